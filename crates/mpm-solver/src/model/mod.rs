//! A model: nouns with everything resolved, nothing left to look up.

mod control;
mod loads;
mod supports;

pub use control::{DomainLimit, PathControl, PathMeasure, PredictorKind, Schedule, Tolerance};
pub use loads::{BodyForce, Loads, PointLoad};
pub use supports::{Prescribed, Support, Turn};

use mpm_assembly::Body;
use mpm_grid::{Layout, MeshMotion, Region, Vector};
use mpm_linear::Choice;

/// All that a run needs to know.
///
/// The example of the [crate] makes one by hand, with a body of any basis and law.
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
