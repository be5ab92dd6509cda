//! What the examples share: a square of 2 × 2 cells with 2 × 2 points each, made without a scene.

use mpm_assembly::{Contribution, MaterialBody};
use mpm_basis::{Basis, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, Mesh, MeshMotion, NodeId, NodeSpace, Region, Vector};
use mpm_material::{Elasticity, Hencky, Material};
use mpm_solver::observe::{LoadStep, Observer, ObserverError};
use mpm_solver::{Active, Model, PredictorKind, Prescribed, Stage, Support, Tolerance};
use std::error::Error;

/// The square [0, 1]² `[L]`.
pub fn layout() -> Result<Layout<2>, Box<dyn Error>> {
    let axis = Axis::uniform(0.0, 1.0, 2)?;
    Ok(Layout::on_axes([axis.clone(), axis])?)
}

/// The square filled with points of any basis and law, between supports, under a motion of its mesh.
pub fn model<B: Basis<2> + 'static, M: Material + 'static>(
    (basis, law): (B, M),
    motion: MeshMotion<2>,
    supports: Vec<Support<2>>,
    steps: u32,
) -> Result<Model<2>, Box<dyn Error>> {
    let layout = layout()?;
    let mesh = Mesh::at_rest(&layout);
    basis.suits(&mesh)?;
    let points = seed_cells(&basis, &mesh, mesh.cells(), 2);
    let nodes = NodeSpace::of(basis.node_kind(&mesh), &mesh)?;
    let mut model = Model::on(layout, nodes);
    model.add_body("square", Box::new(MaterialBody::new(basis, law, points)));
    (model.motion, model.supports) = (motion, supports);
    model.stages = vec![Stage { cuts: 0, predictor: PredictorKind::Rest, ..Stage::equal(steps) }];
    model.tolerance = Tolerance { residual: 1e-10, iterations: 10, ..Tolerance::default() };
    Ok(model)
}

/// A support of one side (or any region) of the square.
pub fn support(
    name: &str,
    region: Region<2>,
    components: [Option<Prescribed>; 2],
) -> Result<Support<2>, Box<dyn Error>> {
    Ok(Support {
        name: name.into(),
        nodes: region.nodes(&NodeSpace::vertices(layout()?.lattice()), &layout()?),
        components,
        moment_about: None,
        active: Active::default(),
    })
}

/// The square of an elastic bar (Young's modulus 1000) that is held at its right side and cannot widen; `contribution`
/// gets the nodes of its left side.
pub fn held_bar<C: Contribution<2> + 'static>(
    contribution: impl FnOnce(Vec<NodeId>) -> C,
    steps: u32,
) -> Result<Model<2>, Box<dyn Error>> {
    let all = Region::Box { from: Vector::zeros(), to: Vector::repeat(1.0) };
    let supports = vec![
        support("right", Region::Plane { axis: 0, at: 1.0 }, [Some(Prescribed::Held), None])?,
        support("flat", all, [None, Some(Prescribed::Held)])?,
    ];
    let law = Hencky(Elasticity::from_young_poisson(1000.0, 0.0)?);
    let mut model = model((Smpm, law), MeshMotion::Fixed, supports, steps)?;
    let left = Region::Plane { axis: 0, at: 0.0 };
    let left = left.nodes(&model.nodes, &model.layout);
    model.add_contribution("springs", Box::new(contribution(left)));
    Ok(model)
}

/// Keeps the relative out-of-balance force of every Newton iterate, step by step.
#[derive(Debug, Default)]
pub struct Residuals(
    /// One list per load step.
    pub Vec<Vec<f64>>,
);

impl Observer for Residuals {
    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.0.push(step.residuals.to_vec());
        Ok(())
    }
}
