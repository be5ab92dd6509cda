//! A rigid cylinder in clay: turned, and pushed as a T-bar penetrometer.

use super::of_tool;
use crate::cases::{fixed, largest};
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{load_own, run};
use crate::variants::{PlaneScene, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Coordinates, Count, Finite, RampInput, Scene, ToolMotionInput, ToolTurnInput};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "cylinder in clay",
    goal: "Adhesion acts on the tool's own area, and plastic flow round a tool gives the known limit loads.",
    setup: "A rigid cylinder, R = 0.5, in a ring of clay of radius 3 (48 sectors, first cells R/10, CPDI1, 2² points a cell, mean dilatation), E = 1000 s_u, ν = 0.49, from which it never parts. It is turned by 1°, smooth, with α = s_u/2 and α = s_u; and pushed by 0.026 diameters.",
    reference: "Torque 2πR²α per unit length. Force over s_u D: π + 2Δ + 2 cos Δ + 4 (cos Δ/2 + sin Δ/2), sin Δ = α/s_u (Randolph & Houlsby 1984): 9.14 smooth, 11.94 rough.",
    run: cylinder,
};

/// Undrained strength, radius.
const STRENGTH: f64 = 1e3;
const RADIUS: f64 = 0.5;

fn scene(adhesion: f64) -> Result<PlaneScene, Broken> {
    let mut scene = plane(load_own("contact/bar")?)?;
    scene.tools[0].interface.adhesion = Finite(adhesion * STRENGTH);
    Ok(scene)
}

/// Limit of the force over s_u D.
fn limit(adhesion: f64) -> f64 {
    let delta = adhesion.asin();
    PI + 2.0 * delta + 2.0 * delta.cos() + 4.0 * ((0.5 * delta).cos() + (0.5 * delta).sin())
}

fn cylinder(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let whole = 2.0 * PI * RADIUS * RADIUS * STRENGTH;
    let mut table = Table::new("Turned:", &["α/s_u", "torque over 2πR² s_u", "area of the surface over 2πR"]);
    for (adhesion, tolerance) in [(0.0, 1e-4), (0.5, 3e-3), (1.0, 1e-2)] {
        let mut scene = scene(adhesion)?;
        let turn = ToolTurnInput {
            axis: mpm_scene::language::Direction::Z,
            centre: Coordinates([0.0; 2]),
            angle: Finite(1.0),
            ramp: RampInput::default(),
        };
        let (by, ramp) = (Coordinates([0.0; 2]), RampInput::default());
        scene.tools[0].motion = ToolMotionInput::Move { by, ramp, then: Vec::new(), turn: Some(turn) };
        scene.schedule.steps = Some(Count(4));
        let history = run(&Scene::PlaneStrain(scene))?.completed()?;
        let last = |column: &str| of_tool(&history, "bar", column, 0).last().copied().unwrap_or(f64::NAN);
        let (torque, area) = (-last("moment") / whole, last("area") / (2.0 * PI * RADIUS));
        let what = format!("turned, α = {adhesion} s_u: torque against 2πR²α, over 2πR² s_u");
        findings.checks.push(Check::new(what, (torque - adhesion).abs(), tolerance));
        findings.checks.push(Check::new(format!("turned, α = {adhesion} s_u: area"), (area - 1.0).abs(), 2e-3));
        table.push([adhesion.to_string(), fixed(torque, 5), fixed(area, 5)]);
    }
    findings.tables.push(table);

    let mut table = Table::new("Pushed: largest force over s_u D.", &["α/s_u", "force", "limit", "error"]);
    let mut curves = Vec::new();
    for (colour, adhesion) in extent.pick(&[0.0][..], &[0.0, 0.5, 1.0]).iter().copied().enumerate() {
        let history = run(&Scene::PlaneStrain(scene(adhesion)?))?.completed()?;
        let force: Vec<f64> = of_tool(&history, "bar", "force", 1)
            .iter()
            .map(|force| force / (2.0 * RADIUS * STRENGTH))
            .collect();
        let (most, limit) = (largest(force.iter().copied()), limit(adhesion));
        let what = format!("pushed, α = {adhesion} s_u: force against the limit, relative");
        findings.checks.push(Check::new(what, (most / limit - 1.0).abs(), 3e-2).remark(fixed(most, 3)));
        let error = format!("{} %", fixed(100.0 * (most / limit - 1.0), 2));
        table.push([adhesion.to_string(), fixed(most, 3), fixed(limit, 3), error]);
        let points =
            history.rows().iter().zip(&force).map(|(row, force)| (2.6 * row.fraction, *force)).collect();
        curves.push(Curve { name: format!("α = {adhesion} s_u"), colour, stroke: Stroke::Line, points });
        let ends = vec![(0.0, limit), (2.6, limit)];
        curves.push(Curve {
            name: format!("limit, {}", fixed(limit, 2)),
            colour,
            stroke: Stroke::Dashes,
            points: ends,
        });
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        findings.pictures.push(Picture {
            file: "t_bar.svg",
            caption: "T-bar: force over s_u D against the way in hundredths of the diameter.".into(),
            panels: vec![Panel::Curves(Curves {
                title: "T-bar".into(),
                axes: ["way over diameter (%)", "force over s_u D"].map(String::from),
                range: [(0.0, 2.6), (0.0, 13.0)],
                logarithmic: [false; 2],
                legend: Legend::LowerRight,
                curves,
            })],
        });
    }
    Ok(findings)
}
