//! Time against error: what accuracy costs, for every basis, on problems whose answer is known.

use crate::first_to::{self, ELEMENTS, Reached};
use crate::report::{Report, Settings, decades};
use crate::{Failure, machine};
use mpm_scene::compile;
use mpm_scene::language::{Count, Direction, FieldInput, LoadInput, Scene};
use mpm_validation::history::History;
use mpm_validation::picture::{Curve, Curves, Legend, Panel, Stroke};
use mpm_validation::problems::column::{Load, column, stress_error};
use mpm_validation::problems::doughnut::{EXACT_AT_20, ring, torque};
use mpm_validation::problems::vortex::{between_walls, errors, exact, vortex};
use mpm_validation::scenes::load;
use mpm_validation::variants::{
    ALL, BACKSLASH, CPDI1_ON_CUBIC_SPLINES, CPDI1_ON_SPLINES, CPDI2Q_ON_CUBIC_SPLINES, CPDI2Q_ON_SPLINES,
    GENERAL, GIMP, Method, PlaneScene, SLASH, plane, refined,
};
use mpm_validation::{Broken, Picture, Table};
use serde::Serialize;

/// A problem with a known answer.
struct Problem {
    name: &'static str,
    /// What the error is.
    measure: &'static str,
    methods: &'static [Method],
    /// Bases on splines.
    on_splines: &'static [Method],
    /// Meshes, coarse to fine.
    meshes: &'static [u32],
    /// The first of these many meshes are run by a quick run.
    quick: usize,
    /// How a mesh is called.
    cells: fn(u32) -> String,
    scene: fn(&Method, u32) -> Result<PlaneScene, Broken>,
    error: fn(&PlaneScene, &History) -> Result<f64, Broken>,
}

/// Bases on splines.
const SPLINES: [Method; 4] =
    [CPDI1_ON_SPLINES, CPDI2Q_ON_SPLINES, CPDI1_ON_CUBIC_SPLINES, CPDI2Q_ON_CUBIC_SPLINES];

/// What `foreign/quadratic_elements.py` is told to write, in the folder of the results.
const ELEMENTS_FILE: &str = "quadratic_elements.json";

const PROBLEMS: [Problem; 5] = [
    Problem {
        name: "column, hard",
        measure: "mean error of the vertical stress over the weight",
        methods: &ALL,
        on_splines: &SPLINES,
        meshes: &[8, 16, 24, 32, 64, 128, 256, 512],
        quick: 2,
        cells: |n| format!("{n}"),
        scene: |method, cells| of_column(Load::Hard, method, cells),
        error: |_, history| Ok(stress_error(history)),
    },
    Problem {
        name: "column, mild",
        measure: "mean error of the vertical stress over the weight",
        methods: &ALL,
        on_splines: &SPLINES,
        meshes: &[8, 16, 24, 32, 64, 128, 256, 512],
        quick: 2,
        cells: |n| format!("{n}"),
        scene: |method, cells| of_column(Load::Mild, method, cells),
        error: |_, history| Ok(stress_error(history)),
    },
    Problem {
        name: "cantilever",
        measure: "error of the displacement of the end, over itself",
        methods: &ALL,
        on_splines: &SPLINES,
        meshes: &[1, 2, 3, 4, 6],
        quick: 1,
        cells: |factor| format!("{} × {}", 20 * factor, 2 * factor),
        scene: cantilever,
        error: |_, history| {
            let [x, y] = displacement_of_the_end(history);
            Ok((x - END[0]).hypot(y - END[1]) / END[0].hypot(END[1]))
        },
    },
    Problem {
        name: "doughnut twist, elastic",
        measure: "error of the torque at 20°",
        methods: &GENERAL,
        on_splines: &SPLINES,
        meshes: &[1, 2, 3, 4, 6, 8],
        quick: 1,
        cells: |factor| format!("{} × {}", 5 * factor, 32 * factor),
        scene: ring,
        error: |_, history| {
            let end = torque(history).last().copied().ok_or("the run has no load step")?;
            Ok((end / EXACT_AT_20 - 1.0).abs())
        },
    },
    Problem {
        name: "generalised vortex",
        measure: "error of the displacement in the mean square",
        methods: &ALL,
        on_splines: &SPLINES,
        meshes: &[1, 2, 3, 4, 6, 8],
        quick: 1,
        cells: |factor| format!("{}²", 24 * factor),
        // Its edges cross the cells of its mesh.
        scene: |method, factor| {
            if method.degree > 1 { between_walls(method, factor) } else { vortex(method, factor) }
        },
        error: |scene, history| Ok(errors(history, &exact(scene)?)?.displacement),
    },
];

