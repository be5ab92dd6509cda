//! Penetrometers and a cylinder in clay, in space, by halves, quarters and eighths.

use super::{extrapolated, nodes, of_tool, scene, written};
use crate::cases::{fixed, largest};
use crate::history::History;
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "ball, T-bar and turned cylinder in space",
    goal: "Limit loads of round tools in clay, by the part of them that planes of symmetry leave.",
    setup: "A quarter of a slice of a T-bar (von Mises) and an eighth of a ball (Tresca), smooth and rough, R = 0.5, wished in place, are pushed by 0.04 R in 8 load steps through box meshes out of which they are cut; n cells over R, growing beyond. On the plane of their middle clay moves along the way only, because what is behind it is the mirror image with the other sign. A quarter of a cylinder, R = 0.5, of which 0.5 and its end stand in clay, α = s_u/2, is turned by 1° in a ring mesh with n cells from 0.05 to R. E = 1000 s_u, ν = 0.49, CPDI1, 2³ points a cell, mean dilatation.",
    reference: "T-bar: 9.14 s_u D smooth, 11.94 rough (Randolph & Houlsby 1984). Ball: 11.80 π R² s_u smooth, 15.10 rough (Randolph, Martin & Hu 2000). Torque of a cylinder with two ends, H between them: ½πD²α(H + D/3), of which this is the half.",
    run: space,
};

/// Radius of all of them.
const RADIUS: f64 = 0.5;

/// What is pushed.
struct Pushed {
    tool: &'static str,
    scene: &'static str,
    surface: &'static str,
    adhesion: f64,
    /// Force over that of the part that is modelled, as n cells over the radius have it.
    scale: fn(u32) -> f64,
    limit: f64,
    /// Of each mesh, and of the value that two of them are extrapolated to.
    tolerances: (f64, f64),
}

const PUSHED: [Pushed; 4] = [
    Pushed {
        tool: "bar",
        scene: "bar_solid",
        surface: "smooth",
        adhesion: 0.0,
        scale: of_bar,
        limit: 9.142,
        tolerances: (0.06, 0.06),
    },
    Pushed {
        tool: "bar",
        scene: "bar_solid",
        surface: "rough",
        adhesion: 1.0,
        scale: of_bar,
        limit: 11.940,
        tolerances: (0.06, 0.06),
    },
    Pushed {
        tool: "ball",
        scene: "ball",
        surface: "smooth",
        adhesion: 0.0,
        scale: of_ball,
        limit: 11.80,
        tolerances: (0.12, 0.12),
    },
    Pushed {
        tool: "ball",
        scene: "ball",
        surface: "rough",
        adhesion: 1.0,
        scale: of_ball,
        limit: 15.10,
        tolerances: (0.12, 0.12),
    },
];

/// Two halves, two sides, over s_u D and the slice's width of one cell.
fn of_bar(cells: u32) -> f64 {
    4.0 / (2.0 * RADIUS * RADIUS / f64::from(cells))
}

fn of_ball(_: u32) -> f64 {
    8.0 / (PI * RADIUS * RADIUS)
}

fn space(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let heads = ["tool", "surface", "cells", "load", "over the limit", "growth in the last step"];
    let text = "Largest load over s_u D or π R² s_u:";
    let mut table = Table::new(text, &heads);
    for pushed in &PUSHED {
        push(pushed, extent, &mut findings, &mut table)?;
    }
    findings.tables.push(table);
    turn(extent, &mut findings)?;
    Ok(findings)
}

/// The mesh of a tool that is pushed.
fn mesh(tool: &str, cells: u32) -> Vec<(&'static str, String)> {
    let far = if tool == "bar" { 3.0 } else { 2.5 };
    let axis = written(nodes(cells, RADIUS, far));
    if tool != "bar" {
        return vec![("mesh", format!("Box(axes: [{axis}, {axis}, {axis}])"))];
    }
    let width = RADIUS / f64::from(cells);
    vec![
        ("mesh", format!("Box(axes: [{axis}, Nodes([0, {width}]), {axis}])")),
        ("bodies[0].shape.to", format!("({far}, {width}, {far})")),
        ("supports[2].region.at", width.to_string()),
    ]
}

