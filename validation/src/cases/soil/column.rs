//! Columns of every law under their own weight, against closed forms.

use super::{iterations, newton, scene};
use crate::cases::{fixed, scientific, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::Scene;
use mpm_solver::observe::Field;

pub(in crate::cases) const CASE: Case = Case {
    name: "columns of soil",
    goal: "Ground of every law settles under its own weight as the closed form says, at finite strain, and converges with the cells.",
    setup: "A column 10 high, one cell wide, 2² points a cell, γ = 20, on rollers, 20 load steps (160 with Cam-Clay, whose path counts). Mohr–Coulomb: E = 1000, ν = 0.2, c = 0, φ = 30°, ψ = 10°; Drucker–Prager: the same with η = 1.2, η̄ = 0.4, k = 0; von Mises and Tresca: s_u = 20; all from no stress. Cam-Clay: M = 1.05, λ = 0.12, κ = 0.025, G₀ = 0, g = 30, from K₀ = 0.6857 under a surcharge of 50. GIMP and CPDI1. Errors: Σ |J − λ(ζ)|/n over 1 − λ of the base, ζ the depth of a point at rest; settlement of the top (from ΣV) over the exact one, less 1.",
    reference: "Uniaxial compression with σ = −γ ζ: `ln λ = λ σ/E*` for Mohr–Coulomb and Drucker–Prager, `K ln λ − a s_u = λ σ` beyond first yield for von Mises (a = 2/√3) and Tresca (a = 4/3), `λ = (1 + γ ζ/s)^(−λ_c/(1 + λ_c))` for Cam-Clay.",
    run: columns,
};

const HEIGHT: f64 = 10.0;
/// Weight per volume `[F/L³]`.
const WEIGHT: f64 = 20.0;
const YOUNG: f64 = 1000.0;
const POISSON: f64 = 0.2;
const STRENGTH: f64 = 20.0;
const SURCHARGE: f64 = 50.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    MohrCoulomb,
    DruckerPrager,
    VonMises,
    Tresca,
    CamClay,
}

const LAWS: [Law; 5] = [Law::MohrCoulomb, Law::DruckerPrager, Law::VonMises, Law::Tresca, Law::CamClay];

impl Law {
    /// What tables and what the scenes call it.
    fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::MohrCoulomb => ("Mohr–Coulomb", "mohr_coulomb"),
            Self::DruckerPrager => ("Drucker–Prager", "drucker_prager"),
            Self::VonMises => ("von Mises", "von_mises"),
            Self::Tresca => ("Tresca", "tresca"),
            Self::CamClay => ("Cam-Clay", "clay"),
        }
    }

    /// Stretch under the weight above a depth at rest `[-]`.
    fn stretch(self, depth: f64) -> f64 {
        let stress = -WEIGHT * depth;
        // Kirchhoff's axial stress as a function of the axial strain.
        let tau: &dyn Fn(f64) -> f64 = match self {
            Self::MohrCoulomb => &|strain| modulus_mohr_coulomb() * strain,
            Self::DruckerPrager => &|strain| modulus_drucker_prager() * strain,
            Self::VonMises => &|strain| undrained(strain, 2.0 / 3.0_f64.sqrt()),
            Self::Tresca => &|strain| undrained(strain, 4.0 / 3.0),
            Self::CamClay => return (1.0 - stress / SURCHARGE).powf(-0.12 / 1.12),
        };
        // τ = λ σ; the difference of the two grows with the strain.
        let (mut low, mut high) = (-2.0, 0.0);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            let above = tau(middle) - middle.exp() * stress > 0.0;
            *(if above { &mut high } else { &mut low }) = middle;
        }
        (0.5 * (low + high)).exp()
    }

    /// Height under its own weight, by Simpson's rule in depth, whose kink at first yield is of no weight in 10⁴ parts.
    fn height(self) -> f64 {
        let parts = 10_000;
        let at = |k: i32| self.stretch(HEIGHT * f64::from(k) / f64::from(2 * parts));
        let sum: f64 = (0..parts).map(|k| at(2 * k) + 4.0 * at(2 * k + 1) + at(2 * k + 2)).sum();
        sum * HEIGHT / f64::from(6 * parts)
    }
}

/// E* of plastic uniaxial compression on the edge of Mohr–Coulomb's pyramid, c = 0 `[F/L²]`.
fn modulus_mohr_coulomb() -> f64 {
    let (s, t) = (30.0_f64.to_radians().sin(), 10.0_f64.to_radians().sin());
    let active = (1.0 - s) / (1.0 + s);
    let flow = 2.0 * (1.0 - t) / (1.0 + t);
    YOUNG / (1.0 - 2.0 * POISSON * active + flow * (active * (1.0 - POISSON) - POISSON))
}

