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
    goal: "A cone that is pushed into clay finds a steady resistance, which depends neither on the ground's size nor on the depth of the start, converges with the mesh, and lies within what is published of its dependence on stiffness and roughness.",
    setup: "A cone of 60° and its shaft, radius a = 1, stand three diameters deep in weightless clay of radius 30 and depth 37, and are pushed in by eight diameters. s_u = 1, ν = 0.49, I = G/s_u; von Mises with s_u in pure shear, Tresca; adhesion α on the cone, carried by a skin just inside it, none on the shaft. CPDI1 with reshaped domains, ghost faces; n cells of equal width over a, up to 1.5 a and from 3 a deep to half a diameter below the last place of the tip, growing by 1.4 beyond; up to about 2 a 2² points a cell with mean dilatation over points, beyond one point a cell; load steps of a fifth of the width of a cell; contact stiffness 2, with which the deepest corner of a domain is mostly 0.03 to 0.08 of a point's width inside the cone. *Wide*: radius and depth 60. *Deep*: from eight diameters. 8 cells: by seven diameters.",
    reference: "Published fits, for clay without stress: Teh & Houlsby (Géotechnique 41, 1991) `(4/3)(1 + ln I)(1.25 + I/2000) + 2.4 α` and Yu, Herrmann & Boulanger (J. Geotech. Geoenviron. Eng. 126, 2000) `0.33 + 2 ln I + 2.37 α` of von Mises' law, Lu, Randolph, Hu & Bugarski (Géotechnique 54, 2004) `3.4 + 1.6 ln I + 1.3 α` of Tresca's. The band: from a tenth below the least of the three to 0.4/n above the largest, because the mesh's error is positive and of first order. Factors are means over a diameter of the way, weighted by the way; the steady factor is that of the last two. Around a shaft clay is plastic up to about √I a: the factor is steady once the shaft that the cone has driven is about as long.",
    run: cone,
};

/// Clay, cone, and mesh.
#[derive(Clone, Copy, PartialEq)]
struct Test {
    is_tresca: bool,
    /// G/s_u.
    rigidity: f64,
    /// α/s_u.
    adhesion: f64,
    /// Cells over the radius of the cone.
    cells: u32,
    /// Radius of the ground over that of the cone.
    radius: f64,
    /// Its depth.
    depth: f64,
    /// Depth of the tip at the start.
    start: f64,
    /// Way of the cone.
    way: f64,
}

/// Von Mises' law, smooth, on the usual ground.
const PLAIN: Test = Test {
    is_tresca: false,
    rigidity: 100.0,
    adhesion: 0.0,
    cells: 4,
    radius: 30.0,
    depth: 37.0,
    start: 6.0,
    way: 16.0,
};

/// On wide and deep ground.
const WIDE: Test = Test { radius: 60.0, depth: 60.0, ..PLAIN };

/// From eight diameters.
const DEEP: Test = Test { start: 16.0, depth: 47.0, ..PLAIN };

/// By seven diameters.
const FINE: Test = Test { cells: 8, way: 14.0, depth: 33.0, ..PLAIN };

/// How much wider each cell is than the one before, away from the cone.
const RATIO: f64 = 1.4;

/// From the base of the cone to its tip, for 60°.
const HEIGHT: f64 = 1.732_051;

impl Test {
    fn clay(self) -> String {
        let law = if self.is_tresca { "Tresca" } else { "von Mises" };
        let ground = match (self.radius > PLAIN.radius, self.start > PLAIN.start) {
            (true, _) => ", wide",
            (_, true) => ", deep",
            _ => "",
        };
        format!("{law}, G/s_u = {}, α = {} s_u{ground}", self.rigidity, self.adhesion)
    }

