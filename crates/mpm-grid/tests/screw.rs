//! A twist composed with a stretch along its axis: the mesh that follows a screw.

use mpm_grid::{
    Axis, DrivenPlane, Layout, LoadFraction, Mesh, MeshMotion, MotionError, NodeId, Ramp, Reindexing, Span,
    Vector,
};
use std::f64::consts::TAU;

const CENTRE: [f64; 2] = [1.0, -0.5];

fn at(fraction: f64) -> LoadFraction {
    LoadFraction::new(fraction).unwrap()
}

fn layout() -> Layout<3> {
    let height = Axis::uniform(0.0, 3.0, 6).unwrap();
    Layout::ring(CENTRE, Axis::uniform(0.5, 3.0, 5).unwrap(), 24, Span::Full, Some(height)).unwrap()
}

/// The inner ring turns with the pile, the plane of its tip goes down towards the base.
fn screw(turns: f64, advance: f64, reindexing: Reindexing) -> MeshMotion<3> {
    let (inner, outer) = ((0.5, Ramp::linear(turns * TAU)), (3.0, Ramp::constant(0.0)));
    let plane = DrivenPlane { anchor: 0.0, driven: 2.0, displacement: Ramp::linear(advance) };
    let twist = MeshMotion::twist(CENTRE, inner, outer, reindexing).unwrap();
    twist.stretched_along_axis(plane).unwrap()
}

fn nodes(mesh: &Mesh<3>) -> impl Iterator<Item = NodeId> {
    (0..mesh.lattice().n_nodes()).map(|i| NodeId::from_index(i).unwrap())
}

/// Some places of the ring and beyond it.
fn places() -> impl Iterator<Item = Vector<3>> {
    (0..200).map(|k| {
        let k = f64::from(k);
        let (radius, angle) = (0.2 + 0.017 * k, 0.7 * k);
        Vector::<3>::new(CENTRE[0] + radius * angle.cos(), CENTRE[1] + radius * angle.sin(), -0.3 + 0.018 * k)
    })
}

#[test]
fn recall_inverts_place() {
    let (layout, motion) = (layout(), screw(-7.3, -1.1, Reindexing::WholeCells));
    for (k, rest) in places().enumerate() {
        let fraction = at((k % 11) as f64 / 10.0);
        let x = motion.place(&layout, &rest, fraction).unwrap();
        assert!((motion.recall(&layout, &x, fraction).unwrap() - rest).norm() < 1e-12, "{rest}");
    }
    // The plane of the tip moves as told, what is above it too, what is on the base stays.
    let moved = |z: f64| motion.place(&layout, &Vector::<3>::new(1.0, 3.0, z), at(0.5)).unwrap()[2];
    assert_eq!([0.0, 1.0, 2.0, 3.0].map(moved), [0.0, 1.0 - 0.275, 2.0 - 0.55, 3.0 - 0.55]);
}

#[test]
fn meshes_follow_their_motion() {
    let (layout, motion) = (layout(), screw(0.05, -1.1, Reindexing::Off));
    for fraction in [0.0, 0.3, 1.0].map(at) {
        let mesh = motion.mesh_at(&layout, fraction).unwrap();
        for node in nodes(&mesh) {
            let x = motion.place(&layout, &layout.position(node), fraction).unwrap();
            assert!((mesh.position(node) - x).norm() < 1e-13);
        }
    }
}

/// Twenty turns: rings keep their polygons, cells are sheared by a cell at most, layers go down evenly, and every place
/// is found.
#[test]
fn the_mesh_stays_good_over_many_turns() {
    let (layout, motion) = (layout(), screw(-20.0, -1.1, Reindexing::WholeCells));
    let sector = TAU / 24.0;
    for step in 0..=100 {
        let fraction = at(f64::from(step) / 100.0);
        let mesh = motion.mesh_at(&layout, fraction).unwrap();
        let lattice = mesh.lattice();
        let tip = 2.0 - 1.1 * fraction.get();
        for k in 0..=6 {
            let rest = 0.5 * f64::from(k);
            let height = if rest < 2.0 { rest * tip / 2.0 } else { rest - 2.0 + tip };
            let mut previous: Option<f64> = None;
            for j in 0..=5 {
                let x = mesh.position(lattice.node([0, j, k]));
                assert!((x[2] - height).abs() < 1e-12);
                let (dx, dy) = (x[0] - CENTRE[0], x[1] - CENTRE[1]);
                assert!((dx.hypot(dy) - (0.5 + 0.5 * f64::from(j))).abs() < 1e-12);
                let turned = dy.atan2(dx);
                assert!(previous.is_none_or(|it| (turned - it).abs() < sector * (1.0 + 1e-9)));
                previous = Some(turned);
            }
        }
        for x in places().map(|rest| motion.place(&layout, &rest, fraction).unwrap()) {
            if let Ok(place) = mesh.locate(&x, 0.0) {
                let mut back = Vector::<3>::zeros();
                mesh.values(&place, |node, value| back += mesh.position(node) * value);
                assert!((back - x).norm() < 1e-9, "{x}");
            }
        }
        // Always from rest: nothing is carried over from another mesh.
        assert_eq!(mesh, motion.mesh_at(&layout, fraction).unwrap());
    }
}

