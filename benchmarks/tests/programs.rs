//! Quick runs of the program: they end, and what they write has the shape that readers expect.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Runs a set quickly and reads what it wrote.
fn quick(set: &str, folder: &Path) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_mpm-benchmarks"))
        .args([set, "--quick", "--output"])
        .arg(folder)
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let file = if set == "error" { "time_against_error" } else { set };
    let text = std::fs::read_to_string(folder.join(file).with_extension("json")).expect("results are written");
    let value: Value = serde_json::from_str(&text).expect("results are JSON");
    assert_eq!(value["set"], file);
    assert_eq!(value["quick"], true);
    assert!(value["cores"].as_u64() > Some(0));
    value["results"].clone()
}

fn rows(results: &Value) -> &Vec<Value> {
    results.as_array().expect("a list of rows")
}

#[test]
fn time_against_error() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let results = quick("error", folder.path());
    for problem in
        ["column, hard", "column, mild", "cantilever", "doughnut twist, elastic", "generalised vortex"]
    {
        let of_problem: Vec<&Value> = rows(&results).iter().filter(|row| row["problem"] == problem).collect();
        assert!(of_problem.len() >= 6, "{problem}: {} runs", of_problem.len());
        for row in of_problem {
            assert!(row["seconds"].as_f64() > Some(0.0) && row["points"].as_u64() > Some(0), "{row}");
            // A run has an error or a reason, never both and never neither.
            let error = row["error"].as_f64().is_some_and(|error| error > 0.0 && error < 1.0);
            assert_ne!(error, row["reason"].is_string(), "{row}");
        }
    }
    // AMPLE's error of GIMP on 16 cells.
    let known = rows(&results)
        .iter()
        .find(|row| row["problem"] == "column, hard" && row["basis"] == "GIMP" && row["cells"] == "16");
    let error = known.and_then(|row| row["error"].as_f64()).expect("GIMP on 16 cells ends");
    assert!((error / 3.6589e-3 - 1.0).abs() < 0.01, "{error}");
    let picture = std::fs::read_to_string(folder.path().join("time_against_error.svg")).expect("a picture");
    assert!(picture.contains("generalised vortex") && picture.contains("CPDI2q"));
}

#[test]
fn throughput_and_growth() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let results = quick("throughput", folder.path());
    for limit in ["bandwidth", "fused", "compiled"] {
        assert!(results["limits"][limit].as_f64() > Some(1e8), "{limit}: {}", results["limits"]);
    }
    // Seven bases of the plane, five of space, four phases each.
    assert_eq!(rows(&results["rows"]).len(), 48);
    for row in rows(&results["rows"]) {
        assert!(row["seconds"].as_f64() > Some(0.0), "{row}");
        // How far from the limit is for large sets to say: a small one stays in the cache.
        assert!(row["least_seconds"].as_f64() > Some(0.0), "{row}");
        assert!(row["distance"].as_f64() > Some(0.0), "{row}");
    }

    let results = quick("growth", folder.path());
    let grown = rows(&results["rows"]);
    assert!(grown.windows(2).all(|pair| pair[0]["points"].as_u64() < pair[1]["points"].as_u64()));
    let exponent = results["fits"][0]["total"].as_f64().expect("an exponent");
    assert!(exponent > 0.8 && exponent < 1.6, "{exponent}");
}

#[test]
fn our_solver_is_measured_where_there_is_no_other() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let results = quick("solver", folder.path());
    let ours = rows(&results).iter().find(|row| row["solver"] == "ours, direct").expect("our own row");
    assert!(ours["seconds"]["error"].as_f64() < Some(1e-10), "{ours}");
    assert_eq!(ours["ours_over_this"].as_f64(), Some(1.0), "small systems are factorised");
    let other =
        rows(&results).iter().find(|row| row["solver"] == "ours, iterative").expect("both are measured");
    assert!(other["seconds"]["error"].as_f64() < Some(1e-6), "{other}");
}

#[test]
fn cubes_in_space() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let results = quick("space", folder.path());
    let runs = rows(&results["runs"]);
    assert_eq!(runs.len(), 4);
    for run in runs {
        let (predicted, peak) = (run["predicted_memory"].as_f64(), run["peak_memory"].as_f64());
        let (predicted, peak) = (predicted.expect("a number"), peak.expect("a number"));
        // The prediction includes the program itself, which takes more memory than small cubes.
        assert!(run["processor"].as_f64() > Some(0.0) && peak > 0.0 && peak < 2.0 * predicted, "{run}");
    }
}

