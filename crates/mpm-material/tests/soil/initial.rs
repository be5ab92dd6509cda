//! Points that begin under stress, and the energy that elastic strains store.

use crate::random::Numbers;
use mpm_material::{
    CamClay, CamClayParameters, ConeMatch, Consolidation, DruckerPrager, Elasticity, Hencky, Material,
    MohrCoulomb, NeoHooke, PerPoint, PointParameters, SymmetricTensor, Tresca, Undrained, UndrainedStrength,
    VonMises, respond, start_under, stored_energy,
};
use nalgebra::Vector3;

fn elasticity(poisson: f64) -> Elasticity {
    Elasticity::from_young_poisson(2e4, poisson).expect("in range")
}

fn clay(shear: f64, shear_ratio: f64) -> CamClay {
    CamClay::new(CamClayParameters {
        critical_ratio: 1.0,
        compression: 0.15,
        swelling: 0.03,
        shear,
        shear_ratio,
        reference_pressure: 20.0,
        preconsolidation: 300.0,
    })
    .expect("in range")
}

/// Something that is done with every law, none of which yields under the stresses of these tests.
trait Visit {
    fn law<M: Material>(&mut self, law: &M);
}

fn visit(to: &mut impl Visit) {
    let strength = UndrainedStrength::perfect(500.0).expect("positive");
    to.law(&Hencky(elasticity(0.3)));
    to.law(&NeoHooke::new(elasticity(0.3)).expect("in range"));
    to.law(&NeoHooke::new(elasticity(0.0)).expect("in range"));
    to.law(&VonMises::with_strength(elasticity(0.3), strength).expect("in range"));
    to.law(&Tresca::new(elasticity(0.3), strength).expect("in range"));
    let sand = MohrCoulomb::new(elasticity(0.3), 500.0, 30.0, 5.0).expect("in range");
    to.law(&sand);
    let cone = DruckerPrager::matched(elasticity(0.3), ConeMatch::PlaneStrain, 500.0, 30.0, 5.0);
    to.law(&cone.expect("in range"));
    to.law(&clay(1500.0, 0.0));
    to.law(&clay(0.0, 30.0));
    to.law(&PerPoint::new(sand));
    to.law(&Undrained::new(clay(1500.0, 0.0), 1e5).expect("positive"));
}

fn stress() -> SymmetricTensor {
    SymmetricTensor { xx: -90.0, yy: -140.0, zz: -85.0, xy: 7.0, yz: -4.0, zx: 3.0 }
}

struct Starts;

impl Visit for Starts {
    fn law<M: Material>(&mut self, law: &M) {
        let point = PointParameters::at(Vector3::zeros());
        let (excess, history) = start_under(law, &point, &stress()).expect("a state");
        let found = respond(law, &excess, &history).expect("a return");
        let error = (found.kirchhoff.to_matrix() - stress().to_matrix()).amax();
        assert!(!found.plastic && error < 1e-11 * 140.0, "{error:e}");
    }
}

#[test]
fn every_law_begins_under_the_stress_that_it_is_given() {
    visit(&mut Starts);
}

struct Energies(Numbers);

impl Visit for Energies {
    /// τ_a = ∂ψ/∂ε_a.
    fn law<M: Material>(&mut self, law: &M) {
        let point = PointParameters::at(Vector3::zeros());
        let (excess, history) = start_under(law, &point, &stress()).expect("a state");
        let start = stored_energy(law, &excess, &history);
        assert!(start.is_finite());
        for _ in 0..20 {
            let strain = Vector3::new(-4e-3, -6e-3, -3e-3) + self.0.strain(1e-3);
            let tau = law.update(&strain, &history).expect("a return").kirchhoff;
            let h = 1e-6;
            for a in 0..3 {
                let energy = |sign: f64| {
                    let mut moved = strain;
                    moved[a] += sign * h;
                    law.stored_energy(&moved, &history)
                };
                let slope = (energy(1.0) - energy(-1.0)) / (2.0 * h);
                assert!((slope - tau[a]).abs() < 1e-6 * (1.0 + tau.amax()), "{slope} {}", tau[a]);
            }
        }
    }
}

#[test]
fn stress_is_the_derivative_of_the_energy() {
    visit(&mut Energies(Numbers(7)));
}

#[test]
fn states_that_no_law_has_are_refused() {
    let point = PointParameters::at(Vector3::zeros());
    let sand = MohrCoulomb::new(elasticity(0.3), 0.0, 30.0, 0.0).expect("in range");
    let at_rest =
        |k0: f64| SymmetricTensor { xx: -k0 * 60.0, yy: -60.0, zz: -k0 * 60.0, ..SymmetricTensor::ZERO };
    // Active and passive: K_a = 1/3, K_p = 3.
    for (k0, is_admissible) in [(0.32, false), (0.34, true), (1.0, true), (2.9, true), (3.1, false)] {
        assert_eq!(start_under(&sand, &point, &at_rest(k0)).is_ok(), is_admissible, "{k0}");
    }
    let reason = start_under(&sand, &point, &at_rest(0.3)).expect_err("beyond yield").reason;
    assert_eq!(reason, "the law yields under it");
    let reason =
        start_under(&clay(1500.0, 0.0), &point, &SymmetricTensor::ZERO).expect_err("no pressure").reason;
    assert!(reason.contains("mean pressure above 0"), "{reason}");
    assert!(start_under(&clay(1500.0, 0.0), &point, &at_rest(12.0)).is_err());
    // Rubber shrinks to nothing at a tension beyond all others.
    let rubber = NeoHooke::new(elasticity(0.3)).expect("in range");
    assert!(start_under(&rubber, &point, &SymmetricTensor { xx: f64::NAN, ..stress() }).is_err());
}

#[test]
fn a_normally_consolidated_clay_begins_on_its_yield_surface() {
    let law = clay(0.0, 30.0);
    let mut point = PointParameters::at(Vector3::zeros());
    let k0 = law.k0();
    for vertical in [1e-3, 1.0, 57.3, 1e5] {
        let tau = Vector3::new(-k0 * vertical, -vertical, -k0 * vertical);
        point.consolidation = Consolidation::Stress(tau);
        let [xx, yy, zz] = tau.into();
        let stress = SymmetricTensor { xx, yy, zz, ..SymmetricTensor::ZERO };
        let (excess, history) = start_under(&law, &point, &stress).expect("on the surface is admissible");
        assert!(!respond(&law, &excess, &history).expect("a return").plastic, "{vertical}");
    }
}
