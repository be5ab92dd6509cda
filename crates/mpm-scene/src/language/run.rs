//! How load steps are solved, and what is recorded.

use super::number::{Count, Positive};
use mpm_solver::Tolerance;
use mpm_solver::observe::Field;
use schemars::JsonSchema;
use serde::de::{EnumAccess, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// How linear systems are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SolverInput {
    /// By the solver that is predicted to be quicker: up to some ten thousand equations the direct one, beyond
    /// the iterative one, which leaves to the other what takes it more iterations than a factorisation is worth. Where
    /// tangents are not symmetric, up to some thirty thousand in space; in the plane, while its factor stays below 8 GB.
    /// `mpm check` tells both costs.
    #[default]
    Auto,
    /// By sparse factorisation.
    Direct,
    /// By conjugate gradients with geometric multigrid, or by GMRES with it where tangents are not symmetric, as
    /// accurately as each Newton iteration needs it; what they cannot solve is factorised.
    Iterative,
}

/// What is done about a rigid motion (of a body, of a part of it, or of bodies together) that neither supports nor any
/// stiffness hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum UnheldMotionInput {
    /// The run ends with a message that names what moves, and how.
    #[default]
    Refuse,
    /// It is kept at zero, as for a block on rollers that is pressed from above: the volume mean of the material does
    /// not move along it. Loads with a part in the motion are refused.
    Zero,
}

/// When a load step counts as solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ToleranceInput {
    /// Out-of-balance force over external plus reaction force, in all and body by body; below 1 `[-]`.
    pub residual: Positive,
    /// Newton iterations per load step before it is cut.
    pub iterations: Count,
    /// A factorised tangent is kept for further iterations while each of them leaves at most this part of the
    /// out-of-balance force, below 1; if left out every iteration has its own. Iterations become more and cheaper:
    /// worth it where factorising takes most of the time and the response is nearly linear `[-]`.
    pub keep_factor_below: Option<Positive>,
}

impl Default for ToleranceInput {
    fn default() -> Self {
        let Tolerance { residual, iterations, keep_factor_below } = Tolerance::default();
        Self {
            residual: Positive(residual),
            iterations: Count(iterations),
            keep_factor_below: keep_factor_below.map(Positive),
        }
    }
}

/// A quantity of the material points that is recorded: one of these, or what a law remembers, by its name: `PlasticStrain`
/// of `VonMises`. Points whose law does not have it get 0. In scenes with tools also `ContactForce` of all tools on the
/// point `[F]`, `ContactGap`, the least signed distance of a corner of its domain to a tool `[L]`, and `ContactSlip`, how far
/// it has slipped along tools so far `[L]`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename = "Field")]
pub enum FieldInput {
    /// Displacement since the start, or since the last stage that resets it, three components `[L]`.
    Displacement,
    /// Deformation gradient F, nine components row by row `[-]`.
    DeformationGradient,
    /// Cauchy stress σ = τ/J, nine components row by row `[F/L²]`.
    CauchyStress,
    /// Elastic logarithmic (Hencky) strain ε_e = ½ ln b_e, nine components row by row `[-]`.
    ElasticStrain,
    /// Current volume J V⁰ (plane strain: per unit thickness) `[L^D]`.
    Volume,
    /// Deviatoric norm ρ = √(2 J₂) of the Kirchhoff stress `[F/L²]`.
    Rho,
    /// 1 where the last load step was plastic, else 0.
    Plastic,
    /// `J = det F` `[-]`.
    VolumeRatio,
    /// Signed volume of the point's domain over that at rest; 1 for points without one `[-]`.
    DomainMeasure,
    /// Smallest weight of a corner of the domain; 1 for points without one `[-]`.
    SmallestCornerWeight,
    /// Number of nodes that receive the point through a single corner of its domain.
    SingleCornerNodes,
    /// Number of the domain's corners outside the mesh; all of them where one lies too far outside.
    CornersOutside,
    /// 1 where a fallback has replaced the domain, else 0.
    FallenBack,
    /// Number of the body (in the order of the scene) that the point belongs to.
    Body,
    /// Corners of the point's domain round its outline, four of (x, y), the last repeated where there are three;
    /// the position, four times, for points without one. Plane strain only `[L]`.
    Outline,
    /// Angle by which the point has turned about the axis of its body of revolution; 0 without `twist` `[rad]`.
    Angle,
    /// What a law remembers, by its name.
    #[schemars(skip)]
    Remembered(String),
}

impl FieldInput {
    fn named(name: String) -> Self {
        match name.as_str() {
            "Displacement" => Self::Displacement,
            "DeformationGradient" => Self::DeformationGradient,
            "CauchyStress" => Self::CauchyStress,
            "ElasticStrain" => Self::ElasticStrain,
            "Volume" => Self::Volume,
            "Rho" => Self::Rho,
            "Plastic" => Self::Plastic,
            "VolumeRatio" => Self::VolumeRatio,
            "DomainMeasure" => Self::DomainMeasure,
            "SmallestCornerWeight" => Self::SmallestCornerWeight,
            "SingleCornerNodes" => Self::SingleCornerNodes,
            "CornersOutside" => Self::CornersOutside,
            "FallenBack" => Self::FallenBack,
            "Body" => Self::Body,
            "Outline" => Self::Outline,
            "Angle" => Self::Angle,
            _ => Self::Remembered(name),
        }
    }

