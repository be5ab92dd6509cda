//! The end of a load step: points take the state of the converged displacement.

use crate::body::advance_points::{Advanced, StateColumns};
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::batch_law::{AdvancingPoints, LawOfPoints};
use crate::body::dilatation::Dilated;
use crate::body::kinematics::LargestStrain;
use crate::body::points::Points;
use crate::body::space::Space;
use crate::body::trial::{Committed, InadmissiblePoint};
use mpm_basis::parallel::both;
use mpm_basis::{ActiveNodes, Basis, Connectivity, Convection, ConvectionError};
use mpm_grid::{Block, Mesh, Vector};
use mpm_material::{Material, SymmetricTensor};
use std::ops::Range;

/// Groups per task; fixed, so that nothing depends on the number of threads.
const GROUPS: usize = 256;

/// A point that could not be carried through a load step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AdvanceError {
    /// It has no admissible state.
    #[error(transparent)]
    Inadmissible(#[from] InadmissiblePoint),
    /// It has moved farther than any mesh could carry it.
    #[error(
        "material point {point} at {position:?} would move by {distance} in one load step, and the mesh is no \
        longer than {reach}: this equilibrium is not believed"
    )]
    TooFar {
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step `[L]`.
        position: Vec<f64>,
        /// Length of its displacement in the step `[L]`.
        distance: f64,
        /// Diagonal of the mesh `[L]`.
        reach: f64,
    },
    /// The centre of its domain has come to the axis of its body of revolution.
    #[error("material point {point} at {position:?} would be at the radius {radius:e}, across the axis")]
    AcrossAxis {
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step, (r, z) `[L]`.
        position: Vec<f64>,
        /// Its radius at the end `[L]`.
        radius: f64,
    },
    /// Its domain cannot be carried on.
    #[error("material point {point} at {position:?}: {}", reason.told(space.axes()))]
    Domain {
        /// Index of the point in its body.
        point: usize,
        /// Where it is at the start of the step `[L]`.
        position: Vec<f64>,
        /// The space of its body.
        space: Space,
        /// What is wrong with its domain.
        reason: ConvectionError,
    },
}

impl AdvanceError {
    /// The same error, of the point that has this number elsewhere.
    pub fn renumbered(mut self, number: impl Fn(usize) -> usize) -> Self {
        let place = match &mut self {
            Self::Inadmissible(it) => &mut it.point,
            Self::TooFar { point, .. } | Self::AcrossAxis { point, .. } | Self::Domain { point, .. } => point,
        };
        *place = number(*place);
        self
    }
}

/// What a converged load step is for the points.
#[derive(Clone, Copy)]
pub struct Converged<'a, const D: usize> {
    /// Mesh of the step.
    pub mesh: &'a Mesh<D>,
    /// Nodes of the step.
    pub active: &'a ActiveNodes<D>,
    /// `Δu_v` of every active node `[L]`.
    pub increment: &'a [Vector<D>],
    /// The unknowns that belong to no node's displacement; read where a nodal field is among them.
    pub own: &'a [f64],
}

/// What the law says of the points after a load step, worked out beside the present columns.
///
/// Kept from step to step: a step writes all of it, and [`PreparedState::swap`] exchanges it for the present columns.
#[derive(Default)]
pub(crate) struct PreparedState<const D: usize> {
    deformation_gradient: Vec<Block<D>>,
    hoop_stretch: Vec<f64>,
    angle: Vec<f64>,
    elastic_excess: Vec<SymmetricTensor>,
    plastic: Vec<bool>,
    largest_strain: LargestStrain,
}

