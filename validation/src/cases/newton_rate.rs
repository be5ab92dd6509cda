//! How fast Newton's iteration closes in.

use super::largest;
use crate::history::History;
use crate::scenes::{from_rest, load, load_own, run};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_solver::observe::Field;
use std::ops::Range;

pub(super) const CASE: Case = Case {
    name: "Newton's rate",
    goal: "Newton's iteration converges quadratically, so the tangent is the consistent one.",
    setup: "The simple stretch with free sides, and the pulled block (12 × 12 cells between rough plates, plastic in places) with its tolerance set below round-off; every load step is begun at rest.",
    reference: "Two to five iterations in every plastic load step of the stretch, each ending below 10⁻⁹; slope 2 of the residual against the one before it, both logarithmic, down to round-off.",
    run: rate,
};

/// Residuals below this are round-off.
const ROUND_OFF: f64 = 1e-13;

fn rate(_: Extent) -> Result<Findings, Broken> {
    let stretch = run(&from_rest(load("simple_stretch")?))?.completed()?;
    let iterations = stretch.series("newton_iterations", 0);
    let plastic: Vec<usize> =
        (1..iterations.len()).filter(|&row| stretch.field(Field::PLASTIC, row).contains(&1.0)).collect();
    let outside = plastic.iter().filter(|&&row| !(2.0..=5.0).contains(&iterations[row])).count();
    let counts = plastic.iter().map(|&row| iterations[row]);
    let (fewest, most) = counts.fold((f64::INFINITY, 0.0_f64), |(a, b), n| (a.min(n), b.max(n)));

    let block = run(&from_rest(load_own("pulled_block")?))?.completed()?;
    Ok(vec![
        Check::none("stretch: plastic load steps outside of 2 to 5 iterations", outside)
            .remark(format!("{fewest} to {most} in {} steps", plastic.len())),
        Check::new("stretch: largest residual at convergence", largest(stretch.series("residual", 0)), 1e-9),
        slope("stretch", &stretch, 1e-1, 0.05),
        slope("pulled block", &block, 1e-2, 0.3),
    ]
    .into())
}

/// Slopes of `ln r_{k+1}` against `ln r_k` over the last residuals of every load step that has three in a range:
/// above it yielding still spreads, and below it is round-off, and there is no rate.
pub(super) fn slopes(history: &History, range: Range<f64>) -> Vec<f64> {
    let mut slopes = Vec::new();
    for row in history.rows() {
        let usable = row.residuals.iter().filter(|r| range.contains(*r));
        if let [.., a, b, c] = usable.map(|r| r.ln()).collect::<Vec<_>>()[..] {
            slopes.push((c - b) / (b - a));
        }
    }
    slopes
}

/// The slope that is farthest from 2.
fn slope(name: &str, history: &History, near: f64, tolerance: f64) -> Check {
    let slopes = slopes(history, ROUND_OFF..near);
    let error =
        if slopes.is_empty() { f64::NAN } else { largest(slopes.iter().map(|slope| (slope - 2.0).abs())) };
    let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
    Check::new(format!("{name}: slope of the residuals against 2, worst load step"), error, tolerance)
        .remark(format!("mean {mean:.3} of {} steps", slopes.len()))
}
