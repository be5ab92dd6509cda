//! The elastic doughnut.

use super::super::{fixed, largest, scientific, sweep};
use super::at_stations;
use crate::history::History;
use crate::problems::doughnut::{EXACT_AT_20, ring, torque};
use crate::reference::Reference;
use crate::scenes::{Run, run};
use crate::variants::{CPDI1, CPDI2Q, GENERAL, Method, SMPM};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist, elastic",
    goal: "Large rotation and shear with a mesh that turns along: torque and its order of convergence.",
    setup: "A ring 5 to 10 (E = 10⁶, ν = 0, elastic), its outer edge fixed, its inner edge turned by 20° in 20 load steps; every ring of nodes turns with the material. 5 × 32 cells, and finer by 2, 4 and 8; 2² points a cell.",
    reference: "The independent implementation at every degree (5 × 32); the converged one-dimensional solution, 6.7643365·10⁷ at 20°, and its profile.",
    run: elastic,
};

fn elastic(extent: Extent) -> Result<Findings, Broken> {
    let factors: &[u32] = extent.pick(&[1, 2], &[1, 2, 4, 8]);
    let jobs: Vec<(&Method, u32)> =
        GENERAL.iter().flat_map(|method| factors.iter().map(move |&factor| (method, factor))).collect();
    let runs = sweep(&jobs, |(method, factor)| run(&Scene::PlaneStrain(ring(method, *factor)?)))?;
    let of = |method: &Method| {
        let at = GENERAL.iter().position(|it| it == method).expect("a general method");
        &runs[at * factors.len()..(at + 1) * factors.len()]
    };

    let mut findings = Findings::default();
    let table = Reference::read("doughnut_elastic_5x32_twist")?;
    for (method, column) in [(SMPM, "smpm"), (CPDI2Q, "cpdi2q")] {
        let expected = table.column(column)?;
        let error = largest(
            at_stations(&of(&method)[0].history, 20).iter().zip(&expected).map(|(a, b)| (a / b - 1.0).abs()),
        );
        let what = format!("{}, 5 × 32: torque against the table (relative, every degree)", method.name);
        findings.checks.push(Check::new(what, error, 1e-7));
    }

    let heads: Vec<String> =
        ["basis".into()].into_iter().chain(factors.iter().map(|f| format!("{} × {}", 5 * f, 32 * f))).collect();
    let mut measured = Table::new(
        "Relative error of the torque at 20°; in parentheses the order between two meshes:",
        &heads.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    // What the independent implementation found on the two coarse meshes, to two digits.
    let known = [
        [1.19e-2, 1.02e-2],
        [-3.1e-4, -1.3e-4],
        [1.0e-3, 1.3e-4],
        [4.8e-3, 1.2e-3],
        [2.7e-2, 6.7e-3],
        [1.4e-2, 3.6e-3],
    ];
    for (method, known) in GENERAL.iter().zip(known) {
        let errors: Vec<f64> = of(method).iter().map(error_at_the_end).collect();
        for (k, (error, known)) in errors.iter().zip(known).enumerate() {
            let mesh = ["5 × 32", "10 × 64"][k];
            let what =
                format!("{}, {mesh}: error of the torque at 20° against {known:e} (relative)", method.name);
            findings
                .checks
                .push(Check::new(what, (error / known - 1.0).abs(), 0.06).remark(format!("{error:+.2e}")));
        }
        let cell = |k: usize| {
            let order = |k: usize| fixed((errors[k - 1] / errors[k]).abs().log2(), 1);
            if let Err(reason) = &of(method)[k].outcome {
                return reason.to_string();
            }
            format!("{:+.2e}{}", errors[k], if k > 0 { format!(" ({})", order(k)) } else { String::new() })
        };
        measured.push([method.name.to_owned()].into_iter().chain((0..errors.len()).map(cell)));
    }
    findings.tables.push(measured);
    for method in [CPDI1, CPDI2Q] {
        let [radius, angle] = off_profile(&of(&method)[1].history)?;
        findings.checks.push(
            Check::new(
                format!("{}, 10 × 64: radius of the points at 20° against the profile", method.name),
                radius,
                2e-2,
            )
            .remark(scientific(radius, 2)),
        );
        findings.checks.push(
            Check::new(
                format!(
                    "{}, 10 × 64: rotation of the points at 20° against the profile (degrees)",
                    method.name
                ),
                angle,
                0.25,
            )
            .remark(scientific(angle, 2)),
        );
    }
    Ok(findings)
}

/// Relative error of the torque at 20°.
fn error_at_the_end(run: &Run) -> f64 {
    match &run.outcome {
        Ok(_) => torque(&run.history).last().map_or(f64::NAN, |t| t / EXACT_AT_20 - 1.0),
        Err(_) => f64::NAN,
    }
}

/// Largest difference of a point's radius and rotation (degrees) from the profile at 20°.
fn off_profile(history: &History) -> Result<[f64; 2], Broken> {
    let table = Reference::read("doughnut_elastic_profile_20deg")?;
    let (rest, radius, rotation) = (table.column("R")?, table.column("r")?, table.column("rotation_deg")?);
    let (first, last) = (&history.rows()[0].positions, &history.last().positions);
    let mut worst = [0.0_f64; 2];
    for (x, y) in first.chunks_exact(3).zip(last.chunks_exact(3)) {
        let at = x[0].hypot(x[1]);
        let Some(k) = (1..rest.len()).find(|&k| rest[k] >= at) else { continue };
        let t = (at - rest[k - 1]) / (rest[k] - rest[k - 1]);
        if t < 0.0 {
            continue;
        }
        let expected = |column: &[f64]| column[k - 1] + t * (column[k] - column[k - 1]);
        let turned = (x[0] * y[1] - x[1] * y[0]).atan2(x[0] * y[0] + x[1] * y[1]).to_degrees();
        worst[0] = worst[0].max((y[0].hypot(y[1]) - expected(&radius)).abs());
        worst[1] = worst[1].max((turned - expected(&rotation)).abs());
    }
    Ok(worst)
}
