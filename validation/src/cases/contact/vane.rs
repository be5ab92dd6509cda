//! A vane in clay, in space.

use super::{nodes, of_tool, scene, written};
use crate::cases::fixed;
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "vane in space",
    goal: "A vane carries the clay between its blades along and turns with it, as a cylinder does, in the clay around it.",
    setup: "A quarter of the lower half of a smooth vane, D = 1, H = 2, which never parts from the clay (von Mises, E = 1000 s_u, ν = 0.49), is turned by 0.5° in 10 load steps. Its four blades are wedges of 20° on a hub of D/4, so that their sides lie on rays of the ring mesh: 9 n sectors of 10°/n, radial cells of D/16n from the hub to the blades' ends, layers that grow from that height at their lower end by a quarter each at most; n = 1, in the full run also 2 and 3. CPDI1, 2³ points a cell, mean dilatation.",
    reference: "½πD²s_u(H + D/3), the torque on the cylinder around the vane: an upper bound, to which the torque comes down with the cells. Extrapolated by the line closest to all meshes: any two of them lead to 0.93 to 1.00, and how far below its bound the torque of such a vane lies is not known.",
    run: vane,
};

/// Radius of the vane and of its hub, half its height.
const RADIUS: f64 = 0.5;
const HUB: f64 = 0.25;
const HALF: f64 = 1.0;

/// A ring mesh with n cells for each of the coarsest.
fn mesh(n: u32) -> String {
    let cell = (RADIUS - HUB) / f64::from(4 * n);
    let radii = [HUB - cell].into_iter().chain(nodes(4 * n, RADIUS - HUB, 0.8).into_iter().map(|r| HUB + r));
    // Distances from the vane's lower end.
    let from_end = |far: f64| nodes(1, cell, far + cell).into_iter().skip(1).map(move |z| z - cell);
    let below: Vec<f64> = from_end(0.55).skip(1).map(|z| -HALF - z).collect();
    let height = below.into_iter().rev().chain(from_end(HALF).map(|z| z - HALF));
    let (radii, height) = (written(radii), written(height));
    format!("Ring(radii: {radii}, sectors: {}, angles: (0, 90), height: {height})", 9 * n)
}

fn vane(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let limit = 0.5 * PI * (2.0 * HALF + 1.0 / 3.0) / 8.0;
    let mut table =
        Table::new("Torque over ½πD²s_u(H + D/3):", &["cells over the radius", "at 0.25°", "at 0.5°"]);
    let mut found = Vec::new();
    for n in extent.pick(&[1][..], &[1, 2, 3]) {
        let changes = [("mesh", mesh(*n)), ("tools[0].parts[0].file", "\"surfaces/vane.stl\"".into())];
        let history = run(&scene("vane_solid", &changes)?)?.completed()?;
        let torque: Vec<f64> = of_tool(&history, "vane", "moment", 2).iter().map(|it| -it / limit).collect();
        let cells = 8 * n;
        let at = |step: usize| torque.get(step).copied().unwrap_or(f64::NAN);
        let (middle, last) = (at(5), at(10));
        table.push([cells.to_string(), fixed(middle, 3), fixed(last, 3)]);
        let what = format!("{cells} cells over the radius: torque at 0.5° against the cylinder's, relative");
        findings.checks.push(Check::new(what, (last - 1.0).abs(), 0.4 / f64::from(*n)).remark(fixed(last, 3)));
        found.push((1.0 / f64::from(*n), last));
    }
    if found.len() > 1 {
        let torque = at_no_width(&found);
        table.push(["extrapolated".into(), String::new(), fixed(torque, 2)]);
        let what = "torque at 0.5° extrapolated to no width of cells, relative";
        findings.checks.push(Check::new(what, (torque - 1.0).abs(), 5e-2).remark(fixed(torque, 2)));
    }
    findings.tables.push(table);
    Ok(findings)
}

/// Where the straight line that is closest to values over widths of cells meets the width 0.
fn at_no_width(found: &[(f64, f64)]) -> f64 {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
    let (width, value) = (mean(&|it| it.0), mean(&|it| it.1));
    let slope = mean(&|it| (it.0 - width) * (it.1 - value)) / mean(&|it| (it.0 - width) * (it.0 - width));
    value - slope * width
}
