//! Returns to the tension cut-off, and to where it meets the cone.

use nalgebra::{Matrix3, Vector3};

use super::MohrCoulomb;
use crate::law::YIELD_TOLERANCE;
use crate::ordered::Ordered;
use crate::{PlasticStrain, Update};

/// Where a return may end, in descending order of the trial, with t = t_c and t₃ = [t (1 + s) − 2c cos φ]/(1 − s),
/// the smallest stress that the cone allows beside t. They are tried in this order.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Place {
    /// τ₁ = t.
    Plane,
    /// τ₁ = τ₂ = t.
    Edge,
    /// τ₁ = τ₂ = τ₃ = t.
    Tip,
    /// τ₁ = t, τ₃ = t₃.
    Rim,
    /// τ₁ = t, τ₂ = τ₃ = t₃.
    ExtensionCorner,
    /// τ₁ = τ₂ = t, τ₃ = t₃: four planes meet, those of both stresses t in the cut-off and in the cone.
    CompressionCorner,
}

use Place::{CompressionCorner, Edge, ExtensionCorner, Plane, Rim, Tip};

const PLACES: [Place; 6] = [Plane, Edge, Tip, Rim, ExtensionCorner, CompressionCorner];

/// Elastic strains at a place, in descending order.
struct Candidate {
    elastic: [f64; 3],
    /// By how much it is not the answer [F/L²].
    violation: f64,
}

impl MohrCoulomb {
    /// The first place whose multipliers are not negative, and whose stress violates no other plane. Exactly one
    /// stress is admissible; where several places lead to it, rounding may choose.
    ///
    /// With N the axes whose stresses the place fixes, D = D_e − D_e N (Nᵀ D_e N)⁻¹ Nᵀ D_e, because the active flows
    /// and the active planes span the same axes: where one stress is left free, D is Young's modulus along it.
    #[inline(never)]
    pub(super) fn on_cut_off(
        &self,
        strain: &Vector3<f64>,
        trial: &Ordered,
        scale: f64,
        history: &PlasticStrain,
    ) -> Update<PlasticStrain> {
        let tolerance = YIELD_TOLERANCE * scale;
        // NaN stays first, because nothing is less than it.
        let (mut place, mut found) = (Plane, self.candidate(Plane, trial));
        for other in PLACES.into_iter().skip(1) {
            if found.violation <= tolerance {
                break;
            }
            let candidate = self.candidate(other, trial);
            if candidate.violation < found.violation {
                (place, found) = (other, candidate);
            }
        }
        let two_g = 2.0 * self.elasticity.shear();
        let Candidate { elastic, .. } = found;
        let [e1, e2, e3] = trial.strain;
        let flow = [e1 - elastic[0], e2 - elastic[1], e3 - elastic[2]];
        // Pairs that the place makes equal. The strains of any other may be equal by themselves.
        let equal = match place {
            Plane | Rim => [false; 3],
            Edge | CompressionCorner => [true, false, false],
            ExtensionCorner => [false, true, false],
            Tip => [true; 3],
        };
        let part = |pair: usize, i: usize, j: usize| {
            if equal[pair] {
                0.0
            } else if flow[i] == flow[j] {
                1.0
            } else {
                (elastic[i] - elastic[j]) / (trial.strain[i] - trial.strain[j])
            }
        };
        let secants = [part(0, 0, 1), part(1, 1, 2), part(2, 0, 2)];
        let (lambda, p_wave) = (self.elasticity.lame(), self.elasticity.p_wave());
        let along = |axis: [f64; 3]| Matrix3::from_diagonal(&trial.by_axis(&axis));
        let young = self.elasticity.young();
        let mut added = 0.0;
        let tangent = match place {
            Plane => {
                let free = trial.by_axis(&[0.0, 1.0, 1.0]);
                let across = lambda * two_g / p_wave;
                free * free.transpose() * across + Matrix3::from_diagonal(&(free * two_g))
            }
            Edge => along([0.0, 0.0, young]),
            Rim => along([0.0, young, 0.0]),
            Tip | ExtensionCorner | CompressionCorner => {
                added = self.apex_stiffness;
                self.at_apex()
            }
        };
        let secant = trial.secants(secants.map(|part| part + added)) * two_g;
        self.answer(strain, trial.by_axis(&elastic), tangent, secant, history)
    }

