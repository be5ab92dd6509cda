//! Stiffnesses and strengths: a number, or a field that gives every point its own.

use super::number::{Finite, Positive};
use super::read;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A number, or a field over the points at rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Quantity<N> {
    /// The same everywhere.
    Number(N),
    /// Every point its own.
    Field(PointField),
}

/// A field over the points at rest: a point takes its value where it rests, and carries it along. Heights are y in the plane
/// and z in space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum PointField {
    /// `value + gradient (at - height)`: linear in the depth below a height.
    Linear {
        /// The height where the field is `value` `[L]`.
        at: Finite,
        /// Value at this height.
        value: Finite,
        /// Growth of the value per length downwards.
        gradient: Finite,
    },
    /// Layers from the top down; the last goes on downwards. Points above the first are refused.
    Layers(Vec<LayerInput>),
    /// A table of numbers with a line of names, from CSV or HDF5 (`.h5`, `.hdf5`: a dataset per column). With columns of all
    /// coordinates a point takes the value of the nearest row; with the height alone (`y` in the plane, `z` in space) it
    /// is interpolated between rows, and points beyond the first or last are refused.
    Table {
        /// The file, as seen from the scene's folder.
        file: String,
        /// Name of the column that holds the values.
        column: String,
    },
    /// A lognormal random field with the correlation exp(-r²/l²) of its logarithm, the same for the same seed.
    Random {
        /// Mean of the values.
        mean: Positive,
        /// Coefficient of variation: standard deviation over mean `[-]`.
        variation: Positive,
        /// l: points so far apart hardly resemble each other `[L]`.
        correlation_length: Positive,
        /// l in the direction of heights; the same if left out `[L]`.
        #[serde(default)]
        vertical_correlation_length: Option<Positive>,
        /// Chooses the field among all of its kind.
        seed: u64,
    },
}

/// A layer of a field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerInput {
    /// Height of its top `[L]`.
    pub top: Finite,
    /// Value at its top.
    pub value: Finite,
    /// Growth of the value per length downwards.
    #[serde(default)]
    pub gradient: Finite,
}

impl<N> From<N> for Quantity<N> {
    fn from(number: N) -> Self {
        Self::Number(number)
    }
}

impl<N: Copy + Into<f64>> Quantity<N> {
    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some((*number).into()),
            Self::Field(_) => None,
        }
    }
}

impl<'de, N: TryFrom<f64, Error = String>> Deserialize<'de> for Quantity<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// A name in front of parentheses becomes a map of one entry.
        #[derive(Deserialize)]
        #[serde(
            untagged,
            expecting = "expected a number or one of `Linear(…)`, `Layers(…)`, `Table(…)` and `Random(…)`"
        )]
        enum Either {
            Number(f64),
            Named(BTreeMap<String, ron::Value>),
        }
        match Either::deserialize(deserializer)? {
            Either::Number(number) => N::try_from(number).map(Self::Number).map_err(D::Error::custom),
            Either::Named(entry) => field(entry).map(Self::Field).map_err(D::Error::custom),
        }
    }
}

/// The field of a name and what stands in its parentheses.
fn field(entry: BTreeMap<String, ron::Value>) -> Result<PointField, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Linear {
        at: Finite,
        value: Finite,
        gradient: Finite,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Table {
        file: String,
        column: String,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Random {
        mean: Positive,
        variation: Positive,
        correlation_length: Positive,
        #[serde(default, deserialize_with = "given")]
        vertical_correlation_length: Option<Positive>,
        seed: u64,
    }
    let Some((name, value)) = entry.into_iter().next() else {
        return Err("expected a field, got nothing".into());
    };
    let told = |error: ron::Error| format!("in `{name}(…)`: {}", read::in_words(&error));
    match name.as_str() {
        "Linear" => {
            let Linear { at, value, gradient } = value.into_rust().map_err(told)?;
            Ok(PointField::Linear { at, value, gradient })
        }
        "Layers" => value.into_rust().map(PointField::Layers).map_err(told),
        "Table" => {
            let Table { file, column } = value.into_rust().map_err(told)?;
            Ok(PointField::Table { file, column })
        }
        "Random" => {
            let Random { mean, variation, correlation_length, vertical_correlation_length, seed } =
                value.into_rust().map_err(told)?;
            Ok(PointField::Random { mean, variation, correlation_length, vertical_correlation_length, seed })
        }
        other => Err(format!(
            "unknown field of points `{other}`; expected a number, `Linear`, `Layers`, `Table` or `Random`"
        )),
    }
}

/// A number that could have been left out: a part that is read by itself knows no `Some`.
fn given<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Positive>, D::Error> {
    Positive::deserialize(deserializer).map(Some)
}

impl<N: JsonSchema> JsonSchema for Quantity<N> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("QuantityOf{}", N::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (number, field) = (generator.subschema_for::<N>(), generator.subschema_for::<PointField>());
        json_schema!({ "anyOf": [number, field] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize, PartialEq)]
    struct Law {
        young: Quantity<Positive>,
        #[serde(default)]
        strength: Option<Quantity<Finite>>,
    }

    fn law(text: &str) -> Result<Law, String> {
        let options =
            ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        options.from_str(text).map_err(|error| error.code.to_string())
    }

    #[test]
    fn numbers_and_fields_are_read() {
        let found = law("(young: 20, strength: Linear(at: 1e1, value: 5.5, gradient: -1))").unwrap();
        assert_eq!(found.young, Quantity::Number(Positive(20.0)));
        let linear = PointField::Linear { at: Finite(10.0), value: Finite(5.5), gradient: Finite(-1.0) };
        assert_eq!(found.strength, Some(Quantity::Field(linear)));
        let found = law("(young: Layers([(top: 3, value: 1), (top: 1, value: 2, gradient: 0.5)]))").unwrap();
        let layer = |top, value, gradient| LayerInput {
            top: Finite(top),
            value: Finite(value),
            gradient: Finite(gradient),
        };
        let layers = PointField::Layers(vec![layer(3.0, 1.0, 0.0), layer(1.0, 2.0, 0.5)]);
        assert_eq!((found.young, found.strength), (Quantity::Field(layers), None));
        let found = law("(young: Table(file: \"a.csv\", column: \"E\"))").unwrap();
        let table = PointField::Table { file: "a.csv".into(), column: "E".into() };
        assert_eq!(found.young, Quantity::Field(table));
        let found = law("(young: Random(mean: 2, variation: 0.3, correlation_length: 4, seed: 7))").unwrap();
        let random = PointField::Random {
            mean: Positive(2.0),
            variation: Positive(0.3),
            correlation_length: Positive(4.0),
            vertical_correlation_length: None,
            seed: 7,
        };
        assert_eq!(found.young, Quantity::Field(random));
    }

    #[test]
    fn what_is_neither_is_told() {
        assert_eq!(law("(young: -1)").unwrap_err(), "expected a finite number above 0, got -1");
        let said = law("(young: Linear(at: 1, value: 2))").unwrap_err();
        assert_eq!(said, "in `Linear(…)`: missing field `gradient`");
        let said = law("(young: Linear(at: 1, value: 2, gradient: 3, depth: 4))").unwrap_err();
        assert_eq!(said, "in `Linear(…)`: unknown field `depth`; expected `at`, `value` or `gradient`");
        let said = law("(young: Square(at: 1))").unwrap_err();
        assert!(said.starts_with("unknown field of points `Square`; expected a number, `Linear`"), "{said}");
        for text in ["(young: \"1e3\")", "(young: true)", "(young: [1])"] {
            assert!(law(text).unwrap_err().starts_with("expected a number or one of"), "{text}");
        }
    }
}