impl<const D: usize> PreparedState<D> {
    /// Works out the state after the step under `increment`, the `Δu_v` of every active node `[L]`: the trial state
    /// of the law becomes the committed one, and `next_history` what it remembers.
    ///
    /// # Errors
    /// The first point (in order) that has no admissible state under the increment.
    pub fn advance<M: Material, const HOOP: bool>(
        &mut self,
        next_history: &mut Vec<M::History>,
        committed: Committed<'_, D, M>,
        plan: &AssemblyPlan<D>,
        increment: &[Vector<D>],
    ) -> Result<(), InadmissiblePoint> {
        let points = committed.points;
        let n = points.len();
        self.deformation_gradient.resize(n, Block::zeros());
        self.hoop_stretch.resize(points.hoop_stretch.len(), 1.0);
        self.angle.resize(points.angle.len(), 0.0);
        self.elastic_excess.resize(n, SymmetricTensor::ZERO);
        // Written anew, too; this is for the length.
        next_history.clear();
        next_history.extend_from_slice(committed.history);
        self.plastic.resize(points.plastic.len(), false);
        let columns = StateColumns {
            deformation_gradient: &mut self.deformation_gradient,
            hoop_stretch: &mut self.hoop_stretch,
            angle: &mut self.angle,
            elastic_excess: &mut self.elastic_excess,
            plastic: &mut self.plastic,
        };
        let connectivity = plan.connectivity();
        let dilated = match plan.dilatation() {
            None => Vec::new(),
            Some(dilatation) => {
                Dilated::<D, M, HOOP> { committed, connectivity, dilatation, increment }.steps()?
            }
        };
        let Committed { law, history, .. } = committed;
        let advanced = Advanced::<D, HOOP> { points, increment, dilated: &dilated };
        let (all, columns) = (0..connectivity.n_groups(), (columns, &mut next_history[..]));
        self.largest_strain = in_groups(connectivity, all, columns, &|groups, (mut columns, next)| {
            let first = if groups.is_empty() { 0 } else { connectivity.group_points(groups.start).start };
            let mut law = AdvancingPoints { of: LawOfPoints { law, history }, next, first };
            advanced.write(groups.map(|group| connectivity.group(group)), &mut law, &mut columns)
        })?;
        Ok(())
    }

    /// The largest |ln λ| of the step's ΔF among the points that yield in it, λ its principal stretches `[-]`.
    pub fn largest_strain(&self) -> f64 {
        self.largest_strain.strain
    }

    /// F of every point after the step.
    pub fn deformation_gradient(&self) -> &[Block<D>] {
        &self.deformation_gradient
    }

    /// Makes the prepared columns the present ones.
    pub fn swap(&mut self, points: &mut Points<D>) {
        std::mem::swap(&mut self.deformation_gradient, &mut points.deformation_gradient);
        std::mem::swap(&mut self.hoop_stretch, &mut points.hoop_stretch);
        std::mem::swap(&mut self.angle, &mut points.angle);
        std::mem::swap(&mut self.elastic_excess, &mut points.elastic_excess);
        std::mem::swap(&mut self.plastic, &mut points.plastic);
    }
}

/// Where the points and their domains are after a load step, worked out beside the present columns.
pub(crate) struct PreparedDomains<const D: usize, Domain> {
    position: Vec<Vector<D>>,
    domain: Vec<Domain>,
}

// Derived `Default` would ask for `Domain: Default`.
impl<const D: usize, Domain> Default for PreparedDomains<D, Domain> {
    fn default() -> Self {
        Self { position: Vec::new(), domain: Vec::new() }
    }
}

