//! Numbers that are checked as they are read, so that a wrong one is reported where it stands.

use mpm_solver::Stage;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// A finite number.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Finite(pub f64);

/// A finite number above zero.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Positive(pub f64);

/// A load fraction, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Fraction(pub f64);

/// A Poisson's ratio, above -1 and below ½.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Poisson(pub f64);

/// A whole number from 1 to 4,294,967,295.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "i64", into = "i64")]
pub struct Count(pub u32);

/// A position or vector, one number per dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates<const D: usize>(pub [f64; D]);

/// A point (x, y) of the plane `[L]`; the origin if left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct PlanePoint(pub (Finite, Finite));

pub(super) fn zero() -> Finite {
    Finite(0.0)
}

pub(super) fn one() -> Positive {
    Positive(1.0)
}

impl<const D: usize> Default for Coordinates<D> {
    fn default() -> Self {
        Self([0.0; D])
    }
}

impl Count {
    /// One.
    pub fn one() -> Self {
        Self(1)
    }
}

impl TryFrom<f64> for Finite {
    type Error = String;
    fn try_from(x: f64) -> Result<Self, String> {
        if x.is_finite() { Ok(Self(x)) } else { Err(format!("expected a finite number, got {x}")) }
    }
}

impl TryFrom<f64> for Positive {
    type Error = String;
    fn try_from(x: f64) -> Result<Self, String> {
        if x.is_finite() && x > 0.0 {
            Ok(Self(x))
        } else {
            Err(format!("expected a finite number above 0, got {x}"))
        }
    }
}

impl TryFrom<f64> for Fraction {
    type Error = String;
    fn try_from(x: f64) -> Result<Self, String> {
        if (0.0..=1.0).contains(&x) {
            Ok(Self(x))
        } else {
            Err(format!("expected a load fraction from 0 to 1, got {x}"))
        }
    }
}

impl TryFrom<f64> for Poisson {
    type Error = String;
    fn try_from(x: f64) -> Result<Self, String> {
        if x > -1.0 && x < 0.5 {
            Ok(Self(x))
        } else {
            Err(format!("expected a Poisson's ratio above -1 and below 0.5, got {x}"))
        }
    }
}

impl TryFrom<i64> for Count {
    type Error = String;
    fn try_from(n: i64) -> Result<Self, String> {
        match u32::try_from(n) {
            Ok(n) if n > 0 => Ok(Self(n)),
            _ => Err(format!("expected a whole number from 1 to {}, got {n}", u32::MAX)),
        }
    }
}

impl From<Finite> for f64 {
    fn from(x: Finite) -> f64 {
        x.0
    }
}

impl From<Positive> for f64 {
    fn from(x: Positive) -> f64 {
        x.0
    }
}

impl From<Fraction> for f64 {
    fn from(x: Fraction) -> f64 {
        x.0
    }
}

impl From<Poisson> for f64 {
    fn from(x: Poisson) -> f64 {
        x.0
    }
}

impl From<Count> for i64 {
    fn from(n: Count) -> i64 {
        n.0.into()
    }
}

impl<const D: usize> Serialize for Coordinates<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = serializer.serialize_tuple(D)?;
        for x in &self.0 {
            tuple.serialize_element(x)?;
        }
        tuple.end()
    }
}

impl<'de, const D: usize> Deserialize<'de> for Coordinates<D> {
    fn deserialize<De: Deserializer<'de>>(deserializer: De) -> Result<Self, De::Error> {
        struct Numbers<const D: usize>;
        impl<'de, const D: usize> Visitor<'de> for Numbers<D> {
            type Value = Coordinates<D>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{D} numbers in parentheses, one per dimension")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Self::Value, A::Error> {
                let mut coordinates = [0.0; D];
                for (i, x) in coordinates.iter_mut().enumerate() {
                    let Finite(next) =
                        numbers.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
                    *x = next;
                }
                if numbers.next_element::<IgnoredAny>()?.is_some() {
                    return Err(A::Error::invalid_length(D + 1, &self));
                }
                Ok(Coordinates(coordinates))
            }
        }
        deserializer.deserialize_tuple(D, Numbers)
    }
}

/// Reads how often a step may be halved.
pub(super) fn halvings<'de, De: Deserializer<'de>>(deserializer: De) -> Result<u8, De::Error> {
    let n = i64::deserialize(deserializer)?;
    let fits = u8::try_from(n).ok().filter(|&n| n <= Stage::MOST_CUTS);
    fits.ok_or_else(|| {
        De::Error::custom(format!("expected a whole number from 0 to {}, got {n}", Stage::MOST_CUTS))
    })
}

/// As [`halvings`], of a stage that says so.
pub(super) fn own_halvings<'de, De: Deserializer<'de>>(deserializer: De) -> Result<Option<u8>, De::Error> {
    halvings(deserializer).map(Some)
}

/// Reads a choice that has a default where it is left out: `None`, which would say so, reads like the name of a choice.
pub(super) fn chosen<'de, T: Deserialize<'de>, De: Deserializer<'de>>(
    deserializer: De,
) -> Result<Option<T>, De::Error> {
    T::deserialize(deserializer).map(Some)
}

/// Reads a map in which no key may stand twice (the last would win).
pub(super) fn unique_keys<'de, V, De>(deserializer: De) -> Result<BTreeMap<String, V>, De::Error>
where
    V: Deserialize<'de>,
    De: Deserializer<'de>,
{
    struct Entries<V>(PhantomData<V>);
    impl<'de, V: Deserialize<'de>> Visitor<'de> for Entries<V> {
        type Value = BTreeMap<String, V>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("named entries in braces")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut entries = BTreeMap::new();
            while let Some(key) = map.next_key::<String>()? {
                if entries.contains_key(&key) {
                    return Err(A::Error::custom(format!("the name `{key}` is given twice")));
                }
                entries.insert(key, map.next_value()?);
            }
            Ok(entries)
        }
    }
    deserializer.deserialize_map(Entries(PhantomData))
}

impl<const D: usize> JsonSchema for Coordinates<D> {
    fn schema_name() -> Cow<'static, str> {
        format!("Coordinates{D}").into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A position or vector: one finite number per dimension.",
            "type": "array", "items": { "type": "number" }, "minItems": D, "maxItems": D
        })
    }
}

impl JsonSchema for Finite {
    fn schema_name() -> Cow<'static, str> {
        "Finite".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "A finite number.", "type": "number" })
    }
}

impl JsonSchema for Positive {
    fn schema_name() -> Cow<'static, str> {
        "Positive".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "A finite number above 0.", "type": "number", "exclusiveMinimum": 0 })
    }
}

impl JsonSchema for Fraction {
    fn schema_name() -> Cow<'static, str> {
        "Fraction".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "A load fraction, 0 to 1.", "type": "number", "minimum": 0, "maximum": 1 })
    }
}

impl JsonSchema for Poisson {
    fn schema_name() -> Cow<'static, str> {
        "Poisson".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "A Poisson's ratio, above -1 and below 0.5.",
            "type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 0.5 })
    }
}

impl JsonSchema for Count {
    fn schema_name() -> Cow<'static, str> {
        "Count".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "A whole number, at least 1.", "type": "integer", "minimum": 1, "maximum": u32::MAX })
    }
}
