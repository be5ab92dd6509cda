//! Rigid motions that nothing holds, found before the first factorisation of a tangent that they make singular.
//!
//! Nodes in a motion `t + ω × x` strain no material point, whatever its law. Such a motion is *free* where it moves no
//! node in a component that a support prescribes; that is a small dense question for each part that is connected. What
//! else may hold a free motion (a spring, a tool, ghost faces between two bodies, the stress of a body that hangs) is
//! asked of the tangent K of all contributions: a combination m of free motions is *unheld* where K m = 0 to rounding.

mod modes;
mod naming;
mod null_space;
mod parts;
pub(crate) mod rest;

use crate::connection::{Connected, contributions};
use crate::model::Model;
use mpm_assembly::{Constraints, SystemSums, SystemTangent, Trial, UnknownVector, finish_tangent};
use mpm_basis::Connectivity;
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_linear::{Matrix, Symmetry};
use modes::{Frames, Mode};
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
        let parts = RigidParts::of(&bodies, &positions);
        let mut modes = Vec::new();
        let frames = Frames::of(&parts, &positions);
        for assembly in &parts.assemblies {
            modes.extend(frames.free(assembly, |node, component| constraints.is_prescribed(node, component)));
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

    /// The free motions that the tangent does not hold either; none if it holds them all.
    pub(crate) fn unheld(
        &self,
        model: &Model<D>,
        connected: &Connected<D>,
        constraints: &Constraints<D>,
        tangent: &[f64],
    ) -> Option<Unheld<D>> {
        let frames = Frames::of(&self.parts, &self.positions);
        let fields: Vec<Vec<Vector<D>>> = self.modes.iter().map(|mode| frames.field(mode)).collect();
        let matrix = Matrix { pattern: connected.pattern.for_solver(), values: tangent };
        let coefficients = null_combinations(matrix, connected, constraints, &fields);
        let unheld = frames.combine(&self.modes, &coefficients);
        if unheld.is_empty() {
            return None;
        }
        let fields = unheld.iter().map(|mode| scaled(frames.field(mode))).collect();
        let turns = |mode: &&Mode| mode.values().any(|motion| motion.rotation != [0.0; 3]);
        Some(Unheld {
            clauses: naming::clauses(&frames, &model.bodies, &unheld),
            fields,
            translations: unheld.len() - unheld.iter().filter(turns).count(),
        })
    }
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
    let pattern = &connected.pattern;
    let mut values = vec![0.0; pattern.n_entries()];
    let increment = UnknownVector::zeros(connected.unknowns());
    let mut force = increment.clone();
    let tangent = Some(SystemTangent { values: &mut values, lift: None });
    let mut sums = SystemSums { force: &mut force, tangent, smallest_determinant: f64::INFINITY };
    let start = LoadFraction::START;
    let trial = Trial { pattern, constraints, increment: &increment, end: start, is_first: true };
    let bodies = connected.bodies(&model.bodies);
    for contribution in contributions(&bodies, &model.contributions) {
        if contribution.add(&trial, &mut sums).is_err() {
            return Vec::new();
        }
    }
    finish_tangent(pattern, constraints, &mut values);
    free.unheld(model, connected, constraints, &values).map_or(Vec::new(), |unheld| unheld.clauses)
}

/// Coefficients of the combinations of nodal fields that K maps to 0.
fn null_combinations<const D: usize>(
    matrix: Matrix<'_>,
    connected: &Connected<D>,
    constraints: &Constraints<D>,
    fields: &[Vec<Vector<D>>],
) -> Vec<Vec<f64>> {
    let unknowns = connected.unknowns();
    let sizes = row_sums(matrix);
    let images: Vec<Vec<f64>> = fields
        .iter()
        .map(|field| {
            let mut vector = vec![0.0; sizes.len()];
            for (node, u) in field.iter().enumerate() {
                for i in (0..D).filter(|&i| !constraints.is_prescribed(node, i)) {
                    vector[unknowns.displacement(node, i).equation()] = u[i];
                }
            }
            matrix.times(&vector)
        })
        .collect();
    let mut triangle = Triangle::new(fields.len());
    for (equation, &size) in sizes.iter().enumerate() {
        if size > 0.0 && !constraints.is_held(unknowns, equation) {
            let mut row: Vec<f64> = images.iter().map(|image| image[equation] / size).collect();
            triangle.add(&mut row);
        }
    }
    triangle.null_space(HELD)
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
