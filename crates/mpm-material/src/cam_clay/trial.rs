//! A trial state before the yield ellipse, and answers to it, of one point or of four.

use super::elastic::Elastic;
use super::parameters::Constants;
use super::return_map::{Equations, Returned};
use crate::PrincipalUpdate;
use crate::deviator::Deviator;
use crate::lanes::Number;
use crate::law::YIELD_TOLERANCE;

/// A trial state, or four.
pub(super) struct Trial<T: Number> {
    split: Deviator<T>,
    pub state: Elastic<T>,
    pub yields: T::Mask,
}

impl<T: Number> Trial<T> {
    /// Of principal strains, p_c being `before` [F/L²].
    #[inline(always)]
    pub fn of(constants: &Constants<T>, strain: &[T; 3], before: T) -> Self {
        let split = Deviator::of(strain);
        let state = constants.skeleton.at(split.volumetric, split.shear());
        // By the largest stress, because squares of trial pressures may overflow; what then is no number
        // has yielded, unless the strains are none.
        let scale = T::of(1.0) / state.p.zip(state.q, f64::max).zip(before, f64::max);
        let (p, along) = (scale * state.p, scale * state.q / constants.critical_ratio);
        let overshoot = along * along + p * (p - scale * before);
        let is_elastic = overshoot.compare(T::of(YIELD_TOLERANCE), |f, tolerance| f <= tolerance);
        let yields = !is_elastic & split.volumetric.absolute().below(T::of(f64::INFINITY));
        Self { split, state, yields }
    }

    /// What returns it, p_c being `before` [F/L²].
    #[inline(always)]
    pub fn equations(&self, constants: &Constants<T>, before: T) -> Equations<T> {
        Equations::new(constants, (self.split.volumetric, self.split.shear()), before)
    }

    /// The answer where it does not yield.
    #[inline(always)]
    pub fn elastic(&self, strain: &[T; 3]) -> PrincipalUpdate<T> {
        let Self { split, state, .. } = self;
        let secant = T::of(2.0) * state.shear_modulus;
        PrincipalUpdate {
            elastic_strain: *strain,
            kirchhoff: split.stresses(state.p, state.q),
            tangent: split.tangent(&state.derivative, secant),
            secant: [secant; 3],
        }
    }

    /// The answer where it is returned.
    #[inline(always)]
    pub fn plastic(&self, returned: &Returned<T>) -> PrincipalUpdate<T> {
        let Returned { stress: (p, q), shear_modulus, volumetric, beta, ref derivative, .. } = *returned;
        let split = &self.split;
        let secant = T::of(2.0) * shear_modulus * beta;
        PrincipalUpdate {
            elastic_strain: split.strains(volumetric, beta),
            kirchhoff: split.stresses(p, q),
            tangent: split.tangent(derivative, secant),
            secant: [secant; 3],
        }
    }
}
