//! `mpm inspect`: what a results file holds, for people and for machines.

use crate::complaint::Complaint;
use crate::report::{self, Row, Table, count};
use crate::terminal::Lines;
use mpm_grid::{rounded, six_digits};
use mpm_io::{Results, ResultsError, component_name, is_being_written};
use mpm_scene::Scene;
use mpm_solver::HistoryNotes;
use mpm_solver::observe::Space;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::Path;

/// Prefix of the phases that count work that was left out.
const SKIPPED: &str = "skipped: ";

/// Of results that nobody writes.
const LEFT: &str = " when it was last written; no program writes it now";

/// What a results file holds.
pub fn inspect(file: &Path, as_json: bool) -> Result<String, Complaint> {
    let found = Inspection::of(file).map_err(|error| Complaint::input(error.to_string()))?;
    Ok(if as_json { format!("{:#}\n", found.json()) } else { found.text() })
}

/// Smallest and largest number, and the last one.
#[derive(Clone, Copy, Debug)]
struct Range {
    least: f64,
    most: f64,
    last: f64,
}

impl Range {
    fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut range = Self { least: f64::INFINITY, most: f64::NEG_INFINITY, last: f64::NAN };
        for value in values {
            range.include(value);
        }
        range
    }

    fn include(&mut self, value: f64) {
        self.least = self.least.min(value);
        self.most = self.most.max(value);
        self.last = value;
    }

    /// Not a number becomes null.
    fn json(&self) -> Value {
        json!({ "smallest": self.least, "largest": self.most })
    }
}

struct Inspection {
    file: String,
    title: String,
    space: Space,
    status: String,
    /// Whether it is said to run, and no program writes it.
    is_left: bool,
    program: String,
    /// Number of the first row.
    first_row: usize,
    rows: usize,
    points: usize,
    fractions: Vec<f64>,
    /// Name and one range per component.
    history: Vec<(String, Vec<Range>)>,
    /// Name, unit, and one range per component over all recorded steps.
    fields: Vec<(String, String, Vec<Range>)>,
    steps: Vec<Row>,
    /// Load steps in each stage, where the schedule has stages: name and number.
    stages: Vec<(String, usize)>,
    timings: Vec<mpm_io::PhaseTime>,
}

impl Inspection {
    fn of(file: &Path) -> Result<Self, ResultsError> {
        let results = Results::open(file)?;
        let mut history = Vec::new();
        for column in results.columns() {
            let table = results.column(&column.name)?;
            let component = |c: usize| Range::of((0..table.len()).map(|row| table.row(row)[c]));
            history.push((column.name.clone(), (0..table.width()).map(component).collect()));
        }
        let recorded = results.fractions().len();
        let mut fields = Vec::new();
        for name in results.fields()? {
            let unit = results.unit(&name)?;
            let mut ranges: Vec<Range> = Vec::new();
            for step in 0..recorded {
                let table = results.field(&name, step)?;
                ranges.resize(table.width(), Range::of([]));
                for point in 0..table.len() {
                    ranges.iter_mut().zip(table.row(point)).for_each(|(range, value)| range.include(*value));
                }
            }
            fields.push((name, unit, ranges));
        }
        let scene = Scene::from_ron(results.scene()).ok();
        let points = if recorded > 0 { results.points(recorded - 1)?.len() } else { 0 };
        Ok(Self {
            file: file.display().to_string(),
            // The results can be read even if the scene is of another version of the language.
            title: scene.as_ref().map_or(String::new(), |scene| scene.title().to_string()),
            space: results.space(),
            status: results.status().to_string(),
            is_left: results.status() == "running" && !is_being_written(file),
            program: results.program().to_string(),
            first_row: results.first_row(),
            rows: results.rows(),
            points,
            fractions: results.fractions().to_vec(),
            history,
            fields,
            steps: steps(&results)?,
            stages: stages(&results, scene.as_ref())?,
            timings: results.timings()?,
        })
    }

