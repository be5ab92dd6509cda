//! The unknowns of a load step: their numbers, which of them are prescribed, and which couple with which.

mod constraints;
mod couplings;
mod incidence;
mod numbering;
mod pattern;

pub use constraints::Constraints;
pub use couplings::{CoupledPlaces, Couplings};
pub(crate) use numbering::node_equation;
pub use numbering::{Block, Place, UnknownId, UnknownVector, Unknowns};
pub use pattern::SparsityPattern;
