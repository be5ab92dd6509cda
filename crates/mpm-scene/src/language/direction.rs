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
    /// The third direction; three dimensions only.
    Z,
}

impl Direction {
    pub(super) fn z() -> Self {
        Direction::Z
    }

    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        match self {
            Direction::X => 0,
            Direction::Y => 1,
            Direction::Z => 2,
        }
    }
}
