//! Coulomb friction: blocks that slide.

use super::of_tool;
use crate::cases::largest;
use crate::scenes::{load_own, run, run_compiled};
use crate::variants::{PlaneScene, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_geometry::Surface;
use mpm_scene::language::{Coordinates, Finite, LoadInput, Scene, ShapeInput, ToolPartInput};
use mpm_scene::{NamedColumns, PointTable, SceneFiles, compile_with};

pub(in crate::cases) const CASE: Case = Case {
    name: "sliding blocks",
    goal: "A block slides where friction can hold it no longer, and then with the whole of it.",
    setup: "A heavy elastic block of 1 × 0.45 across cells of 0.1 (CPDI1, 2² points a cell, ghost stabilisation). A plane is drawn away under it (μ = 0.3, 0.5, 1), with the exact tangent and without its term of friction; and a load along a plane grows until the block slides off (μ = 0.2, 0.5; block and plane at 0°, 17° and 31° to the mesh, and at four heights in their cells).",
    reference: "Force along the plane over that across it: μ; across it: the weight. The load step in which the block slides off: μ times the weight, within one smallest step.",
    run: friction,
};

/// Weight of the block.
const WEIGHT: f64 = 2000.0 * 10.0 * 0.45;

fn friction(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let heads = ["μ", "linear solutions a step, exact tangent", "without the term"];
    let mut table = Table::new("Linear solutions in the last load step, in which all corners slip:", &heads);
    for coefficient in [0.3, 0.5, 1.0] {
        let mut solutions = Vec::new();
        for exact in [true, false] {
            let mut scene = plane(load_own("contact/drag")?)?;
            scene.tools[0].interface.friction = Finite(coefficient);
            scene.tools[0].interface.exact_friction = exact;
            let history = run(&Scene::PlaneStrain(scene))?.completed()?;
            let last = |column: &str, component| {
                *of_tool(&history, "plane", column, component).last().unwrap_or(&f64::NAN)
            };
            let (along, across) = (last("force", 0), last("force", 1));
            let name = format!("drawn, μ = {coefficient}, {}", if exact { "exact" } else { "lagged" });
            findings.checks.push(Check::new(
                format!("{name}: force along over force across, against μ"),
                ((along / across).abs() / coefficient - 1.0).abs(),
                1e-10,
            ));
            findings.checks.push(Check::new(
                format!("{name}: force across, against the weight"),
                (across.abs() / WEIGHT - 1.0).abs(),
                1e-10,
            ));
            solutions.push(history.series("newton_iterations", 0).last().copied().unwrap_or(f64::NAN));
        }
        table.push([coefficient.to_string(), solutions[0].to_string(), solutions[1].to_string()]);
    }
    findings.tables.push(table);
    slide_off(extent, &mut findings)?;
    Ok(findings)
}

/// The load at which a block slides off, on planes at several angles to the mesh.
fn slide_off(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let mut table = Table::new(
        "Load fraction that the block reaches, over that at which friction is spent:",
        &["μ", "angle of the plane", "height in the cells", "of the limit", "halvings"],
    );
    for coefficient in [0.2, 0.5] {
        let mut errors = Vec::new();
        let jobs = [(0.0, 0.03), (17.0, 0.03), (31.0, 0.03), (0.0, 0.0), (0.0, 0.055), (0.0, 0.08)];
        for (angle, height) in extent.pick(&jobs[..3], &jobs[..]) {
            let (scene, block) = tilted(coefficient, *angle, *height)?;
            let steps = f64::from(scene.schedule.steps.map_or(1, |steps| steps.0));
            let smallest = 1.0 / steps / f64::from(1_u32 << scene.schedule.cuts);
            let scene = Scene::PlaneStrain(scene);
            let outcome = run_compiled(&mut compile_with(&scene, &block)?, &scene);
            let (reached, expected) = (outcome.history.last().fraction, 0.25 + 0.75 * coefficient);
            let slid = outcome.failure().is_some();
            errors.push(if slid { (reached - expected).abs() / smallest } else { f64::NAN });
            table.push([
                coefficient.to_string(),
                format!("{angle}°"),
                height.to_string(),
                format!("{:.6}", reached / expected),
                outcome.history.series("cuts", 0).iter().sum::<f64>().to_string(),
            ]);
        }
        let what =
            format!("slid off, μ = {coefficient}: load fraction against μ times the weight [smallest steps]");
        findings.checks.push(Check::new(what, largest(errors), 1.0 + 1e-6));
    }
    findings.tables.push(table);
    Ok(())
}

/// Block, plane and loads turned by an angle `[degrees]` about the block's lower left corner, `height` above a line of nodes.
fn tilted(coefficient: f64, angle: f64, height: f64) -> Result<(PlaneScene, TiltedBlock), Broken> {
    let mut scene = plane(load_own("contact/incline")?)?;
    scene.tools[0].interface.friction = Finite(coefficient);
    let (sin, cos) = angle.to_radians().sin_cos();
    let block = TiltedBlock { corner: [0.0, 0.1 + height], along: [cos, sin] };
    scene.bodies[0].points_per_cell = None;
    scene.bodies[0].shape = ShapeInput::Points { file: "block".into() };
    if let ToolPartInput::Plane { through, normal } = &mut scene.tools[0].parts[0] {
        (through.0, normal.0) = (block.corner, [-sin, cos]);
    }
    for load in &mut scene.loads {
        if let LoadInput::BodyForce { acceleration: Coordinates([x, y]), .. } = load {
            (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
        }
    }
    Ok((scene, block))
}

/// Points of a block of 1 × 0.45 whose lower side runs along a unit vector from a corner, each of a square of 0.05.
struct TiltedBlock {
    corner: [f64; 2],
    along: [f64; 2],
}

impl SceneFiles for TiltedBlock {
    fn points(&self, file: &str, _: usize) -> Result<PointTable, String> {
        const WIDTH: f64 = 0.05;
        let [cos, sin] = self.along;
        let mut table = PointTable { file: file.into(), row_kind: "row", ..PointTable::default() };
        for k in 0..180_u32 {
            let (x, y) = (WIDTH * (f64::from(k % 20) + 0.5), WIDTH * (f64::from(k / 20) + 0.5));
            table.row.push(u64::from(k));
            table.position.extend([self.corner[0] + cos * x - sin * y, self.corner[1] + sin * x + cos * y]);
            table.volume.push(WIDTH * WIDTH);
            table.domain.extend([cos, sin, -sin, cos].map(|part| 0.5 * WIDTH * part));
        }
        Ok(table)
    }

    fn surface(&self, file: &str) -> Result<Surface, String> {
        Err(format!("{file} is no surface"))
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        Err(format!("{file} is no table"))
    }
}
