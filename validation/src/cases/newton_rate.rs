//! How fast Newton's iteration closes in.

use super::largest;
use crate::history::History;
use crate::scenes::{load, load_own, run};
use crate::{Broken, Case, Check};
use mpm_solver::observe::Field;

pub(super) const CASE: Case = Case {
    name: "Newton's rate",
    goal: "Newton's iteration converges quadratically, so the tangent is the consistent one.",
    setup: "The simple stretch with free sides, and the pulled block (12 × 12 cells between rough plates, plastic in places) with its tolerance set below round-off.",
    reference: "Two to five iterations in every plastic load step of the stretch, each ending below 10⁻⁹; slope 2 of the residual against the one before it, both logarithmic, down to round-off.",
    run: rate,
};

/// Residuals from here on are still quadratic; below `ROUND_OFF` they are not any more.
const NEAR: f64 = 1e-1;
const ROUND_OFF: f64 = 1e-13;

fn rate() -> Result<Vec<Check>, Broken> {
    let stretch = run(&load("simple_stretch")?)?.completed()?;
    let iterations = stretch.series("newton_iterations", 0);
    let plastic: Vec<usize> =
        (1..iterations.len()).filter(|&row| stretch.field(Field::Plastic, row).contains(&1.0)).collect();
    let outside = plastic.iter().filter(|&&row| !(2.0..=5.0).contains(&iterations[row])).count();
    let counts = plastic.iter().map(|&row| iterations[row]);
    let (fewest, most) = counts.fold((f64::INFINITY, 0.0_f64), |(a, b), n| (a.min(n), b.max(n)));

    let block = run(&load_own("pulled_block")?)?.completed()?;
    Ok(vec![
        Check::none("stretch: plastic load steps outside of 2 to 5 iterations", outside)
            .remark(format!("{fewest} to {most} in {} steps", plastic.len())),
        Check::new("stretch: largest residual at convergence", largest(stretch.series("residual", 0)), 1e-9),
        slope("stretch", &stretch),
        slope("pulled block", &block),
    ])
}

/// Slope of the last usable pair of residuals of every step that has three of them.
fn slope(name: &str, history: &History) -> Check {
    let mut slopes = Vec::new();
    for row in history.rows() {
        let usable: Vec<f64> =
            row.residuals.iter().copied().filter(|&r| r > ROUND_OFF && r < NEAR).map(f64::ln).collect();
        if let [.., a, b, c] = usable[..] {
            slopes.push((c - b) / (b - a));
        }
    }
    let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
    let spread = slopes.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &s| (a.min(s), b.max(s)));
    Check::new(format!("{name}: slope of the residuals against 2"), (mean - 2.0).abs(), 0.2).remark(format!(
        "{mean:.2} ({:.2} to {:.2}) in {} steps",
        spread.0,
        spread.1,
        slopes.len()
    ))
}
