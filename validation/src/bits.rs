//! Whether two builds of `mpm` write the same results, bit for bit.
//!
//! Both programs run every scene of `scenes/` and `validation/scenes/`, and go on with runs from a checkpoint in their
//! middle. All datasets and attributes of the results are compared: name, type, shape, and the bits of every value. What is
//! left out is listed in [`LEFT_OUT`].

use crate::Broken;
use mpm_io::{Item, Results};
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// Items that may differ between two runs of one scene, each with the reason.
pub const LEFT_OUT: [(&str, &str); 3] = [
    ("history/wall_seconds", "time of every load step"),
    ("timings/seconds", "time of every phase"),
    ("@program", "version of the program"),
];

/// Runs that are resumed: scene, and the load step whose checkpoint they are resumed from. It is more than half of the
/// scene's load steps, so that no later checkpoint replaces it.
const RESUMED: [(&str, u32); 3] = [("collapse", 25), ("doughnut_limit", 100), ("path_doughnut", 60)];

/// A run that both programs make.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Its name in the table.
    pub name: String,
    scene: PathBuf,
    /// Load steps before the checkpoint from which the run goes on.
    resumed_after: Option<u32>,
}

/// All runs whose names hold one of `parts`, or all where there are none.
///
/// # Errors
/// A folder of scenes cannot be read, or a part is in no name.
pub fn plans(parts: &[String]) -> Result<Vec<Plan>, Broken> {
    let mut plans = Vec::new();
    for (folder, prefix) in [("../scenes", ""), ("scenes", "validation/")] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        for entry in entries {
            let scene = entry?.path();
            let Some(stem) = scene.file_stem().and_then(|it| it.to_str()) else { continue };
            if scene.extension().is_none_or(|extension| extension != "ron") {
                continue;
            }
            let name = format!("{prefix}{stem}");
            if let Some((_, after)) = RESUMED.iter().find(|(scene, _)| *scene == name) {
                let name = format!("{name}, resumed after {after}");
                plans.push(Plan { name, scene: scene.clone(), resumed_after: Some(*after) });
            }
            plans.push(Plan { name, scene, resumed_after: None });
        }
    }
    plans.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(part) = parts.iter().find(|part| plans.iter().all(|plan| !plan.name.contains(*part))) {
        return Err(format!("no scene has {part:?} in its name").into());
    }
    plans.retain(|plan| parts.is_empty() || parts.iter().any(|part| plan.name.contains(part)));
    Ok(plans)
}

/// What one program made of a run.
struct Outcome {
    items: Vec<Item>,
    status: String,
    load_steps: usize,
    took: Duration,
}

impl Plan {
    /// Runs the scene with one program in an empty folder.
    fn run(&self, program: &Path, folder: &Path) -> Result<Outcome, Broken> {
        let (results, checkpoint) = (folder.join("results.h5"), folder.join("checkpoint.h5"));
        let start = |what: &str, file: &Path, more: &[String]| -> Result<(), Broken> {
            let mut command = Command::new(program);
            command.args([what, "--quiet", "--threads", "1", "-o"]).arg(&results).arg(file).args(more);
            let output = command.current_dir(folder).output()?;
            match output.status.code() {
                // A run that could not finish has results, too; refused input has none.
                Some(0 | 1) => Ok(()),
                _ => {
                    let said = String::from_utf8_lossy(&output.stderr);
                    Err(format!("{}: {}: {}", self.name, output.status, said.trim()).into())
                }
            }
        };
        let clock = Instant::now();
        match self.resumed_after {
            None => start("run", &self.scene, &[])?,
            Some(after) => {
                let kept = ["--checkpoint".into(), checkpoint.display().to_string()];
                let every = ["--checkpoint-every".into(), after.to_string()];
                start("run", &self.scene, &[kept, every].concat())?;
                start("resume", &checkpoint, &[])?;
            }
        }
        let took = clock.elapsed();
        let file = Results::open(&results)?;
        let items = file.contents()?;
        Ok(Outcome { items, status: file.status().into(), load_steps: file.rows().saturating_sub(1), took })
    }
}

/// One item that is not the same in two results files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The item.
    pub item: String,
    /// What differs first, and how much does.
    pub what: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.item, self.what)
    }
}

/// Compares what two results files hold, but for [`LEFT_OUT`]. The items are sorted by name.
pub fn differences(old: &[Item], new: &[Item]) -> Vec<Difference> {
    let of = |items: &[Item], name: &str| items.iter().position(|item| item.name == name);
    let mut found = Vec::new();
    for item in old {
        let what = match of(new, &item.name) {
            None => Some("only the old program writes it".into()),
            Some(at) => difference(item, &new[at]),
        };
        found.extend(what.map(|what| Difference { item: item.name.clone(), what }));
    }
    for item in new.iter().filter(|item| of(old, &item.name).is_none()) {
        found.push(Difference { item: item.name.clone(), what: "only the new program writes it".into() });
    }
    found.retain(|difference| LEFT_OUT.iter().all(|(name, _)| *name != difference.item));
    found
}