#[test]
fn laws_are_paired_with_von_mises() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let results = quick("laws", folder.path());
    for row in rows(&results) {
        let plastic = row["plastic"].as_f64().expect("a number");
        let yields = row["law"].as_str().is_some_and(|name| name.ends_with("yielding"));
        assert!(if yields { plastic > 0.5 } else { plastic == 0.0 }, "{row}");
        assert!(row["seconds"].as_f64() > Some(0.0) && row["ratio"].as_f64() > Some(0.0), "{row}");
    }
}

#[test]
fn whole_processes() {
    // The program is built with the workspace's tests; alone this crate has none.
    let program = Path::new(env!("CARGO_BIN_EXE_mpm-benchmarks")).with_file_name("mpm");
    let folder = tempfile::tempdir().expect("a folder for results");
    if !program.exists() {
        let output = Command::new(env!("CARGO_BIN_EXE_mpm-benchmarks")).args(["small", "--quick"]).output();
        let output = output.expect("the program starts");
        assert!(String::from_utf8_lossy(&output.stderr).contains("build it by"), "{output:?}");
        return;
    }
    let small = quick("small", folder.path());
    assert!(small["start"].as_f64() >= Some(0.0) && rows(&small["rows"]).len() == 2, "{small}");
    let threads = quick("threads", folder.path());
    assert_eq!(rows(&threads).len(), 4);
    for row in rows(&threads) {
        assert!(row["one"].as_f64() > Some(0.0) && row["gain"].as_f64() > Some(0.0), "{row}");
    }
}

#[test]
fn ranks_say_how_to_build_what_they_need() {
    let folder = tempfile::tempdir().expect("a folder for results");
    let nowhere = folder.path().join("mpm-mpi");
    let mut command = Command::new(env!("CARGO_BIN_EXE_mpm-benchmarks"));
    command.args(["ranks", "--quick", "--mpm-mpi"]).arg(&nowhere).arg("--output").arg(folder.path());
    let output = command.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("build it by `sh scripts/mpi.sh"), "{said}");
}

/// A shell script in a folder, to be started as a program.
#[cfg(unix)]
fn program(folder: &Path, name: &str, script: &str) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join(name);
    std::fs::write(&path, format!("#!/bin/sh\n{script}")).expect("the script is written");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("it may be started");
    path
}

/// `foreign/peers.py` with a stand-in for `mpm`, whose two points carry 9/10 of the weight, and a peer that fails.
#[cfg(unix)]
#[test]
fn peers_that_are_missing_or_fail_leave_the_others_their_rows() {
    let folder = tempfile::tempdir().expect("a folder for programs");
    let mpm = "case $1 in --version) echo mpm 0;; export) mkdir tables
        printf 'y,cauchy_stress.yy\\n20,0\\n30,0\\n' >tables/points_0000.csv
        printf 'y,cauchy_stress.yy\\n9,-21600\\n9,-14400\\n' >tables/points_0040.csv;; esac\n";
    let mpm = program(folder.path(), "mpm", mpm);
    let broken = program(folder.path(), "broken", "echo out of order >&2; exit 3\n");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("foreign/peers.py");
    let mut command = Command::new("python3");
    command.arg(script).args("--cells 2 --repetitions 1 --python nowhere --octave nowhere".split(' '));
    command.arg("--mpm").arg(mpm).arg("--geomechanics-mpm").arg(broken).arg("--ample").arg(folder.path());
    command.env_remove("GEOWARP").current_dir(folder.path());
    let output = command.output().expect("python3 starts");
    let (table, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(1), "{table}{said}");
    let of_mpm: Vec<&str> = table.lines().filter(|line| line.starts_with("| mpm 0 |")).collect();
    assert_eq!(of_mpm.len(), 3, "{table}{said}");
    assert!(of_mpm.iter().all(|line| line.ends_with("| 1 | 1.0 | 5.000e-02 |")), "{table}");
    assert!(table.contains("| geomechanics/mpm | standard MPM | failed |"), "{table}");
    for left_out in ["Kratos is", "AMPLE is", "GeoWarp is", "elements are"] {
        assert_eq!(said.matches(&format!("{left_out} left out")).count(), 1, "{left_out}: {said}");
    }
    assert_eq!(said.matches("out of order").count(), 1, "{said}");
}

#[test]
fn a_kernel_that_does_not_exist_is_named() {
    let output = Command::new(env!("CARGO_BIN_EXE_mpm-benchmarks")).args(["kernel", "no such"]).output();
    let output = output.expect("the program starts");
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("no kernel `no such`"));
}