fn push(it: &Pushed, extent: Extent, findings: &mut Findings, table: &mut Table) -> Result<(), Broken> {
    let Pushed { tool, surface, limit, tolerances, .. } = *it;
    let meshes = if tool == "bar" { [4, 6, 8] } else { [3, 4, 5] };
    let mut found = Vec::new();
    for cells in extent.pick(&meshes[..1], &meshes[..]) {
        let mut changes = mesh(tool, *cells);
        changes.push(("tools[0].interface.adhesion", it.adhesion.to_string()));
        let history = run(&scene(it.scene, &changes)?)?.completed()?;
        let load: Vec<f64> =
            of_tool(&history, tool, "force", 2).iter().map(|force| -force * (it.scale)(*cells)).collect();
        let most = largest(load.iter().copied());
        let growth =
            load.last().zip(load.iter().nth_back(1)).map_or(f64::NAN, |(end, before)| end / before - 1.0);
        let what = format!("{tool}, {surface}, {cells} cells: load against the limit, relative");
        findings.checks.push(Check::new(what, (most / limit - 1.0).abs(), tolerances.0).remark(fixed(most, 3)));
        let area = area(&history, tool, *cells);
        let what = format!("{tool}, {surface}, {cells} cells: area of the surface, relative");
        // A slice of one cell is only eight rows of samples wide, and has one more or less.
        let tolerance = if tool == "bar" { 0.12 } else { 0.03 };
        findings.checks.push(Check::new(what, (area - 1.0).abs(), tolerance).remark(fixed(area, 4)));
        table.push([
            tool.to_owned(),
            surface.to_owned(),
            cells.to_string(),
            fixed(most, 3),
            fixed(most / limit, 4),
            format!("{} %", fixed(100.0 * growth, 2)),
        ]);
        found.push((1.0 / f64::from(*cells), most));
    }
    if let [_, coarse, fine] = found[..] {
        let load = extrapolated([coarse, fine]);
        let what = format!("{tool}, {surface}: load extrapolated to no width of cells, relative");
        findings.checks.push(Check::new(what, (load / limit - 1.0).abs(), tolerances.1).remark(fixed(load, 3)));
    }
    Ok(())
}

/// Area of the surface at the start over that of the part of the tool.
fn area(history: &History, tool: &str, cells: u32) -> f64 {
    let whole = match tool {
        "bar" => 0.5 * PI * RADIUS * RADIUS / f64::from(cells),
        _ => 0.5 * PI * RADIUS * RADIUS,
    };
    of_tool(history, tool, "area", 0).get(1).map_or(f64::NAN, |area| area / whole)
}

fn turn(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let whole = 0.5 * PI * 0.5 * (1.0 + 1.0 / 3.0) / 8.0;
    let surface = (PI * 1.0 + 2.0 * PI * RADIUS * RADIUS) / 8.0;
    let text = "Torque of the turned cylinder over its limit, and the area of its surface over the cylinder's:";
    let mut table = Table::new(text, &["cells", "torque", "area"]);
    let mut found = Vec::new();
    for cells in extent.pick(&[4][..], &[4, 6, 8]) {
        let inner = (0..*cells).map(|k| 0.05 + 0.45 * f64::from(k) / f64::from(*cells));
        let beyond = nodes(*cells, RADIUS, 1.5).into_iter().skip(*cells as usize);
        let down = nodes(*cells, RADIUS, 1.25).into_iter().rev().map(|z| 0.0 - z);
        let (radii, height) = (written(inner.chain(beyond)), written(down));
        let sectors = 3 * cells / 2;
        let ring = format!("Ring(radii: {radii}, sectors: {sectors}, angles: (0, 90), height: {height})");
        let history = run(&scene("turned_end", &[("mesh", ring)])?)?.completed()?;
        let last = |column: &str, component: usize| {
            of_tool(&history, "cylinder", column, component).last().copied().unwrap_or(f64::NAN)
        };
        let (torque, area) = (-last("moment", 2) / whole, last("area", 0) / surface);
        let what = format!("turned cylinder, {cells} cells: torque against the limit, relative");
        findings.checks.push(Check::new(what, (torque - 1.0).abs(), 0.05).remark(fixed(torque, 4)));
        table.push([cells.to_string(), fixed(torque, 4), fixed(area, 4)]);
        found.push((1.0 / f64::from(*cells), torque));
    }
    if let [_, coarse, fine] = found[..] {
        let torque = extrapolated([coarse, fine]);
        let what = "turned cylinder: torque extrapolated to no width of cells, relative";
        findings.checks.push(Check::new(what, (torque - 1.0).abs(), 0.03).remark(fixed(torque, 4)));
    }
    findings.tables.push(table);
    Ok(())
}
