//! Ramps: how what is prescribed follows the load fraction.

use super::number::{Finite, Fraction};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// Knots (load fraction, factor).
pub type Knots = Vec<(Fraction, Finite)>;

/// A piecewise linear function of the load fraction. Left out, it rises linearly from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum RampInput {
    /// Knots over the stage with which it begins, held constant before the first and after the last.
    Knots(Knots),
    /// Knots over stages by their names. In each the ramp goes on from where the stage before has left it, unless the stage has
    /// a knot at fraction 0.
    Stages(BTreeMap<String, Knots>),
}

impl Default for RampInput {
    fn default() -> Self {
        Self::Knots(vec![(Fraction(0.0), Finite(0.0)), (Fraction(1.0), Finite(1.0))])
    }
}

impl Serialize for RampInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Knots(knots) => knots.serialize(serializer),
            Self::Stages(stages) => stages.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for RampInput {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        deserializer.deserialize_any(Ramp)
    }
}

/// Reads either form.
struct Ramp;

impl<'de> Visitor<'de> for Ramp {
    type Value = RampInput;

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("a list of knots (load fraction, factor), or such lists by the names of stages")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<RampInput, A::Error> {
        let mut knots = Vec::new();
        while let Some(knot) = list.next_element()? {
            knots.push(knot);
        }
        Ok(RampInput::Knots(knots))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RampInput, A::Error> {
        let mut stages = BTreeMap::new();
        while let Some(stage) = map.next_key::<String>()? {
            if stages.contains_key(&stage) {
                return Err(A::Error::custom(format!("the name `{stage}` is given twice")));
            }
            stages.insert(stage, map.next_value()?);
        }
        Ok(RampInput::Stages(stages))
    }
}

impl JsonSchema for RampInput {
    fn schema_name() -> Cow<'static, str> {
        "RampInput".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let knots = generator.subschema_for::<Knots>();
        json_schema!({
            "description": "A piecewise linear function of the load fraction, as knots (load fraction, factor), held constant \
                before the first and after the last. Left out, it rises linearly from 0 to 1. In a schedule of stages the knots \
                are those of the stage with which it begins, and in later stages it stays what it was; or knots are given by \
                the names of stages, as in `{\"press\": [(1, 1)], \"pull\": [(1, 0.2)]}`: in each it then goes on from where the \
                stage before has left it, unless the stage has a knot at fraction 0.",
            "anyOf": [knots, { "type": "object", "additionalProperties": knots }]
        })
    }
}
