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
    setup: "A cone of 60° and its shaft, radius a = 1, stand three diameters deep in weightless clay of radius 30 and depth 27 and are pushed in by four diameters. s_u = 1, ν = 0.49, G/s_u = 100; von Mises with s_u in pure shear, Tresca; adhesion α on the cone, carried by a skin just inside it, none on the shaft. CPDI1 with reshaped domains, 2² points a cell, mean dilatation over points, ghost faces; n cells of equal width over a, up to 1.5 a, growing by 1.3 beyond; 40 n load steps.",
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

    fn push(self, cells: u32) -> Result<History, Broken> {
        let radii = lines(cells, 1.5, 1.3, 30.0);
        let air = (1..=(1.5 * f64::from(cells)).round() as u32).map(|k| f64::from(k) / f64::from(cells));
        let depths = lines(cells, 15.0, 1.3, 27.0);
        let heights = depths.iter().rev().map(|depth| -depth).chain(air);
        let law = if self.is_tresca { "tresca" } else { "clay" };
        let changes = [
            ("mesh.axes[0]", format!("Nodes({})", list(radii))),
            ("mesh.axes[1]", format!("Nodes({})", list(heights))),
            ("bodies[0].material", format!("{law:?}")),
            (&*format!("materials.{law}.young"), (2.0 * 1.49 * self.rigidity).to_string()),
            ("tools[1].interface.adhesion", self.adhesion.to_string()),
            ("schedule.steps", (40 * cells).to_string()),
            ("output.fields", "[]".into()),
        ];
        run(&scene("cone", &changes)?)?.completed()
    }
}

/// The way of the cone, and the force on the cone and its skin over π a² s_u.
fn path(history: &History) -> Vec<(f64, f64)> {
    let force = |tool| of_tool(history, tool, "force", 1);
    let ways = history.rows().iter().map(|row| 8.0 * row.fraction);
    ways.zip(force("cone").iter().zip(force("skin")))
        .map(|(way, (cone, skin))| (way, (cone + skin) / PI))
        .collect()
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
    let mut jobs = vec![(plain, 2)];
    if extent == Extent::Full {
        jobs.extend([(plain, 4), (test(true, 100.0, 0.0), 4), (test(false, 100.0, 1.0), 2)]);
    }
    let runs = sweep(&jobs, |(test, cells)| Ok(path(&test.push(*cells)?)))?;
    let mut findings = Findings::default();
    let heads = [
        "clay",
        "cells over a",
        "third diameter",
        "fourth",
        "deviation",
        "Teh & Houlsby",
        "Yu et al.",
        "Lu et al.",
    ];
    let mut table = Table::new("Cone factor, mean over a diameter of the way; published fits:", &heads);
    for ((test, cells), path) in jobs.iter().zip(&runs) {
        let ((before, _), (factor, deviation)) = (mean(path, 4.0, 6.0), mean(path, 6.0, 8.0));
        let name = format!("{}, {cells} cells", test.name());
        let published = test.published();
        table.push(
            [test.name(), cells.to_string()]
                .into_iter()
                .chain([before, factor, deviation].into_iter().chain(published).map(|it| fixed(it, 2))),
        );
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
fn refined(jobs: &[(Test, u32)], runs: &[Vec<(f64, f64)>], plain: Test, findings: &mut Findings) {
    let meshes: Vec<(u32, &Vec<(f64, f64)>)> = jobs
        .iter()
        .zip(runs)
        .filter(|((test, _), _)| test.name() == plain.name())
        .map(|((_, cells), run)| (*cells, run))
        .collect();
    let of = |cells: u32| {
        meshes.iter().find(|it| it.0 == cells).map_or((f64::NAN, f64::NAN), |it| mean(it.1, 6.0, 8.0))
    };
    let ((coarse, wide), (fine, narrow)) = (of(2), of(4));
    let what = "factor from 2 to 4 cells over a: change (relative)";
    findings.checks.push(Check::new(what, (fine / coarse - 1.0).abs(), 0.15));
    let what = "deviation of the force from its mean, from 2 to 4 cells: order, lack below 0.5";
    let order = (wide / narrow).log2();
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
        curves.push(Curve { name: name.into(), colour: colour + 2, stroke: Stroke::Dashes, points });
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
