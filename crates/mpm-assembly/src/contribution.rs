//! What adds to force and tangent: bodies, ghost faces, and whatever else acts on nodes or has unknowns of its own.

use crate::body::{AssemblyPlan, Body, InadmissiblePoint};
use crate::sharing::{SavedByPoint, Scale, Sharing};
use crate::trial::{SystemSums, Trial};
use crate::unknowns::{Couplings, SparsityPattern, Unknowns};
use mpm_basis::{ActiveNodes, Connectivity};
use mpm_grid::{LoadFraction, Mesh, NodeId, Ramp};
use mpm_linear::Symmetry;
use mpm_material::FieldInfo;

/// Adds to the out-of-balance force and to the tangent of a load step.
///
/// The solver asks in this order, in every load step:
/// 1. [`begin`](Self::begin) freezes what does not change while the step is balanced, and
///    [`locate`](Self::locate) finds where the contribution's couplings are stored, if the pattern is new;
/// 2. [`add`](Self::add), for every trial; it is pure, so that any trial may be the last one;
/// 3. [`augment`](Self::augment) once the step is balanced; where it has changed what it holds fixed, the step is balanced
///    again from where it is,
/// 4. [`prepare`](Self::prepare), and [`commit`](Self::commit) once the points are committed. A step that fails is begun
///    again from 1, so that what was prepared is dropped,
/// 5. [`divide`](Self::divide) where points were split after the step.
///
/// A contribution that remembers something from step to step (a slip, an anchor, a carried force) keeps it apart from
/// what it has prepared, and [saves](Self::save) it for a run that is resumed.
///
/// Unknowns that belong to no node's displacement (a nodal field, the free motion of a rigid tool) are
/// [pushed](Unknowns::push) in `begin`. They count from the start of the step, as displacements do.
pub trait Contribution<const D: usize>: Send + Sync {
    /// Begins a load step.
    ///
    /// # Errors
    /// Why no load step can begin here; the solver reports the reason and cuts the step.
    fn begin(&mut self, step: &StepStart<'_, D>, unknowns: &mut Unknowns<D>) -> Result<Begun, Refused> {
        let _ = (step, unknowns);
        Ok(Begun::AsBefore)
    }

