//! One material point, driven through strain, stress, or both.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::elementary::exp_m1;
use crate::{Material, NoReturn, PointParameters, SymmetricTensor, respond, start_under};

/// What one component does in a step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Control {
    /// It is deformed by so much [-]: a logarithmic stretch along an axis, an angle of simple shear.
    Strain(f64),
    /// Its Cauchy stress is this at the end [F/L²].
    Stress(f64),
}

/// A step of a driven point, ΔF = [[exp a₁, γ, 0], [0, exp a₂, 0], [0, 0, exp a₃]]: the controls of a₁, a₂, a₃ (with
/// σ₁₁, σ₂₂, σ₃₃) and of γ (with σ₁₂).
pub type StepControl = [Control; 4];

/// A point that its control does not lead on.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum NotDriven {
    /// The law has no state there.
    #[error(transparent)]
    NoReturn(#[from] NoReturn),
    /// No strain gives the stresses that are asked for.
    #[error("no strain was found that gives the stresses asked for: the nearest are off by {0:e}")]
    NoBalance(f64),
}

/// A material point under a law.
#[derive(Clone, Debug)]
pub struct DrivenPoint<'a, M: Material> {
    law: &'a M,
    /// F since the start [-].
    deformation: Matrix3<f64>,
    excess: SymmetricTensor,
    history: M::History,
    /// Cauchy stress [F/L²].
    stress: SymmetricTensor,
    plastic: bool,
}

impl<'a, M: Material> DrivenPoint<'a, M> {
    /// A point that begins under the Cauchy stress `stress` [F/L²].
    ///
    /// # Errors
    /// The law has no elastic state with this stress.
    pub fn new(law: &'a M, point: &PointParameters, stress: &SymmetricTensor) -> Result<Self, NoReturn> {
        let (excess, history) = start_under(law, point, stress)?;
        Ok(Self { law, deformation: Matrix3::identity(), excess, history, stress: *stress, plastic: false })
    }

    /// F since the start [-].
    pub fn deformation(&self) -> &Matrix3<f64> {
        &self.deformation
    }

    /// Cauchy stress [F/L²].
    pub fn stress(&self) -> &SymmetricTensor {
        &self.stress
    }

    /// Whether the last step was plastic.
    pub fn is_plastic(&self) -> bool {
        self.plastic
    }

    /// Components of the law's [`Material::history_fields`].
    pub fn history(&self) -> Vec<f64> {
        let mut shown = Vec::new();
        self.law.show(&self.history, &mut shown);
        shown
    }

    /// Takes a step. Stresses are met by Newton's method with differences for derivatives; directions in which they do
    /// not change, as between two equal stresses on an edge of a yield surface, are left alone.
    ///
    /// # Errors
    /// The law finds no state, or no strain gives the stresses; the point stays as it was.
    pub fn step(&mut self, control: &StepControl) -> Result<(), NotDriven> {
        const ITERATIONS: usize = 100;
        const HALVINGS: usize = 12;
        /// Out-of-balance stress that is accepted, as a part of the largest stress; usually it ends at round-off.
        const ACCEPTED: f64 = 1e-10;

        let mut strains = control.map(|it| if let Control::Strain(by) = it { by } else { 0.0 });
        let free: Vec<usize> = (0..4).filter(|&k| matches!(control[k], Control::Stress(_))).collect();
        let mut now = self.after(&strains)?;
        let mut off = residual(&now, control, &free);
        for _ in 0..ITERATIONS {
            if off.amax() == 0.0 {
                break;
            }
            let Some(correction) = self.correction(&strains, control, &free, &off)? else { break };
            let (mut part, mut better) = (1.0, None);
            for _ in 0..HALVINGS {
                let mut tried = strains;
                free.iter().zip(correction.iter()).for_each(|(&k, by)| tried[k] -= part * by);
                if let Ok(next) = self.after(&tried) {
                    let left = residual(&next, control, &free);
                    if left.amax() < off.amax() {
                        better = Some((tried, next, left));
                        break;
                    }
                }
                part *= 0.5;
            }
            // Round-off is reached, or nothing is better.
            let Some(found) = better else { break };
            (strains, now, off) = found;
        }
        let largest = now.stress.to_matrix().amax();
        let asked = control.iter().fold(largest, |most, it| match it {
            Control::Stress(stress) => most.max(stress.abs()),
            Control::Strain(_) => most,
        });
        if off.amax() > ACCEPTED * asked || off.amax().is_nan() {
            return Err(NotDriven::NoBalance(off.amax()));
        }
        *self = now;
        Ok(())
    }

    /// The point after a step of these strains.
    fn after(&self, &[a1, a2, a3, shear]: &[f64; 4]) -> Result<Self, NoReturn> {
        let h = Matrix3::new(exp_m1(a1), shear, 0.0, 0.0, exp_m1(a2), 0.0, 0.0, 0.0, exp_m1(a3));
        let step = Matrix3::identity() + h;
        let carried = step * self.excess.to_matrix() * step.transpose();
        let trial = SymmetricTensor::from_matrix(&(h + h.transpose() + h * h.transpose() + carried));
        let response = respond(self.law, &trial, &self.history)?;
        let deformation = step * self.deformation;
        let stress =
            SymmetricTensor::from_matrix(&(response.kirchhoff.to_matrix() / deformation.determinant()));
        let (excess, history) = (response.elastic_excess, response.history);
        Ok(Self { law: self.law, deformation, excess, history, stress, plastic: response.plastic })
    }

    /// What Newton's method takes off the free strains; `None` where no stress depends on them.
    fn correction(
        &self,
        strains: &[f64; 4],
        control: &StepControl,
        free: &[usize],
        off: &DVector<f64>,
    ) -> Result<Option<DVector<f64>>, NoReturn> {
        const DIFFERENCE: f64 = 1e-8;
        /// Smaller singular values, as parts of the largest, are what differences leave of zero.
        const SINGULAR: f64 = 1e-7;

        let mut jacobian = DMatrix::zeros(free.len(), free.len());
        for (column, &k) in free.iter().enumerate() {
            let mut moved = *strains;
            moved[k] += DIFFERENCE;
            let change = residual(&self.after(&moved)?, control, free) - off;
            jacobian.set_column(column, &(change / DIFFERENCE));
        }
        if !jacobian.iter().all(|entry| entry.is_finite()) {
            return Ok(None);
        }
        let parts = jacobian.svd(true, true);
        let largest = parts.singular_values.max();
        if largest == 0.0 {
            return Ok(None);
        }
        Ok(parts.solve(off, SINGULAR * largest).ok())
    }
}

/// Stresses of the free components less those that are asked for.
fn residual<M: Material>(point: &DrivenPoint<'_, M>, control: &StepControl, free: &[usize]) -> DVector<f64> {
    let SymmetricTensor { xx, yy, zz, xy, .. } = point.stress;
    let stress = [xx, yy, zz, xy];
    let off = |&k: &usize| match control[k] {
        Control::Stress(asked) => stress[k] - asked,
        Control::Strain(_) => 0.0,
    };
    DVector::from_iterator(free.len(), free.iter().map(off))
}

/// p = −⅓ tr σ and q = √(3/2) |dev σ| [F/L²].
pub fn invariants(stress: &SymmetricTensor) -> (f64, f64) {
    let SymmetricTensor { xx, yy, zz, xy, yz, zx } = *stress;
    let differences = Vector3::new(xx - yy, yy - zz, zz - xx).norm_squared();
    let shear = xy * xy + yz * yz + zx * zx;
    (-(xx + yy + zz) / 3.0, (0.5 * differences + 3.0 * shear).sqrt())
}
