//! Surfaces of tools, for drawing.

use super::axisymmetric::in_plane;
use super::mesh::layout;
use super::tools::{ToolParts, mesh_bounds, smallest_edge, tool};
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::language::{Scene, SceneIn};
use crate::limits::memory_left;
use std::array::from_fn;

/// The surface of a tool at rest: segments in the plane, triangles in space.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolSurface {
    /// The tool's name.
    pub name: String,
    /// The point whose position the history tells `[L]`.
    pub moment_about: [f64; 3],
    /// Positions; in the plane z = 0 `[L]`.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each segment or triangle by number: two or three.
    pub facets: Vec<Vec<u32>>,
}

impl ToolSurface {
    /// Its vertices where the history tells of the tool's `position`, and in space of its `rotation`, in the plane of its
    /// `angle` instead `[L]`.
    pub fn placed(&self, position: &[f64], rotation: &[f64]) -> Vec<[f64; 3]> {
        let matrix = match rotation {
            [angle] => {
                let (sine, cosine) = angle.to_radians().sin_cos();
                [cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0]
            }
            rows => whole(rows),
        };
        let position = whole::<3>(position);
        let place = |x: &[f64; 3]| {
            let arm: [f64; 3] = from_fn(|d| x[d] - self.moment_about[d]);
            from_fn(|i| position[i] + (0..3).map(|j| matrix[3 * i + j] * arm[j]).sum::<f64>())
        };
        self.vertices.iter().map(place).collect()
    }
}

/// The tools of a scene; of one without end as much as lies in the mesh.
///
/// # Errors
/// What is wrong with the mesh, a tool or its file, with its path.
pub fn tool_surfaces(scene: &Scene, files: &dyn SceneFiles) -> Result<Vec<ToolSurface>, SceneError> {
    match scene {
        Scene::PlaneStrain(scene) => surfaces(scene, files),
        Scene::Axisymmetric(scene) => surfaces(&in_plane(scene)?, files),
        Scene::Solid(scene) => surfaces(scene, files),
    }
}

fn surfaces<const D: usize, B: ToolParts<D>>(
    scene: &SceneIn<D, B>,
    files: &dyn SceneFiles,
) -> Result<Vec<ToolSurface>, SceneError> {
    if scene.tools.is_empty() {
        return Ok(Vec::new());
    }
    let layout = layout(&scene.mesh, memory_left())?;
    let (within, spacing) = (mesh_bounds(&layout), smallest_edge(&layout));
    let mut surfaces = Vec::new();
    for (k, input) in scene.tools.iter().enumerate() {
        let outline = tool::<D, B>(input, &format!("tools[{k}]"), &layout, files)?.outline(spacing, &within);
        surfaces.push(ToolSurface {
            name: input.name.clone(),
            moment_about: whole(&input.moment_about.0),
            vertices: outline.vertices.iter().map(|x| whole(x.as_slice())).collect(),
            facets: outline.facets.iter().map(|facet| facet.to_vec()).collect(),
        });
    }
    Ok(surfaces)
}

/// Padded with zeros.
fn whole<const N: usize>(x: &[f64]) -> [f64; N] {
    from_fn(|d| x.get(d).copied().unwrap_or(0.0))
}
