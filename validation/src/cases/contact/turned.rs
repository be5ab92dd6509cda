//! Tools that are turned, and a pile that is pulled: torques and forces of adhesion in space, and a vane.

use super::{extrapolated, of_tool};
use crate::cases::{fixed, largest};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::{load_own, run};
use crate::variants::{plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{AxisInput, Count, Finite, MeshInput, Scene, ToolMotionInput};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "cylinder, pile and vane in clay",
    goal: "Adhesion in space has the tool's own area, however far the tool turns; and a vane carries the clay between its blades along.",
    setup: "A rigid cylinder, R = 0.5, in a ring of clay between smooth plates (32 sectors, one layer of cells), α = s_u/2, which never parts from it, turned by 90° in 6 load steps, in the full run by 720° in 48. A quarter of a pile, R = 0.25, wished in place 0.8 deep, α = s_u/2, pulled up by 0.003 until its base has parted, cells of 1/10, in the full run of 1/15 and 1/20 too. A smooth vane of four blades in the plane, R = 0.0525, R/10 thick, turned by 2°, cells as wide as the blades are thick, in the full run half as wide too. E = 500 to 1000 s_u, ν = 0.49, CPDI1, 2³ and 2² points a cell, mean dilatation.",
    reference: "Torque of the cylinder 2πR² α H, at every load step; force of the pile π D L α; torque of the vane 2πR² s_u, an upper bound by the circle around it, to which its torque comes down with the cells.",
    run: turned,
};

fn turned(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    cylinder(extent, &mut findings)?;
    pile(extent, &mut findings)?;
    vane(extent, &mut findings)?;
    Ok(findings)
}

fn cylinder(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let Scene::Solid(mut scene) = load_own("contact/turned_cylinder")? else {
        return Err("expected a scene in space".into());
    };
    let (degrees, steps) = extent.pick((90.0, 6), (720.0, 48));
    if let ToolMotionInput::Screw { angle, .. } = &mut scene.tools[0].motion {
        *angle = Finite(degrees);
    }
    scene.schedule.steps = Some(Count(steps));
    let history = run(&Scene::Solid(scene))?.completed()?;
    let limit = 2.0 * PI * 0.25 * 0.5 * 0.1;
    let torque = of_tool(&history, "pile", "moment", 2);
    let errors = torque[1..].iter().map(|torque| (-torque / limit - 1.0).abs());
    let last = torque.last().map_or(f64::NAN, |torque| -torque / limit);
    let angle = of_tool(&history, "pile", "angle", 0).last().copied().unwrap_or(f64::NAN);
    findings.checks.push(
        Check::new("cylinder: torque against 2πR² α H, at every load step, relative", largest(errors), 1e-2)
            .remark(format!("{} at {angle}°", fixed(last, 4))),
    );
    Ok(())
}

fn pile(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let mut table = Table::new("Force on the pile over π D L α:", &["cells", "force"]);
    let mut found = Vec::new();
    for (cells, tolerance) in extent.pick(&[(8, 0.08)][..], &[(8, 0.08), (12, 0.05), (16, 0.05)]) {
        let Scene::Solid(mut scene) = load_own("contact/pulled_pile")? else {
            return Err("expected a scene in space".into());
        };
        // Air above the ground is one cell at least.
        if let MeshInput::Box { axes, .. } = &mut scene.mesh {
            let width = 0.8 / f64::from(*cells);
            let layers = cells * 3 / 2 + 1;
            let up = (Finite(0.0), Finite(width * f64::from(layers)), Count(layers));
            for (axis, (from, to, cells)) in axes.iter_mut().zip([
                (Finite(0.0), Finite(0.8), Count(*cells)),
                (Finite(0.0), Finite(0.8), Count(*cells)),
                up,
            ]) {
                *axis = AxisInput::Uniform { from, to, cells };
            }
        }
        let history = run(&Scene::Solid(scene))?.completed()?;
        let force = of_tool(&history, "pile", "force", 2);
        let most = largest(force.iter().map(|force| -force / (0.25 * PI * 0.5 * 0.8 * 5.0)));
        let what = format!("pile, cells of 1/{}: force against π D L α, relative", cells * 5 / 4);
        findings.checks.push(Check::new(what, (most - 1.0).abs(), *tolerance).remark(fixed(most, 4)));
        table.push([format!("1/{}", cells * 5 / 4), fixed(most, 4)]);
        found.push((1.0 / f64::from(*cells), most));
    }
    if let [_, coarse, fine] = found[..] {
        let force = extrapolated([coarse, fine]);
        table.push(["extrapolated".into(), fixed(force, 4)]);
        let what = "pile: force extrapolated to no width of cells, relative";
        findings.checks.push(Check::new(what, (force - 1.0).abs(), 5e-2).remark(fixed(force, 4)));
    }
    findings.tables.push(table);
    Ok(())
}

/// Torque over 2πR² s_u at every load step.
fn vane_torque(history: &History) -> Vec<f64> {
    of_tool(history, "vane", "moment", 0)
        .iter()
        .map(|moment| -moment / (2.0 * PI * 0.0525 * 0.0525 * 5.0))
        .collect()
}

fn vane(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let mut table = Table::new("Torque of the vane at 1° over 2πR² s_u:", &["cells over the radius", "torque"]);
    let (mut curves, mut found) = (Vec::new(), Vec::new());
    for factor in extent.pick(&[1][..], &[1, 2]) {
        let history =
            run(&Scene::PlaneStrain(refined(plane(load_own("contact/vane")?)?, *factor)))?.completed()?;
        let torque = vane_torque(&history);
        let at = |degrees: f64| history.rows().iter().position(|row| 2.0 * row.fraction > degrees - 1e-9);
        let middle = at(1.0).map_or(f64::NAN, |row| torque[row]);
        let cells = 10.5 * f64::from(*factor);
        table.push([cells.to_string(), fixed(middle, 3)]);
        let what = format!("vane, {cells} cells over its radius: torque at 1° against 2πR² s_u, relative");
        findings
            .checks
            .push(Check::new(what, (middle - 1.0).abs(), 0.3 / f64::from(*factor)).remark(fixed(middle, 3)));
        let points =
            history.rows().iter().zip(&torque).map(|(row, torque)| (2.0 * row.fraction, *torque)).collect();
        let name = format!("{cells} cells over the radius");
        curves.push(Curve { name, colour: curves.len(), stroke: Stroke::Line, points });
        found.push(middle);
    }
    if let [coarse, fine] = found[..] {
        let limit = 2.0 * fine - coarse;
        table.push(["extrapolated".into(), fixed(limit, 3)]);
        let what = "vane: torque at 1° extrapolated to no width of cells, relative";
        findings.checks.push(Check::new(what, (limit - 1.0).abs(), 7e-2).remark(fixed(limit, 3)));
        let points = vec![(0.0, 1.0), (2.0, 1.0)];
        curves.push(Curve { name: "circle around it".into(), colour: 0, stroke: Stroke::Dashes, points });
        findings.pictures.push(Picture {
            file: "vane.svg",
            caption: "Vane: torque over 2πR² s_u against the angle.".into(),
            panels: vec![Panel::Curves(Curves {
                title: "Vane".into(),
                axes: ["angle (degrees)", "torque over 2πR² s_u"].map(String::from),
                range: [(0.0, 2.0), (0.0, 1.4)],
                logarithmic: [false; 2],
                legend: Legend::LowerRight,
                curves,
            })],
        });
    }
    findings.tables.push(table);
    Ok(())
}
