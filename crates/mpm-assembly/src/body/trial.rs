//! State of one point under a trial displacement.

use crate::body::kinematics::{StepGradient, inverse_and_determinant};
use crate::body::points::Points;
use mpm_grid::Block;
use mpm_material::{Material, NoReturn, Response, SymmetricTensor, log_strain, respond};

/// A point that has no admissible state under a trial displacement.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("material point {point} {reason}")]
pub struct InadmissiblePoint {
    /// Index of the point in its body.
    pub point: usize,
    /// Why there is none.
    pub reason: InadmissibleState,
}

/// Why a point has no admissible state.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InadmissibleState {
    /// The trial displacement turns it inside out.
    #[error("would be inverted (det ΔF = {determinant:e})")]
    Inverted {
        /// `det ΔF` of the trial; not a number where the trial itself was not finite.
        determinant: f64,
    },
    /// The trial displacement takes it across the axis of its body of revolution.
    #[error("would reach the axis (hoop stretch {hoop:e})")]
    ReachesAxis {
        /// `ΔF_θθ` of the trial; not a number where the trial itself was not finite.
        hoop: f64,
    },
    /// Its law finds no stress.
    #[error("has no stress: {0}")]
    NoReturn(NoReturn),
}

impl InadmissiblePoint {
    /// The trial displacement turns `point` inside out.
    pub(crate) fn inverted(point: usize, determinant: f64) -> Self {
        Self { point, reason: InadmissibleState::Inverted { determinant } }
    }

    /// The trial displacement takes `point` across the axis.
    pub(crate) fn reaches_axis(point: usize, hoop: f64) -> Self {
        Self { point, reason: InadmissibleState::ReachesAxis { hoop } }
    }

    /// The law finds no stress for `point`.
    pub(crate) fn no_return(point: usize, reason: NoReturn) -> Self {
        Self { point, reason: InadmissibleState::NoReturn(reason) }
    }
}

/// Points at the start of a load step, and their law.
pub(crate) struct Committed<'a, const D: usize, M: Material> {
    pub law: &'a M,
    pub points: &'a Points<D>,
    /// What the law remembers of each point; zero bytes for elasticity.
    pub history: &'a [M::History],
}

// Derived `Clone` would ask for `M: Clone`.
impl<const D: usize, M: Material> Clone for Committed<'_, D, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<const D: usize, M: Material> Copy for Committed<'_, D, M> {}

/// State of one point under a trial displacement: a pure function of its committed state.
pub(crate) struct Trial<const D: usize, H> {
    /// `ΔF_θθ`; 1 where there is no hoop.
    pub hoop: f64,
    /// The inverse of `ΔF`, of a body of revolution of its in-plane part.
    pub inverse: Block<D>,
    pub response: Response<H>,
}

/// Kinematics and law of point `p` under a displacement gradient.
#[inline(always)]
pub(crate) fn trial_of<const D: usize, M: Material, const HOOP: bool>(
    committed: Committed<'_, D, M>,
    p: usize,
    h: &StepGradient<D>,
) -> Result<Trial<D, M::History>, InadmissiblePoint> {
    let StepOf { hoop, inverse, .. } = step_of::<D, HOOP>(p, h)?;
    let Committed { law, points, history } = committed;
    let response = respond(law, &h.trial_excess::<HOOP>(&points.elastic_excess[p]), &history[p])
        .map_err(|reason| InadmissiblePoint::no_return(p, reason))?;
    Ok(Trial { hoop, inverse, response })
}

/// ΔF of a load step, see [`Trial`].
pub(crate) struct StepOf<const D: usize> {
    pub step: Block<D>,
    pub hoop: f64,
    pub inverse: Block<D>,
    pub determinant: f64,
}

/// ΔF of point `p` from `ΔF - I`.
///
/// # Errors
/// The point is turned inside out, or taken across the axis: each by itself, because two changes of sign make a
/// positive determinant.
#[inline(always)]
pub(crate) fn step_of<const D: usize, const HOOP: bool>(
    p: usize,
    h: &StepGradient<D>,
) -> Result<StepOf<D>, InadmissiblePoint> {
    let step = Block::identity() + h.block;
    let (inverse, mut determinant) = inverse_and_determinant(&step);
    // Written so that a trial that is not a number is refused as well.
    let hoop = 1.0 + h.hoop;
    if HOOP && D == 3 && !(hoop > 0.0 && hoop.is_finite()) {
        return Err(InadmissiblePoint::reaches_axis(p, hoop));
    }
    if !(determinant > 0.0 && determinant.is_finite()) {
        return Err(InadmissiblePoint::inverted(p, determinant));
    }
    if HOOP && D == 2 {
        if !(hoop > 0.0 && hoop.is_finite()) {
            return Err(InadmissiblePoint::reaches_axis(p, hoop));
        }
        determinant *= hoop;
    }
    Ok(StepOf { step, hoop, inverse, determinant })
}

/// τ' : (ε_tr - ε_e) of a point that yields, per reference volume `[F/L²]`.
pub(crate) fn dissipated<M: Material>(
    law: &M,
    trial: &SymmetricTensor,
    response: &Response<M::History>,
) -> f64 {
    let (before, after) = (log_strain(trial), log_strain(&response.elastic_excess));
    let flow = before.to_matrix() - after.to_matrix();
    let fluid = law.fluid_stress(after.trace(), &response.history);
    response.kirchhoff.to_matrix().dot(&flow) - fluid * flow.trace()
}
