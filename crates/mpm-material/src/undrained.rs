//! Water in the pores that cannot leave: a volumetric stiffness on top of any law.

use nalgebra::Vector3;

use crate::elementary::exp;
use crate::lanes::{LANES, Lanes, Number, each, four};
use crate::per_point::{MOST_NUMBERS, Numbers};
use crate::{
    Apex, Elasticity, FieldInfo, History, LaneUpdate, Material, NoReturn, OwnParameters, ParameterError,
    PointParameters, Update, Varied,
};

/// A law of effective stress in undrained loading: the pore fluid adds −K_f ln J to the Kirchhoff pressure,
///
/// τ = τ' + K_f ln J 1,   D = D' + K_f 1⊗1,   u = −K_f ln J/J,
///
/// u the excess pore pressure (Cauchy's, compression positive). J counts from where the fluid was shut in,
/// and comes from ln J = tr ε_tr + v, v the volumetric strain that is no longer, or was never, elastic.
/// K_f is 50 to 100 times the bulk modulus of the skeleton: more costs digits, and mean dilatation has to
/// be on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Undrained<M> {
    skeleton: M,
    fluid: f64,
}

/// History of the skeleton, and of the pore fluid.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct PoreFluid<H> {
    /// What the skeleton remembers.
    pub skeleton: H,
    /// v = ln J − tr ε_e [-]: plastic volumetric strain, less the elastic one at which the fluid was shut in.
    pub inelastic_volume: f64,
    /// Excess pore pressure u [F/L²], compression positive.
    pub excess_pressure: f64,
}

impl<H: History> History for PoreFluid<H> {
    const NUMBERS: usize = H::NUMBERS + 2;
    const FIELDS: &'static [FieldInfo] =
        &[FieldInfo { name: "excess_pore_pressure", components: 1, unit: "F/L²" }];

    fn store(&self, to: &mut Vec<f64>) {
        self.skeleton.store(to);
        to.extend([self.inelastic_volume, self.excess_pressure]);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        Ok(Self {
            skeleton: H::restore(&from[..H::NUMBERS])?,
            inelastic_volume: from[H::NUMBERS],
            excess_pressure: from[H::NUMBERS + 1],
        })
    }

    fn show(&self, to: &mut Vec<f64>) {
        to.push(self.excess_pressure);
    }
}

impl<M> Undrained<M> {
    /// The law `skeleton` of effective stress with a pore fluid of K_f = `bulk` [F/L²].
    ///
    /// # Errors
    /// `bulk` is not positive and finite.
    pub fn new(skeleton: M, bulk: f64) -> Result<Self, ParameterError> {
        Ok(Self { skeleton, fluid: ParameterError::unless_positive("fluid_bulk", bulk)? })
    }

    /// The law of effective stress.
    #[inline]
    pub fn skeleton(&self) -> &M {
        &self.skeleton
    }
}

/// Pore fluid after an update, of one point or of four.
struct Fluid<T> {
    /// K_f ln J [F/L²].
    tension: T,
    /// As of [`PoreFluid`].
    inelastic_volume: T,
    /// As of [`PoreFluid`].
    excess_pressure: T,
}

impl<T: Number> Fluid<T> {
    /// Of K_f = `bulk` [F/L²], where the elastic strain `left` is left of `trial`, and v was `before`.
    #[inline(always)]
    fn of(bulk: T, trial: &[T; 3], left: &[T; 3], before: T) -> Self {
        let sum = |of: &[T; 3]| of[0] + of[1] + of[2];
        let volume = sum(trial) + before;
        let tension = bulk * volume;
        let flow: [T; 3] = each(|a| trial[a] - left[a]);
        Self { tension, inelastic_volume: before + sum(&flow), excess_pressure: -tension * exp(-volume) }
    }
}

impl<H: Copy> LaneUpdate<H> {
    /// The answers with a pore fluid of K_f = `bulk` [F/L²] that comes from `history`.
    #[inline(always)]
    fn with_fluid(
        self,
        bulk: Lanes,
        trial: &[Lanes; 3],
        history: [&PoreFluid<H>; LANES],
    ) -> LaneUpdate<PoreFluid<H>> {
        let Self { mut principal, plastic, history: skeleton } = self;
        let before = Lanes(four(|k| history[k].inelastic_volume));
        let fluid = Fluid::of(bulk, trial, &principal.elastic_strain, before);
        for a in 0..3 {
            principal.kirchhoff[a] += fluid.tension;
            for b in 0..3 {
                principal.tangent[a][b] += bulk;
            }
        }
        let after = |k: usize| PoreFluid {
            skeleton: skeleton[k],
            inelastic_volume: fluid.inelastic_volume.0[k],
            excess_pressure: fluid.excess_pressure.0[k],
        };
        LaneUpdate { principal, plastic, history: four(after) }
    }
}

