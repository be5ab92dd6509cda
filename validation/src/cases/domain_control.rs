//! Domains that outgrow their cells in the shear band of a ring at its limit load.

use super::largest;
use crate::history::History;
use crate::scenes::{load, run};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_solver::scene::{ControlInput, Positive, Scene};
use std::f64::consts::{PI, SQRT_2};

pub(super) const CASE: Case = Case {
    name: "domains under large shear",
    goal: "Domains that outgrow their cells do not add to the limit load, once they are shortened, reshaped or split; the mean torque stays at the limit however far the ring is turned.",
    setup: "The doughnut twist with ρ_y = 1e4 on 5 × 32 cells, CPDI1, to 180° in 180 load steps: shear of 17 in the innermost row of cells; `Cap`, `Reshape` and `Split` at 0.7 cells, and none of them.",
    reference: "The discrete limit torque 2π (R_i + h/2)² ρ_y/√2, in the mean over the degrees from 1 to 180. At single degrees the torque swings about it with every basis, standard MPM included (0.81 to 1.27 of the limit): the pressures of points that share a cell are hardly coupled, and with ν = -0.9 the swings of standard MPM shrink to 7 %.",
    run: large_shear,
};

/// `2π (R_i + h/2)² ρ_y/√2`.
const LIMIT: f64 = 2.0 * PI * 5.5 * 5.5 * 1e4 / SQRT_2;

fn large_shear(_: Extent) -> Result<Findings, Broken> {
    let cells = Positive(0.7);
    let plain = torque(&watched(None)?);
    let reshaped = torque(&watched(Some(ControlInput::Reshape { cells }))?);
    let capped = torque(&watched(Some(ControlInput::Cap { cells }))?);
    let history = watched(Some(ControlInput::Split { cells, growth: Positive(16.0) }))?;
    let split = torque(&history);
    let points = history.rows().last().map_or(0, |row| row.positions.len() / 3);
    let swing = |torque: &[f64]| largest(torque.iter().map(|t| (t - 1.0).abs()));
    Ok(Findings::from(vec![
        Check::new("up to 5 degrees, no control, every degree", swing(&plain[..5]), 0.02),
        Check::none("no control: end torque below twice the limit", usize::from(plain[179] < 2.0))
            .remark(format!("{:.2} of the limit", plain[179])),
        mean("Reshape", &reshaped, 0.05),
        Check::new("Reshape: torque against the limit, every degree", swing(&reshaped), 0.2),
        mean("Cap", &capped, 0.05),
        mean("Split", &split, 0.1),
        Check::none("Split: points that are not more than before", usize::from(points <= 640))
            .remark(format!("{points} points")),
    ]))
}

fn mean(name: &str, torque: &[f64], tolerance: f64) -> Check {
    let mean = torque.iter().sum::<f64>() / torque.len() as f64;
    Check::new(format!("{name}: mean torque against the limit"), (mean - 1.0).abs(), tolerance)
        .remark(format!("{mean:.3} of the limit"))
}

fn watched(control: Option<ControlInput>) -> Result<History, Broken> {
    let mut scene = load("doughnut_limit")?;
    if let Scene::PlaneStrain(scene) = &mut scene {
        scene.domains.control = control;
        scene.output.fields.clear();
    }
    run(&scene)?.completed()
}

/// Torque over the limit at every whole degree from 1 on.
fn torque(history: &History) -> Vec<f64> {
    let moments = history.series("reaction_moment/inner", 0);
    let degrees = history.rows().iter().map(|row| row.fraction * 180.0);
    let whole =
        degrees.zip(moments).filter(|(degree, _)| *degree > 0.5 && (degree - degree.round()).abs() < 1e-6);
    whole.map(|(_, moment)| moment / LIMIT).collect()
}
