//! Plough blades in clay, in the plane and in space.

use super::{of_tool, written};
use crate::cases::{fixed, largest};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{changed, run, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::SQRT_2;

pub(in crate::cases) const CASE: Case = Case {
    name: "ploughs",
    goal: "The force on a plough blade in clay: with adhesion, weight, a rake, and in space, where it has ends.",
    setup: "scenes/plough.ron: a blade, H = 1 m, 0.125 m thick, in clay of s_u = 5 kPa, E = 500 s_u, cells of 1/8 m, drawn by 0.5 m in 100 load steps with α = 0, s_u/2 and s_u; by 0.12 m in 24 steps smooth with a rake of 60° and 45°, and in clay of 6 kN/m³. scenes/plough_solid.ron: half of a smooth blade, B = 1, 2 and 4 m wide, 0.25 m thick, in cells of 1/4 m, drawn by 0.05 m in 10 steps. CPDI1, 2² and 2³ points a cell, mean dilatation, `Reshape`. The quick run has the rake of 60° alone.",
    reference: "Bounds, none of them published values. Upright in the plane: (1 + asin a + √(1 - a²)) s_u H, a = α/s_u, and γ'H²/2 for the weight; the toe adds to it. Rake β, smooth: at most 2 tan(β/2) s_u H by a wedge that slides off along the best plane. In space, smooth: at most 2 s_u H B + √2 s_u H² by a wedge of 45° with two triangular sides. Cells of H/8 and H/4 lie above these bounds, by an error of order one at the toe and the edges.",
    run: ploughs,
};

/// s_u.
const STRENGTH: f64 = 5.0;

fn ploughs(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    if extent == Extent::Full {
        adhesion(&mut findings)?;
        space(&mut findings)?;
    }
    rake(extent, &mut findings)?;
    Ok(findings)
}

/// Force over s_u H in each load step, and how far the blade has come.
fn drawn(history: &History) -> Vec<(f64, f64)> {
    let way = of_tool(history, "blade", "position", 0);
    let start = way.first().copied().unwrap_or(f64::NAN);
    let force = of_tool(history, "blade", "force", 0);
    way.iter().zip(force).map(|(at, force)| (at - start, -force / STRENGTH)).collect()
}

/// The force after the blade has come as far as `way`, between load steps on the straight line.
fn at(way: f64, drawn: &[(f64, f64)]) -> f64 {
    let between = drawn.windows(2).find(|pair| pair[0].0 <= way && way <= pair[1].0 + 1e-9);
    between.map_or(f64::NAN, |pair| {
        let [(a, f), (b, g)] = [pair[0], pair[1]];
        f + (g - f) * (way - a) / (b - a)
    })
}

/// The plane blade drawn with other values, each a path and what stands there.
fn plane(changes: &[(&str, String)]) -> Result<Vec<(f64, f64)>, Broken> {
    let quiet = ("output", "(fields: [])".to_owned());
    let changes: Vec<(&str, String)> = changes.iter().cloned().chain([quiet]).collect();
    Ok(drawn(&run(&changed(text("plough")?, &changes)?)?.completed()?))
}

fn short(steps: u32) -> [(&'static str, String); 2] {
    [("tools[0].motion.by", "(0.12, 0)".into()), ("schedule", format!("(steps: {steps})"))]
}

fn adhesion(findings: &mut Findings) -> Result<(), Broken> {
    let about = "In the plane, force over s_u H after 0.05 m, its mean from 0.1 m to 0.5 m, where a heap rises in front, and the bound:";
    let mut table = Table::new(about, &["α/s_u", "γ'", "at 0.05 m", "mean", "bound", "over it"]);
    let (mut curves, mut smooth) = (Vec::new(), f64::NAN);
    for (colour, part) in [0.0_f64, 0.5, 1.0].into_iter().enumerate() {
        let drawn = plane(&[("tools[0].interface.adhesion", (part * STRENGTH).to_string())])?;
        let bound = 1.0 + part.asin() + (1.0 - part * part).sqrt();
        let early = at(0.05, &drawn);
        let late: Vec<f64> = drawn.iter().filter(|it| it.0 >= 0.1).map(|it| it.1).collect();
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        let what = format!("α = {part} s_u: force at 0.05 m against the bound, relative");
        findings.checks.push(Check::new(what, (early / bound - 1.0).abs(), 0.25).remark(fixed(early, 3)));
        let over = format!("{} %", fixed(100.0 * (early / bound - 1.0), 1));
        table.push([part.to_string(), "0".into(), fixed(early, 3), fixed(mean, 3), fixed(bound, 3), over]);
        let name = format!("α = {part} s_u");
        curves.push(Curve { name, colour, stroke: Stroke::Line, points: drawn });
        let (name, points) = (format!("bound, {}", fixed(bound, 2)), vec![(0.0, bound), (0.5, bound)]);
        curves.push(Curve { name, colour, stroke: Stroke::Dashes, points });
        if part == 0.0 {
            smooth = early;
        }
    }
    let [by, _] = short(0);
    let heavy = plane(&[
        ("tools[0].interface.adhesion", "0".into()),
        ("materials.clay.density", "0.6".into()),
        ("loads", "[BodyForce(acceleration: (0, -10))]".into()),
        ("schedule", "(stages: [(name: \"weight\", steps: 4), (name: \"drag\", steps: 24)])".into()),
        by,
        ("tools[0].motion.ramp", "{\"drag\": [(0, 0), (1, 1)]}".into()),
    ])?;
    let early = at(0.05, &heavy);
    let part = (early - smooth) * STRENGTH / 3.0;
    let what = "weight: what it adds at 0.05 m against γ'H²/2, relative";
    findings.checks.push(Check::new(what, (part - 1.0).abs(), 0.2).remark(fixed(part, 3)));
    let over = format!("{} %", fixed(100.0 * (early / 2.6 - 1.0), 1));
    table.push(["0".into(), "6 kN/m³".into(), fixed(early, 3), "–".into(), "2.600".into(), over]);
    findings.tables.push(table);
    findings.pictures.push(Picture {
        file: "plough.svg",
        caption: "Plough in the plane: force over s_u H against the way.".into(),
        panels: vec![Panel::Curves(Curves {
            title: "Plough".into(),
            axes: ["way (m)", "force over s_u H"].map(String::from),
            range: [(0.0, 0.5), (0.0, 4.0)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves,
        })],
    });
    Ok(())
}

fn rake(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let about = "Smooth, in the plane, with a rake, force over s_u H:";
    let mut table = Table::new(about, &["rake", "at 0.05 m", "mean from there to 0.12 m", "bound"]);
    let mut means = Vec::new();
    for degrees in extent.pick(&[60.0_f64][..], &[90.0, 60.0, 45.0]) {
        let (back, bound) = (1.0 / degrees.to_radians().tan(), 2.0 * (0.5 * degrees.to_radians()).tan());
        let corner = |x: f64, y: f64| format!("({}, {y})", x - (y - 1.0) * back);
        let face = [corner(1.375 - back, 1.0), corner(1.5, 1.0), corner(1.5, 2.7), corner(1.375, 2.7)];
        let front = format!("Box(from: ({}, 1), to: (5.5, 2), without: [\"blade\"])", 1.5 - back);
        let [by, steps] = short(24);
        let drawn = plane(&[
            by,
            steps,
            ("tools[0].interface.adhesion", "0".into()),
            ("tools[0].parts", format!("[Polygon(vertices: [{}])]", face.join(", "))),
            ("bodies[1].shape", front),
        ])?;
        let late: Vec<f64> = drawn.iter().filter(|it| it.0 >= 0.05).map(|it| it.1).collect();
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        let what = format!("rake of {degrees}°: mean force over its bound");
        findings.checks.push(Check::new(what, mean / bound, 1.8).remark(fixed(mean, 3)));
        table.push([format!("{degrees}°"), fixed(at(0.05, &drawn), 3), fixed(mean, 3), fixed(bound, 3)]);
        means.push((degrees, mean));
    }
    for pair in means.windows(2) {
        let what = format!("rake of {}°: force over that of {}°", pair[1].0, pair[0].0);
        findings.checks.push(Check::new(what, pair[1].1 / pair[0].1, 0.98));
    }
    findings.tables.push(table);
    Ok(())
}

fn space(findings: &mut Findings) -> Result<(), Broken> {
    let about = "In space, smooth, cells of H/4: largest force over s_u H B, and the bound:";
    let mut table = Table::new(about, &["B/H", "force", "bound", "over it"]);
    let mut before: Option<f64> = None;
    for width in [1.0, 2.0, 4.0] {
        let far = 0.5 * width + 2.0;
        let across = (0..=(4.0 * far) as u32).map(|k| 0.25 * f64::from(k));
        let history = run(&changed(
            text("plough_solid")?,
            &[
                ("mesh.axes[1]", written(across)),
                ("bodies[0].shape.to", format!("(5, {far}, 1)")),
                ("bodies[1].shape.to", format!("(5, {far}, 2)")),
                ("bodies[2].shape.from", format!("(0, {}, 1)", 0.5 * width)),
                ("bodies[2].shape.to", format!("(1.5, {far}, 2)")),
                ("supports[1].region.at", far.to_string()),
                ("tools[0].parts[0].shift", format!("(1.5, {}, 1)", 0.5 * width)),
                ("output", "(fields: [])".into()),
            ],
        )?)?
        .completed()?;
        let most = largest(drawn(&history).iter().map(|it| 2.0 * it.1 / width));
        let bound = 2.0 + SQRT_2 / width;
        let what = format!("in space, B = {width} H: force against the bound, relative");
        findings.checks.push(Check::new(what, (most / bound - 1.0).abs(), 0.5).remark(fixed(most, 3)));
        if let Some(before) = before {
            let what = format!("in space, B = {width} H: force per width over that of half the width");
            findings.checks.push(Check::new(what, most / before, 0.9));
        }
        let over = format!("{} %", fixed(100.0 * (most / bound - 1.0), 1));
        table.push([width.to_string(), fixed(most, 3), fixed(bound, 3), over]);
        before = Some(most);
    }
    findings.tables.push(table);
    Ok(())
}