impl<M: Material> Material for Undrained<M> {
    type History = PoreFluid<M::History>;
    const PLASTIC: bool = M::PLASTIC;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        self.skeleton.has_symmetric_tangent()
    }

    /// The fluid is shut in under the effective stress at which the point begins.
    fn initial(&self, point: &PointParameters) -> Self::History {
        let skeleton = self.skeleton.initial(point);
        let strain = point.stress.and_then(|stress| self.skeleton.elastic_strain(&stress, &skeleton).ok());
        let inelastic_volume = strain.map_or(0.0, |strain| -strain.sum());
        PoreFluid { skeleton, inelastic_volume, excess_pressure: 0.0 }
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        let mut fields = self.skeleton.history_fields();
        fields.extend_from_slice(Self::History::FIELDS);
        fields
    }

    fn show(&self, history: &Self::History, to: &mut Vec<f64>) {
        self.skeleton.show(&history.skeleton, to);
        history.show(to);
    }

    /// Of effective stresses: the fluid has no excess pressure at the start.
    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &Self::History,
    ) -> Result<Vector3<f64>, NoReturn> {
        self.skeleton.elastic_strain(kirchhoff, &history.skeleton)
    }

    /// That of the skeleton and ½ K_f (ln J)².
    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &Self::History) -> f64 {
        let volume = elastic_strain.sum() + history.inelastic_volume;
        self.skeleton.stored_energy(elastic_strain, &history.skeleton) + 0.5 * self.fluid * volume * volume
    }

    fn fluid_stress(&self, volumetric: f64, history: &Self::History) -> f64 {
        let own = self.fluid * (volumetric + history.inelastic_volume);
        own + self.skeleton.fluid_stress(volumetric, &history.skeleton)
    }

    fn apex(&self, history: &Self::History) -> Option<Apex> {
        self.skeleton.apex(&history.skeleton)
    }

    fn undrained_strength(&self, history: &Self::History) -> Option<f64> {
        self.skeleton.undrained_strength(&history.skeleton)
    }

    #[inline]
    fn update(&self, trial: &Vector3<f64>, history: &Self::History) -> Result<Update<Self::History>, NoReturn> {
        let effective = self.skeleton.update(trial, &history.skeleton)?;
        let (strain, left) = ((*trial).into(), effective.elastic_strain.into());
        let Fluid { tension, inelastic_volume, excess_pressure } =
            Fluid::<f64>::of(self.fluid, &strain, &left, history.inelastic_volume);
        Ok(Update {
            elastic_strain: effective.elastic_strain,
            kirchhoff: effective.kirchhoff.add_scalar(tension),
            tangent: effective.tangent.add_scalar(self.fluid),
            secant: effective.secant,
            plastic: effective.plastic,
            history: PoreFluid { skeleton: effective.history, inelastic_volume, excess_pressure },
        })
    }

    /// Four points at once where the skeleton answers so.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&Self::History; LANES],
    ) -> Result<LaneUpdate<Self::History>, NoReturn> {
        let effective = self.skeleton.update_lanes(trial, four(|k| &history[k].skeleton))?;
        Ok(effective.with_fluid(Lanes::of(self.fluid), trial, history))
    }

    /// K and G of the skeleton, K_f added to K.
    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.skeleton.elasticity().stiffened(self.fluid)
    }
}

/// Those of the skeleton, then K_f.
impl<M: Varied> Varied for Undrained<M> {
    const N_OWN: usize = M::N_OWN + 1;
    const FOUR_AT_ONCE: bool = M::FOUR_AT_ONCE;

    fn own_fields() -> Vec<FieldInfo> {
        let mut fields = M::own_fields();
        fields.push(FieldInfo { name: "fluid_bulk", components: 1, unit: "F/L²" });
        fields
    }

    fn own(&self) -> OwnParameters {
        let mut own = self.skeleton.own();
        own[M::N_OWN] = self.fluid;
        own
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        Self { skeleton: self.skeleton.with_own(own), fluid: own[M::N_OWN] }
    }

    #[inline(always)]
    fn update_own(
        &self,
        own: [&OwnParameters; LANES],
        trial: &[Lanes; 3],
        history: [&Self::History; LANES],
    ) -> Result<LaneUpdate<Self::History>, NoReturn> {
        let effective = self.skeleton.update_own(own, trial, four(|k| &history[k].skeleton))?;
        Ok(effective.with_fluid(Lanes(four(|k| own[k][M::N_OWN])), trial, history))
    }

    fn numbers(history: &Self::History) -> Numbers {
        let mut numbers = M::numbers(&history.skeleton);
        numbers[M::History::NUMBERS] = history.inelastic_volume;
        numbers[M::History::NUMBERS + 1] = history.excess_pressure;
        numbers
    }

    fn history(numbers: &Numbers) -> Self::History {
        const { assert!(Self::History::NUMBERS <= MOST_NUMBERS) };
        PoreFluid {
            skeleton: M::history(numbers),
            inelastic_volume: numbers[M::History::NUMBERS],
            excess_pressure: numbers[M::History::NUMBERS + 1],
        }
    }
}
