//! Motions: place and recall, what they refuse, re-indexing, prescribed displacements.

use mpm_grid::{
    AffineMotion, Axis, Block, DrivenPlane, Layout, LoadFraction, Mesh, MeshMotion, MotionError, NodeId, Ramp,
    Reindexing, Span, Vector,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::array::from_fn;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn fraction(f: f64) -> LoadFraction {
    LoadFraction::new(f).unwrap()
}

fn square<const D: usize>() -> Layout<D> {
    Layout::on_axes(from_fn(|_| Axis::uniform(0.0, 2.0, 4).unwrap())).unwrap()
}

fn ring(span: Span) -> Layout<2> {
    Layout::ring([1.0, 2.0], Axis::uniform(5.0, 10.0, 5).unwrap(), 32, span, None).unwrap()
}

fn plane(anchor: f64, driven: f64, displacement: f64) -> Option<DrivenPlane> {
    Some(DrivenPlane { anchor, driven, displacement: Ramp::linear(displacement) })
}

fn twist(angle: f64, reindexing: Reindexing) -> MeshMotion<2> {
    let (inner, outer) = ((5.0, Ramp::linear(angle)), (10.0, Ramp::constant(0.0)));
    MeshMotion::twist([1.0, 2.0], inner, outer, reindexing).unwrap()
}

fn expand(anchor: f64, driven: f64, displacement: f64) -> Result<MeshMotion<2>, MotionError> {
    MeshMotion::expand(DrivenPlane { anchor, driven, displacement: Ramp::linear(displacement) })
}

/// The corner of largest coordinates moves by `by` along every direction.
fn kite<const D: usize>(by: f64) -> MeshMotion<D> {
    let last = (1 << D) - 1;
    let path = (0..1 << D).map(|c| from_fn(|_| Ramp::linear(if c == last { by } else { 0.0 })));
    MeshMotion::corners(path.collect()).unwrap()
}

fn nodes<const D: usize>(mesh: &Mesh<D>) -> impl Iterator<Item = NodeId> {
    (0..mesh.lattice().n_nodes()).map(|i| NodeId::from_index(i).unwrap())
}

fn round_trip<const D: usize>(motion: &MeshMotion<D>, layout: &Layout<D>, rest: &[f64], f: f64) {
    let rest = Vector::from_fn(|d, _| rest[d]);
    let x = motion.place(layout, &rest, fraction(f)).unwrap();
    let back = motion.recall(layout, &x, fraction(f)).unwrap();
    assert!((back - rest).norm() < 1e-12, "{motion:?}: {rest} became {back}");
}

/// The same cases in every run, and no files written on failure.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Default::default() }
}

proptest! {
    #![proptest_config(cases(256))]
    #[test]
    fn recall_inverts_place(rest in prop::collection::vec(0.0..2.0, 3), f in 0.0..1.0) {
        let stretch2 = MeshMotion::stretch([plane(0.5, 1.5, 3.0), plane(2.0, 0.0, -0.7)]).unwrap();
        let stretch3 = MeshMotion::stretch([None, plane(2.0, 1.0, 0.9), plane(0.0, 2.0, 1.0)]).unwrap();
        let turn2 = MeshMotion::rotate([0.3, 4.0], Ramp::linear(9.0)).unwrap();
        let turn3 = MeshMotion::rotate([0.3, 4.0], Ramp::linear(-9.0)).unwrap();
        for motion in [MeshMotion::Fixed, stretch2, kite(4.0), turn2] {
            round_trip::<2>(&motion, &square(), &rest, f);
        }
        for motion in [MeshMotion::Fixed, stretch3, kite(1.5), turn3] {
            round_trip::<3>(&motion, &square(), &rest, f);
        }
        for reindexing in [Reindexing::Off, Reindexing::WholeCells, Reindexing::Neighbours] {
            // From inside the inner radius to outside the outer one.
            let x = [1.0 + 8.0 * rest[0], 2.0 - rest[1]];
            round_trip::<2>(&twist(7.0, reindexing), &ring(Span::Full), &x, f);
        }
        // From the driven radius to beyond the anchor; and the other way round.
        let x = [1.0 + 5.0 + 4.0 * rest[0], 2.0 - rest[1]];
        for (anchor, driven, by) in [(9.0, 5.0, 3.0), (9.0, 5.0, -4.5), (5.0, 8.0, -2.5)] {
            round_trip::<2>(&expand(anchor, driven, by).unwrap(), &ring(Span::Full), &x, f);
        }
    }

    /// Mesh nodes stand where the motion places them (but for re-indexing).
    #[test]
    fn meshes_follow_their_motion(f in 0.0..1.0) {
        let stretch = MeshMotion::stretch([plane(0.6, 1.5, 3.0), plane(0.0, 2.0, -0.7)]).unwrap();
        let turn = || MeshMotion::rotate([0.3, 4.0], Ramp::linear(9.0)).unwrap();
        let table = [
            (stretch, square()),
            (kite(4.0), square()),
            (turn(), square()),
            (turn(), ring(Span::Full)),
            (turn(), ring(Span::Sector { from: 1.0, to: 3.0 })),
            (twist(0.5, Reindexing::Off), ring(Span::Full)),
            (twist(0.5, Reindexing::Off), ring(Span::Sector { from: 1.0, to: 3.0 })),
            (expand(9.0, 6.0, 2.0).unwrap(), ring(Span::Full)),
            (expand(6.0, 9.0, -2.0).unwrap(), ring(Span::Sector { from: 1.0, to: 3.0 })),
        ];
        for (motion, layout) in table {
            let mesh = motion.mesh_at(&layout, fraction(f)).unwrap();
            for node in nodes(&mesh) {
                let x = motion.place(&layout, &layout.position(node), fraction(f)).unwrap();
                prop_assert!((mesh.position(node) - x).norm() < 1e-13, "{:?}", motion);
            }
        }
    }
}