/// The same on Drucker–Prager's cone, k = 0 `[F/L²]`.
fn modulus_drucker_prager() -> f64 {
    let (slope, flow) = (1.2, 0.4);
    let ratio = (3.0 - slope) / (3.0 + 2.0 * slope);
    let rate = (1.0 - flow / 3.0) / (0.5 + flow / 3.0);
    YOUNG / (1.0 - 2.0 * POISSON * ratio + rate * (ratio * (1.0 - POISSON) - POISSON))
}

/// Axial Kirchhoff stress of undrained strength: elastic to |ln λ| = 3 a s_u/4G, then `K ln λ − a s_u` `[F/L²]`.
fn undrained(strain: f64, a: f64) -> f64 {
    let (shear, bulk) = (0.5 * YOUNG / (1.0 + POISSON), YOUNG / (3.0 - 6.0 * POISSON));
    if strain > -0.75 * a * STRENGTH / shear {
        return (bulk + 4.0 / 3.0 * shear) * strain;
    }
    bulk * strain - a * STRENGTH
}

fn column(law: Law, basis: &str, cells: u32) -> Result<Scene, Broken> {
    let width = HEIGHT / f64::from(cells);
    let mut changes = vec![
        ("basis", basis.to_owned()),
        ("mesh.axes[0].to", width.to_string()),
        ("mesh.axes[1].cells", cells.to_string()),
        ("bodies[0].material", format!("{:?}", law.names().1)),
        ("bodies[0].shape.to", format!("({width}, {HEIGHT})")),
        ("supports[2].region.at", width.to_string()),
    ];
    if law == Law::CamClay {
        changes.push(("schedule.steps", "160".to_owned()));
        changes.push(("loads[1].resultant", format!("(0, {})", -SURCHARGE * width)));
        return scene("column_cam_clay", &changes);
    }
    scene("column", &changes)
}

/// What a run has to show.
struct Settled {
    /// Mean error of the stretch over 1 − λ of the base.
    stretch: f64,
    /// Relative error of the settlement.
    settlement: f64,
    /// Error of the stretch of the lowest points.
    base: f64,
    iterations: f64,
    newton: Option<Check>,
    /// Depth at rest and stretch of every point.
    profile: Vec<(f64, f64)>,
}

fn settled(law: Law, label: &str, height: f64, history: &History) -> Settled {
    let last = history.rows().len() - 1;
    let ratios = history.field(Field::VOLUME_RATIO, last);
    let depths = history.rows()[0].positions.chunks_exact(3).map(|x| HEIGHT - x[1]);
    let profile: Vec<(f64, f64)> = depths.zip(ratios.iter().copied()).collect();
    let n = ratios.len() as f64;
    let error = |&(depth, ratio): &(f64, f64)| (ratio - law.stretch(depth)).abs();
    let lowest = profile.iter().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, error);
    let top = HEIGHT * ratios.iter().sum::<f64>() / n;
    Settled {
        stretch: profile.iter().map(error).sum::<f64>() / n / (1.0 - law.stretch(HEIGHT)),
        settlement: ((HEIGHT - top) / (HEIGHT - height) - 1.0).abs(),
        base: lowest,
        iterations: iterations(history),
        newton: newton(label, history),
        profile,
    }
}

fn columns(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[8, 16, 32], &[8, 16, 32, 64, 128, 256]);
    let mut jobs = Vec::new();
    for law in LAWS {
        for basis in ["Gimp", "Cpdi1"] {
            jobs.extend(meshes.iter().map(|&cells| (law, basis, cells)));
        }
    }
    let heights = LAWS.map(|law| (law, law.height()));
    let height = |law: Law| heights.iter().find(|it| it.0 == law).map_or(f64::NAN, |it| it.1);
    let runs = sweep(&jobs, |&(law, basis, cells)| {
        let history = run(&column(law, basis, cells)?)?.completed()?;
        let label = format!("{}, {}, {cells} cells", law.names().0, basis.to_uppercase());
        Ok(settled(law, &label, height(law), &history))
    })?;
    let mut findings = Findings::default();
    let heads = ["law", "basis", "cells", "stretch", "order", "settlement", "base", "Newton iterations"];
    let mut table = Table::new(
        "Mean error of the stretch over 1 − λ of the base and its order between two meshes, relative error of the settlement, error of the stretch of the lowest point, and Newton iterations in all load steps. Order 1.5 of the undrained laws is that of the kink at the depth of first yield. In Cam-Clay with GIMP, whose domains overlap as points near the top unload and load again by turns, the error of the path that they have taken stays, and the order is below 1:",
        &heads,
    );
    for (jobs, runs) in jobs.chunks(meshes.len()).zip(runs.chunks(meshes.len())) {
        let (law, basis, _) = jobs[0];
        let label = law.names().0;
        for (k, (job, run)) in jobs.iter().zip(runs).enumerate() {
            let order =
                if k > 0 { fixed((runs[k - 1].stretch / run.stretch).log2(), 2) } else { String::new() };
            table.push([
                label.to_owned(),
                basis.to_uppercase(),
                job.2.to_string(),
                scientific(run.stretch, 3),
                order,
                scientific(run.settlement, 2),
                scientific(run.base, 2),
                run.iterations.to_string(),
            ]);
        }
        findings.checks.extend(checks(law, &format!("{label}, {}", basis.to_uppercase()), meshes, runs));
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        findings.pictures.push(picture(&jobs, &runs));
    }
    Ok(findings)
}

