//! The equations of a load step: out-of-balance force and tangent of a trial displacement.

use crate::connection::{Connected, Ghost};
use crate::error::StepFailure;
use crate::model::{NamedBody, Tolerance};
use crate::timing::{Phase, Timings};
use mpm_assembly::{Constraints, InvertedPoint, PassInput, Sums, TangentSums, finish_tangent};
use mpm_grid::{Mesh, NodeId, Vector};
use mpm_linear::Method;

/// Everything that stays fixed while one load step is balanced.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a, const D: usize> {
    pub bodies: &'a [NamedBody<D>],
    /// The mesh at the start of the step.
    pub mesh: &'a Mesh<D>,
    pub connected: &'a Connected<D>,
    pub constraints: &'a Constraints<D>,
    /// `f_ext` of every active node `[F]`.
    pub external: &'a [Vector<D>],
    /// Out-of-balance force that rounding alone can cause `[F]`.
    pub round_off: f64,
    pub tolerance: Tolerance,
}

/// A trial displacement, its forces, and what has been spent on it.
#[derive(Clone)]
pub(crate) struct Iterate<const D: usize> {
    /// `Δu_v` of every active node `[L]`.
    pub increment: Vec<Vector<D>>,
    /// `f_int - f_ext` `[F]`.
    pub reaction: Vec<Vector<D>>,
    /// `f_ext - f_int`, zero on prescribed components `[F]`.
    pub out_of_balance: Vec<Vector<D>>,
    /// Smallest `det ΔF` of any point.
    pub smallest_determinant: f64,
    pub effort: Effort,
}

/// Nodal displacement that balances the forces of a load step.
pub(crate) struct Equilibrium<const D: usize> {
    /// `Δu_v` of every active node `[L]`.
    pub increment: Vec<Vector<D>>,
    /// `f_int - f_ext`: on prescribed components the reaction `[F]`.
    pub reaction: Vec<Vector<D>>,
    /// Smallest `det ΔF` of any point.
    pub smallest_determinant: f64,
    pub effort: Effort,
}

/// What it takes to balance a load step, and how well its linear systems are solved.
#[derive(Clone)]
pub(crate) struct Effort {
    /// Relative out-of-balance force after each linear solution.
    pub residuals: Vec<f64>,
    /// The most general factorisation that was needed.
    pub method: Method,
    /// Iterations of conjugate gradients.
    pub linear_iterations: u64,
    /// Corrections of which only a part was taken.
    pub shortened: u32,
    /// Number of linear solves spent on a predictor that was discarded; not counted in `residuals`.
    pub dropped: u64,
    /// Parts in which relaxation balanced the step; 0 where it was balanced at once.
    pub relaxations: u32,
    /// Node at which LLᵀ last met a pivot that was not positive.
    pub unstable_node: Option<NodeId>,
    /// Largest backward error of a linear solution.
    pub backward_error: f64,
    /// Steps of iterative refinement of linear solutions, in all.
    pub refinements: u32,
    /// Largest ratio of the pivots of a factorisation; the condition number is as large or larger. 0: no pivots.
    pub pivot_spread: f64,
}

impl<const D: usize> Iterate<D> {
    /// No node of `n` has moved, and linear systems will be solved by `method` until it fails.
    pub(crate) fn at_rest(n: usize, method: Method) -> Self {
        let effort = Effort {
            residuals: Vec::new(),
            method,
            linear_iterations: 0,
            shortened: 0,
            dropped: 0,
            relaxations: 0,
            unstable_node: None,
            backward_error: 0.0,
            refinements: 0,
            pivot_spread: 0.0,
        };
        Self {
            increment: vec![Vector::zeros(); n],
            reaction: vec![Vector::zeros(); n],
            out_of_balance: vec![Vector::zeros(); n],
            smallest_determinant: f64::INFINITY,
            effort,
        }
    }

    /// The iterate as the step's equilibrium, once it is balanced.
    pub(crate) fn into_equilibrium(self) -> Equilibrium<D> {
        let Self { increment, reaction, smallest_determinant, effort, .. } = self;
        Equilibrium { increment, reaction, smallest_determinant, effort }
    }
}

/// Whether a pass over the points also sums the tangent.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    Force,
    ForceAndTangent,
}

/// What a pass with a tangent writes to besides the iterate; untouched by a pass without.
pub(crate) struct TangentTarget<'a, const D: usize> {
    /// Entries of the tangent K.
    pub values: &'a mut [f64],
    /// The product of K and the prescribed increments `[F]`; not wanted where empty.
    pub lift: &'a mut [Vector<D>],
}

