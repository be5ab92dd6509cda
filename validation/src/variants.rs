//! Variants of a scene: the same problem with another basis, mesh or number of points.

use crate::Broken;
use mpm_scene::language::{
    AxisInput, ControlInput, CornerWeightsInput, Count, DomainsInput, FunctionsInput, MeshInput, PlaneBasis,
    Positive, Scene, SceneIn, TrianglesInput,
};

/// A scene in plane strain.
pub type PlaneScene = SceneIn<2, PlaneBasis>;

/// A basis of the plane with its options.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Its name in tables.
    pub name: &'static str,
    /// The basis.
    pub basis: PlaneBasis,
    /// How its triangles lie, if it has any.
    pub triangles: Option<TrianglesInput>,
    /// Degree of the mesh's functions: 1 are linear ones, 2 and 3 splines.
    pub degree: u32,
}

const fn method(name: &'static str, basis: PlaneBasis, triangles: Option<TrianglesInput>) -> Method {
    Method { name, basis, triangles, degree: 1 }
}

const fn on_splines(name: &'static str, basis: PlaneBasis, degree: u32) -> Method {
    Method { name, basis, triangles: None, degree }
}

/// Standard MPM.
pub const SMPM: Method = method("sMPM", PlaneBasis::Smpm, None);
/// Generalised interpolation.
pub const GIMP: Method = method("GIMP", PlaneBasis::Gimp, None);
/// Parallelograms.
pub const CPDI1: Method = method("CPDI1", PlaneBasis::Cpdi1, None);
/// Quadrilaterals.
pub const CPDI2Q: Method = method("CPDI2q", PlaneBasis::Cpdi2q, None);
/// Triangles, cut from lower left to upper right.
pub const SLASH: Method = method("CPDI2t slash", PlaneBasis::Cpdi2t, Some(TrianglesInput::Slash));
/// Triangles, cut from upper left to lower right.
pub const BACKSLASH: Method = method("CPDI2t backslash", PlaneBasis::Cpdi2t, Some(TrianglesInput::Backslash));
/// Triangles, cut both ways.
pub const CROSS: Method = method("CPDI2t cross", PlaneBasis::Cpdi2t, Some(TrianglesInput::Cross));

/// All but GIMP, which needs rectilinear meshes.
pub const GENERAL: [Method; 6] = [SMPM, CPDI1, CPDI2Q, SLASH, BACKSLASH, CROSS];

/// Parallelograms on splines of degree 2.
pub const CPDI1_ON_SPLINES: Method = on_splines("CPDI1, splines", PlaneBasis::Cpdi1, 2);
/// Quadrilaterals on splines of degree 2.
pub const CPDI2Q_ON_SPLINES: Method = on_splines("CPDI2q, splines", PlaneBasis::Cpdi2q, 2);
/// Parallelograms on splines of degree 3.
pub const CPDI1_ON_CUBIC_SPLINES: Method = on_splines("CPDI1, cubic splines", PlaneBasis::Cpdi1, 3);
/// Quadrilaterals on splines of degree 3.
pub const CPDI2Q_ON_CUBIC_SPLINES: Method = on_splines("CPDI2q, cubic splines", PlaneBasis::Cpdi2q, 3);

/// All of the plane, on linear functions.
pub const ALL: [Method; 7] = [SMPM, GIMP, CPDI1, CPDI2Q, SLASH, BACKSLASH, CROSS];

impl Method {
    /// The scene with this basis.
    pub fn of(&self, mut scene: PlaneScene) -> PlaneScene {
        scene.basis = self.basis;
        scene.domains = DomainsInput { triangles: self.triangles, ..DomainsInput::default() };
        if self.degree > 1 {
            let (MeshInput::Box { functions, .. } | MeshInput::Ring { functions, .. }) = &mut scene.mesh;
            *functions = FunctionsInput::Splines { degree: Count(self.degree) };
        }
        scene
    }
}

/// A scene that must be in plane strain.
///
/// # Errors
/// It is not.
pub fn plane(scene: Scene) -> Result<PlaneScene, Broken> {
    match scene {
        Scene::PlaneStrain(scene) => Ok(scene),
        Scene::Axisymmetric(_) | Scene::Solid(_) => Err("expected a scene in plane strain".into()),
    }
}

/// The scene with n × n points a cell in every body.
pub fn with_points(mut scene: PlaneScene, points_per_cell: u32) -> PlaneScene {
    for body in &mut scene.bodies {
        body.points_per_cell = Some(Count(points_per_cell));
    }
    scene
}

/// The scene in another number of load steps.
pub fn in_steps(mut scene: PlaneScene, steps: u32) -> PlaneScene {
    scene.schedule.steps = Some(Count(steps));
    scene
}

/// The scene with `factor` times as many cells along every (uniform) axis, and around.
pub fn refined(mut scene: PlaneScene, factor: u32) -> PlaneScene {
    let refine = |axis: &mut AxisInput| {
        if let AxisInput::Uniform { cells, .. } | AxisInput::Graded { cells, .. } = axis {
            cells.0 *= factor;
        }
    };
    match &mut scene.mesh {
        MeshInput::Box { axes, .. } => axes.iter_mut().for_each(refine),
        MeshInput::Ring { radii, sectors, .. } => {
            refine(radii);
            sectors.0 *= factor;
        }
    }
    scene
}

/// The scene with points that fall back to parallelograms.
pub fn falling_back(mut scene: PlaneScene, beyond: f64) -> PlaneScene {
    scene.domains.fallback_beyond = Some(Positive(beyond));
    scene
}

/// The scene with something done about domains that have outgrown their cells.
pub fn with_control(mut scene: PlaneScene, control: ControlInput) -> PlaneScene {
    scene.domains.control = Some(control);
    scene
}

/// The scene with the corner weights of the domains at rest.
pub fn frozen(mut scene: PlaneScene) -> PlaneScene {
    scene.domains.corner_weights = Some(CornerWeightsInput::Frozen);
    scene
}
