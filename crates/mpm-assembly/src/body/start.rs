//! How points begin.

use mpm_material::{Consolidation, NoReturn, OwnParameters, SymmetricTensor};

/// How a point begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointStart {
    /// Parameters of its own, for laws that are [`PerPoint`](mpm_material::PerPoint).
    pub own: Option<OwnParameters>,
    /// Its stress, Cauchy's and Kirchhoff's in one `[F/L²]`; in the plane with its component along z.
    pub stress: Option<SymmetricTensor>,
    /// How far it was compressed in the past.
    pub consolidation: Consolidation,
}

/// A point that cannot begin under its stress.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("material point {point} cannot begin under its stress: {reason}")]
pub struct RefusedStart {
    /// Index of the point in its body.
    pub point: usize,
    /// What the law says.
    pub reason: NoReturn,
}
