//! Returns to the tension cut-off, and to where it meets the cone.

use nalgebra::{Matrix3, Vector3};

use super::MohrCoulomb;
use crate::ordered::Ordered;
use crate::von_mises::YIELD_TOLERANCE;
use crate::{PlasticStrain, Update};

/// A plane of the yield surface, by the places of its stresses in descending order of the trial.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Plane {
    /// Of the cone: the larger and the smaller stress.
    Cone(usize, usize),
    /// Of the cut-off.
    Tension(usize),
}

use Plane::{Cone, Tension};

/// Sets of active planes to be tried in this order, each with the pairs (1, 2), (2, 3), (1, 3) that it makes
/// equal. At τ₁ = τ₂ = t_c four planes meet, and any three of them may be those whose multipliers are
/// not negative. Sets of the cone alone are dealt with before.
const CANDIDATES: [(&[Plane], [bool; 3]); 9] = [
    (&[Tension(0)], [false; 3]),
    (&[Tension(0), Tension(1)], [true, false, false]),
    (&[Cone(0, 2), Tension(0)], [false; 3]),
    (&[Cone(0, 2), Cone(0, 1), Tension(0)], [false, true, false]),
    (&[Cone(0, 2), Tension(0), Tension(1)], [true, false, false]),
    (&[Cone(0, 2), Cone(1, 2), Tension(0)], [true, false, false]),
    (&[Cone(0, 2), Cone(1, 2), Tension(1)], [true, false, false]),
    (&[Cone(1, 2), Tension(0), Tension(1)], [true, false, false]),
    (&[Tension(0), Tension(1), Tension(2)], [true; 3]),
];

/// A set of planes with the strain that its return leaves.
struct Candidate {
    /// One column a plane; those of planes that are not there are zero.
    normals: Matrix3<f64>,
    flows: Matrix3<f64>,
    /// (N_fᵀ D_e N_g)⁻¹, the identity where planes are not there.
    inverse: Matrix3<f64>,
    multipliers: Vector3<f64>,
    elastic: Vector3<f64>,
}

impl MohrCoulomb {
    /// The first set whose multipliers are not negative, and whose stress violates no other plane:
    ///
    /// D = D_e − D_e N_g (N_fᵀ D_e N_g)⁻¹ N_fᵀ D_e, zero for three planes.
    ///
    /// Exactly one stress is admissible; where several sets lead to it, rounding may choose.
    #[inline(never)]
    pub(super) fn on_cut_off(
        &self,
        strain: &Vector3<f64>,
        trial: &Ordered,
        scale: f64,
        history: &PlasticStrain,
    ) -> Update<PlasticStrain> {
        let tolerance = YIELD_TOLERANCE * scale;
        let stiffness =
            Matrix3::from_diagonal_element(2.0 * self.elasticity.shear()).add_scalar(self.elasticity.lame());
        let mut best: Option<(f64, Candidate, &[Plane], [bool; 3])> = None;
        for (planes, equal) in CANDIDATES {
            let Some(candidate) = self.candidate(planes, trial, &stiffness) else { continue };
            let violation = self.violation(&candidate, &stiffness);
            // NaN is no better than anything.
            if best.as_ref().is_none_or(|(least, ..)| violation < *least) {
                best = Some((violation, candidate, planes, equal));
            }
            if violation <= tolerance {
                break;
            }
        }
        // None: only where the strains are no numbers.
        let Some((_, found, planes, equal)) = best else {
            let nothing = Vector3::repeat(f64::NAN);
            return self.answer(strain, nothing, Matrix3::repeat(f64::NAN), nothing, history);
        };
        let elastic = [found.elastic[0], found.elastic[1], found.elastic[2]];
        let tangent = if planes.len() == 3 {
            Matrix3::zeros()
        } else {
            let lost = (stiffness * found.flows) * found.inverse * (stiffness * found.normals).transpose();
            let sorted = stiffness - lost;
            // Rows, then columns, back to their axes.
            let rows = [0, 1, 2].map(|b| trial.by_axis(&sorted.column(b).into_owned().into()));
            let rows = Matrix3::from_columns(&rows).transpose();
            let columns = [0, 1, 2].map(|a| trial.by_axis(&rows.column(a).into_owned().into()));
            Matrix3::from_columns(&columns).transpose()
        };
        let flow = found.flows * found.multipliers;
        let part = |pair: usize, i: usize, j: usize| {
            if equal[pair] {
                0.0
            } else if flow[i] == flow[j] {
                1.0
            } else {
                (elastic[i] - elastic[j]) / (trial.strain[i] - trial.strain[j])
            }
        };
        let secant = trial.secants([part(0, 0, 1), part(1, 1, 2), part(2, 0, 2)]);
        let secant = secant * (2.0 * self.elasticity.shear());
        self.answer(strain, trial.by_axis(&elastic), tangent, secant, history)
    }

    /// Return with all of `planes` active; `None` where they cannot be met together.
    fn candidate(&self, planes: &[Plane], trial: &Ordered, stiffness: &Matrix3<f64>) -> Option<Candidate> {
        let ((s, _), t) = (self.friction, self.dilation);
        let strain = Vector3::from(trial.strain);
        let tau = stiffness * strain;
        let (mut normals, mut flows, mut overshoot) = (Matrix3::zeros(), Matrix3::zeros(), Vector3::zeros());
        for (column, plane) in planes.iter().enumerate() {
            match *plane {
                Cone(i, j) => {
                    normals[(i, column)] = 1.0 + s;
                    normals[(j, column)] = -1.0 + s;
                    flows[(i, column)] = 1.0 + t;
                    flows[(j, column)] = -1.0 + t;
                    overshoot[column] = self.overshoot(tau[i], tau[j]);
                }
                Tension(i) => {
                    normals[(i, column)] = 1.0;
                    flows[(i, column)] = 1.0;
                    overshoot[column] = tau[i] - self.cut_off;
                }
            }
        }
        let mut system = normals.transpose() * stiffness * flows;
        for column in planes.len()..3 {
            system[(column, column)] = 1.0;
        }
        let inverse = system.try_inverse()?;
        let multipliers = inverse * overshoot;
        Some(Candidate { normals, flows, inverse, multipliers, elastic: strain - flows * multipliers })
    }

    /// By how much a candidate is not the answer [F/L²]: a negative multiplier, as the stress that it would
    /// carry, or a plane that is passed.
    fn violation(&self, candidate: &Candidate, stiffness: &Matrix3<f64>) -> f64 {
        let tau = stiffness * candidate.elastic;
        let negative = -candidate.multipliers.min() * self.elasticity.shear();
        let (largest, smallest) = (tau.max(), tau.min());
        negative.max(self.overshoot(largest, smallest)).max(largest - self.cut_off)
    }
}
