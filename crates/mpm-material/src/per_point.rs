//! Parameters that differ from point to point.

use nalgebra::Vector3;

use crate::parameters::{MOST_OWN, OwnParameters};
use crate::{
    CamClay, DruckerPrager, Elasticity, FieldInfo, Hencky, History, Material, MohrCoulomb, NeoHooke, NoReturn,
    PlasticShear, PlasticStrain, PointParameters, Preconsolidation, Tresca, Update, VonMises,
};

/// A law whose stiffness and strengths may differ from point to point.
pub trait Varied: Material + 'static {
    /// The parameters that may, at most [`MOST_OWN`].
    const OWN: &'static [FieldInfo];

    /// Their values in this law.
    fn own(&self) -> OwnParameters;

    /// The same law with other values, which a law of its kind has accepted.
    fn with_own(&self, own: &OwnParameters) -> Self;

    /// The only number of a history; zero where it has none.
    fn number(history: &Self::History) -> f64;

    /// The history that has this number.
    fn history(number: f64) -> Self::History;
}

/// A law of which every point carries parameters of its own ([`PointParameters::own`]). They are part of the history, so
/// that they go where the point goes, into results, and into checkpoints. All laws are one type here, which costs a
/// call per update; laws that are not wrapped know nothing of it and cost nothing.
pub struct PerPoint(Box<dyn ErasedLaw>);

/// The number that a law remembers, and the point's own parameters.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PointHistory {
    /// What the law remembers; zero where it remembers nothing.
    pub number: f64,
    /// The point's own parameters.
    pub own: OwnParameters,
}

impl History for PointHistory {
    const NUMBERS: usize = 1 + MOST_OWN;
    const FIELDS: &'static [FieldInfo] = &[];

    fn store(&self, to: &mut Vec<f64>) {
        to.push(self.number);
        to.extend(self.own);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let [number, own @ ..]: [f64; 1 + MOST_OWN] =
            from.try_into().map_err(|_| format!("{} numbers, expected {}", from.len(), Self::NUMBERS))?;
        Ok(Self { number, own })
    }

    fn show(&self, _to: &mut Vec<f64>) {}
}

/// What [`PerPoint`] asks of a law, whichever it is.
trait ErasedLaw: Send + Sync {
    fn has_symmetric_tangent(&self) -> bool;
    fn initial(&self, point: &PointParameters) -> PointHistory;
    fn fields(&self) -> [&'static [FieldInfo]; 2];
    fn update(&self, trial: &Vector3<f64>, history: &PointHistory) -> Result<Update<PointHistory>, NoReturn>;
    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &PointHistory,
    ) -> Result<Vector3<f64>, NoReturn>;
    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &PointHistory) -> f64;
    fn elasticity(&self) -> Elasticity;
}

impl<M: Varied> ErasedLaw for M {
    fn has_symmetric_tangent(&self) -> bool {
        Material::has_symmetric_tangent(self)
    }

    fn initial(&self, point: &PointParameters) -> PointHistory {
        let own = point.own.unwrap_or_else(|| self.own());
        PointHistory { number: M::number(&Material::initial(&self.with_own(&own), point)), own }
    }

    fn fields(&self) -> [&'static [FieldInfo]; 2] {
        [M::History::FIELDS, M::OWN]
    }

    fn update(&self, trial: &Vector3<f64>, history: &PointHistory) -> Result<Update<PointHistory>, NoReturn> {
        let law = self.with_own(&history.own);
        let Update { elastic_strain, kirchhoff, tangent, secant, plastic, history: after } =
            Material::update(&law, trial, &M::history(history.number))?;
        let history = PointHistory { number: M::number(&after), own: history.own };
        Ok(Update { elastic_strain, kirchhoff, tangent, secant, plastic, history })
    }

    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &PointHistory,
    ) -> Result<Vector3<f64>, NoReturn> {
        let law = self.with_own(&history.own);
        Material::elastic_strain(&law, kirchhoff, &M::history(history.number))
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &PointHistory) -> f64 {
        let law = self.with_own(&history.own);
        Material::stored_energy(&law, elastic_strain, &M::history(history.number))
    }

    fn elasticity(&self) -> Elasticity {
        Material::elasticity(self)
    }
}

