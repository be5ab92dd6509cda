//! Directions of space.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A direction of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
pub enum Direction {
    /// The first direction.
    X,
    /// The second direction.
    Y,
    /// The third direction, in three dimensions; along the axis of revolution in an `Axisymmetric` scene.
    Z,
    /// Away from the axis of revolution; in an `Axisymmetric` scene only.
    R,
    /// About the axis of revolution, from r towards where a right-handed turn about z leads; in an `Axisymmetric` scene with
    /// `twist` only. Displacements are angles in degrees.
    Theta,
}

impl Direction {
    pub(super) fn z() -> Self {
        Direction::Z
    }

    /// 0, 1 or 2 in Cartesian coordinates; R and Theta are none of them, and count as the first and the third.
    pub fn index(self) -> usize {
        match self {
            Direction::X | Direction::R => 0,
            Direction::Y => 1,
            Direction::Z | Direction::Theta => 2,
        }
    }
}
