//! A compiled scene: nouns with everything resolved, nothing left to look up.

use crate::domains::DomainLimit;
use crate::vortex::Vortex;
use mpm_assembly::{Body, views};
use mpm_grid::{Layout, LoadFraction, MeshMotion, NodeId, Ramp, Region, Vector};
use mpm_linear::Choice;

/// All that a run needs to know.
///
/// A scene is compiled into one ([`crate::compile`]). Without a scene, with a body of any basis and law:
///
/// ```
/// use mpm_assembly::MaterialBody;
/// use mpm_basis::{Basis, Smpm};
/// use mpm_grid::{Axis, Layout, Mesh, Ramp, Region, Vector};
/// use mpm_material::{Elasticity, Hencky};
/// use mpm_solver::{Model, Prescribed, Schedule, run};
///
/// // A cell with one point, pressed to nine tenths of its height.
/// let axis = Axis::uniform(0.0, 1.0, 1)?;
/// let layout = Layout::on_axes([axis.clone(), axis])?;
/// let mut points = Vec::new();
/// let (low, high) = (Vector::<2>::repeat(-1.0), Vector::<2>::repeat(1.0));
/// Smpm.seed(&Mesh::at_rest(&layout).piece([0, 0], &low, &high), &mut |seed| points.push(seed));
/// let law = Hencky(Elasticity::from_young_poisson(1000.0, 0.3)?);
///
/// let mut model = Model::new(layout);
/// model.add_body("block", Box::new(MaterialBody::new(Smpm, law, points)));
/// let side = |axis: usize, at: f64| Region::<2>::Plane { axis, at };
/// model.add_support("left", &side(0, 0.0), [Some(Prescribed::Held), None]);
/// model.add_support("base", &side(1, 0.0), [None, Some(Prescribed::Held)]);
/// model.add_support("top", &side(1, 1.0), [None, Some(Prescribed::Driven(Ramp::linear(-0.1)))]);
/// model.schedule = Schedule::equal(2);
/// let summary = run(&mut model, &mut ())?;
/// assert_eq!((summary.steps, summary.cuts, summary.points), (2, 0, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[non_exhaustive]
pub struct Model<const D: usize> {
    /// Where the mesh's nodes stand at rest.
    pub layout: Layout<D>,
    /// How they move.
    pub motion: MeshMotion<D>,
    /// The bodies, in the order of the scene.
    pub bodies: Vec<NamedBody<D>>,
    /// The supports, in the order of the scene.
    pub supports: Vec<Support<D>>,
    /// Forces.
    pub loads: Loads<D>,
    /// Load steps.
    pub schedule: Schedule,
    /// How the load fraction follows the path, where it does.
    pub path: Option<PathControl>,
    /// When a load step counts as solved.
    pub tolerance: Tolerance,
    /// How linear systems are solved.
    pub solver: Choice,
    /// What is done about domains that have outgrown their cells, if anything.
    pub domain_limit: Option<DomainLimit>,
    /// Stiffness of the jumps of displacement gradient at the edge of the bodies over Young's modulus, where
    /// they are to be penalised; see [`mpm_assembly::GhostFaces`].
    pub ghost: Option<f64>,
    /// Whether the history tells the health of the points' domains.
    pub domain_history: bool,
    /// Whether the history tells the condition number of the tangent.
    pub condition_history: bool,
    /// Whether the history tells energies.
    pub energies: bool,
    /// What the history follows besides supports, in the order of the scene.
    pub probes: Vec<Probe<D>>,
}

impl<const D: usize> Model<D> {
    /// A mesh at rest without bodies, supports and loads; one load step.
    pub fn new(layout: Layout<D>) -> Self {
        Self {
            layout,
            motion: MeshMotion::Fixed,
            bodies: Vec::new(),
            supports: Vec::new(),
            loads: Loads::default(),
            schedule: Schedule::equal(1),
            path: None,
            tolerance: Tolerance::default(),
            solver: Choice::Auto,
            domain_limit: None,
            ghost: None,
            domain_history: false,
            condition_history: false,
            energies: false,
            probes: Vec::new(),
        }
    }

    /// How its linear systems are solved: path control in the plane takes the signs of pivots to see limit points,
    /// which conjugate gradients can pass without notice.
    pub(crate) fn linear_solver(&self) -> Choice {
        match self.solver {
            Choice::Auto if D == 2 && self.path.is_some() => Choice::Direct,
            chosen => chosen,
        }
    }

