//! Points that have come apart close again before they bear anything.

use nalgebra::{Matrix3, Vector3};

use crate::per_point::{MOST_NUMBERS, Numbers};
use crate::{
    Apex, Elasticity, FieldInfo, History, Material, NoReturn, OwnParameters, ParameterError, PointParameters,
    Update, Varied,
};

/// A law of which a point that expanded at the apex bears nothing more until it has closed again: the volume correction of
/// Tampubolon et al. (2017, Multi-species simulation of porous sand and water mixtures), here exact for a step in which it
/// closes.
///
/// Plain laws forget how far a point has expanded at the apex, where it has no stiffness: it meets full stiffness as soon as
/// it is compressed, with a volume that is too large for good. Here a point remembers v, the logarithm of its volume over
/// that at which it came apart. With the strain ε_a of the apex, a trial ε_tr = ε_a + x and d = −tr x:
///
/// * d ≤ v: the point stays apart. It bears the tension of the apex in every direction, and v becomes v − d;
/// * d > v: the point closes on the way, and only the part of the step after that is strain to the law:
///   ε = ε_a + (1 − v/d) x, v becomes 0. The stress is continuous, and
///   ∂ε/∂ε_tr = (1 − v/d) I − (v/d²) x⊗1, so that the tangent is not symmetric.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VolumeCorrected<M>(M);

/// What the law remembers, and how far the point has opened.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Opened<H> {
    /// What the law remembers.
    pub law: H,
    /// v [-], not negative.
    pub volume: f64,
}

impl<H: History> History for Opened<H> {
    const NUMBERS: usize = H::NUMBERS + 1;
    const FIELDS: &'static [FieldInfo] = &[FieldInfo { name: "opened_volume", components: 1, unit: "-" }];

    fn store(&self, to: &mut Vec<f64>) {
        self.law.store(to);
        to.push(self.volume);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let error = |error: ParameterError| error.to_string();
        let volume = ParameterError::unless_not_negative("opened_volume", from[H::NUMBERS]).map_err(error)?;
        Ok(Self { law: H::restore(&from[..H::NUMBERS])?, volume })
    }

    fn show(&self, to: &mut Vec<f64>) {
        to.push(self.volume);
    }
}

impl<M: Material> VolumeCorrected<M> {
    /// The law `law`, which changes nothing where it has no [apex](Material::apex).
    pub fn new(law: M) -> Self {
        Self(law)
    }
}

impl<M: Material> VolumeCorrected<M> {
    /// Answers a trial of a point that is apart.
    fn apart(
        &self,
        trial: &Vector3<f64>,
        history: &Opened<M::History>,
        apex: Apex,
    ) -> Result<Update<Opened<M::History>>, NoReturn> {
        let strain = Vector3::repeat(apex.volumetric / 3.0);
        let step = trial - strain;
        let closing = -step.sum();
        if closing <= history.volume {
            let elasticity = self.0.elasticity();
            let two_g = 2.0 * apex.stiffness * elasticity.shear();
            let lambda = apex.stiffness * elasticity.lame();
            return Ok(Update {
                elastic_strain: strain,
                kirchhoff: Vector3::repeat(elasticity.bulk() * apex.volumetric),
                tangent: Matrix3::from_diagonal_element(two_g).add_scalar(lambda),
                secant: Vector3::repeat(two_g),
                plastic: true,
                history: Opened { volume: history.volume - closing, ..*history },
            });
        }
        let part = 1.0 - history.volume / closing;
        let closed = self.0.update(&(strain + step * part), &history.law)?;
        let by_volume = step * (history.volume / (closing * closing));
        let along = Matrix3::from_diagonal_element(part) - by_volume * Vector3::repeat(1.0).transpose();
        Ok(Update {
            elastic_strain: closed.elastic_strain,
            kirchhoff: closed.kirchhoff,
            tangent: closed.tangent * along,
            secant: closed.secant * part,
            // Its elastic strain is not that of the trial, even where the law is elastic.
            plastic: true,
            history: Opened { law: closed.history, volume: 0.0 },
        })
    }
}

impl<M: Material> Material for VolumeCorrected<M> {
    type History = Opened<M::History>;
    const PLASTIC: bool = true;

    /// That of a step in which a point closes is not.
    fn has_symmetric_tangent(&self) -> bool {
        false
    }

    fn initial(&self, point: &PointParameters) -> Self::History {
        Opened { law: self.0.initial(point), volume: 0.0 }
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        let mut fields = self.0.history_fields();
        fields.extend_from_slice(Self::History::FIELDS);
        fields
    }

    fn show(&self, history: &Self::History, to: &mut Vec<f64>) {
        self.0.show(&history.law, to);
        history.show(to);
    }

    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &Self::History,
    ) -> Result<Vector3<f64>, NoReturn> {
        self.0.elastic_strain(kirchhoff, &history.law)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &Self::History) -> f64 {
        self.0.stored_energy(elastic_strain, &history.law)
    }

    fn fluid_stress(&self, volumetric: f64, history: &Self::History) -> f64 {
        self.0.fluid_stress(volumetric, &history.law)
    }

    fn apex(&self, history: &Self::History) -> Option<Apex> {
        self.0.apex(&history.law)
    }

    fn undrained_strength(&self, history: &Self::History) -> Option<f64> {
        self.0.undrained_strength(&history.law)
    }

    fn update(&self, trial: &Vector3<f64>, history: &Self::History) -> Result<Update<Self::History>, NoReturn> {
        let apex = self.0.apex(&history.law);
        if let Some(apex) = apex.filter(|_| history.volume > 0.0) {
            return self.apart(trial, history, apex);
        }
        let Update { elastic_strain, kirchhoff, tangent, secant, plastic, history: law } =
            self.0.update(trial, &history.law)?;
        let comes_apart = plastic && apex.is_some_and(|apex| apex.is_reached(&elastic_strain));
        // Below zero by rounding only.
        let volume = if comes_apart { (trial - elastic_strain).sum().max(0.0) } else { 0.0 };
        Ok(Update { elastic_strain, kirchhoff, tangent, secant, plastic, history: Opened { law, volume } })
    }

    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}

impl<M: Varied> Varied for VolumeCorrected<M> {
    const N_OWN: usize = M::N_OWN;

    fn own_fields() -> Vec<FieldInfo> {
        M::own_fields()
    }

    fn own(&self) -> OwnParameters {
        self.0.own()
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        Self(self.0.with_own(own))
    }

    fn numbers(history: &Self::History) -> Numbers {
        let mut numbers = M::numbers(&history.law);
        numbers[M::History::NUMBERS] = history.volume;
        numbers
    }

    fn history(numbers: &Numbers) -> Self::History {
        const { assert!(Self::History::NUMBERS <= MOST_NUMBERS) };
        Opened { law: M::history(numbers), volume: numbers[M::History::NUMBERS] }
    }
}
