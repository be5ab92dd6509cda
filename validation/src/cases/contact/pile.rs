//! A screw pile in clay.

use super::of_tool;
use crate::cases::{fixed, largest};
use crate::history::History;
use crate::scenes::{changed, run, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::{PI, TAU};

pub(in crate::cases) const CASE: Case = Case {
    name: "screw pile",
    goal: "The surface of a shaft with a helical plate is counted once and whole while it is screwed in, and the torque comes up to that of a closed form's terms.",
    setup: "The first 10 degrees of scenes/screw_pile.ron in 5 load steps: a shaft of R_s = 0.44, 2.4 long, a plate of one turn with R_h = 0.85, t = 0.2 and pitch 0.4, which advances by a pitch per turn, in clay of s_u = 20, E = 500 s_u, α = s_u/2; a ring mesh of 12 sectors at rest, cells of 0.14 to 0.25 across and 0.2 along: no more than one cell over the thickness of the plate. 5408 points. The quick run is the first step.",
    reference: "Area of cylinder and helicoid, with the round rim and ends. Torque: shaft 2πR_s²Lα, faces 4/3 π(R_h³ − R_s³)α, rim π²tR²α with R = R_h + t/π, leading edge about N_c s_u t(R_h² − R_s²)/2, N_c = 7.5: an estimate for an edge in the middle of unbounded clay, no bound and no published number.",
    run: pile,
};

const SHAFT: f64 = 0.44;
const PLATE: f64 = 0.85;
const THICKNESS: f64 = 0.2;
const PITCH: f64 = 0.4;
const DEPTH: f64 = 2.4;
const ADHESION: f64 = 10.0;
const STRENGTH: f64 = 20.0;

/// Angles at which the torque is compared `[degrees]`, and tolerances: what the edge meets grows as the clay before it is strained.
const ROWS: [(f64, f64); 3] = [(2.0, 0.1), (6.0, 0.15), (10.0, 0.25)];

/// Length of a turn of the helicoid's line at a radius.
fn turn(radius: f64) -> f64 {
    (TAU * radius).hypot(PITCH)
}

/// Length of the shaft that the plate does not cover.
fn bare() -> f64 {
    DEPTH - THICKNESS * turn(SHAFT) / (TAU * SHAFT)
}

/// Radius at the middle of the round rim.
fn rim() -> f64 {
    PLATE + THICKNESS / PI
}

/// The area of the pile in the clay.
fn area() -> f64 {
    let strips = 200;
    let width = (PLATE - SHAFT) / f64::from(strips);
    let face: f64 = (0..strips).map(|k| turn(SHAFT + (f64::from(k) + 0.5) * width) * width).sum();
    let round = 0.5 * PI * THICKNESS;
    TAU * SHAFT * bare() + 2.0 * face + round * turn(rim()) + 2.0 * round * (PLATE - SHAFT)
}

/// Torque of shaft, faces, rim, and leading edge.
fn terms() -> [f64; 4] {
    let faces = 4.0 / 3.0 * PI * (PLATE.powi(3) - SHAFT.powi(3)) * ADHESION;
    let edge = 7.5 * STRENGTH * THICKNESS * 0.5 * (PLATE * PLATE - SHAFT * SHAFT);
    [TAU * SHAFT * SHAFT * bare() * ADHESION, faces, PI * PI * THICKNESS * rim().powi(2) * ADHESION, edge]
}

/// The pile turned by an angle in some steps.
fn screwed(degrees: f64, steps: u32) -> Result<History, Broken> {
    let advance = -PITCH * degrees / 360.0;
    let changes = [
        ("tools[0].motion.by", format!("(0, 0, {advance})")),
        ("tools[0].motion.turn.angle", (-degrees).to_string()),
        ("schedule.steps", steps.to_string()),
        ("output", "(fields: [])".to_owned()),
    ];
    run(&changed(text("screw_pile")?, &changes)?)?.completed()
}

fn pile(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let (degrees, steps) = extent.pick((2.0, 1), (10.0, 5));
    let history = screwed(degrees, steps)?;
    let of = |column: &str, component: usize| of_tool(&history, "pile", column, component);
    let (areas, torque, crowd) = (of("area", 0), of("moment", 2), of("force", 2));
    let deepest = of("deepest", 0);
    let off = areas[1..].iter().map(|found| (found / area() - 1.0).abs());
    findings.checks.push(
        Check::new("area of the surface in the clay, all load steps, relative", largest(off), 2e-2)
            .remark(fixed(area(), 4)),
    );
    let sum: f64 = terms().iter().sum();
    let mut table = Table::new(
        "Torque and vertical force of the clay on the pile, and the terms of the torque:",
        &["turned", "torque", "vertical force", "deepest", "shaft", "faces", "rim", "edge", "sum"],
    );
    for &(wanted, tolerance) in extent.pick(&ROWS[..1], &ROWS[..]) {
        let row = history.rows().iter().position(|row| row.fraction * degrees > wanted - 1e-9);
        let of_row = |column: &[f64]| row.and_then(|row| column.get(row)).copied().unwrap_or(f64::NAN);
        let (found, force) = (of_row(&torque), of_row(&crowd));
        let what = format!("torque after {wanted}° against the sum of the terms, relative");
        let check = Check::new(what, (found / sum - 1.0).abs(), tolerance);
        findings.checks.push(check.remark(fixed(found, 2)));
        let numbers = [found, force].into_iter().map(|it| fixed(it, 2));
        let terms = terms().into_iter().chain([sum]).map(|it| fixed(it, 2));
        let deepest = fixed(of_row(&deepest), 3);
        table.push([format!("{wanted}°")].into_iter().chain(numbers).chain([deepest]).chain(terms));
    }
    findings.tables.push(table);
    Ok(findings)
}
