//! Cylindrical cavities that are driven open.

use super::{iterations, newton, scene};
use crate::cases::{fixed, largest, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::Scene;
use std::f64::consts::FRAC_PI_2;

pub(in crate::cases) const RING: Case = Case {
    name: "cavity in a ring",
    goal: "A cavity that is driven open to twice its radius in sand and in clay meets the pressure of the one-dimensional solution.",
    setup: "A quarter of a ring from radius 1 to 10 under σ₀ = −100 I, the outer face held, the inner one driven to 2 in 100 load steps; the mesh expands with it. Mohr–Coulomb: E = 10000, ν = 0.2, c = 1, φ = 30°, ψ = 10°, mean dilatation over points; Tresca: E = 3000, ν = 0.49, s_u = 10, mean dilatation of cells. CPDI1, 2² points a cell; cells n along the radius (the last four times as long as the first) × n/2 around. The pressure is that on the node at 45°.",
    reference: "The same equations in one dimension, solved apart (480 elements; mesh and steps converged to 5e-6).",
    run: ring,
};

pub(in crate::cases) const INFINITE: Case = Case {
    name: "cavity in unbounded clay",
    goal: "Cavity pressure in unbounded ground tends to the limit of Gibson and Anderson, and that in a thick cylinder to Hill's.",
    setup: "Tresca, G/s_u = 100, ν = 0.4995, mean dilatation of cells, CPDI1, 2² points a cell, 100 load steps. Unbounded: a quarter of a ring from 1 to 400 with a free outer edge, n cells along the radius (the last 400 times as long as the first) × n/6 around, driven to a = 2. Thick cylinder: from 1 to 2, free outside, n/3 cells along the radius, G/s_u = 10⁵, driven to a = 1.0001.",
    reference: "`p = s_u [1 + ln(G/s_u) + ln(1 − 1/a²)] + s_u²/4G` with Hencky's law, plastic from a = 1.005 on; `p = 2 s_u ln 2` when all of the cylinder is plastic.",
    run: infinite,
};

/// Radii at which the pressure is compared; the load step that ends there is 100 (a − 1).
pub(in crate::cases) const RADII: [f64; 9] = [1.01, 1.02, 1.05, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0];
pub(in crate::cases) const SAND: [f64; 9] =
    [178.654, 223.236, 304.058, 392.324, 521.909, 731.833, 926.577, 1_121.016, 1_320.310];
pub(in crate::cases) const CLAY: [f64; 9] =
    [127.159, 144.121, 184.015, 244.330, 366.244, 636.763, 950.079, 1_312.796, 1_727.809];

/// A curve of pressure against radius, found.
pub(in crate::cases) struct Pressed {
    /// Radius and pressure after every load step.
    pub(in crate::cases) path: Vec<(f64, f64)>,
    pub(in crate::cases) history: History,
}

impl Pressed {
    fn at(&self, radius: f64) -> f64 {
        self.path.iter().find(|it| (it.0 - radius).abs() < 1e-9).map_or(f64::NAN, |it| it.1)
    }

    /// Errors at the radii, of the reference.
    pub(in crate::cases) fn errors(&self, reference: &[f64; 9]) -> Vec<f64> {
        RADII.iter().zip(reference).map(|(&radius, p)| self.at(radius) / p - 1.0).collect()
    }
}

/// The pressure on the node `gauge`, whose neighbours stand a sector away on either side: p a sin(sector).
fn pressed(scene: &Scene, sectors: u32, opening: f64) -> Result<Pressed, Broken> {
    let history = run(scene)?.completed()?;
    Ok(Pressed { path: pressures(&history, sectors, opening), history })
}

/// Radius and pressure after every load step.
fn pressures(history: &History, sectors: u32, opening: f64) -> Vec<(f64, f64)> {
    let force = |component| history.series("reaction/gauge", component);
    let (x, y) = (force(0), force(1));
    let width = (FRAC_PI_2 / f64::from(sectors)).sin();
    let radii = history.rows().iter().map(|row| 1.0 + opening * row.fraction);
    radii.zip(x.iter().zip(&y)).map(|(a, (x, y))| (a, x.hypot(*y) / (a * width))).collect()
}

fn ring(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[16, 32], &[16, 32, 64]);
    let laws = [("sand", "Points", SAND), ("clay", "Cell", CLAY)];
    let jobs: Vec<_> = laws.iter().flat_map(|law| meshes.iter().map(move |&cells| (law, cells))).collect();
    let runs = sweep(&jobs, |&((law, mean, _), cells)| {
        let changes = [
            ("mesh.radii.cells", cells.to_string()),
            ("mesh.sectors", (cells / 2).to_string()),
            ("bodies[0].material", format!("{law:?}")),
            ("bodies[0].mean_dilatation", (*mean).to_owned()),
            ("output.fields", "[]".to_owned()),
        ];
        pressed(&scene("cavity", &changes)?, cells / 2, 1.0)
    })?;
    let mut findings = Findings::default();
    for ((law, _, reference), runs) in laws.iter().zip(runs.chunks(meshes.len())) {
        findings.tables.push(table(&format!("Cavity in {law}"), reference, meshes, runs));
        for (&cells, run) in meshes.iter().zip(runs) {
            let tolerance = if *law == "sand" { 4.0 } else { 0.41 } / f64::from(cells * cells);
            let worst = largest(run.errors(reference).iter().map(|it| it.abs()));
            let what = format!("{law}, {cells} cells: pressure, worst of {} radii (relative)", RADII.len());
            findings.checks.push(Check::new(what, worst, tolerance));
            findings.checks.extend(newton(&format!("{law}, {cells} cells"), &run.history));
        }
    }
    under_pressure(&mut findings)?;
    if extent == Extent::Full {
        findings.pictures.push(picture(&laws, meshes, &runs));
    }
    Ok(findings)
}

