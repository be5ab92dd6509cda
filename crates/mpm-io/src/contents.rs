//! Everything that a results file holds, as it is stored.

use hdf5::types::{FixedAscii, FixedUnicode, FloatSize, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5::{Container, Group, H5Type, Location};

use crate::calls::Call;
use crate::error::{ResultsError, reason};
use crate::reader::Results;
use crate::source::Source;

/// Longest text of fixed length that is read [bytes].
const LONGEST_TEXT: usize = 64;

/// One dataset or attribute of a results file.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Its path: `history/residual` for a dataset, `history@rows` for an attribute of a group.
    pub name: String,
    /// Numbers along each of its axes; empty for a single one.
    pub shape: Vec<usize>,
    /// All its values, the last axis fastest.
    pub values: Values,
}

/// Values of one stored type.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Double precision.
    Real(Vec<f64>),
    /// Single precision.
    Single(Vec<f32>),
    /// Unsigned integers of 64 bits.
    Count(Vec<u64>),
    /// Signed integers of 64 bits.
    Index(Vec<i64>),
    /// Unsigned integers of 8 bits.
    Byte(Vec<u8>),
    /// Text.
    Text(Vec<String>),
}

impl Values {
    /// Name of the stored type.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Real(_) => "f64",
            Self::Single(_) => "f32",
            Self::Count(_) => "u64",
            Self::Index(_) => "i64",
            Self::Byte(_) => "u8",
            Self::Text(_) => "text",
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Single(values) => values.len(),
            Self::Count(values) => values.len(),
            Self::Index(values) => values.len(),
            Self::Byte(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value at `index`, with as many digits as tell it from its neighbours.
    ///
    /// # Panics
    /// If there is no such value.
    pub fn show(&self, index: usize) -> String {
        match self {
            Self::Real(values) => format!("{:e}", values[index]),
            Self::Single(values) => format!("{:e}", values[index]),
            Self::Count(values) => values[index].to_string(),
            Self::Index(values) => values[index].to_string(),
            Self::Byte(values) => values[index].to_string(),
            Self::Text(values) => format!("{:?}", values[index]),
        }
    }

    /// Indices at which the bits of two lists of one type and length differ: two zeros of different sign do, two NaN
    /// of equal bits do not.
    pub fn differences(&self, other: &Self) -> Vec<usize> {
        fn unequal<T>(a: &[T], b: &[T], equal: impl Fn(&T, &T) -> bool) -> Vec<usize> {
            (0..a.len().min(b.len())).filter(|&k| !equal(&a[k], &b[k])).collect()
        }
        match (self, other) {
            (Self::Real(a), Self::Real(b)) => unequal(a, b, |x, y| x.to_bits() == y.to_bits()),
            (Self::Single(a), Self::Single(b)) => unequal(a, b, |x, y| x.to_bits() == y.to_bits()),
            (Self::Count(a), Self::Count(b)) => unequal(a, b, u64::eq),
            (Self::Index(a), Self::Index(b)) => unequal(a, b, i64::eq),
            (Self::Byte(a), Self::Byte(b)) => unequal(a, b, u8::eq),
            (Self::Text(a), Self::Text(b)) => unequal(a, b, String::eq),
            _ => (0..self.len().min(other.len())).collect(),
        }
    }
}

impl Results {
    /// All datasets and attributes, sorted by name. Rows beyond the counts of a killed run are among them.
    ///
    /// # Errors
    /// [`ResultsError::Malformed`] if a part cannot be read or is of a type that results files do not have.
    pub fn contents(&self) -> Result<Vec<Item>, ResultsError> {
        let _call = Call::begin();
        let mut items = Vec::new();
        collect(&Source { path: self.path() }, self.file(), "", &mut items)?;
        items.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(items)
    }
}

/// Reads what lies below a group.
fn collect(source: &Source<'_>, group: &Group, path: &str, items: &mut Vec<Item>) -> Result<(), ResultsError> {
    const DEEPEST: usize = 8; // links of a hostile file can form a ring
    let fail = |error: hdf5::Error| source.malformed(path, reason(&error));
    if path.matches('/').count() > DEEPEST {
        return Err(source.malformed(path, "is nested too deeply"));
    }
    attributes(source, group, path, items)?;
    for member in group.member_names().map_err(fail)? {
        let name = if path.is_empty() { member.clone() } else { format!("{path}/{member}") };
        if let Ok(below) = group.group(&member) {
            collect(source, &below, &name, items)?;
            continue;
        }
        let dataset = group.dataset(&member).map_err(|error| source.malformed(&name, reason(&error)))?;
        source.shape(&dataset, &name)?;
        attributes(source, &dataset, &name, items)?;
        let values = read(source, &dataset, &name)?;
        items.push(Item { name, shape: dataset.shape(), values });
    }
    Ok(())
}

fn attributes(
    source: &Source<'_>,
    location: &Location,
    path: &str,
    items: &mut Vec<Item>,
) -> Result<(), ResultsError> {
    for attribute in location.attr_names().map_err(|error| source.malformed(path, reason(&error)))? {
        let name = format!("{path}@{attribute}");
        let attribute = location.attr(&attribute).map_err(|error| source.malformed(&name, reason(&error)))?;
        let values = read(source, &attribute, &name)?;
        items.push(Item { name, shape: attribute.shape(), values });
    }
    Ok(())
}

fn read(source: &Source<'_>, container: &Container, name: &str) -> Result<Values, ResultsError> {
    fn all<T: H5Type>(container: &Container) -> hdf5::Result<Vec<T>> {
        container.read_raw::<T>()
    }
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let kind = container.dtype().and_then(|kind| kind.to_descriptor());
    let values = match kind.map_err(|error| source.malformed(name, reason(&error)))? {
        TypeDescriptor::Float(FloatSize::U8) => all(container).map(Values::Real),
        TypeDescriptor::Float(FloatSize::U4) => all(container).map(Values::Single),
        TypeDescriptor::Unsigned(IntSize::U8) => all(container).map(Values::Count),
        TypeDescriptor::Integer(IntSize::U8) => all(container).map(Values::Index),
        TypeDescriptor::Unsigned(IntSize::U1) => all(container).map(Values::Byte),
        TypeDescriptor::VarLenUnicode => all::<VarLenUnicode>(container)
            .map(|texts| Values::Text(texts.iter().map(|it| text(it.as_bytes())).collect())),
        TypeDescriptor::FixedUnicode(length) if length <= LONGEST_TEXT => {
            all::<FixedUnicode<LONGEST_TEXT>>(container)
                .map(|texts| Values::Text(texts.iter().map(|it| text(it.as_bytes())).collect()))
        }
        TypeDescriptor::FixedAscii(length) if length <= LONGEST_TEXT => {
            all::<FixedAscii<LONGEST_TEXT>>(container)
                .map(|texts| Values::Text(texts.iter().map(|it| text(it.as_bytes())).collect()))
        }
        other => return Err(source.malformed(name, format!("holds {other}, which no results file has"))),
    };
    values.map_err(|error| source.malformed(name, reason(&error)))
}
