//! Coulomb friction: blocks that slide.

use super::of_tool;
use crate::cases::largest;
use crate::scenes::{load_own, run};
use crate::variants::plane;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Finite, Scene, ShapeInput};

pub(in crate::cases) const CASE: Case = Case {
    name: "sliding blocks",
    goal: "A block slides where friction can hold it no longer, and then with the whole of it.",
    setup: "A heavy elastic block of 1 × 0.45 across cells of 0.1 (CPDI1, 2² points a cell, ghost stabilisation). A plane is drawn away under it (μ = 0.3, 0.5, 1), with the exact tangent and without its term of friction; and a load along a plane grows until the block slides off (μ = 0.2, 0.5; the block at four heights in its cells).",
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
    for coefficient in [0.2, 0.5] {
        let mut errors = Vec::new();
        for offset in extent.pick(&[0.03, 0.0][..], &[0.03, 0.055, 0.08, 0.0]) {
            let mut scene = plane(load_own("contact/incline")?)?;
            scene.tools[0].interface.friction = Finite(coefficient);
            let steps = f64::from(scene.schedule.steps.0);
            let smallest = 1.0 / steps / f64::from(1_u32 << scene.schedule.cuts);
            raise(&mut scene, *offset);
            let outcome = run(&Scene::PlaneStrain(scene))?;
            let reached = outcome.history.last().fraction;
            let expected = 0.25 + 0.75 * coefficient;
            errors.push(if outcome.outcome.is_err() {
                (reached - expected).abs() / smallest
            } else {
                f64::NAN
            });
        }
        let what =
            format!("slid off, μ = {coefficient}: load fraction against μ times the weight [smallest steps]");
        findings.checks.push(Check::new(what, largest(errors), 1.0 + 1e-6));
    }
    Ok(findings)
}

/// Lifts block and plane, so that the block begins `offset` above a line of nodes.
fn raise(scene: &mut crate::variants::PlaneScene, offset: f64) {
    let low = 0.1 + offset;
    if let ShapeInput::Box { from, to, .. } = &mut scene.bodies[0].shape {
        (from.0[1], to.0[1]) = (low, low + 0.45);
    }
    if let mpm_scene::language::ToolPartInput::Plane { through, .. } = &mut scene.tools[0].parts[0] {
        through.0[1] = low;
    }
}
