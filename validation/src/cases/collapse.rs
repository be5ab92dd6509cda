//! A block that settles and spreads under its own weight (AMPLE's collapse).

use super::{fixed, largest, sweep};
use crate::picture::{Panel, Picture, Shapes};
use crate::scenes::{Run, load, run};
use crate::variants::{PlaneScene, plane, refined, with_points};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use mpm_solver::observe::Field;

pub(super) const CASE: Case = Case {
    name: "collapse",
    goal: "Large plastic flow under self-weight: every load step must be solved.",
    setup: "Half a block of 16 × 8 (E = 10⁶, ν = 0.3, ρ_y = 20·10³, density 1000, g = 10 in 40 load steps) on rollers, GIMP; cells of 1, 0.5 and 0.25, 2² and 6² points a cell.",
    reference: "AMPLE, 2² points: largest x and y of a point 13.5786 and 5.8539 with cells of 1 (191 linear solves), 13.7515 and 6.0557 with cells of 0.5. Both codes solve every load step. Domains come to overhang the rim of the mesh: AMPLE cuts off what is outside, here the functions of the rim's cells continue, so that a domain keeps its whole volume. The checks below measure that difference: about a thousandth.",
    run: collapses,
};

fn scene(factor: u32, points: u32) -> Result<PlaneScene, Broken> {
    Ok(with_points(refined(plane(load("collapse")?)?, factor), points))
}

/// Largest x and y of a point `[L]`.
fn extent_of(run: &Run) -> [f64; 2] {
    let positions = &run.history.last().positions;
    [0, 1].map(|i| largest(positions.chunks_exact(3).map(|x| x[i])))
}

/// The shortest load step over the nominal one.
fn shortest(run: &Run) -> f64 {
    let rows = run.history.rows();
    rows.windows(2).map(|pair| 40.0 * (pair[1].fraction - pair[0].fraction)).fold(f64::INFINITY, f64::min)
}

fn collapses(extent: Extent) -> Result<Findings, Broken> {
    let jobs: &[(u32, u32)] =
        extent.pick(&[(1, 2), (1, 6), (2, 2)], &[(1, 2), (1, 6), (2, 2), (2, 6), (4, 2), (4, 6)]);
    let runs = sweep(jobs, |&(factor, points)| run(&Scene::PlaneStrain(scene(factor, points)?)))?;
    let mut findings = Findings::default();
    let mut table = Table::new(
        "How far each run gets:",
        &[
            "cell",
            "points",
            "load reached",
            "load steps",
            "linear solves",
            "halvings",
            "shortest step",
            "largest x",
            "largest y",
            "ends because",
        ],
    );
    for (&(factor, points), run) in jobs.iter().zip(&runs) {
        let cell = 1.0 / f64::from(factor);
        let [x, y] = extent_of(run);
        let total = |column: &str| run.history.series(column, 0).iter().sum::<f64>();
        let name = format!("cells of {cell}, {points}²");
        findings.checks.push(
            Check::none(format!("{name}: does not finish"), usize::from(run.outcome.is_err()))
                .remark(run.outcome.as_ref().err().map_or(String::new(), ToString::to_string)),
        );
        findings.checks.push(
            Check::none(
                format!("{name}: load steps below 1/64 of the nominal one"),
                usize::from(shortest(run) < 1.0 / 64.0 - 1e-12),
            )
            .remark(format!("shortest 1/{}", (1.0 / shortest(run)).round())),
        );
        for (wanted, expected) in [((1, 2), [13.578_637_4, 5.853_875_8]), ((2, 2), [13.7515, 6.0557])] {
            if wanted == (factor, points) {
                let error = largest([(x / expected[0] - 1.0).abs(), (y / expected[1] - 1.0).abs()]);
                findings.checks.push(
                    Check::new(format!("{name}: largest x and y against AMPLE's (relative)"), error, 2e-3)
                        .remark(format!("{x:.7}, {y:.7}")),
                );
            }
        }
        table.push([
            cell.to_string(),
            format!("{points}²"),
            format!("{} %", fixed(100.0 * run.history.last().fraction, 1)),
            (run.history.rows().len() - 1).to_string(),
            total("newton_iterations").to_string(),
            total("cuts").to_string(),
            format!("1/{}", (1.0 / shortest(run)).round()),
            fixed(x, 7),
            fixed(y, 7),
            run.outcome.as_ref().err().map_or(String::new(), ToString::to_string),
        ]);
    }
    findings.tables.push(table);
    if extent == Extent::Full {
        let drawn = jobs.iter().position(|job| *job == (2, 2)).expect("a job");
        findings.pictures.push(picture(&runs[drawn])?);
    }
    Ok(findings)
}

/// The final shape, coloured by ρ over the yield radius.
fn picture(run: &Run) -> Result<Picture, Broken> {
    let history = &run.history;
    let rho = history.field(Field::RHO, history.rows().len() - 1);
    let outline = |corners: &Vec<[f64; 3]>| corners.iter().map(|x| (x[0], x[1])).collect::<Vec<_>>();
    let domains =
        history.outlines().iter().zip(rho).map(|(corners, rho)| (outline(corners), rho / 20e3)).collect();
    let shape = Shapes {
        title: format!("{} % of the weight", fixed(100.0 * history.last().fraction, 0)),
        range: [(0.0, 16.0), (0.0, 8.0)],
        domains,
        lines: super::mesh_lines(&Scene::PlaneStrain(scene(2, 2)?), 1.0)?,
        ..Shapes::default()
    };
    Ok(Picture {
        file: "collapse.png",
        caption: "Collapse, cells of 0.5, 2² points: domains at the end, from pale (no deviatoric stress) to red (yield).".into(),
        panels: vec![Panel::Shapes(shape)],
    })
}