    fn name(self) -> String {
        format!("{}, {} cells", self.clay(), self.cells)
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

    /// Lines along the axis: fine from a depth of 3 a to half a diameter below the last place of the tip.
    fn heights(self) -> Vec<f64> {
        const TOP: f64 = 3.0;
        let below = lines(self.cells, self.start - TOP + self.way + 1.0, RATIO, self.depth - TOP);
        let mut above = lines(self.cells, 0.0, RATIO, TOP);
        // What heaves.
        let (end, width) = (TOP, above[above.len() - 1] - above[above.len() - 2]);
        above.extend([end + width, end + 3.0 * width]);
        below.iter().rev().map(|x| -TOP - x).chain(above.iter().skip(1).map(|x| x - TOP)).collect()
    }

    /// The cone with its shaft, and its skin where it is rough: a tool has one adhesion, so that of the cone's face is
    /// carried by a tool of its own, which lies 0.005 inside and meets nothing.
    fn tools(self) -> String {
        let motion = format!("motion: Move(by: (0, {:?}))", -self.way);
        let (tip, shoulder, top) = (-self.start, HEIGHT - self.start, self.way + 2.0);
        let cone = format!(
            "(name: \"cone\", parts: [Polygon(vertices: [(0, {tip:?}), (1, {shoulder:?}), (1, {top:?}), (0, {top:?})])], \
             rounding: 0.1, {motion}, interface: (stiffness: 2))"
        );
        if self.adhesion == 0.0 {
            return format!("[{cone}]");
        }
        let (low, high, adhesion) = (tip + 0.1832, shoulder + 0.001_349, self.adhesion);
        format!(
            "[{cone}, (name: \"skin\", parts: [Polygon(vertices: [(0, {low:?}), (0.1, {low:?}), (0.995, {high:?}), \
             (0, {high:?})])], rounding: 0.03, {motion}, interface: (adhesion: {adhesion}, stiffness: 2))]"
        )
    }

    /// Force on the cone, with its skin where it is rough, over π a² s_u, along its way.
    fn path(self) -> Result<Vec<(f64, f64)>, Broken> {
        let radii = lines(self.cells, 1.5, RATIO, self.radius);
        // Where fine points end: a line of the mesh.
        let near = radii.iter().copied().find(|radius| *radius >= 2.0).unwrap_or(f64::NAN);
        let (law, base) = (if self.is_tresca { "tresca" } else { "clay" }, -self.depth);
        let young = format!("materials.{law}.young");
        let history = run(&scene(
            "cone",
            &[
                (&*young, (2.0 * 1.49 * self.rigidity).to_string()),
                ("mesh.axes[0]", format!("Nodes({})", list(radii))),
                ("mesh.axes[1]", format!("Nodes({})", list(self.heights()))),
                ("bodies[0].material", format!("{law:?}")),
                ("bodies[1].material", format!("{law:?}")),
                ("bodies[0].shape.from", format!("(0, {base:?})")),
                ("bodies[0].shape.to", format!("({near:?}, 0)")),
                ("bodies[1].shape.from", format!("({near:?}, {base:?})")),
                ("bodies[1].shape.to", format!("({:?}, 0)", self.radius)),
                ("supports[0].region.at", format!("{:?}", self.radius)),
                ("supports[1].region.at", format!("{base:?}")),
                ("tools", self.tools()),
                ("schedule.steps", (5.0 * self.way * f64::from(self.cells)).to_string()),
                ("output.fields", "[]".into()),
            ],
        )?)?
        .completed()?;
        Ok(self.force(&history))
    }

    fn force(self, history: &History) -> Vec<(f64, f64)> {
        let mut force = of_tool(history, "cone", "force", 1);
        if self.adhesion > 0.0 {
            force.iter_mut().zip(of_tool(history, "skin", "force", 1)).for_each(|(sum, skin)| *sum += skin);
        }
        let ways = history.rows().iter().map(|row| self.way * row.fraction);
        ways.zip(force).map(|(way, force)| (way, force / PI)).collect()
    }
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

/// Mean over a diameter, the first being 1.
fn over(path: &[(f64, f64)], diameter: u32) -> f64 {
    let end = 2.0 * f64::from(diameter);
    mean(path, end - 2.0, end).0
}

/// A test with its path.
type Run = (Test, Vec<(f64, f64)>);

/// The steady factor, which is the mean over the last two diameters, and the deviation of the force from it.
fn steady((test, path): &Run) -> (f64, f64) {
    mean(path, test.way - 4.0, test.way)
}

fn cone(extent: Extent) -> Result<Findings, Broken> {
    let coarse = Test { cells: 2, ..PLAIN };
    let tests = match extent {
        Extent::Full => vec![
            // The longest first.
            FINE,
            Test { adhesion: 0.5, ..PLAIN },
            Test { adhesion: 1.0, ..PLAIN },
            Test { rigidity: 300.0, ..PLAIN },
            Test { is_tresca: true, ..PLAIN },
            WIDE,
            DEEP,
            PLAIN,
            Test { rigidity: 50.0, ..PLAIN },
            coarse,
        ],
        _ => vec![coarse],
    };
    let paths = sweep(&tests, |test| test.path())?;
    let runs: Vec<Run> = tests.into_iter().zip(paths).collect();
    let mut findings = Findings::default();
    for run in &runs {
        let (test, path) = run;
        let (name, (factor, _), published) = (test.name(), steady(run), test.published());
        let low = 0.9 * published.iter().copied().fold(f64::INFINITY, f64::min);
        let high = (1.0 + 0.4 / f64::from(test.cells)) * published.iter().copied().fold(0.0, f64::max);
        let outside = usize::from(!(low..=high).contains(&factor));
        let said = format!("{factor:.2} in {low:.2} to {high:.2}");
        findings
            .checks
            .push(Check::none(format!("{name}: steady factor outside the band"), outside).remark(said));
        // Clay of I = 300 is plastic up to 17 a around the shaft.
        let fifth = if test.rigidity > PLAIN.rigidity { 0.06 } else { 0.05 };
        for (diameter, allowed) in [(5, fifth), (6, 0.03)] {
            let change = over(path, diameter) / factor - 1.0;
            let what = format!("{name}: diameter {diameter} against the steady factor (relative)");
            findings.checks.push(Check::new(what, change.abs(), allowed).remark(fixed(change, 4)));
        }
    }
    findings.tables.push(factors(&runs));
    if extent == Extent::Full {
        refined(&runs, &mut findings);
        findings.pictures.push(picture(&runs));
    }
    Ok(findings)
}

fn factors(runs: &[Run]) -> Table {
    let mut heads = vec!["clay".to_owned(), "cells over a".into()];
    heads.extend((1..=8).map(|diameter| diameter.to_string()));
    heads.extend(["steady", "deviation", "Teh & Houlsby", "Yu et al.", "Lu et al."].map(String::from));
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = Table::new("Cone factor, mean over each diameter of the way; published fits:", &heads);
    for run in runs {
        let ((test, path), (factor, deviation)) = (run, steady(run));
        let numbers = (1..=8).map(|diameter| over(path, diameter)).chain([factor, deviation]);
        // Nothing where the cone was not pushed so far.
        let numbers = numbers
            .chain(test.published())
            .map(|factor| if factor.is_nan() { String::new() } else { fixed(factor, 2) });
        table.push([test.clay(), test.cells.to_string()].into_iter().chain(numbers));
    }
    table
}

/// How the factor changes with the mesh and with the ground.
fn refined(runs: &[Run], findings: &mut Findings) {
    let of = |test: Test| runs.iter().find(|run| run.0 == test).map_or((f64::NAN, f64::NAN), steady);
    let meshes = [Test { cells: 2, ..PLAIN }, PLAIN, FINE].map(of);
    for (k, allowed) in [(0, 0.15), (1, 0.05)] {
        let (cells, change) = (2 << k, meshes[k + 1].0 / meshes[k].0 - 1.0);
        let what = format!("steady factor, from {cells} to {} cells over a: change (relative)", 2 * cells);
        findings.checks.push(Check::new(what, change.abs(), allowed).remark(fixed(change, 4)));
    }
    let extrapolated = 2.0 * meshes[2].0 - meshes[1].0;
    // The two fits of von Mises' law.
    let published = 0.5 * (PLAIN.published()[0] + PLAIN.published()[1]);
    let what = "steady factor, extrapolated from 4 and 8 cells, against the mean of the fits of von Mises' law (relative)";
    let said = format!("{extrapolated:.2}, {published:.2}");
    findings.checks.push(Check::new(what, (extrapolated / published - 1.0).abs(), 0.05).remark(said));
    let what = "deviation of the force from the steady factor, from 2 to 8 cells: order, lack below 0.5";
    let order = 0.5 * (meshes[0].1 / meshes[2].1).log2();
    findings.checks.push(Check::new(what, (0.5 - order).max(0.0) + 0.0 * order, 0.0).remark(fixed(order, 2)));
    for (what, test) in [("wide ground", WIDE), ("deep start", DEEP)] {
        let change = of(test).0 / meshes[1].0 - 1.0;
        let what = format!("{what}: change of the steady factor (relative)");
        findings.checks.push(Check::new(what, change.abs(), 0.015).remark(fixed(change, 4)));
    }
}

/// Forces on three meshes, and means over a diameter of every test.
fn picture(runs: &[Run]) -> Picture {
    let smooth = |path: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let ends = (8..=64).map(|k| 0.25 * f64::from(k));
        ends.map(|end| (0.5 * (end - 1.0), mean(path, end - 2.0, end).0)).collect()
    };
    let curve = |name: String, colour, points| Curve { name, colour, stroke: Stroke::Line, points };
    let panel = |title: &str, curves| {
        Panel::Curves(Curves {
            title: title.into(),
            axes: ["way over diameter", "cone factor"].map(String::from),
            range: [(0.0, 8.0), (0.0, 14.0)],
            logarithmic: [false; 2],
            legend: Legend::LowerRight,
            curves,
        })
    };
    let meshes = runs.iter().filter(|(test, _)| test.clay() == PLAIN.clay()).enumerate();
    let mut meshes: Vec<Curve> = meshes
        .map(|(colour, (test, path))| {
            let points = path.iter().map(|(way, force)| (0.5 * way, *force)).collect();
            curve(format!("{} cells", test.cells), colour, points)
        })
        .collect();
    for (colour, (name, limit)) in
        ["Teh & Houlsby", "Yu et al.", "Lu et al."].into_iter().zip(PLAIN.published()).enumerate()
    {
        let points = vec![(0.0, limit), (8.0, limit)];
        meshes.push(Curve { name: name.into(), colour: colour + 3, stroke: Stroke::Dashes, points });
    }
    let means = runs.iter().filter(|(test, _)| test.cells == 4).enumerate();
    let means = means.map(|(colour, (test, path))| curve(test.clay(), colour, smooth(path))).collect();
    Picture {
        file: "cone.svg",
        caption: "Cone in clay: force over π a² s_u against the way in diameters; von Mises, G/s_u = 100, and, as means over a diameter, 4 cells over the radius."
            .into(),
        panels: vec![panel("Three meshes", meshes), panel("Means over a diameter", means)],
    }
}
