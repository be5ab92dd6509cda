//! A wall, a cut, and a slope at their limit.

use super::{iterations, newton_at_limit, scene};
use crate::cases::{fixed, sweep};
use crate::history::History;
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};

pub(in crate::cases) const WALL: Case = Case {
    name: "smooth wall",
    goal: "A smooth wall that is moved into soil, or away from it, meets Rankine's passive and active force.",
    setup: "Soil of height 1 and length 4 on a smooth base, γ = 20, K₀ = 1 at the start, a wall at one end moved by ± 0.001 in 20 load steps with the mesh; Mohr–Coulomb (c = 1, φ = ψ = 30°, E = 10⁶) and Tresca (s_u = 2.5, E = 10⁵, ν = 0.495); mean dilatation over points, 2² points a cell; standard MPM and GIMP, 8 and 16 cells in the height.",
    reference: "½ K_p γ H² + 2 c H √K_p and ½ K_a γ H² − 2 c H √K_a; ½ γ H² ± 2 s_u H. Heave and settlement of the surface, 0.1 % of the height at most, change the force as much.",
    run: wall,
};

pub(in crate::cases) const CUT: Case = Case {
    name: "vertical cut",
    goal: "A vertical cut in clay collapses under the weight that limit analysis gives.",
    setup: "A cut of height 1 in clay, s_u = 1 (Tresca), E = 10⁴, ν = 0.495, the ground going on 1 below and before it and 3 behind; weight along the path of equilibria, steps of equal dissipation; GIMP, 2² points a cell, mean dilatation over points, ghost stabilisation; 8 and 16 cells in the height.",
    reference: "γH/s_u between 3.7752 and 3.7776 (Kammoun et al. 2010), read where the crest has moved by 0.002; met from above, with the cells at the foot of the cut.",
    run: cut,
};

pub(in crate::cases) const SLOPE: Case = Case {
    name: "infinite slope",
    goal: "A layer on a slope stays until the slope is as steep as its friction.",
    setup: "A layer 1 deep along its slope, γ = 20, φ = ψ = 30°, c = 0.05, E = 10⁵, ν = 0.3, K₀ = 0.5 at the start; gravity turns down the slope in 100 load steps; lengths of 40 and 80 (the ends held), cells of 1 × 1/8; standard MPM, 2² points a cell.",
    reference: "tan β = tan φ + c/γh, where the middle of the surface has moved by 0.003. What the ends hold is the same for both lengths, so that twice the longer less the shorter is free of it.",
    run: slope,
};

/// The force on the wall: soil, whether it is pushed, exact value.
fn forces() -> [(&'static str, bool, f64); 4] {
    let root = 3.0_f64.sqrt();
    [
        ("sand", true, 0.5 * 3.0 * 20.0 + 2.0 * root),
        ("sand", false, 0.5 * 20.0 / 3.0 - 2.0 / root),
        ("clay", true, 0.5 * 20.0 + 2.0 * 2.5),
        ("clay", false, 0.5 * 20.0 - 2.0 * 2.5),
    ]
}

fn wall(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[8], &[8, 16]);
    let mut jobs = Vec::new();
    for (soil, pushed, force) in forces() {
        for basis in ["Smpm", "Gimp"] {
            jobs.extend(meshes.iter().map(|&cells| (soil, pushed, force, basis, cells)));
        }
    }
    let runs = sweep(&jobs, |&(soil, pushed, _, basis, cells)| {
        let changes = [
            ("basis", basis.to_owned()),
            ("bodies[0].material", format!("{soil:?}")),
            ("mesh.axes[0].cells", (4 * cells).to_string()),
            ("mesh.axes[1].cells", (5 * cells / 4).to_string()),
            ("motion[0].displacement", if pushed { "0.001" } else { "-0.001" }.to_owned()),
            ("output.fields", "[]".to_owned()),
        ];
        run(&scene("wall", &changes)?)?.completed()
    })?;
    let mut findings = Findings::default();
    let heads = ["soil", "state", "basis", "cells", "force", "exact", "Newton iterations"];
    let mut table = Table::new(
        "Force on the wall, and Newton iterations in 20 load steps. With GIMP the domains of heaving clay reach a little way into the cells above, whose nodes hardly anything else holds: these take part of the stress off the uppermost points, the less the smaller the cells:",
        &heads,
    );
    for ((soil, pushed, exact, basis, cells), history) in jobs.into_iter().zip(&runs) {
        let state = if pushed { "passive" } else { "active" };
        let force = history.series("reaction/wall", 0).last().map_or(f64::NAN, |force| force.abs());
        table.push([
            soil.to_owned(),
            state.to_owned(),
            basis.to_uppercase(),
            cells.to_string(),
            fixed(force, 4),
            fixed(exact, 4),
            iterations(history).to_string(),
        ]);
        let reached = basis == "Gimp" && soil == "clay" && pushed;
        let tolerance = if reached { 2.0 / f64::from(cells * cells) } else { 2e-3 };
        let name = format!("{soil}, {state}, {}, {cells} cells", basis.to_uppercase());
        findings.checks.push(Check::new(
            format!("{name}: force (relative)"),
            (force / exact - 1.0).abs(),
            tolerance,
        ));
        findings.checks.extend(newton_at_limit(&name, history));
    }
    findings.tables.push(table);
    Ok(findings)
}