#[test]
fn stretch_moves_planes_as_told() {
    let axis = Axis::graded(vec![0.0, 1.0, 2.0, 4.0, 5.0]).unwrap();
    let layout = Layout::on_axes([axis]).unwrap();
    let table = [
        ((1.0, 4.0), 3.0, [0.0, 1.0, 3.0, 7.0, 8.0]),
        ((4.0, 1.0), -3.0, [-3.0, -2.0, 0.0, 4.0, 5.0]),
        ((0.0, 5.0), -2.5, [0.0, 0.5, 1.0, 2.0, 2.5]),
    ];
    for ((anchor, driven), displacement, expected) in table {
        let motion = MeshMotion::stretch([plane(anchor, driven, displacement)]).unwrap();
        let mesh = motion.mesh_at(&layout, LoadFraction::END).unwrap();
        let [axis] = mesh.rectilinear().expect("a stretched box is rectilinear");
        for (i, x) in (0..5).zip(expected) {
            assert!((axis.node(i) - x).abs() < 1e-15, "{anchor} to {driven}: node {i}");
        }
    }
}

/// Rings of nodes between the radii are re-spaced, those beyond the driven one move with it, and all keep their angles.
#[test]
fn expansion_moves_rings_as_told() {
    let layout = ring(Span::Sector { from: 0.5, to: 1.0 });
    let table: [((f64, f64), f64, [f64; 6]); 3] = [
        ((10.0, 5.0), 3.0, [64.0, 69.28, 75.52, 82.72, 90.88, 100.0]),
        ((9.0, 7.0), 1.0, [40.0, 51.0, 64.0, 71.96875, 81.0, 100.0]),
        ((5.0, 10.0), 4.0, [25.0, 50.08, 79.72, 113.92, 152.68, 196.0]),
    ];
    for ((anchor, driven), displacement, squares) in table {
        let motion = expand(anchor, driven, displacement).unwrap();
        let mesh = motion.mesh_at(&layout, LoadFraction::END).unwrap();
        let start = motion.mesh_at(&layout, LoadFraction::START).unwrap();
        for node in nodes(&mesh) {
            let [line, ring] = mesh.lattice().node_index(node);
            let angle = 0.5 + 0.5 * f64::from(line) / 32.0;
            let x = Vector::<2>::new(1.0, 2.0)
                + Vector::<2>::new(angle.cos(), angle.sin()) * squares[ring as usize].sqrt();
            assert!((mesh.position(node) - x).norm() < 1e-14, "{anchor} to {driven}: ring {ring}");
            let by =
                motion.displacement(&layout, node, &start, LoadFraction::START, LoadFraction::END).unwrap();
            assert!((start.position(node) + by - x).norm() < 1e-14);
        }
    }
}

