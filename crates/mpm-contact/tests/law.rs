//! The law against finite differences: force by position and by motions of the tool, on all shapes, sticking,
//! slipping, in the first evaluation, with adhesion and augmented.

mod common;

use common::{Random, near};
use mpm_contact::{
    CornerLaw, CornerState, Helix, HelixSize, Increment, Interface, Mode, Plane, Polygon, Pose, Response,
    Revolution, Shape, Sphere, Surface, Tangent, Trial, force_by_motion, moment, respond, tangent,
};
use mpm_grid::{Block, Vector};
use nalgebra::Vector3;

struct Case<'a, const D: usize> {
    shape: &'a dyn Shape<D>,
    law: CornerLaw,
    state: CornerState<D>,
    first: bool,
}

impl<const D: usize> Case<'_, D> {
    fn near(&self, pose: &Pose<D>, x: &Vector<D>) -> mpm_contact::Near<D> {
        near(self.shape, &pose.recall(x))[0].turned(pose)
    }

    fn respond(&self, pose: &Pose<D>, x: &Vector<D>) -> Response<D> {
        let trial = Trial { position: *x, near: &self.near(pose, x), pose, first: self.first };
        respond(&self.law, &self.state, &trial)
    }

    fn tangent(&self, pose: &Pose<D>, x: &Vector<D>, kind: Tangent) -> Block<D> {
        let trial = Trial { position: *x, near: &self.near(pose, x), pose, first: self.first };
        let response = respond(&self.law, &self.state, &trial);
        tangent(&self.law, &self.state, &trial, &response, kind)
    }

    /// Compares both derivatives with differences of fourth order; the error relative to k.
    fn error(&self, base: &Pose<D>, about: &Vector<D>, q: &[f64], x: &Vector<D>) -> f64 {
        let increment = Increment::from_slice(q);
        let pose = base.moved(about, &increment);
        let exact = self.tangent(&pose, x, Tangent::Exact);
        let force = self.respond(&pose, x).force;
        let step = 3e-6;
        let slope = |f: &dyn Fn(f64) -> Vector<D>| {
            ((f(step) - f(-step)) * 8.0 - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)
        };
        let mut worst: f64 = 0.0;
        for d in 0..D {
            let by = |s: f64| Vector::<D>::from_fn(|e, _| if e == d { s } else { 0.0 });
            let change = slope(&|s| self.respond(&pose, &(x + by(s))).force);
            worst = worst.max((change + exact.column(d)).norm());
        }
        let arm = x - pose.place(about);
        for k in 0..Increment::<D>::COMPONENTS {
            let change = slope(&|by| {
                let mut other = q.to_vec();
                other[k] += by;
                self.respond(&base.moved(about, &Increment::from_slice(&other)), x).force
            });
            let told = force_by_motion(&exact, &force, &increment.velocity(k, &arm), &increment.spin(k));
            worst = worst.max((change - told).norm());
        }
        worst / self.law.stiffness
    }
}

fn shapes2() -> Vec<Box<dyn Shape<2>>> {
    let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let polygon = Polygon::new(l.iter().map(|&x| Vector::<2>::from(x)).collect(), 0.3).unwrap();
    vec![
        Box::new(Plane::new(Vector::<2>::new(0.1, 0.2), Vector::<2>::new(-1.0, 2.0)).unwrap()),
        Box::new(Sphere::new(Vector::<2>::new(0.3, 0.2), 1.2).unwrap()),
        Box::new(Sphere::hole(Vector::<2>::new(0.3, 0.2), 1.2).unwrap()),
        Box::new(polygon),
    ]
}

