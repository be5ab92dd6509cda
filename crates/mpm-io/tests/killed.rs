//! A run killed at any moment leaves a file with every load step it had finished.

mod fake;

use std::error::Error;
use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use mpm_io::{Options, Results, ResultsWriter};
use mpm_solver::observe::{Entry, Fields};

/// Set for the process that writes and is killed; its value is the path.
const VICTIM: &str = "MPM_IO_KILLED_RUN";
/// Set to make it compress.
const LEVEL: &str = "MPM_IO_KILLED_RUN_LEVEL";
const POINTS: usize = 50;
const EVERY: usize = 3;
const KILLS: usize = 60;

#[test]
fn killed_runs_keep_their_load_steps() -> Result<(), Box<dyn Error + Send + Sync>> {
    if let Ok(path) = std::env::var(VICTIM) {
        return write_on_and_on(&path);
    }
    let directory = tempfile::tempdir()?;
    let began = Instant::now();
    let mut steps_seen = 0;
    for kill in 0..KILLS {
        let path = directory.path().join(format!("killed{kill}.h5"));
        let mut victim = Command::new(std::env::current_exe()?)
            .args(["--exact", "killed_runs_keep_their_load_steps", "--nocapture"])
            .env(VICTIM, &path)
            .env(LEVEL, if kill % 2 == 0 { "0" } else { "1" })
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()?;
        let mut dots = victim.stderr.take().expect("stderr is piped");
        let mut text = vec![0];
        dots.read_exact(&mut text)?;
        // Moments spread over 0 to 40 ms in an order without pattern.
        sleep(Duration::from_micros((kill * 7_919 % KILLS * 40_000 / KILLS) as u64));
        victim.kill()?;
        victim.wait()?;
        dots.read_to_end(&mut text)?;
        assert!(text.iter().all(|&dot| dot == b'.'), "victim: {}", String::from_utf8_lossy(&text));
        steps_seen += text.len();
        check(&path, text.len()).map_err(|error| format!("kill {kill} after {} rows: {error}", text.len()))?;
        std::fs::remove_file(&path)?;
    }
    assert!(steps_seen > 2 * KILLS, "only {steps_seen} load steps in {KILLS} runs, {:?}", began.elapsed());
    Ok(())
}

/// Writes load steps without end, and a dot after each.
fn write_on_and_on(path: &str) -> Result<(), Box<dyn Error + Send + Sync>> {
    let compression = std::env::var(LEVEL)?.parse()?;
    let mut writer = ResultsWriter::create(
        path,
        Options { every: EVERY, compression, keep_back: Duration::ZERO, ..fake::options() },
    )?;
    fake::start(&mut writer, POINTS)?;
    for step in 0.. {
        fake::load_step(&mut writer, step, POINTS)?;
        std::io::stderr().write_all(b".")?;
    }
    Ok(())
}

/// All rows that the victim had announced are there, and at most the one it was writing.
fn check(path: &std::path::Path, announced: usize) -> Result<(), Box<dyn Error + Send + Sync>> {
    let results = Results::open(path)?;
    assert_eq!(results.status(), "running");
    assert!(
        (announced..=announced + 1).contains(&results.rows()),
        "{} rows, {announced} announced",
        results.rows()
    );
    for column in fake::columns() {
        let table = results.column(&column.name)?;
        for row in 0..results.rows() {
            let at = fake::columns().iter().position(|other| *other == column).expect("it is one of them");
            let expected = match &fake::row(row)[at] {
                Entry::Count(values) => values.iter().map(|&value| value as f64).collect(),
                Entry::Real(values) => values.clone(),
            };
            assert_eq!(table.row(row), expected, "{} row {row}", column.name);
        }
    }
    for row in 0..results.rows() {
        assert_eq!(results.residuals(row)?, fake::residuals(row), "row {row}");
    }
    let recorded = results.fractions().len();
    assert!(
        recorded >= announced.div_ceil(EVERY) && recorded <= (announced + 1).div_ceil(EVERY),
        "{recorded} recorded"
    );
    for k in 0..recorded {
        let cloud = fake::Cloud { step: k * EVERY, points: POINTS };
        assert_eq!(results.points(k)?.values(), cloud.positions(), "recorded step {k}");
        for field in fake::fields() {
            assert_eq!(
                results.field(field.name(), k)?.values(),
                cloud.field(field),
                "{field:?}, recorded step {k}"
            );
        }
    }
    Ok(())
}
