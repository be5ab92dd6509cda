//! The slides' doughnut to 90°.

use super::super::{relative, shapes, sweep};
use super::at_stations;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::problems::doughnut::torque;
use crate::reference::Reference;
use crate::scenes::{Run, load, run};
use crate::variants::{CPDI1, CPDI2Q, CROSS, Method, SLASH, SMPM, plane};
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_scene::Scene;

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist, the slides'",
    goal: "Very large twist with yielding: which bases stay physical?",
    setup: "The same ring with ρ_y = 10⁶, 5 × 32 cells, turned by 90° in 90 load steps; angles larger than a cell are reduced by whole cells. Elastic strains are of order one, so the ring softens and all further twist goes to the innermost cells: torques depend on the mesh, and only those on one mesh may be compared.",
    reference: "The independent implementation at every degree. The finding of the slides: standard MPM and CPDI1 stay near the one-dimensional torque, CPDI2q drifts away, triangles grow without bound.",
    run: plastic,
};

fn plastic(extent: Extent) -> Result<Findings, Broken> {
    let methods = [SMPM, CPDI1, CPDI2Q, SLASH, CROSS];
    let columns = ["smpm", "cpdi1", "cpdi2q", "cpdi2t-slash", "cpdi2t-cross"];
    let scene = |method: &Method| -> Result<Scene, Broken> {
        Ok(Scene::PlaneStrain(method.of(plane(load("doughnut")?)?)))
    };
    let runs: Vec<Run> = sweep(&methods, |method| run(&scene(method)?))?;
    let table = Reference::read("doughnut_5x32_reindexed_twist")?;

    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (colour, ((method, column), run)) in methods.iter().zip(columns).zip(&runs).enumerate() {
        let (found, expected) = (at_stations(&run.history, 90), table.column(column)?);
        let error = relative(&found, &expected);
        let what = format!("{}: torque against the table (every degree to 90, over the peak)", method.name);
        findings.checks.push(
            Check::new(what, error, 1e-6)
                .remark(run.outcome.as_ref().err().map_or(String::new(), ToString::to_string)),
        );
        curves.push(Curve {
            name: method.name.into(),
            colour,
            stroke: Stroke::Line,
            points: found.iter().enumerate().map(|(k, t)| (k as f64 + 1.0, t / 1e7)).collect(),
        });
    }
    let at_90 = |k: usize| torque(&runs[k].history).last().copied().unwrap_or(f64::NAN);
    let ordered = (0..4).filter(|&k| at_90(k) >= at_90(k + 1)).count();
    findings.checks.push(Check::none("torques at 90° not in the order of the slides' finding", ordered));

    if extent == Extent::Full {
        findings.pictures.push(Picture {
            file: "doughnut_torque.svg",
            caption: "Doughnut twist with the slides' parameters, 5 × 32 cells: torque against the angle."
                .into(),
            panels: vec![Panel::Curves(Curves {
                title: "Doughnut twist".into(),
                axes: ["angle of the inner edge (degrees)", "torque / 10⁷"].map(String::from),
                range: [(0.0, 90.0), (0.0, 20.0)],
                logarithmic: [false; 2],
                legend: Legend::UpperLeft,
                curves,
            })],
        });
        let mut panels = Vec::new();
        for (k, method) in methods.iter().enumerate().filter(|(_, method)| **method != SLASH) {
            let quarter = [(0.0, 10.1), (0.0, 10.1)];
            panels.push(shapes(format!("{}, 90°", method.name), &scene(method)?, &runs[k].history, quarter)?);
        }
        findings.pictures.push(Picture {
            file: "doughnut_domains.svg",
            caption: "Doughnut twist with the slides' parameters at 90°, first quadrant: points (sMPM) or domains, and the mesh in red.".into(),
            panels,
        });
    }
    Ok(findings)
}
