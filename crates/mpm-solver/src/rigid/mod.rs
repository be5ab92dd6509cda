//! Rigid motions that nothing holds, found before the first factorisation of a tangent that they make singular.
//!
//! Nodes in a motion `t + ω × x` strain no material point, whatever its law. Such a motion is *free* where it moves no
//! node in a component that a support prescribes; that is a small dense question for each part that is connected. What
//! else may hold a free motion (a spring, a tool, ghost faces between two bodies, the stress of a body that hangs) is
//! asked of the tangent K of all contributions: a combination m of free motions is *unheld* where K m = 0 to rounding.
//! A contribution that can hold a body need say no more than its stiffness.

mod growth;
mod modes;
mod naming;
mod null_space;
mod parts;
pub(crate) mod rest;

use crate::connection::{Connected, contributions};
use crate::model::Model;
use crate::ranks::{Ranks, any, largest};
use modes::{Frames, Mode, turns};
use mpm_assembly::{
    Constraints, Contribution, SystemSums, SystemTangent, Trial, UnknownVector, finish_tangent,
};
use mpm_basis::Connectivity;
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_linear::{Matrix, Symmetry};
use null_space::Triangle;
use parts::{NodesAt, RigidParts};

/// Part of the stiffness around it that holds a node against a motion, below which nothing does: what a factorisation
/// can tell from rounding.
const HELD: f64 = 1e-11;

/// Free motions that are looked at; a body that has fallen into more parts is told by the first of them.
const MOST_MODES: usize = 60;

/// The parts of all bodies in a load step, and the motions that supports leave free; the same on all ranks.
pub(crate) struct FreeMotions<const D: usize> {
    parts: RigidParts<D>,
    /// Of the active nodes of this rank.
    positions: Vec<Vector<D>>,
    modes: Vec<Mode>,
}

/// Motions that nothing holds.
#[derive(Default)]
pub(crate) struct Unheld<const D: usize> {
    /// What moves, and how.
    pub clauses: Vec<String>,
    /// Displacement of every active node of this rank in each of them, the largest of all of size 1.
    pub fields: Vec<Vec<Vector<D>>>,
    /// How many of them turn nothing; these come last.
    pub translations: usize,
}

impl<const D: usize> FreeMotions<D> {
    /// The motions that supports leave free; mostly none.
    pub(crate) fn of(
        model: &Model<D>,
        mesh: &Mesh<D>,
        connected: &Connected<D>,
        constraints: &Constraints<D>,
    ) -> Self {
        let bodies: Vec<&Connectivity<D>> =
            connected.assembly_plans.iter().map(|plan| plan.connectivity()).collect();
        // The hoop resists every motion along r.
        let is_ring = model.space().is_axisymmetric();
        let is_held = |node: usize, i: usize| is_ring && i == 0 || constraints.is_prescribed(node, i);
        let n_points: Vec<usize> = model.bodies.iter().map(|named| named.body.n_points()).collect();
        let at = NodesAt {
            nodes: connected.active.nodes(),
            position: &|node| model.nodes.position(mesh, node),
            is_held: &is_held,
            coordinates: model.coordinates(),
            n_points: &n_points,
        };
        let ranks = &*connected.shared.ranks;
        let parts = RigidParts::of(&bodies, at, ranks);
        let positions: Vec<Vector<D>> = at.nodes.iter().map(|&node| (at.position)(node)).collect();
        let mut modes = Vec::new();
        let frames = Frames::of(&parts, &positions, ranks);
        for assembly in &parts.assemblies {
            modes.extend(frames.free(assembly, is_held));
            if modes.len() >= MOST_MODES {
                break;
            }
        }
        Self { parts, positions, modes }
    }