    /// What the `k`-th of the unknowns is that it has pushed in this step, as a message says it; `axes` are the names of the
    /// directions.
    fn describe_unknown(&self, k: usize, axes: [&'static str; 3]) -> String {
        let _ = axes;
        format!("unknown {k}")
    }

    /// The places that it couples in this step; they make the pattern of the tangent.
    fn couplings(&self) -> &dyn Couplings;

    /// Whether its tangent is symmetric; the pattern takes the worst of all contributions.
    fn symmetry(&self) -> Symmetry {
        Symmetry::Unsymmetric
    }

    /// Finds where its couplings are stored in a new pattern. [`SystemSums::add`] needs no such preparation.
    fn locate(&mut self, pattern: &SparsityPattern<D>) {
        let _ = pattern;
    }

    /// Adds its internal force, and its tangent where that is wanted, under a trial. A spring adds `+k u` and `+k`; a
    /// force from outside is subtracted.
    ///
    /// # Errors
    /// The trial is not admissible, for example because a point is inverted.
    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible>;

    /// Its share in the size of the forces with which an out-of-balance force is compared, a Euclidean norm over unknowns:
    /// nothing, if the supports and the external force carry it all.
    fn scale(&self, trial: &Trial<'_, D>) -> Scale<D> {
        let _ = trial;
        Scale::Size(0.0)
    }

    /// Adds to every active node the size of what its force is a small difference of, such as stiffness times position:
    /// rounding takes the last digits of that `[F]`.
    fn round_off(&self, sizes: &mut [f64]) {
        let _ = sizes;
    }

    /// The size with which the residuals of its own unknowns are compared, in the units of those residuals: the norm of these
    /// numbers, each the sum over all who share it; without any it is 1.
    fn own_scale(&self, trial: &Trial<'_, D>) -> Vec<f64> {
        let _ = trial;
        Vec::new()
    }

    /// The residual of its own unknowns that rounding alone can cause, as the norm of numbers in their units, each the sum
    /// over all who share it.
    fn own_round_off(&self, trial: &Trial<'_, D>) -> Vec<f64> {
        let _ = trial;
        Vec::new()
    }

    /// Whether its force depends on the load fraction besides the displacement, as where a wall or a tool moves.
    fn moves_with_load(&self) -> bool {
        false
    }

    /// Whether it only pulls at bodies, as a load does, and cannot hold or push them.
    fn is_load(&self) -> bool {
        false
    }

    /// Ramps that it follows: load steps end at their knots.
    fn ramps(&self) -> Vec<&Ramp> {
        Vec::new()
    }

    /// What in it is probably not meant on the mesh and for the bodies at the start, though it can be run: sentences that
    /// name it.
    fn remarks(&self, mesh: &Mesh<D>, bodies: &[(&str, &dyn Body<D>)]) -> Vec<String> {
        let _ = (mesh, bodies);
        Vec::new()
    }

    /// Where it has a size of its own, what a check tells of that once the first load step has begun.
    fn size(&self, bodies: &[(&str, &dyn Body<D>)]) -> Option<String> {
        let _ = bodies;
        None
    }

    /// Memory that it holds at the peak of a load step, once the first one has begun `[bytes]`. What takes next to nothing
    /// beside bodies need not say it.
    fn bytes(&self) -> usize {
        0
    }

    /// Whether it exists only on the nodes on which the functions of the mesh live.
    fn needs_functions_of_mesh(&self) -> bool {
        false
    }

    /// Whether several may share it who each hold some of the points: what it adds, its round-off and its energies are then
    /// those of a part, and their sums are the whole; so are those of its history that do not say otherwise.
    fn can_be_shared(&self) -> bool {
        false
    }

    /// Whether it gives stiffness to nodes that points barely reach.
    fn stabilises(&self) -> bool {
        false
    }

    /// Energies of a balanced trial.
    fn energy(&self, trial: &Trial<'_, D>) -> ContributionEnergy {
        let _ = trial;
        ContributionEnergy::default()
    }

    /// Looks at a balanced trial, and may change what [`begin`](Self::begin) has frozen, such as the multipliers of a
    /// constraint; `round` counts from 0. Returns whether the step has to be balanced again, which ends at some round; all who
    /// share it answer alike.
    fn augment(&mut self, trial: &Trial<'_, D>, round: u32, sharing: &dyn Sharing<D>) -> bool {
        let _ = (trial, round, sharing);
        false
    }

    /// Points of a body were split: `parts` tells for every point of now its point of before, and its share of that.
    fn divide(&mut self, body: usize, parts: &[(usize, f64)]) {
        let _ = (body, parts);
    }

    /// Works out its state at the end of a balanced step, apart from the present one.
    ///
    /// # Errors
    /// Why the run cannot go on from this balance; the solver reports the reason and cuts the step.
    fn prepare(&mut self, trial: &Trial<'_, D>) -> Result<(), Inadmissible> {
        let _ = trial;
        Ok(())
    }

    /// Makes the prepared state the present one.
    fn commit(&mut self) {}

    /// Its present state as finite numbers, from which a run goes on bit for bit.
    fn save(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Takes the numbers that [`Self::save`] returned in an earlier run.
    ///
    /// # Errors
    /// What the numbers are, and what was expected; nothing has changed.
    fn restore(&mut self, saved: &[f64]) -> Result<(), String> {
        if saved.is_empty() { Ok(()) } else { Err(format!("has {} numbers, expected none", saved.len())) }
    }

    /// Nodes that it needs besides those that the points here influence, of those that carry material: markers may stand in
    /// cells whose points are all with others.
    fn nodes(&self, mesh: &Mesh<D>, sharing: &dyn Sharing<D>) -> Vec<NodeId> {
        let _ = (mesh, sharing);
        Vec::new()
    }

    /// Called after a step was committed: takes from the others what it must remember alike, see [`Sharing::gathered`].
    fn hear(&mut self, sharing: &dyn Sharing<D>) {
        let _ = sharing;
    }

    /// How what it saves is shared out with the points; none where it is the same for all who share it.
    fn saved_by_point(&self) -> Option<SavedByPoint> {
        None
    }

    /// What the history of the run tells of it after the last committed step: always the same columns, whose names no
    /// other contribution of the model has.
    fn history(&self) -> Vec<Recorded> {
        Vec::new()
    }

    /// Fields of the material points that it can show in results.
    fn point_fields(&self) -> &'static [PointField] {
        &[]
    }

    /// One of its [fields](Self::point_fields) after the last committed step: all components of every point of `bodies`,
    /// which are those of the model, body by body.
    fn point_field(&self, name: &str, bodies: &[&dyn Body<D>]) -> Vec<f64> {
        let _ = (name, bodies);
        Vec::new()
    }
}

/// A field of the material points that contributions know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointField {
    /// Name, components and unit.
    pub info: FieldInfo,
    /// What is shown where several contributions have the field.
    pub joined: Joined,
}

/// How the values of several contributions make one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joined {
    /// Their sum.
    Sum,
    /// The least of them.
    Least,
}

