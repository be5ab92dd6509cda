//! Boundary value problems of soil against closed forms and limit loads.

mod at_rest;
pub(super) mod cavity;
mod circle;
mod column;
mod footing;
mod limits;

pub(super) use at_rest::CASE as AT_REST;
pub(super) use cavity::{INFINITE, RING};
pub(super) use circle::CASE as CIRCLE;
pub(super) use column::CASE as COLUMN;
pub(super) use footing::{CLAY, HEAVY, SAND};
pub(super) use limits::{CUT, SLOPE, WALL};

use super::newton_rate::slopes;
use crate::history::History;
use crate::scenes::{changed, text};
use crate::{Broken, Check};
use mpm_scene::language::Scene;

/// A scene of `scenes/soil` with other values, each a path and what stands there.
fn scene(name: &str, changes: &[(&str, String)]) -> Result<Scene, Broken> {
    changed(text(&format!("soil/{name}"))?, changes)
}

/// Newton iterations of all load steps.
fn iterations(history: &History) -> f64 {
    history.series("newton_iterations", 0).iter().sum()
}

/// Residuals below this are round-off, above [`NEAR`] yielding still spreads.
const ROUND_OFF: f64 = 1e-13;
const NEAR: f64 = 1e-2;
/// Where round-off begins if the stiffness is 10⁴ to 10⁵ times the strength: forces that balance are differences of
/// elastic forces, which are as much larger.
const STIFF: f64 = 2e-12;

/// Slope of the residuals in the median of all load steps that have one; `None` where none has.
fn newton(name: &str, history: &History) -> Option<Check> {
    median(name, slopes(history, ROUND_OFF..NEAR))
}

/// As [`newton`], at limit loads: slopes over the last three residuals below [`NEAR`] the first two of which can tell a slope
/// of 1.9, because the third would be above round-off.
fn newton_at_limit(name: &str, history: &History) -> Option<Check> {
    let mut slopes = Vec::new();
    for row in history.rows() {
        let near: Vec<f64> = row.residuals.iter().filter(|r| **r < NEAR).map(|r| r.ln()).collect();
        let tells = |it: &&[f64]| it[1] + 1.9 * (it[1] - it[0]) >= STIFF.ln();
        if let Some(&[a, b, c]) = near.windows(3).rev().find(tells) {
            slopes.push((c - b) / (b - a));
        }
    }
    median(name, slopes)
}

/// The median of slopes against 1.9.
fn median(name: &str, mut slopes: Vec<f64>) -> Option<Check> {
    slopes.sort_by(f64::total_cmp);
    let median = *slopes.get(slopes.len() / 2)?;
    let fast = slopes.iter().filter(|slope| **slope >= 1.9).count();
    let said = format!("median {median:.2}; at least 1.9 in {fast} of {} load steps", slopes.len());
    let what = format!("{name}: slope of Newton's residuals, lack below 1.9");
    Some(Check::new(what, (1.9 - median).max(0.0) + 0.0 * median, 0.0).remark(said))
}