    /// Puts a body behind the others.
    pub fn add_body(&mut self, name: impl Into<String>, body: Box<dyn Body<D>>) {
        self.bodies.push(NamedBody { name: name.into(), body, shape_volume: None });
    }

    /// Puts a support of the mesh's nodes in a region (at rest) behind the others.
    pub fn add_support(
        &mut self,
        name: impl Into<String>,
        region: &Region<D>,
        components: [Option<Prescribed>; D],
    ) {
        let nodes = region.nodes(&self.layout);
        self.supports.push(Support { name: name.into(), nodes, components, moment_about: None });
    }
}

/// Points of a body that are followed through the history.
#[derive(Clone, Debug)]
pub struct Probe<const D: usize> {
    /// Its name in the results.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// Its points, ascending; at least one.
    pub points: Vec<usize>,
    /// Their mean position at rest `[L]`.
    pub rest: Vector<D>,
}

/// A body and its name.
pub struct NamedBody<const D: usize> {
    /// Its name in the scene.
    pub name: String,
    /// Its points, law and basis.
    pub body: Box<dyn Body<D>>,
    /// Volume of the shape that its points fill, where theirs is found in another way `[L^D]`.
    pub shape_volume: Option<f64>,
}

/// Prescribed displacements of a set of nodes.
#[derive(Clone, Debug)]
pub struct Support<const D: usize> {
    /// Its name in the results.
    pub name: String,
    /// Its nodes, ascending; those that carry no material are ignored.
    pub nodes: Vec<NodeId>,
    /// What is prescribed of each component, if anything.
    pub components: [Option<Prescribed>; D],
    /// Point about which the moment of the reaction is recorded, if it is `[L]`.
    pub moment_about: Option<[f64; 2]>,
}

/// How a component of displacement is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub enum Prescribed {
    /// Zero.
    Held,
    /// A displacement against the load fraction `[L]`.
    Driven(Ramp),
    /// The motion of the mesh.
    FollowMesh,
    /// A rotation, of which this is a component across the axis.
    Turned(Turn),
}

/// A rotation about an axis along a direction of space.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Direction of the axis, from 0; 2 in the plane.
    pub axis: usize,
    /// Where the axis passes, by the coordinates across it in their order `[L]`.
    pub centre: [f64; 2],
    /// Angle against the load fraction, right-handed about the axis `[rad]`.
    pub angle: Ramp,
}

impl Turn {
    /// The two directions across the axis, in their order.
    pub fn across(&self) -> [usize; 2] {
        match self.axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// `(R(Δα) - I)(x - c)` of what stands at `x` at the start of a load step `[L]`.
    pub fn displacement<const D: usize>(
        &self,
        x: &Vector<D>,
        start: LoadFraction,
        end: LoadFraction,
    ) -> Vector<D> {
        let angle = self.angle.value(end) - self.angle.value(start);
        // x, z, y is left-handed.
        let sine = if self.axis == 1 { -angle.sin() } else { angle.sin() };
        // cos - 1 without the difference.
        let less = -2.0 * (0.5 * angle).sin().powi(2);
        let [d, e] = self.across();
        let (a, b) = (x[d] - self.centre[0], x[e] - self.centre[1]);
        Vector::from_fn(|i, _| match i {
            i if i == d => less * a - sine * b,
            i if i == e => sine * a + less * b,
            _ => 0.0,
        })
    }
}

/// Forces on the bodies.
#[derive(Clone, Debug, Default)]
pub struct Loads<const D: usize> {
    /// Body forces: force per mass at full load `[L/T²]` and its ramp.
    pub body_forces: Vec<(Vector<D>, Ramp)>,
    /// Forces on single points.
    pub point_loads: Vec<PointLoad<D>>,
    /// Manufactured body forces: the body's index, and the field.
    pub vortices: Vec<(usize, Vortex)>,
}

/// One load carried by points of one body.
#[derive(Clone, Debug)]
pub struct PointLoad<const D: usize> {
    /// Index of the body.
    pub body: usize,
    /// Points and the part of the force that each carries, ascending in point; the parts sum to 1.
    pub shares: Vec<(usize, f64)>,
    /// The whole force at full load `[F]`.
    pub force: Vector<D>,
    /// Part of it against the load fraction.
    pub ramp: Ramp,
}

impl<const D: usize> Loads<D> {
    /// Body force per mass at a load fraction, if any acts at all `[L/T²]`.
    pub fn acceleration(&self, at: LoadFraction) -> Option<Vector<D>> {
        if self.body_forces.is_empty() {
            return None;
        }
        Some(self.body_forces.iter().fold(Vector::zeros(), |sum, (force, ramp)| sum + force * ramp.value(at)))
    }

