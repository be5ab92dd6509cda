//! How a run proceeds: load steps, control of the path, tolerances, and care for domains.

use mpm_basis::DomainControl;
#[cfg(doc)]
use mpm_grid::LoadFraction;

/// A part of the schedule: load steps over which the load fraction goes from 0 to 1, and how often one may be halved.
///
/// Ramps, the motion of the mesh and the supports say what they do in which stage, see [`LoadFraction`].
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Its name; empty in a schedule that has no others. With names, the history says in which stage a row is.
    pub name: String,
    /// Number of nominal load steps.
    pub steps: u32,
    /// Halvings of a nominal step before the run gives up.
    pub cuts: u8,
    /// Where Newton's iteration begins.
    pub predictor: PredictorKind,
    /// How the load fraction follows the path, where it does.
    pub path: Option<PathControl>,
    /// Whether displacements count from its start on. Positions at rest are then those at its start, so that forces that are
    /// functions of them ([`crate::BodyForce`]) cannot act on the bodies.
    pub resets_displacements: bool,
}

impl Stage {
    /// Halvings at most: a part of a step is a whole number of the smallest ones, in 64 bits.
    pub const MOST_CUTS: u8 = 40;

    /// So many equal load steps, each of which may be halved ten times.
    pub const fn equal(steps: u32) -> Self {
        Self {
            name: String::new(),
            steps,
            cuts: 10,
            predictor: PredictorKind::LastStep,
            path: None,
            resets_displacements: false,
        }
    }
}

/// Where the iteration of a load step begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PredictorKind {
    /// At the displacement of the step before; where that does not converge at once, at rest.
    #[default]
    LastStep,
    /// At rest.
    Rest,
}

/// Control of the path: the load fraction is found, and may decrease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathControl {
    /// What the length of a step is.
    pub measure: PathMeasure,
    /// Change of the load fraction in the first step `[-]`.
    pub first: f64,
    /// Largest change of the load fraction in any step, about `[-]`.
    pub longest: f64,
    /// Iterations that a step should need: with fewer the next is longer, with more shorter.
    pub iterations: u32,
}

/// What the length of a step along the path is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMeasure {
    /// Root mean square of the free displacements.
    ArcLength {
        /// Longest step `[L]`.
        most: Option<f64>,
    },
    /// Dissipated energy.
    Dissipation {
        /// Longest step `[F L]`.
        most: Option<f64>,
    },
}

/// When a load step counts as solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// `|f_oob| / (|f_ext| + |f_reaction|)` `[-]`.
    pub residual: f64,
    /// Newton iterations before the step is cut.
    pub iterations: u32,
    /// Part of the out-of-balance force that an iteration may leave for its factorisation to be kept, if it
    /// may be at all `[-]`.
    pub keep_factor_below: Option<f64>,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { residual: 1e-9, iterations: 25, keep_factor_below: None }
    }
}

/// What a scene wants done about domains that have outgrown their cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DomainLimit {
    /// What is done, and from which size on.
    pub control: DomainControl,
    /// Points of all bodies at most.
    pub most_points: usize,
}

/// What is done about a rigid motion that neither supports nor any stiffness hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UnheldMotion {
    /// No load step is made: any amount of the motion would be as good an equilibrium as any other.
    #[default]
    Refuse,
    /// The motion is kept at zero where no load has a part in it: the volume mean of the material does not move along it.
    Zero,
}