/// Where GIMP carries the history of its overlaps along, errors are larger.
fn checks(law: Law, label: &str, meshes: &[u32], runs: &[Settled]) -> Vec<Check> {
    let rough = law == Law::CamClay && label.ends_with("GIMP");
    let (least, settlement, base) = if rough { (0.6, 1.5e-2, 5e-3) } else { (1.3, 1e-4, 2e-3) };
    let mut checks = Vec::new();
    for pair in [[8, 32], [32, 128]] {
        let [Some(coarse), Some(fine)] = pair.map(|n| meshes.iter().position(|&it| it == n)) else { continue };
        let order = (runs[coarse].stretch / runs[fine].stretch).log2() / 2.0;
        let what =
            format!("{label}: order of the stretch from {} to {} cells, lack below {least}", pair[0], pair[1]);
        checks.push(
            Check::new(what, (least - order).max(0.0) + 0.0 * order, 0.0).remark(format!("order {order:.2}")),
        );
    }
    if let Some(at) = meshes.iter().position(|&it| it == 32) {
        let run = &runs[at];
        checks.push(Check::new(
            format!("{label}, 32 cells: settlement (relative)"),
            run.settlement,
            settlement,
        ));
        checks.push(Check::new(format!("{label}, 32 cells: stretch of the base"), run.base, base));
        checks.extend(run.newton.clone());
    }
    checks
}

fn picture(jobs: &[(Law, &str, u32)], runs: &[Settled]) -> Picture {
    let mut profiles = Vec::new();
    for (colour, law) in LAWS.into_iter().enumerate() {
        let exact = (0..=100).map(|k| f64::from(k) * 0.1).map(|depth| (law.stretch(depth), -depth)).collect();
        profiles.push(Curve { name: law.names().0.into(), colour, stroke: Stroke::Line, points: exact });
        let found = jobs.iter().zip(runs).find(|(job, _)| **job == (law, "Cpdi1", 16));
        let points = found.map_or(Vec::new(), |(_, run)| run.profile.iter().map(|it| (it.1, -it.0)).collect());
        profiles.push(Curve { name: String::new(), colour, stroke: Stroke::Marks, points });
    }
    let mut errors = Vec::new();
    for (colour, law) in LAWS.into_iter().enumerate() {
        for (basis, stroke) in [("Cpdi1", Stroke::Line), ("Gimp", Stroke::Dashes)] {
            let of = jobs.iter().zip(runs).filter(|(job, _)| job.0 == law && job.1 == basis);
            let points = of.map(|(job, run)| (f64::from(job.2), run.stretch)).collect();
            errors.push(Curve {
                name: format!("{}, {}", law.names().0, basis.to_uppercase()),
                colour,
                stroke,
                points,
            });
        }
    }
    Picture {
        file: "soil_columns.svg",
        caption: "Columns of soil: stretch against depth (lines exact, marks CPDI1, 16 cells) and its error against the number of cells.".into(),
        panels: vec![
            Panel::Curves(Curves {
                title: "Stretch".into(),
                axes: ["stretch", "−depth at rest"].map(String::from),
                range: [(0.76, 1.0), (-10.0, 0.0)],
                logarithmic: [false; 2],
                legend: Legend::UpperLeft,
                curves: profiles,
            }),
            Panel::Curves(Curves {
                title: "Error of the stretch".into(),
                axes: ["cells", "error"].map(String::from),
                range: [(6.0, 400.0), (1e-5, 0.1)],
                logarithmic: [true; 2],
                legend: Legend::LowerLeft,
                curves: errors,
            }),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heights and stretches of the base, computed apart with more digits.
    #[test]
    fn closed_forms_have_the_digits_of_the_table() {
        for (law, height, base) in [
            (Law::MohrCoulomb, 9.187_419_258_43, 0.849_434_804_527),
            (Law::DruckerPrager, 9.189_332_335_05, 0.849_763_797_187),
            (Law::VonMises, 8.919_378_44, 0.785_637_198_838),
            (Law::Tresca, 8.954_027_85, 0.789_583_271_125),
            (Law::CamClay, 8.982_525_608_91, 0.841_608_972_065),
        ] {
            assert!((law.height() - height).abs() < 1e-8, "{law:?}: {}", law.height());
            assert!((law.stretch(HEIGHT) - base).abs() < 1e-9, "{law:?}: {}", law.stretch(HEIGHT));
        }
        assert!((modulus_mohr_coulomb() - 1_041.075_539_486_89).abs() < 1e-9);
        assert!((modulus_drucker_prager() - 1_043.956_043_956_04).abs() < 1e-9);
    }
}
