//! What a constitutive law is, and what it answers to a trial state.

use nalgebra::{Matrix3, Vector3};

use crate::elementary::{exp_m1, ln_1p};
use crate::lanes::{LANES, Lanes, Mask, Number, each, four};
use crate::spectral::{Frame, Spectrum};
use crate::{Elasticity, FieldInfo, History, PointParameters, PrincipalTangent, SymmetricTensor};

/// Overshoot of the yield radius that still counts as elastic. A point left on the yield surface
/// by one load step must not be called plastic in the next by rounding alone: neighbours would
/// then soften one-sidedly, and rounding would choose the branch of the solution.
pub(crate) const YIELD_TOLERANCE: f64 = 1e-12;

/// An isotropic law in principal logarithmic space, always three-dimensional.
///
/// The three principal directions have equal rights: a law must not read anything into their
/// order, which is fixed by the data but not sorted.
pub trait Material: Send + Sync {
    /// What a point remembers besides b_e; `()` where there is nothing.
    type History: History;

    /// Whether the law can yield.
    const PLASTIC: bool;

    /// Whether the algorithmic tangent ∂τ_a/∂ε_b is symmetric in every state that these parameters allow, and with
    /// it the stiffness matrix. A tangent that is called symmetric and is not loses its upper triangle.
    fn has_symmetric_tangent(&self) -> bool;

    /// What a point remembers before the first load step.
    fn initial(&self, point: &PointParameters) -> Self::History;

    /// What results can show of a history, in the order of [`Self::show`].
    fn history_fields(&self) -> Vec<FieldInfo> {
        Self::History::FIELDS.to_vec()
    }

    /// Appends the components of all [`Self::history_fields`].
    fn show(&self, history: &Self::History, to: &mut Vec<f64>) {
        history.show(to);
    }

    /// Principal elastic strains that carry principal Kirchhoff stresses [F/L²]: those of a point that begins under
    /// stress. Unless a law says otherwise, of stresses that are linear in logarithmic strain.
    ///
    /// # Errors
    /// No elastic strain carries these stresses.
    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        _history: &Self::History,
    ) -> Result<Vector3<f64>, NoReturn> {
        Ok(self.elasticity().strain(kirchhoff))
    }

    /// Elastic energy per reference volume [F/L²] of principal elastic strains; what hardening stores is not part of it.
    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &Self::History) -> f64;

    /// Isotropic Kirchhoff stress [F/L²] that plastic flow does no work against, because it depends on the
    /// volume alone: that of pore fluid. `volumetric` is tr ε_e.
    fn fluid_stress(&self, _volumetric: f64, _history: &Self::History) -> f64 {
        0.0
    }

    /// The apex of the yield surface, or the tip of its cut-off; none where mean tension has no bound, or where shear
    /// stresses are borne beside the largest.
    fn apex(&self, _history: &Self::History) -> Option<Apex> {
        None
    }

    /// Undrained shear strength s_u that a point has left [F/L²]; none where shear stress has no bound, or one that
    /// depends on the pressure.
    fn undrained_strength(&self, _history: &Self::History) -> Option<f64> {
        None
    }

    /// Answers principal elastic trial strains `trial` [-] with stress, tangent and the elastic
    /// strain that is left. Non-finite strains give non-finite stresses.
    ///
    /// # Errors
    /// The law finds no admissible state that `trial` returns to. The load step is then cut.
    fn update(&self, trial: &Vector3<f64>, history: &Self::History) -> Result<Update<Self::History>, NoReturn>;

    /// [`Self::update`] of four points, each with the bits that it has alone; a law that says nothing of it is asked point by
    /// point. It is called very often: a law that answers four points at once does so in code that is inlined, see
    /// [`crate::lanes`].
    ///
    /// # Errors
    /// As of [`Self::update`], of any of the points.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&Self::History; LANES],
    ) -> Result<LaneUpdate<Self::History>, NoReturn> {
        let of = |k: usize| self.update(&Vector3::new(trial[0].0[k], trial[1].0[k], trial[2].0[k]), history[k]);
        Ok(LaneUpdate::of([of(0)?, of(1)?, of(2)?, of(3)?]))
    }

    /// Elastic constants of the undeformed material. Their P-wave modulus is the size of the tangent's entries,
    /// against which round-off is judged; ghost stiffness is measured in their Young's modulus.
    fn elasticity(&self) -> Elasticity;
}

/// The state of the largest mean tension, the same in all directions.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Apex {
    /// Elastic volumetric strain tr ε_e [-].
    pub volumetric: f64,
    /// Part of the elastic moduli that the tangent has there.
    pub stiffness: f64,
}

/// A return mapping that found no admissible state.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{reason}")]
pub struct NoReturn {
    /// What the law could not do, as a clause: "the hardening equation has no root in its bracket".
    pub reason: &'static str,
}

/// Answer of a [`Material`] in principal axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Update<H> {
    /// Elastic strains ε_e after the update [-].
    pub elastic_strain: Vector3<f64>,
    /// Kirchhoff stresses τ [F/L²].
    pub kirchhoff: Vector3<f64>,
    /// Algorithmic tangent ∂τ_a/∂ε_bᵗʳ [F/L²], `[(a, b)]`.
    pub tangent: Matrix3<f64>,
    /// Secants (τ_a − τ_b)/(ε_aᵗʳ − ε_bᵗʳ) of the pairs (0,1), (1,2), (2,0) [F/L²], each with its
    /// limit where the strains are equal. A law gives them in closed form: the quotient of
    /// differences would lose all digits as two strains approach each other.
    pub secant: Vector3<f64>,
    /// Whether the point yielded in this update.
    pub plastic: bool,
    /// What the point remembers from here on.
    pub history: H,
}

