//! The limit torque of a ring of weak metal.

use super::super::{fixed, largest, sweep};
use super::torque;
use crate::scenes::{load, run};
use crate::variants::{CPDI1, Method, SMPM, plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Count, Finite, MotionInput, Scene};
use std::f64::consts::{PI, SQRT_2};

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist, limit torque",
    goal: "At the limit load the torque is that of the innermost row of cells, and comes down to the exact one with their size.",
    setup: "The doughnut twist with ρ_y = 10⁴ to 5° in 50 load steps of 0.1°, 5 × 32 cells and finer by 2 and 4; 2² points a cell. The tests run the coarsest mesh.",
    reference: "The exact limit torque 2π R_i² ρ_y/√2 = 1.1107207·10⁶, and the discrete one 2π (R_i + h/2)² ρ_y/√2: the innermost row of cells yields as a whole. An independent implementation with CPDI1 finds 1.218 and 1.101 times the exact one on the two coarser meshes at 5°.",
    run: limit,
};

/// Limit torque with cells of width h `[F L]` per unit thickness; the exact one with 0.
fn limit_torque(h: f64) -> f64 {
    2.0 * PI * (5.0 + 0.5 * h).powi(2) * 1e4 / SQRT_2
}

fn scene(method: &Method, factor: u32) -> Result<Scene, Broken> {
    let mut scene = refined(method.of(plane(load("doughnut_limit")?)?), factor);
    if let MotionInput::Twist { inner, .. } = &mut scene.motion {
        *inner = Finite(5.0);
    }
    // The bases as published.
    for body in &mut scene.bodies {
        body.mean_dilatation = None;
    }
    scene.schedule.steps = Some(Count(50));
    scene.output.fields.clear();
    Ok(Scene::PlaneStrain(scene))
}

fn limit(extent: Extent) -> Result<Findings, Broken> {
    let factors: &[u32] = extent.pick(&[1], &[1, 2, 4]);
    let methods = [SMPM, CPDI1];
    let jobs: Vec<(Method, u32)> =
        methods.iter().flat_map(|method| factors.iter().map(move |&factor| (method.clone(), factor))).collect();
    let histories = sweep(&jobs, |(method, factor)| run(&scene(method, *factor)?)?.completed())?;

    let mut findings = Findings::default();
    let heads = [
        "basis",
        "cells",
        "discrete limit",
        "torque at 5°",
        "over the discrete limit, from 1° on",
        "iterations: mean / most",
        "halvings",
    ];
    let mut table = Table::new(
        "Torques over the exact limit. With CPDI1 the torque keeps to the discrete limit; with standard MPM it swings about it as points cross into other cells. At the limit load the tangent is all but singular, and load steps cost more iterations the finer the mesh.",
        &heads,
    );
    let exact = limit_torque(0.0);
    let mut last: Vec<(Method, f64)> = Vec::new();
    for ((method, factor), history) in jobs.iter().zip(&histories) {
        let name = format!("{}, {} × {}", method.name, 5 * factor, 32 * factor);
        let discrete = limit_torque(1.0 / f64::from(*factor));
        let angles = history.rows()[1..].iter().map(|row| 5.0 * row.fraction);
        let at_limit: Vec<f64> = angles
            .zip(torque(history))
            .filter(|(angle, _)| *angle > 1.0 - 1e-9)
            .map(|(_, torque)| torque / discrete)
            .collect();
        let low = at_limit.iter().copied().fold(f64::INFINITY, f64::min);
        let off = largest(at_limit.iter().map(|torque| (torque - 1.0).abs()));
        let end = torque(history).last().copied().unwrap_or(f64::NAN) / exact;
        // The points' pressures swing with standard MPM, see the case on large shear.
        let tolerance = if *method == CPDI1 { 0.015 } else { 0.06 };
        findings.checks.push(
            Check::new(format!("{name}: torque against the discrete limit, 1° to 5°"), off, tolerance)
                .remark(format!("{:.4} of the exact limit at 5°", end)),
        );
        if let (true, Some(known)) = (*method == CPDI1, [1.218, 1.101].get(factor.trailing_zeros() as usize)) {
            let what = format!("{name}: torque over the exact limit at 5° against {known}");
            findings.checks.push(Check::new(what, (end - known).abs(), 3e-3));
        }
        let iterations = history.series("newton_iterations", 0);
        let mean = iterations.iter().sum::<f64>() / (iterations.len() - 1) as f64;
        table.push([
            method.name.into(),
            format!("{} × {}", 5 * factor, 32 * factor),
            fixed(discrete / exact, 4),
            fixed(end, 4),
            format!("{} to {}", fixed(low, 3), fixed(largest(at_limit.iter().copied()), 3)),
            format!("{mean:.1} / {}", largest(iterations)),
            fixed(history.series("cuts", 0).iter().sum(), 0),
        ]);
        last.push((method.clone(), end));
    }
    if extent == Extent::Full {
        for method in &methods {
            let ends: Vec<f64> = last.iter().filter(|(of, _)| of == method).map(|&(_, end)| end).collect();
            let rising = ends.windows(2).filter(|pair| pair[1] >= pair[0]).count();
            let what = format!("{}: meshes that do not come nearer to the exact limit", method.name);
            let told = ends.iter().map(|end| fixed(*end, 4)).collect::<Vec<_>>().join(", ");
            findings.checks.push(Check::none(what, rising).remark(told));
        }
    }
    findings.tables.push(table);
    Ok(findings)
}
