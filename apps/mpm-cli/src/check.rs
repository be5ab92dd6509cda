//! `mpm check`.

use crate::complaint::Complaint;
use crate::crew::{Crew, agreed};
use crate::input::{self, Input, Settings};
use crate::report::count;
use crate::run::{files_of, start_threads};
use crate::say::say;
use crate::terminal::Lines;
use clap::Args;
use mpm_grid::six_digits;
use mpm_scene::{Check, Scene, implausible, seconds_of_run, unwritten_fields};
use mpm_solver::{Estimate, Memory, StageSteps};
use std::path::PathBuf;

#[derive(Args)]
pub struct CheckArguments {
    /// The scene, a RON file (its language: scenes/README.md, or `mpm schema --markdown`).
    scene: PathBuf,
    #[command(flatten)]
    settings: Settings,
    /// Folder in which the files lie that the scene names [default: that of the scene].
    #[arg(long, value_name = "FOLDER")]
    files: Option<PathBuf>,
    /// Number of threads on which times are measured [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Print it as JSON for machines.
    #[arg(long)]
    json: bool,
}

/// Says how large a scene with these settings is, and what each rank has of it, where several share it.
pub fn check(arguments: &CheckArguments, crew: &dyn Crew) -> Result<(), Complaint> {
    let CheckArguments { scene, settings, threads, json, .. } = arguments;
    start_threads(threads.or(crew.threads()))?;
    let files = files_of(scene, arguments.files.as_deref());
    let mut input = match (agreed(crew, input::read(scene, &settings.set, &files)), crew.share()) {
        (Ok(input), _) => input,
        // What is too large for one rank may be shared by several.
        (Err(_), Some(share)) if !*json => {
            let mut input = agreed(crew, input::read_share(scene, &settings.set, &files, Some(share)))?;
            return tell_shares(&mut input, crew);
        }
        (Err(complaint), _) => return Err(complaint),
    };
    let estimate = input.compiled.estimate().map_err(|error| Complaint::unfinished(error.to_string()));
    let estimate = agreed(crew, estimate)?;
    if crew.leads() && *json {
        let json = serde_json::to_string_pretty(&Check::of(&estimate, &input.scene, &input.notes));
        say(&(json.expect("numbers, texts and lists") + "\n"))?;
    } else if crew.leads() {
        say(&sizes(&estimate, &input.scene, &unwritten_fields(&input.scene), &input.notes))?;
    }
    if *json { Ok(()) } else { tell_shares(&mut input, crew) }
}

/// Says what each rank has.
fn tell_shares(input: &mut Input, crew: &dyn Crew) -> Result<(), Complaint> {
    match crew.shares(&mut input.compiled)? {
        Some(shares) if crew.leads() => say(&shares),
        _ => Ok(()),
    }
}

fn sizes(it: &Estimate, scene: &Scene, unwritten: &[String], notes: &[String]) -> String {
    let title = scene.title();
    let mut lines = Lines::new();
    let mut line = |name: &str, value: String| lines.add(name, value);
    if !title.is_empty() {
        line("scene", title.to_string());
    }
    line("dimensions", it.dimensions.to_string());
    line("material points", count(it.points));
    for volume in &it.volumes {
        let off = volume.shape.map(|shape| (volume.points / shape - 1.0).abs());
        let off = off.map(|off| format!(", {off:.0e} off its shape's")).unwrap_or_default();
        let mass = volume.mass.map(|mass| format!(", mass {}", six_digits(mass))).unwrap_or_default();
        line("volume", format!("{} of `{}`{off}{mass}", six_digits(volume.points), volume.body));
    }
    for tool in &it.tools {
        line("tool", tool.clone());
    }
    line("cells", format!("{}, {} with material", count(it.cells), count(it.cells_with_material)));
    line("nodes", format!("{}, {} active", count(it.nodes), count(it.active_nodes)));
    line("equations", format!("{} ({} more prescribed)", count(it.equations), count(it.prescribed)));
    line("tangent entries", count(it.tangent_entries));
    line("factor entries", format!("{} once bodies have moved", count(it.factor_entries)));
    let prediction = &it.prediction;
    let (direct, iterative) = (
        format!(
            "direct {:.1e} operations, {}",
            prediction.factor_operations,
            bytes(8 * prediction.factor_entries as usize)
        ),
        format!(
            "iterative {:.1e} bytes moved, {}",
            prediction.iterative_traffic,
            bytes(prediction.iterative_bytes as usize)
        ),
    );
    let (chosen, other) = if it.is_iterative { (iterative, direct) } else { (direct, iterative) };
    line("linear solver", format!("{chosen} ({other})"));
    line("memory", memory(&it.memory));
    let per_point = 1e9 * it.seconds.pass / it.points as f64;
    line("assembly", format!("{:.2e} s per pass, {per_point:.0} ns per point", it.seconds.pass));
    line("load steps", count(it.steps));
    it.stages.iter().filter(|it| !it.name.is_empty()).for_each(|stage| line("stage", told_of(stage)));
    line("time", time(it, scene));

    for remark in implausible(scene).iter().chain(&it.remarks) {
        line("note", remark.clone());
    }
    for (k, what) in skipped(it, unwritten).into_iter().enumerate() {
        line(if k == 0 { "skipped" } else { "" }, what);
    }
    for note in notes {
        line("note", note.clone());
    }
    for warning in &it.warnings {
        line("warning", warning.clone());
    }
    lines.into_text()
}

