//! The tangent against differences of the internal force.

use super::largest;
use crate::probe::{Probe, plane, solid};
use crate::quasi_random::QuasiRandom;
use crate::scenes::load_own;
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_grid::Vector;
use mpm_solver::Model;

pub(super) const CASE: Case = Case {
    name: "tangent",
    goal: "The assembled tangent is the derivative of the internal force.",
    setup: "Blocks of a von Mises metal in the plane and in space, graded cells, points not aligned with them; displaced by random nodal values: at rest, from rest, and once more from the state so reached, elastic and plastic points together.",
    reference: "K v against central differences of the internal force in random directions v (step 10⁻⁶ of unit directions).",
    run,
};

/// Directions tried in each state.
const DIRECTIONS: usize = 8;

fn run(_: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    checks.extend(states::<2>("plane", plane(&load_own("block_plane")?)?)?);
    checks.extend(states::<3>("space", solid(&load_own("block_solid")?)?)?);
    Ok(checks.into())
}

fn states<const D: usize>(space: &str, model: Model<D>) -> Result<Vec<Check>, Broken> {
    let mut random = QuasiRandom::new(7);
    let mut probe = Probe::of(model)?;
    let n = probe.n_nodes();
    let what = |state: &str| format!("K v against differences, {space}, {state}");

    let rest = vec![Vector::zeros(); n];
    let mut checks = vec![Check::new(what("undeformed"), worst(&probe, &rest, &mut random)?, 1e-6)];

    let first = random.field(n, 0.012);
    checks.push(Check::new(what("first step"), worst(&probe, &first, &mut random)?, 1e-6));
    probe.advance(&first)?;
    let plastic = probe.points().iter().filter(|point| point.plastic).count();
    let of = probe.points().len();
    checks.push(
        Check::none(
            format!("{space}: lack of plastic points, or of elastic ones"),
            usize::from(plastic < of / 10) + usize::from(plastic > of - of / 10),
        )
        .remark(format!("{plastic} of {of} points plastic")),
    );

    let second = random.field(probe.n_nodes(), 0.012);
    checks.push(Check::new(what("second step"), worst(&probe, &second, &mut random)?, 1e-6));
    Ok(checks)
}

/// Largest error of `K v`, relative to its size.
fn worst<const D: usize>(
    probe: &Probe<D>,
    increment: &[Vector<D>],
    random: &mut QuasiRandom,
) -> Result<f64, Broken> {
    let h = 1e-6;
    let mut errors = Vec::new();
    for _ in 0..DIRECTIONS {
        let v = random.field::<D>(probe.n_nodes(), 1.0);
        let moved = |by: f64| -> Vec<Vector<D>> { increment.iter().zip(&v).map(|(u, v)| u + v * by).collect() };
        let (forward, backward) = (probe.internal(&moved(h))?, probe.internal(&moved(-h))?);
        let product = probe.tangent_times(increment, &v)?;
        let size = product.iter().map(|x| x.norm_squared()).sum::<f64>().sqrt();
        let error: f64 = (forward.iter().zip(&backward).zip(&product))
            .map(|((f, b), k)| ((f - b) / (2.0 * h) - k).norm_squared())
            .sum();
        errors.push(error.sqrt() / size);
    }
    Ok(largest(errors))
}