/// Load fraction at which the point of a probe has moved so far; not a number if it never has.
fn reached(history: &History, probe: &str, distance: f64) -> f64 {
    let [x, y] = [0, 1].map(|k| history.series(&format!("probe/{probe}/displacement"), k));
    let moved: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect();
    let fractions: Vec<f64> = history.rows().iter().map(|row| row.fraction).collect();
    let Some(after) = moved.iter().position(|it| *it >= distance) else { return f64::NAN };
    let before = after.saturating_sub(1);
    let part = (distance - moved[before]) / (moved[after] - moved[before]);
    fractions[before] + part * (fractions[after] - fractions[before])
}

fn cut(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[8], &[8, 16]);
    let limit = 0.5 * (3.7752 + 3.7776);
    let runs = sweep(meshes, |&cells| {
        let changes = [
            ("mesh.axes[0].cells", (4 * cells).to_string()),
            ("mesh.axes[1].cells", (17 * cells / 8).to_string()),
            ("output.fields", "[]".to_owned()),
        ];
        // The path does not end: the run stops at its last step.
        Ok(run(&scene("cut", &changes)?)?.history)
    })?;
    let mut findings = Findings::default();
    let heads =
        ["cells", "γH/s_u where the crest has moved by 0.001", "0.002", "over the limit", "Newton iterations"];
    let mut table = Table::new("Weight at collapse, and Newton iterations in 40 steps along the path:", &heads);
    let mut ends = Vec::new();
    for (&cells, history) in meshes.iter().zip(&runs) {
        let [first, end] = [0.001, 0.002].map(|distance| 5.0 * reached(history, "crest", distance));
        table.push([
            cells.to_string(),
            fixed(first, 4),
            fixed(end, 4),
            fixed(end / limit, 4),
            iterations(history).to_string(),
        ]);
        let name = format!("{cells} cells");
        let error = (end / limit - 1.0).abs();
        findings.checks.push(Check::new(
            format!("{name}: weight against the limit"),
            error,
            0.45 * f64::from(cells).powf(-0.7),
        ));
        findings.checks.push(Check::new(
            format!("{name}: growth from 0.001 to 0.002"),
            end / first - 1.0,
            0.01,
        ));
        findings.checks.extend(newton_at_limit(&name, history));
        ends.push(end / limit);
    }
    for (ends, meshes) in ends.windows(2).zip(meshes.windows(2)) {
        let end = 2.0 * ends[1] - ends[0];
        let what = format!("limit from {} and {} cells", meshes[0], meshes[1]);
        findings.checks.push(Check::new(what, (end - 1.0).abs(), 0.03).remark(fixed(end, 4)));
    }
    findings.tables.push(table);
    Ok(findings)
}

fn slope(_: Extent) -> Result<Findings, Broken> {
    let exact = 30.0_f64.to_radians().tan() + 0.05 / 20.0;
    let runs = sweep(&[40_u32, 80], |&length| {
        let changes = [
            ("mesh.axes[0].to", length.to_string()),
            ("mesh.axes[0].cells", length.to_string()),
            ("bodies[0].shape.to", format!("({length}, 1)")),
            ("supports[2].region.at", length.to_string()),
            ("probes[0].points", format!("Near({}, 1)", length / 2)),
            ("output.fields", "[]".to_owned()),
        ];
        // It slides before the last load step.
        Ok((length, run(&scene("slope", &changes)?)?.history))
    })?;
    let mut findings = Findings::default();
    let heads = ["length", "tan β where it slides", "over tan φ + c/γh", "Newton iterations"];
    let mut table = Table::new(
        "Slope at which the middle has moved by 0.003, and Newton iterations until the run ends a little later:",
        &heads,
    );
    let mut ends = Vec::new();
    for (length, history) in &runs {
        let end = reached(history, "middle", 0.003);
        table.push([length.to_string(), fixed(end, 5), fixed(end / exact, 4), iterations(history).to_string()]);
        let what = format!("length {length}: slope against the limit (relative)");
        findings.checks.push(Check::new(what, (end / exact - 1.0).abs(), 0.02));
        findings.checks.extend(newton_at_limit(&format!("length {length}"), history));
        ends.push(end / exact);
    }
    let end = 2.0 * ends[1] - ends[0];
    let what = "without the ends: slope against the limit (relative)";
    findings.checks.push(Check::new(what, (end - 1.0).abs(), 5e-3).remark(fixed(end, 4)));
    findings.tables.push(table);
    Ok(findings)
}
