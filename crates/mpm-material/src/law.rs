//! What a constitutive law is, and what it answers to a trial state.

use nalgebra::{Matrix3, Vector3};

use crate::lanes::{LANES, Lanes, Mask, Number, each, four};
use crate::{Elasticity, FieldInfo, History, PointParameters};

/// Overshoot of the yield radius that still counts as elastic. A point left on the yield surface
/// by one load step must not be called plastic in the next by rounding alone: neighbours would
/// then soften one-sidedly, and rounding would choose the branch of the solution.
pub(crate) const YIELD_TOLERANCE: f64 = 1e-12;

/// Four points at once are called elastic if they are so by this part of the size of their stresses at least; the others are
/// asked one by one. It is far beyond rounding, so that both ways agree.
pub(crate) const SURELY_ELASTIC: f64 = 1e-9;

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
        let of = |k: usize| self.update(&strain_of(trial, k), history[k]);
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
#[derive(Clone, Copy, PartialEq, Debug, Default)]
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
        let principal = PrincipalUpdate {
            elastic_strain: [Lanes::ZERO; 3],
            kirchhoff: [Lanes::ZERO; 3],
            tangent: [[Lanes::ZERO; 3]; 3],
            secant: [Lanes::ZERO; 3],
        };
        let mut all = Self { principal, plastic: Mask::NONE, history: four(|k| of[k].history) };
        for (lane, of) in of.iter().enumerate() {
            all.set(lane, of);
        }
        all
    }
}

impl<H: Copy> LaneUpdate<H> {
    /// Answers of points of which most do not yield: `elastic` for those that surely do not, the others are asked `alone`.
    ///
    /// # Errors
    /// As of `alone`.
    #[inline(always)]
    pub(crate) fn elastic_but(
        elastic: PrincipalUpdate<Lanes>,
        may_yield: Mask,
        history: [&H; LANES],
        alone: impl Fn(usize) -> Result<Update<H>, NoReturn>,
    ) -> Result<Self, NoReturn> {
        let answer = Self { principal: elastic, plastic: Mask::NONE, history: four(|k| *history[k]) };
        answer.but(may_yield, alone)
    }

    /// The same but for some points, which are asked `alone`.
    ///
    /// # Errors
    /// As of `alone`.
    #[inline(always)]
    pub(crate) fn but(
        mut self,
        others: Mask,
        alone: impl Fn(usize) -> Result<Update<H>, NoReturn>,
    ) -> Result<Self, NoReturn> {
        if Lanes::any(others) {
            for lane in 0..LANES {
                if others.get(lane) {
                    self.set(lane, &alone(lane)?);
                }
            }
        }
        Ok(self)
    }

    /// Gives one of the points another answer.
    #[inline(always)]
    fn set(&mut self, lane: usize, of: &Update<H>) {
        for a in 0..3 {
            self.principal.elastic_strain[a].0[lane] = of.elastic_strain[a];
            self.principal.kirchhoff[a].0[lane] = of.kirchhoff[a];
            self.principal.secant[a].0[lane] = of.secant[a];
            for b in 0..3 {
                self.principal.tangent[a][b].0[lane] = of.tangent[(a, b)];
            }
        }
        self.plastic.set(lane, of.plastic);
        self.history[lane] = of.history;
    }
}

/// The principal strains of one of four points.
#[inline(always)]
pub(crate) fn strain_of(trial: &[Lanes; 3], lane: usize) -> Vector3<f64> {
    Vector3::new(trial[0].0[lane], trial[1].0[lane], trial[2].0[lane])
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
