//! Loads and walls on boundary markers: tangents against differences, balance of forces and moments.

use mpm_assembly::{
    Body, BodyAtStart, BodySide, Constraints, Contribution, Hold, MarkerForce, MarkerLoad, MaterialBody,
    SparsityPattern, StepStart, SystemSums, ToolLoad, Trial, UnknownVector, Unknowns, Unshared, Wall,
    WallContact, stiffness_error,
};
use mpm_basis::{ActiveNodes, Connectivity, Cpdi1, seed_cells};
use mpm_contact::{Plane, Shape, Sphere, Tool, ToolMotion, moment};
use mpm_grid::{Axis, Layout, LoadFraction, Mesh, NodeSpace, Ramp, Vector};
use mpm_linear::Symmetry;
use mpm_material::{Elasticity, Hencky};
use nalgebra::Vector3;

/// A contribution that has begun a step on a block of cells between 1 and 3, and a displacement of all unknowns.
struct Begun<const D: usize, C> {
    contribution: C,
    pattern: SparsityPattern<D>,
    increment: UnknownVector<D>,
    positions: Vec<Vector<D>>,
}

fn begun<const D: usize, C: Contribution<D>>(degree: u32, mut contribution: C) -> Begun<D, C> {
    let axes = std::array::from_fn(|_| Axis::uniform(0.0, 4.0, 4).unwrap());
    let layout = Layout::<D>::on_axes(axes).unwrap();
    let layout = if degree == 1 { layout } else { layout.with_splines(degree).unwrap() };
    let mesh = Mesh::at_rest(&layout);
    let within = mesh.cells().filter(|index| index.iter().all(|&i| (1..3).contains(&i)));
    let law = Hencky(Elasticity::from_young_poisson(1e3, 0.3).unwrap());
    let points = seed_cells(&Cpdi1, &mesh, within, 2);
    let body = MaterialBody::new(Cpdi1, law, points);
    let stencils = body.stencils(&mesh).unwrap();
    let space = NodeSpace::of(mesh.functions(), &mesh).unwrap();
    let active = ActiveNodes::of(&space, std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let bodies = [BodyAtStart { name: "block", body: &body, connectivity: &connectivity }];
    let (from, to) = (LoadFraction::START, LoadFraction::END);
    let step = StepStart {
        mesh: &mesh,
        active: &active,
        bodies: &bodies,
        from,
        to,
        is_retry: false,
        sharing: &Unshared,
    };
    let mut unknowns = Unknowns::of_nodes(active.len());
    contribution.begin(&step, &mut unknowns).unwrap();
    let symmetry = contribution.symmetry();
    let pattern = SparsityPattern::reusing(None, &unknowns, symmetry, &[contribution.couplings()]);
    let mut increment = UnknownVector::zeros(&unknowns);
    let entries = (0..unknowns.n_equations()).map(|k| 0.05 * (2.3 * k as f64 + 0.4).sin());
    increment.read_equations(&entries.collect::<Vec<_>>());
    let positions = active.nodes().iter().map(|&node| space.position(&mesh, node)).collect();
    Begun { contribution, pattern, increment, positions }
}

impl<const D: usize, C: Contribution<D>> Begun<D, C> {
    fn trial<'a>(&'a self, constraints: &'a Constraints<D>) -> Trial<'a, D> {
        Trial {
            pattern: &self.pattern,
            constraints,
            increment: &self.increment,
            end: LoadFraction::END,
            is_first: false,
        }
    }

    fn stiffness_error(&self) -> f64 {
        let constraints = Constraints::none(self.positions.len());
        stiffness_error(&self.contribution, &self.trial(&constraints)).unwrap()
    }

    /// Forces on the nodes.
    fn forces(&self) -> Vec<Vector<D>> {
        let constraints = Constraints::none(self.positions.len());
        let mut force = UnknownVector::zeros(self.pattern.unknowns());
        let mut sums = SystemSums::new(&mut force, None);
        self.contribution.add(&self.trial(&constraints), &mut sums).unwrap();
        force.nodes
    }
}

/// Points round a square from (1, 1) to (3, 3), 4 on each edge, anticlockwise; all of them or of the first edge.
fn square(is_closed: bool) -> BodySide<2> {
    let corners = [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0), (1.0, 1.0)];
    let mut markers = Vec::new();
    for edge in corners.windows(2).take(if is_closed { 4 } else { 1 }) {
        for k in 0..4 {
            let part = f64::from(k) / 4.0;
            let at = |a: f64, b: f64| a + (b - a) * part;
            markers.push(Vector::<2>::new(at(edge[0].0, edge[1].0), at(edge[0].1, edge[1].1)));
        }
    }
    if !is_closed {
        markers.push(Vector::<2>::new(3.0, 1.0));
    }
    let n = markers.len() as u32;
    let facets = (0..if is_closed { n } else { n - 1 }).map(|k| [k, (k + 1) % n]).collect();
    BodySide { body: "block".into(), name: "side".into(), markers, facets, layers: 1 }
}

/// The face x = 3 of a block, of four quadrilaterals.
fn face() -> BodySide<3> {
    let at = |k: usize| Vector3::new(3.0, 1.0 + (k % 3) as f64, 1.0 + (k / 3) as f64);
    let mut facets = Vec::new();
    for corner in [0, 1, 3, 4] {
        let [a, b, c, d] = [corner, corner + 1, corner + 4, corner + 3];
        facets.extend([[a, b, c], [a, c, d], [a, b, d], [b, c, d]]);
    }
    let markers = (0..9).map(at).collect();
    BodySide { body: "block".into(), name: "face".into(), markers, facets, layers: 2 }
}