    /// Forces on the points of one body at a load fraction, ascending in point `[F]`.
    pub fn point_forces(&self, body: usize, points: &dyn Body<D>, at: LoadFraction) -> Vec<(usize, Vector<D>)> {
        let mut forces: Vec<(usize, Vector<D>)> = Vec::new();
        for load in self.point_loads.iter().filter(|load| load.body == body) {
            let force = load.force * load.ramp.value(at);
            forces.extend(load.shares.iter().map(|&(point, share)| (point, force * share)));
        }
        for (_, vortex) in self.vortices.iter().filter(|(index, _)| *index == body) {
            forces.extend(views(points).enumerate().map(|(point, view)| {
                let rest = view.reference_position.expect("kept where a vortex acts");
                (point, vortex.body_force(&rest, at) * view.reference_volume)
            }));
        }
        forces.sort_by_key(|&(point, _)| point);
        forces
    }
}

/// Equal load steps, and how often one may be halved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Number of nominal load steps.
    pub steps: u32,
    /// Halvings of a nominal step before the run gives up.
    pub cuts: u8,
    /// Where Newton's iteration begins.
    pub predictor: Predictor,
}

impl Schedule {
    /// Halvings at most: a part of a step is a whole number of the smallest ones, in 64 bits.
    pub const MOST_CUTS: u8 = 40;

    /// So many equal load steps, each of which may be halved ten times.
    pub const fn equal(steps: u32) -> Self {
        Self { steps, cuts: 10, predictor: Predictor::LastStep }
    }
}

/// Where the iteration of a load step begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Predictor {
    /// At the displacement of the step before; where that does not converge at once, at rest.
    #[default]
    LastStep,
    /// At rest.
    Rest,
}

/// Control of the path: the load fraction is found, and may decrease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathControl {
    /// What the length of a step is.
    pub measure: PathMeasure,
    /// Change of the load fraction in the first step `[-]`.
    pub first: f64,
    /// Largest change of the load fraction in any step, about `[-]`.
    pub longest: f64,
    /// Iterations that a step should need: with fewer the next is longer, with more shorter.
    pub iterations: u32,
}

/// What the length of a step along the path is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMeasure {
    /// Root mean square of the free displacements.
    ArcLength {
        /// Longest step `[L]`.
        most: Option<f64>,
    },
    /// Dissipated energy.
    Dissipation {
        /// Longest step `[F L]`.
        most: Option<f64>,
    },
}

/// When a load step counts as solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// `|f_oob| / (|f_ext| + |f_reaction|)` `[-]`.
    pub residual: f64,
    /// Newton iterations before the step is cut.
    pub iterations: u32,
    /// Part of the out-of-balance force that an iteration may leave for its factorisation to be kept, if it
    /// may be at all `[-]`.
    pub keep_factor_below: Option<f64>,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { residual: 1e-9, iterations: 25, keep_factor_below: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_right_handed_about_its_axis() {
        let quarter = |axis: usize, x: [f64; 3]| {
            let angle = Ramp::linear(std::f64::consts::FRAC_PI_2);
            let turn = Turn { axis, centre: [0.0, 0.0], angle };
            let x = Vector::<3>::from(x);
            x + turn.displacement(&x, LoadFraction::START, LoadFraction::END)
        };
        let near = |found: Vector<3>, expected: [f64; 3]| {
            assert!((found - Vector::<3>::from(expected)).norm() < 1e-15)
        };
        near(quarter(2, [1.0, 0.0, 5.0]), [0.0, 1.0, 5.0]);
        near(quarter(0, [5.0, 1.0, 0.0]), [5.0, 0.0, 1.0]);
        near(quarter(1, [0.0, 5.0, 1.0]), [1.0, 5.0, 0.0]);
        // About another centre, which stays; the distance from it is kept.
        let turn = Turn { axis: 1, centre: [2.0, 3.0], angle: Ramp::linear(0.7) };
        let at = |x: [f64; 3]| turn.displacement(&Vector::<3>::from(x), LoadFraction::START, LoadFraction::END);
        assert_eq!(at([2.0, 9.0, 3.0]).norm(), 0.0);
        let moved = Vector::<3>::new(1.5, 0.0, -0.5) + at([3.5, 9.0, 2.5]);
        assert!((moved.norm() - 1.5_f64.hypot(0.5)).abs() < 1e-15);
    }
}
