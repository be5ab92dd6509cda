//! A screw pile in clay.

use super::{of_tool, scene};
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

pub(in crate::cases) const INSTALLED: Case = Case {
    name: "screw pile installed and pulled",
    goal: "A screw pile goes through whole turns under an overburden: its torque stays near the closed form's terms, the crowd force falls with the ratio of advance to pitch, and what it bears when pulled is told beside the torque.",
    setup: "validation/scenes/contact/screw_pile_turns.ron: the pile and the mesh of the case before, E = 200 s_u, an overburden of s_u, mean dilatation over points, load steps of 2.5°; two turns with a ratio of 1, one with others, then pulled by 0.2, half of the pitch. The quick run turns by 10° in two steps and pulls by 0.005.",
    reference: "The terms of the torque of the case before. Perko's empirical ratio of capacity to torque, K_t = 1433/d^0.92 in 1/m with the shaft's diameter d in mm: 2.8 for 880 mm; it is of piles that are installed with a ratio of 1, in soils of all kinds, and no check.",
    run: installed,
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

/// Ratios of advance to pitch, and how far the pile is turned `[degrees]`.
const RATIOS: [(f64, f64); 4] = [(0.6, 360.0), (0.8, 360.0), (1.0, 720.0), (1.2, 360.0)];

/// Largest departure of the torque's mean over a quarter of a turn from the sum of the terms, relative.
const TORQUE_OFF: f64 = 0.4;

/// What an installation tells.
struct Installed {
    /// Angle `[degrees]`, torque `[F L]`, crowd force `[F]` and area `[L²]` of every load step of the turn.
    turned: Vec<[f64; 4]>,
    /// Largest downward force of the clay on the pile while it is pulled `[F]`.
    uplift: f64,
}

impl Installed {
    /// The pile turned by `degrees` in some load steps, with an advance of `ratio` pitches a turn; then pulled by `pull`.
    fn by(ratio: f64, (degrees, steps): (f64, u32), (pull, pulls): (f64, u32)) -> Result<Self, Broken> {
        let advance = -PITCH * ratio * degrees / 360.0;
        let stages = format!(
            "[(name: \"rest\", steps: 1), (name: \"turn\", steps: {steps}), (name: \"pull\", steps: {pulls})]"
        );
        let changes = [
            ("tools[0].motion.by", format!("(0, 0, {advance})")),
            ("tools[0].motion.turn.angle", (-degrees).to_string()),
            ("tools[0].motion.then[0].by", format!("(0, 0, {pull})")),
            ("schedule.stages", stages),
            ("output", "(fields: [])".to_owned()),
        ];
        let history = run(&scene("screw_pile_turns", &changes)?)?.completed()?;
        let of = |column: &str, component: usize| of_tool(&history, "pile", column, component);
        let (angle, torque, force, area) = (of("angle", 0), of("moment", 2), of("force", 2), of("area", 0));
        let stage = |from: f64| {
            let rows = history.rows().iter().enumerate();
            rows.filter(move |(_, row)| row.fraction > from && row.fraction <= from + 1.0).map(|(row, _)| row)
        };
        Ok(Self {
            turned: stage(1.0).map(|row| [-angle[row], torque[row], force[row], area[row]]).collect(),
            uplift: stage(2.0).map(|row| -force[row]).fold(0.0, f64::max),
        })
    }

    /// Means of torque and crowd force between two angles `[degrees]`.
    fn means(&self, from: f64, to: f64) -> [f64; 2] {
        let rows: Vec<&[f64; 4]> =
            self.turned.iter().filter(|row| row[0] > from + 1e-9 && row[0] <= to + 1e-9).collect();
        [1, 2].map(|column| rows.iter().map(|row| row[column]).sum::<f64>() / rows.len() as f64)
    }
}

fn installed(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let sum: f64 = terms().iter().sum();
    let mut table = Table::new(
        "Means over parts of a turn; what the pile bears when it is pulled, over the torque of the last part:",
        &["advance over pitch", "turned", "torque", "over the terms", "crowd force", "uplift", "K_t"],
    );
    let (mut areas, mut off, mut crowds) = (0.0_f64, 0.0_f64, Vec::new());
    for &(ratio, degrees) in extent.pick(&[(0.6, 10.0), (1.0, 10.0)][..], &RATIOS[..]) {
        let (part, steps) = extent.pick((10.0, 2), (90.0, (degrees / 2.5) as u32));
        let pile = Installed::by(ratio, (degrees, steps), extent.pick((0.005, 1), (0.2, 40)))?;
        areas = areas.max(largest(pile.turned.iter().map(|row| (row[3] / area() - 1.0).abs())));
        for last in 1..=(degrees / part) as u32 {
            let to = f64::from(last) * part;
            let [torque, crowd] = pile.means(to - part, to);
            off = off.max((torque / sum - 1.0).abs());
            let ends = to > degrees - 1e-9;
            let at_end = |number: f64, digits| if ends { fixed(number, digits) } else { String::new() };
            table.push([
                ratio.to_string(),
                format!("{} to {to}°", to - part),
                fixed(torque, 1),
                fixed(torque / sum, 2),
                fixed(crowd, 0),
                at_end(pile.uplift, 0),
                at_end(pile.uplift / torque, 2),
            ]);
        }
        // By the same angle all ratios have gone through as much clay along the thread.
        crowds.push(pile.means(0.0, extent.pick(10.0, 360.0))[1]);
    }
    let falls = crowds.windows(2).filter(|pair| pair[0] >= pair[1]).count();
    findings.checks.extend([
        Check::new("area of the surface in the clay, all load steps, relative", areas, 5e-2),
        Check::new(
            "torque over a part of a turn against the sum of the terms, relative, largest",
            off,
            TORQUE_OFF,
        )
        .remark(fixed(sum, 2)),
        Check::new("larger advances with no larger crowd force", falls as f64, 0.0),
    ]);
    findings.tables.push(table);
    Ok(findings)
}
