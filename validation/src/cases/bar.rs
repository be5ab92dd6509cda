//! A bar whose shape comes from an STL file.

use super::shapes::{pulled, solid};
use super::view::view;
use crate::picture::{Panel, Picture};
use crate::scenes::compiled;
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_scene::language::SolidBasis;

pub(super) const CASE: Case = Case {
    name: "bar of STL shape",
    goal: "A body whose sides lie across the cells has the volume of its surface and, in a homogeneous state, the exact force.",
    setup: "A hexagonal bar from an STL file (four long, corners 1 from its axis, turned by 10° against the cells of 0.5, 2³ points a cell; cells that it fills in part have points of that part's volume, centre and extent), E = 10³, ν = 0.3, pulled to 1.5 times its length in 10 load steps; its sides are free and draw together across the cells.",
    reference: "Force E A ln λ / λ, A = 3√3/2; the volume by the divergence theorem. The bar's coordinates have single precision (6e-8).",
    run: bar,
};

fn bar(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let estimate = compiled(&solid("bar_of_stl", SolidBasis::Cpdi1)?)?.estimate()?;
    let exact = 6.0 * 3.0_f64.sqrt();
    let volume = &estimate.volumes[0];
    let shape = volume.shape.ok_or("a surface has a volume")?;
    findings.checks.push(
        Check::new(
            "volume of the points against that of the surface (relative)",
            (volume.points / shape - 1.0).abs(),
            1e-7,
        )
        .remark(format!("{:.9}", volume.points)),
    );
    findings.checks.push(Check::new(
        "volume of the surface against that of a hexagonal bar (relative)",
        (shape / exact - 1.0).abs(),
        1e-6,
    ));

    let runs = pulled("", "bar_of_stl", 0.25 * exact, 1e-6, &mut findings)?;
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
