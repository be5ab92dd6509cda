//! Loads and prescribed displacements as functions of the load fraction, with their derivatives.

use crate::error::{PathFailure, StepFailure};
use mpm_assembly::Constraints;
use mpm_grid::{LoadFraction, Vector};

/// Half the difference of load fractions over which loading is differentiated.
const HALF_DIFFERENCE: f64 = 1e-5;

/// Prescribed increments and external forces at a load fraction.
pub(crate) type LoadingAt<'a, const D: usize> =
    dyn Fn(LoadFraction) -> Result<(Constraints<D>, Vec<Vector<D>>), StepFailure> + 'a;

/// Loading at a load fraction and its derivative.
pub(super) struct Loading<const D: usize> {
    /// `ū` over the step `[L]`.
    pub(super) prescribed: Vec<Vector<D>>,
    /// `∂ū/∂t` `[L]`, as the increments of constraints.
    pub(super) rates: Constraints<D>,
    /// `f_ext` `[F]`.
    pub(super) external: Vec<Vector<D>>,
    /// `∂f_ext/∂t` `[F]`.
    pub(super) external_rate: Vec<Vector<D>>,
}

/// Loading at a load fraction; beyond 0 and 1 it goes on in a straight line.
pub(super) fn loading<const D: usize>(loading: &LoadingAt<'_, D>, at: f64) -> Result<Loading<D>, StepFailure> {
    if !at.is_finite() {
        return Err(StepFailure::Path(PathFailure::Leaves { fraction: at }));
    }
    let fraction = |value: f64| LoadFraction::new(value.clamp(0.0, 1.0)).expect("clamped");
    let here = fraction(at);
    let (before, after) = (fraction(here.get() - HALF_DIFFERENCE), fraction(here.get() + HALF_DIFFERENCE));
    let (constraints, mut external) = loading(here)?;
    let (low, low_force) = loading(before)?;
    let (high, high_force) = loading(after)?;
    let (span, beyond) = (after.get() - before.get(), at - here.get());

    let mut prescribed = constraints.increment().to_vec();
    let mut rates = Constraints::none(constraints.n_nodes());
    for (v, prescribed) in prescribed.iter_mut().enumerate() {
        for i in (0..D).filter(|&i| constraints.is_prescribed(v, i)) {
            let rate = (high.increment()[v][i] - low.increment()[v][i]) / span;
            rates.prescribe(v, i, rate);
            prescribed[i] += rate * beyond;
        }
    }
    let external_rate: Vec<Vector<D>> =
        low_force.iter().zip(&high_force).map(|(low, high)| (high - low) / span).collect();
    for (force, rate) in external.iter_mut().zip(&external_rate) {
        *force += rate * beyond;
    }
    Ok(Loading { prescribed, rates, external, external_rate })
}

/// Sets the components that are prescribed at a load fraction.
pub(super) fn impose_at<const D: usize>(
    at: &LoadingAt<'_, D>,
    end: f64,
    increment: &mut [Vector<D>],
) -> Result<(), StepFailure> {
    let loading = loading(at, end)?;
    impose(&loading.rates, &loading.prescribed, increment);
    Ok(())
}

/// Sets the prescribed components.
pub(super) fn impose<const D: usize>(
    constraints: &Constraints<D>,
    prescribed: &[Vector<D>],
    increment: &mut [Vector<D>],
) {
    constraints.free_part(increment);
    for (increment, prescribed) in increment.iter_mut().zip(prescribed) {
        *increment += prescribed;
    }
}
