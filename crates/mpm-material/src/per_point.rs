//! Parameters that differ from point to point.

use nalgebra::Vector3;

use crate::lanes::{LANES, Lanes, Work, four, vectorised};
use crate::law::strain_of;
use crate::parameters::{MOST_OWN, OwnParameters};
use crate::{Apex, Elasticity, FieldInfo, History, LaneUpdate, Material, NoReturn, PointParameters, Update};

/// Most numbers that a law remembers of a point: two of a law whose points open and close, and two of pore fluid.
pub const MOST_NUMBERS: usize = 4;

/// What a law remembers of a point as numbers, in the order of [`History::store`]; those that it has not are zero.
pub type Numbers = [f64; MOST_NUMBERS];

/// A law whose parameters may differ from point to point.
pub trait Varied: Material + Sized + 'static {
    /// How many parameters may, at most [`MOST_OWN`].
    const N_OWN: usize;

    /// Which.
    fn own_fields() -> Vec<FieldInfo>;

    /// Their values in this law.
    fn own(&self) -> OwnParameters;

    /// The same law with other values, which a law of its kind has accepted.
    fn with_own(&self, own: &OwnParameters) -> Self;

    /// Whether [`Self::update_own`] does more than to ask point by point.
    const FOUR_AT_ONCE: bool = false;

    /// [`Material::update_lanes`] of four points with other values each; a law that says nothing of it is asked point by
    /// point.
    ///
    /// # Errors
    /// As of [`Material::update`], of any of the points.
    #[inline(always)]
    fn update_own(
        &self,
        own: [&OwnParameters; LANES],
        trial: &[Lanes; 3],
        history: [&Self::History; LANES],
    ) -> Result<LaneUpdate<Self::History>, NoReturn> {
        let of = |k: usize| self.with_own(own[k]).update(&strain_of(trial, k), history[k]);
        Ok(LaneUpdate::of([of(0)?, of(1)?, of(2)?, of(3)?]))
    }

    /// A history as numbers.
    fn numbers(history: &Self::History) -> Numbers;

    /// The history that has these numbers.
    fn history(numbers: &Numbers) -> Self::History;
}

/// A law of which every point carries parameters of its own ([`PointParameters::own`]). They are part of the history, so
/// that they go where the point goes, into results, and into checkpoints. All laws are one type here, which costs a
/// call per update or per four; laws that are not wrapped know nothing of it and cost nothing.
pub struct PerPoint {
    law: Box<dyn ErasedLaw>,
    has_symmetric_tangent: bool,
}

/// What a law remembers, and the point's own parameters.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PointHistory {
    /// What the law remembers.
    pub numbers: Numbers,
    /// The point's own parameters.
    pub own: OwnParameters,
}

impl History for PointHistory {
    const NUMBERS: usize = MOST_NUMBERS + MOST_OWN;
    const FIELDS: &'static [FieldInfo] = &[];

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.numbers);
        to.extend(self.own);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let found = from.split_first_chunk::<MOST_NUMBERS>();
        let whole = found.and_then(|(numbers, own)| Some((*numbers, own.try_into().ok()?)));
        let (numbers, own) =
            whole.ok_or_else(|| format!("{} numbers, expected {}", from.len(), Self::NUMBERS))?;
        Ok(Self { numbers, own })
    }

    fn show(&self, _to: &mut Vec<f64>) {}
}

/// What [`PerPoint`] asks of a law, whichever it is.
trait ErasedLaw: Send + Sync {
    fn has_symmetric_tangent(&self, own: &OwnParameters) -> bool;
    fn initial(&self, point: &PointParameters) -> PointHistory;
    fn fields(&self) -> Vec<FieldInfo>;
    fn show(&self, history: &PointHistory, to: &mut Vec<f64>);
    fn apex(&self, history: &PointHistory) -> Option<Apex>;
    fn undrained_strength(&self, history: &PointHistory) -> Option<f64>;
    fn update(&self, trial: &Vector3<f64>, history: &PointHistory) -> Result<Update<PointHistory>, NoReturn>;
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PointHistory; LANES],
    ) -> Result<LaneUpdate<PointHistory>, NoReturn>;
    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &PointHistory,
    ) -> Result<Vector3<f64>, NoReturn>;
    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &PointHistory) -> f64;
    fn fluid_stress(&self, volumetric: f64, history: &PointHistory) -> f64;
    fn elasticity(&self) -> Elasticity;
}

/// Four points of a law that may have other parameters each.
struct Asking<'a, M> {
    law: &'a M,
    trial: &'a [Lanes; 3],
    history: [&'a PointHistory; LANES],
}

impl<M: Varied> Work for Asking<'_, M> {
    type Output = Result<LaneUpdate<PointHistory>, NoReturn>;

    #[inline(always)]
    fn run<const VECTORS: bool>(self) -> Self::Output {
        let Self { law, trial, history } = self;
        let before = four(|k| M::history(&history[k].numbers));
        let own = four(|k| &history[k].own);
        let LaneUpdate { principal, plastic, history: after } =
            law.update_own(own, trial, before.each_ref())?;
        let after = |k: usize| PointHistory { numbers: M::numbers(&after[k]), own: *own[k] };
        Ok(LaneUpdate { principal, plastic, history: four(after) })
    }
}