/// What the run takes of memory, in all and by part.
fn memory(it: &Memory) -> String {
    let of_contributions = match it.contributions {
        0 => String::new(),
        held => format!("tools and other forces {}, ", bytes(held)),
    };
    let if_factorised = match it.factorised {
        0 => String::new(),
        held => {
            format!("; {} more once a tangent is factorised that the iteration does not solve", bytes(held))
        }
    };
    format!(
        "about {}: points {}, connectivity {}, tangent {}, solver {}, {of_contributions}vectors and record {}, program {}{if_factorised}",
        bytes(it.total()),
        bytes(it.points),
        bytes(it.connectivity),
        bytes(it.tangent),
        bytes(it.solver),
        bytes(it.work),
        bytes(it.program)
    )
}

/// How long the run takes.
fn time(it: &Estimate, scene: &Scene) -> String {
    let seconds = &it.seconds;
    let told = if seconds.is_tried { "tried" } else { "counted" };
    let tools = match it.tools.is_empty() {
        true => String::new(),
        false => format!(", {:.1e} s for tools", seconds.tools),
    };
    let [least, most] = seconds_of_run(it, scene);
    format!(
        "{} to {} s of processor, more where load steps are halved; in a load step connecting {:.1e} s, in each of about \
         {} Newton iterations {:.1e} s for the points{tools} and {:.1e} s to solve ({told})",
        two_digits(least),
        two_digits(most),
        seconds.connect + seconds.analyse,
        seconds.iterations,
        seconds.pass,
        seconds.solve
    )
}

/// A stage: its steps, and the supports that begin with it or end in it.
fn told_of(stage: &StageSteps) -> String {
    let mut told = format!("`{}`, load steps: {}", stage.name, count(stage.steps));
    for (what, supports) in [("begin", &stage.begun), ("end", &stage.ended)] {
        if !supports.is_empty() {
            let names: Vec<String> = supports.iter().map(|name| format!("`{name}`")).collect();
            told += &format!("; {what}: {}", names.join(", "));
        }
    }
    told
}

/// What the run will do without.
fn skipped(it: &Estimate, unwritten: &[String]) -> Vec<String> {
    let unused = [
        (it.cells - it.cells_with_material, "empty cells"),
        (it.nodes - it.active_nodes, "nodes without material"),
    ];
    let mut skipped: Vec<String> =
        unused.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{} {what}", count(*n))).collect();
    if !it.columns_not_stored.is_empty() {
        skipped.push(format!("not stored per point: {}", it.columns_not_stored.join(", ")));
    }
    if it.columns_not_stored.contains(&"plastic state") {
        skipped.push("no yield checks".into());
    }
    if !unwritten.is_empty() {
        skipped.push(format!("fields not written: {}", unwritten.join(", ")));
    }
    skipped
}

/// A time to two digits.
fn two_digits(seconds: f64) -> String {
    let unit = 10_f64.powi(seconds.log10().floor() as i32 - 1);
    six_digits((seconds / unit).round() * unit)
}

fn bytes(size: usize) -> String {
    let mut value = size as f64;
    let mut unit = "B";
    for next in ["kB", "MB", "GB", "TB"] {
        if value < 1000.0 {
            break;
        }
        (value, unit) = (value / 1000.0, next);
    }
    format!("{} {unit}", six_digits(value))
}
