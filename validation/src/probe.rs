//! The forces and the tangent of one body under any nodal displacement, without a solver.

use crate::Broken;
use crate::scenes::compiled;
use mpm_assembly::{
    AssemblyPlan, BodyAtStart, BodyConnectivity, ConnectedBody, Constraints, Contribution, Converged,
    Couplings, PointView, SparsityPattern, StepStart, SystemSums, SystemTangent, Trial, UnknownVector,
    Unknowns, Unshared,
};
use mpm_basis::{ActiveNodes, Connectivity};
use mpm_grid::{LoadFraction, Mesh, NodeSpace, Vector};
use mpm_linear::Matrix;
use mpm_material::SymmetricTensor;
use mpm_scene::Compiled;
use mpm_scene::Scene;
use mpm_solver::{Model, NamedBody, NamedContribution};

/// The first body of a model on the mesh at rest, with the contributions of the model, ready to be displaced.
pub struct Probe<const D: usize> {
    named: NamedBody<D>,
    contributions: Vec<NamedContribution<D>>,
    mesh: Mesh<D>,
    active: ActiveNodes<D>,
    pattern: SparsityPattern<D>,
    plan: AssemblyPlan<D>,
}

/// The model of a scene in plane strain.
///
/// # Errors
/// The scene does not compile, or is not in plane strain.
pub fn plane(scene: &Scene) -> Result<Model<2>, Broken> {
    match compiled(scene)? {
        Compiled::Plane(model) => Ok(model),
        Compiled::Solid(_) => Err("expected a scene in plane strain".into()),
    }
}

/// The model of a scene in three dimensions.
///
/// # Errors
/// The scene does not compile, or is in plane strain.
pub fn solid(scene: &Scene) -> Result<Model<3>, Broken> {
    match compiled(scene)? {
        Compiled::Solid(model) => Ok(model),
        Compiled::Plane(_) => Err("expected a scene in three dimensions".into()),
    }
}

impl<const D: usize> Probe<D> {
    /// Takes the first body of a model.
    ///
    /// # Errors
    /// The mesh does not cover it.
    pub fn of(model: Model<D>) -> Result<Self, Broken> {
        let mesh = model.motion.mesh_at(&model.layout, LoadFraction::START)?;
        let named = model.bodies.into_iter().next().expect("a scene has a body");
        let mut contributions = model.contributions;
        let (active, pattern, plan) = connect(&named, &mut contributions, &mesh)?;
        Ok(Self { named, contributions, mesh, active, pattern, plan })
    }

    /// Number of active nodes.
    pub fn n_nodes(&self) -> usize {
        self.active.len()
    }

    /// A nodal field from a function of position.
    pub fn field(&self, of: impl Fn(Vector<D>) -> Vector<D>) -> Vec<Vector<D>> {
        self.active.nodes().iter().map(|&node| of(self.active.space().position(&self.mesh, node))).collect()
    }

    /// Every material point.
    pub fn points(&self) -> Vec<PointView<D>> {
        mpm_assembly::views(&*self.named.body).collect()
    }

    /// Kirchhoff stress of every material point `[F/L²]`.
    pub fn stresses(&self) -> Vec<SymmetricTensor> {
        let body = &*self.named.body;
        mpm_assembly::of_points(body, |point| body.kirchhoff(point)).collect()
    }

    /// `f_int` under an increment of displacement `[F]`.
    ///
    /// # Errors
    /// The increment inverts a point.
    pub fn internal(&self, increment: &[Vector<D>]) -> Result<Vec<Vector<D>>, Broken> {
        self.sum(increment, None)
    }

    /// `K v` with the assembled tangent of an increment of displacement `[F]`.
    ///
    /// # Errors
    /// The increment inverts a point.
    pub fn tangent_times(&self, increment: &[Vector<D>], v: &[Vector<D>]) -> Result<Vec<Vector<D>>, Broken> {
        let mut values = vec![0.0; self.pattern.n_entries()];
        self.sum(increment, Some(SystemTangent { values: &mut values, lift: None }))?;
        let flat: Vec<f64> = v.iter().flat_map(|v| v.iter().copied()).collect();
        let product = Matrix { pattern: self.pattern.for_solver(), values: &values }.times(&flat);
        Ok(product.chunks_exact(D).map(Vector::from_column_slice).collect())
    }

    /// The internal force, and the tangent where it is wanted.
    fn sum(
        &self,
        increment: &[Vector<D>],
        tangent: Option<SystemTangent<'_, D>>,
    ) -> Result<Vec<Vector<D>>, Broken> {
        let (pattern, constraints) = (&self.pattern, &Constraints::none(self.active.len()));
        let mut force = UnknownVector::zeros(pattern.unknowns());
        let increment = &UnknownVector { nodes: increment.to_vec(), ..force.clone() };
        let trial = Trial { pattern, constraints, increment, end: LoadFraction::END, is_first: false };
        let mut sums = SystemSums::new(&mut force, tangent);
        let body = ConnectedBody { body: &*self.named.body, plan: &self.plan };
        body.add(&trial, &mut sums)?;
        for named in &self.contributions {
            named.contribution.add(&trial, &mut sums)?;
        }
        Ok(force.nodes)
    }

    /// Carries the points through an increment of displacement, and connects them to the mesh again.
    ///
    /// # Errors
    /// A point is inverted or leaves the mesh.
    pub fn advance(&mut self, increment: &[Vector<D>]) -> Result<(), Broken> {
        let step = Converged { mesh: &self.mesh, active: &self.active, increment, own: &[] };
        self.named.body.prepare(&self.plan, step)?;
        self.named.body.commit();
        (self.active, self.pattern, self.plan) = connect(&self.named, &mut self.contributions, &self.mesh)?;
        Ok(())
    }
}

type Connected<const D: usize> = (ActiveNodes<D>, SparsityPattern<D>, AssemblyPlan<D>);

fn connect<const D: usize>(
    named: &NamedBody<D>,
    contributions: &mut [NamedContribution<D>],
    mesh: &Mesh<D>,
) -> Result<Connected<D>, Broken> {
    let body = &*named.body;
    let stencils = body.stencils(mesh)?;
    let active = ActiveNodes::of(&NodeSpace::of(body.node_kind(mesh), mesh)?, std::slice::from_ref(&stencils));
    let connectivity = Connectivity::of(stencils, &active);
    let dilatation = body.dilatation(&connectivity, mesh, &active)?;
    let linked = BodyConnectivity { connectivity, dilatation };
    let bodies = [BodyAtStart { name: &named.name, body, connectivity: &linked.connectivity }];
    let (from, to) = (LoadFraction::START, LoadFraction::END);
    let step =
        StepStart { mesh, active: &active, bodies: &bodies, from, to, is_retry: false, sharing: &Unshared };
    let mut unknowns = Unknowns::of_nodes(active.len());
    for named in &mut *contributions {
        named.contribution.begin(&step, &mut unknowns)?;
    }
    let mut couplings: Vec<&dyn Couplings> = vec![&linked];
    couplings.extend(contributions.iter().map(|named| named.contribution.couplings()));
    let pattern = SparsityPattern::reusing(None, &unknowns, body.symmetry(), &couplings);
    for named in contributions {
        named.contribution.locate(&pattern);
    }
    let plan = AssemblyPlan::new(linked, &pattern);
    Ok((active, pattern, plan))
}
