//! Points of a body of revolution that turns: the law of the body is asked point by point.
//!
//! A pass over points is compiled once for each law. With twist it is compiled once for all laws, because tensors are full
//! there and their spectrum costs more than a call: the pass is one for [`ByPoint`], which asks the law of the body behind
//! [`PointLaw`] for each point by its number.

use crate::body::advance::PreparedState;
use crate::body::assembly_plan::AssemblyPlan;
use crate::body::points::Points;
use crate::body::scatter::{PassInput, Sums};
use crate::body::trial::{Committed, InadmissiblePoint};
use crate::body::{dissipation, pass};
use mpm_grid::Vector;
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

    /// See [`Material::update`], without what is remembered.
    ///
    /// # Errors
    /// As of [`Material::update`].
    fn update(&self, point: usize, trial: &Vector3<f64>) -> Result<Update<()>, NoReturn>;
}

/// A point's number, and after an update the trial strains under which the law was asked.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Asked {
    point: u32,
    /// Principal trial strains `[-]`.
    pub trial: Vector3<f64>,
}

impl Asked {
    /// All points of a body of so many.
    pub fn all(points: usize) -> Vec<Self> {
        (0..points as u32).map(|point| Self { point, trial: Vector3::zeros() }).collect()
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
struct ByPoint<'a>(&'a dyn PointLaw);

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
        let Update { elastic_strain, kirchhoff, tangent, secant, plastic, .. } =
            self.0.update(history.point as usize, trial)?;
        let history = Asked { point: history.point, trial: *trial };
        Ok(Update { elastic_strain, kirchhoff, tangent, secant, plastic, history })
    }

    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}

/// A law, its points by number, and their columns.
#[derive(Clone, Copy)]
pub(crate) struct Turning<'a> {
    pub law: &'a dyn PointLaw,
    pub asked: &'a [Asked],
    pub points: &'a Points<3>,
}

impl Turning<'_> {
    /// As [`pass::assemble`].
    pub fn assemble(
        self,
        plan: &AssemblyPlan<3>,
        input: PassInput<'_, 3>,
        sums: Sums<'_, 3>,
    ) -> Result<f64, InadmissiblePoint> {
        let law = ByPoint(self.law);
        let committed = Committed { law: &law, points: self.points, history: self.asked };
        pass::assemble::<3, ByPoint<'_>, true>(committed, plan, input, sums)
    }

    /// As [`dissipation::dissipation`].
    pub fn dissipation(
        self,
        plan: &AssemblyPlan<3>,
        increment: &[Vector<3>],
        gradient: &mut [Vector<3>],
    ) -> Result<f64, InadmissiblePoint> {
        let law = ByPoint(self.law);
        let committed = Committed { law: &law, points: self.points, history: self.asked };
        dissipation::dissipation::<3, ByPoint<'_>, true>(committed, plan, increment, gradient)
    }

    /// As [`PreparedState::advance`]; `asked` is told of every point under which strains its law was asked.
    pub fn advance(
        self,
        plan: &AssemblyPlan<3>,
        increment: &[Vector<3>],
        next: &mut PreparedState<3>,
        asked: &mut Vec<Asked>,
    ) -> Result<(), InadmissiblePoint> {
        let law = ByPoint(self.law);
        let committed = Committed { law: &law, points: self.points, history: self.asked };
        next.advance::<ByPoint<'_>, true>(asked, committed, plan, increment)
    }
}