fn shapes3() -> Vec<Box<dyn Shape<3>>> {
    let plate = HelixSize { radii: [0.5, 2.0], pitch: 1.5, turns: 1.5, thickness: 0.4 };
    // A wedge over a triangle.
    let vertices = [0.0, 2.0]
        .iter()
        .flat_map(|&z| [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(|x: [f64; 2]| Vector3::new(x[0], x[1], z)));
    let sides = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5], [0, 2, 1], [3, 4, 5]];
    vec![
        Box::new(Plane::new(Vector::<3>::new(0.1, 0.2, 0.0), Vector::<3>::new(-1.0, 2.0, 0.5)).unwrap()),
        Box::new(Sphere::new(Vector::<3>::new(0.3, 0.2, -0.1), 1.2).unwrap()),
        Box::new(Revolution::cylinder(Vector3::zeros(), Vector3::new(0.3, 0.0, 2.0), 0.8, 0.3).unwrap()),
        Box::new(Revolution::cone(Vector3::zeros(), Vector3::new(0.0, 0.0, 2.0), [0.0, 1.3], 0.3).unwrap()),
        Box::new(Helix::new(Vector3::zeros(), Vector3::z(), Vector3::x(), &plate).unwrap()),
        Box::new(Surface::new(vertices.collect(), sides.to_vec(), 0.3).unwrap()),
    ]
}

/// Corners just inside and outside a shape, with every kind of state.
fn sweep<const D: usize>(shape: &dyn Shape<D>, random: &mut Random) {
    let mut seen = [0_u32; 4];
    let mut checked = 0;
    while checked < 300 {
        let turn = Vector3::new(0.4, -0.2, 0.7);
        let base = Pose::turned(&random.vector(-1.0, 1.0), &turn, &random.vector(-0.5, 0.5));
        let about: Vector<D> = random.vector(-0.5, 0.5);
        let q: Vec<f64> = (0..Increment::<D>::COMPONENTS).map(|_| random.between(-0.2, 0.2)).collect();
        let pose = base.moved(&about, &Increment::from_slice(&q));
        let x = pose.place(&random.vector(-1.5, 3.5));
        let found = near(shape, &pose.recall(&x));
        let (first, second) = (found[0], found.get(1));
        let crowded = second.is_some_and(|it| it.distance - first.distance < 0.01);
        // Nor where another feature begins within a difference: there the force has a kink.
        let borders = (0..2 * D).any(|k| {
            let by = Vector::<D>::from_fn(|d, _| match (d == k / 2, k % 2) {
                (true, 0) => 4e-5,
                (true, _) => -4e-5,
                _ => 0.0,
            });
            near(shape, &(pose.recall(&x) + by))[0].feature != first.feature
        });
        if !(-0.12..0.05).contains(&first.distance) || crowded || borders {
            continue;
        }
        let (friction, shear_stiffness) = ([0.0, 0.4, 1.0][checked % 3], [1.0, 0.05][checked % 2]);
        let interface = Interface { friction, shear_stiffness, ..Interface::default() };
        let adhesion = if checked % 4 == 1 { 300.0 } else { 0.0 };
        let law = CornerLaw::new(&interface, 1000.0, 0.5, u8::try_from(D).unwrap(), adhesion);
        let size = if checked % 5 < 3 { 0.05 } else { 1e-3 };
        let state = CornerState {
            anchor: pose.recall(&x) + random.vector(-size, size),
            normal: first.normal,
            multiplier: if checked % 7 == 0 { 200.0 } else { 0.0 },
            offset: -0.01,
            mode: [Mode::Open, Mode::Stuck, Mode::Slipping][checked % 3],
            held: checked % 11 == 0,
        };
        let case = Case { shape, law, state, first: checked % 13 == 0 };
        // Where the state changes within the difference the force has a kink.
        let at = case.respond(&pose, &x);
        let near_opening = (state.multiplier - law.stiffness * at.gap).abs() < 1e-4 * law.stiffness;
        let limit = law.friction * at.normal_force.max(0.0) + adhesion;
        let (n, d) = (pose.turn(&first.normal), x - pose.place(&state.anchor));
        let elastic = law.shear_stiffness() * (d - n * n.dot(&d)).norm();
        let near_slipping = (elastic - limit).abs() < 1e-4 * law.stiffness;
        let kinks = near_opening || near_slipping;
        if kinks {
            checked += 1;
            continue;
        }
        let error = case.error(&base, &about, &q, &x);
        assert!(error < 1e-7, "{error:e} at {x:?}: {at:?} {first:?} of {shape:?}");
        seen[match at.mode {
            Mode::Open => 0,
            Mode::Stuck => 1,
            Mode::Slipping if law.friction > 0.0 => 2,
            Mode::Slipping => 3,
        }] += 1;
        checked += 1;
    }
    assert!(seen.iter().all(|&n| n > 5), "{seen:?} of {shape:?}");
}