impl Problem {
    fn methods(&self) -> impl Iterator<Item = &'static Method> + use<> {
        self.methods.iter().chain(self.on_splines)
    }
}

/// The column; a body one cell wide needs three points a cell on splines of degree 3.
fn of_column(load_case: Load, method: &Method, cells: u32) -> Result<PlaneScene, Broken> {
    let mut scene = plane(column(load_case, method, cells)?)?;
    if method.degree > 2 {
        scene.bodies.iter_mut().for_each(|body| body.points_per_cell = Some(Count(3)));
    }
    Ok(scene)
}

/// The shipped cantilever with two changes without which no limit under refinement exists, or no order
/// but the first: its root is clamped (a pin alone sinks in for ever), and the load is shared by the four
/// points around a place that every mesh has, not by two that come nearer to the end with every mesh.
fn cantilever(method: &Method, factor: u32) -> Result<PlaneScene, Broken> {
    let mut scene = refined(method.of(plane(load("cantilever")?)?), factor);
    scene.supports.retain(|support| support.name == "root");
    for support in &mut scene.supports {
        support.fix = vec![Direction::X, Direction::Y];
    }
    for load in &mut scene.loads {
        if let LoadInput::PointForce { near, points, .. } = load {
            (near.0[0], *points) = (9.75, Some(Count(4)));
        }
    }
    Ok(scene)
}

/// Displacement of the cantilever's end, see [`displacement_of_the_end`] `[L]`. Extrapolated with order 2
/// from CPDI2q on 80 × 8 and 160 × 16 cells ((−5.291678, −7.992618) and (−5.293893, −7.995108), by
/// `cantilever-end 4 8`); CPDI1 on 80 × 8 and 120 × 12 leads to the same within 3e-4. Errors below 5e-5 mean
/// nothing.
const END: [f64; 2] = [-5.2946, -7.9959];

/// Mean displacement over the outermost twentieth of the cantilever, which every mesh cuts at the same
/// place (all points have the same volume at rest) `[L]`.
fn displacement_of_the_end(history: &History) -> [f64; 2] {
    let (rest, last) = (&history.rows()[0].positions, &history.last().positions);
    let outer = || rest.chunks_exact(3).zip(last.chunks_exact(3)).filter(|(x, _)| x[0] > 9.5);
    [0, 1].map(|i| outer().map(|(x, y)| y[i] - x[i]).sum::<f64>() / outer().count() as f64)
}

/// Displacement of the cantilever's end for every basis and these meshes: the runs from which the
/// reference was extrapolated.
///
/// # Errors
/// A scene cannot be made.
pub fn cantilever_end(factors: &[u32]) -> Result<Table, Failure> {
    let mut table = Table::new("Displacement of the cantilever's end.", &["basis", "cells", "u_x", "u_y"]);
    for &factor in factors {
        for method in ALL {
            let scene = cantilever(&method, factor)?;
            let mut history = History::of(&[]).only_ends();
            let [x, y] = match compile(&Scene::PlaneStrain(scene))?.run(&mut history) {
                Ok(_) => displacement_of_the_end(&history).map(|u| format!("{u:.9}")),
                Err(reason) => [reason.to_string(), String::new()],
            };
            table.push([method.name.to_owned(), format!("{} × {}", 20 * factor, 2 * factor), x, y]);
        }
    }
    Ok(table)
}

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the problem.
    pub problem: &'static str,
    /// Name of the basis.
    pub basis: &'static str,
    /// Cells of the mesh.
    pub cells: String,
    /// Material points.
    pub points: usize,
    /// Newton iterations, all load steps together.
    pub iterations: u64,
    /// Processor time from the scene to the answer, one thread, the least of the repetitions `[s]`.
    pub seconds: f64,
    /// The error, of a run that reached its end.
    pub error: Option<f64>,
    /// Why a run ended early.
    pub reason: Option<String>,
}

