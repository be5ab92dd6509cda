//! Sums with points and nodes side by side: the same bits as point by point, with vector registers and without.

// Of which other tests use more.
#[allow(dead_code)]
mod setup;

use mpm_assembly::{Constraints, InadmissibleState, MaterialBody, PassInput, Sums};
use mpm_basis::{Basis, Cpdi1, Gimp, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, Mesh, Vector};
use mpm_material::lanes::{LANES, Lanes};
use mpm_material::{
    CamClay, CamClayParameters, DruckerPrager, Elasticity, Hencky, LaneUpdate, Material, NeoHooke, NoReturn,
    PointParameters, Undrained, Update, VonMises,
};
use nalgebra::Vector3;
use setup::{Setup, connect, field, sum};
use std::process::Command;

/// What [`hashes`] answers; a change of the order of sums or of a function changes it, and belongs into the changelog.
const HASHES: [&str; 7] = [
    "1c2b7986f381d38a",
    "4700fe5e5dcf1175",
    "14df729a7535990c",
    "fe0bfaf401f5a5c9",
    "2908d7f86088f4ac",
    "2c7691e4d9f7c413",
    "ab75c2b8f5db27ff",
];

/// A law that refuses four points at once, so that each is asked for alone.
#[derive(Clone, Copy)]
struct OneByOne<M>(M);

impl<M: Material> Material for OneByOne<M> {
    type History = M::History;
    const PLASTIC: bool = M::PLASTIC;

    fn has_symmetric_tangent(&self) -> bool {
        self.0.has_symmetric_tangent()
    }

    fn initial(&self, point: &PointParameters) -> M::History {
        self.0.initial(point)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &M::History) -> f64 {
        self.0.stored_energy(elastic_strain, history)
    }

    fn update(&self, trial: &Vector3<f64>, history: &M::History) -> Result<Update<M::History>, NoReturn> {
        self.0.update(trial, history)
    }

    fn update_lanes(
        &self,
        _trial: &[Lanes; 3],
        _history: [&M::History; LANES],
    ) -> Result<LaneUpdate<M::History>, NoReturn> {
        Err(NoReturn { reason: "one by one" })
    }

    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}

/// The same law with its answers for four points hidden: a law that knows nothing of lanes.
#[derive(Clone, Copy)]
struct Plain<M>(M);

impl<M: Material> Material for Plain<M> {
    type History = M::History;
    const PLASTIC: bool = M::PLASTIC;

    fn has_symmetric_tangent(&self) -> bool {
        self.0.has_symmetric_tangent()
    }

    fn initial(&self, point: &PointParameters) -> M::History {
        self.0.initial(point)
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &M::History) -> f64 {
        self.0.stored_energy(elastic_strain, history)
    }

    fn update(&self, trial: &Vector3<f64>, history: &M::History) -> Result<Update<M::History>, NoReturn> {
        self.0.update(trial, history)
    }

    fn elasticity(&self) -> Elasticity {
        self.0.elasticity()
    }
}

/// Elastic, and refuses what is stretched in all by more than a twentieth.
#[derive(Clone, Copy)]
struct Brittle(Elasticity);

impl Material for Brittle {
    type History = ();
    const PLASTIC: bool = false;

    fn has_symmetric_tangent(&self) -> bool {
        true
    }

    fn initial(&self, _point: &PointParameters) {}

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, _history: &()) -> f64 {
        Hencky(self.0).stored_energy(elastic_strain, &())
    }

    fn update(&self, trial: &Vector3<f64>, _history: &()) -> Result<Update<()>, NoReturn> {
        if trial.sum() > 0.05 {
            return Err(NoReturn { reason: "it is stretched" });
        }
        Hencky(self.0).update(trial, &())
    }

    fn elasticity(&self) -> Elasticity {
        self.0
    }
}

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(1e3, 0.3).expect("in range")
}

/// A clay without elastic strain, of which parts yield in a wave and parts do not.
fn clay(shear: f64, shear_ratio: f64) -> CamClay {
    CamClay::new(CamClayParameters {
        critical_ratio: 0.9,
        compression: 0.15,
        swelling: 0.03,
        shear,
        shear_ratio,
        reference_pressure: 20.0,
        preconsolidation: 25.0,
    })
    .expect("in range")
}

/// Bits of force, tangent and lift of a body in a trial displacement.
fn bits<const D: usize>(setup: &Setup<D>, increment: &[Vector<D>]) -> Vec<u64> {
    let mut constraints = Constraints::none(setup.active.len());
    constraints.prescribe(3, D - 1, 0.01);
    let (force, tangent, lift) = sum(setup, increment, &constraints);
    let vectors = force.iter().chain(&lift).flat_map(|it| it.iter());
    vectors.chain(&tangent).map(|number| number.to_bits()).collect()
}

fn bits_in_a_wave<const D: usize, B: Basis<D> + 'static, M: Material + 'static>(
    basis: B,
    law: M,
    cells: u32,
) -> Vec<u64> {
    let setup = setup::setup::<D, _, _>(basis, law, cells, 3, None);
    bits(&setup, &field(&setup, 0.02))
}

fn check<const D: usize, B: Basis<D> + Copy + 'static, M: Material + Copy + 'static>(
    basis: B,
    law: M,
    cells: u32,
) {
    let together = bits_in_a_wave::<D, _, _>(basis, law, cells);
    assert!(together == bits_in_a_wave::<D, _, _>(basis, Plain(law), cells), "D = {D}");
    assert!(together == bits_in_a_wave::<D, _, _>(basis, OneByOne(law), cells), "D = {D}");
}