impl PerPoint {
    /// The law `law`, whose elastic constants are those that sizes of forces are judged by: take those of the
    /// stiffest point.
    pub fn new<M: Varied>(law: M) -> Self {
        Self(Box::new(law))
    }
}

impl Material for PerPoint {
    type History = PointHistory;
    const PLASTIC: bool = true;

    fn has_symmetric_tangent(&self) -> bool {
        self.0.has_symmetric_tangent()
    }

    fn initial(&self, point: &PointParameters) -> PointHistory {
        self.0.initial(point)
    }

    /// Those of the law, then the point's own parameters.
    fn history_fields(&self) -> Vec<FieldInfo> {
        self.0.fields().concat()
    }

    fn show(&self, history: &PointHistory, to: &mut Vec<f64>) {
        let [remembered, own] = self.0.fields();
        to.extend(remembered.iter().map(|_| history.number));
        to.extend(&history.own[..own.len()]);
    }

    fn update(&self, trial: &Vector3<f64>, history: &PointHistory) -> Result<Update<PointHistory>, NoReturn> {
        self.0.update(trial, history)
    }

    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &PointHistory,
    ) -> Result<Vector3<f64>, NoReturn> {
        self.0.elastic_strain(kirchhoff, history)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &PointHistory) -> f64 {
        self.0.stored_energy(elastic_strain, history)
    }

    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}

const fn stress(name: &'static str) -> FieldInfo {
    FieldInfo { name, components: 1, unit: "F/L²" }
}

/// A law that remembers nothing.
impl Varied for Hencky {
    const OWN: &'static [FieldInfo] = &[stress("young")];

    fn own(&self) -> OwnParameters {
        [self.0.young(), 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        Self(self.0.with_young(own[0]))
    }

    fn number(_history: &()) -> f64 {
        0.0
    }

    fn history(_number: f64) {}
}

impl Varied for NeoHooke {
    const OWN: &'static [FieldInfo] = &[stress("young")];

    fn own(&self) -> OwnParameters {
        [Material::elasticity(self).young(), 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_young(own[0])
    }

    fn number(_history: &()) -> f64 {
        0.0
    }

    fn history(_number: f64) {}
}

impl Varied for VonMises {
    const OWN: &'static [FieldInfo] = &[stress("young"), stress("yield_radius")];

    fn own(&self) -> OwnParameters {
        [Material::elasticity(self).young(), self.yield_radius(), 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_values(own[0], own[1])
    }

    fn number(history: &PlasticStrain) -> f64 {
        history.0
    }

    fn history(number: f64) -> PlasticStrain {
        PlasticStrain(number)
    }
}

impl Varied for Tresca {
    const OWN: &'static [FieldInfo] = &[stress("young"), stress("undrained_strength")];

    fn own(&self) -> OwnParameters {
        [Material::elasticity(self).young(), self.strength().intact(), 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_values(own[0], own[1])
    }

    fn number(history: &PlasticShear) -> f64 {
        history.0
    }

    fn history(number: f64) -> PlasticShear {
        PlasticShear(number)
    }
}

impl Varied for MohrCoulomb {
    const OWN: &'static [FieldInfo] = &[stress("young"), stress("cohesion"), stress("tensile_strength")];

    fn own(&self) -> OwnParameters {
        self.values()
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_values(own)
    }

    fn number(history: &PlasticStrain) -> f64 {
        history.0
    }

    fn history(number: f64) -> PlasticStrain {
        PlasticStrain(number)
    }
}

impl Varied for DruckerPrager {
    const OWN: &'static [FieldInfo] = &[stress("young"), stress("cone_strength"), stress("tension")];

    fn own(&self) -> OwnParameters {
        self.values()
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_values(own)
    }

    fn number(history: &PlasticStrain) -> f64 {
        history.0
    }

    fn history(number: f64) -> PlasticStrain {
        PlasticStrain(number)
    }
}

impl Varied for CamClay {
    const OWN: &'static [FieldInfo] = &[stress("shear")];

    fn own(&self) -> OwnParameters {
        [self.parameters().shear, 0.0, 0.0]
    }

    fn with_own(&self, own: &OwnParameters) -> Self {
        self.with_shear(own[0])
    }

    fn number(history: &Preconsolidation) -> f64 {
        history.0
    }

    fn history(number: f64) -> Preconsolidation {
        Preconsolidation(number)
    }
}
