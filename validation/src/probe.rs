//! The forces and the tangent of one body under any nodal displacement, without a solver.

use crate::Broken;
use crate::scenes::compiled;
use mpm_assembly::{
    Body, Connection, Constraints, Converged, GhostFaces, Linked, PassInput, Pattern, PointView, Sums,
    TangentSums,
};
use mpm_basis::{ActiveNodes, Links};
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_scene::Compiled;
use mpm_scene::Scene;
use mpm_solver::Model;

/// The first body of a model on the mesh at rest, ready to be displaced.
pub struct Probe<const D: usize> {
    body: Box<dyn Body<D>>,
    mesh: Mesh<D>,
    active: ActiveNodes<D>,
    pattern: Pattern<D>,
    connection: Connection<D>,
    ghost: Option<Ghost<D>>,
    /// The penalty that the model asks for.
    ghost_factor: Option<f64>,
}

/// Penalised faces, and where their stiffness goes.
struct Ghost<const D: usize> {
    faces: GhostFaces<D>,
    slots: Vec<u32>,
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
        let body = model.bodies.into_iter().next().expect("a scene has a body").body;
        let ghost_factor = model.ghost;
        let (active, pattern, connection, ghost) = connect(&*body, &mesh, ghost_factor)?;
        Ok(Self { body, mesh, active, pattern, connection, ghost, ghost_factor })
    }

    /// Number of active nodes.
    pub fn n_nodes(&self) -> usize {
        self.active.len()
    }

    /// A nodal field from a function of position.
    pub fn field(&self, of: impl Fn(Vector<D>) -> Vector<D>) -> Vec<Vector<D>> {
        self.active.nodes().iter().map(|&node| of(self.mesh.position(node))).collect()
    }

    /// Every material point.
    pub fn points(&self) -> Vec<PointView<D>> {
        mpm_assembly::views(&*self.body).collect()
    }

    /// `f_int` under an increment of displacement `[F]`.
    ///
    /// # Errors
    /// The increment inverts a point.
    pub fn internal(&self, increment: &[Vector<D>]) -> Result<Vec<Vector<D>>, Broken> {
        let constraints = Constraints::none(self.active.len());
        let mut internal = vec![Vector::zeros(); self.active.len()];
        let input = PassInput { pattern: &self.pattern, constraints: &constraints, increment };
        self.body.assemble(&self.connection, input, Sums { internal: &mut internal, tangent: None })?;
        if let Some(Ghost { faces, slots }) = &self.ghost {
            faces.assemble(slots, input, Sums { internal: &mut internal, tangent: None });
        }
        Ok(internal)
    }

    /// `K v` with the assembled tangent of an increment of displacement `[F]`.
    ///
    /// # Errors
    /// The increment inverts a point.
    pub fn tangent_times(&self, increment: &[Vector<D>], v: &[Vector<D>]) -> Result<Vec<Vector<D>>, Broken> {
        let constraints = Constraints::none(self.active.len());
        let mut internal = vec![Vector::zeros(); self.active.len()];
        let mut values = vec![0.0; self.pattern.n_entries()];
        let input = PassInput { pattern: &self.pattern, constraints: &constraints, increment };
        let tangent = Some(TangentSums { values: &mut values, lift: None });
        self.body.assemble(&self.connection, input, Sums { internal: &mut internal, tangent })?;
        if let Some(Ghost { faces, slots }) = &self.ghost {
            let tangent = Some(TangentSums { values: &mut values, lift: None });
            faces.assemble(slots, input, Sums { internal: &mut internal, tangent });
        }

        // The pattern holds the lower triangle by columns.
        let mut product = vec![Vector::zeros(); self.active.len()];
        let (starts, rows) = (self.pattern.column_start(), self.pattern.row());
        for column in 0..self.pattern.n_equations() {
            for entry in starts[column]..starts[column + 1] {
                let row = rows[entry];
                product[row / D][row % D] += values[entry] * v[column / D][column % D];
                if row != column {
                    product[column / D][column % D] += values[entry] * v[row / D][row % D];
                }
            }
        }
        Ok(product)
    }

    /// Carries the points through an increment of displacement, and connects them to the mesh again.
    ///
    /// # Errors
    /// A point is inverted or leaves the mesh.
    pub fn advance(&mut self, increment: &[Vector<D>]) -> Result<(), Broken> {
        let step = Converged { mesh: &self.mesh, active: &self.active, increment };
        self.body.prepare(&self.connection, step)?;
        self.body.commit();
        (self.active, self.pattern, self.connection, self.ghost) =
            connect(&*self.body, &self.mesh, self.ghost_factor)?;
        Ok(())
    }
}

type Connected<const D: usize> = (ActiveNodes<D>, Pattern<D>, Connection<D>, Option<Ghost<D>>);

fn connect<const D: usize>(
    body: &dyn Body<D>,
    mesh: &Mesh<D>,
    ghost_factor: Option<f64>,
) -> Result<Connected<D>, Broken> {
    let stencils = body.stencils(mesh)?;
    let active = ActiveNodes::of(mesh.lattice(), std::slice::from_ref(&stencils));
    let links = Links::of(stencils, &active);
    let faces = ghost_factor.map(|factor| {
        let mut cells = Vec::new();
        body.occupied_cells(&links, mesh.lattice(), &active, &mut cells);
        GhostFaces::of(mesh, &active, cells, factor)
    });
    let dilatation = body.dilatation(&links, mesh, &active)?;
    let linked = Linked { links, dilatation };
    let pattern = Pattern::reusing(None, active.len(), std::slice::from_ref(&linked), faces.as_ref());
    let connection = Connection::new(linked, &pattern);
    let ghost = faces.map(|faces| Ghost { slots: faces.slots(&pattern), faces });
    Ok((active, pattern, connection, ghost))
}
