//! What a point answers to a trial elastic state: principal axes before the law is asked, tensors after it.

use nalgebra::Vector3;

use crate::elementary::{exp_m1, ln_1p};
use crate::lanes::{Lanes, Number};
use crate::spectral::{Frame, Spectrum};
use crate::{Material, NoReturn, PointParameters, PrincipalTangent, PrincipalUpdate, SymmetricTensor, Update};

/// Answer of a point to a trial elastic state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Response<H> {
    /// Kirchhoff stress τ = J σ [F/L²].
    pub kirchhoff: SymmetricTensor,
    /// Elastic excess b_e − I after the update [-].
    pub elastic_excess: SymmetricTensor,
    /// Whether the point yielded.
    pub plastic: bool,
    /// What the point remembers from here on.
    pub history: H,
    /// Principal axes and moduli, from which the spatial tangent is made when it is wanted.
    pub tangent: PrincipalTangent,
}

/// Answers the trial elastic state b_eᵗʳ = ΔF b_e ΔFᵀ, given by its excess
/// `trial_excess` = b_eᵗʳ − I.
///
/// The principal values c_a of the excess give εᵗʳ_a = ½ ln(1 + c_a); what yields is returned to
/// b_e = exp(2 ε_e) in the axes of the trial state. An elastic point keeps its trial excess, bit
/// for bit. States with `yz == zx == 0` take a closed-form path about ten times faster than the
/// general one.
///
/// Where b_eᵗʳ is not positive definite, or not finite, every component of the stress is NaN (but
/// for yz and zx of a plane state, always zero). The caller, who knows det ΔF, should refuse such
/// a state before asking.
///
/// # Errors
/// What the law's [`Material::update`] says.
// Always inlined: a pass that wants stresses only then pays for nothing that `tangent` holds.
#[inline(always)]
pub fn respond<M: Material>(
    law: &M,
    trial_excess: &SymmetricTensor,
    history: &M::History,
) -> Result<Response<M::History>, NoReturn> {
    let trial = PrincipalTrial::of(Spectrum::of(trial_excess));
    let update = law.update(&trial.strain.into(), history)?;
    Ok(trial.response(update, trial_excess))
}

/// A trial state in its principal axes, or four: what [`respond`] does before and after it asks the law.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PrincipalTrial<T = f64> {
    pub(crate) frame: Frame<T>,
    /// Principal excess.
    values: [T; 3],
    /// Principal logarithmic strains [-].
    pub strain: [T; 3],
}

impl PrincipalTrial<Lanes> {
    /// Of four trial excesses of which z is a principal direction.
    #[inline(always)]
    pub fn in_plane(trial_excess: &SymmetricTensor<Lanes>) -> Self {
        Self::of(Spectrum::plane(trial_excess))
    }

    /// Of several times four trial excesses (one at least) of which z is a principal direction nowhere.
    #[inline(always)]
    pub fn in_space<const N: usize>(trial_excesses: [&SymmetricTensor<Lanes>; N]) -> [Self; N] {
        const { assert!(N > 0, "of one tensor at least") };
        let spectra = Spectrum::of_several(trial_excesses);
        let mut trials = [Self::of(spectra[0]); N];
        for (trial, spectrum) in trials.iter_mut().zip(spectra).skip(1) {
            *trial = Self::of(spectrum);
        }
        trials
    }

    /// Whether z is a principal direction of four trial excesses; none where it is so of some of them only, which then have
    /// to be taken apart.
    #[inline(always)]
    pub fn is_plane(trial_excess: &SymmetricTensor<Lanes>) -> Option<bool> {
        let is_zero = |x: Lanes| x.compare(Lanes::ZERO, |x, zero| x == zero);
        let is_plane = is_zero(trial_excess.yz) & is_zero(trial_excess.zx);
        if Lanes::all(is_plane) {
            return Some(true);
        }
        (!Lanes::any(is_plane)).then_some(false)
    }
}

impl<T: Number> PrincipalTrial<T> {
    #[inline(always)]
    pub(crate) fn of(Spectrum { values, frame }: Spectrum<T>) -> Self {
        Self { frame, values, strain: log_strains(&values) }
    }

    /// The tensor of principal Kirchhoff stresses [F/L²].
    #[inline(always)]
    pub fn stress(&self, kirchhoff: &[T; 3]) -> SymmetricTensor<T> {
        self.frame.compose(kirchhoff)
    }

    /// Elastic excess b_e − I with the elastic strains after an update [-].
    #[inline(always)]
    pub fn elastic_excess(&self, elastic_strain: &[T; 3]) -> SymmetricTensor<T> {
        let mut excess = *elastic_strain;
        for value in &mut excess {
            *value = exp_m1(T::of(2.0) * *value);
        }
        self.frame.compose(&excess)
    }