impl<M: Varied> ErasedLaw for M {
    fn has_symmetric_tangent(&self, own: &OwnParameters) -> bool {
        Material::has_symmetric_tangent(&self.with_own(own))
    }

    fn initial(&self, point: &PointParameters) -> PointHistory {
        let own = point.own.unwrap_or_else(|| self.own());
        PointHistory { numbers: M::numbers(&Material::initial(&self.with_own(&own), point)), own }
    }

    fn fields(&self) -> Vec<FieldInfo> {
        let mut fields = self.history_fields();
        fields.extend(M::own_fields());
        fields
    }

    fn show(&self, history: &PointHistory, to: &mut Vec<f64>) {
        Material::show(self, &M::history(&history.numbers), to);
        to.extend(&history.own[..M::N_OWN]);
    }

    fn apex(&self, history: &PointHistory) -> Option<Apex> {
        Material::apex(&self.with_own(&history.own), &M::history(&history.numbers))
    }

    fn undrained_strength(&self, history: &PointHistory) -> Option<f64> {
        Material::undrained_strength(&self.with_own(&history.own), &M::history(&history.numbers))
    }

    fn update(&self, trial: &Vector3<f64>, history: &PointHistory) -> Result<Update<PointHistory>, NoReturn> {
        let law = self.with_own(&history.own);
        let Update { elastic_strain, kirchhoff, tangent, secant, plastic, history: after } =
            Material::update(&law, trial, &M::history(&history.numbers))?;
        let history = PointHistory { numbers: M::numbers(&after), own: history.own };
        Ok(Update { elastic_strain, kirchhoff, tangent, secant, plastic, history })
    }

    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PointHistory; LANES],
    ) -> Result<LaneUpdate<PointHistory>, NoReturn> {
        if M::FOUR_AT_ONCE {
            return vectorised(Asking { law: self, trial, history });
        }
        let of = |k: usize| ErasedLaw::update(self, &strain_of(trial, k), history[k]);
        Ok(LaneUpdate::of([of(0)?, of(1)?, of(2)?, of(3)?]))
    }

    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &PointHistory,
    ) -> Result<Vector3<f64>, NoReturn> {
        let law = self.with_own(&history.own);
        Material::elastic_strain(&law, kirchhoff, &M::history(&history.numbers))
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &PointHistory) -> f64 {
        let law = self.with_own(&history.own);
        Material::stored_energy(&law, elastic_strain, &M::history(&history.numbers))
    }

    fn fluid_stress(&self, volumetric: f64, history: &PointHistory) -> f64 {
        let law = self.with_own(&history.own);
        Material::fluid_stress(&law, volumetric, &M::history(&history.numbers))
    }

    fn elasticity(&self) -> Elasticity {
        Material::elasticity(self)
    }
}

impl PerPoint {
    /// The law `law`, whose elastic constants are those that sizes of forces are judged by: take those of the
    /// stiffest point.
    pub fn new<M: Varied>(law: M) -> Self {
        let has_symmetric_tangent = law.has_symmetric_tangent();
        Self { law: Box::new(law), has_symmetric_tangent }
    }

    /// The same law for points that have these parameters: its tangent is symmetric where it is so at all of them.
    pub fn for_points<'a>(self, mut own: impl Iterator<Item = &'a OwnParameters>) -> Self {
        let has_symmetric_tangent = own.all(|own| self.law.has_symmetric_tangent(own));
        Self { has_symmetric_tangent, ..self }
    }
}

impl Material for PerPoint {
    type History = PointHistory;
    const PLASTIC: bool = true;

    fn has_symmetric_tangent(&self) -> bool {
        self.has_symmetric_tangent
    }

    fn initial(&self, point: &PointParameters) -> PointHistory {
        self.law.initial(point)
    }

    /// Those of the law, then the point's own parameters.
    fn history_fields(&self) -> Vec<FieldInfo> {
        self.law.fields()
    }

    fn show(&self, history: &PointHistory, to: &mut Vec<f64>) {
        self.law.show(history, to);
    }

    fn update(&self, trial: &Vector3<f64>, history: &PointHistory) -> Result<Update<PointHistory>, NoReturn> {
        self.law.update(trial, history)
    }

    /// Four points at once where the law answers so whatever their parameters.
    #[inline(always)]
    fn update_lanes(
        &self,
        trial: &[Lanes; 3],
        history: [&PointHistory; LANES],
    ) -> Result<LaneUpdate<PointHistory>, NoReturn> {
        self.law.update_lanes(trial, history)
    }

    fn elastic_strain(
        &self,
        kirchhoff: &Vector3<f64>,
        history: &PointHistory,
    ) -> Result<Vector3<f64>, NoReturn> {
        self.law.elastic_strain(kirchhoff, history)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &PointHistory) -> f64 {
        self.law.stored_energy(elastic_strain, history)
    }

    fn fluid_stress(&self, volumetric: f64, history: &PointHistory) -> f64 {
        self.law.fluid_stress(volumetric, history)
    }

    fn apex(&self, history: &PointHistory) -> Option<Apex> {
        self.law.apex(history)
    }

    fn undrained_strength(&self, history: &PointHistory) -> Option<f64> {
        self.law.undrained_strength(history)
    }

    fn elasticity(&self) -> Elasticity {
        self.law.elasticity()
    }
}