/// Cavities in clay with averages over points, which pressure spoils: the runs have to say so.
fn under_pressure(findings: &mut Findings) -> Result<(), Broken> {
    let heads = ["σ₀", "error at 1.05", "1.1", "1.2", "1.4", "reached", "pressure over shear stress"];
    let text = "Clay with mean dilatation over points, 16 cells: a pressure of tens of times the strength drives motions \
                of the nodes amid the ground. Under σ₀ = −1000 I the run ends early. Both runs tell of the pressure:";
    let mut table = Table::new(text, &heads);
    for (stress, opening) in [(-100, 0.4), (-1000, 0.3)] {
        let changes = [
            ("mesh.radii.cells", "16".to_owned()),
            ("mesh.sectors", "8".to_owned()),
            ("motion.displacement", opening.to_string()),
            ("bodies[0].material", "\"clay\"".to_owned()),
            ("bodies[0].initial", format!("Stress(xx: {stress}, yy: {stress}, zz: {stress})")),
            ("schedule", format!("(steps: {}, cuts: 2)", 100.0 * opening)),
            ("output.fields", "[]".to_owned()),
        ];
        let ended = run(&scene("cavity", &changes)?)?;
        let path = pressures(&ended.history, 8, opening);
        let at = |radius: f64| path.iter().find(|it| (it.0 - radius).abs() < 1e-9);
        let errors = [2, 3, 4, 5].map(|k| {
            let error = at(RADII[k]).map(|it| 100.0 * (it.1 / CLAY[k] - 1.0));
            error.filter(|_| stress == -100).map_or(String::new(), |error| format!("{} %", fixed(error, 2)))
        });
        let (ratio, is_told) = match &ended.outcome {
            Ok(summary) => (summary.pressure_over_shear, summary.pressure_over_shear.is_some()),
            Err(error) => (None, error.to_string().contains("where points yield, pressure is")),
        };
        let reached = fixed(path.last().map_or(1.0, |it| it.0), 2);
        let ratio = ratio.map_or(String::new(), |ratio| fixed(ratio, 0));
        table.push([stress.to_string()].into_iter().chain(errors).chain([reached, ratio]));
        let what = format!("clay, averages over points, σ₀ = {stress}: runs that do not tell of the pressure");
        findings.checks.push(Check::none(what, usize::from(!is_told)));
    }
    findings.tables.push(table);
    Ok(())
}