/// The first difference of two items of one name.
fn difference(old: &Item, new: &Item) -> Option<String> {
    if old.values.kind() != new.values.kind() {
        return Some(format!("type {} before, {} now", old.values.kind(), new.values.kind()));
    }
    let differing = old.values.differences(&new.values);
    let shapes = (old.shape != new.shape).then(|| format!("shape {:?} before, {:?} now", old.shape, new.shape));
    let first = differing.first().map(|&k| {
        let (before, now) = (short(old.values.show(k)), short(new.values.show(k)));
        let (all, index) = (old.values.len(), index(&old.shape, k));
        format!("{before} before, {now} now at {index:?}; {} of {all} values differ", differing.len())
    });
    match (shapes, first) {
        (None, None) => None,
        (shapes, first) => Some([shapes, first].into_iter().flatten().collect::<Vec<_>>().join("; ")),
    }
}

/// The beginning of a long text.
fn short(text: String) -> String {
    const LONGEST: usize = 60;
    if text.chars().count() <= LONGEST { text } else { text.chars().take(LONGEST).chain(['…']).collect() }
}

/// Index along every axis of the value at `k`.
fn index(shape: &[usize], mut k: usize) -> Vec<usize> {
    let mut index = vec![0; shape.len()];
    for (at, &length) in index.iter_mut().zip(shape).rev() {
        (*at, k) = (k % length, k / length);
    }
    index
}

/// A run that both programs made.
pub struct Compared {
    /// Its name.
    pub name: String,
    /// Where the results differ.
    pub differences: Vec<Difference>,
    status: String,
    load_steps: usize,
    items: usize,
    values: usize,
    took: [Duration; 2],
}

/// Makes a run with both programs, at the same time, and compares the results.
///
/// # Errors
/// A program does not start, refuses the scene, crashes, or its results cannot be read.
pub fn compare(plan: &Plan, old: &Path, new: &Path) -> Result<Compared, Broken> {
    let folders = [tempfile::tempdir()?, tempfile::tempdir()?];
    let [old, new] = std::thread::scope(|scope| {
        let runs = [(old, &folders[0]), (new, &folders[1])]
            .map(|(program, folder)| scope.spawn(move || plan.run(program, folder.path())));
        runs.map(|run| run.join().expect("the thread does not panic"))
    });
    let (old, new) = (old?, new?);
    Ok(Compared {
        name: plan.name.clone(),
        differences: differences(&old.items, &new.items),
        status: new.status,
        load_steps: new.load_steps,
        items: new.items.len(),
        values: new.items.iter().map(|item| item.values.len()).sum(),
        took: [old.took, new.took],
    })
}

/// Head of the table that [`Compared::row`] fills.
pub const HEAD: &str = "| run | ended | load steps | items | values | seconds, old and new | differing items |\n|---|---|---|---|---|---|---|";

impl Compared {
    /// One row of the table.
    pub fn row(&self) -> String {
        let status = self.status.split(':').next().unwrap_or_default();
        let [old, new] = self.took.map(|it| it.as_secs_f64());
        format!(
            "| {} | {status} | {} | {} | {} | {old:.2} {new:.2} | {} |",
            self.name,
            self.load_steps,
            self.items,
            self.values,
            self.differences.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_io::Values;

    fn item(name: &str, values: &[f64]) -> Item {
        Item { name: name.into(), shape: vec![values.len() / 2, 2], values: Values::Real(values.to_vec()) }
    }

    #[test]
    fn the_first_difference_of_every_item_is_told() {
        let old = [item("a", &[1.0, 2.0, 3.0, 4.0]), item("b", &[0.0, f64::NAN]), item("c", &[])];
        assert!(differences(&old, &old).is_empty());
        let new = [item("a", &[1.0, 2.0, 3.5, 4.5]), item("b", &[-0.0, f64::NAN]), item("d", &[])];
        let found: Vec<String> = differences(&old, &new).iter().map(Difference::to_string).collect();
        let expected = [
            "a: 3e0 before, 3.5e0 now at [1, 0]; 2 of 4 values differ",
            "b: 0e0 before, -0e0 now at [0, 0]; 1 of 2 values differ",
            "c: only the old program writes it",
            "d: only the new program writes it",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn types_and_shapes_are_compared() {
        let old = [item("a", &[1.0, 2.0])];
        let kind = [Item { name: "a".into(), shape: vec![1, 2], values: Values::Count(vec![1, 2]) }];
        assert_eq!(differences(&old, &kind)[0].what, "type f64 before, u64 now");
        let longer = differences(&old, &[item("a", &[1.0, 2.0, 3.0, 4.0])]);
        assert_eq!(longer[0].what, "shape [1, 2] before, [2, 2] now");
    }

    #[test]
    fn times_are_left_out() {
        let of = |seconds: f64| [item("history/wall_seconds", &[seconds, seconds])];
        assert!(differences(&of(1.0), &of(2.0)).is_empty());
        assert!(differences(&of(1.0), &[]).is_empty());
    }

    #[test]
    fn every_scene_is_run_and_some_are_resumed() {
        let all = plans(&[]).expect("the folders are there");
        assert!(all.len() >= 35, "{}", all.len());
        for (scene, _) in RESUMED {
            assert_eq!(
                all.iter().filter(|plan| plan.name.starts_with(&format!("{scene}, resumed"))).count(),
                1
            );
        }
        assert_eq!(plans(&["path_arch".into()]).expect("there is one").len(), 1);
        assert!(plans(&["no such scene".into()]).is_err());
    }
}