    fn text(&self) -> String {
        let mut lines = Lines::new();
        let mut line = |name: &str, value: String| lines.add(name, value);
        if !self.title.is_empty() {
            line("scene", self.title.clone());
        }
        line("status", rounded(&self.status) + if self.is_left { LEFT } else { "" });
        line("written by", self.program.clone());
        line(
            "load steps",
            format!("{}, {} halved", count(self.steps.len()), count(self.total(|row| row.cuts))),
        );
        if !self.stages.is_empty() {
            let told = self.stages.iter().map(|(name, steps)| format!("`{name}` {}", count(*steps)));
            line("stages", told.collect::<Vec<_>>().join(", "));
        }
        if self.first_row > 0 {
            line("first step here", count(self.first_row));
        }
        let iterations = self.total(|row| row.residuals.len() as u64);
        line(
            "iterations",
            format!("{}, {} corrections shortened", count(iterations), count(self.total(|row| row.shortened))),
        );
        line("material points", count(self.points));
        let ends = self.fractions.first().zip(self.fractions.last());
        let ends = ends.map_or(String::new(), |(a, b)| {
            format!(", load fraction {} to {}", six_digits(*a), six_digits(*b))
        });
        line("recorded", format!("{} steps{ends}", count(self.fractions.len())));
        let time = self.timings.iter().filter(|it| it.count > 0 && !it.phase.starts_with(SKIPPED));
        let time: Vec<String> =
            time.map(|it| format!("{} {:.3} s ({}×)", it.phase, it.seconds, it.count)).collect();
        line("time", time.join(", "));
        let skipped: Vec<String> =
            self.skipped().map(|(name, number)| format!("{} {name}", count(number))).collect();
        line("skipped", skipped.join("; "));
        self.notes().into_iter().for_each(|note| line("note", note));

        let mut text = lines.into_text();
        let mut table = Table::new(["smallest", "largest", "last", "history"]);
        for (name, ranges) in &self.history {
            for (c, range) in ranges.iter().enumerate() {
                let name = format!("{name}{}", component_name(self.space, ranges.len(), c));
                table.push([six_digits(range.least), six_digits(range.most), six_digits(range.last), name]);
            }
        }
        let _ = write!(text, "\n{table}");
        let mut table = Table::new(["smallest", "largest", "field, over all recorded steps"]);
        for (name, unit, ranges) in &self.fields {
            // In the plane much of a tensor is zero.
            let is_told = |range: &Range| ranges.len() == 1 || range.least != 0.0 || range.most != 0.0;
            for (c, range) in ranges.iter().enumerate().filter(|(_, range)| is_told(range)) {
                let name = format!("{name}{} [{unit}]", component_name(self.space, ranges.len(), c));
                table.push([six_digits(range.least), six_digits(range.most), name]);
            }
        }
        let _ = write!(text, "\n{table}\n{}", report::convergence(&self.steps));
        text
    }