impl<const D: usize> Problem<'_, D> {
    /// Nodes that carry material.
    pub(crate) fn n_nodes(&self) -> usize {
        self.connected.active.len()
    }

    /// Sets the forces of the iterate (and the tangent) under its increment.
    ///
    /// # Errors
    /// The increment inverts a point; the forces are then undefined.
    pub(crate) fn evaluate(
        &self,
        iterate: &mut Iterate<D>,
        wanted: Wanted,
        target: TangentTarget<'_, D>,
        timings: &mut Timings,
    ) -> Result<(), StepFailure> {
        let TangentTarget { values, lift } = target;
        let phase = match wanted {
            Wanted::Force => Phase::Stress,
            Wanted::ForceAndTangent => Phase::Assemble,
        };
        for named in self.bodies {
            timings.skipped.count_pass(&*named.body);
        }
        let Connected { connections, pattern, ghost, .. } = self.connected;
        timings.time(phase, || {
            iterate.smallest_determinant = f64::INFINITY;
            iterate.reaction.fill(Vector::zeros());
            if wanted == Wanted::ForceAndTangent {
                values.fill(0.0);
            }
            let input = PassInput { pattern, constraints: self.constraints, increment: &iterate.increment };
            for (named, connection) in self.bodies.iter().zip(connections) {
                let sums = sums(wanted, &mut iterate.reaction, values, lift);
                let determinant =
                    named.body.assemble(connection, input, sums).map_err(|it| inverted(named, it))?;
                iterate.smallest_determinant = iterate.smallest_determinant.min(determinant);
            }
            if let Some(Ghost { faces, slots }) = ghost {
                faces.assemble(slots, input, sums(wanted, &mut iterate.reaction, values, lift));
            }
            if wanted == Wanted::ForceAndTangent {
                finish_tangent(pattern, self.constraints, values);
            }
            // Internal force becomes f_int - f_ext; its free components must vanish.
            for (v, (reaction, external)) in iterate.reaction.iter_mut().zip(self.external).enumerate() {
                *reaction -= external;
                iterate.out_of_balance[v] = -*reaction;
            }
            self.constraints.free_part(&mut iterate.out_of_balance);
            Ok(())
        })
    }

    /// `|f_oob| / (|f_ext| + |f_reaction|)`.
    pub(crate) fn residual(&self, iterate: &Iterate<D>) -> f64 {
        let mut supported = 0.0;
        for (v, force) in iterate.reaction.iter().enumerate() {
            for i in (0..D).filter(|&i| self.constraints.is_prescribed(v, i)) {
                supported += force[i] * force[i];
            }
        }
        let scale = norm(self.external) + f64::sqrt(supported);
        let force = norm(&iterate.out_of_balance);
        if force == 0.0 { 0.0 } else { force / scale }
    }

    /// Whether what is out of balance is no more than rounding.
    pub(crate) fn is_rounding(&self, iterate: &Iterate<D>) -> bool {
        norm(&iterate.out_of_balance) <= self.round_off
    }

    /// Whether what is out of balance is small against the forces, or no more than rounding.
    pub(crate) fn is_balanced(&self, iterate: &Iterate<D>) -> bool {
        self.is_rounding(iterate) || self.residual(iterate) < self.tolerance.residual
    }
}

fn norm<const D: usize>(field: &[Vector<D>]) -> f64 {
    field.iter().map(|x| x.norm_squared()).sum::<f64>().sqrt()
}

/// Sum of the scalar products, node by node.
pub(crate) fn dot<const D: usize>(a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// What a pass adds to; no lift where `lift` is empty.
fn sums<'a, const D: usize>(
    wanted: Wanted,
    internal: &'a mut [Vector<D>],
    values: &'a mut [f64],
    lift: &'a mut [Vector<D>],
) -> Sums<'a, D> {
    let lift = if lift.is_empty() { None } else { Some(lift) };
    let tangent = TangentSums { values, lift };
    Sums { internal, tangent: (wanted == Wanted::ForceAndTangent).then_some(tangent) }
}

/// The failure of a trial that inverts a point.
pub(crate) fn inverted<const D: usize>(named: &NamedBody<D>, it: InvertedPoint) -> StepFailure {
    StepFailure::Inverted {
        body: named.name.clone(),
        basis: named.body.basis(),
        point: it.point,
        position: named.body.point(it.point).position.iter().copied().collect(),
        determinant: it.determinant,
    }
}
