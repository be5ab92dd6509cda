//! A flat elastic punch.

use super::{lines, list};
use crate::cases::{fixed, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;

pub(in crate::cases) const CASE: Case = Case {
    name: "flat elastic punch",
    goal: "The force on a smooth rigid circular punch on elastic ground converges to the closed form of the half space.",
    setup: "Punch of radius a = 1, whose nodes are driven by 10⁻⁴, on ground of radius and depth L, base and side on rollers; E = 1000, ν = 0.3; c cells under the punch, growing by 1.25 beyond it, CPDI1, 2² points a cell.",
    reference: "Half space: `P = 2 E/(1 − ν²) a δ` (Boussinesq; Sneddon 1965). The error of a finite depth is of order a/L, that of the cells of order h/a: the punch's last node carries half a cell more than its radius. An independent code found, on meshes that are alike below the punch, at 4, 8 and 16 cells, 1.1443, 1.1088, 1.0927 of this with L = 12 a and 1.0924, 1.0623, 1.0481 with L = 25 a.",
    run: punch,
};

/// Ground of two sizes, and what another code found there on 4, 8 and 16 cells.
const FOUND: [(f64, [f64; 3]); 2] = [(12.0, [1.1443, 1.1088, 1.0927]), (25.0, [1.0924, 1.0623, 1.0481])];

/// Force over that on the half space.
fn press(end: f64, cells: u32) -> Result<f64, Broken> {
    let lines = lines(cells, 1.0, 1.25, end);
    let (radii, heights) = (list(lines.iter().copied()), list(lines.iter().rev().map(|x| -x)));
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            mesh: Box(axes: [Nodes({radii}), Nodes({heights})]),
            basis: Cpdi1, materials: {{ "rock": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [(name: "ground", material: "rock", shape: Box(from: (0, -{end}), to: ({end}, 0)), points_per_cell: 2)],
            supports: [
                (name: "base", region: Plane(axis: Z, at: -{end}), fix: [Z]),
                (name: "side", region: Plane(axis: R, at: {end}), fix: [R]),
                (name: "punch", region: Box(from: (0, 0), to: (1, 0)), displace: [(axis: Z, by: -1e-4)]),
            ],
            schedule: (steps: 1), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    let force = history.series("reaction/punch", 1).last().map_or(f64::NAN, |force| -force);
    Ok(force / (2.0 * 1000.0 / (1.0 - 0.09) * 1e-4))
}

fn punch(extent: Extent) -> Result<Findings, Broken> {
    let meshes = extent.pick(&[4, 8][..], &[4, 8, 16, 32]);
    let jobs: Vec<(f64, u32)> =
        FOUND.iter().flat_map(|(end, _)| meshes.iter().map(move |&cells| (*end, cells))).collect();
    let runs = sweep(&jobs, |(end, cells)| press(*end, *cells))?;
    let (near, far) = runs.split_at(meshes.len());
    let mut findings = Findings::default();
    let heads = ["cells", "L = 12 a", "L = 25 a", "no end", "order"];
    let mut table =
        Table::new("Force over that of the half space; extrapolated in a/L; order of what is left:", &heads);
    // Both errors of the end are of order 1/L.
    let limits: Vec<f64> = near.iter().zip(far).map(|(near, far)| far - (near - far) * 12.0 / 13.0).collect();
    for (k, cells) in meshes.iter().enumerate() {
        for ((end, found), runs) in FOUND.iter().zip([near, far]) {
            if let Some(found) = found.get(k) {
                let what = format!("L = {end} a, {cells} cells: force against that of another code (relative)");
                findings.checks.push(Check::new(what, (runs[k] / found - 1.0).abs(), 2e-2));
            }
        }
        let order = if k == 0 { f64::NAN } else { ((limits[k - 1] - 1.0) / (limits[k] - 1.0)).log2() };
        let shown = if k == 0 { String::new() } else { fixed(order, 2) };
        table.push([cells.to_string(), fixed(near[k], 4), fixed(far[k], 4), fixed(limits[k], 4), shown]);
    }
    for k in 1..meshes.len() {
        let limit = 2.0 * limits[k] - limits[k - 1];
        let what =
            format!("no end, extrapolated from {} and {} cells: force (relative)", meshes[k - 1], meshes[k]);
        findings.checks.push(Check::new(what, (limit - 1.0).abs(), 2e-3).remark(fixed(limit, 4)));
    }
    findings.tables.push(table);
    Ok(findings)
}