pub(in crate::cases) fn table(name: &str, reference: &[f64; 9], meshes: &[u32], runs: &[Pressed]) -> Table {
    let counts: Vec<String> = runs.iter().map(|run| iterations(&run.history).to_string()).collect();
    let text = format!(
        "{name}: pressure, and the error on each mesh; Newton iterations in 100 load steps: {}.",
        counts.join(", ")
    );
    let heads: Vec<String> = ["radius".into(), "reference".into()]
        .into_iter()
        .chain(meshes.iter().map(|cells| format!("{cells} cells")))
        .collect();
    let mut table = Table::new(text, &heads.iter().map(String::as_str).collect::<Vec<_>>());
    for (k, radius) in RADII.iter().enumerate() {
        let errors = runs.iter().map(|run| format!("{} %", fixed(100.0 * run.errors(reference)[k], 3)));
        table.push([fixed(*radius, 2), fixed(reference[k], 4)].into_iter().chain(errors));
    }
    table
}

fn picture(laws: &[(&str, &str, [f64; 9]); 2], meshes: &[u32], runs: &[Pressed]) -> Picture {
    let mut curves = Vec::new();
    for (colour, ((law, _, reference), runs)) in laws.iter().zip(runs.chunks(meshes.len())).enumerate() {
        let points = RADII.into_iter().zip(*reference).collect();
        curves.push(Curve { name: String::new(), colour, stroke: Stroke::Marks, points });
        let points = runs.last().map_or(Vec::new(), |run| run.path[1..].to_vec());
        curves.push(Curve { name: (*law).into(), colour, stroke: Stroke::Line, points });
    }
    Picture {
        file: "soil_cavity.svg",
        caption: "Cavity in a ring: pressure against radius (marks: one-dimensional solution).".into(),
        panels: vec![Panel::Curves(Curves {
            title: "Cavity in a ring".into(),
            axes: ["radius", "pressure"].map(String::from),
            range: [(1.0, 2.0), (0.0, 1800.0)],
            logarithmic: [false; 2],
            legend: Legend::UpperLeft,
            curves,
        })],
    }
}

fn infinite(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[24, 48], &[24, 48, 96]);
    let (strength, shear) = (1.0_f64, 100.0_f64);
    let limit = |a: f64| {
        strength * (1.0 + (shear / strength).ln() + (1.0 - 1.0 / (a * a)).ln())
            + strength * strength / (4.0 * shear)
    };
    let reference = RADII.map(limit);
    let runs = sweep(meshes, |&cells| {
        let changes = [
            ("mesh.radii.cells", cells.to_string()),
            ("mesh.sectors", (cells / 6).to_string()),
            ("output.fields", "[]".to_owned()),
        ];
        pressed(&scene("cavity_infinite", &changes)?, cells / 6, 1.0)
    })?;
    let thick = sweep(meshes, |&cells| {
        let changes = [
            ("mesh.radii", format!("Uniform(from: 1, to: 2, cells: {})", cells / 3)),
            ("mesh.sectors", (cells / 6).to_string()),
            ("motion", "Expand(anchor: 2, driven: 1, displacement: 1e-4)".to_owned()),
            ("materials.clay.young", 2.999e5.to_string()),
            ("bodies[0].shape.outer", "2".to_owned()),
            ("output.fields", "[]".to_owned()),
        ];
        pressed(&scene("cavity_infinite", &changes)?, cells / 6, 1e-4)
    })?;
    let mut findings = Findings::default();
    findings.tables.push(table("Unbounded clay", &reference, meshes, &runs));
    for ((&cells, run), thick) in meshes.iter().zip(&runs).zip(&thick) {
        let square = f64::from(cells * cells);
        let worst = largest(run.errors(&reference).iter().map(|it| it.abs()));
        let what = format!("unbounded, {cells} cells: pressure, worst of {} radii (relative)", RADII.len());
        findings.checks.push(Check::new(what, worst, 5.76 / square));
        let end = thick.path.last().map_or(f64::NAN, |it| it.1);
        let what = format!("thick cylinder, {} cells: limit pressure (relative)", cells / 3);
        let error = (end / (2.0 * 2.0_f64.ln()) - 1.0).abs();
        findings.checks.push(Check::new(what, error, 25.0 / square).remark(format!("{end:.5} s_u")));
    }
    Ok(findings)
}
