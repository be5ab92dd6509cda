//! Bodies of revolution that turn about their axis: torsion of a cylinder, and piles that are turned, pulled, and both.

use crate::cases::{fixed, scientific, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use std::f64::consts::PI;

pub(in crate::cases) const CYLINDER: Case = Case {
    name: "cylinder that is twisted",
    goal: "The torque of a cylinder that is twisted at finite strain converges to its closed form with the square of the cells, is the same for every basis whose points fill the same pieces, and does not depend on the number of load steps.",
    setup: "A cylinder of radius and height 1, E = 10³, ν = 0.3, held along r and at its ends along z, the top turned by 0.4 against the base; 4, 8 and 16 cells, 2² points a cell, in 1 and 4 load steps.",
    reference: "The torque of Hencky's law in simple shear, integrated over the section: 237.465140095449.",
    run: cylinder,
};

pub(in crate::cases) const PILE: Case = Case {
    name: "pile turned and pulled",
    goal: "The surface of a pile bears its strength along the slip: turned, pulled, and both at once, torque and force are those of the closed form.",
    setup: "A rigid pile of radius 0.5 along 1 of elastic ground up to r = 2.5, whose outside is held, E = 10⁴, ν = 0.3, adhesion 1 between both; the pile turns by 8·10⁻³ and is pulled by none, a half, one and two times its way at the surface, and is pulled alone, in 8 load steps; 16 cells a radius of 2, with contact stiffness 100. The surface of the pile in the ground is known to a sample, 1/96 of it.",
    reference: "Torque 2π R² L a cos ψ and force 2π R L a sin ψ, with tan ψ the ways along the axis and around it.",
    run: pile,
};

/// Torque of the cylinder.
const TORQUE: f64 = 237.465_140_095_449;

fn twisted((basis, cells, steps): (&str, u32, u32)) -> Result<f64, Broken> {
    let degrees = 0.4_f64.to_degrees();
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            twist: true,
            mesh: Box(axes: [Uniform(from: 0, to: 1, cells: {cells}), Uniform(from: 0, to: 1, cells: {cells})]),
            basis: {basis}, materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [(name: "shaft", material: "m", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
            supports: [
                (name: "all", region: Everywhere, fix: [R]), (name: "base", region: Plane(axis: Z, at: 0), fix: [Z, Theta]),
                (name: "top", region: Plane(axis: Z, at: 1), fix: [Z], displace: [(axis: Theta, by: {degrees})]),
            ],
            schedule: (steps: {steps}), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    Ok(history.series("reaction_moment/top", 0).last().copied().unwrap_or(f64::NAN))
}

fn cylinder(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let cells = extent.pick(&[4, 8][..], &[4, 8, 16]);
    let bases = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];
    let of_basis = |basis: &'static str| cells.iter().map(move |&cells| (basis, cells, 1));
    let mut jobs: Vec<(&str, u32, u32)> = bases.iter().flat_map(|basis| of_basis(basis)).collect();
    jobs.push(("Cpdi1", cells[0], 4));
    let torques = sweep(&jobs, |job| twisted(*job))?;
    let (in_steps, torques) = torques.split_last().unwrap_or((&f64::NAN, &[]));
    let standard = torques[0];
    let mut table = Table::new("Torques against the closed form:", &["basis", "cells", "error", "order"]);
    for (basis, torques) in bases.iter().zip(torques.chunks(cells.len())) {
        let errors: Vec<f64> = torques.iter().map(|torque| torque / TORQUE - 1.0).collect();
        for (k, (cells, error)) in cells.iter().zip(&errors).enumerate() {
            let order = if k == 0 { "".into() } else { fixed((errors[k - 1] / error).log2(), 2) };
            table.push([basis.to_string(), cells.to_string(), scientific(*error, 3), order]);
        }
        findings.checks.push(Check::new(format!("{basis}, 8 cells: torque (relative)"), errors[1].abs(), 3e-3));
        let lack = (1.9 - (errors[0] / errors[1]).log2()).max(0.0);
        findings.checks.push(Check::new(format!("{basis}: order, lack below 1.9"), lack, 0.0));
        // Triangles have points at other places.
        if *basis != "Cpdi2t" {
            let apart = (torques[0] / standard - 1.0).abs();
            let what = format!("{basis}: torque against standard MPM's (relative)");
            findings.checks.push(Check::new(what, apart, 1e-9));
        }
    }
    let once = torques[2 * cells.len()];
    findings.checks.push(Check::new("4 load steps against 1 (relative)", (in_steps / once - 1.0).abs(), 1e-10));
    findings.tables.push(table);
    Ok(findings)
}

/// Torque and force on the pile over their limits, for ways along the axis and around it.
fn driven(along: f64, around: f64) -> Result<[f64; 2], Broken> {
    let degrees = (around / 0.5).to_degrees();
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            twist: true,
            mesh: Box(axes: [Uniform(from: 0, to: 2.5, cells: 20), Uniform(from: -0.25, to: 1.25, cells: 12)]),
            basis: Cpdi1, materials: {{ "ground": Hencky(young: 1e4, poisson: 0.3) }},
            bodies: [(name: "ground", material: "ground", shape: Box(from: (0.5, 0), to: (2.5, 1)), points_per_cell: 2)],
            supports: [(name: "outside", region: Plane(axis: R, at: 2.5), fix: [R, Z, Theta])],
            tools: [
                (name: "pile", rounding: 0, parts: [Cylinder(radius: 0.5, extent: (-1, 2))],
                    interface: (adhesion: 1, stiffness: 100), motion: Move(by: (0, {along}), turn: (angle: {degrees}))),
            ],
            schedule: (steps: 8), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    let last = |name: &str, c: usize| history.series(name, c).last().copied().unwrap_or(f64::NAN);
    let area = 2.0 * PI * 0.5;
    Ok([-last("tool/pile/moment", 0) / (area * 0.5), -last("tool/pile/force", 1) / area])
}

fn pile(_: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let ways = [(0.0, 4e-3), (2e-3, 4e-3), (4e-3, 4e-3), (8e-3, 4e-3), (4e-3, 0.0)];
    let loads = sweep(&ways, |(along, around)| driven(*along, *around))?;
    let heads = ["along the axis over around it", "torque", "closed form", "force", "closed form"];
    let mut table = Table::new("Torque and force on the pile, over 2π R² L a and 2π R L a:", &heads);
    for ((along, around), [torque, force]) in ways.iter().zip(&loads) {
        let way = along.hypot(*around);
        let exact = [around / way, along / way];
        let name = if *around == 0.0 { "pulled alone".into() } else { fixed(along / around, 1) };
        table.push([name.clone(), fixed(*torque, 4), fixed(exact[0], 4), fixed(*force, 4), fixed(exact[1], 4)]);
        let error = (torque - exact[0]).hypot(force - exact[1]);
        findings.checks.push(Check::new(format!("{name}: torque and force over their limits"), error, 1.2e-2));
    }
    findings.tables.push(table);
    Ok(findings)
}
