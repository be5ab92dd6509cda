//! A circle with friction on a block, against tables.

use super::{of_tool, on};
use crate::cases::{largest, scientific};
use crate::reference::Reference;
use crate::scenes::{from_rest, load_own, run};
use crate::variants::{CPDI1, GIMP, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::Scene;

pub(in crate::cases) const CASE: Case = Case {
    name: "circle on a block",
    goal: "Contact with friction on a curved surface is what another implementation of the same equations computes.",
    setup: "A rigid circle, R = 0.3, μ = 0.3, pressed by 0.03 into an elastic block of 1 × 0.45 (E = 10⁶, ν = 0.3, cells of 0.1, 2² points a cell) in 5 load steps, then drawn along it by 0.05 in 5 more; every step is begun at rest.",
    reference: "Tables of an independent implementation, GIMP and CPDI1: force, moment, corners that touch and slip, linear solutions.",
    run: circle,
};

fn circle(_: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let heads = ["basis", "force, moment", "corners", "linear solutions beyond those of the table"];
    let mut table =
        Table::new("Largest differences from the tables, force and moment relative to the largest:", &heads);
    for (method, name) in [(&GIMP, "gimp"), (&CPDI1, "cpdi1")] {
        let reference = Reference::read(&format!("contact/circle_on_block_{name}"))?;
        let scene = on(method, plane(load_own("contact/circle_on_block")?)?);
        let history = run(&from_rest(Scene::PlaneStrain(scene)))?.completed()?;
        let of = |column: &str, component: usize| of_tool(&history, "circle", column, component)[1..].to_vec();
        let differences = |found: &[f64], expected: &[f64]| {
            if found.len() != expected.len() {
                return f64::NAN;
            }
            largest(found.iter().zip(expected).map(|(a, b)| (a - b).abs()))
        };
        let size = |values: &[f64]| largest(values.iter().map(|it| it.abs()));
        let vertical = size(&reference.column("force_y")?);
        let moments = reference.column("moment")?;
        let forces = [
            differences(&of("force", 0), &reference.column("force_x")?) / vertical,
            differences(&of("force", 1), &reference.column("force_y")?) / vertical,
            differences(&of("moment", 0), &moments) / size(&moments),
        ];
        let corners = [
            differences(&of("closed", 0), &reference.column("closed")?),
            differences(&of("slipping", 0), &reference.column("slipping")?),
        ];
        let iterations = history.series("newton_iterations", 0)[1..].to_vec();
        let beyond = iterations.iter().sum::<f64>() - reference.column("iterations")?.iter().sum::<f64>();
        table.push([
            method.name.to_owned(),
            scientific(largest(forces), 2),
            largest(corners).to_string(),
            beyond.to_string(),
        ]);
        findings.checks.push(Check::new(format!("{}: force and moment", method.name), largest(forces), 1e-7));
        findings.checks.push(Check::new(format!("{}: corners", method.name), largest(corners), 0.0));
        let what = format!("{}: linear solutions beyond those of the table", method.name);
        findings.checks.push(Check::new(what, beyond.max(0.0), 3.0));
    }
    findings.tables.push(table);
    Ok(findings)
}
