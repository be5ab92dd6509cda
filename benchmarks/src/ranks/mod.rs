//! Ranks of `mpm-mpi` against one process of `mpm`: time, memory and traffic, the answers, and a model of many.

mod answers;
mod model;
mod programs;

pub use answers::Answers;
pub use model::{Inputs, Told};
pub use programs::{NotBuilt, Predicted, Rank, Run};

use crate::Failure;
use crate::program::median;
use crate::report::{Report, Settings};
use mpm_validation::Table;
use programs::Programs;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Laws by name, and as the language has them.
const LAWS: [(&str, &str); 2] = [
    ("elastic", "Hencky(young: 1e3, poisson: 0.3, density: 1)"),
    ("von Mises", "VonMises(young: 1e3, poisson: 0.3, yield_radius: 30, density: 1)"),
];

/// Runs of every kind, in turn.
const REPETITIONS: usize = 3;

/// Phases of a run that are shown.
const PHASES: [&str; 7] = ["connect", "assemble", "analyse", "factorise", "solve", "advance", "output"];

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Ranks {
    /// Cells along an edge of the block.
    pub cells: u32,
    /// Of every law: all repetitions on 0 (`mpm`), 1 and 2 ranks.
    pub runs: Vec<(&'static str, Vec<Vec<Run>>)>,
    /// What is predicted of two ranks.
    pub predicted: Vec<Predicted>,
    /// The elastic block on two ranks in two load steps, and with fields recorded.
    pub further: [Run; 2],
    /// Answers of ranks beside those of one process.
    pub answers: Vec<Answers>,
    /// What the model is told.
    pub inputs: Inputs,
    /// What it says.
    pub model: Vec<Told>,
}

/// Runs the set with blocks of so many cells along an edge, and the programs at these paths: `mpm`, `mpm-mpi`.
///
/// # Errors
/// [`NotBuilt`] where a program is missing; a run fails.
pub fn run(
    settings: &Settings,
    cells: Option<u32>,
    programs: [Option<PathBuf>; 2],
) -> Result<Report<Ranks>, Failure> {
    let programs = Programs::find(programs, settings.output.join("ranks"))?;
    let cells = cells.unwrap_or(settings.pick(8, 48));
    let scene = scene();
    let laws = &LAWS[..settings.pick(1, LAWS.len())];
    let answers = answers::of(&programs, &scene, settings.pick(6, 16), laws)?;
    let mut runs = Vec::new();
    for &(name, law) in laws {
        let set = block(cells, 1, law);
        let mut of_law: Vec<Vec<Run>> = vec![Vec::new(); 3];
        for _ in 0..settings.pick(1, REPETITIONS) {
            for (ranks, all) in (0..).zip(&mut of_law) {
                let run = programs.run(ranks, &scene, &set, "block")?;
                eprintln!("{name}, {ranks} ranks: {:.2} s", run.processor());
                all.push(run);
            }
        }
        runs.push((name, of_law));
    }
    let law = LAWS[0].1;
    let predicted = programs.check(2, &scene, &block(cells, 1, law))?;
    let longer = programs.run(2, &scene, &block(cells, 2, law), "block")?;
    let mut set = block(cells, 1, law);
    set.push("output.fields=[Displacement, CauchyStress]".into());
    let recorded = programs.run(2, &scene, &set, "block")?;
    let [_, one, two] = [0, 1, 2].map(|ranks: usize| typical(&runs[0].1[ranks]));
    let inputs =
        Inputs::of(&model::Measured { one, two, longer: &longer, recorded: &recorded, predicted: &predicted });
    let model = model::told(&inputs);
    let tables = vec![
        strong(cells, &runs),
        ratios(&runs),
        shares(two, &longer, &predicted),
        answers::table(&answers),
        inputs.table(),
        model::table(&model),
    ];
    let pictures = vec![(model::picture(&model), 2)];
    let further = [longer, recorded];
    Ok(Report {
        set: "ranks",
        tables,
        pictures,
        results: Ranks { cells, runs, predicted, further, answers, inputs, model },
    })
}

/// The scene that is measured, a block in space.
fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/block_solid.ron")
}

