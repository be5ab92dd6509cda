//! Every law asked for four points at once against the same law asked for each of them: the same bits.

use crate::random::Numbers;
use crate::reference::{Table, Visit, tables};
use mpm_material::lanes::{LANES, Lanes, Number, four};
use mpm_material::{
    CamClay, CamClayParameters, DruckerPrager, Elasticity, History, LaneUpdate, Material, PerPoint,
    PointParameters, PrincipalTangent, PrincipalTrial, SymmetricTensor, Undrained, Varied, respond,
};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Excess of principal strains in axes that are aligned with nothing, or with z.
fn excess(numbers: &mut Numbers, in_plane: bool) -> SymmetricTensor {
    let strain = numbers.strain(0.2);
    let angle = numbers.between(-3.0, 3.0);
    let tilt = if in_plane { 0.0 } else { numbers.between(0.1, 1.4) };
    let axes = Rotation3::from_euler_angles(0.0, tilt, angle).into_inner();
    let excess = axes * Matrix3::from_diagonal(&strain.map(|eps| (2.0 * eps).exp_m1())) * axes.transpose();
    let excess = SymmetricTensor::from_matrix(&excess);
    if in_plane { SymmetricTensor { yz: 0.0, zx: 0.0, ..excess } } else { excess }
}

fn side_by_side(of: &[SymmetricTensor; LANES]) -> SymmetricTensor<Lanes> {
    let lanes = |get: fn(&SymmetricTensor) -> f64| Lanes(of.each_ref().map(get));
    SymmetricTensor {
        xx: lanes(|t| t.xx),
        yy: lanes(|t| t.yy),
        zz: lanes(|t| t.zz),
        xy: lanes(|t| t.xy),
        yz: lanes(|t| t.yz),
        zx: lanes(|t| t.zx),
    }
}

fn components<T: Copy>(t: &SymmetricTensor<T>) -> [T; 6] {
    [t.xx, t.yy, t.zz, t.xy, t.yz, t.zx]
}

/// The numbers of some tensors and of tangents.
fn numbers<T: Number>(tensors: &[SymmetricTensor<T>], tangent: &PrincipalTangent<T>) -> Vec<T> {
    let mut all: Vec<T> = tensors.iter().flat_map(components).collect();
    all.extend(tangent.moduli::<3>().as_flattened().as_flattened().as_flattened());
    all.extend(tangent.moduli::<2>().as_flattened().as_flattened().as_flattened());
    let (by_hoop, of_hoop, hoop) = tangent.hoop_moduli();
    all.extend([by_hoop, of_hoop].as_flattened().as_flattened());
    all.push(hoop);
    all
}

#[derive(Default)]
struct Compared {
    points: usize,
    plastic: usize,
}

impl Compared {
    /// Compares the answers of a law to points that remember these.
    fn compare<M: Material>(&mut self, name: &str, law: &M, history: &[M::History; LANES]) {
        let mut random = Numbers(7);
        for step in 0..60 {
            let points: [SymmetricTensor; LANES] = std::array::from_fn(|_| excess(&mut random, step % 2 == 0));
            let each = four(|k| respond(law, &points[k], &history[k]));
            let together = side_by_side(&points);
            let trial = match PrincipalTrial::is_plane(&together).expect("of one kind") {
                true => PrincipalTrial::in_plane(&together),
                // Beside others, by turns.
                false => {
                    let others = side_by_side(&std::array::from_fn(|_| excess(&mut random, false)));
                    PrincipalTrial::in_space([&others, &together])[1]
                }
            };
            let Ok(all) = law.update_lanes(&trial.strain, history.each_ref()) else {
                assert!(each.iter().any(Result::is_err), "{name}: it answers all of them");
                continue;
            };
            let LaneUpdate { principal, plastic, history: after } = &all;
            let (tangent, excess) = (trial.tangent(principal), trial.elastic_excess(&principal.elastic_strain));
            let found = numbers(&[trial.stress(&principal.kirchhoff), excess], &tangent);
            for (lane, one) in each.into_iter().enumerate() {
                let one = one.expect("it answers them together");
                assert_eq!(plastic.get(lane), one.plastic, "{name}");
                assert_eq!(tangent.is_symmetric().get(lane), one.tangent.is_symmetric(), "{name}");
                let mut expected = numbers(&[one.kirchhoff, one.elastic_excess], &one.tangent);
                one.history.store(&mut expected);
                let mut found: Vec<f64> = found.iter().map(|lanes| lanes.0[lane]).collect();
                after[lane].store(&mut found);
                assert_eq!(found.len(), expected.len());
                for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    // An elastic point keeps its excess.
                    let same = found.to_bits() == expected.to_bits() || (6..12).contains(&k) && !one.plastic;
                    assert!(same, "{name} {step} {lane}, number {k}: {found:e}, alone {expected:e}");
                }
                self.points += 1;
                self.plastic += usize::from(one.plastic);
            }
        }
    }

    /// The same of points that have the parameters of these laws.
    fn compare_points<M: Varied>(&mut self, name: &str, laws: [M; LANES]) {
        let points = four(|k| {
            let mut point = PointParameters::at(Vector3::zeros());
            point.own = Some(laws[k].own());
            point
        });
        let [law, ..] = laws;
        let law = PerPoint::new(law);
        self.compare(name, &law, &points.each_ref().map(|point| law.initial(point)));
    }
}