impl<const D: usize, Domain: Clone + Send + Sync> PreparedDomains<D, Domain> {
    /// Works out positions, which move by `Σ_v S_vp Δu_v`, and domains, which the basis convects.
    /// `deformation_gradient` is F of every point after the step.
    ///
    /// # Errors
    /// The first point (in order) that moves too far, or whose domain cannot be carried on.
    pub fn advance<B: Basis<D, Domain = Domain>>(
        &mut self,
        basis: &B,
        (position, domain, space): (&[Vector<D>], &[Domain], Space),
        deformation_gradient: &[Block<D>],
        connectivity: &Connectivity<D>,
        step: Converged<'_, D>,
    ) -> Result<(), AdvanceError> {
        // Points and domains move from where they are.
        self.position.clear();
        self.position.extend_from_slice(position);
        self.domain.clear();
        self.domain.extend_from_slice(domain);
        let reach = step.mesh.diagonal();
        let columns = (&mut self.position[..], &mut self.domain[..]);
        in_groups(connectivity, 0..connectivity.n_groups(), columns, &|groups, (positions, domains)| {
            let mut du = Vec::new();
            let mut at = 0;
            for view in groups.map(|group| connectivity.group(group)) {
                du.clear();
                du.extend(view.nodes.iter().map(|&node| step.increment[node as usize]));
                for k in 0..view.points {
                    let p = view.first_point + k;
                    let mut displacement = Vector::zeros();
                    for (value, du) in view.point(k).0.iter().zip(&du) {
                        displacement += du * *value;
                    }
                    let distance = displacement.norm();
                    if distance > reach {
                        let position = position[p].iter().copied().collect();
                        return Err(AdvanceError::TooFar { point: p, position, distance, reach });
                    }
                    let convection = Convection {
                        displacement,
                        deformation_gradient: deformation_gradient[p],
                        mesh: step.mesh,
                        active: step.active,
                        increment: step.increment,
                    };
                    let carried = basis.convect(&mut domains[at], &mut positions[at], &convection);
                    carried.map_err(|reason| AdvanceError::Domain {
                        point: p,
                        position: position[p].iter().copied().collect(),
                        space,
                        reason,
                    })?;
                    let radius = positions[at][0];
                    if space.is_axisymmetric() && radius <= 0.0 {
                        let position = position[p].iter().copied().collect();
                        return Err(AdvanceError::AcrossAxis { point: p, position, radius });
                    }
                    at += 1;
                }
            }
            Ok(())
        })
    }

    /// Makes the prepared columns the present ones.
    pub fn swap(&mut self, position: &mut Vec<Vector<D>>, domain: &mut Vec<Domain>) {
        std::mem::swap(&mut self.position, position);
        std::mem::swap(&mut self.domain, domain);
    }
}

/// Columns that tasks write to, each to its run of points.
trait SplitColumns: Send + Sized {
    fn split_at(self, point: usize) -> (Self, Self);
}

impl<const D: usize, History: Send> SplitColumns for (StateColumns<'_, D>, &mut [History]) {
    fn split_at(self, at: usize) -> (Self, Self) {
        let (columns, columns_rest) = self.0.split_at(at);
        let (history, history_rest) = self.1.split_at_mut(at);
        ((columns, history), (columns_rest, history_rest))
    }
}

impl<A: Send, B: Send> SplitColumns for (&mut [A], &mut [B]) {
    fn split_at(self, at: usize) -> (Self, Self) {
        let (a, a_rest) = self.0.split_at_mut(at);
        let (b, b_rest) = self.1.split_at_mut(at);
        ((a, b), (a_rest, b_rest))
    }
}

/// What tasks find out of their points.
trait Joined: Send {
    fn joined(self, other: Self) -> Self;
}

impl Joined for () {
    fn joined(self, (): ()) {}
}

impl Joined for LargestStrain {
    fn joined(mut self, other: Self) -> Self {
        self.join(other.strain);
        self
    }
}

/// Does `work` for runs of groups in parallel, halving the range until it is small; what it finds out of all of them, or the
/// first error (in order).
fn in_groups<const D: usize, C: SplitColumns, R: Joined, E: Send>(
    connectivity: &Connectivity<D>,
    groups: Range<usize>,
    columns: C,
    work: &(impl Fn(Range<usize>, C) -> Result<R, E> + Sync),
) -> Result<R, E> {
    if groups.len() <= GROUPS {
        return work(groups, columns);
    }
    let middle = (groups.start + groups.end) / 2;
    let at = connectivity.group_points(middle).start - connectivity.group_points(groups.start).start;
    let (low, high) = columns.split_at(at);
    let (low, high) = both(
        || in_groups(connectivity, groups.start..middle, low, work),
        || in_groups(connectivity, middle..groups.end, high, work),
    );
    Ok(low?.joined(high?))
}