/// A block of so many cells along every direction that settles by a tenth in so many load steps; only its ends are recorded.
fn block(cells: u32, steps: u32, law: &str) -> Vec<String> {
    let mut set = vec![
        format!("materials.rock={law}"),
        format!("bodies[0].shape.to=({cells}, {cells}, {cells})"),
        // The weight is that of the shipped block, whatever the size.
        format!("loads[0].acceleration=(0, {}, 0)", -96.0 / f64::from(cells)),
        "solver=Iterative".into(),
        format!("schedule.steps={steps}"),
        format!("output.every={steps}"),
    ];
    (0..3).for_each(|d| set.extend(["to", "cells"].map(|name| format!("mesh.axes[{d}].{name}={cells}"))));
    set.extend([3, 4].map(|k| format!("supports[{k}].region.at={cells}")));
    set
}

/// The run whose processor time is in the middle.
fn typical(runs: &[Run]) -> &Run {
    let mut sorted: Vec<&Run> = runs.iter().collect();
    sorted.sort_by(|a, b| a.processor().total_cmp(&b.processor()));
    sorted[sorted.len() / 2]
}

fn who(ranks: u32) -> String {
    match ranks {
        0 => "`mpm`, one thread".into(),
        1 => "1 rank".into(),
        ranks => format!("{ranks} ranks"),
    }
}

fn strong(cells: u32, runs: &[(&str, Vec<Vec<Run>>)]) -> Table {
    let text = format!(
        "A block of {cells}³ cells, eight points each, one load step: processor seconds of the slowest rank, seconds of the phases on the wall of rank 0, largest memory of a rank and bytes that all have sent. Of the repetitions that in the middle."
    );
    let first = ["law", "on", "processor", "wall", "Newton", "linear"];
    let last = ["MB of a rank", "MB sent"];
    let heads: Vec<&str> = first.into_iter().chain(PHASES).chain(last).collect();
    let mut table = Table::new(text, &heads);
    for (law, runs) in runs {
        for run in runs.iter().map(|it| typical(it)) {
            let mut row = vec![(*law).to_owned(), who(run.ranks)];
            row.extend([run.processor(), run.wall].map(|it| format!("{it:.2}")));
            row.extend([run.newton.to_string(), run.linear.to_string()]);
            row.extend(PHASES.map(|phase| format!("{:.2}", run.seconds(phase))));
            let held = run.each.iter().map(|it| it.memory).fold(0.0, f64::max);
            row.push(format!("{:.0}", 1e-6 * held));
            row.push(format!("{:.1}", 1e-6 * run.each.iter().map(|it| it.bytes).sum::<f64>()));
            table.rows.push(row);
        }
    }
    table
}

/// Ratios of the runs that were made in turn.
fn ratios(runs: &[(&str, Vec<Vec<Run>>)]) -> Table {
    let text = "Ratios of processor seconds of the slowest rank, runs in turn, the median: one rank over `mpm` on one thread (at most 2 is wanted), one rank over two (at least 1.7 is wanted), two ranks over `mpm`.";
    let mut table =
        Table::new(text, &["law", "one rank over `mpm`", "one rank over two", "two ranks over `mpm`"]);
    for (law, runs) in runs {
        let ratio = |a: usize, b: usize| {
            let each = runs[a].iter().zip(&runs[b]).map(|(a, b)| a.processor() / b.processor());
            format!("{:.2}", median(each.collect()))
        };
        table.push([(*law).to_owned(), ratio(1, 0), ratio(1, 2), ratio(2, 0)]);
    }
    table
}

/// What two ranks have, beside what `mpm-mpi check` predicts.
fn shares(two: &Run, longer: &Run, predicted: &[Predicted]) -> Table {
    let text = format!(
        "What `mpm-mpi check` predicts of two ranks (bytes for 5 Newton iterations), and what they held and sent in a load step of {} (PETSc's messages are not counted).",
        longer.newton.saturating_sub(two.newton)
    );
    let heads = [
        "rank",
        "points",
        "nodes",
        "shared",
        "MB predicted",
        "MB held",
        "kB a step predicted",
        "kB a step sent",
    ];
    let mut table = Table::new(text, &heads);
    for (rank, it) in predicted.iter().enumerate() {
        let (one, both) = (&two.each[rank], &longer.each[rank]);
        table.push([
            rank.to_string(),
            it.points.to_string(),
            it.nodes.to_string(),
            it.shared.to_string(),
            format!("{:.0}", 1e-6 * it.memory),
            format!("{:.0}", 1e-6 * one.memory),
            format!("{:.0}", 1e-3 * it.bytes),
            format!("{:.0}", 1e-3 * (both.bytes - one.bytes)),
        ]);
    }
    table
}
