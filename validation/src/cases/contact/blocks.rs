//! Blocks that rigid plates press: uniform states with closed forms.

use super::{of_tool, on, scene};
use crate::cases::{largest, scientific};
use crate::history::History;
use crate::reference::Reference;
use crate::scenes::{load_own, run};
use crate::variants::{CPDI1, GIMP, Method, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::Scene;

pub(in crate::cases) const CASE: Case = Case {
    name: "blocks under rigid plates",
    goal: "A plate that moves through cells presses a block to a uniform state, exactly.",
    setup: "A block of 0.5 × 1 between smooth walls, Hencky, E = 10⁶, ν = 0.25, pressed by 30 % in 10 load steps by a smooth plate, whose rim crosses three rows of cells; and a block of 1 × 0.5 of von Mises soil, s_u = 10⁴, pushed by 20 % in 20 load steps by a smooth wall whose contact is augmented. Cells of 0.1, 2² points a cell, GIMP and CPDI1; the first block as a slice in space, too, in the full run also augmented and on cells of 1/20 and 1/30.",
    reference: "Compression of one point in series with the springs of 20 corners; without penetration, where it is augmented. One point of soil that is driven along the same load steps, which ends at 2 s_u H/l.",
    run: blocks,
};

/// Largest error of a column from row 1 on, relative to each value.
fn error(found: &[f64], expected: &[f64]) -> f64 {
    if found.len() != expected.len() + 1 {
        return f64::NAN;
    }
    largest(found[1..].iter().zip(expected).map(|(a, b)| (a / b - 1.0).abs()))
}

fn pressed(method: &Method, scene: &str, augment: u8) -> Result<History, Broken> {
    let mut scene = on(method, plane(load_own(scene)?)?);
    scene.tools[0].interface.augment = augment;
    run(&Scene::PlaneStrain(scene))?.completed()
}

/// Force on the plate over the depth of the slice, with so many cells across it.
fn pressed_in_space(cells: u32, augment: u32) -> Result<Vec<f64>, Broken> {
    let axis = |to: f64, cells: u32| format!("Uniform(from: 0, to: {to}, cells: {cells})");
    let axes = [axis(0.5, cells), axis(0.1, cells / 5), axis(1.2, 12 * cells / 5)];
    let changes = [
        ("mesh", format!("Box(axes: [{}])", axes.join(", "))),
        ("tools[0].interface.augment", augment.to_string()),
    ];
    let history = run(&scene("compression_solid", &changes)?)?.completed()?;
    Ok(of_tool(&history, "plate", "force", 2).iter().map(|force| force / 0.1).collect())
}

fn blocks(extent: Extent) -> Result<Findings, Broken> {
    let (compression, passive) =
        (Reference::read("contact/compression")?, Reference::read("contact/passive_block")?);
    let mut findings = Findings::default();
    let heads = ["block", "basis", "augmentations", "largest error", "linear solutions a step", "deepest"];
    let mut table = Table::new(
        "Force on the plate against the closed form over all load steps, linear solutions, and the largest penetration over the width of a point:",
        &heads,
    );
    let jobs = [
        ("compression", "plate", 1, &GIMP, 0, "force_penalty", 1e-11),
        ("compression", "plate", 1, &CPDI1, 0, "force_penalty", 1e-11),
        ("compression", "plate", 1, &CPDI1, 8, "force_rigid", 1e-11),
        ("passive_block", "wall", 0, &CPDI1, 8, "force", 1e-9),
        ("passive_block", "wall", 0, &GIMP, 8, "force", 2e-3),
    ];
    for (block, tool, component, method, augment, column, tolerance) in jobs {
        let history = pressed(method, &format!("contact/{block}"), augment)?;
        let reference = if block == "compression" { &compression } else { &passive };
        let expected = reference.column(column)?;
        let found = of_tool(&history, tool, "force", component);
        let error = error(&found, &expected);
        let what = format!("{block}, {}, {augment} augmentations: force, relative", method.name);
        findings.checks.push(Check::new(what, error, tolerance));
        let solutions: f64 = history.series("newton_iterations", 0).iter().sum();
        table.push([
            block.to_owned(),
            method.name.to_owned(),
            augment.to_string(),
            scientific(error, 2),
            format!("{:.1}", solutions / expected.len() as f64),
            scientific(largest(of_tool(&history, tool, "deepest", 0)), 2),
        ]);
        // What the tool exerts is what the supports carry.
        let supports = history.series("reaction/total", component);
        let balance = found.iter().zip(&supports).map(|(tool, support)| (tool - support).abs());
        let size = largest(found.iter().map(|force| force.abs()));
        let what =
            format!("{block}, {}, {augment} augmentations: force against the supports' reactions", method.name);
        findings.checks.push(Check::new(what, largest(balance) / size, 1e-10));
    }
    findings.tables.push(table);
    for (cells, augment, column) in extent.pick(
        &[(5, 0, "force_penalty")][..],
        &[(5, 0, "force_penalty"), (5, 8, "force_rigid"), (10, 8, "force_rigid"), (15, 8, "force_rigid")],
    ) {
        let error = error(&pressed_in_space(*cells, *augment)?, &compression.column(column)?);
        let what = format!(
            "compression in space, CPDI1, {cells} cells across, {augment} augmentations: force, relative"
        );
        findings.checks.push(Check::new(what, error, 1e-11));
    }
    Ok(findings)
}
