//! A strip that a frame rolls up.

use super::super::largest;
use crate::scenes::{changed, run};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_solver::observe::Field;

pub(in crate::cases) const STRIP: Case = Case {
    name: "rolled cantilever",
    goal: "A strip is rolled up to five sixths of a circle by a moment at its end, and back: the strip is straight again, and the moment is that of the slender beam.",
    setup: "A strip of 16 by 0.5, E = 1200, ν = 0, on splines of degree 2, clamped at one end; a frame that is free to move and turn holds the other one and has the moment E I 5π/(3·16), which then falls to nothing. 4 and 8 tiles through the height. (Ends that meet in cells of the mesh would stick to each other: the circle stays open.)",
    reference: "M = E I κ. Strain is the same all over a tile, so that n tiles through the height have I (1 − 1/n²).",
    run: strips,
};

/// A strip of 16 by 0.5 that a frame rolls up and lets go of again.
const STRIP_SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: -4.63, to: 17.12, cells: 87), Uniform(from: -0.88, to: 12.62, cells: 54)], functions: Splines(degree: 2)),
    basis: Cpdi2q, stabilisation: Ghost(factor: 1e-5), materials: { "steel": Hencky(young: 1200, poisson: 0) },
    bodies: [(name: "strip", material: "steel", shape: Box(from: (0, 0), to: (16, 0.5)), points_per_cell: 2, tiling: Shape)],
    walls: [
        (name: "clamp", body: "strip", side: "left", hold: All),
        (name: "tip", body: "strip", side: "right", hold: All, moment_about: (16, 0.25),
            motion: Loaded(free: [X, Y, Turn], moment: 4.090615434361711, ramp: [(0, 0), (0.5, 1), (1, 0)])),
    ],
    schedule: (steps: 64), output: (fields: [CauchyStress]),
)"#;

/// The largest angle of the frame `[degrees]`, and how far the tip and the stress are from those at rest at the end.
fn strip(points_per_cell: u32) -> Result<[f64; 3], Broken> {
    let changes = [("bodies[0].points_per_cell", points_per_cell.to_string())];
    let history = run(&changed(STRIP_SCENE.into(), &changes)?)?.completed()?;
    let angles = history.series("wall/tip/angle", 0);
    let last = history.rows().len() - 1;
    let tip = [0, 1].map(|d| history.series("wall/tip/position", d)[last]);
    let stress = largest(history.field(Field::CAUCHY_STRESS, last).iter().map(|s| s.abs()));
    Ok([largest(angles), (tip[0] - 16.0).hypot(tip[1] - 0.25), stress])
}

fn strips(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    for points in extent.pick(&[2][..], &[2, 4]) {
        let [angle, away, stress] = strip(*points)?;
        let n = f64::from(2 * points);
        let expected = 300.0 / (1.0 - 1.0 / (n * n));
        let name = format!("{n} tiles through the height");
        findings.checks.push(
            Check::new(format!("{name}: angle at the full moment"), (angle / expected - 1.0).abs(), 0.02)
                .remark(format!("{angle:.1}° for {expected:.1}°")),
        );
        findings.checks.push(Check::new(
            format!("{name}: the tip is back, over the length"),
            away / 16.0,
            1e-4,
        ));
        findings.checks.push(Check::new(format!("{name}: stress that is left, over E"), stress / 1200.0, 2e-4));
    }
    Ok(findings)
}
