//! A model: nouns with everything resolved, nothing left to look up.

mod control;
mod loads;
mod solver;
mod supports;

pub use control::{DomainLimit, PathControl, PathMeasure, PredictorKind, Stage, Tolerance, UnheldMotion};
pub use loads::{BodyForce, Loads, PointLoad, Share, Side, SideLoad};
pub use solver::{SolverChoice, SolverFactory};
pub use supports::{Active, Prescribed, Release, Support, Turn, across};

use mpm_assembly::{Body, Contribution, Space};
use mpm_grid::{Layout, Mesh, MeshMotion, NodeSpace, Region, Vector};
use mpm_linear::{Automatic, Choice, LinearSolver, Symmetry};

/// All that a run needs to know.
///
/// The example of the [crate] makes one by hand, with a body of any basis and law.
#[non_exhaustive]
pub struct Model<const D: usize> {
    /// Where the mesh's nodes stand at rest.
    pub layout: Layout<D>,
    /// The nodes that the bodies' bases live on.
    pub nodes: NodeSpace<D>,
    /// How the mesh moves.
    pub motion: MeshMotion<D>,
    /// The bodies, in the order of the scene.
    pub bodies: Vec<NamedBody<D>>,
    /// The supports, in the order of the scene.
    pub supports: Vec<Support<D>>,
    /// Forces.
    pub loads: Loads<D>,
    /// Load steps: the stages of the schedule, one after the other.
    pub stages: Vec<Stage>,
    /// When a load step counts as solved.
    pub tolerance: Tolerance,
    /// What is done about rigid motions that nothing holds.
    pub unheld_motion: UnheldMotion,
    /// How linear systems are solved.
    pub solver: SolverChoice,
    /// What is done about domains that have outgrown their cells, if anything.
    pub domain_limit: Option<DomainLimit>,
    /// What adds to force and tangent besides the bodies, in the order of the sums.
    pub contributions: Vec<NamedContribution<D>>,
    /// Whether the history tells the health of the points' domains.
    pub domain_history: bool,
    /// Whether the history tells the condition number of the tangent.
    pub condition_history: bool,
    /// Whether the history tells energies.
    pub energies: bool,
    /// Whether a run ends where driven nodes have lost their body, see [`crate::Error::LostBody`]; it does, unless a program
    /// says otherwise.
    pub needs_grip: bool,
    /// What the history follows besides supports, in the order of the scene.
    pub probes: Vec<Probe<D>>,
    /// Where other ranks have made points, too: of every body the numbers, among all its points, of those that are here; ascending.
    /// Loads and probes name points by their numbers among all until ranks [divide](crate::Ranks::divide) the model. None where
    /// all points are here.
    pub share: Option<Vec<Vec<u64>>>,
}

impl<const D: usize> Model<D> {
    /// A mesh at rest without bodies, supports and loads; one load step. Its nodes are those of the layout's functions.
    ///
    /// # Panics
    /// Never: a layout has the nodes of its functions.
    pub fn new(layout: Layout<D>) -> Self {
        let mesh = Mesh::at_rest(&layout);
        let nodes = NodeSpace::of(mesh.functions(), &mesh).expect("a layout has the nodes of its functions");
        Self::on(layout, nodes)
    }

    /// As [`Self::new`], with other nodes of the layout: those of its bodies' basis, see
    /// [`mpm_basis::Basis::node_kind`].
    pub fn on(layout: Layout<D>, nodes: NodeSpace<D>) -> Self {
        Self {
            layout,
            nodes,
            motion: MeshMotion::Fixed,
            bodies: Vec::new(),
            supports: Vec::new(),
            loads: Loads::default(),
            stages: vec![Stage::equal(1)],
            tolerance: Tolerance::default(),
            unheld_motion: UnheldMotion::default(),
            solver: SolverChoice::default(),
            domain_limit: None,
            contributions: Vec::new(),
            domain_history: false,
            condition_history: false,
            energies: false,
            needs_grip: true,
            probes: Vec::new(),
            share: None,
        }
    }

    /// The space of its bodies.
    pub fn space(&self) -> Space {
        self.bodies.first().map_or(Space::default(), |named| named.body.space())
    }

    /// Coordinates of a place: one less than components of a displacement, where bodies turn about an axis.
    pub(crate) fn coordinates(&self) -> usize {
        self.space().coordinates::<D>()
    }

    /// Whether bodies turn about their axis of revolution.
    pub fn turns(&self) -> bool {
        self.space().turns::<D>()
    }

    /// Number of nodes of the mesh; of a layer those of its section.
    pub(crate) fn n_nodes(&self) -> usize {
        self.nodes.lattice().nodes().iter().take(self.coordinates()).map(|&nodes| nodes as usize).product()
    }

    /// Its bodies with their names, as contributions see them.
    pub(crate) fn bodies_by_name(&self) -> Vec<(&str, &dyn Body<D>)> {
        self.bodies.iter().map(|named| (&*named.name, &*named.body)).collect()
    }

