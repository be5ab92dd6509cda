//! Planes of symmetry: where bodies are cut by the ends of the mesh, and what must hold there.

use super::mesh::component;
use super::shapes::WithSurface;
use crate::error::SceneError;
use crate::language::BodyInput;
use mpm_assembly::Space;
use mpm_basis::ActiveNodes;
use mpm_grid::{Layout, Mesh};
use mpm_solver::{Model, StepFailure, Support};

/// Low and high side in every direction.
pub(super) type Sides<const D: usize> = [[bool; 2]; D];

/// The sides on which the mesh ends within a body.
pub(super) fn cut_sides<const D: usize>(
    input: &BodyInput<D>,
    shape: &WithSurface<'_, D>,
    (layout, space): (&Layout<D>, Space),
    path: &str,
) -> Result<Sides<D>, SceneError> {
    let sides = shape.cut(layout).map_err(|it| SceneError::new(format!("{path}.shape"), it))?;
    for (k, direction) in input.symmetry.iter().enumerate() {
        let path = format!("{path}.symmetry[{k}]");
        let d = component::<D>(*direction, &path)?;
        // Whether the shape can be cut at all is told where it is filled.
        if matches!(layout, Layout::Box { .. }) && shape.is_solid() && sides[d] == [false; 2] {
            let along = space.directions()[d];
            let reason = format!("the body ends within the mesh along {along}: no end of the mesh cuts it");
            return Err(SceneError::new(path, reason));
        }
    }
    Ok(sides)
}

/// Refuses nodes that carry a body, lie where it is cut, and may leave the plane: half a body would move as if it were
/// whole.
pub(super) fn check_planes<const D: usize>(
    cuts: &[Sides<D>],
    model: &Model<D>,
    mesh: &Mesh<D>,
) -> Result<(), SceneError> {
    for (b, (sides, named)) in cuts.iter().zip(&model.bodies).enumerate() {
        if sides.iter().flatten().all(|&cut| !cut) {
            continue;
        }
        let nodes = named.body.nodes(mesh).map_err(|it| {
            let (body, basis, reason) = (named.name.clone(), named.body.basis(), it.to_string());
            SceneError::new("bodies", StepFailure::Outside { body, basis, reason })
        })?;
        let active = ActiveNodes::of(&model.nodes, &[nodes]);
        let last = model.nodes.lattice().nodes().map(|n| n - 1);
        for &node in active.nodes() {
            let index = model.nodes.lattice().node_index(node);
            let on_plane = |d: usize| sides[d][0] && index[d] == 0 || sides[d][1] && index[d] == last[d];
            for d in (0..D).filter(|&d| on_plane(d)) {
                let holds = |stage: u32, support: &Support<D>| {
                    support.acts_in(stage)
                        && support.components[d].is_some()
                        && support.nodes.binary_search(&node).is_ok()
                };
                let is_axis = d == 0 && model.space().is_axisymmetric();
                if is_axis && model.nodes.position(mesh, node)[0] <= mesh.axis_width() {
                    // The axis is held, whatever the scene says.
                    continue;
                }
                let mut stages = (0..).zip(&model.stages).map(|(stage, _)| stage);
                if stages.any(|stage| !model.supports.iter().any(|it| holds(stage, it))) {
                    let axis = model.space().directions()[d];
                    let at = model.nodes.position(mesh, node);
                    let reason = format!(
                        "no support fixes {axis} of the node at {:?}, where the symmetry plane cuts the body",
                        at.as_slice()
                    );
                    return Err(SceneError::new(format!("bodies[{b}].symmetry"), reason));
                }
            }
        }
    }
    Ok(())
}
