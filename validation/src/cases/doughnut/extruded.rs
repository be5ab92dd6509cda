//! The doughnut in three dimensions.

use super::super::{largest, relative, sweep};
use super::torque;
use crate::scenes::{load, run};
use crate::variants::{CPDI1, CPDI2Q, Method, SMPM, plane};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_scene::language::{
    AxisInput, Count, MaterialInput, MeshInput, PlaneBasis, Positive, ReindexingInput, Scene, SceneIn,
    SolidBasis,
};
use mpm_scene::language::{Finite, MotionInput};

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist in space",
    goal: "A ring between smooth plates is a ring in plane strain: torques per height agree on equal meshes.",
    setup: "The elastic doughnut (5 × 32 cells, 2² points, 20° in 20 load steps, whole cells taken off) and the yielding one of the slides (to 40°, over first yield), 1.5 high with one and with two cells across, rollers below and above.",
    reference: "The same scenes in plane strain, every load step.",
    run: extruded,
};

const HEIGHT: f64 = 1.5;

struct Job {
    plane: Method,
    solid: SolidBasis,
    layers: u32,
    yields: bool,
}

fn jobs(extent: Extent) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (plane, solid) in [(SMPM, SolidBasis::Smpm), (CPDI1, SolidBasis::Cpdi1)] {
        for (layers, yields) in [(1, false), (2, false), (1, true)] {
            if extent == Extent::Full || (layers, yields) == (1, false) {
                jobs.push(Job { plane: plane.clone(), solid, layers, yields });
            }
        }
    }
    if extent == Extent::Full {
        jobs.push(Job { plane: CPDI2Q, solid: SolidBasis::Cpdi2Hexahedron, layers: 1, yields: false });
    }
    jobs
}

impl Job {
    /// What both scenes share: the law and how far they are twisted.
    fn shared<const D: usize, B>(&self, mut scene: SceneIn<D, B>) -> SceneIn<D, B> {
        let degrees = if self.yields { 40 } else { 20 };
        for material in scene.materials.values_mut() {
            let (young, poisson, density) = (Positive(1e6).into(), mpm_scene::language::Poisson(0.0), None);
            *material = if self.yields {
                MaterialInput::VonMises {
                    young,
                    poisson,
                    yield_radius: Some(Positive(1e6).into()),
                    undrained_strength: None,
                    softening: None,
                    gradient: None,
                    density,
                }
            } else {
                MaterialInput::Hencky { young, poisson, gradient: None, density }
            };
        }
        if let MotionInput::Twist { inner, reindexing, .. } = &mut scene.motion {
            *inner = Finite(f64::from(degrees));
            *reindexing = ReindexingInput::WholeCells;
        }
        scene.schedule.steps = Some(Count(degrees));
        scene.output.fields.clear();
        scene
    }

    /// Torques per height in space, and those in the plane.
    fn torques(&self) -> Result<[Vec<f64>; 2], Broken> {
        let Scene::Solid(mut solid) = load("tube_twist")? else {
            return Err("expected a scene in three dimensions".into());
        };
        solid.basis = self.solid;
        if let MeshInput::Ring { height: Some(AxisInput::Uniform { cells, .. }), .. } = &mut solid.mesh {
            *cells = Count(self.layers);
        }
        let in_space = run(&Scene::Solid(self.shared(solid)))?.completed()?;
        let flat: SceneIn<2, PlaneBasis> = self.plane.of(plane(load("doughnut")?)?);
        let in_plane = run(&Scene::PlaneStrain(self.shared(flat)))?.completed()?;
        Ok([torque(&in_space).iter().map(|torque| torque / HEIGHT).collect(), torque(&in_plane)])
    }
}

fn extruded(extent: Extent) -> Result<Findings, Broken> {
    let jobs = jobs(extent);
    let torques = sweep(&jobs, Job::torques)?;
    let check = |(job, [space, plane]): (&Job, &[Vec<f64>; 2])| {
        let basis = job.plane.name;
        let law = if job.yields { "yielding" } else { "elastic" };
        let cells = if job.layers == 1 { "one cell" } else { "two cells" };
        let what = format!("{basis}, {law}, {cells} high: torque per height against plane strain (every step)");
        let peak = largest(plane.iter().copied());
        Check::new(what, relative(space, plane), 1e-8).remark(format!("up to {peak:.4e}"))
    };
    Ok(jobs.iter().zip(&torques).map(check).collect::<Vec<_>>().into())
}