impl Visit for Compared {
    fn law<M: Material>(
        &mut self,
        table: &Table,
        law: &M,
        start: impl Fn(f64) -> M::History,
        _number: impl Fn(&M::History) -> f64,
        _strain: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) {
        let history = start(table.number(&table.rows[0], "history_in").unwrap_or(0.0));
        self.compare(&table.name, law, &[history; LANES]);
    }
}

#[test]
fn four_points_at_once_have_the_bits_of_each() {
    let mut compared = Compared::default();
    for table in tables("states_") {
        table.visit(&mut compared);
    }
    let Compared { points, plastic } = compared;
    assert!(points > 2000 && plastic > points / 5 && plastic < points, "{plastic} of {points} yield");
}

/// Pore fluid, and parameters of points.
#[test]
fn wrapped_laws_have_the_bits_of_each() {
    let elasticity = Elasticity::from_young_poisson(2e4, 0.3).expect("in range");
    let cones = [0.7, 1.0, 1.2, 0.9]
        .map(|slope| DruckerPrager::new(elasticity, slope, 0.2, 8.0 * slope).expect("in range"));
    // Without a constant part of the shear modulus, with nothing else, and with both.
    let clays = [(0.0, 25.0), (1500.0, 0.0), (900.0, 10.0), (1500.0, 0.0)].map(|(shear, shear_ratio)| {
        CamClay::new(CamClayParameters {
            critical_ratio: 0.9,
            compression: 0.15,
            swelling: 0.03 + 1e-5 * shear_ratio,
            shear,
            shear_ratio,
            reference_pressure: 20.0,
            preconsolidation: 25.0,
        })
        .expect("in range")
    });
    let mut compared = Compared::default();
    let start = PointParameters::at(Vector3::zeros());
    let wet = |law| Undrained::new(law, 1e5).expect("positive");
    compared.compare("a wet cone", &wet(cones[0]), &[wet(cones[0]).initial(&start); LANES]);
    let wet = |law| Undrained::new(law, 1e5).expect("positive");
    compared.compare("a wet clay", &wet(clays[2]), &[wet(clays[2]).initial(&start); LANES]);
    compared.compare_points("cones", cones);
    compared.compare_points("clays", clays);
    let bulks = [1e5, 2e5, 3e5, 4e5];
    compared.compare_points("wet cones", four(|k| Undrained::new(cones[k], bulks[k]).expect("positive")));
    compared.compare_points("wet clays", four(|k| Undrained::new(clays[k], bulks[k]).expect("positive")));
    let Compared { points, plastic } = compared;
    assert!(points > 1000 && plastic > points / 5 && plastic < points, "{plastic} of {points} yield");
}

#[test]
fn points_of_both_kinds_are_taken_apart() {
    let mut random = Numbers(3);
    let points = [true, true, false, true].map(|in_plane| excess(&mut random, in_plane));
    assert!(PrincipalTrial::is_plane(&side_by_side(&points)).is_none());
    assert!(PrincipalTrial::is_plane(&side_by_side(&[points[2]; LANES])) == Some(false));
}