#[test]
fn a_uniform_axis_stays_uniform_only_where_it_does() {
    let uniform = |a, b| {
        let motion = MeshMotion::stretch([plane(a, b, 1.0), None]).unwrap();
        let mesh = motion.mesh_at(&square(), LoadFraction::END).unwrap();
        mesh.rectilinear().unwrap()[0].is_uniform()
    };
    assert!(uniform(0.0, 2.0) && uniform(2.5, -0.5));
    assert!(!uniform(0.0, 1.5) && !uniform(0.5, 2.0));
}

#[test]
fn motions_that_cannot_be_are_refused() {
    let error = MeshMotion::stretch([plane(0.0, 2.0, -2.0)]).unwrap_err();
    assert_eq!(error, MotionError::ThroughAnchor { axis: 0, fraction: 1.0 });
    assert!(MeshMotion::stretch([plane(2.0, 0.0, 2.5)]).is_err());
    assert!(MeshMotion::stretch([plane(2.0, 0.0, -2.5)]).is_ok());
    let error = MeshMotion::stretch([None, plane(1.0, 1.0, 0.0)]).unwrap_err();
    assert_eq!(error, MotionError::CoincidentPlanes { axis: 1 });
    assert_eq!(MeshMotion::stretch([plane(0.0, f64::NAN, 0.0)]), Err(MotionError::NotFinite));
    assert_eq!(MeshMotion::stretch([plane(0.0, 1.0, f64::NAN)]), Err(MotionError::NotFinite));
    let count = MotionError::CornerCount { needed: 4, found: 3 };
    let still = || [Ramp::constant(0.0), Ramp::constant(0.0)];
    assert_eq!(MeshMotion::<2>::corners(vec![still(), still(), still()]), Err(count));
    let still = || Ramp::constant(0.0);
    assert_eq!(MeshMotion::<1>::rotate([0.0; 2], still()), Err(MotionError::NeedsPlane));
    let radii = MeshMotion::<2>::twist([0.0; 2], (2.0, still()), (2.0, still()), Reindexing::Off);
    assert_eq!(radii, Err(MotionError::TwistRadii { inner: 2.0, outer: 2.0 }));
    assert_eq!(expand(2.0, 2.0, 1.0), Err(MotionError::ExpandedRadii { anchor: 2.0, driven: 2.0 }));
    assert_eq!(expand(0.0, 2.0, 1.0), Err(MotionError::ExpandedRadii { anchor: 0.0, driven: 2.0 }));
    let reached = Err(MotionError::ThroughRadius { fraction: 1.0 });
    assert_eq!([expand(3.0, 1.0, 2.0), expand(3.0, 1.0, -1.0)], [reached.clone(), reached]);
    assert_eq!(expand(f64::NAN, 1.0, 2.0), Err(MotionError::NotFinite));
}

#[test]
fn motions_that_do_not_suit_the_layout_are_refused() {
    let refused =
        |motion: MeshMotion<2>, layout: &Layout<2>| motion.mesh_at(layout, fraction(0.5)).unwrap_err();
    let full = ring(Span::Full);
    let stretch = MeshMotion::stretch([plane(0.0, 2.0, 1.0), None]).unwrap();
    assert_eq!(refused(stretch, &full), MotionError::NeedsBox);
    assert_eq!(refused(kite(1.0), &full), MotionError::NeedsBox);
    let reindexed = || twist(1.0, Reindexing::WholeCells);
    assert_eq!(refused(reindexed(), &square()), MotionError::NeedsRing);
    assert_eq!(refused(expand(1.0, 2.0, 1.0).unwrap(), &square()), MotionError::NeedsRing);
    // The innermost ring, of radius 5, moves with the driven one, to the centre.
    assert_eq!(refused(expand(19.0, 11.0, -10.5).unwrap(), &full), MotionError::Folded { fraction: 0.5 });
    let sector = ring(Span::Sector { from: 0.0, to: 1.0 });
    assert_eq!(refused(reindexed(), &sector), MotionError::OpenRing);
    let (inner, outer) = ((5.0, Ramp::linear(1.0)), (10.0, Ramp::constant(0.0)));
    let off = MeshMotion::twist([1.0, 2.1], inner, outer, Reindexing::Off).unwrap();
    assert!(matches!(refused(off, &full), MotionError::OffCentre { .. }));
    // Folded: the kite's corner pulled through the diagonal; a twist of a whole turn in five cells.
    assert_eq!(refused(kite(-3.0), &square()), MotionError::Folded { fraction: 0.5 });
    let torn = twist(4.0 * TAU, Reindexing::Off);
    assert_eq!(refused(torn, &full), MotionError::Folded { fraction: 0.5 });
}

