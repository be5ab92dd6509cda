//! Tools in motions that leave something exact: a screw along its own thread, a full turn of everything, a cylinder that
//! turns on a mesh along the axes and in clay whose strength grows with depth.

use super::of_tool;
use crate::cases::{fixed, largest};
use crate::history::History;
use crate::scenes::{load_own, run};
use crate::variants::{plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{AxisInput, Count, Finite, MeshInput, Scene};
use std::f64::consts::{PI, TAU};

pub(in crate::cases) const CASE: Case = Case {
    name: "screws and full turns",
    goal: "What a motion of a tool leaves exact is so: a screw that follows its thread meets adhesion alone, a full turn of everything changes nothing, and adhesion has the strength of each point.",
    setup: "A screw (shaft R_s = 0.1, plate R_h = 0.3, 0.1 thick with a round rim, pitch 0.4) turns by 10° along its own thread in soil that does not move, cut by it as boxes are, cells of 1/10, in the full run 1/20 and 1/40 too; one turn of the plate lies in the soil. A block of von Mises clay that a rough foot has pressed, dragged and let yield is turned once around in 180 load steps with foot and mesh. A rigid cylinder, R = 0.5, α = s_u/2, which never parts from the clay, turns by 1° on a box mesh with boxes of GIMP along the axes, cells of R/10, in the full run R/20 too. It turns by 3° in a tube of clay 1 deep (48 sectors), s_u = 5 + 2 z at the depth z.",
    reference: "Torque and vertical force of the screw: shaft a 2πR_s² L R_s/q and a 2πR_s L c/q with q² = R_s² + c², c = pitch/2π and L without what the plate covers; faces a 4π/3 (R_h³ - R_s³) and 2 a pitch (R_h - R_s); the round rim by an integral over half its circle. The same state before and after the turn. Torque 2πR² α per length; 2πR² ½ ∫ s_u dz.",
    run: motions,
};

fn motions(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    screw(extent, &mut findings)?;
    full_turn(&mut findings)?;
    on_box_mesh(extent, &mut findings)?;
    by_depth(&mut findings)?;
    Ok(findings)
}

const SHAFT: f64 = 0.1;
const PLATE: f64 = 0.3;
const PITCH: f64 = 0.4;
const THICKNESS: f64 = 0.1;

/// Torque and vertical force of a shear stress of 1 along the thread on the shaft, the faces and the rim of one turn.
fn along_thread() -> [f64; 2] {
    let (c, h) = (PITCH / TAU, 0.5 * THICKNESS);
    let q = SHAFT.hypot(c);
    let free = PITCH - THICKNESS * q / SHAFT;
    let shaft = [TAU * SHAFT * SHAFT * free * SHAFT / q, TAU * SHAFT * free * c / q];
    let faces = [4.0 * PI / 3.0 * (PLATE.powi(3) - SHAFT.powi(3)), 2.0 * PITCH * (PLATE - SHAFT)];
    let length = PLATE.hypot(c);
    let mut rim = [0.0; 2];
    let n = 1000;
    for k in 0..n {
        let (sine, cosine) = (PI * ((f64::from(k) + 0.5) / f64::from(n) - 0.5)).sin_cos();
        let normal = [cosine, -c / length * sine, PLATE / length * sine];
        let (x, y) = (PLATE + h * normal[0], h * normal[1]);
        let velocity = [-y, x, c];
        let across: f64 = (0..3).map(|d| velocity[d] * normal[d]).sum();
        let along: [f64; 3] = std::array::from_fn(|d| velocity[d] - normal[d] * across);
        let speed = along.iter().map(|v| v * v).sum::<f64>().sqrt();
        let area = TAU * h * length * PI / f64::from(n) * (1.0 + h * PLATE / (length * length) * cosine);
        rim[0] += area * (x * along[1] - y * along[0]) / speed;
        rim[1] += area * along[2] / speed;
    }
    std::array::from_fn(|k| shaft[k] + faces[k] + rim[k])
}

fn screw(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let exact = along_thread();
    let mut table = Table::new("Screw along its thread:", &["cells", "torque", "vertical force", "area"]);
    table.push(["exact".into(), fixed(exact[0], 4), fixed(exact[1], 4), String::new()]);
    let mut found: Vec<[f64; 2]> = Vec::new();
    for factor in extent.pick(&[1][..], &[1, 2, 4]) {
        let Scene::Solid(mut scene) = load_own("contact/screw_thread")? else {
            return Err("expected a scene in space".into());
        };
        if let MeshInput::Box { axes, .. } = &mut scene.mesh {
            for axis in axes {
                let AxisInput::Uniform { cells, .. } = axis else { return Err("expected even cells".into()) };
                *cells = Count(cells.0 * factor);
            }
        }
        if *factor == 1 {
            let mut smooth = scene.clone();
            smooth.tools[0].interface.adhesion = Finite(0.0);
            let history = run(&Scene::Solid(smooth))?.completed()?;
            let error = largest(
                [
                    last(&history, "screw", "moment", 2) / exact[0],
                    last(&history, "screw", "force", 2) / exact[1],
                ]
                .map(f64::abs),
            );
            findings.checks.push(Check::new(
                "screw, smooth: torque and vertical force over those of adhesion",
                error,
                1e-3,
            ));
        }
        let history = run(&Scene::Solid(scene))?.completed()?;
        let of = [last(&history, "screw", "moment", 2), last(&history, "screw", "force", 2)];
        let width = 10 * factor;
        table.push([
            format!("1/{width}"),
            fixed(of[0], 4),
            fixed(of[1], 4),
            fixed(last(&history, "screw", "area", 0), 4),
        ]);
        let errors: [f64; 2] = std::array::from_fn(|k| of[k] / exact[k] - 1.0);
        let tolerance = 0.08 / f64::from(*factor);
        let what = format!("screw, cells of 1/{width}: torque and vertical force along the thread, relative");
        let told = format!("{} and {}", fixed(errors[0], 4), fixed(errors[1], 4));
        findings.checks.push(Check::new(what, largest(errors.map(f64::abs)), tolerance).remark(told));
        found.push(errors);
    }
    if let [_, middle, fine] = found[..] {
        let order = (middle[0] / fine[0]).log2();
        let limit = fine[0] - (middle[0] - fine[0]) / (2_f64.powf(ORDER) - 1.0);
        let what = "screw: torque extrapolated to no width of cells, relative";
        let told = format!("{}, order of the last two {}", fixed(limit, 4), fixed(order, 2));
        findings.checks.push(Check::new(what, limit.abs(), 5e-3).remark(told));
    }
    findings.tables.push(table);
    Ok(())
}

/// Order in the width of cells with which errors of surfaces fall that boxes are cut by in steps.
const ORDER: f64 = 1.5;

fn last(history: &History, tool: &str, column: &str, component: usize) -> f64 {
    of_tool(history, tool, column, component).last().copied().unwrap_or(f64::NAN)
}

fn full_turn(findings: &mut Findings) -> Result<(), Broken> {
    let history = run(&load_own("contact/full_turn")?)?.completed()?;
    let Some(before) = history.rows().iter().position(|row| row.fraction == 2.0) else {
        return Err("no load step ends where the turn begins".into());
    };
    let mut error = 0.0_f64;
    let mut apart = |values: &[f64], size: f64| {
        error = largest(
            [error].into_iter().chain(values[before..].iter().map(|it| (it - values[before]).abs() / size)),
        );
    };
    let [x, y] = [0, 1].map(|component| of_tool(&history, "foot", "force", component));
    let force: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect();
    apart(&force, force[before]);
    for column in ["energy/elastic", "energy/dissipated", "tool/foot/moment", "tool/foot/area"] {
        let values = history.series(column, 0);
        apart(&values, values[before].abs());
    }
    let what = "full turn: force, moment and area of the foot, and energies, in every load step, relative";
    findings.checks.push(Check::new(what, error, 1e-9));
    let turned = [x, y].map(|force| (force.last().copied().unwrap_or(f64::NAN) - force[before]).abs());
    let what = "full turn: components of the foot's force after it, relative";
    findings.checks.push(Check::new(what, largest(turned.map(|it| it / force[before])), 1e-9));
    Ok(())
}

fn on_box_mesh(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let limit = 2.0 * PI * 0.25 * 0.5;
    for factor in extent.pick(&[1][..], &[1, 2]) {
        let scene = refined(plane(load_own("contact/gimp_cylinder")?)?, *factor);
        let history = run(&Scene::PlaneStrain(scene))?.completed()?;
        let (torque, area) =
            (-last(&history, "bar", "moment", 0) / limit, last(&history, "bar", "area", 0) / PI);
        let cells = 10 * factor;
        let what = format!("cylinder, GIMP on a box mesh, cells of R/{cells}: torque against 2πR² α, relative");
        findings
            .checks
            .push(Check::new(what, (torque - 1.0).abs(), 0.05 / f64::from(*factor)).remark(fixed(torque, 4)));
        let what = format!("cylinder, GIMP on a box mesh, cells of R/{cells}: area");
        findings.checks.push(Check::new(what, (area - 1.0).abs(), 2e-3));
    }
    Ok(())
}

fn by_depth(findings: &mut Findings) -> Result<(), Broken> {
    let history = run(&load_own("contact/clay_by_depth")?)?.completed()?;
    let torque = -last(&history, "pile", "moment", 2) / (2.0 * PI * 0.25 * 0.5 * 6.0);
    let what = "cylinder in clay whose strength grows with depth: torque against 2πR² α ∫ s_u dz, relative";
    findings.checks.push(Check::new(what, (torque - 1.0).abs(), 1e-2).remark(fixed(torque, 4)));
    Ok(())
}
