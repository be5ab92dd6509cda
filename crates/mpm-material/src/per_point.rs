//! Strengths that differ from point to point.

use nalgebra::Vector3;

use crate::history::{FIELDS, followed};
use crate::{Elasticity, FieldInfo, History, Material, NoReturn, ParameterError, PointParameters, Update};

/// A law all of whose strengths can be multiplied by one factor.
pub trait Scalable: Material + Sized {
    /// The same law with its strengths (stresses, not angles or slopes) multiplied by `factor` > 0.
    fn scaled(&self, factor: f64) -> Self;

    /// Whether the law still has a solution in every state; scaling may have made it soften too fast.
    ///
    /// # Errors
    /// It does.
    fn check(&self) -> Result<(), ParameterError> {
        Ok(())
    }
}

/// A law whose strength at a point is its own, multiplied by the point's factor
/// ([`PointParameters::strength`]). The factor is part of the history, so that points carry it along; laws
/// that are not wrapped know nothing of it and cost nothing.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PerPoint<M>(
    /// The law at factor 1.
    pub M,
);

/// History of a law, and the point's factor on its strength.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PointHistory<H> {
    /// What the law remembers.
    pub law: H,
    /// Factor on the strength [-].
    pub strength: f64,
}

impl<H: History> PointHistory<H> {
    const ALL: &'static [FieldInfo; FIELDS] =
        &followed(H::FIELDS, FieldInfo { name: "strength_factor", components: 1, unit: "-" });
}

impl<H: History> History for PointHistory<H> {
    const NUMBERS: usize = H::NUMBERS + 1;
    const FIELDS: &'static [FieldInfo] = Self::ALL.split_at(H::FIELDS.len() + 1).0;

    fn store(&self, to: &mut Vec<f64>) {
        self.law.store(to);
        to.push(self.strength);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        let law = H::restore(&from[..H::NUMBERS])?;
        let strength = ParameterError::unless_positive("strength_factor", from[H::NUMBERS]);
        Ok(Self { law, strength: strength.map_err(|error| error.to_string())? })
    }

    fn show(&self, to: &mut Vec<f64>) {
        self.law.show(to);
        to.push(self.strength);
    }
}

impl<M: Scalable> PerPoint<M> {
    /// Whether the law has a solution in every state of a point with the factor `strength`.
    ///
    /// # Errors
    /// `strength` is not positive and finite, or what [`Scalable::check`] says.
    pub fn check(&self, strength: f64) -> Result<(), ParameterError> {
        self.0.scaled(ParameterError::unless_positive("strength_factor", strength)?).check()
    }
}

impl<M: Scalable> Material for PerPoint<M> {
    type History = PointHistory<M::History>;
    const PLASTIC: bool = M::PLASTIC;

    #[inline]
    fn has_symmetric_tangent(&self) -> bool {
        self.0.has_symmetric_tangent()
    }

    fn initial(&self, point: &PointParameters) -> Self::History {
        PointHistory { law: self.0.initial(point), strength: point.strength }
    }

    #[inline]
    fn update(&self, trial: &Vector3<f64>, history: &Self::History) -> Result<Update<Self::History>, NoReturn> {
        let Update { elastic_strain, kirchhoff, tangent, secant, plastic, history: law } =
            self.0.scaled(history.strength).update(trial, &history.law)?;
        let history = PointHistory { law, strength: history.strength };
        Ok(Update { elastic_strain, kirchhoff, tangent, secant, plastic, history })
    }

    #[inline]
    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}
