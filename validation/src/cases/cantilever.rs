//! A cantilever bent far (Molstad 1977).

use super::{fixed, largest, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::probe;
use crate::scenes::{Run, load, run};
use crate::variants::{CPDI1, CPDI2Q, GIMP, Method, plane, refined, with_points};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Positive, Scene, StabilisationInput};
use mpm_solver::observe::Field;

pub(super) const CASE: Case = Case {
    name: "cantilever",
    goal: "Bending through a large angle: does a run with small cuts finish, and where does it end?",
    setup: "A beam 10 × 1 (E = 12·10⁶, ν = 0.2) under a tip load of 10⁵ in 50 steps, P l²/EI = 9.6 with E/(1 − ν²); the load is shared by the two points nearest to the axis at the free end. Cells of 0.5, 0.25 and 0.125, 2² (with and without ghost stabilisation) and 6² points a cell.",
    reference: "The inextensible elastica; AMPLE (GIMP, 0.5, 6²): displacement of the loaded points (−5.47752, −8.17211) in 197 linear solves, one step accepted unconverged; with 2² points it stops at step 10 (0.5) and 13 (0.25).",
    run: cantilevers,
};

const LENGTH: f64 = 10.0;
/// Full load P l²/EI.
const FULL: f64 = 9.6;

/// Deflection and shortening of the elastica over the length at P l²/EI = 0, 1, …, 10.
const ELASTICA: [(f64, f64); 11] = [
    (0.0, 0.0),
    (0.302, 0.056),
    (0.494, 0.160),
    (0.603, 0.255),
    (0.670, 0.329),
    (0.714, 0.388),
    (0.744, 0.434),
    (0.767, 0.472),
    (0.785, 0.504),
    (0.799, 0.531),
    (0.811, 0.555),
];

struct Bent {
    run: Run,
    /// Load and mean displacement of the loaded points at every load step.
    path: Vec<(f64, [f64; 2])>,
}

/// Basis, refinement, points per cell and direction, and whether small cuts are stabilised.
type Job = (Method, u32, u32, bool);

fn bend((method, factor, points, ghost): &Job) -> Result<Bent, Broken> {
    let mut scene = with_points(refined(method.of(plane(load("cantilever")?)?), *factor), *points);
    scene.stabilisation = ghost.then_some(StabilisationInput::Ghost { factor: Some(Positive(1.0 / 30.0)) });
    let scene = Scene::PlaneStrain(scene);
    let loaded: Vec<usize> =
        probe::plane(&scene)?.loads.point_loads.iter().flat_map(|it| &it.shares).map(|it| it.point).collect();
    let run = run(&scene)?;
    let path = (0..run.history.rows().len())
        .map(|row| (FULL * run.history.rows()[row].fraction, mean(&run.history, row, &loaded)));
    Ok(Bent { path: path.collect(), run })
}

fn mean(history: &History, row: usize, points: &[usize]) -> [f64; 2] {
    let moved = history.field(Field::DISPLACEMENT, row);
    [0, 1].map(|i| points.iter().map(|p| moved[3 * p + i]).sum::<f64>() / points.len() as f64)
}

/// Largest departure of the deflection from the elastica, over the length, at the loads that both know.
fn departure(path: &[(f64, [f64; 2])]) -> f64 {
    largest((1..=9).map(|load| {
        let at = path.windows(2).find(|pair| pair[1].0 >= f64::from(load) - 1e-12);
        at.map_or(f64::NAN, |pair| {
            let t = (f64::from(load) - pair[0].0) / (pair[1].0 - pair[0].0);
            let found = pair[0].1[1] + t * (pair[1].1[1] - pair[0].1[1]);
            (-found / LENGTH - ELASTICA[load as usize].0).abs()
        })
    }))
}