fn pressure<const D: usize>(side: BodySide<D>, symmetry: Symmetry) -> MarkerLoad<D> {
    MarkerLoad::new(side, MarkerForce::Pressure(7.0), Ramp::linear(1.0), symmetry)
}

#[test]
fn tangents_of_pressures() {
    for degree in [1, 2, 3] {
        let closed = begun(degree, pressure(square(true), Symmetry::Symmetric)).stiffness_error();
        let open = begun(degree, pressure(square(false), Symmetry::Unsymmetric)).stiffness_error();
        let face = begun(degree, pressure(face(), Symmetry::Unsymmetric)).stiffness_error();
        assert!([closed, open, face].iter().all(|error| *error < 1e-7), "{closed:e} {open:e} {face:e}");
        // What the ends of an open side add is not small.
        let without_ends = begun(degree, pressure(square(false), Symmetry::Symmetric)).stiffness_error();
        assert!(without_ends > 1e-2, "{without_ends:e}");
    }
}

/// A pressure round a body, as it is deformed, has no resultant and no moment; a dead traction has its own.
#[test]
fn forces_and_moments_are_those_of_the_load() {
    for degree in [1, 2, 3] {
        let round = begun(degree, pressure(square(true), Symmetry::Symmetric));
        let side = square(false);
        let traction = MarkerForce::traction(&side, &Vector::<2>::new(2.0, -1.0));
        let dead = MarkerLoad::new(side, traction, Ramp::linear(1.0), Symmetry::Symmetric);
        let dead = begun(degree, dead);
        let sums = |of: &Begun<2, MarkerLoad<2>>| {
            let forces = of.forces();
            let whole: Vector<2> = forces.iter().sum();
            // Nodes carry the arms: Σ N_v (X_v + Δu_v) is where the marker is.
            let nodes = of.positions.iter().zip(&of.increment.nodes);
            let moments = nodes.zip(&forces).map(|((x, u), force)| moment(&(x + u), force).z);
            (whole, moments.sum::<f64>())
        };
        let (whole, turn) = sums(&round);
        assert!(whole.norm() < 1e-12 && turn.abs() < 1e-11, "{whole} {turn}");
        let (whole, _) = sums(&dead);
        assert!((whole - Vector::<2>::new(-4.0, 2.0)).norm() < 1e-12, "{whole}");
    }
}

fn wall<const D: usize>(side: BodySide<D>, hold: Hold<D>, motion: ToolMotion<D>) -> Wall<D> {
    let moment_about = Vector::from_fn(|d, _| 0.5 + d as f64);
    Wall { side, hold, motion, load: None, stiffness: 2.0, exact: false, moment_about }
}

fn tool<const D: usize>(shape: impl Shape<D> + 'static) -> Tool<D> {
    Tool::new(vec![Box::new(shape)]).unwrap()
}

#[test]
fn tangents_of_walls_that_move() {
    let by = [Ramp::linear(0.3), Ramp::linear(-0.1)];
    let turn = || {
        ToolMotion::turning(by.clone(), Vector::<2>::new(1.0, 0.0), Vector3::z(), Ramp::linear(0.4)).unwrap()
    };
    let disc = || tool(Sphere::new(Vector::<2>::new(2.0, -3.0), 4.2).unwrap());
    let plane = || tool(Plane::new(Vector::<2>::new(0.0, 1.0), Vector::<2>::new(0.2, 1.0)).unwrap());
    for degree in [1, 2] {
        for hold in [Hold::All, Hold::Normal(disc()), Hold::Normal(plane()), Hold::Contact(disc())] {
            let name = format!("{hold:?}");
            let error =
                begun(degree, WallContact::new("w", wall(square(false), hold, turn()))).stiffness_error();
            assert!(error < 1e-7, "{name}: {error:e}");
        }
        let ball = tool(Sphere::new(Vector3::new(8.0, 2.0, 2.0), 5.1).unwrap());
        let error = begun(degree, WallContact::new("w", wall(face(), Hold::Normal(ball), ToolMotion::rest())));
        assert!(error.stiffness_error() < 1e-7);
    }
}

#[test]
fn tangents_of_frames() {
    let by = || ToolMotion::shifted([Ramp::linear(0.1), Ramp::constant(0.0)]).unwrap();
    for free in [vec![0, 1, 2], vec![2], vec![1, 2]] {
        let ramp = Ramp::linear(1.0);
        for follows in [false, true] {
            let (free, ramp) = (free.clone(), ramp.clone());
            let (force, moment) = (Vector::<2>::new(3.0, -2.0), Vector3::z() * 5.0);
            let load = ToolLoad { free, force, moment, ramp, follows };
            let wall = Wall { load: Some(load), ..wall(square(false), Hold::All, by()) };
            let error = begun(2, WallContact::new("frame", wall)).stiffness_error();
            assert!(error < 1e-7, "{follows}: {error:e}");
        }
    }
    let load = ToolLoad {
        free: vec![0, 2],
        force: Vector3::new(3.0, 0.0, -2.0),
        moment: Vector3::zeros(),
        ramp: Ramp::linear(1.0),
        follows: false,
    };
    let wall = Wall { load: Some(load), ..wall(face(), Hold::All, ToolMotion::rest()) };
    let error = begun(2, WallContact::new("frame", wall)).stiffness_error();
    assert!(error < 1e-7, "{error:e}");
}