/// Answer of a [`Material`] to one trial state in principal axes, or to four: what is in [`Update`] besides.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PrincipalUpdate<T> {
    /// As of [`Update`].
    pub elastic_strain: [T; 3],
    /// As of [`Update`].
    pub kirchhoff: [T; 3],
    /// As of [`Update`], `[a][b]`.
    pub tangent: [[T; 3]; 3],
    /// As of [`Update`].
    pub secant: [T; 3],
}

/// Answer of a [`Material`] to four trial states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LaneUpdate<H> {
    /// In principal axes.
    pub principal: PrincipalUpdate<Lanes>,
    /// Which points yielded.
    pub plastic: Mask,
    /// What they remember from here on.
    pub history: [H; LANES],
}

impl<H: Copy> LaneUpdate<H> {
    /// Of four answers.
    #[inline(always)]
    pub fn of(of: [Update<H>; LANES]) -> Self {
        let mut principal = PrincipalUpdate {
            elastic_strain: [Lanes::ZERO; 3],
            kirchhoff: [Lanes::ZERO; 3],
            tangent: [[Lanes::ZERO; 3]; 3],
            secant: [Lanes::ZERO; 3],
        };
        for (lane, of) in of.iter().enumerate() {
            for a in 0..3 {
                principal.elastic_strain[a].0[lane] = of.elastic_strain[a];
                principal.kirchhoff[a].0[lane] = of.kirchhoff[a];
                principal.secant[a].0[lane] = of.secant[a];
                for b in 0..3 {
                    principal.tangent[a][b].0[lane] = of.tangent[(a, b)];
                }
            }
        }
        Self { principal, plastic: Mask(four(|k| of[k].plastic)), history: four(|k| of[k].history) }
    }
}

impl PrincipalUpdate<f64> {
    /// The answer of a point that has yielded or not.
    #[inline(always)]
    pub fn with<H>(self, plastic: bool, history: H) -> Update<H> {
        let Self { elastic_strain, kirchhoff, tangent, secant } = self;
        Update {
            elastic_strain: elastic_strain.into(),
            kirchhoff: kirchhoff.into(),
            tangent: Matrix3::from_fn(|a, b| tangent[a][b]),
            secant: secant.into(),
            plastic,
            history,
        }
    }
}

impl<T: Number> PrincipalUpdate<T> {
    /// One answer where the mask says so, and else another.
    #[inline(always)]
    pub fn pick(mask: T::Mask, yes: &Self, no: &Self) -> Self {
        let three = |yes: &[T; 3], no: &[T; 3]| each(|a| T::pick(mask, yes[a], no[a]));
        Self {
            elastic_strain: three(&yes.elastic_strain, &no.elastic_strain),
            kirchhoff: three(&yes.kirchhoff, &no.kirchhoff),
            tangent: [
                three(&yes.tangent[0], &no.tangent[0]),
                three(&yes.tangent[1], &no.tangent[1]),
                three(&yes.tangent[2], &no.tangent[2]),
            ],
            secant: three(&yes.secant, &no.secant),
        }
    }
}

impl Apex {
    /// Whether an elastic strain has the volume of the apex, up to rounding.
    pub(crate) fn is_reached(&self, elastic_strain: &Vector3<f64>) -> bool {
        let rounding = YIELD_TOLERANCE * (self.volumetric.abs() + elastic_strain.amax());
        elastic_strain.sum() >= self.volumetric - rounding
    }
}

impl<H> Update<H> {
    /// The answer without what the point remembers.
    #[inline]
    pub fn without_history(self) -> Update<()> {
        let Self { elastic_strain, kirchhoff, tangent, secant, plastic, .. } = self;
        Update { elastic_strain, kirchhoff, tangent, secant, plastic, history: () }
    }
}

impl Update<()> {
    /// The answer with a history: of an elastic law, that which it leaves as it is.
    #[inline]
    pub fn with_history<H>(self, history: H) -> Update<H> {
        let Self { elastic_strain, kirchhoff, tangent, secant, plastic, .. } = self;
        Update { elastic_strain, kirchhoff, tangent, secant, plastic, history }
    }
}

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

    /// Of four trial excesses; none where z is a principal direction of some of them only, which then have to be taken
    /// apart.
    #[inline(always)]
    pub fn of_four(trial_excess: &SymmetricTensor<Lanes>) -> Option<Self> {
        let is_zero = |x: Lanes| x.compare(Lanes::ZERO, |x, zero| x == zero);
        let is_plane = is_zero(trial_excess.yz) & is_zero(trial_excess.zx);
        if Lanes::all(is_plane) {
            return Some(Self::in_plane(trial_excess));
        }
        (!Lanes::any(is_plane)).then(|| Self::of(Spectrum::in_space(trial_excess)))
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

    /// Elastic excess b_e − I after an update of what yields [-].
    #[inline(always)]
    pub fn elastic_excess(&self, update: &PrincipalUpdate<T>) -> SymmetricTensor<T> {
        let mut excess = update.elastic_strain;
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
            elastic_excess: if update.plastic { self.elastic_excess(&principal) } else { *trial_excess },
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