    /// The strains at a place. Where a stress is not fixed, its strain is that of the trial.
    #[inline]
    fn candidate(&self, place: Place, trial: &Ordered) -> Candidate {
        let (lambda, g) = (self.elasticity.lame(), self.elasticity.shear());
        let t = self.cut_off;
        let flow = self.dilation;
        let [e1, e2, e3] = trial.strain;
        // Two strains of which the stresses are given, beside a third.
        let pair = |stresses: (f64, f64), third: f64| {
            let mean = (0.5 * (stresses.0 + stresses.1) - lambda * third) / (2.0 * (lambda + g));
            let half = 0.25 * (stresses.0 - stresses.1) / g;
            (mean + half, mean - half)
        };
        // The strain, the smallest multiplier, and the largest and the smallest stress that are not given.
        let (elastic, least, free) = match place {
            Plane => {
                let overshoot = self.stresses(&trial.strain)[0] - t;
                let first = e1 - overshoot / self.elasticity.p_wave();
                ([first, e2, e3], e1 - first, Some((e2, e3)))
            }
            Edge => {
                let (equal, _) = pair((t, t), e3);
                ([equal, equal, e3], e2 - equal, Some((e3, e3)))
            }
            Tip => {
                let equal = t / (3.0 * self.elasticity.bulk());
                ([equal; 3], e3 - equal, None)
            }
            Rim => {
                let (first, last) = pair((t, self.least()), e2);
                let cone = (last - e3) / (1.0 - flow);
                ([first, e2, last], cone.min(e1 - first - cone * (1.0 + flow)), Some((e2, e2)))
            }
            ExtensionCorner => {
                let (first, last) = self.corner(t, self.least());
                let (outer, inner) = ((last - e3) / (1.0 - flow), (last - e2) / (1.0 - flow));
                let tension = e1 - first - (outer + inner) * (1.0 + flow);
                ([first, last, last], outer.min(inner).min(tension), None)
            }
            CompressionCorner => {
                let (last, first) = self.corner(self.least(), t);
                let cone = (last - e3) / (1.0 - flow);
                let (upper, lower) = (e1 - first, e2 - first);
                // What the cone's planes share out between both axes is at most what flows along them.
                let tension = upper + lower - cone * (1.0 + flow);
                ([first, first, last], cone.min(upper).min(lower).min(tension), None)
            }
        };
        let violation = match free {
            None => -least * g,
            Some((larger, smaller)) => {
                let mean = lambda * (elastic[0] + elastic[1] + elastic[2]);
                let (larger, smaller) = (2.0 * g * larger + mean, 2.0 * g * smaller + mean);
                let passed = self.overshoot(larger.max(t), smaller.min(t)).max(larger - t);
                passed.max(-least * g)
            }
        };
        Candidate { elastic, violation }
    }

    /// t₃ [F/L²].
    #[inline]
    fn least(&self) -> f64 {
        let (sin, cos) = self.friction;
        (self.cut_off * (1.0 + sin) - 2.0 * self.cohesion * cos) / (1.0 - sin)
    }

    /// Strains under one stress `single` and two stresses `double`.
    #[inline]
    fn corner(&self, single: f64, double: f64) -> (f64, f64) {
        let mean = (single + 2.0 * double) / (9.0 * self.elasticity.bulk());
        let shear = (single - double) / (6.0 * self.elasticity.shear());
        (mean + 2.0 * shear, mean - shear)
    }
}
