//! The same problem in other units.

use super::{run_plane, scene};
use crate::history::Row;
use crate::variants::{ALL, CPDI1, GIMP, Method, PlaneScene};
use crate::{Broken, Case, Check, Extent, Findings};

pub(super) const UNITS: Case = Case {
    name: "units",
    goal: "Nothing in the code has a length, a force or a time of its own.",
    setup: "The collapse (GIMP refused where it does not suit) with all lengths times 2^a and all forces per length times 2^b, a from -40 to 40, b even (Cholesky's roots of odd powers of two round); ghost stabilisation on.",
    reference: "The positions over 2^a, bit for bit, and as many iterations.",
    run: units,
};

fn block(length: f64, force: f64) -> Result<PlaneScene, Broken> {
    let at = |x: f64| format!("{:e}", x * length);
    scene(&format!(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: {w}, cells: 12), Uniform(from: 0, to: {h}, cells: 6)]),
            basis: Smpm,
            stabilisation: Ghost(),
            materials: {{ \"clay\": VonMises(young: {young:e}, poisson: 0.3, yield_radius: {strength:e}, density: {density:e}) }},
            bodies: [(name: \"block\", material: \"clay\", shape: Box(from: (0, 0), to: ({b}, {b})), points_per_cell: 2)],
            supports: [
                (name: \"base\", region: Plane(axis: Y, at: 0), fix: [Y]),
                (name: \"symmetry\", region: Plane(axis: X, at: 0), fix: [X]),
            ],
            loads: [BodyForce(acceleration: (0, -8))],
            schedule: (steps: 10),
            output: (fields: []),
        )",
        w = at(12.0),
        h = at(6.0),
        b = at(6.0),
        young = 1048576.0 * force / (length * length),
        strength = 16384.0 * force / (length * length),
        // Weight per volume is force per length³.
        density = 1024.0 * force / (length * length * length),
    ))
}

fn units(extent: Extent) -> Result<Findings, Broken> {
    let methods: &[Method] = extent.pick(&[GIMP, CPDI1], &ALL);
    let scales: &[(i32, i32)] = extent
        .pick(&[(-10, 0), (10, 20)], &[(-40, 0), (-10, 0), (10, 0), (40, 0), (0, 30), (10, -20), (-20, 8)]);
    let mut findings = Findings::default();
    for method in methods {
        let told = |row: &Row, scale: f64| -> Vec<u64> {
            row.positions.iter().map(|x| (x / scale).to_bits()).collect()
        };
        let reference = run_plane(method_of(method, block(1.0, 1.0)?))?;
        for &(a, b) in scales {
            let (length, force) = (2_f64.powi(a), 2_f64.powi(b));
            let run = run_plane(method_of(method, block(length, force)?))?;
            let same = |(x, y): (&Row, &Row)| {
                told(x, 1.0) == told(y, length) && x.residuals.len() == y.residuals.len()
            };
            let rows = reference.history.rows().iter().zip(run.history.rows());
            let differing = reference.history.rows().len().abs_diff(run.history.rows().len())
                + rows.filter(|pair| !same(*pair)).count();
            findings.checks.push(Check::none(
                format!("{}, lengths times 2^{a}, forces times 2^{b}: load steps that differ", method.name),
                differing,
            ));
        }
    }
    Ok(findings)
}

/// With the basis, and the stabilisation that the scene has.
fn method_of(method: &Method, scene: PlaneScene) -> PlaneScene {
    method.of(scene)
}
