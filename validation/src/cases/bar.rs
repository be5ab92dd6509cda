//! A bar whose shape comes from an STL file.

use super::view::view;
use super::{fixed, largest, scientific, sweep};
use crate::picture::{Panel, Picture};
use crate::scenes::{compiled, load, run};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_solver::scene::{DomainsInput, Scene, SolidBasis};

pub(super) const CASE: Case = Case {
    name: "bar of STL shape",
    goal: "A body whose sides lie across the cells has the volume of its surface and, in a homogeneous state, the exact force.",
    setup: "A hexagonal bar from an STL file (four long, corners 1 from its axis, turned by 10° against the cells of 0.5, 2³ points a cell; cells that it fills in part have points of that part's volume, centre and extent), E = 10³, ν = 0.3, pulled to 1.5 times its length in 10 load steps; its sides are free and draw together across the cells.",
    reference: "Force E A ln λ / λ, A = 3√3/2; the volume by the divergence theorem. The bar's coordinates have single precision (6e-8).",
    run: pulled,
};

const BASES: [(SolidBasis, &str); 5] = [
    (SolidBasis::Smpm, "sMPM"),
    (SolidBasis::Gimp, "GIMP"),
    (SolidBasis::Cpdi1, "CPDI1"),
    (SolidBasis::Cpdi2Hexahedron, "CPDI2 hexahedra"),
    (SolidBasis::Cpdi2Tetrahedron, "CPDI2 tetrahedra"),
];

fn scene(basis: SolidBasis) -> Result<Scene, Broken> {
    let Scene::Solid(mut scene) = load("bar_of_stl")? else {
        return Err("expected a scene in three dimensions".into());
    };
    scene.basis = basis;
    scene.domains = DomainsInput::default();
    Ok(Scene::Solid(scene))
}

fn pulled(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let estimate = compiled(&scene(SolidBasis::Cpdi1)?)?.estimate()?;
    let exact = 6.0 * 3.0_f64.sqrt();
    let volume = &estimate.volumes[0];
    findings.checks.push(
        Check::new(
            "volume of the points against that of the surface (relative)",
            (volume.points / volume.shape - 1.0).abs(),
            1e-7,
        )
        .remark(format!("{:.9}", volume.points)),
    );
    findings.checks.push(Check::new(
        "volume of the surface against that of a hexagonal bar (relative)",
        (volume.shape / exact - 1.0).abs(),
        1e-6,
    ));

    let runs = sweep(&BASES, |(basis, _)| run(&scene(*basis)?))?;
    let mut table = Table::new(
        "Force at the end, and the largest error of any load step over the force there:",
        &["basis", "points", "force", "error"],
    );
    for ((_, name), run) in BASES.iter().zip(&runs) {
        let reason = run.outcome.as_ref().err().map_or(String::new(), ToString::to_string);
        let forces = run.history.series("reaction/pulled", 2);
        let rows = run.history.rows()[1..].iter().zip(&forces[1..]);
        let error = largest(rows.map(|(row, force)| {
            let stretch = 1.0 + 0.5 * row.fraction;
            (force / (1e3 * 0.25 * exact * stretch.ln() / stretch) - 1.0).abs()
        }));
        let error = if run.outcome.is_ok() { error } else { f64::NAN };
        let what = format!("{name}: force against E A ln λ / λ (relative, every load step)");
        findings.checks.push(Check::new(what, error, 1e-6).remark(reason));
        table.push([
            (*name).to_owned(),
            run.history.outlines().len().to_string(),
            fixed(forces[forces.len() - 1], 6),
            scientific(error, 2),
        ]);
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        let history = &runs[2].history;
        let range = [(-4.3, 1.3), (-3.4, 1.3)];
        let panel =
            |title: &str, outlines: &[Vec<[f64; 3]>]| Panel::Shapes(view(title.into(), outlines, &[], range));
        findings.pictures.push(Picture {
            file: "bar_of_stl.png",
            caption: "The bar at the end, CPDI1: domains of the points. Those at the sides are as large as what fills their part of a cell.".into(),
            panels: vec![panel("bar of STL shape", history.outlines())],
        });
    }
    Ok(findings)
}
