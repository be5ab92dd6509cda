//! Paths of one material point.

use super::material::MaterialInput;
use super::number::{Count, Finite};
use super::read::{ReadError, read};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A material point under a law, and the path that it is driven along: what `mpm drive` reads. Stresses are Cauchy's,
/// tension is positive; strains are logarithmic and counted from the start of a segment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename = "Drive", deny_unknown_fields)]
pub struct DriveInput {
    /// Free text.
    #[serde(default)]
    pub title: String,
    /// The law; its parameters are numbers.
    pub law: MaterialInput,
    /// Principal stresses σ_11, σ_22, σ_33 at the start `[F/L²]`.
    #[serde(default)]
    pub stress: (Finite, Finite, Finite),
    /// Segments, one after the other.
    pub path: Vec<SegmentInput>,
}

/// A part of a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum SegmentInput {
    /// All three axes are strained alike.
    Isotropic {
        /// Logarithmic strain of each axis `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Axis 1 is strained, the others keep their length.
    Oedometer {
        /// Logarithmic strain of axis 1 `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Axis 1 is strained, σ_22 and σ_33 are kept.
    Triaxial {
        /// Logarithmic strain of axis 1 `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Axis 1 is strained, axes 2 and 3 by minus the half of it: the volume is kept.
    UndrainedTriaxial {
        /// Logarithmic strain of axis 1 `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Axis 1 is strained, axis 2 by minus as much: plane strain that keeps the volume.
    PlaneStrain {
        /// Logarithmic strain of axis 1 `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Simple shear of the plane 1-2, which keeps the volume.
    SimpleShear {
        /// Tangent of the angle of shear, F_12 `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Shear of the plane 1-2 at constant σ_22; axes 1 and 3 keep their length.
    DirectShear {
        /// Sum of the shears of all steps, each on the height that it finds `[-]`.
        by: Finite,
        /// Number of steps.
        steps: Count,
    },
    /// Each component by strain or by stress.
    Mixed {
        /// Axis 1.
        axis_1: PointControlInput,
        /// Axis 2.
        axis_2: PointControlInput,
        /// Axis 3.
        axis_3: PointControlInput,
        /// Shear of the plane 1-2.
        #[serde(default = "PointControlInput::kept")]
        shear: PointControlInput,
        /// Number of steps.
        steps: Count,
    },
}

/// What a component does in a segment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum PointControlInput {
    /// It is strained by so much, in equal parts `[-]`.
    Strain(Finite),
    /// Its stress goes in equal parts to this value `[F/L²]`.
    Stress(Finite),
}

impl PointControlInput {
    fn kept() -> Self {
        Self::Strain(Finite(0.0))
    }
}

impl DriveInput {
    /// Reads a law and a path.
    ///
    /// # Errors
    /// What is wrong, and where in the text.
    pub fn from_ron(text: &str) -> Result<Self, ReadError> {
        read(text)
    }
}

impl SegmentInput {
    /// Number of steps.
    pub fn steps(&self) -> u32 {
        match *self {
            Self::Isotropic { steps, .. }
            | Self::Oedometer { steps, .. }
            | Self::Triaxial { steps, .. }
            | Self::UndrainedTriaxial { steps, .. }
            | Self::PlaneStrain { steps, .. }
            | Self::SimpleShear { steps, .. }
            | Self::DirectShear { steps, .. }
            | Self::Mixed { steps, .. } => steps.0,
        }
    }
}