impl Row {
    /// What it has reached, if it came to its end.
    fn reached(&self) -> Option<Reached> {
        let (problem, name, cells) = (self.problem.to_owned(), self.basis.to_owned(), self.cells.clone());
        Some(Reached { problem, name, cells, seconds: self.seconds, error: self.error? })
    }
}

/// Short runs are repeated for so long `[s]`, at most so often.
const REPEAT_FOR: f64 = 0.4;
const REPEAT: usize = 5;

/// A basis is not taken to finer meshes once a run has taken so long `[s]`.
const LONG: f64 = 20.0;

/// Runs the set; what is finished is written after each problem.
///
/// # Errors
/// A scene cannot be made, or a file not be written. A run that ends early is a result.
pub fn run(settings: &Settings) -> Result<Report<Vec<Row>>, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let elements = first_to::elements(&settings.output.join(ELEMENTS_FILE))?;
    let mut rows: Vec<Row> = Vec::new();
    for (k, problem) in PROBLEMS.iter().enumerate() {
        let meshes = &problem.meshes[..settings.pick(problem.quick, problem.meshes.len())];
        for method in problem.methods() {
            for &mesh in meshes {
                let row = pool.install(|| one(problem, method, mesh, settings.quick))?;
                eprintln!("{}, {}, {}: {:.3} s", row.problem, row.basis, row.cells, row.seconds);
                let is_long = row.seconds > LONG;
                rows.push(row);
                if is_long {
                    break;
                }
            }
        }
        if k + 1 < PROBLEMS.len() {
            report(&rows, &elements).save(settings)?;
        }
    }
    Ok(report(&rows, &elements))
}

/// Tables and pictures of these runs, and of finite elements.
fn report(rows: &[Row], elements: &[Reached]) -> Report<Vec<Row>> {
    let of = |problem: &Problem| -> Vec<Row> {
        rows.iter().filter(|row| row.problem == problem.name).cloned().collect()
    };
    let done = || PROBLEMS.iter().map(|problem| (problem, of(problem))).filter(|(_, rows)| !rows.is_empty());
    let mut tables: Vec<Table> = done().map(|(problem, rows)| table(problem, &rows)).collect();
    tables.push(failures(rows));
    let mut all: Vec<Reached> = Vec::new();
    for (problem, rows) in done() {
        all.extend(rows.iter().filter_map(Row::reached));
        all.extend(elements.iter().filter(|it| it.problem == problem.name).cloned());
    }
    let of_degree = |degree: u32| SPLINES.iter().filter(|it| it.degree == degree).map(|it| it.name).collect();
    let groups = [
        ("GIMP", vec![GIMP.name]),
        ("other bases on linear functions", GENERAL.map(|it| it.name).into()),
        ("degree 2", of_degree(2)),
        ("degree 3", of_degree(3)),
        (ELEMENTS, vec![ELEMENTS]),
    ];
    tables.push(first_to::table(&all, &groups));
    let panels = done().map(|(problem, rows)| panel(problem, &rows, elements)).collect();
    Report { set: "time_against_error", tables, pictures: pictures(panels), results: rows.to_vec() }
}

fn one(problem: &Problem, method: &Method, mesh: u32, once: bool) -> Result<Row, Broken> {
    let mut scene = (problem.scene)(method, mesh)?;
    scene.output.fields = vec![FieldInput::CauchyStress, FieldInput::Displacement];
    let whole = Scene::PlaneStrain(scene.clone());
    let mut row = Row {
        problem: problem.name,
        basis: method.name,
        cells: (problem.cells)(mesh),
        points: 0,
        iterations: 0,
        seconds: f64::INFINITY,
        error: None,
        reason: None,
    };
    let mut spent = 0.0;
    let fields = compile(&whole)?.fields(&scene.output)?;
    for repetition in 0..REPEAT {
        let mut history = History::of(&fields).only_ends();
        let work = machine::timed(|| Ok::<_, Broken>(compile(&whole)?.run(&mut history)));
        row.points = history.rows()[0].positions.len() / 3;
        match work.result? {
            Ok(summary) => {
                row.error = Some((problem.error)(&scene, &history)?);
                row.iterations = summary.iterations;
            }
            Err(reason) => row.reason = Some(reason.to_string()),
        }
        row.seconds = row.seconds.min(work.processor);
        spent += work.processor;
        let enough = spent > REPEAT_FOR && repetition + 1 >= 2;
        if once || row.reason.is_some() || enough || spent > 2.0 {
            break;
        }
    }
    Ok(row)
}

