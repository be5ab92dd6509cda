//! Ground in geostatic balance.

use super::{iterations, scene};
use crate::cases::{largest, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_solver::observe::Field;

pub(in crate::cases) const CASE: Case = Case {
    name: "ground at rest",
    goal: "Ground in geostatic balance does not move, whatever its law.",
    setup: "Ground of 6 × 10, 4 × 8 cells, 2² points a cell, γ = 20, K₀ = 0.6 (0.7 with Cam-Clay, over-consolidated 1.5 times), weight acting from the start, 4 load steps; Hencky, Mohr–Coulomb and Drucker–Prager without cohesion, Mohr–Coulomb with pore fluid, von Mises and Tresca with a strength that grows with depth, Cam-Clay; standard MPM, GIMP, CPDI1, CPDI2q, CPDI2t.",
    reference: "No displacement, and no out-of-balance force, without any iteration.",
    run: at_rest,
};

const LAWS: [&str; 7] =
    ["hencky", "mohr_coulomb", "with_water", "drucker_prager", "von_mises", "tresca", "cam_clay"];
const BASES: [&str; 5] = ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];

fn at_rest(_: Extent) -> Result<Findings, Broken> {
    let checks = sweep(&LAWS, |law| {
        let (mut motion, mut residual, mut unsolved) = (0.0_f64, 0.0_f64, 0.0_f64);
        for basis in BASES {
            let mut changes = vec![("bodies[0].material", format!("{law:?}")), ("basis", basis.to_owned())];
            if *law == "cam_clay" {
                let initial = "Geostatic(surface: 10, unit_weight: 20, k0: 0.7, over_consolidation: 1.5)";
                changes.push(("bodies[0].initial", initial.to_owned()));
            }
            let history = run(&scene("at_rest", &changes)?)?.completed()?;
            let last = history.rows().len() - 1;
            let moved = history.field(Field::DISPLACEMENT, last).iter().map(|u| u.abs());
            unsolved += iterations(&history);
            let residuals = history.series("residual", 0).into_iter();
            (motion, residual) = (largest(moved.chain([motion])), largest(residuals.chain([residual])));
        }
        let of = |what: &str| format!("{}: {what}, all bases", law.replace('_', " "));
        Ok([
            Check::new(of("largest displacement over the height"), motion / 10.0, 1e-12),
            Check::new(of("Newton iterations"), unsolved, 0.0),
            Check::new(of("out-of-balance force without them"), residual, 1e-12),
        ])
    })?;
    Ok(checks.into_iter().flatten().collect::<Vec<_>>().into())
}
