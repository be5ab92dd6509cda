//! A cone that is pushed into clay.

use super::{lines, list, scene};
use crate::cases::contact::of_tool;
use crate::cases::{fixed, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use std::f64::consts::PI;

pub(in crate::cases) const CASE: Case = Case {
    name: "cone in clay",
    goal: "A cone that is pushed into clay by four diameters finds a steady resistance, whose swings fall with the cells, and within what is published of its dependence on stiffness and roughness.",
    setup: "A cone of 60° and its shaft, radius a = 1, stand three diameters deep in weightless clay of radius 30 and depth 27 and are pushed in by four diameters. s_u = 1, ν = 0.49, I = G/s_u; von Mises with s_u in pure shear, Tresca; adhesion α on the cone, carried by a skin just inside it, none on the shaft. CPDI1 with reshaped domains, ghost faces; n cells of equal width over a, up to 1.5 a and from one diameter above the shoulder to half a diameter below the last place of the tip, growing by 1.4 beyond; up to about 2 a 2² points a cell with mean dilatation over points, beyond one point a cell; load steps of a tenth of the width of a cell. On 8 cells by two diameters only.",
    reference: "Published fits, for clay without stress, I = G/s_u: Teh & Houlsby (1991) `(4/3)(1 + ln I)(1.25 + I/2000) + 2.4 α` and Yu, Herrmann & Boulanger (2000) `0.33 + 2 ln I + 2.37 α` of von Mises' law, Lu, Randolph, Hu & Bugarski (2004) `3.4 + 1.6 ln I + 1.3 α` of Tresca's. The band: from a tenth below the least to a tenth above the largest of the three. Factors are means over the last diameter, weighted by the way.",
    run: cone,
};

/// Clay and cone: law, G/s_u, α/s_u.
#[derive(Clone, Copy)]
struct Test {
    is_tresca: bool,
    rigidity: f64,
    adhesion: f64,
}

impl Test {
    fn name(self) -> String {
        let law = if self.is_tresca { "Tresca" } else { "von Mises" };
        format!("{law}, G/s_u = {}, α = {} s_u", self.rigidity, self.adhesion)
    }

    /// Cone factors of the published fits.
    fn published(self) -> [f64; 3] {
        let (index, alpha) = (self.rigidity, self.adhesion);
        [
            4.0 / 3.0 * (1.0 + index.ln()) * (1.25 + index / 2000.0) + 2.4 * alpha,
            0.33 + 2.0 * index.ln() + 2.37 * alpha,
            3.4 + 1.6 * index.ln() + 1.3 * alpha,
        ]
    }

    /// Pushes the cone by `way`.
    fn push(self, cells: u32, way: f64) -> Result<History, Broken> {
        let radii = lines(cells, 1.5, RATIO, 30.0);
        // Where fine points end: a line of the mesh.
        let near = radii.iter().copied().find(|radius| *radius >= 2.0).unwrap_or(f64::NAN);
        let law = if self.is_tresca { "tresca" } else { "clay" };
        let young = format!("materials.{law}.young");
        let mut changes = vec![
            (&*young, (2.0 * 1.49 * self.rigidity).to_string()),
            ("mesh.axes[0]", format!("Nodes({})", list(radii))),
            ("mesh.axes[1]", format!("Nodes({})", list(heights(cells)))),
            ("bodies[0].material", format!("{law:?}")),
            ("bodies[1].material", format!("{law:?}")),
            ("bodies[0].shape.to", format!("({near:?}, 0)")),
            ("bodies[1].shape.from", format!("({near:?}, -27)")),
            ("tools[0].motion.by", format!("(0, {:?})", -way)),
            ("schedule.steps", (10.0 * way * f64::from(cells)).to_string()),
            ("output.fields", "[]".into()),
        ];
        if self.adhesion > 0.0 {
            changes.push(("tools", rough(self.adhesion)));
        }
        run(&scene("cone", &changes)?)?.completed()
    }
}

/// Four diameters.
const WAY: f64 = 8.0;

/// A factor with two digits; nothing where the cone was not pushed so far.
fn shown(factor: f64) -> String {
    if factor.is_nan() { String::new() } else { fixed(factor, 2) }
}

/// How much wider each cell is than the one before, away from the cone.
const RATIO: f64 = 1.4;

/// Lines along the axis: fine from one diameter above the shoulder to half a diameter below the last place of the tip.
fn heights(cells: u32) -> Vec<f64> {
    const TOP: f64 = -3.0;
    let below = lines(cells, 12.0, RATIO, 27.0 + TOP);
    let mut above = lines(cells, 0.0, RATIO, -TOP);
    // What heaves.
    let (end, width) = (-TOP, above[above.len() - 1] - above[above.len() - 2]);
    above.extend([end + width, end + 3.0 * width]);
    below.iter().rev().map(|x| TOP - x).chain(above.iter().skip(1).map(|x| TOP + x)).collect()
}

/// The cone and its skin, which lies 0.005 inside, meets nothing and carries the adhesion of the cone's face: a tool has
/// one adhesion.
fn rough(adhesion: f64) -> String {
    format!(
        r#"[
            (name: "cone", parts: [Polygon(vertices: [(0, -6), (1, -4.267949), (1, 10), (0, 10)])], rounding: 0.1,
                motion: Move(by: (0, -8))),
            (name: "skin", parts: [Polygon(vertices: [(0, -5.8168), (0.1, -5.8168), (0.995, -4.2666), (0, -4.2666)])],
                rounding: 0.03, motion: Move(by: (0, -8)), interface: (adhesion: {adhesion})),
        ]"#
    )
}