fn table(problem: &Problem, rows: &[Row]) -> Table {
    let heads = ["basis", "cells", "points", "iterations", "error", "order", "seconds", "µs/(pt·it)"];
    let text = format!("{}: {}, against processor seconds on one thread.", problem.name, problem.measure);
    let mut table = Table::new(text, &heads);
    for (k, row) in rows.iter().enumerate() {
        let before = (k > 0 && rows[k - 1].basis == row.basis).then(|| &rows[k - 1]);
        let order = before.and_then(|before| {
            let ratio = (row.points as f64 / before.points as f64).ln();
            // A column has one direction to refine, the others two.
            let halvings = if problem.name.starts_with("column") { ratio } else { 0.5 * ratio };
            Some((before.error? / row.error?).ln() / halvings)
        });
        let each = 1e6 * row.seconds / (row.points as f64 * row.iterations as f64);
        table.push([
            row.basis.to_owned(),
            row.cells.clone(),
            row.points.to_string(),
            row.iterations.to_string(),
            row.error.map_or("ends early".into(), |error| format!("{error:.2e}")),
            order.map_or(String::new(), |order| format!("{order:.1}")),
            format!("{:.4}", row.seconds),
            if row.iterations > 0 { format!("{each:.2}") } else { String::new() },
        ]);
    }
    table
}

fn failures(rows: &[Row]) -> Table {
    let mut table = Table::new("Runs that ended early, and why:", &["problem", "basis", "cells", "reason"]);
    for row in rows {
        if let Some(reason) = &row.reason {
            table.push([row.problem.into(), row.basis.into(), row.cells.clone(), reason.clone()]);
        }
    }
    table
}

/// The curves of a problem: of the triangles those that are cut both ways, which are the best of them.
fn panel(problem: &Problem, rows: &[Row], elements: &[Reached]) -> Panel {
    let drawn: Vec<&str> =
        ALL.iter().filter(|it| **it != SLASH && **it != BACKSLASH).chain(&SPLINES).map(|it| it.name).collect();
    let mut done: Vec<Reached> = rows.iter().filter_map(Row::reached).collect();
    done.retain(|it| drawn.contains(&&it.name[..]));
    done.extend(elements.iter().filter(|it| it.problem == problem.name).cloned());
    let curves = drawn.iter().chain([&ELEMENTS]).enumerate().map(|(colour, &name)| Curve {
        name: name.into(),
        colour,
        stroke: Stroke::MarkedLine,
        points: done.iter().filter(|it| it.name == name).map(|it| (it.seconds, it.error)).collect(),
    });
    Panel::Curves(Curves {
        title: problem.name.into(),
        axes: ["processor seconds, one thread", problem.measure].map(String::from),
        range: [decades(done.iter().map(|it| it.seconds)), decades(done.iter().map(|it| it.error))],
        logarithmic: [true; 2],
        legend: Legend::None,
        curves: curves.filter(|curve| !curve.points.is_empty()).collect(),
    })
}

/// The four problems of the README, and the mild column.
fn pictures(mut panels: Vec<Panel>) -> Vec<(Picture, usize)> {
    // The panel of the vortex, the last one, has room for a legend: nothing is both quick and good there.
    if let Some(Panel::Curves(vortex)) = panels.last_mut() {
        vortex.legend = Legend::LowerLeft;
    }
    let mild = (panels.len() > 1).then(|| panels.remove(1));
    let picture = |file, panels| Picture { file, caption: String::new(), panels };
    let mut pictures = vec![(picture("time_against_error.svg", panels), 2)];
    pictures.extend(mild.map(|mut mild| {
        if let Panel::Curves(mild) = &mut mild {
            mild.legend = Legend::LowerLeft;
        }
        (picture("time_against_error_column_mild.svg", vec![mild]), 1)
    }));
    pictures
}