#[test]
fn prescribed_displacements_are_those_of_the_material() {
    let (layout, motion) = (layout(), screw(-9.0, -1.1, Reindexing::WholeCells));
    let (start, end) = (at(0.35), at(0.36));
    let mesh = motion.mesh_at(&layout, start).unwrap();
    for node in nodes(&mesh) {
        let x = mesh.position(node);
        let rest = motion.recall(&layout, &x, start).unwrap();
        let expected = motion.place(&layout, &rest, end).unwrap() - x;
        let found = motion.displacement(&layout, node, &mesh, start, end).unwrap();
        assert!((found - expected).norm() < 1e-11, "{x}");
    }
}

#[test]
fn gradients_are_those_of_the_moved_cells() {
    let (layout, motion) = (layout(), screw(-3.3, -1.1, Reindexing::WholeCells));
    let mesh = motion.mesh_at(&layout, at(0.7)).unwrap();
    let mut located = 0;
    for x in places().map(|rest| motion.place(&layout, &rest, at(0.7)).unwrap()) {
        let Ok(place) = mesh.locate(&x, 0.0) else { continue };
        located += 1;
        // A linear field is reproduced: its gradient is exact.
        let slope = Vector::<3>::new(0.3, -1.2, 0.8);
        let mut gradient = Vector::<3>::zeros();
        mesh.values_and_gradients(&place, |node, _, by| gradient += by * slope.dot(&mesh.position(node)));
        assert!((gradient - slope).norm() < 1e-10, "{x}");
    }
    assert!(located > 100);
}

#[test]
fn stretches_that_do_not_suit_are_refused() {
    let plane =
        |anchor: f64, driven: f64, by: f64| DrivenPlane { anchor, driven, displacement: Ramp::linear(by) };
    let twist = || {
        let (inner, outer) = ((0.5, Ramp::linear(1.0)), (3.0, Ramp::constant(0.0)));
        MeshMotion::<3>::twist(CENTRE, inner, outer, Reindexing::WholeCells).unwrap()
    };
    let coincident = twist().stretched_along_axis(plane(1.0, 1.0, 0.0));
    assert_eq!(coincident, Err(MotionError::CoincidentPlanes { axis: 2 }));
    let through = twist().stretched_along_axis(plane(0.0, 1.0, -1.0));
    assert_eq!(through, Err(MotionError::ThroughAnchor { axis: 2, fraction: 1.0 }));
    assert_eq!(twist().stretched_along_axis(plane(0.0, f64::NAN, 0.0)), Err(MotionError::NotFinite));
    assert_eq!(MeshMotion::<3>::Fixed.stretched_along_axis(plane(0.0, 1.0, 1.0)), Err(MotionError::NotTwisted));
    let flat = Layout::ring([0.0; 2], Axis::uniform(0.5, 3.0, 5).unwrap(), 24, Span::Full, None).unwrap();
    let (inner, outer) = ((0.5, Ramp::linear(1.0)), (3.0, Ramp::constant(0.0)));
    let motion = MeshMotion::<2>::twist([0.0; 2], inner, outer, Reindexing::WholeCells).unwrap();
    let motion = motion.stretched_along_axis(plane(0.0, 1.0, 1.0)).unwrap();
    assert_eq!(motion.mesh_at(&flat, at(0.5)), Err(MotionError::NeedsHeight));
    assert_eq!(motion.ramps().len(), 3);
}
