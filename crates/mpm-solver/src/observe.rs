//! What a run lets others see: an [`Observer`] is called once per converged load step.
//!
//! The solver decides which columns a history has ([`Column`]); an observer that stores or prints
//! them needs no knowledge of physics. Fields of points are computed when asked for, or never.

pub use crate::cancellation::Cancellation;
pub use crate::timing::Timing;
pub use mpm_assembly::Space;

use crate::state::State;
use mpm_grid::LoadFraction;
use mpm_material::FieldInfo;
use std::error::Error;

/// What one entry of a history column is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// A count; stored as an unsigned integer.
    Count,
    /// A real number.
    Real,
}

/// One column of the history: `width` numbers per load step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Path below `/history`, for example `newton_iterations` or `reaction/pulled`.
    pub name: String,
    /// Counts or reals.
    pub kind: ColumnKind,
    /// Numbers per row; a column of width 1 is stored as a vector, a wider one as a matrix.
    pub width: usize,
}

impl Column {
    /// Dimension of its numbers in length L, force F and the number D of dimensions, or what else they are counted in;
    /// `-` for none, `?` where its name says nothing, as of a contribution that does not ship. In the plane forces are per
    /// unit thickness; of bodies of revolution they are those of the whole ring.
    pub fn unit(&self, space: Space) -> &'static str {
        let (group, rest) = self.name.split_once('/').unwrap_or((&self.name, ""));
        let last = rest.rsplit('/').next().unwrap_or_default();
        match (group, last) {
            _ if self.kind == ColumnKind::Count => "-",
            ("reaction", _) | ("tool", "force") => "F",
            ("reaction_moment" | "energy", _) | ("tool", "moment") => "F L",
            ("displacement", _) | ("tool" | "probe", "position") | ("probe", "displacement") => "L",
            ("probe", "cauchy_stress") => "F/L²",
            ("tool" | "probe", "angle") | ("angle", _) => "°",
            ("tool", "area") if space.is_axisymmetric() => "L²",
            ("tool", "area") => "L^(D-1)",
            ("driven_gap", _) => "cells",
            ("wall_seconds", "") => "s",
            ("stage", "fraction") | ("tool", "deepest" | "rotation") | (_, "") => "-",
            _ => "?",
        }
    }
}

/// The values of one column in one row, `Column::width` of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// Values of a [`ColumnKind::Count`] column.
    Count(Vec<u64>),
    /// Values of a [`ColumnKind::Real`] column.
    Real(Vec<f64>),
}

/// A quantity of the material points that can be asked for: one of [`Field::OF_POINTS`], what a law remembers,
/// or what contributions know of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Field {
    name: &'static str,
    components: usize,
    unit: &'static str,
}

impl Field {
    /// Displacement since the start, three components `[L]`.
    pub const DISPLACEMENT: Self = Self::new("displacement", 3, "L");
    /// Deformation gradient F, nine components row by row `[-]`.
    pub const DEFORMATION_GRADIENT: Self = Self::new("deformation_gradient", 9, "-");
    /// Cauchy stress σ = τ/J, nine components row by row `[F/L²]`.
    pub const CAUCHY_STRESS: Self = Self::new("cauchy_stress", 9, "F/L²");
    /// Elastic logarithmic (Hencky) strain ε_e = ½ ln b_e, nine components row by row `[-]`.
    pub const ELASTIC_STRAIN: Self = Self::new("elastic_strain", 9, "-");
    /// Current volume J V⁰ (plane strain: per unit thickness) `[L^D]`; of bodies of revolution that of the ring `[L³]`.
    pub const VOLUME: Self = Self::new("volume", 1, "L^D");
    /// Deviatoric norm ρ = √(2 J₂) of the Kirchhoff stress `[F/L²]`.
    pub const RHO: Self = Self::new("rho", 1, "F/L²");
    /// 1 where the last load step was plastic, else 0.
    pub const PLASTIC: Self = Self::new("plastic", 1, "-");
    /// `J = det F` `[-]`.
    pub const VOLUME_RATIO: Self = Self::new("volume_ratio", 1, "-");
    /// Signed volume of the point's domain over that at rest; 1 for points without one `[-]`.
    pub const DOMAIN_MEASURE: Self = Self::new("domain_measure", 1, "-");
    /// Smallest weight of a corner of the domain; 1 for points without one `[-]`.
    pub const SMALLEST_CORNER_WEIGHT: Self = Self::new("smallest_corner_weight", 1, "-");
    /// Number of nodes that receive the point through a single corner of its domain.
    pub const SINGLE_CORNER_NODES: Self = Self::new("single_corner_nodes", 1, "-");
    /// Number of the domain's corners outside the mesh; all of them where one lies too far outside.
    pub const CORNERS_OUTSIDE: Self = Self::new("corners_outside", 1, "-");
    /// 1 where a fallback has replaced the domain, else 0.
    pub const FALLEN_BACK: Self = Self::new("fallen_back", 1, "-");
    /// Number of the body (in the order of the scene) that the point belongs to.
    pub const BODY: Self = Self::new("body", 1, "-");
    /// Angle by which the point has turned about the axis of its body of revolution; 0 of bodies that do not turn `[rad]`.
    pub const ANGLE: Self = Self::new("angle", 1, "rad");
    /// Corners of the point's domain round its outline, four of (x, y), the last repeated where there are three;
    /// the position, four times, for points without one. Plane strain only `[L]`.
    pub const OUTLINE: Self = Self::new("outline", 8, "L");