#[test]
fn reindexing_keeps_polygons_and_bounds_the_shear() {
    let layout = ring(Span::Full);
    for degrees in 0..=720 {
        let angle = f64::from(degrees).to_radians();
        let raw = twist(angle, Reindexing::Off);
        let mesh = twist(angle, Reindexing::WholeCells).mesh_at(&layout, LoadFraction::END).unwrap();
        let lattice = mesh.lattice();
        let index_of = |i, j| lattice.node([i, j]);
        let mut previous = None;
        for j in 0..=5 {
            // The first node of the ring, as the raw twist has it, is some node of the mesh's ring.
            let rest = layout.position(index_of(0, j));
            let x = raw.place(&layout, &rest, LoadFraction::END).unwrap();
            let apart = |i| (mesh.position(index_of(i, j)) - x).norm();
            assert!((0..32).any(|i| apart(i) < 1e-11), "{degrees}°, ring {j}");

            let at = mesh.position(index_of(0, j)) - Vector::<2>::new(1.0, 2.0);
            let turned = at[1].atan2(at[0]);
            assert!(turned > -PI / 32.0 - 1e-8 && turned < PI / 32.0 + 1e-8);
            if let Some(previous) = previous {
                let shear: f64 = turned - previous;
                assert!(shear.abs() < TAU / 32.0 + 1e-12);
            }
            previous = Some(turned);
        }
    }
}

/// The displacement over a step, judged by where the material at a node of the mesh came from.
#[test]
fn prescribed_displacements_are_those_of_the_material() {
    let stretch = MeshMotion::stretch([plane(0.6, 1.5, 3.0), plane(0.0, 2.0, -0.7)]).unwrap();
    let turn = MeshMotion::rotate([0.3, 4.0], Ramp::linear(9.0)).unwrap();
    let table = [
        (MeshMotion::Fixed, square()),
        (stretch, square()),
        (kite(4.0), square()),
        (turn.clone(), square()),
        (turn, ring(Span::Full)),
        (twist(0.4, Reindexing::Off), ring(Span::Full)),
        (twist(20.0, Reindexing::WholeCells), ring(Span::Full)),
    ];
    let (start, end) = (fraction(0.35), fraction(0.4));
    for (motion, layout) in table {
        let mesh = motion.mesh_at(&layout, start).unwrap();
        for node in nodes(&mesh) {
            let x = mesh.position(node);
            let rest = motion.recall(&layout, &x, start).unwrap();
            let expected = motion.place(&layout, &rest, end).unwrap() - x;
            let found = motion.displacement(&layout, node, &mesh, start, end).unwrap();
            assert!((found - expected).norm() < 1e-11, "{motion:?} at {x}");
        }
    }
}

/// Shears the first direction by the second and shifts it, by `most` at full load; `early` at once.
#[derive(Debug)]
struct Shear {
    most: f64,
    early: f64,
}

impl<const D: usize> AffineMotion<D> for Shear {
    fn at(&self, fraction: LoadFraction) -> (Block<D>, Vector<D>) {
        let by = self.early + self.most * fraction.get();
        let matrix =
            Block::from_fn(|i, j| f64::from(u8::from(i == j)) + if (i, j) == (0, 1) { by } else { 0.0 });
        (matrix, Vector::from_fn(|d, _| if d == 0 { by } else { 0.0 }))
    }
}

/// Halves, then squeezes flat, the second direction.
#[derive(Debug)]
struct Squeeze;

impl AffineMotion<2> for Squeeze {
    fn at(&self, fraction: LoadFraction) -> (Block<2>, Vector<2>) {
        (Block::<2>::new(1.0, 0.0, 0.0, 1.0 - fraction.get()), Vector::zeros())
    }
}

