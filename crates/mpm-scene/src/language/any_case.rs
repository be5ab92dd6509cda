//! Names that are understood however their letters are written, as people write those of bases: `CPDI1`, `sMPM`.

use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error, VariantAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// One of several names.
pub(super) trait AnyCase: Copy + 'static {
    /// Name of the type, for messages.
    const NAME: &'static str;
    /// The names.
    const NAMES: &'static [&'static str];
    /// What they stand for, in their order.
    const VALUES: &'static [Self];
}

/// Reads one of the names.
///
/// # Errors
/// It is none of them.
pub(super) fn read<'de, T: AnyCase, De: Deserializer<'de>>(deserializer: De) -> Result<T, De::Error> {
    deserializer.deserialize_enum(T::NAME, T::NAMES, Variant(PhantomData))
}

struct Variant<T>(PhantomData<T>);

impl<'de, T: AnyCase> Visitor<'de> for Variant<T> {
    type Value = T;

    fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
        write!(to, "enum {}", T::NAME)
    }

    fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<T, A::Error> {
        let (value, variant) = access.variant_seed(Name(PhantomData))?;
        variant.unit_variant()?;
        Ok(value)
    }
}

struct Name<T>(PhantomData<T>);

impl<'de, T: AnyCase> DeserializeSeed<'de> for Name<T> {
    type Value = T;

    fn deserialize<De: Deserializer<'de>>(self, deserializer: De) -> Result<T, De::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<T: AnyCase> Visitor<'_> for Name<T> {
    type Value = T;

    fn expecting(&self, to: &mut fmt::Formatter) -> fmt::Result {
        to.write_str("variant identifier")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
        let found = T::NAMES.iter().position(|known| known.eq_ignore_ascii_case(name));
        found.map(|k| T::VALUES[k]).ok_or_else(|| E::unknown_variant(name, T::NAMES))
    }
}

#[cfg(test)]
mod tests {
    use crate::language::{PlaneBasis, SolidBasis};

    #[test]
    fn names_of_bases_are_read_as_people_write_them() {
        for (name, basis) in
            [("CPDI1", PlaneBasis::Cpdi1), ("sMPM", PlaneBasis::Smpm), ("GIMP", PlaneBasis::Gimp)]
        {
            assert_eq!(ron::from_str::<PlaneBasis>(name).unwrap(), basis);
        }
        let name = "CPDI2Tetrahedron";
        assert_eq!(ron::from_str::<SolidBasis>(name).unwrap(), SolidBasis::Cpdi2Tetrahedron);
        let error = ron::from_str::<PlaneBasis>("Fem").unwrap_err().to_string();
        assert!(error.contains("Fem"), "{error}");
        for basis in [PlaneBasis::Cpdi2q, PlaneBasis::Cpdi2t] {
            assert_eq!(ron::from_str::<PlaneBasis>(&ron::to_string(&basis).unwrap()).unwrap(), basis);
        }
    }

    /// `None` and `Some` are how options are written: as names they would have two meanings.
    #[test]
    fn no_name_of_the_language_is_that_of_an_option() {
        let schema = schemars::schema_for!(crate::Scene).to_value().to_string();
        assert!(schema.contains("\"Stretch\""), "names stand between quotation marks");
        assert!(!schema.contains("\"None\"") && !schema.contains("\"Some\""), "{schema}");
    }
}
