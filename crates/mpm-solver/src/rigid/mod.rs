//! Rigid motions that nothing holds, found before the first factorisation of a tangent that they make singular.
//!
//! Nodes in a motion `t + ω × x` strain no material point, whatever its law. Such a motion is *free* where it moves no
//! node in a component that a support prescribes; that is a small dense question for each part that is connected. What
//! else may hold a free motion (a spring, a tool, ghost faces between two bodies, the stress of a body that hangs) is
//! asked of the tangent K of all contributions: a combination m of free motions is *unheld* where K m = 0 to rounding.
//! A contribution that can hold a body need say no more than its stiffness.

mod modes;
mod naming;
mod null_space;
mod parts;
pub(crate) mod rest;

use crate::connection::{Connected, contributions};
use crate::model::Model;
use modes::{Frames, Mode, turns};
use mpm_assembly::{Constraints, Contribution, SystemSums, SystemTangent, Trial, finish_tangent};
use mpm_basis::Connectivity;
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_linear::{Matrix, Symmetry};
use null_space::Triangle;
use parts::RigidParts;

/// Part of the stiffness around it that holds a node against a motion, below which nothing does: what a factorisation
/// can tell from rounding.
const HELD: f64 = 1e-11;

/// Free motions that are looked at; a body that has fallen into more parts is told by the first of them.
const MOST_MODES: usize = 60;

/// The parts of all bodies in a load step, and the motions that supports leave free.
pub(crate) struct FreeMotions<const D: usize> {
    parts: RigidParts,
    positions: Vec<Vector<D>>,
    modes: Vec<Mode>,
}

/// Motions that nothing holds.
#[derive(Default)]
pub(crate) struct Unheld<const D: usize> {
    /// What moves, and how.
    pub clauses: Vec<String>,
    /// Displacement of every active node in each of them, the largest of size 1.
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
        let nodes = connected.active.nodes().iter();
        let positions: Vec<Vector<D>> = nodes.map(|&node| model.nodes.position(mesh, node)).collect();
        let parts = RigidParts::of(&bodies, &positions, model.coordinates());
        // The hoop resists every motion along r.
        let is_ring = model.space().is_axisymmetric();
        let is_held = |node: usize, i: usize| is_ring && i == 0 || constraints.is_prescribed(node, i);
        let mut modes = Vec::new();
        let frames = Frames::of(&parts, &positions);
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
        let frames = Frames::of(&self.parts, &self.positions);
        let n = self.modes.len();
        let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
        let modes = frames.combine(&self.modes, &(0..n).map(unit).collect::<Vec<_>>());

        let unknowns = connected.unknowns();
        let image = |mode: &Mode| {
            let mut field = vec![0.0; unknowns.n_equations()];
            for (node, u) in frames.field(mode).iter().enumerate() {
                for i in (0..D).filter(|&i| !constraints.is_prescribed(node, i)) {
                    field[unknowns.displacement(node, i).equation()] = u[i];
                }
            }
            let values = if turns(mode) { Some(&tangent) } else { besides.as_ref() };
            match values {
                Some(values) => Matrix { pattern: connected.pattern.for_solver(), values }.times(&field),
                None => vec![0.0; field.len()],
            }
        };
        let images: Vec<Vec<f64>> = modes.iter().map(image).collect();
        let sizes = row_sums(Matrix { pattern: connected.pattern.for_solver(), values: &tangent });
        let mut triangle = Triangle::new(modes.len());
        for (equation, &size) in sizes.iter().enumerate() {
            if size > 0.0 && !constraints.is_held(unknowns, equation) {
                let mut row: Vec<f64> = images.iter().map(|image| image[equation] / size).collect();
                triangle.add(&mut row);
            }
        }
        let unheld = frames.combine(&modes, &triangle.null_space(HELD));
        (!unheld.is_empty()).then(|| Unheld {
            clauses: naming::clauses(&frames, &model.bodies, &unheld),
            fields: unheld.iter().map(|mode| scaled(frames.field(mode))).collect(),
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
    for contribution in contributions {
        contribution.add(&trial, &mut sums).ok()?;
    }
    finish_tangent(pattern, constraints, &mut values);
    Some(values)
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

/// A field whose largest component is 1 in size.
fn scaled<const D: usize>(mut field: Vec<Vector<D>>) -> Vec<Vector<D>> {
    let largest = field.iter().map(|u| u.amax()).fold(0.0, f64::max);
    field.iter_mut().for_each(|u| *u /= largest);
    field
}
