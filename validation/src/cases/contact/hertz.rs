//! A cylinder on an elastic block.

use super::of_tool;
use crate::cases::{fixed, largest};
use crate::reference::Reference;
use crate::scenes::{load_own, run};
use crate::variants::{plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::Scene;

pub(in crate::cases) const CASE: Case = Case {
    name: "cylinder on a block",
    goal: "Force of a contact that grows as it is pressed (Hertz).",
    setup: "Half of a rigid, smooth cylinder, R = 20, pressed by 0.02 into an elastic block of half width 4 and depth 4 between smooth rigid sides, E = 10⁶, ν = 0.3; cells of 0.1, in the full run of 0.05, 2² points a cell, CPDI1.",
    reference: "Contact of a cylinder with a layer of these bounds by a cosine series and complementarity, small strains.",
    run: hertz,
};

fn hertz(extent: Extent) -> Result<Findings, Broken> {
    let reference = Reference::read("contact/hertz")?;
    let force = reference.column("force")?;
    let mut findings = Findings::default();
    let heads = ["cell", "least error of the force", "largest"];
    let mut table = Table::new("Force against the reference, over all load steps:", &heads);
    for (factor, tolerance) in extent.pick(&[(1, 0.02)][..], &[(1, 0.02), (2, 0.015)]) {
        let scene = refined(plane(load_own("contact/hertz")?)?, *factor);
        let history = run(&Scene::PlaneStrain(scene))?.completed()?;
        let cell = 0.1 / f64::from(*factor);
        let found = of_tool(&history, "cylinder", "force", 1);
        if found.len() != force.len() + 1 {
            return Err(format!("{} load steps, expected {}", found.len() - 1, force.len()).into());
        }
        let errors: Vec<f64> =
            found[1..].iter().zip(&force).map(|(half, whole)| 2.0 * half / whole - 1.0).collect();
        findings.checks.push(Check::new(
            format!("cells of {cell}: force, relative"),
            largest(errors.iter().map(|error| error.abs())),
            *tolerance,
        ));
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let percent = |error: f64| format!("{} %", fixed(100.0 * error, 2));
        let most = errors.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        table.push([cell.to_string(), percent(least), percent(most)]);
    }
    findings.tables.push(table);
    Ok(findings)
}