/// The way of the cone, and the force on the cone, with its skin where it is rough, over π a² s_u.
fn path(history: &History, test: Test, way: f64) -> Vec<(f64, f64)> {
    let mut force = of_tool(history, "cone", "force", 1);
    if test.adhesion > 0.0 {
        force.iter_mut().zip(of_tool(history, "skin", "force", 1)).for_each(|(sum, skin)| *sum += skin);
    }
    let ways = history.rows().iter().map(|row| way * row.fraction);
    ways.zip(force).map(|(way, force)| (way, force / PI)).collect()
}

/// Mean over a part of the way, weighted by the way, and the deviation from it.
fn mean(path: &[(f64, f64)], from: f64, to: f64) -> (f64, f64) {
    let parts = path.windows(2).filter(|pair| pair[0].0 >= from - 1e-9 && pair[1].0 <= to + 1e-9);
    let parts: Vec<(f64, f64)> =
        parts.map(|pair| (pair[1].0 - pair[0].0, 0.5 * (pair[0].1 + pair[1].1))).collect();
    let whole: f64 = parts.iter().map(|it| it.0).sum();
    let mean = parts.iter().map(|(way, force)| way * force).sum::<f64>() / whole;
    let square = parts.iter().map(|(way, force)| way * (force - mean).powi(2)).sum::<f64>() / whole;
    (mean, square.sqrt())
}