    fn json(&self) -> Value {
        let history = self.history.iter().map(|(name, ranges)| {
            let of = |value: fn(&Range) -> f64| ranges.iter().map(value).collect::<Vec<_>>();
            let entry =
                json!({ "smallest": of(|it| it.least), "largest": of(|it| it.most), "last": of(|it| it.last) });
            (name.clone(), entry)
        });
        let fields = self.fields.iter().map(|(name, unit, ranges)| {
            let components: Vec<Value> = ranges.iter().map(Range::json).collect();
            (name.clone(), json!({ "unit": unit, "components": components }))
        });
        let newton = self.steps.iter().map(|row| {
            json!({
                "step": row.step, "load_fraction": row.fraction, "equations": row.equations,
                "method": report::method(row.method), "cuts": row.cuts,
                "shortened_corrections": row.shortened, "residuals": row.residuals,
            })
        });
        let time = self.timings.iter().filter(|it| !it.phase.starts_with(SKIPPED));
        let time = time.map(|it| (it.phase.clone(), json!({ "seconds": it.seconds, "count": it.count })));
        json!({
            "file": self.file, "title": self.title, "status": self.status, "program": self.program,
            "load_steps": self.steps.len(), "first_row": self.first_row, "rows": self.rows,
            "iterations": self.total(|row| row.residuals.len() as u64),
            "cuts": self.total(|row| row.cuts), "material_points": self.points,
            "recorded_load_fractions": self.fractions,
            "stages": self.stages.iter().map(|(name, steps)| json!({ "name": name, "load_steps": steps })).collect::<Vec<_>>(),
            "history": history.collect::<Map<_, _>>(),
            "fields": fields.collect::<Map<_, _>>(),
            "newton": newton.collect::<Vec<_>>(),
            "time": time.collect::<Map<_, _>>(),
            "notes": self.notes(),
            "skipped": self.skipped().map(|(name, number)| (name.to_string(), json!(number))).collect::<Map<_, _>>(),
        })
    }

    /// What of the history is worth a word.
    fn notes(&self) -> Vec<String> {
        let deepest = |(name, ranges): &(String, Vec<Range>)| {
            let largest = ranges.first().map_or(0.0, |range| range.most);
            HistoryNotes::note(name, largest)
        };
        self.history.iter().filter_map(deepest).collect()
    }

    fn total(&self, of: impl Fn(&Row) -> u64) -> u64 {
        self.steps.iter().map(of).sum()
    }

    fn skipped(&self) -> impl Iterator<Item = (&str, u64)> {
        let skipped = self.timings.iter().filter_map(|it| Some((it.phase.strip_prefix(SKIPPED)?, it.count)));
        skipped.filter(|(_, count)| *count > 0)
    }
}

/// The stages that a run has come to and the load steps in each, without the initial state; none without stages.
fn stages(results: &Results, scene: Option<&Scene>) -> Result<Vec<(String, usize)>, ResultsError> {
    const COLUMN: &str = "stage/number";
    if !results.columns().iter().any(|column| column.name == COLUMN) {
        return Ok(Vec::new());
    }
    let names = scene.map_or(&[][..], |scene| &scene.schedule().stages);
    let column = results.column(COLUMN)?;
    let mut stages: Vec<(String, usize)> = Vec::new();
    let rows = (0..results.rows()).filter(|row| results.first_row() + row > 0);
    // Each stage has a row at least, if the file is as it was written.
    let most = names.len().max(results.rows());
    let numbers = rows.map(|row| column.row(row)[0] as usize);
    for number in numbers.filter(|number| (1..=most).contains(number)) {
        while stages.len() < number {
            let name =
                names.get(stages.len()).map_or_else(|| (stages.len() + 1).to_string(), |it| it.name.clone());
            stages.push((name, 0));
        }
        stages[number - 1].1 += 1;
    }
    Ok(stages)
}

/// The load steps of a results file, without the initial state.
fn steps(results: &Results) -> Result<Vec<Row>, ResultsError> {
    let counts = |name: &str| results.column(name).map(|table| table.values().to_vec());
    let fractions = counts("load_fraction")?;
    // These columns may be missing.
    let [equations, method, cuts, shortened] = ["equations", "factorization", "cuts", "shortened_corrections"]
        .map(|name| counts(name).unwrap_or_default());
    let at = |column: &[f64], row: usize| column.get(row).map_or(0, |value| *value as u64);
    let first = results.first_row();
    let rows = (0..results.rows()).filter(|row| first + row > 0);
    rows.map(|row| {
        Ok(Row {
            step: first + row,
            fraction: fractions[row],
            residuals: results.residuals(row)?,
            equations: at(&equations, row),
            method: at(&method, row),
            cuts: at(&cuts, row),
            shortened: at(&shortened, row),
        })
    })
    .collect()
}
