//! A screw pile in sand.

use super::of_tool;
use crate::cases::{fixed, largest};
use crate::scenes::{changed, run, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "screw pile in sand",
    goal: "A screw pile turns and advances in sand with friction on it: what it presses the ground down with stands on the ground's base at every load step, its torque is above that of the friction under the stress at rest, and it bears more when pulled than its friction at rest.",
    setup: "scenes/screw_pile_sand.ron: the pile, mesh and 5408 points of the case `screw pile` (no more than one cell over the thickness of the plate), in the sand of the case `cone in sand` under a surcharge of 20 kPa, friction 0.3 on shaft and plate, advance of a pitch a turn; 40° in 16 load steps of 2.5°, then pulled by 0.1, a quarter of the pitch, in 20. The quick run turns by 2.5° and pulls by 0.005. Beyond 65° most load steps are halved, and a half turn was not reached in an hour on a core that other work shared: what the plate displaces, half of the sand along its thread, is pressed against the wall of this small mesh.",
    reference: "Balance of vertical forces. Friction under the stress at rest, with σ_h = K₀ σ_v on the shaft and σ_v at its depth on both faces of the plate: torque 2πR_s² μ ∫K₀ σ_v dz + (4/3)π(R_h³ − R_s³) μ σ_v, and 2πR_s μ ∫K₀ σ_v dz when pulled; no bound, because turning changes the stress. Perko's empirical ratio of capacity to torque, 2.8 per metre for a shaft of 880 mm, is told beside and not checked, because at this depth of less than 1.5 plate diameters, with a wall at 0.45 from the plate's edge and with one cell over the plate, the numbers are those of this scene alone. Published torques in sand (Davidson et al. 2022, Cerfontaine et al. 2020) are not compared: their tables were not at hand.",
    run: pile,
};

const SHAFT: f64 = 0.44;
const PLATE: f64 = 0.85;
const PITCH: f64 = 0.4;
const GROUND: f64 = 2.4;
/// Height of the plate's middle at the start `[L]`.
const PLATE_AT: f64 = 1.8;
const SURCHARGE: f64 = 20.0;
const UNIT_WEIGHT: f64 = 16.3;
const AT_REST: f64 = 0.47;
const FRICTION: f64 = 0.3;

/// Vertical stress at rest at a height.
fn vertical(height: f64) -> f64 {
    SURCHARGE + UNIT_WEIGHT * (GROUND - height)
}

/// Force of friction along the shaft under the stress at rest.
fn shaft_at_rest() -> f64 {
    2.0 * PI * SHAFT * GROUND * FRICTION * AT_REST * vertical(0.5 * GROUND)
}

/// Torque of friction on shaft and plate under the stress at rest.
fn torque_at_rest() -> f64 {
    let faces = 4.0 / 3.0 * PI * (PLATE.powi(3) - SHAFT.powi(3)) * FRICTION * vertical(PLATE_AT);
    SHAFT * shaft_at_rest() + faces
}

fn pile(extent: Extent) -> Result<Findings, Broken> {
    let (degrees, steps) = extent.pick((2.5, 1), (40.0, 16));
    let (pull, pulls) = extent.pick((0.005, 1), (0.1, 20));
    let advance = -PITCH * degrees / 360.0;
    let stages = format!(
        "[(name: \"rest\", steps: 1), (name: \"turn\", steps: {steps}), (name: \"pull\", steps: {pulls})]"
    );
    let changes = [
        ("tools[0].motion.by", format!("(0, 0, {advance})")),
        ("tools[0].motion.turn.angle", format!("{:?}", -degrees)),
        ("tools[0].motion.then[0].by", format!("(0, 0, {pull})")),
        ("schedule.stages", stages),
        ("output", "(fields: [])".to_owned()),
    ];
    let history = run(&changed(text("screw_pile_sand")?, &changes)?)?.completed()?;
    let of = |column: &str, component: usize| of_tool(&history, "pile", column, component);
    let (torque, force) = (of("moment", 2), of("force", 2));
    let base = history.series("reaction/base", 2);
    let rows = |from: f64| {
        let rows = history.rows().iter().enumerate();
        rows.filter(move |(_, row)| row.fraction > from && row.fraction <= from + 1.0).map(|(row, _)| row)
    };
    // What the base bears besides the pile's force is the weight of the ground and its surcharge, at all load steps.
    let borne: Vec<f64> = base.iter().zip(&force).map(|(base, force)| base - force).skip(1).collect();
    let off = largest(borne.iter().map(|it| (it / borne[0] - 1.0).abs()));
    // Load steps are halved here and there, so that parts are told by the angle.
    let (angle, parts) = (of("angle", 0), extent.pick(1, 4));
    let width = degrees / f64::from(parts);
    let mean_in = |part: u32, of: &[f64]| {
        let (from, to) = (f64::from(part) * width + 1e-9, f64::from(part + 1) * width + 1e-9);
        let rows: Vec<usize> = rows(1.0).filter(|&row| -angle[row] > from && -angle[row] <= to).collect();
        rows.iter().map(|&row| of[row]).sum::<f64>() / rows.len() as f64
    };
    let at_end = mean_in(parts - 1, &torque);
    let uplift = rows(2.0).map(|row| -force[row]).fold(0.0, f64::max);
    let mut table = Table::new(
        "Means over the load steps of parts of the turn; what the pile bears when it is pulled, over the torque of the last part:",
        &["turned", "torque", "over friction at rest", "crowd force", "uplift", "K_t"],
    );
    for part in 0..parts {
        let found = mean_in(part, &torque);
        let told = |number: f64, digits| if part + 1 == parts { fixed(number, digits) } else { String::new() };
        table.push([
            format!("{} to {}°", f64::from(part) * width, f64::from(part + 1) * width),
            fixed(found, 1),
            fixed(found / torque_at_rest(), 2),
            fixed(mean_in(part, &force), 0),
            told(uplift, 0),
            told(uplift / at_end, 2),
        ]);
    }
    let mut findings = Findings::default();
    let what = "force on the base less that on the pile: change from the ground at rest on, relative, largest";
    findings.checks.push(Check::new(what, off, 5e-3));
    // After 2.5 degrees friction is not yet mobilised.
    if extent == Extent::Full {
        let said = format!("{at_end:.1}, {:.1}", torque_at_rest());
        let is_below = usize::from(at_end < torque_at_rest());
        findings.checks.push(Check::none("torque at the end below friction at rest", is_below).remark(said));
        let said = format!("{uplift:.0}, {:.0}", shaft_at_rest());
        let is_below = usize::from(uplift < shaft_at_rest());
        findings.checks.push(Check::none("uplift below friction at rest", is_below).remark(said));
    }
    findings.tables.push(table);
    Ok(findings)
}
