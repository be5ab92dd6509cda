//! A law behind an interface that asks it point by point, so that a pass need not be compiled for it.
//!
//! A pass over points is compiled once for each law. Where the law is a small part of the work a pass is compiled once
//! for all laws: it is one for [`ByPoint`], which asks the law of the body behind [`PointLaw`] for each point by its number.

use mpm_material::{Elasticity, FieldInfo, History, Material, NoReturn, PointParameters, Update};
use nalgebra::Vector3;

/// A law with what it remembers of the points of a body.
pub(crate) trait PointLaw: Send + Sync {
    /// See [`Material::has_symmetric_tangent`].
    fn has_symmetric_tangent(&self) -> bool;

    /// See [`Material::elasticity`].
    fn elasticity(&self) -> Elasticity;

    /// See [`Material::stored_energy`].
    fn stored_energy(&self, point: usize, elastic_strain: &Vector3<f64>) -> f64;

    /// See [`Material::fluid_stress`].
    fn fluid_stress(&self, point: usize, volumetric: f64) -> f64;

    /// See [`Material::update`], without what is remembered; `field` is the nodal field at the point, 0 without one.
    ///
    /// # Errors
    /// As of [`Material::update`].
    fn update(&self, point: usize, trial: &Vector3<f64>, field: f64) -> Result<Update<()>, NoReturn>;
}

/// A point's number and the nodal field there, and after an update the trial strains under which the law was asked.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Asked {
    point: u32,
    /// Value of the nodal field of a regularised law `[-]`; 0 without one.
    pub field: f64,
    /// Principal trial strains `[-]`.
    pub trial: Vector3<f64>,
}

impl Asked {
    /// A point that has been asked.
    pub fn of(point: usize, field: f64, trial: &Vector3<f64>) -> Self {
        Self { point: point as u32, field, trial: *trial }
    }

    /// All points of a body of so many.
    pub fn all(points: usize) -> Vec<Self> {
        (0..points as u32).map(|point| Self { point, ..Self::default() }).collect()
    }
}

impl History for Asked {
    const NUMBERS: usize = 0;
    const FIELDS: &'static [FieldInfo] = &[];

    fn store(&self, _to: &mut Vec<f64>) {}

    fn restore(_from: &[f64]) -> Result<Self, String> {
        Ok(Self::default())
    }
}

/// The law of a body as one that remembers which point it answers for.
pub(crate) struct ByPoint<'a>(pub &'a dyn PointLaw);

impl Material for ByPoint<'_> {
    type History = Asked;

    // Laws that never yield say so in every answer.
    const PLASTIC: bool = true;

    fn has_symmetric_tangent(&self) -> bool {
        self.0.has_symmetric_tangent()
    }

    fn initial(&self, _point: &PointParameters) -> Asked {
        Asked::default()
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &Asked) -> f64 {
        self.0.stored_energy(history.point as usize, elastic_strain)
    }

    fn fluid_stress(&self, volumetric: f64, history: &Asked) -> f64 {
        self.0.fluid_stress(history.point as usize, volumetric)
    }

    fn update(&self, trial: &Vector3<f64>, history: &Asked) -> Result<Update<Asked>, NoReturn> {
        let update = self.0.update(history.point as usize, trial, history.field)?;
        Ok(update.with_history(Asked { trial: *trial, ..*history }))
    }

    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}