#[test]
fn tangents_agree_with_finite_differences() {
    let mut random = Random(7);
    shapes2().iter().for_each(|shape| sweep(&**shape, &mut random));
    shapes3().iter().for_each(|shape| sweep(&**shape, &mut random));
}

fn resting() -> (CornerLaw, CornerState<2>, mpm_contact::Near<2>) {
    let plane = Plane::new(Vector::<2>::zeros(), Vector::<2>::new(0.0, 1.0)).unwrap();
    let interface = Interface { friction: 0.5, ..Interface::default() };
    let x = Vector::<2>::zeros();
    let found = near(&plane, &x)[0];
    (
        CornerLaw::new(&interface, 1000.0, 0.5, 2, 0.0),
        CornerState::at_rest(&Pose::identity(), &x, &found),
        found,
    )
}

#[test]
fn a_corner_that_rests_has_stiffness_in_the_first_tangent_only() {
    let (law, state, found) = resting();
    let pose = Pose::identity();
    for (first, expected) in [(true, law.stiffness), (false, 0.0)] {
        let trial = Trial { position: Vector::zeros(), near: &found, pose: &pose, first };
        let response = respond(&law, &state, &trial);
        assert_eq!(response.force, Vector::<2>::zeros());
        assert_eq!(tangent(&law, &state, &trial, &response, Tangent::Exact)[(1, 1)], expected);
        assert_eq!(tangent(&law, &state, &trial, &response, Tangent::Exact)[(0, 0)], expected);
    }
}

/// Pressed, dragged: the force is μ F_N, and the anchor follows at the elastic distance.
#[test]
fn dragged_corners_slip_by_coulombs_law() {
    let (law, mut state, _) = resting();
    let plane = Plane::new(Vector::<2>::zeros(), Vector::<2>::new(0.0, 1.0)).unwrap();
    let pose = Pose::identity();
    for k in 1..6 {
        let x = Vector::<2>::new(0.02 * f64::from(k), -0.01);
        let found = near(&plane, &x)[0];
        let trial = Trial { position: x, near: &found, pose: &pose, first: false };
        let response = respond(&law, &state, &trial);
        assert!((response.normal_force - 0.01 * law.stiffness).abs() < 1e-12 * law.stiffness);
        assert!((response.tangential[0] + 0.5 * response.normal_force).abs() < 1e-12 * law.stiffness);
        assert_eq!(response.mode, Mode::Slipping);
        state = state.committed(&law, &trial, &response);
        assert!((x - state.anchor).norm() - 0.005 < 1e-15);
        let again = respond(&law, &state, &trial);
        assert!((again.force - response.force).norm() < 1e-12 * law.stiffness);
        // In the first evaluation of the next step it may slip; one that stuck may not.
        let stuck = CornerState { mode: Mode::Stuck, ..state };
        let far = Trial { position: x + Vector::<2>::new(0.1, 0.0), first: true, ..trial };
        assert_eq!(respond(&law, &state, &far).mode, Mode::Slipping);
        assert_eq!(respond(&law, &stuck, &far).mode, Mode::Stuck);
    }
}

/// A stuck corner that turns with its tool keeps its force in the tool's frame.
#[test]
fn states_turn_with_the_tool() {
    let (law, state, _) = resting();
    let plane = Plane::new(Vector::<2>::zeros(), Vector::<2>::new(0.0, 1.0)).unwrap();
    let rest = Vector::<2>::new(0.002, -0.01);
    let found = near(&plane, &rest)[0];
    let respond_at = |pose: &Pose<2>| {
        let near = found.turned(pose);
        let trial = Trial { position: pose.place(&rest), near: &near, pose, first: false };
        respond(&law, &state, &trial)
    };
    let still = respond_at(&Pose::identity());
    assert_eq!(still.mode, Mode::Stuck);
    let pose =
        Pose::turned(&Vector::<2>::new(3.0, 1.0), &Vector3::new(0.0, 0.0, 2.1), &Vector::<2>::new(5.0, 0.0));
    let turned = respond_at(&pose);
    assert!((pose.turn(&still.force) - turned.force).norm() < 1e-11);
    assert!((still.stored(&law) - turned.stored(&law)).abs() < 1e-12);
}

