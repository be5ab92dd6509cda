//! A block that settles and spreads under its own weight (AMPLE's collapse).

use super::{fixed, largest, sweep};
use crate::picture::{Panel, Patch, Picture, Shapes};
use crate::scenes::{Run, load, run};
use crate::variants::{PlaneScene, plane, refined, with_points};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use mpm_scene::language::{AxisInput, Coordinates, Direction, MeshInput, RegionInput, SupportInput};
use mpm_solver::observe::Field;

pub(super) const CASE: Case = Case {
    name: "collapse",
    goal: "Large plastic flow under self-weight: every load step must be solved.",
    setup: "Half a block of 16 × 8 (E = 10⁶, ν = 0.3, ρ_y = 20·10³, density 1000, g = 10 in 40 load steps) on rollers, GIMP; cells of 1, 0.5 and 0.25, 2² and 6² points a cell.",
    reference: "AMPLE, 2² points: largest x and y of a point 13.5786 and 5.8539 with cells of 1 (191 linear solves), 13.7515 and 6.0557 with cells of 0.5. Both codes solve every load step. Domains come to overhang the rim of the mesh, on the base and on the line of symmetry: AMPLE cuts off what is outside, here the functions of the rim's cells continue, so that a domain keeps its whole volume. The third way is a mesh that goes on beyond the rim by a row of cells, with all nodes there held. With it, the answer differs from ours by less than AMPLE's does, and to the same side; with cells of 1 such a row is so little filled that the run ends before its last load step.",
    run: collapses,
};

/// Refinement and points per direction of a cell; largest x and y of a point `[L]`.
const AMPLE: [((u32, u32), [f64; 2]); 2] = [((1, 2), [13.578_637_4, 5.853_875_8]), ((2, 2), [13.7515, 6.0557])];

fn scene(factor: u32, points: u32) -> Result<PlaneScene, Broken> {
    Ok(with_points(refined(plane(load("collapse")?)?, factor), points))
}

/// The scene in a mesh that goes on beyond the base and the line of symmetry by a row of cells, with all nodes there held.
fn walled(factor: u32) -> Result<PlaneScene, Broken> {
    const FAR: f64 = 1e3;
    let mut scene = scene(factor, 2)?;
    let cell = 1.0 / f64::from(factor);
    let MeshInput::Box { axes } = &mut scene.mesh else { return Err("the collapse has a box mesh".into()) };
    for axis in axes {
        let AxisInput::Uniform { from, cells, .. } = axis else { return Err("its cells are equal".into()) };
        from.0 -= cell;
        cells.0 += 1;
    }
    let below = |d: usize, at: f64| {
        let mut to = [FAR; 2];
        to[d] = at;
        RegionInput::Box { from: Coordinates([-FAR; 2]), to: Coordinates(to) }
    };
    for (k, d, name) in [(0, 1, "below"), (1, 0, "left")] {
        scene.supports[k].region = below(d, 0.0);
        let held = SupportInput {
            name: name.into(),
            region: below(d, -0.5 * cell),
            fix: vec![Direction::X, Direction::Y],
            ..scene.supports[k].clone()
        };
        scene.supports.push(held);
    }
    Ok(scene)
}

/// What the rim of the mesh does to the answer: with a row of cells beyond it against functions that continue.
fn rims(extent: Extent, ours: &dyn Fn(u32) -> Option<[f64; 2]>) -> Result<(Table, Vec<Check>), Broken> {
    let mut table = Table::new(
        "Largest x and y of a point, 2² points, by what becomes of a domain that overhangs the rim of the mesh:",
        &[
            "cell",
            "functions of the rim's cells continue (ours)",
            "a row of cells beyond, held",
            "cut off (AMPLE)",
        ],
    );
    let mut checks = Vec::new();
    let told = |it: [f64; 2]| format!("{}, {}", fixed(it[0], 5), fixed(it[1], 5));
    for &factor in extent.pick(&[2][..], &[2, 4]) {
        let run = run(&Scene::PlaneStrain(walled(factor)?))?;
        let (beyond, ours) = (extent_of(&run), ours(factor).ok_or("a run of that mesh")?);
        let error = if run.outcome.is_err() {
            f64::NAN
        } else {
            largest([(beyond[0] / ours[0] - 1.0).abs(), (beyond[1] / ours[1] - 1.0).abs()])
        };
        let cell = 1.0 / f64::from(factor);
        let what = format!("cells of {cell}, 2²: a row of cells beyond the rim (relative)");
        checks.push(Check::new(what, error, 3e-4));
        let ample = AMPLE.iter().find(|it| it.0 == (factor, 2)).map_or("–".into(), |it| told(it.1));
        table.push([cell.to_string(), told(ours), told(beyond), ample]);
    }
    Ok((table, checks))
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
        for (wanted, expected) in AMPLE {
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
    let of_mesh = |factor| jobs.iter().position(|it| *it == (factor, 2)).map(|k| extent_of(&runs[k]));
    let (table, checks) = rims(extent, &of_mesh)?;
    findings.tables.push(table);
    findings.checks.extend(checks);
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
    let patches = history
        .outlines()
        .iter()
        .zip(rho)
        .map(|(corners, rho)| Patch::new(outline(corners), rho / 20e3))
        .collect();
    let shape = Shapes {
        title: format!("{} % of the weight", fixed(100.0 * history.last().fraction, 0)),
        range: [(0.0, 16.0), (0.0, 8.0)],
        patches,
        lines: super::mesh_lines(&Scene::PlaneStrain(scene(2, 2)?), 1.0)?,
        ..Shapes::default()
    };
    Ok(Picture {
        file: "collapse.png",
        caption: "Collapse, cells of 0.5, 2² points: domains at the end, from pale (no deviatoric stress) to red (yield).".into(),
        panels: vec![Panel::Shapes(shape)],
    })
}
