//! A sphere on an elastic block.

use super::{of_tool, scene, written};
use crate::cases::fixed;
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};

pub(in crate::cases) const CASE: Case = Case {
    name: "sphere on a block",
    goal: "In space, by a quarter, force of a contact that grows as it is pressed (Hertz).",
    setup: "A quarter of a rigid, smooth sphere, R = 4, pressed by 0.01 into an elastic block of half width 4 and depth 4 between smooth rigid sides, E = 10⁶, ν = 0.3; 8, 10, and 12 cells in each direction, each longer than the one nearer to the contact, the last 30 times the first: 4 to 5.5 of them over the contact's radius of 0.2. 2³ points a cell, CPDI1.",
    reference: "δ = (9 F²/(16 E*² R))^(1/3) + κF: the half space's indentation by a paraboloid, and κ = −0.1087/E*, by which the block's deflection under a point load differs next to that from the half space's, by a double cosine series of a layer. Small strains.",
    run: sphere,
};

/// E* = E/(1 - ν²).
const MODULUS: f64 = 1e6 / 0.91;
/// Radius of the sphere, and by how much it is pressed.
const RADIUS: f64 = 4.0;
const INDENTATION: f64 = 0.01;
/// Half width and depth of the block.
const SIZE: f64 = 4.0;
/// Last cell over the first.
const RATIO: f64 = 30.0;

/// κE*, worked out apart: the sum of `C(kh) 2/(k (2L)²)` over all wave vectors k of a block of half width L and depth h = L,
/// `C = (cosh 2kh - 1)/(sinh 2kh + 2kh)`, and of `h (1 - 2ν)/((1 - ν)² (2L)²)` for k = 0, less the half space's, both under a
/// Gaussian load that shrinks to a point.
const COMPLIANCE: f64 = -0.108713;

/// Force under an indentation.
fn force(indentation: f64) -> f64 {
    let half_space = |indentation: f64| 4.0 / 3.0 * MODULUS * (RADIUS * indentation.powi(3)).sqrt();
    // The block's part is small, and the iteration contracts.
    (0..60).fold(half_space(indentation), |force, _| half_space(indentation - force * COMPLIANCE / MODULUS))
}

/// Cells that grow from 0 to the size of the block.
fn cells(count: i32) -> Vec<f64> {
    let growth = RATIO.powf(1.0 / f64::from(count - 1));
    (0..=count).map(|k| SIZE * (growth.powi(k) - 1.0) / (growth.powi(count) - 1.0)).collect()
}

fn sphere(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let text = "Force on the whole sphere over the reference, by load steps:";
    let mut table = Table::new(text, &["cells", "over the contact's radius", "1", "2", "3", "4"]);
    let mut means = Vec::new();
    for (count, tolerance) in extent.pick(&[(8, 0.1)][..], &[(8, 0.1), (10, 0.06), (12, 0.04)]) {
        let across = cells(*count);
        let up = across.iter().rev().map(|x| -x).chain([across[1]]);
        let axes = format!("Box(axes: [{0}, {0}, {1}])", written(across.clone()), written(up));
        let history = run(&scene("sphere", &[("mesh", axes)])?)?.completed()?;
        let parts: Vec<f64> = history
            .rows()
            .iter()
            .zip(of_tool(&history, "sphere", "force", 2))
            .skip(1)
            .map(|(row, quarter)| 4.0 * quarter / force(INDENTATION * row.fraction))
            .collect();
        // As the contact grows over one corner after the other, the force swings about its mean.
        let mean = parts[1..].iter().sum::<f64>() / (parts.len() - 1) as f64;
        let what = format!("{count} cells: force, mean of the last three load steps, relative");
        findings.checks.push(Check::new(what, (mean - 1.0).abs(), *tolerance).remark(fixed(mean, 4)));
        let over = fixed((RADIUS * INDENTATION).sqrt() / across[1], 1);
        table.push([count.to_string(), over].into_iter().chain(parts.iter().map(|part| fixed(*part, 4))));
        means.push((across[1], mean));
    }
    if let [(wide, coarse), _, (narrow, fine)] = means[..] {
        let limit = fine - narrow * narrow * (coarse - fine) / (wide * wide - narrow * narrow);
        let what = "force extrapolated with order two from 8 and 12 cells, relative";
        findings.checks.push(Check::new(what, (limit - 1.0).abs(), 2e-2).remark(fixed(limit, 4)));
    }
    findings.tables.push(table);
    Ok(findings)
}
