//! Water in the pores that cannot leave: a volumetric stiffness on top of any law.

use nalgebra::Vector3;

use crate::elementary::exp;
use crate::per_point::{MOST_NUMBERS, Numbers};
use crate::{
    Apex, Elasticity, FieldInfo, History, Material, NoReturn, OwnParameters, ParameterError, PointParameters,
    Update, Varied,
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
        let volume = trial.sum() + history.inelastic_volume;
        let tension = self.fluid * volume;
        let flow = trial - effective.elastic_strain;
        Ok(Update {
            elastic_strain: effective.elastic_strain,
            kirchhoff: effective.kirchhoff.add_scalar(tension),
            tangent: effective.tangent.add_scalar(self.fluid),
            secant: effective.secant,
            plastic: effective.plastic,
            history: PoreFluid {
                skeleton: effective.history,
                inelastic_volume: history.inelastic_volume + flow.sum(),
                excess_pressure: -tension * exp(-volume),
            },
        })
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
