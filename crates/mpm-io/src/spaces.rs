//! The space of the bodies, as files tell it: nothing is said of Cartesian coordinates.

use hdf5::types::VarLenUnicode;
use hdf5::{File, Group};
use mpm_solver::observe::Space;

use crate::error::ResultsError;
use crate::source::Source;

const ATTRIBUTE: &str = "space";

/// Writes the attribute of a results file.
pub(crate) fn write(file: &Group, space: Space) -> hdf5::Result<()> {
    if space == Space::Cartesian {
        return Ok(());
    }
    let name: VarLenUnicode = space.name().parse().map_err(|_| "the name of a space is no text")?;
    file.new_attr::<VarLenUnicode>().create(ATTRIBUTE)?.write_scalar(&name)
}

/// Reads the attribute of a results file.
///
/// # Errors
/// It names no space.
pub(crate) fn read(file: &File, source: &Source<'_>) -> Result<Space, ResultsError> {
    if file.attr(ATTRIBUTE).is_err() {
        return Ok(Space::Cartesian);
    }
    named(&source.text(file, ATTRIBUTE)?).map_err(|reason| source.malformed(ATTRIBUTE, reason))
}

/// The space of a name.
///
/// # Errors
/// What the name is, and what was expected.
pub(crate) fn named(name: &str) -> Result<Space, String> {
    let known = [Space::Cartesian, Space::Axisymmetric];
    let found = known.into_iter().find(|it| it.name() == name);
    found.ok_or_else(|| format!("is {name:?}, expected {}", known.map(Space::name).join(" or ")))
}