    /// The solver's field; none where it is one that a law remembers.
    pub(crate) fn of_points(&self) -> Option<Field> {
        match self {
            Self::Displacement => Some(Field::DISPLACEMENT),
            Self::DeformationGradient => Some(Field::DEFORMATION_GRADIENT),
            Self::CauchyStress => Some(Field::CAUCHY_STRESS),
            Self::ElasticStrain => Some(Field::ELASTIC_STRAIN),
            Self::Volume => Some(Field::VOLUME),
            Self::Rho => Some(Field::RHO),
            Self::Plastic => Some(Field::PLASTIC),
            Self::VolumeRatio => Some(Field::VOLUME_RATIO),
            Self::DomainMeasure => Some(Field::DOMAIN_MEASURE),
            Self::SmallestCornerWeight => Some(Field::SMALLEST_CORNER_WEIGHT),
            Self::SingleCornerNodes => Some(Field::SINGLE_CORNER_NODES),
            Self::CornersOutside => Some(Field::CORNERS_OUTSIDE),
            Self::FallenBack => Some(Field::FALLEN_BACK),
            Self::Body => Some(Field::BODY),
            Self::Outline => Some(Field::OUTLINE),
            Self::Angle => Some(Field::ANGLE),
            Self::Remembered(_) => None,
        }
    }
}

impl<'de> Deserialize<'de> for FieldInput {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        deserializer.deserialize_enum("Field", &[], NameOfField)
    }
}

/// Reads any name where serde expects the variant of an enum.
struct NameOfField;

impl<'de> Visitor<'de> for NameOfField {
    type Value = FieldInput;

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("a name")
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<FieldInput, A::Error> {
        let (Identifier(name), variant) = data.variant()?;
        variant.unit_variant()?;
        Ok(FieldInput::named(name))
    }
}

/// A word without quotes.
struct Identifier(String);

impl<'de> Deserialize<'de> for Identifier {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        struct Word;
        impl Visitor<'_> for Word {
            type Value = Identifier;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("a name")
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Identifier, E> {
                Ok(Identifier(word.to_owned()))
            }
        }
        deserializer.deserialize_identifier(Word)
    }
}

/// What the results file holds besides the history.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputInput {
    /// Fields of the material points.
    pub fields: Vec<FieldInput>,
    /// Points are recorded every so many load steps, and always at the start and the end. Of halved steps, and of those
    /// that end at knots of ramps, only the ends of the equal steps count, through all stages.
    pub every: Count,
    /// Numbers of the fields: `Double` (default), or `Single`, seven digits at half the room. Positions are always double.
    pub precision: PrecisionInput,
    /// Components of the fields: `All` (default), as VTK has them, or `InPlane`, of plane strain only: x and y of the
    /// displacement; xx, xy, yy, zz of stress and elastic strain; these and yx of the deformation gradient.
    pub components: ComponentsInput,
    /// Whether the health of the points' domains is worked out after every load step, as columns
    /// `/history/domain_…`.
    pub domain_history: bool,
    /// Whether energies are recorded `[F L]`: `/history/energy/elastic`, `…/dissipated` by yielding,
    /// `…/external_work` of loads and supports, and `…/unbalanced`, what is left of the work. That vanishes with the
    /// square of the load step, but for forces that a reset mesh lets go of, and for `stabilisation`, whose penalty
    /// is in none of them. Costs a pass over the points per load step.
    pub energies: bool,
    /// Whether the condition number of every load step's last tangent is estimated (`/history/condition`), by ten
    /// linear solutions more: 10 to 30 % more time in the plane, up to 80 % in space with the direct solver. Without it
    /// the summary has a lower bound, from the pivots, which is free.
    pub condition: bool,
    /// Checkpoints, from which an interrupted run goes on by `mpm resume`; none if left out.
    pub checkpoint: Option<CheckpointInput>,
}

/// How the numbers of the points' fields are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PrecisionInput {
    /// 8 bytes: what was computed.
    #[default]
    Double,
    /// 4 bytes: enough to look at.
    Single,
}

/// Which components of the points' fields are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ComponentsInput {
    /// Three of vectors, nine of tensors.
    #[default]
    All,
    /// Those that plane strain leaves.
    InPlane,
}

/// When the state of the run is kept in a file beside the results; at least one of the two is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointInput {
    /// After every so many load steps; in a schedule of stages also at the end of each.
    #[serde(default)]
    pub every: Option<Count>,
    /// After the first load step that ends so long after the last checkpoint `[s]`.
    #[serde(default)]
    pub seconds: Option<Positive>,
}

impl Default for OutputInput {
    fn default() -> Self {
        Self {
            fields: vec![FieldInput::CauchyStress, FieldInput::Displacement],
            every: Count(1),
            precision: PrecisionInput::Double,
            components: ComponentsInput::All,
            domain_history: false,
            energies: false,
            condition: false,
            checkpoint: None,
        }
    }
}