    /// Whether there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.modes.is_empty()
    }

    /// The free motions that no stiffness holds either; none if all are held, or if no tangent can be summed.
    pub(crate) fn unheld(
        &self,
        model: &Model<D>,
        connected: &Connected<D>,
        constraints: &Constraints<D>,
        end: LoadFraction,
    ) -> Option<Unheld<D>> {
        let bodies = connected.bodies(&model.bodies);
        let all = contributions(&bodies, &model.contributions);
        let tangent = tangent_at_rest(connected, constraints, end, &all)?;
        // Bodies do not hold translations: what their tangents say of these is what dropped influences leave.
        let besides = &all[bodies.len()..];
        let besides = match besides.is_empty() {
            true => None,
            false => Some(tangent_at_rest(connected, constraints, end, besides)?),
        };
        let shared = &connected.shared;
        let frames = Frames::of(&self.parts, &self.positions, &*shared.ranks);
        let n = self.modes.len();
        let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
        let modes = frames.combine(&self.modes, &(0..n).map(unit).collect::<Vec<_>>());

        let matrix = |values| Matrix { pattern: connected.pattern.for_solver(), values };
        let image = |mode: &Mode| {
            let mut field = UnknownVector::zeros(connected.unknowns());
            field.nodes = frames.field(mode);
            constraints.free_part(&mut field.nodes);
            let values = if turns(mode) { Some(&tangent) } else { besides.as_ref() };
            let mut numbers = Vec::new();
            field.write_equations(&mut numbers);
            let product = values.map_or(vec![0.0; numbers.len()], |values| matrix(values).times(&numbers));
            complete(connected, product)
        };
        let images: Vec<Vec<f64>> = modes.iter().map(image).collect();
        let sizes = complete(connected, row_sums(matrix(&tangent)));
        let mut triangle = Triangle::new(modes.len());
        for (equation, &size) in sizes.iter().enumerate().filter(|it| connected.counts_equation(it.0)) {
            if size > 0.0 && !constraints.is_held(connected.unknowns(), equation) {
                let mut row: Vec<f64> = images.iter().map(|image| image[equation] / size).collect();
                triangle.add(&mut row);
            }
        }
        let triangle = frames.of_all(triangle);
        let unheld = frames.combine(&modes, &triangle.null_space(HELD));
        (!unheld.is_empty()).then(|| Unheld {
            clauses: naming::clauses(&frames, &model.bodies, &unheld),
            fields: unheld.iter().map(|mode| scaled(frames.field(mode), &*shared.ranks)).collect(),
            translations: unheld.iter().filter(|mode| !turns(mode)).count(),
        })
    }
}

/// Tangent of some contributions where nothing moves; none if they refuse even that.
fn tangent_at_rest<const D: usize>(
    connected: &Connected<D>,
    constraints: &Constraints<D>,
    end: LoadFraction,
    contributions: &[&dyn Contribution<D>],
) -> Option<Vec<f64>> {
    let pattern = &connected.pattern;
    let mut values = vec![0.0; pattern.n_entries()];
    let increment = connected.at_rest();
    let mut force = increment.clone();
    let tangent = Some(SystemTangent { values: &mut values, lift: None });
    let mut sums = SystemSums::new(&mut force, tangent);
    let trial = Trial { pattern, constraints, increment: &increment, end, is_first: true };
    let shared = &connected.shared;
    for contribution in contributions {
        let added = contribution.add(&trial, &mut sums);
        if any(&*shared.ranks, added.is_err()) {
            return None;
        }
    }
    finish_tangent(pattern, constraints, &mut values);
    shared.leave_to_owners(pattern, constraints, &mut values);
    Some(values)
}

/// Numbers of the equations with what other ranks have of them.
fn complete<const D: usize>(connected: &Connected<D>, here: Vec<f64>) -> Vec<f64> {
    let (mut vector, mut numbers) = (UnknownVector::zeros(connected.unknowns()), here);
    vector.read_equations(&numbers);
    connected.complete(&mut vector);
    vector.write_equations(&mut numbers);
    numbers
}

/// Rigid motions that nothing holds at the start of a run, as clauses; none if the tangent cannot be summed.
pub(crate) fn unheld_at_start<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    connected: &Connected<D>,
    constraints: &Constraints<D>,
) -> Vec<String> {
    let free = FreeMotions::of(model, mesh, connected, constraints);
    if free.is_empty() {
        return Vec::new();
    }
    let unheld = free.unheld(model, connected, constraints, LoadFraction::START);
    unheld.map_or(Vec::new(), |unheld| unheld.clauses)
}

/// `Σ_j |K_ij|` of every row.
fn row_sums(matrix: Matrix<'_>) -> Vec<f64> {
    let pattern = matrix.pattern;
    let mut sums = vec![0.0; pattern.n_equations()];
    for j in 0..sums.len() {
        for entry in pattern.column_start[j]..pattern.column_start[j + 1] {
            let (i, size) = (pattern.row[entry], matrix.values[entry].abs());
            sums[i] += size;
            if pattern.symmetry == Symmetry::Symmetric && i != j {
                sums[j] += size;
            }
        }
    }
    sums
}

/// A field whose largest component on any rank is 1 in size.
fn scaled<const D: usize>(mut field: Vec<Vector<D>>, ranks: &dyn Ranks<D>) -> Vec<Vector<D>> {
    let largest = largest(ranks, field.iter().map(|u| u.amax()).fold(0.0, f64::max));
    field.iter_mut().for_each(|u| *u /= largest);
    field
}