#[test]
fn what_is_held_pulls_and_what_separates_does_not() {
    let (law, state, _) = resting();
    let plane = Plane::new(Vector::<2>::zeros(), Vector::<2>::new(0.0, 1.0)).unwrap();
    let pose = Pose::identity();
    let x = Vector::<2>::new(0.0, 0.01);
    let found = near(&plane, &x)[0];
    let trial = Trial { position: x, near: &found, pose: &pose, first: false };
    assert_eq!(respond(&law, &state, &trial).force, Vector::<2>::zeros());
    assert_eq!(respond(&law, &state, &trial).mode, Mode::Open);
    let held = CornerState { held: true, ..state };
    let pulled = respond(&law, &held, &trial);
    assert!((pulled.normal_force + 0.01 * law.stiffness).abs() < 1e-12);
    // No friction without pressure.
    assert_eq!(pulled.tangential, Vector::<2>::zeros());
    assert_eq!(held.committed(&law, &trial, &pulled).offset, held.offset);
}

#[test]
fn offsets_only_shrink() {
    let (law, state, _) = resting();
    let plane = Plane::new(Vector::<2>::zeros(), Vector::<2>::new(0.0, 1.0)).unwrap();
    let pose = Pose::identity();
    let deep = CornerState { offset: -0.05, ..state };
    for (height, expected) in [(-0.06, -0.05), (-0.02, -0.02), (0.01, 0.0)] {
        let x = Vector::<2>::new(0.0, height);
        let found = near(&plane, &x)[0];
        let trial = Trial { position: x, near: &found, pose: &pose, first: false };
        let response = respond(&law, &deep, &trial);
        assert_eq!(deep.committed(&law, &trial, &response).offset, expected);
    }
}

#[test]
fn an_augmentation_carries_the_force() {
    let (law, state, _) = resting();
    let plane = Plane::new(Vector::<2>::zeros(), Vector::<2>::new(0.0, 1.0)).unwrap();
    let pose = Pose::identity();
    let x = Vector::<2>::new(0.0, -0.01);
    let found = near(&plane, &x)[0];
    let response = respond(&law, &state, &Trial { position: x, near: &found, pose: &pose, first: false });
    let augmented = state.augmented(&response);
    let flush = Vector::<2>::zeros();
    let found = near(&plane, &flush)[0];
    let trial = Trial { position: flush, near: &found, pose: &pose, first: false };
    let again = respond(&law, &augmented, &trial);
    assert_eq!(again.normal_force, response.normal_force);
    assert_eq!(augmented.committed(&law, &trial, &again).multiplier, response.normal_force);
}

#[test]
fn the_symmetric_tangent_is_exact_without_friction() {
    let disc = Sphere::new(Vector::<2>::zeros(), 1.0).unwrap();
    let interface = Interface::default();
    let x = Vector::<2>::new(0.6, 0.7);
    let found = near(&disc, &x)[0];
    let pose = Pose::identity();
    let law = CornerLaw::new(&interface, 1000.0, 0.5, 2, 0.0);
    let state = CornerState { offset: 0.0, ..CornerState::at_rest(&pose, &x, &found) };
    let trial = Trial { position: x, near: &found, pose: &pose, first: false };
    let response = respond(&law, &state, &trial);
    let [a, b] =
        [Tangent::Exact, Tangent::Symmetric].map(|kind| tangent(&law, &state, &trial, &response, kind));
    assert!((a - b).norm() < 1e-12 * a.norm());
    assert!(response.normal_force > 0.0 && response.mode == Mode::Slipping);
    assert_eq!(moment(&Vector::<2>::new(1.0, 0.0), &Vector::<2>::new(0.0, 2.0))[2], 2.0);
}

#[test]
fn bad_interfaces_are_refused() {
    let bad = [
        Interface { friction: -0.1, ..Interface::default() },
        Interface { adhesion: f64::NAN, ..Interface::default() },
        Interface { stiffness: 0.99, ..Interface::default() },
        Interface { shear_stiffness: 1.1, ..Interface::default() },
    ];
    let names: Vec<&str> = bad.iter().map(|it| it.check().unwrap_err().name).collect();
    assert_eq!(names, ["friction", "adhesion", "stiffness", "shear_stiffness"]);
    assert!(Interface::default().check().is_ok());
}
