//! Tools with edges in clay: a strip footing and a plough blade.

use super::of_tool;
use crate::cases::{fixed, largest};
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{load, load_own, run};
use crate::variants::{plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Coordinates, Count, Finite, Positive, Scene, StabilisationInput, ToolMotionInput};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "footing and blade",
    goal: "Limit loads of tools with edges in clay, whose forces change smoothly as corners pass rounded edges.",
    setup: "Half of a smooth strip footing with edges rounded by a third of a cell, pressed by 0.034 of its width, 8 cells under its half (E = 1000 s_u, ν = 0.49); and a smooth blade, 1 m deep, that is drawn by 0.03 m through clay 2 m deep (E = 500 s_u), cells of 1/8, in the full run of 1/16 m. CPDI1, 2² points a cell, mean dilatation, ghost stabilisation (of factor 0.003 in the blade's clay, because the faces' force follows the displacement of the load step and carries a part of the blade's).",
    reference: "Footing: (2 + π) s_u, met from above by about half a cell at its edge. Blade: 2 s_u H and a part at the toe, of first order in the cells.",
    run: edges,
};

/// Limit pressure of the footing over s_u.
const LIMIT: f64 = 2.0 + PI;

fn edges(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let footing = run(&Scene::PlaneStrain(plane(load_own("contact/footing")?)?))?.completed()?;
    let pressure: Vec<f64> =
        of_tool(&footing, "footing", "force", 1).iter().map(|force| force / 500.0).collect();
    let last = pressure.last().copied().unwrap_or(f64::NAN);
    findings.checks.push(
        Check::new("footing: pressure against the limit, relative", (last / LIMIT - 1.0).abs(), 0.12)
            .remark(fixed(last, 3)),
    );
    let falls = pressure.windows(2).map(|pair| (pair[0] - pair[1]).max(0.0));
    findings.checks.push(Check::new("footing: largest fall of the pressure, over s_u", largest(falls), 0.06));

    let mut table = Table::new("Force on the blade over s_u H, smooth:", &["cell", "force", "of the limit"]);
    for (factor, tolerance) in extent.pick(&[(1, 0.12)][..], &[(1, 0.12), (2, 0.06)]) {
        let mut scene = refined(plane(load("plough")?)?, *factor);
        scene.stabilisation = Some(StabilisationInput::Ghost { factor: Some(Positive(0.003)) });
        scene.tools[0].interface.adhesion = Finite(0.0);
        if let ToolMotionInput::Move { by, .. } = &mut scene.tools[0].motion {
            *by = Coordinates([0.03, 0.0]);
        }
        scene.schedule.steps = Some(Count(12));
        scene.output.fields.clear();
        let history = run(&Scene::PlaneStrain(scene))?.completed()?;
        let force = -of_tool(&history, "blade", "force", 0).last().copied().unwrap_or(f64::NAN) / 5.0;
        let cells = 8 * factor;
        let what = format!("blade, {cells} cells along it: force against 2 s_u H, relative");
        findings.checks.push(Check::new(what, (force / 2.0 - 1.0).abs(), *tolerance).remark(fixed(force, 3)));
        table.push([format!("1/{cells}"), fixed(force, 3), format!("{} %", fixed(50.0 * force, 1))]);
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        let settlement = footing.rows().iter().map(|row| 3.4 * row.fraction);
        let line = |name: &str, stroke, points| Curve { name: name.into(), colour: 0, stroke, points };
        findings.pictures.push(Picture {
            file: "footing_as_a_tool.svg",
            caption: "A rigid footing as a tool: pressure over s_u against the settlement.".into(),
            panels: vec![Panel::Curves(Curves {
                title: "Footing".into(),
                axes: ["settlement over width (%)", "pressure over s_u"].map(String::from),
                range: [(0.0, 3.4), (0.0, 6.5)],
                logarithmic: [false; 2],
                legend: Legend::LowerRight,
                curves: vec![
                    line("smooth", Stroke::Line, settlement.zip(pressure.iter().copied()).collect()),
                    line("limit", Stroke::Dashes, vec![(0.0, LIMIT), (3.4, LIMIT)]),
                ],
            })],
        });
    }
    Ok(findings)
}
