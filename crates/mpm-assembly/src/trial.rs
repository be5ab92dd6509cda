//! A trial solution of a load step, and the sums of forces and tangent under it.

use crate::body::{PassInput, Sums, TangentSums};
use crate::sharing::Scale;
use crate::unknowns::{Constraints, SparsityPattern, UnknownId, UnknownVector, Unknowns};
use mpm_grid::{Block, LoadFraction, Vector};

/// A trial solution of a load step.
#[derive(Clone, Copy)]
pub struct Trial<'a, const D: usize> {
    /// Where entries of the tangent are stored.
    pub pattern: &'a SparsityPattern<D>,
    /// Prescribed components of displacement.
    pub constraints: &'a Constraints<D>,
    /// `Δu` of the active nodes `[L]`, and the other unknowns.
    pub increment: &'a UnknownVector<D>,
    /// Load fraction at the end of the step.
    pub end: LoadFraction,
    /// Whether nothing has moved yet: the first trial of an iteration from rest. Contact predicts sticking there.
    pub is_first: bool,
}

impl<'a, const D: usize> Trial<'a, D> {
    /// What a pass over points reads.
    pub fn input(&self) -> PassInput<'a, D> {
        let UnknownVector { nodes, own } = self.increment;
        PassInput { pattern: self.pattern, constraints: self.constraints, increment: nodes, own }
    }
}

/// What contributions add to: internal forces, and where it is wanted the tangent.
pub struct SystemSums<'a, const D: usize> {
    /// `fⁱⁿᵗ` of every active node `[F]`, and the residuals of the other unknowns.
    pub force: &'a mut UnknownVector<D>,
    /// The tangent.
    pub tangent: Option<SystemTangent<'a, D>>,
    /// Smallest `det ΔF` of any point so far.
    pub smallest_determinant: f64,
    /// The [scale](crate::Contribution::scale) of the contribution that adds, where it knows that by then: it is not asked again.
    pub scale: Option<Scale<D>>,
}

/// Entries of the tangent, and optionally its product with prescribed increments.
pub struct SystemTangent<'a, const D: usize> {
    /// One value per entry of the [`SparsityPattern`].
    pub values: &'a mut [f64],
    /// The tangent times the prescribed increments, where asked for.
    pub lift: Option<&'a mut UnknownVector<D>>,
}

impl<'a, const D: usize> SystemSums<'a, D> {
    /// Nothing has been added yet.
    pub fn new(force: &'a mut UnknownVector<D>, tangent: Option<SystemTangent<'a, D>>) -> Self {
        Self { force, tangent, smallest_determinant: f64::INFINITY, scale: None }
    }
}

impl<const D: usize> SystemSums<'_, D> {
    /// What passes over points add to.
    pub fn sums(&mut self) -> Sums<'_, D> {
        let tangent = self.tangent.as_mut().map(|SystemTangent { values, lift }| {
            let (lift, own_lift) = match lift {
                Some(UnknownVector { nodes, own }) => (Some(&mut nodes[..]), &mut own[..]),
                None => (None, Default::default()),
            };
            TangentSums { values, lift, own_lift }
        });
        let UnknownVector { nodes, own } = &mut *self.force;
        Sums { internal: nodes, own, tangent }
    }

    /// Whether a tangent is wanted.
    pub fn wants_tangent(&self) -> bool {
        self.tangent.is_some()
    }

    /// Adds the force on some unknowns, and where a tangent is wanted its derivative `stiffness` with respect to them:
    /// a dense matrix, column by column. Prescribed components are left out of the tangent here.
    ///
    /// # Panics
    /// If a tangent is wanted and the unknowns are of places that no contribution couples.
    pub fn add(&mut self, trial: &Trial<'_, D>, unknowns: &[UnknownId], force: &[f64], stiffness: &[f64]) {
        let numbering = trial.pattern.unknowns();
        for (&unknown, &force) in unknowns.iter().zip(force) {
            *entry(self.force, numbering, unknown) += force;
        }
        let Some(tangent) = &mut self.tangent else { return };
        trial.pattern.add_dense(unknowns, stiffness, trial.constraints, tangent.values);
        let Some(lift) = &mut tangent.lift else { return };
        for (column, &unknown) in unknowns.iter().enumerate() {
            let Some((node, component)) = numbering.node_of(unknown.equation()) else { continue };
            let prescribed = trial.constraints.increment()[node][component];
            if prescribed != 0.0 {
                for (row, &other) in unknowns.iter().enumerate() {
                    *entry(lift, numbering, other) += stiffness[column * unknowns.len() + row] * prescribed;
                }
            }
        }
    }
}

impl<const D: usize> SystemSums<'_, D> {
    /// Adds the internal force `-W_v F` of a point that nodes carry with the weights `W_v`, on which the force F acts, and
    /// where a tangent is wanted `W_v W_w k` with `k = -∂F/∂x`. Of a symmetric tangent the lower triangle of k is taken.
    ///
    /// # Panics
    /// If a tangent is wanted and no contribution couples the nodes.
    pub fn add_carried(
        &mut self,
        trial: &Trial<'_, D>,
        carriers: &[(u32, f64)],
        force: &Vector<D>,
        block: Option<&Block<D>>,
    ) {
        for &(node, weight) in carriers {
            for i in 0..D {
                self.force.nodes[node as usize][i] += -force[i] * weight;
            }
        }
        let (Some(tangent), Some(block)) = (&mut self.tangent, block) else { return };
        trial.pattern.add_carried(carriers, block, trial.constraints, tangent.values);
        let Some(lift) = &mut tangent.lift else { return };
        for &(column, w) in carriers {
            let prescribed = trial.constraints.increment()[column as usize];
            for j in (0..D).filter(|&j| prescribed[j] != 0.0) {
                for &(row, v) in carriers {
                    for i in 0..D {
                        lift.nodes[row as usize][i] += v * w * block[(i, j)] * prescribed[j];
                    }
                }
            }
        }
    }
}

/// The number of an unknown.
fn entry<'a, const D: usize>(
    vector: &'a mut UnknownVector<D>,
    numbering: &Unknowns<D>,
    unknown: UnknownId,
) -> &'a mut f64 {
    match numbering.node_of(unknown.equation()) {
        Some((node, component)) => &mut vector.nodes[node][component],
        None => &mut vector.own[unknown.equation() - numbering.displacement(numbering.n_nodes(), 0).equation()],
    }
}