#[test]
fn points_side_by_side_have_the_bits_of_each() {
    let von_mises = VonMises::new(elasticity(), 15.0).expect("positive");
    let unsymmetric = DruckerPrager::new(elasticity(), 0.3, 0.1, 5.0).expect("in range");
    check::<2, _, _>(Smpm, Hencky(elasticity()), 8);
    check::<2, _, _>(Gimp::default(), von_mises, 8);
    check::<2, _, _>(Cpdi1, unsymmetric, 8);
    check::<3, _, _>(Smpm, von_mises, 5);
    check::<3, _, _>(Gimp::default(), unsymmetric, 5);
    check::<3, _, _>(Cpdi1, Hencky(elasticity()), 5);
    check::<2, _, _>(Smpm, clay(1500.0, 0.0), 8);
    check::<3, _, _>(Smpm, clay(500.0, 20.0), 5);
}

/// Of the points of a batch the first in order is named, whether it is its step or its law that is at fault.
#[test]
fn the_first_point_without_a_state_is_named() {
    let setup = setup::setup::<2, _, _>(Smpm, Brittle(elasticity()), 4, 1, None);
    let constraints = Constraints::none(setup.active.len());
    // Two cells side by side, of which the left one comes first.
    let x: Vec<f64> = setup.active.nodes().iter().map(|&node| setup.mesh.position(node)[0]).collect();
    let (low, high) = (x.iter().copied().fold(3.0, f64::min), x.iter().copied().fold(0.0, f64::max));
    let middle = x.into_iter().find(|x| *x > low && *x < high).expect("three columns of nodes");
    let refused = |left: f64, right: f64| {
        let stretched = |x: Vector<2>| {
            let slope = if x[0] < middle { left } else { right };
            Vector::<2>::new(slope * (x[0] - middle), 0.0)
        };
        let nodes = setup.active.nodes().iter();
        let increment: Vec<_> = nodes.map(|&node| stretched(setup.mesh.position(node))).collect();
        let mut internal = vec![Vector::zeros(); increment.len()];
        let sums = Sums { internal: &mut internal, own: &mut [], tangent: None };
        let input =
            PassInput { pattern: &setup.pattern, constraints: &constraints, increment: &increment, own: &[] };
        setup.body.assemble(&setup.plan, input, sums).expect_err("a point has no state").reason
    };
    assert!(matches!(refused(0.2, -3.0), InadmissibleState::NoReturn(_)));
    assert!(matches!(refused(-3.0, 0.2), InadmissibleState::Inverted { .. }));
}

/// A number that depends on all bits of the sums of a body that yields in parts. It is made by arithmetic alone: nothing of it
/// comes from a C library.
fn hash<const D: usize, B: Basis<D> + 'static, M: Material + 'static>(basis: B, law: M, cells: u32) -> u64 {
    let axes = std::array::from_fn(|d| Axis::uniform(0.0, 3.0, cells + d as u32).expect("an axis"));
    let mesh = Mesh::at_rest(&Layout::<D>::on_axes(axes).expect("a layout"));
    let extent = mesh.lattice().cells();
    let inner = mesh.cells().filter(|index| (0..D).all(|d| index[d] > 0 && index[d] + 1 < extent[d]));
    let seeds = seed_cells(&basis, &mesh, inner, 2);
    let setup = connect(Box::new(MaterialBody::new(basis, law, seeds)), mesh);
    let displacement = |x: Vector<D>| Vector::from_fn(|i, _| 0.02 * x[i] * (1.0 - 0.4 * x[(i + 1) % D]));
    let nodes = setup.active.nodes().iter();
    let increment: Vec<Vector<D>> = nodes.map(|&node| displacement(setup.mesh.position(node))).collect();
    let numbers = bits(&setup, &increment);
    numbers.iter().fold(0, |hash, bits| (hash.rotate_left(5) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

fn hashes() -> [u64; 7] {
    let von_mises = VonMises::new(elasticity(), 10.0).expect("positive");
    let unsymmetric = DruckerPrager::new(elasticity(), 0.3, 0.1, 5.0).expect("in range");
    [
        hash::<2, _, _>(Smpm, von_mises, 9),
        hash::<2, _, _>(Cpdi1, unsymmetric, 9),
        hash::<3, _, _>(Smpm, von_mises, 5),
        hash::<3, _, _>(Cpdi1, unsymmetric, 5),
        hash::<3, _, _>(Gimp::default(), NeoHooke::new(elasticity()).expect("in range"), 5),
        hash::<2, _, _>(Smpm, clay(1500.0, 0.0), 9),
        hash::<3, _, _>(Smpm, Undrained::new(clay(0.0, 25.0), 1e4).expect("positive"), 5),
    ]
}

/// In a process of its own, because the choice is made once for each.
#[test]
fn bits_are_the_same_on_every_machine_with_and_without_vector_registers() {
    const CHILD: &str = "MPM_TEST_WITHOUT_VECTORS";
    assert_eq!(hashes().map(|hash| format!("{hash:016x}")), HASHES);
    if std::env::var_os(CHILD).is_none() {
        let without = Command::new(std::env::current_exe().expect("this program"))
            .args(["--exact", "bits_are_the_same_on_every_machine_with_and_without_vector_registers"])
            .env(CHILD, "1")
            .env("MPM_VECTORS", "off")
            .output()
            .expect("a run of this program");
        assert!(without.status.success(), "{}", String::from_utf8_lossy(&without.stdout));
    }
}
