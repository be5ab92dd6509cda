//! A pile that is pushed and pulled.

use super::{list, scene};
use crate::cases::contact::of_tool;
use crate::cases::{fixed, sweep};
use crate::history::History;
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "pile pushed and pulled",
    goal: "The shaft of a pile carries its area times the adhesion, pulled and pushed, and its base the bearing capacity of a deep footing.",
    setup: "A pile of radius R = 0.25, wished in place 0.8 deep in weightless clay of radius 4 and depth 3.8, Tresca, s_u = 10, E = 1000 s_u, ν = 0.49; α = s_u/2 on a shaft that begins 0.05 above the smooth base. Pulled up by 0.003 until the base has parted, pushed down by 0.02. CPDI1, 2² points a cell, mean dilatation, cells of R/n at the pile.",
    reference: "Force of the shaft π D L α, L = 0.75 less the way up: at first order in the cells, because the last corner that the shaft holds stands for half a cell more than its end. Base, pushed: between the smooth footing on the surface, 5.69 s_u, and twice that; the rule of Skempton (1951) for circles, 6 (1 + 0.2 z/D) s_u up to 9 s_u, gives 7.9 s_u.",
    run: pile,
};

const RADIUS: f64 = 0.25;
const STRENGTH: f64 = 10.0;
/// Area of the shaft in the ground times the adhesion.
const SHAFT: f64 = 2.0 * PI * RADIUS * LENGTH * 0.5 * STRENGTH;
/// Length of the shaft in the ground.
const LENGTH: f64 = 0.75;

/// Lines from `from` by steps of `size` over `even`, then growing by 1.2 up to `end`.
fn graded(size: f64, even: f64, end: f64) -> Vec<f64> {
    let count = (even / size).round();
    let mut lines: Vec<f64> = (0..=count as u32).map(|k| f64::from(k) * even / count).collect();
    let (mut at, mut size) = (even, size);
    while at < end {
        size *= 1.2;
        at = if at + 1.5 * size > end { end } else { at + size };
        lines.push(at);
    }
    lines
}

fn moved(way: f64, steps: u32, cells: u32) -> Result<History, Broken> {
    let size = RADIUS / f64::from(cells);
    let below = graded(size, 0.2, 3.0).into_iter().skip(1).map(|depth| 0.4 - depth);
    let count = (0.8 / size).round();
    // Two rows of air above the ground.
    let beside = (0..=count as u32 + 2).map(|k| 0.4 + 0.8 * f64::from(k) / count);
    let mut heights: Vec<f64> = below.chain(beside).collect();
    heights.sort_by(f64::total_cmp);
    let motion = format!("Move(by: (0, {way}))");
    let changes = [
        ("mesh.axes[0]", format!("Nodes({})", list(graded(size, 0.5, 4.0)))),
        ("mesh.axes[1]", format!("Nodes({})", list(heights))),
        ("tools[0].motion", motion.clone()),
        ("tools[1].motion", motion),
        ("schedule.steps", steps.to_string()),
    ];
    run(&scene("pile", &changes)?)?.completed()
}

/// Force of the shaft over that of its present area, mean over the second half of the way.
fn shaft(history: &History, way: f64) -> f64 {
    let force = of_tool(history, "shaft", "force", 1);
    let rows: Vec<(f64, f64)> = history.rows().iter().map(|row| way * row.fraction).zip(force).collect();
    let half = &rows[rows.len() / 2..];
    let part = |(way, force): &(f64, f64)| -way.signum() * force / (SHAFT * (1.0 - way / LENGTH));
    half.iter().map(part).sum::<f64>() / half.len() as f64
}

fn pile(extent: Extent) -> Result<Findings, Broken> {
    let meshes = extent.pick(&[3, 6][..], &[3, 6, 12]);
    let moves = [("pulled", 0.003, 3), ("pushed", -0.02, 20)];
    let jobs: Vec<_> = moves.iter().flat_map(|it| meshes.iter().map(move |&cells| (*it, cells))).collect();
    let runs = sweep(&jobs, |((_, way, steps), cells)| moved(*way, *steps, *cells))?;
    let mut findings = Findings::default();
    let heads = ["pile", "cells over R", "shaft over π D L α", "base over π R² s_u"];
    let mut table = Table::new(
        "Mean force of the shaft over the second half of the way, and force of the base at the end:",
        &heads,
    );
    for ((name, way, _), runs) in moves.iter().zip(runs.chunks(meshes.len())) {
        for (cells, history) in meshes.iter().zip(runs) {
            let shaft = shaft(history, *way);
            let base = of_tool(history, "base", "force", 1).last().copied().unwrap_or(f64::NAN)
                / (PI * RADIUS * RADIUS * STRENGTH);
            table.push([(*name).to_owned(), cells.to_string(), fixed(shaft, 4), fixed(base, 3)]);
            let what = format!("{name}, {cells} cells: force of the shaft against π D L α (relative)");
            let tolerance = 0.2 / f64::from(*cells);
            findings.checks.push(Check::new(what, (shaft - 1.0).abs(), tolerance).remark(fixed(shaft, 4)));
            let (what, is_wrong) = if *way > 0.0 {
                ("base that still carries", base != 0.0)
            } else {
                ("base outside its bounds", !(5.69..=11.38).contains(&base))
            };
            let what = format!("{name}, {cells} cells: {what}");
            findings.checks.push(Check::none(what, usize::from(is_wrong)).remark(fixed(base, 3)));
        }
    }
    findings.tables.push(table);
    Ok(findings)
}