/// A column of the history, and its values in one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Path below `/history`.
    pub name: String,
    /// The values.
    pub values: RecordedValues,
    /// What they are where several share the contribution.
    pub of_parts: OfParts,
}

/// What the values of those make who share a contribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OfParts {
    /// Their sum.
    #[default]
    Sum,
    /// The largest of them.
    Largest,
    /// They are the same.
    Same,
}

/// Values of a column in one row.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordedValues {
    /// A count.
    Count(u64),
    /// Real numbers.
    Real(Vec<f64>),
}

impl Recorded {
    /// A count.
    pub fn count(name: impl Into<String>, count: u64) -> Self {
        Self { name: name.into(), values: RecordedValues::Count(count), of_parts: OfParts::Sum }
    }

    /// Real numbers.
    pub fn real(name: impl Into<String>, values: impl Into<Vec<f64>>) -> Self {
        Self { name: name.into(), values: RecordedValues::Real(values.into()), of_parts: OfParts::Sum }
    }

    /// The same with what the values of several parts make.
    #[must_use]
    pub fn of_parts(self, of_parts: OfParts) -> Self {
        Self { of_parts, ..self }
    }
}

/// Whether a contribution couples the places that it coupled in the load step that was begun before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begun {
    /// It does, so that the pattern may be kept.
    AsBefore,
    /// It may not.
    Anew,
}

/// Why a contribution cannot begin a load step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Refused {
    /// A clause that follows the contribution's name.
    pub reason: String,
    /// Whether a shorter step may be begun.
    pub is_step_too_long: bool,
}

impl Refused {
    /// A shorter step may be begun.
    pub fn step_too_long(reason: impl Into<String>) -> Self {
        Self { reason: reason.into(), is_step_too_long: true }
    }

    /// No step can be begun from here, however short.
    pub fn here(reason: impl Into<String>) -> Self {
        Self { reason: reason.into(), is_step_too_long: false }
    }
}

/// Why a trial is not admissible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Inadmissible {
    /// A point of a body has no admissible state.
    #[error("{0}")]
    Point(InadmissiblePoint),
    /// A contribution has none; a clause that follows its name.
    #[error("{0}")]
    Contribution(String),
}

/// Energies of a contribution `[F L]` (in the plane: per unit thickness).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContributionEnergy {
    /// Stored at the end of the step.
    pub stored: f64,
    /// Dissipated in the step.
    pub dissipated: f64,
    /// Work done on the contribution from outside in the step, as by a wall that is moved.
    pub work: f64,
}

/// A load step at its start.
#[derive(Clone, Copy)]
pub struct StepStart<'a, const D: usize> {
    /// Mesh of the step.
    pub mesh: &'a Mesh<D>,
    /// Nodes that carry material.
    pub active: &'a ActiveNodes<D>,
    /// The bodies, in the order of the model.
    pub bodies: &'a [BodyAtStart<'a, D>],
    /// Load fraction at the start.
    pub from: LoadFraction,
    /// Load fraction at the end; along a path only the balanced step knows its own, see [`Trial::end`].
    pub to: LoadFraction,
    /// Whether the last step that was begun started here too, and failed: mesh and points are the same.
    pub is_retry: bool,
    /// Who else holds points of the same bodies.
    pub sharing: &'a dyn Sharing<D>,
}

/// A body at the start of a load step.
#[derive(Clone, Copy)]
pub struct BodyAtStart<'a, const D: usize> {
    /// Its name.
    pub name: &'a str,
    /// Its points.
    pub body: &'a dyn Body<D>,
    /// Which nodes its points influence.
    pub connectivity: &'a Connectivity<D>,
}

/// A body and its connection in a load step.
#[derive(Clone, Copy)]
pub struct ConnectedBody<'a, const D: usize> {
    /// Its points.
    pub body: &'a dyn Body<D>,
    /// How they are connected to the nodes.
    pub plan: &'a AssemblyPlan<D>,
}

/// The life of a body's points is that of [`Body`]; in a load step it is a contribution like any other.
impl<const D: usize> Contribution<D> for ConnectedBody<'_, D> {
    fn couplings(&self) -> &dyn Couplings {
        self.plan.body_connectivity()
    }

    fn symmetry(&self) -> Symmetry {
        self.body.symmetry()
    }

    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible> {
        let determinant = self.body.assemble(self.plan, trial.input(), sums.sums());
        let determinant = determinant.map_err(Inadmissible::Point)?;
        sums.smallest_determinant = sums.smallest_determinant.min(determinant);
        Ok(())
    }
}