    /// The fields that points of any law and basis have.
    pub const OF_POINTS: [Self; 16] = [
        Self::DISPLACEMENT,
        Self::DEFORMATION_GRADIENT,
        Self::CAUCHY_STRESS,
        Self::ELASTIC_STRAIN,
        Self::VOLUME,
        Self::RHO,
        Self::PLASTIC,
        Self::VOLUME_RATIO,
        Self::DOMAIN_MEASURE,
        Self::SMALLEST_CORNER_WEIGHT,
        Self::SINGLE_CORNER_NODES,
        Self::CORNERS_OUTSIDE,
        Self::FALLEN_BACK,
        Self::BODY,
        Self::OUTLINE,
        Self::ANGLE,
    ];

    const fn new(name: &'static str, components: usize, unit: &'static str) -> Self {
        Self { name, components, unit }
    }

    /// Name of the field's dataset.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Numbers per point.
    pub fn components(self) -> usize {
        self.components
    }

    /// Dimension of its numbers in length L, force F and the number D of dimensions; `-` for none.
    pub fn unit(self, space: Space) -> &'static str {
        // Volumes of bodies of revolution are those of the whole ring.
        if self == Self::VOLUME && space.is_axisymmetric() { "L³" } else { self.unit }
    }
}

/// What a law remembers.
impl From<FieldInfo> for Field {
    fn from(info: FieldInfo) -> Self {
        Self::new(info.name, info.components, info.unit)
    }
}

/// Access to the material points at the end of a load step.
pub trait Fields {
    /// Number of material points.
    fn n_points(&self) -> usize;
    /// Positions, three components per point (z = 0 in plane strain) `[L]`.
    fn positions(&self) -> Vec<f64>;
    /// One field, `field.components()` numbers per point, point by point; 0 for points whose law does not have it.
    fn field(&self, field: Field) -> Vec<f64>;
    /// Corners of every point's domain, three components per corner: round the outline in the plane,
    /// a list in space; none for points without a domain `[L]`.
    fn outlines(&self) -> Vec<Vec<[f64; 3]>> {
        Vec::new()
    }
}

/// What a run is, said once before its first step.
#[derive(Clone, Debug)]
pub struct RunStart {
    /// The space of the bodies: what coordinates and components are.
    pub space: Space,
    /// Columns of the history.
    pub columns: Vec<Column>,
    /// Material points at the start.
    pub points: usize,
    /// Nominal number of load steps.
    pub steps: usize,
    /// Number of stages: the load fraction at the end of the run.
    pub stages: usize,
    /// Which rows are counted where points are recorded at every so many load steps.
    pub counted: Counted,
}

/// Which rows of a history are counted where points are recorded at every so many load steps: those that runs of
/// one scene have in common, whatever steps are halved or end at knots of ramps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Counted {
    /// All rows: load fractions are found along a path.
    #[default]
    Rows,
    /// Rows at the ends of the equal steps of the load fraction, so many in each stage.
    EqualSteps(Vec<u32>),
}

impl Counted {
    /// Number of a row at a load fraction; none where it is not counted.
    pub fn number(&self, row: usize, fraction: f64) -> Option<usize> {
        match self {
            Self::Rows => Some(row),
            Self::EqualSteps(stages) => {
                let stage = LoadFraction::of_total(fraction).ok()?.stage() as usize;
                let (before, steps) = (f64::from(stage as u32), f64::from(*stages.get(stage)?));
                let number = ((fraction - before) * steps).round();
                let earlier: usize = stages[..stage].iter().map(|steps| *steps as usize).sum();
                (before + number / steps == fraction).then_some(earlier + number as usize)
            }
        }
    }

    /// Whether points are recorded at a row, if they are at every so many; they are at the end of each of several stages.
    pub fn is_recorded(&self, every: usize, row: usize, fraction: f64) -> bool {
        let ends_stage =
            matches!(self, Self::EqualSteps(stages) if stages.len() > 1 && fraction.fract() == 0.0);
        ends_stage || self.number(row, fraction).is_some_and(|number| number.is_multiple_of(every))
    }
}