fn cone(extent: Extent) -> Result<Findings, Broken> {
    let test = |is_tresca, rigidity, adhesion| Test { is_tresca, rigidity, adhesion };
    let plain = test(false, 100.0, 0.0);
    let mut jobs = vec![(plain, 2, WAY)];
    if extent == Extent::Full {
        // The longest first.
        jobs = vec![(plain, 8, 0.5 * WAY), (plain, 4, WAY), (plain, 2, WAY)];
        for (rigidity, adhesion) in [(50.0, 0.0), (300.0, 0.0), (100.0, 0.5), (100.0, 1.0)] {
            jobs.push((test(false, rigidity, adhesion), 4, WAY));
        }
        jobs.push((test(true, 100.0, 0.0), 4, WAY));
    }
    let runs = sweep(&jobs, |(test, cells, way)| Ok(path(&test.push(*cells, *way)?, *test, *way)))?;
    let mut findings = Findings::default();
    let heads = [
        "clay",
        "cells over a",
        "second diameter",
        "third",
        "fourth",
        "deviation",
        "Teh & Houlsby",
        "Yu et al.",
        "Lu et al.",
    ];
    let mut table = Table::new("Cone factor, mean over a diameter of the way; published fits:", &heads);
    for ((test, cells, way), path) in jobs.iter().zip(&runs) {
        let ((second, _), (before, _), (factor, deviation)) =
            (mean(path, 2.0, 4.0), mean(path, 4.0, 6.0), mean(path, 6.0, 8.0));
        let name = format!("{}, {cells} cells", test.name());
        let published = test.published();
        table.push(
            [test.name(), cells.to_string()]
                .into_iter()
                .chain([second, before, factor, deviation].into_iter().chain(published).map(shown)),
        );
        if *way < WAY {
            continue;
        }
        let low = 0.9 * published.iter().copied().fold(f64::INFINITY, f64::min);
        let high = 1.1 * published.iter().copied().fold(0.0, f64::max);
        let outside = usize::from(!(low..=high).contains(&factor));
        let said = format!("{factor:.2} in {low:.2} to {high:.2}");
        findings.checks.push(Check::none(format!("{name}: factor outside the band"), outside).remark(said));
        let what = format!("{name}: change from the third diameter to the fourth (relative)");
        findings.checks.push(Check::new(what, (factor / before - 1.0).abs(), 0.15));
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        refined(&jobs, &runs, plain, &mut findings);
    }
    Ok(findings)
}

/// How the factor changes with the mesh, and a picture of it.
fn refined(jobs: &[(Test, u32, f64)], runs: &[Vec<(f64, f64)>], plain: Test, findings: &mut Findings) {
    let meshes: Vec<(u32, &Vec<(f64, f64)>)> = jobs
        .iter()
        .zip(runs)
        .filter(|((test, ..), _)| test.name() == plain.name())
        .map(|((_, cells, _), run)| (*cells, run))
        .collect();
    let of = |cells: u32, from: f64| {
        let run = meshes.iter().find(|it| it.0 == cells);
        run.map_or((f64::NAN, f64::NAN), |it| mean(it.1, from, from + 2.0))
    };
    for (coarse, fine, allowed) in [(2, 4, 0.15), (4, 8, 0.05)] {
        let what =
            format!("factor of the second diameter, from {coarse} to {fine} cells over a: change (relative)");
        let change = of(fine, 2.0).0 / of(coarse, 2.0).0 - 1.0;
        findings.checks.push(Check::new(what, change.abs(), allowed).remark(fixed(change, 4)));
    }
    let what = "deviation of the force from its mean, from 2 to 4 cells: order, lack below 0.5";
    let order = (of(2, 6.0).1 / of(4, 6.0).1).log2();
    findings.checks.push(Check::new(what, (0.5 - order).max(0.0) + 0.0 * order, 0.0).remark(fixed(order, 2)));
    let mut curves: Vec<Curve> = meshes
        .iter()
        .enumerate()
        .map(|(colour, (cells, path))| Curve {
            name: format!("{cells} cells"),
            colour,
            stroke: Stroke::Line,
            points: path.iter().map(|(way, force)| (0.5 * way, *force)).collect(),
        })
        .collect();
    for (colour, (name, limit)) in
        ["Teh & Houlsby", "Yu et al.", "Lu et al."].into_iter().zip(plain.published()).enumerate()
    {
        let points = vec![(0.0, limit), (4.0, limit)];
        curves.push(Curve { name: name.into(), colour: colour + 3, stroke: Stroke::Dashes, points });
    }
    findings.pictures.push(Picture {
        file: "cone.svg",
        caption: "Cone in clay, von Mises, G/s_u = 100: force over π a² s_u against the way in diameters."
            .into(),
        panels: vec![Panel::Curves(Curves {
            title: "Cone in clay".into(),
            axes: ["way over diameter", "cone factor"].map(String::from),
            range: [(0.0, 4.0), (0.0, 14.0)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves,
        })],
    });
}
