//! Bodies that barely reach into cells.

use super::{effort, reason, run_plane, scene, variant};
use crate::cases::{fixed, largest, scientific, sweep};
use crate::probe::{Probe, plane};
use crate::scenes::load;
use crate::variants::{self, ALL, CPDI1, GIMP, Method, PlaneScene, SMPM, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_grid::Vector;
use mpm_scene::Scene;
use mpm_scene::language::Positive;
use mpm_solver::observe::Field;
use nalgebra::{DMatrix, SymmetricEigen};

pub(super) const CONDITION: Case = Case {
    name: "condition against cut",
    goal: "Ghost stabilisation bounds the condition of the tangent however little of a body lies in a cell, and costs no iterations.",
    setup: "A block of 4 × 4 cells (E = 1, ν = 0, 2² points a cell) moved along the diagonal so that it reaches by a·h into the cells beyond, a from 1 (fitted) to 10⁻⁶; the same block under its own weight on a rough base, in 5 load steps.",
    reference: "λ_max/λ_4 of the tangent at rest (three rigid modes) below 10⁴ with ghost stabilisation; published for GIMP without it: 1.7·10⁵ at a = 0.2, 2.2·10⁷ at 0.1, 2.1·10⁹ at 0.05, 5·10¹³ at 0.01. Newton iterations per load step at most one more than fitted.",
    run: condition,
};

pub(super) const ANSWER: Case = Case {
    name: "what ghost stabilisation changes",
    goal: "It moves the converged answer by less than the error of the discretisation, and lets runs finish that stop without it.",
    setup: "Self-weight column (mild and hard), collapse, corner stretch on squares (to D = 0.4, where no cell is empty yet) and cantilever with 2² points, with and without it.",
    reference: "The change of the answer against its error or, where no exact one is known, against the change by halving the cells.",
    run: answers,
};

const CUTS: [f64; 10] = [1.0, 0.5, 0.251, 0.2, 0.1, 0.05, 1e-2, 1e-3, 1e-4, 1e-6];

fn block(cut: f64, load: &str) -> Result<PlaneScene, Broken> {
    scene(&format!(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 6), Uniform(from: 0, to: 6, cells: 6)]),
            basis: Smpm,
            materials: {{ \"soft\": Hencky(young: 1, poisson: 0, density: 1) }},
            bodies: [(name: \"block\", material: \"soft\", shape: Box(from: ({cut}, {cut}), to: ({end}, {end})), points_per_cell: 2)],
            {load}
            schedule: (steps: 5),
        )",
        end = 4.0 + cut,
    ))
}

/// λ_max/λ_4 of the tangent at rest.
fn ratio(scene: PlaneScene) -> Result<f64, Broken> {
    let probe = Probe::of(plane(&Scene::PlaneStrain(scene))?)?;
    let (n, rest) = (probe.n_nodes(), probe.field(|_| Vector::zeros()));
    let mut columns = Vec::with_capacity(4 * n * n);
    for column in 0..2 * n {
        let mut unit = rest.clone();
        unit[column / 2][column % 2] = 1.0;
        columns.extend(probe.tangent_times(&rest, &unit)?.iter().flat_map(|it| [it[0], it[1]]));
    }
    let tangent = DMatrix::from_vec(2 * n, 2 * n, columns);
    let mut values: Vec<f64> = SymmetricEigen::new(tangent).eigenvalues.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    // Rounding leaves a few units in the last place of the largest.
    Ok(values[2 * n - 1] / values[3].max(f64::EPSILON * values[2 * n - 1]))
}

fn condition(extent: Extent) -> Result<Findings, Broken> {
    let cuts: &[f64] = extent.pick(&[1.0, 0.1, 1e-6], &CUTS);
    let methods: &[Method] = extent.pick(&[SMPM, GIMP, CPDI1], &ALL);
    let mut findings = Findings::default();
    let heads: Vec<String> = cuts.iter().map(|cut| format!("a = {cut}")).collect();
    let heads: Vec<&str> = ["basis", "ghost"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let mut table = Table::new("λ_max/λ_4 of the tangent (10¹⁶: beyond what rounding lets see):", &heads);
    for method in methods {
        for ghost in [false, true] {
            let ratios = sweep(cuts, |&cut| ratio(variant(&block(cut, "")?, method, ghost)))?;
            let row = [method.name.to_owned(), if ghost { "yes" } else { "no" }.to_owned()];
            table.push(row.into_iter().chain(ratios.iter().map(|&it| scientific(it, 1))));
            if ghost {
                let what = format!("{}: largest condition number with ghost stabilisation", method.name);
                findings.checks.push(Check::new(what, largest(ratios), 1e4));
            }
        }
    }
    findings.tables.push(table);
    iterations(cuts, methods, &mut findings)?;
    Ok(findings)
}

/// Newton iterations of the block under its weight.
fn iterations(cuts: &[f64], methods: &[Method], findings: &mut Findings) -> Result<(), Broken> {
    // Nodes at or below the base are held, wherever they are.
    let load = "supports: [(name: \"base\", region: Box(from: (-9, -9), to: (9, 1)), fix: [X, Y])],
            loads: [BodyForce(acceleration: (0, -0.02))],";
    let mut table = Table::new(
        "Linear solutions in 5 load steps under self-weight (most in a load step); the base is the first row of nodes that is wholly inside:",
        &["basis", "ghost", "fitted", "most over the cuts", "runs that stop"],
    );
    for method in methods {
        for ghost in [false, true] {
            let runs = sweep(cuts, |&cut| run_plane(variant(&block(cut, load)?, method, ghost)))?;
            let most = |run: &crate::scenes::Run| largest(run.history.series("newton_iterations", 0));
            let (fitted, stopped) = (most(&runs[0]), runs.iter().filter(|run| run.outcome.is_err()).count());
            let worst = largest(runs.iter().filter(|run| run.outcome.is_ok()).map(most));
            table.push([
                method.name.to_owned(),
                if ghost { "yes" } else { "no" }.to_owned(),
                fitted.to_string(),
                worst.to_string(),
                stopped.to_string(),
            ]);
            if ghost {
                let name = method.name;
                findings.checks.push(Check::new(
                    format!("{name}: iterations in a load step beyond the fitted block's"),
                    (worst - fitted).max(0.0),
                    1.0,
                ));
                findings.checks.push(Check::none(format!("{name}: cut blocks that stop"), stopped));
            }
        }
    }
    findings.tables.push(table);
    Ok(())
}

/// A problem, an answer of it, and what the answer should be if that is known.
struct Problem {
    name: &'static str,
    scene: fn() -> Result<PlaneScene, Broken>,
    answer: fn(&crate::scenes::Run) -> f64,
    exact: Option<f64>,
}

/// Mean of |σ_yy + ρ g (50 - Y)| over ρ g 50.
fn column_error(run: &crate::scenes::Run) -> f64 {
    let history = &run.history;
    let last = history.rows().len() - 1;
    let (stress, moved) = (history.field(Field::CAUCHY_STRESS, last), history.field(Field::DISPLACEMENT, last));
    let errors = (0..stress.len() / 9).map(|p| {
        let at_rest = history.last().positions[3 * p + 1] - moved[3 * p + 1];
        (stress[9 * p + 4] + 800.0 * (50.0 - at_rest)).abs() / 40e3
    });
    errors.sum::<f64>() / (stress.len() / 9) as f64
}

fn highest(run: &crate::scenes::Run) -> f64 {
    largest(run.history.last().positions.iter().skip(1).step_by(3).copied())
}

fn farthest(run: &crate::scenes::Run) -> f64 {
    largest(run.history.last().positions.iter().step_by(3).copied())
}

/// Largest settlement of a point.
fn deepest(run: &crate::scenes::Run) -> f64 {
    let last = run.history.rows().len() - 1;
    largest(run.history.field(Field::DISPLACEMENT, last).iter().skip(1).step_by(3).map(|y| -y))
}

fn pulled(run: &crate::scenes::Run) -> f64 {
    *run.history.series("reaction/corner", 0).last().expect("the initial state is always shown")
}

fn problems(extent: Extent) -> Vec<Problem> {
    let column = || variants::plane(load("column")?);
    let mild = || {
        let mut scene = variants::plane(load("column")?)?;
        for law in scene.materials.values_mut() {
            if let mpm_scene::language::MaterialInput::Hencky { young, .. } = law {
                *young = Positive(1e6).into();
            }
        }
        Ok(scene)
    };
    // Halved cells lose their points at the corner beyond D = 0.5.
    let corner = || {
        let text = crate::scenes::text("corner_stretch_rectilinear")?;
        scene(&text.replace("displacement: 4", "displacement: 0.4").replace("steps: 40", "steps: 4"))
    };
    let bent = || Ok(variants::with_points(variants::plane(load("cantilever")?)?, 2));
    let block = || variants::plane(load("collapse")?);
    let mut problems = vec![
        Problem {
            name: "column, mild: error of the stress",
            scene: mild,
            answer: column_error,
            exact: Some(0.0),
        },
        Problem {
            name: "column, hard: error of the stress",
            scene: column,
            answer: column_error,
            exact: Some(0.0),
        },
        Problem { name: "column, hard: height", scene: column, answer: highest, exact: None },
        Problem { name: "cantilever: deflection", scene: bent, answer: deepest, exact: None },
    ];
    if extent == Extent::Full {
        problems.push(Problem { name: "collapse: largest x", scene: block, answer: farthest, exact: None });
        problems.push(Problem {
            name: "corner stretch, D = 0.4: reaction",
            scene: corner,
            answer: pulled,
            exact: None,
        });
    }
    problems
}

fn answers(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let mut table = Table::new(
        "Answers without and with ghost stabilisation, and with cells half as large (with it); in brackets the linear solutions and halvings:",
        &["problem, answer", "without", "with", "with, half the cell", "change by it", "change by the cells"],
    );
    for problem in problems(extent) {
        let jobs = [(false, 1), (true, 1), (true, 2)];
        let runs = sweep(&jobs, |&(ghost, factor)| {
            run_plane(refined(variant(&(problem.scene)()?, &GIMP, ghost), factor))
        })?;
        let answers: Vec<f64> = runs.iter().map(problem.answer).collect();
        let told = runs.iter().zip(&answers).map(|(run, answer)| {
            let [solves, cuts] = effort(&run.history);
            match run.outcome {
                Ok(_) => format!("{} ({solves}, {cuts})", fixed(*answer, 5)),
                Err(_) => format!("ends: {}", reason(run)),
            }
        });
        let change = (answers[1] - answers[0]).abs();
        let by_cells =
            problem.exact.map_or((answers[2] - answers[1]).abs(), |exact| (answers[1] - exact).abs());
        let finished = runs[0].outcome.is_ok();
        let mut row = vec![problem.name.to_owned()];
        row.extend(told);
        row.push(if finished { scientific(change, 1) } else { "–".into() });
        row.push(scientific(by_cells, 1));
        table.push(row);
        let unfinished = runs[1..].iter().filter(|run| run.outcome.is_err()).count();
        findings.checks.push(Check::none(format!("{}: stabilised runs that stop", problem.name), unfinished));
        if finished {
            let what = format!("{}: change by ghost stabilisation over that by the cells", problem.name);
            findings.checks.push(Check::new(what, change / by_cells, 1.0));
        }
    }
    findings.tables.push(table);
    Ok(findings)
}