fn affine_meshes_are_complete<const D: usize>() {
    let layout = square::<D>();
    let motion = MeshMotion::<D>::affine(Arc::new(Shear { most: 1.5, early: 0.0 })).unwrap();
    round_trip(&motion, &layout, &[0.3, 1.7, 0.9], 0.7);
    let mesh = motion.mesh_at(&layout, fraction(0.7)).unwrap();
    let rest = Vector::<D>::from_fn(|d, _| 0.3 + 0.35 * d as f64);
    let x = motion.place(&layout, &rest, fraction(0.7)).unwrap();
    assert!((x[0] - (rest[0] + 1.05 * rest[1] + 1.05)).abs() < 1e-14);
    let (mut here, mut identity) = (Vector::<D>::zeros(), Block::<D>::zeros());
    mesh.values_and_gradients(&mesh.locate(&x, 0.0).unwrap(), |node, value, gradient| {
        here += value * mesh.position(node);
        identity += mesh.position(node) * gradient.transpose();
    });
    assert!((here - x).norm() < 1e-13, "Σ N x_v = {here}, not {x}");
    assert!((identity - Block::<D>::identity()).norm() < 1e-13, "Σ x_v ⊗ ∇N = {identity}");
    let start = motion.mesh_at(&layout, fraction(0.2)).unwrap();
    for node in nodes(&start) {
        let by = motion.displacement(&layout, node, &start, fraction(0.2), fraction(0.7)).unwrap();
        assert!((by - (mesh.position(node) - start.position(node))).norm() < 1e-14);
    }
}

#[test]
fn affine_motions_are_exact() {
    affine_meshes_are_complete::<2>();
    affine_meshes_are_complete::<3>();
}

#[test]
fn affine_motions_that_cannot_be_are_refused() {
    let early = MeshMotion::<2>::affine(Arc::new(Shear { most: 1.0, early: 0.1 }));
    assert_eq!(early, Err(MotionError::NotAtRest));
    let shear = MeshMotion::<2>::affine(Arc::new(Shear { most: 1.0, early: 0.0 })).unwrap();
    assert_eq!(shear.mesh_at(&ring(Span::Full), fraction(0.5)), Err(MotionError::NeedsBox));
    let infinite = MeshMotion::<2>::affine(Arc::new(Shear { most: f64::INFINITY, early: 0.0 }));
    // 0 · ∞ is not a number, so this map is not the identity at its start either.
    assert_eq!(infinite, Err(MotionError::NotAtRest));
    let squeeze = MeshMotion::affine(Arc::new(Squeeze)).unwrap();
    assert!(squeeze.mesh_at(&square(), fraction(0.5)).is_ok());
    assert_eq!(squeeze.mesh_at(&square(), fraction(1.0)), Err(MotionError::Folded { fraction: 1.0 }));
    assert_eq!(squeeze, squeeze.clone());
    assert_ne!(squeeze, MeshMotion::affine(Arc::new(Squeeze)).unwrap());
}

#[test]
fn neighbours_are_sheared_by_half_a_cell_at_most() {
    // Few sectors and rings close to each other, where whole cells of each ring fold.
    let radii = Axis::graded(vec![0.3, 0.44, 0.58, 0.72, 0.86, 1.05, 1.3]).unwrap();
    let layout = Layout::<2>::ring([1.0, 2.0], radii, 12, Span::Full, None).unwrap();
    let mesh = |angle: f64, reindexing| {
        let (inner, outer) = ((0.3, Ramp::linear(angle)), (1.3, Ramp::constant(0.0)));
        let motion = MeshMotion::twist([1.0, 2.0], inner, outer, reindexing).unwrap();
        motion.mesh_at(&layout, LoadFraction::END)
    };
    let sector = TAU / 12.0;
    let mut folded = 0;
    for k in 0..=400 {
        let angle = -12.6 * f64::from(k) / 400.0;
        folded += usize::from(mesh(angle, Reindexing::WholeCells).is_err());
        let mesh = mesh(angle, Reindexing::Neighbours).expect("no cell folds");
        let polar = |ring: u32| {
            let x = mesh.position(layout.lattice().node([0, ring]));
            (x[1] - 2.0).atan2(x[0] - 1.0)
        };
        for ring in 0..7 {
            // The same polygon as without re-indexing.
            let radius = layout.position(layout.lattice().node([0, ring]))[0] - 1.0;
            let turned = angle * (1.3 - radius) / 1.0;
            let cells = (polar(ring) - turned) / sector;
            assert!((cells - cells.round()).abs() < 1e-9, "{angle}, ring {ring}: {cells}");
            if ring < 6 {
                let apart = (polar(ring + 1) - polar(ring)) / sector;
                let apart = apart - 12.0 * (apart / 12.0).round();
                assert!(apart.abs() <= 0.5 + 1e-6, "{angle}, ring {ring}: {apart} cells");
            }
        }
    }
    assert!(folded > 0, "whole cells of each ring would fold");
}