    /// Whether the tangents equal their transposes: those of all bodies and contributions have to.
    pub(crate) fn symmetry(&self) -> Symmetry {
        let of_bodies = self.bodies.iter().map(|named| named.body.symmetry());
        let mut all = of_bodies.chain(self.contributions.iter().map(|named| named.contribution.symmetry()));
        if all.all(|it| it == Symmetry::Symmetric) { Symmetry::Symmetric } else { Symmetry::Unsymmetric }
    }

    /// The choice among the shipped solvers, if one of them is to be taken. Path control takes the signs of pivots to see
    /// limit points, which conjugate gradients in the plane can pass without notice, and GMRES never sees.
    pub fn choice(&self) -> Option<Choice> {
        let needs_pivots =
            || self.follows_path() && (self.coordinates() == 2 || self.symmetry() == Symmetry::Unsymmetric);
        match self.solver {
            SolverChoice::Automatic(Choice::Auto) if needs_pivots() => Some(Choice::Direct),
            // Forces and torques have no common measure that iterations could be ended by.
            SolverChoice::Automatic(Choice::Auto) if self.turns() => Some(Choice::Direct),
            SolverChoice::Automatic(choice) => Some(choice),
            SolverChoice::Custom(_) => None,
        }
    }

    /// Whether the load fraction follows the path in any stage.
    pub(crate) fn follows_path(&self) -> bool {
        self.stages.iter().any(|stage| stage.path.is_some())
    }

    /// Whether the history says in which stage a row is.
    pub(crate) fn has_named_stages(&self) -> bool {
        self.stages.iter().any(|stage| !stage.name.is_empty())
    }

    /// A linear solver for a run.
    pub fn linear_solver(&self) -> Box<dyn LinearSolver> {
        match (&self.solver, self.choice()) {
            (SolverChoice::Custom(make), _) => make(),
            (_, choice) => Box::new(Automatic::new(choice.unwrap_or_default())),
        }
    }

    /// Load fractions of the knots of all its ramps in a stage, in no order, some more than once.
    pub(crate) fn knots_in(&self, stage: u32) -> Vec<f64> {
        let supports = self.supports.iter().flat_map(|support| support.components.iter().flatten());
        let prescribed = supports.filter_map(Prescribed::ramp);
        let Loads { body_forces, point_loads, side_loads, fields } = &self.loads;
        let forces = body_forces.iter().map(|(_, ramp)| ramp).chain(point_loads.iter().map(|load| &load.ramp));
        let forces = forces.chain(side_loads.iter().map(|load| &load.ramp));
        let fields = fields.iter().flat_map(|(_, field)| field.ramps());
        let contributions = self.contributions.iter().flat_map(|named| named.contribution.ramps());
        let ramps = prescribed.chain(forces).chain(fields).chain(self.motion.ramps()).chain(contributions);
        let knots = ramps.flat_map(|ramp| ramp.knots().map(|knot| knot.0));
        knots.filter(|at| at.stage() == stage).map(|at| at.get()).collect()
    }

    /// Puts a body behind the others.
    pub fn add_body(&mut self, name: impl Into<String>, body: Box<dyn Body<D>>) {
        self.bodies.push(NamedBody { name: name.into(), body, shape_volume: None, density: None });
    }

    /// Puts a contribution to force and tangent behind the others. Its name is that of its state in checkpoints; no two
    /// have the same.
    pub fn add_contribution(&mut self, name: impl Into<String>, contribution: Box<dyn Contribution<D>>) {
        self.contributions.push(NamedContribution { name: name.into(), contribution });
    }

    /// Makes what the last load step has prepared the present state.
    pub(crate) fn commit(&mut self) {
        self.bodies.iter_mut().for_each(|named| named.body.commit());
        self.contributions.iter_mut().for_each(|named| named.contribution.commit());
    }

    /// Puts a support of the nodes in a region (at rest) behind the others.
    pub fn add_support(
        &mut self,
        name: impl Into<String>,
        region: &Region<D>,
        components: [Option<Prescribed>; D],
    ) {
        let nodes = region.nodes(&self.nodes, &self.layout);
        self.supports.push(Support {
            name: name.into(),
            nodes,
            components,
            moment_about: None,
            active: Active::default(),
        });
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
    /// Their mean position where displacements count from: at rest, or at the last stage that resets them `[L]`.
    pub rest: Vector<D>,
}

/// A body and its name.
pub struct NamedBody<const D: usize> {
    /// Its name in the scene.
    pub name: String,
    /// Its points, law and basis.
    pub body: Box<dyn Body<D>>,
    /// Volume of the shape that its points fill, where it is known `[L^D]`.
    pub shape_volume: Option<f64>,
    /// Mass per volume at rest, where it is known `[M/L^D]`.
    pub density: Option<f64>,
}

/// A contribution to force and tangent, and its name.
pub struct NamedContribution<const D: usize> {
    /// Its name in messages and checkpoints.
    pub name: String,
    /// What it adds.
    pub contribution: Box<dyn Contribution<D>>,
}