    /// Principal axes and moduli of an update, from which the spatial tangent is made.
    #[inline(always)]
    pub fn tangent(&self, update: &PrincipalUpdate<T>) -> PrincipalTangent<T> {
        let Self { frame, values, strain } = *self;
        let PrincipalUpdate { kirchhoff, tangent, secant, .. } = *update;
        PrincipalTangent { frame, excess: values, strain, kirchhoff, tangent, secant }
    }
}

impl PrincipalTrial {
    /// An update in principal axes as the answer of the point.
    #[inline(always)]
    pub(crate) fn response<H>(&self, update: Update<H>, trial_excess: &SymmetricTensor) -> Response<H> {
        let principal = PrincipalUpdate {
            elastic_strain: update.elastic_strain.into(),
            kirchhoff: update.kirchhoff.into(),
            tangent: update.tangent.transpose().into(),
            secant: update.secant.into(),
        };
        Response {
            kirchhoff: self.stress(&principal.kirchhoff),
            elastic_excess: if update.plastic {
                self.elastic_excess(&principal.elastic_strain)
            } else {
                *trial_excess
            },
            plastic: update.plastic,
            history: update.history,
            tangent: self.tangent(&principal),
        }
    }
}

/// Elastic logarithmic strain ε_e = ½ ln b_e [-] from the excess b_e − I; NaN where b_e is not
/// positive definite.
#[inline]
pub fn log_strain(excess: &SymmetricTensor) -> SymmetricTensor {
    let Spectrum { values, frame } = Spectrum::of(excess);
    frame.compose(&log_strains(&values))
}

/// The largest of |ln λ|, λ the principal stretches of b, from the excess b − I [-]; NaN where b is not positive definite.
pub fn largest_log_stretch(excess: &SymmetricTensor) -> f64 {
    let strains = log_strains(&Spectrum::of(excess).values);
    strains.iter().fold(0.0, |largest, strain| if strain.abs() <= largest { largest } else { strain.abs() })
}

/// Elastic energy per reference volume [F/L²] of the excess b_e − I; NaN where b_e is not positive definite.
pub fn stored_energy<M: Material>(law: &M, excess: &SymmetricTensor, history: &M::History) -> f64 {
    law.stored_energy(&log_strains(&Spectrum::of(excess).values).into(), history)
}

/// Whether a point with the excess b_e − I is at the [apex](Material::apex) of its law, up to rounding.
pub fn is_at_apex<M: Material>(law: &M, excess: &SymmetricTensor, history: &M::History) -> bool {
    law.apex(history).is_some_and(|apex| apex.is_reached(&log_strains(&Spectrum::of(excess).values).into()))
}

/// Elastic excess b_e − I and history of a point that begins under the Kirchhoff stress `stress` [F/L²], which is
/// Cauchy's too, because J = 1.
///
/// # Errors
/// The law has no elastic state with this stress: no strain carries it, or it is beyond yield.
pub fn start_under<M: Material>(
    law: &M,
    point: &PointParameters,
    stress: &SymmetricTensor,
) -> Result<(SymmetricTensor, M::History), NoReturn> {
    let Spectrum { values, frame } = Spectrum::of(stress);
    let values = Vector3::from(values);
    let history = law.initial(&PointParameters { stress: Some(values), ..*point });
    let strain = law.elastic_strain(&values, &history)?;
    let update = law.update(&strain, &history)?;
    if update.plastic {
        return Err(NoReturn { reason: "the law yields under it" });
    }
    let error = (update.kirchhoff - values).amax();
    if error > 1e-9 * values.amax() || error.is_nan() {
        return Err(NoReturn { reason: "no elastic strain carries it" });
    }
    Ok((frame.compose(&excesses(&strain)), history))
}

/// c_a = exp(2 ε_a) − 1.
#[inline]
fn excesses(strain: &Vector3<f64>) -> [f64; 3] {
    strain.map(|eps| exp_m1(2.0 * eps)).into()
}

/// ε_a = ½ ln(1 + c_a).
#[inline(always)]
fn log_strains<T: Number>(excess: &[T; 3]) -> [T; 3] {
    // One bad value spoils all three: a stress must not look healthy in some components only.
    let are_good = is_strained(excess[0]) & is_strained(excess[1]) & is_strained(excess[2]);
    let mut strains = [T::ZERO; 3];
    for (strain, c) in strains.iter_mut().zip(excess) {
        *strain = T::pick(are_good, T::of(0.5) * log_or_zero(*c), T::of(f64::NAN));
    }
    strains
}

/// ln(1 + c), which nobody works out where it is 0 throughout: as in plane strain across the plane.
#[inline(always)]
fn log_or_zero<T: Number>(c: T) -> T {
    if T::all(c.compare(T::ZERO, |c, zero| c == zero)) { T::ZERO } else { ln_1p(c) }
}

/// Whether an excess is that of a stretch.
#[inline(always)]
fn is_strained<T: Number>(c: T) -> T::Mask {
    c.above(T::of(-1.0)) & c.below(T::of(f64::INFINITY))
}
