//! `locate` inverts positions on boxes, bent boxes and rings; its rules at faces and beyond.

use mpm_grid::{
    Axis, Block, DrivenPlane, Layout, LoadFraction, Mesh, MeshMotion, NodeId, Ramp, Reindexing, Span, Vector,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::array::from_fn;

/// One mesh of every kind, its parameters drawn from `r` (numbers in [0, 1)).
fn meshes<const D: usize>(r: &[f64]) -> Vec<(&'static str, Mesh<D>)> {
    let at = LoadFraction::new(r[0]).unwrap();
    let axes: [Axis; D] = from_fn(|d| {
        let ratio = 0.3 + 3.0 * r[1 + d];
        Axis::geometric(-1.0, 2.0 + r[4 + d], 5 + 2 * u32::try_from(d).unwrap(), ratio).unwrap()
    });
    let height = || (D == 3).then(|| Axis::geometric(0.0, 2.0, 3, 2.0).unwrap());
    let radii = || Axis::geometric(1.0, 3.0, 4, 1.0 + r[1]).unwrap();
    let solid = Layout::<D>::on_axes(axes).unwrap();
    let full = Layout::<D>::ring([0.3, -0.2], radii(), 24, Span::Full, height()).unwrap();
    let span = Span::Sector { from: 2.0 + r[2], to: 4.0 + r[2] };
    let open = Layout::<D>::ring([0.3, -0.2], radii(), 5, span, height()).unwrap();

    let displacement = Ramp::linear(2.0 * r[7] - 0.5);
    let pulled = DrivenPlane { anchor: 1.5, driven: -0.5, displacement };
    let stretch = MeshMotion::stretch(from_fn(|d| (d == 0).then(|| pulled.clone()))).unwrap();
    let ramp = |c: usize, d: usize| Ramp::linear(1.2 * r[(8 + c * D + d) % r.len()] - 0.6);
    let corners = MeshMotion::corners((0..1 << D).map(|c| from_fn(|d| ramp(c, d))).collect());
    let rotate = || MeshMotion::rotate([1.0, 0.4], Ramp::linear(20.0 * r[9])).unwrap();
    let twist = |angle, reindexing| {
        let inner = (1.0, Ramp::linear(angle));
        MeshMotion::twist([0.3, -0.2], inner, (3.0, Ramp::constant(0.1)), reindexing).unwrap()
    };
    [
        ("box", MeshMotion::Fixed.mesh_at(&solid, at)),
        ("stretched box", stretch.mesh_at(&solid, at)),
        ("bent box", corners.unwrap().mesh_at(&solid, at)),
        ("rotated box", rotate().mesh_at(&solid, at)),
        ("ring", MeshMotion::Fixed.mesh_at(&full, at)),
        ("rotated ring", rotate().mesh_at(&full, at)),
        ("twisted ring", twist(r[10], Reindexing::Off).mesh_at(&full, at)),
        ("re-indexed ring", twist(30.0 * r[10], Reindexing::WholeCells).mesh_at(&full, at)),
        ("sector", MeshMotion::Fixed.mesh_at(&open, at)),
        ("rotated sector", rotate().mesh_at(&open, at)),
        ("twisted sector", twist(-r[10], Reindexing::Off).mesh_at(&open, at)),
    ]
    .into_iter()
    .map(|(name, mesh)| (name, mesh.unwrap_or_else(|error| panic!("{name}: {error}"))))
    .collect()
}

fn inverts<const D: usize>(r: &[f64]) {
    for (name, mesh) in meshes::<D>(r) {
        let cells = mesh.lattice().cells();
        let drawn = |d: usize| (f64::from(cells[d]) * r[11 + d]).floor();
        let cell: [u32; D] = from_fn(|d| (0..cells[d]).find(|&i| f64::from(i) == drawn(d)).unwrap());
        let local = Vector::<D>::from_fn(|d, _| 1.98 * r[14 + d] - 0.99);
        let x = mesh.linear_cell(cell).position(&local);

        let place = mesh.locate(&x, 0.0).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(place.cell, cell, "{name}");
        assert!((place.local - local).norm() < 1e-10, "{name}: {}", (place.local - local).norm());
        let hint = mesh.locate(&mesh.linear_cell(from_fn(|d| cells[d] / 2)).position(&local), 0.0);
        let near = mesh.locate_near(&x, 0.0, &hint.unwrap()).unwrap();
        assert!(near.cell == cell && (near.local - place.local).norm() < 1e-10, "{name}");

        let (mut one, mut here) = (0.0, Vector::<D>::zeros());
        let (mut zero, mut identity) = (Vector::<D>::zeros(), Block::<D>::zeros());
        let mut alone = Vec::new();
        mesh.values(&place, |node, value| alone.push((node, value)));
        let mut both = Vec::new();
        mesh.values_and_gradients(&place, |node, value, gradient| {
            both.push((node, value));
            one += value;
            here += value * mesh.position(node);
            zero += gradient;
            identity += mesh.position(node) * gradient.transpose();
        });
        assert_eq!(alone, both, "{name}");
        assert!((one - 1.0).abs() < 1e-14 && (here - x).norm() < 1e-12, "{name}");
        assert!(zero.norm() < 1e-11, "{name}: {zero}");
        assert!((identity - Block::identity()).norm() < 1e-11, "{name}: {identity}");
    }
}

/// Every node is found at the upper side of the cell below it.
fn nodes_belong_to_the_lower_cell<const D: usize>(r: &[f64]) {
    for (name, mesh) in meshes::<D>(r) {
        let lattice = mesh.lattice();
        let periodic = lattice.periodic();
        for node in (0..lattice.n_nodes()).map(|i| NodeId::from_index(i).unwrap()) {
            let place = mesh.locate(&mesh.position(node), 0.0).unwrap();
            let index = lattice.node_index(node);
            for d in 0..D {
                let expected = match (index[d], periodic[d]) {
                    (0, false) => (0, -1.0),
                    (0, true) => (lattice.cells()[d] - 1, 1.0),
                    (i, _) => (i - 1, 1.0),
                };
                assert_eq!((place.cell[d], place.local[d]), expected, "{name}: {index:?}");
            }
        }
    }
}

/// The same cases in every run, and no files written on failure.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

proptest! {
    #![proptest_config(cases(256))]
    #[test]
    fn locate_inverts_positions(r in prop::collection::vec(0.0..1.0, 32)) {
        inverts::<2>(&r);
        inverts::<3>(&r);
    }
}

proptest! {
    #![proptest_config(cases(16))]
    #[test]
    fn faces_belong_to_the_lower_cell(r in prop::collection::vec(0.0..1.0, 32)) {
        nodes_belong_to_the_lower_cell::<2>(&r);
        nodes_belong_to_the_lower_cell::<3>(&r);
    }
}

fn box_mesh() -> Mesh<2> {
    let axes = [Axis::uniform(0.0, 4.0, 4).unwrap(), Axis::uniform(0.0, 1.0, 2).unwrap()];
    Mesh::at_rest(&Layout::on_axes(axes).unwrap())
}

fn ring_mesh(angle: f64) -> Mesh<2> {
    let radii = Axis::uniform(5.0, 10.0, 5).unwrap();
    let layout = Layout::<2>::ring([0.0; 2], radii, 32, Span::Full, None).unwrap();
    let motion = MeshMotion::rotate([0.0; 2], Ramp::constant(angle)).unwrap();
    motion.mesh_at(&layout, LoadFraction::START).unwrap()
}

#[test]
fn beyond_a_box_its_cells_continue() {
    let mesh = box_mesh();
    let x = Vector::<2>::new(4.3, -0.2);
    let outside = mesh.locate(&x, 0.0).unwrap_err();
    assert_eq!(outside.position, x);
    assert!((outside.distance - 0.4).abs() < 1e-14, "{outside}");
    let place = mesh.locate(&x, 0.5).unwrap();
    assert_eq!(place.cell, [3, 0]);
    assert!((place.local - Vector::<2>::new(1.6, -1.8)).norm() < 1e-14);
    assert!(mesh.locate(&Vector::<2>::new(4.5, 0.1), 0.5).is_ok());
    assert!(mesh.locate(&Vector::<2>::new(4.5 + 1e-8, 0.1), 0.5).is_err());
    // A billionth of a cell outside is inside, two are not.
    assert_eq!(mesh.locate(&Vector::<2>::new(4.0 + 0.9e-9, 0.1), 0.0).unwrap().local[0], 1.0);
    assert!(mesh.locate(&Vector::<2>::new(4.0 + 2e-9, 0.1), 0.0).is_err());
}

#[test]
fn beyond_a_ring_its_cells_continue() {
    for turn in [0.0, 0.05, 3.0] {
        let mesh = ring_mesh(turn);
        for i in 0..1000 {
            let angle = 0.01 * f64::from(i);
            let direction = Vector::<2>::new(angle.cos(), angle.sin());
            let linear = |x: &Vector<2>| {
                let mut sum = Vector::<2>::zeros();
                mesh.values(&mesh.locate(x, 0.5).unwrap(), |v, n| sum += n * mesh.position(v));
                sum
            };
            for r in [4.6, 5.0, 7.3, 10.0, 10.4] {
                let x = r * direction;
                assert!((linear(&x) - x).norm() < 1e-12, "{r} at {angle}");
            }
            let far = mesh.locate(&(12.0 * direction), 0.5).unwrap_err();
            assert!((1.9..2.2).contains(&far.distance), "{far}");
            assert!(mesh.locate(&(3.5 * direction), 0.5).is_err());
        }
        // The chords of the polygon lie inside its circle.
        assert!(mesh.locate(&Vector::<2>::new(0.0, 0.0), 0.5).is_err());
        let middle = turn + std::f64::consts::PI / 32.0;
        let x = 9.99 * Vector::<2>::new(middle.cos(), middle.sin());
        assert!(mesh.locate(&x, 0.0).is_err() && mesh.locate(&x, 0.5).is_ok());
    }
}

fn kite_mesh() -> Mesh<2> {
    let axis = || Axis::uniform(0.0, 2.0, 2).unwrap();
    let path = (0..4).map(|c| from_fn(|_| Ramp::constant(if c == 3 { 3.0 } else { 0.0 })));
    let layout = Layout::on_axes([axis(), axis()]).unwrap();
    let motion = MeshMotion::corners(path.collect()).unwrap();
    motion.mesh_at(&layout, LoadFraction::START).unwrap()
}

#[test]
fn beyond_a_bent_box_its_cells_continue() {
    let mesh = kite_mesh();
    let out = Vector::<2>::new(1.7, 1.4);
    let x = mesh.linear_cell([1, 1]).position(&out);
    let place = mesh.locate(&x, 0.5).unwrap();
    assert_eq!(place.cell, [1, 1]);
    assert!((place.local - out).norm() < 1e-12);
    let outside = mesh.locate(&x, 0.3).unwrap_err();
    assert!((outside.distance - 0.35).abs() < 1e-12, "{outside}");
    assert!(mesh.locate(&Vector::<2>::new(-1e3, 1e4), 0.5).is_err());
}

#[test]
fn theta_wraps_round_the_seam() {
    let mesh = ring_mesh(0.0);
    for (y, cell, local) in [(1e-3, 0, -1.0), (-1e-3, 31, 1.0), (0.0, 31, 1.0)] {
        let place = mesh.locate(&Vector::<2>::new(7.5, y), 0.0).unwrap();
        assert_eq!(place.cell, [cell, 2]);
        assert!((place.local[0] - local).abs() < 2e-3);
        assert_eq!(place.local[0] == 1.0, y == 0.0);
        let mut nodes = Vec::new();
        mesh.values(&place, |node, _| nodes.push(mesh.lattice().node_index(node)[0]));
        assert_eq!(nodes, [cell, (cell + 1) % 32, cell, (cell + 1) % 32]);
    }
    // From the far side of the ring, the walk crosses the seam.
    let hint = mesh.locate(&Vector::<2>::new(7.5, -0.5), 0.0).unwrap();
    let place = mesh.locate_near(&Vector::<2>::new(7.5, 0.5), 0.0, &hint).unwrap();
    assert_eq!(place.cell, [0, 2]);
}

#[test]
fn what_is_no_position_is_outside() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let x = Vector::<2>::new(x, 0.5);
        assert!(box_mesh().locate(&x, 0.5).is_err());
        assert!(ring_mesh(0.1).locate(&x, 0.5).is_err());
        assert!(kite_mesh().locate(&x, 0.5).is_err());
    }
}

#[test]
fn a_mesh_of_a_billion_nodes_costs_nothing() {
    let axis = || Axis::uniform(0.0, 1.0, 1000).unwrap();
    let layout = Layout::on_axes([axis(), axis(), axis()]).unwrap();
    let pulled = DrivenPlane { anchor: 0.0, driven: 1.0, displacement: Ramp::linear(1.0) };
    let path = (0..8).map(|c| from_fn(|d| Ramp::linear(if c == 7 && d == 0 { 0.5 } else { 0.0 })));
    let motions = [
        MeshMotion::Fixed,
        MeshMotion::stretch([Some(pulled), None, None]).unwrap(),
        MeshMotion::corners(path.collect()).unwrap(),
        MeshMotion::rotate([0.5; 2], Ramp::linear(1.0)).unwrap(),
    ];
    let last = NodeId::from_index(1001 * 1001 * 1001 - 1).unwrap();
    // A list of the nodes would take 24 GB each time.
    for motion in motions {
        for _ in 0..100 {
            let mesh = motion.mesh_at(&layout, LoadFraction::END).unwrap();
            let place = mesh.locate(&mesh.position(last), 0.0).unwrap();
            assert_eq!(place.cell, [999; 3]);
        }
    }
}