/// One converged load step, or (with `index` 0) the initial state.
pub struct LoadStep<'a> {
    /// Row of the history: 0 is the initial state.
    pub index: usize,
    /// Load fraction at the end of the step; it counts stages, see [`LoadFraction::total`].
    pub fraction: f64,
    /// The row, one entry per column of [`RunStart::columns`].
    pub row: &'a [Entry],
    /// Relative out-of-balance force of every iterate of this step, first to last.
    pub residuals: &'a [f64],
    /// Seconds and counts per phase since the start of the run.
    pub timings: &'a [Timing],
    /// The material points.
    pub fields: &'a dyn Fields,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// All load steps converged.
    Completed,
    /// The run stopped early, for this reason.
    Failed(String),
}

/// Anything that can go wrong in an observer (a full disk, say) ends the run with this.
pub type ObserverError = Box<dyn Error + Send + Sync>;

/// What a run that goes on from a [`State`] has behind it.
pub struct Resumed {
    /// Rows of the history that were shown: the initial state and the load steps.
    pub rows: usize,
    /// Load fraction reached.
    pub fraction: f64,
}

/// When a run offers its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// After this load step has been shown.
    Step(usize),
    /// After this load step, the last of a stage that has a name, has been shown.
    StageEnd(usize),
    /// At the end of a run that stops early; the state is that of the last load step.
    End,
}

/// Looks at a run: called before it, after every converged load step, and at its end.
pub trait Observer {
    /// Called once, before the initial state is shown.
    ///
    /// # Errors
    /// Whatever keeps the observer from working; the run does not start.
    fn start(&mut self, _run: &RunStart) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Called once instead of [`Self::start`] where a run goes on from a [`State`]; the next load step is
    /// number `so_far.rows`.
    ///
    /// # Errors
    /// Whatever keeps the observer from going on; the run does not start.
    fn resume(&mut self, run: &RunStart, _so_far: &Resumed) -> Result<(), ObserverError> {
        self.start(run)
    }

    /// The flag that stops the run; one that nobody raises if left out.
    fn cancellation(&self) -> Cancellation {
        Cancellation::default()
    }

    /// Called after every load step that was shown, and where the run stops early: a chance to keep the
    /// state from which it can go on. The state is made by the call of `state` only.
    ///
    /// # Errors
    /// Whatever keeps the observer from working; the run stops.
    fn save(&mut self, _at: Moment, _state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Called for the initial state and after every converged load step.
    ///
    /// # Errors
    /// Whatever keeps the observer from working; the run stops and keeps what was recorded.
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError>;

    /// Called once before [`Self::finish`], also of a run that failed, with the load fraction and the points of the last
    /// load step that was shown: who does not keep those of every step can keep them here.
    ///
    /// # Errors
    /// Whatever keeps the observer from working.
    fn last(&mut self, _fraction: f64, _fields: &dyn Fields) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Called once at the end, also of a run that failed.
    ///
    /// # Errors
    /// Whatever keeps the observer from closing its record.
    fn finish(&mut self, _outcome: &Outcome, _timings: &[Timing]) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// Sees nothing.
impl Observer for () {
    fn load_step(&mut self, _: &LoadStep<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Column, ColumnKind, Counted, Field, Space};

    #[test]
    fn columns_have_units() {
        let column = |name: &str| Column { name: name.into(), kind: ColumnKind::Real, width: 1 };
        let unit = |name: &str| column(name).unit(Space::Cartesian);
        let named = ["load_fraction", "reaction/a/b", "tool/a/b/area", "probe/p/cauchy_stress", "springs/a"];
        assert_eq!(named.map(unit), ["-", "F", "L^(D-1)", "F/L²", "?"]);
        let count = Column { name: "tool/a/closed".into(), kind: ColumnKind::Count, width: 1 };
        assert_eq!(count.unit(Space::Cartesian), "-");
        assert_eq!(column("tool/a/area").unit(Space::Axisymmetric), "L²");
        let volumes = [Space::Cartesian, Space::Axisymmetric].map(|space| Field::VOLUME.unit(space));
        assert_eq!(volumes, ["L^D", "L³"]);
    }

    #[test]
    fn halved_steps_are_not_counted() {
        let counted = Counted::EqualSteps(vec![10]);
        let at = |fraction| counted.number(7, fraction);
        assert_eq!(
            [at(0.0), at(0.1), at(0.25), at(3.0 / 10.0), at(1.0)],
            [Some(0), Some(1), None, Some(3), Some(10)]
        );
        assert!(counted.is_recorded(5, 7, 0.5) && !counted.is_recorded(5, 5, 0.55));
        assert_eq!(Counted::Rows.number(7, 0.25), Some(7));
        let staged = Counted::EqualSteps(vec![2, 3]);
        let at = |fraction| staged.number(7, fraction);
        assert_eq!(
            [at(0.5), at(1.0), at(1.0 + 1.0 / 3.0), at(1.5), at(2.0)],
            [Some(1), Some(2), Some(3), None, Some(5)]
        );
        assert_eq!(at(2.5), None);
    }
}