fn cantilevers(extent: Extent) -> Result<Findings, Broken> {
    let mut jobs: Vec<Job> = Vec::new();
    // With 6² points the cuts are never small for long.
    let kinds = [(2, false), (2, true), (6, false)];
    for (factor, (points, ghost)) in [1, 2, 4].into_iter().flat_map(|factor| kinds.map(|kind| (factor, kind))) {
        for method in [GIMP, CPDI1, CPDI2Q] {
            if extent == Extent::Full || factor == 1 {
                jobs.push((method, factor, points, ghost));
            }
        }
    }
    let bent = sweep(&jobs, bend)?;

    let mut findings = Findings::default();
    let mut table = Table::new(
        "How far each run gets and how the loaded points end (departure: of the deflection from the elastica over the length, largest at P l²/EI = 1 … 9):",
        &[
            "basis",
            "cell",
            "points",
            "ghost",
            "load reached",
            "linear solves",
            "halvings",
            "u_x",
            "u_y",
            "departure",
            "ends because",
        ],
    );
    for ((method, factor, points, ghost), Bent { run, path }) in jobs.iter().zip(&bent) {
        let (load, [x, y]) = path[path.len() - 1];
        let total = |column: &str| run.history.series(column, 0).iter().sum::<f64>();
        table.push([
            method.name.to_owned(),
            format!("{}", 0.5 / f64::from(*factor)),
            format!("{points}²"),
            if *ghost { "yes" } else { "no" }.to_owned(),
            format!("{} %", fixed(100.0 * load / FULL, 1)),
            total("newton_iterations").to_string(),
            total("cuts").to_string(),
            fixed(x, 5),
            fixed(y, 5),
            fixed(departure(path), 4),
            run.outcome.as_ref().err().map_or(String::new(), ToString::to_string),
        ]);
    }
    findings.tables.push(table);

    let finishing = [(GIMP, 6, false), (CPDI1, 6, false), (GIMP, 2, true), (CPDI1, 2, true), (CPDI2Q, 2, true)];
    for (method, points, ghost) in finishing {
        let name = if ghost { format!("{}, ghost", method.name) } else { method.name.to_owned() };
        let at = jobs.iter().position(|job| *job == (method.clone(), 1, points, ghost)).expect("a job");
        let Bent { run, path } = &bent[at];
        let [x, y] = path[path.len() - 1].1;
        let reason = run.outcome.as_ref().err().map_or(String::new(), ToString::to_string);
        let unfinished =
            Check::none(format!("{name}, 0.5, {points}²: does not finish"), usize::from(run.outcome.is_err()));
        findings.checks.push(unfinished.remark(reason));
        if method == GIMP && points == 6 {
            let away = (x + 5.47752).hypot(y + 8.17211) / 5.47752_f64.hypot(8.17211);
            let solves: f64 = run.history.series("newton_iterations", 0).iter().sum();
            findings.checks.push(
                Check::new(
                    "GIMP, 0.5, 6²: displacement of the loaded points against AMPLE's (relative)",
                    away,
                    1e-3,
                )
                .remark(format!("({x:.5}, {y:.5}), {solves} linear solves")),
            );
        }
        let what =
            format!("{name}, 0.5, {points}²: departure of the deflection from the elastica, over the length");
        findings.checks.push(Check::new(what, departure(path), 0.02));
    }
    if extent == Extent::Full {
        findings.pictures.push(picture(&jobs, &bent));
    }
    Ok(findings)
}

fn picture(jobs: &[Job], bent: &[Bent]) -> Picture {
    let elastica = |component: fn(&(f64, f64)) -> f64| {
        ELASTICA.iter().enumerate().map(|(load, it)| (load as f64, component(it))).collect()
    };
    let mut curves = Vec::new();
    for (colour, wanted) in [
        (1, (GIMP, 1, 6, false)),
        (2, (CPDI1, 1, 6, false)),
        (3, (CPDI2Q, 1, 6, false)),
        (4, (GIMP, 4, 6, false)),
    ] {
        let Some(at) = jobs.iter().position(|job| *job == wanted) else { continue };
        let cell = 0.5 / f64::from(wanted.1);
        for (component, sign) in [(1, -1.0), (0, -1.0)] {
            let points =
                bent[at].path.iter().map(|(load, moved)| (*load, sign * moved[component] / LENGTH)).collect();
            let stroke = if component == 1 { Stroke::Line } else { Stroke::Dashes };
            let name =
                if component == 1 { format!("{}, cells of {cell}", wanted.0.name) } else { String::new() };
            curves.push(Curve { name, colour, stroke, points });
        }
    }
    curves.push(Curve {
        name: "elastica".into(),
        colour: 0,
        stroke: Stroke::Marks,
        points: elastica(|it| it.0),
    });
    curves.push(Curve { name: String::new(), colour: 0, stroke: Stroke::Marks, points: elastica(|it| it.1) });
    Picture {
        file: "cantilever.svg",
        caption: "Cantilever, 6² points a cell: deflection v and shortening u of the loaded points over the length, against the load.".into(),
        panels: vec![Panel::Curves(Curves {
            title: "Cantilever".into(),
            axes: ["load P l²/EI", "v/l (lines), u/l (dashes)"].map(String::from),
            range: [(0.0, 10.0), (0.0, 1.4)],
            logarithmic: [false; 2],
            legend: Legend::UpperLeft,
            curves,
        })],
    }
}
