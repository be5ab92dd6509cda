//! State of one point of a regularised body under a trial displacement and a trial field.

use super::measure::ShearMeasure;
use crate::body::by_point::{Asked, ByPoint, PointLaw};
use crate::body::kinematics::{StepGradient, block};
use crate::body::points::Points;
use crate::body::trial::{InadmissiblePoint, StepOf, dissipated, step_of};
use mpm_grid::{Block, Vector};
use mpm_material::{FieldDriver, FieldResponse, NoReturn, Regularisation, Response, SymmetricTensor};

/// The law of a regularised body, asked point by point.
pub(super) trait FieldLaw: PointLaw {
    /// The answer of a point to its trial excess b_tr − 1 and the field k there; its driver is κ, of laws that have one.
    ///
    /// # Errors
    /// The law finds no admissible state.
    fn respond(
        &self,
        point: usize,
        trial_excess: &SymmetricTensor,
        field: f64,
    ) -> Result<FieldResponse<Asked>, NoReturn>;

    /// The committed driver of a point `[-]`.
    fn driver(&self, point: usize) -> f64;
}

/// Committed points of a regularised body and their law.
#[derive(Clone, Copy)]
pub(super) struct Regularised<'a, const D: usize> {
    pub law: &'a dyn FieldLaw,
    pub points: &'a Points<D>,
    pub regularisation: Regularisation,
}

/// State of a point under a trial.
pub(super) struct FieldTrial<const D: usize> {
    pub step: StepOf<D>,
    /// Of the law, without the stress of the shear measure.
    pub response: Response<Asked>,
    /// b_tr − 1 `[-]`.
    excess: SymmetricTensor,
    /// τ, all of it `[F/L²]`.
    pub kirchhoff: Block<D>,
    /// ∂τ/∂k `[F/L²]`.
    pub by_field: Block<D>,
    /// d `[-]`.
    pub driver: f64,
    /// ∂d/∂k `[-]`.
    pub driver_by_field: f64,
    /// k `[-]`.
    pub field: f64,
    measure: Option<ShearMeasure<D>>,
}

/// A gradient ∇S of the mesh at the start of the step as one at rest, `F_nᵀ ∇S`.
#[inline]
pub(super) fn at_rest<const D: usize>(deformation_gradient: &Block<D>, gradient: &Vector<D>) -> Vector<D> {
    deformation_gradient.tr_mul(gradient)
}

impl<const D: usize> Regularised<'_, D> {
    /// The state of point `p`; `du` and `field` run over its nodes, as its influences do.
    ///
    /// # Errors
    /// The point has no admissible state.
    #[inline]
    pub fn trial(
        &self,
        p: usize,
        du: &[Vector<D>],
        field: &[f64],
        (values, gradients): (&[f64], &[Vector<D>]),
    ) -> Result<FieldTrial<D>, InadmissiblePoint> {
        let h = StepGradient::of::<false>(du, (values, gradients), 0.0);
        let step = step_of::<D, false>(p, &h)?;
        let f = &self.points.deformation_gradient[p];
        let k: f64 = field.iter().zip(values).map(|(value, shape)| value * shape).sum();
        let excess = h.trial_excess::<false>(&self.points.elastic_excess[p]);
        let answer =
            self.law.respond(p, &excess, k).map_err(|reason| InadmissiblePoint::no_return(p, reason))?;
        let FieldResponse { response, by_field, driver, driver_by_field } = answer;
        let mut trial = FieldTrial {
            step,
            kirchhoff: block(&response.kirchhoff),
            response,
            excess,
            by_field: block(&by_field),
            driver,
            driver_by_field,
            field: k,
            measure: None,
        };
        if self.regularisation.driver() == FieldDriver::Strain {
            let measure = ShearMeasure::of(&(trial.step.step * f));
            let modulus = self.regularisation.modulus();
            trial.kirchhoff += measure.slope() * (modulus * (measure.value - k));
            trial.by_field = measure.slope() * -modulus;
            trial.driver = measure.value;
            trial.measure = Some(measure);
        }
        Ok(trial)
    }

    /// Energy that a point dissipates in the step per volume at rest: that of the law, without the part h (κ − k) Δκ, which
    /// is stored `[F/L²]`.
    pub fn dissipated(&self, p: usize, trial: &FieldTrial<D>, law: &ByPoint<'_>) -> f64 {
        let all = dissipated(law, &trial.excess, &trial.response);
        match self.regularisation.driver() {
            FieldDriver::Strain => all,
            FieldDriver::PlasticStrain => {
                let stored = self.regularisation.modulus() * (trial.driver - trial.field);
                all - stored * (trial.driver - self.law.driver(p))
            }
        }
    }
}

impl<const D: usize> FieldTrial<D> {
    /// The spatial tangent, with that of the shear measure.
    #[inline]
    pub fn tangent(&self, regularisation: &Regularisation) -> [[Block<D>; D]; D] {
        let mut a = self.response.tangent.spatial_tangent::<D>();
        if let Some(measure) = &self.measure {
            measure.add_tangent(regularisation.modulus(), self.field, &mut a);
        }
        a
    }
}
