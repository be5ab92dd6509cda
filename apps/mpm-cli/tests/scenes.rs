//! What is made of scenes: `mpm new`, values set on the command line, `mpm sweep`, output for machines.

mod common;

use common::{flat, mpm, says};
use mpm_io::Results;
use std::path::Path;

#[track_caller]
fn complains(directory: &Path, arguments: &[&str]) -> String {
    common::complains(directory, 2, arguments)
}

#[test]
fn templates_are_listed_written_and_run() {
    let folder = tempfile::tempdir().unwrap();
    let list = says(folder.path(), &["new", "--list"]);
    assert!(list.lines().count() >= 16 && list.contains("doughnut_elastic "), "{list}");
    assert_eq!(says(folder.path(), &["new", "first"]), "first.ron\n");
    assert_eq!(says(folder.path(), &["new", "first", "mine.ron"]), "mine.ron\n");
    let text = std::fs::read_to_string(folder.path().join("mine.ron")).unwrap();
    assert_eq!(says(folder.path(), &["new", "first", "-"]), text);
    assert!(text.lines().filter(|line| line.trim().starts_with("//")).count() >= 5, "{text}");
    says(folder.path(), &["run", "-q", "mine.ron"]);
    assert_eq!(Results::open(folder.path().join("mine.h5")).unwrap().status(), "completed");

    let error = complains(folder.path(), &["new", "first", "mine.ron"]);
    assert!(error.contains("cannot create scene mine.ron: File exists"), "{error}");
    let error = complains(folder.path(), &["new", "frist"]);
    assert!(error.contains("no template named `frist`; there are first, simple_stretch"), "{error}");
    // Every one of them is a scene.
    for name in list.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next()) {
        says(folder.path(), &["new", name, &format!("{name}_.ron")]);
        says(folder.path(), &["check", &format!("{name}_.ron")]);
    }
}

#[test]
fn values_are_set_before_the_scene_is_read() {
    let folder = tempfile::tempdir().unwrap();
    says(folder.path(), &["new", "first", "a.ron"]);
    let arguments = ["run", "a.ron", "-q", "--set", "schedule.steps=3", "--set", "materials.rubber.young=2e4"];
    says(folder.path(), &arguments);
    let results = Results::open(folder.path().join("a.h5")).unwrap();
    // The start, three equal steps, and one that ends at the knot of the ramp.
    assert_eq!(results.rows(), 5);
    // The results keep the scene as it was run, with its comments.
    assert!(results.scene().contains("schedule: (steps: 3)") && results.scene().contains("// 2 × 2"));
    assert!(results.scene().contains("young: 2e4"));
    assert!(!std::fs::read_to_string(folder.path().join("a.ron")).unwrap().contains("2e4"));

    let text = says(folder.path(), &["check", "a.ron", "--set", "bodies[0].points_per_cell=3"]);
    assert!(text.contains("material points   144"), "{text}");
    let json = says(folder.path(), &["check", "a.ron", "--set", "bodies[0].points_per_cell=3", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["material_points"], &json["cells_with_material"]), (&144.into(), &16.into()));
    let memory = json["memory"].as_object().unwrap();
    let sum: u64 = memory.iter().filter(|(name, _)| *name != "total").map(|(_, n)| n.as_u64().unwrap()).sum();
    assert_eq!(memory["total"], sum);
}

#[test]
fn a_wrong_setting_is_told_as_such() {
    let folder = tempfile::tempdir().unwrap();
    says(folder.path(), &["new", "first", "a.ron"]);
    for command in ["check", "run"] {
        let text =
            complains(folder.path(), &[command, "a.ron", "--set", "materials.rubber=VonMises(young: 1)"]);
        let part = "missing field `poisson`";
        assert!(flat(&text).contains(part) && text.contains("[--set:1:35]"), "{text}");
    }
    // An error in the file is reported at the file.
    let broken = std::fs::read_to_string(folder.path().join("a.ron")).unwrap().replace("basis:", "bases:");
    std::fs::write(folder.path().join("broken.ron"), broken).unwrap();
    let text = complains(folder.path(), &["check", "broken.ron", "--set", "schedule.steps=3"]);
    assert!(text.contains("[broken.ron:6:5]"), "{text}");
}

#[test]
fn runs_tell_machines() {
    let folder = tempfile::tempdir().unwrap();
    says(folder.path(), &["new", "first", "a.ron"]);
    let output = mpm(folder.path(), &["run", "a.ron", "--json", "--set", "schedule.steps=2"]);
    assert!(output.stderr.is_empty());
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["status"], &json["load_steps"]), (&"completed".into(), &3.into()));
    // A run that cannot finish says so in both.
    let hopeless = ["run", "a.ron", "--json", "--set", "tolerance.iterations=1", "--set", "schedule.cuts=0"];
    let output = mpm(folder.path(), &hopeless);
    assert_eq!(output.status.code(), Some(1));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(json["status"].as_str().unwrap().starts_with("failed: load step 1"), "{json}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("no equilibrium"));
}

#[test]
fn a_sweep_runs_every_combination_once() {
    let folder = tempfile::tempdir().unwrap();
    says(folder.path(), &["new", "first", "a.ron"]);
    let sweep = |steps: &'static str| {
        let steps = format!("schedule.steps={steps}");
        mpm(folder.path(), &["sweep", "a.ron", "--set", &steps, "--set", "basis=Smpm,Cpdi1", "--jobs", "2"])
    };
    let output = sweep("2,3");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let run = String::from_utf8(output.stderr).unwrap();
    assert_eq!(run.lines().filter(|line| line.ends_with(": completed")).count(), 4, "{run}");
    let table = std::fs::read_to_string(folder.path().join("a_sweep/results.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 5);
    assert!(
        lines[0].starts_with("schedule.steps,basis,status,load_fraction,load_steps,iterations,cuts"),
        "{table}"
    );
    assert!(lines[1].starts_with("2,Smpm,completed,1,3,") && lines[4].starts_with("3,Cpdi1,completed,1,"));
    let name = "schedule.steps=3,basis=Cpdi1";
    let results = folder.path().join("a_sweep").join(name).join("results.h5");
    let at = lines[0].split(',').position(|head| head == "reaction/clamp.y last").unwrap();
    let clamp = Results::open(&results).unwrap().column("reaction/clamp").unwrap();
    assert_eq!(lines[4].split(',').nth(at).unwrap().parse::<f64>().unwrap(), clamp.row(clamp.len() - 1)[1]);

    // Finished runs are not run again; missing and unfinished ones are.
    let before = std::fs::metadata(&results).unwrap().modified().unwrap();
    std::fs::remove_file(folder.path().join("a_sweep/schedule.steps=2,basis=Smpm/results.h5")).unwrap();
    let output = sweep("2,3,4");
    let run = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{run}");
    assert!(run.contains("3 of 3: ") && !run.contains(name), "{run}");
    assert_eq!(std::fs::metadata(&results).unwrap().modified().unwrap(), before);
    let shown = String::from_utf8(output.stdout).unwrap();
    assert_eq!(shown.lines().filter(|line| line.ends_with("completed")).count(), 6, "{shown}");
}

#[test]
fn a_sweep_says_which_runs_failed_and_refuses_wrong_values_at_once() {
    let folder = tempfile::tempdir().unwrap();
    says(folder.path(), &["new", "first", "a.ron"]);
    let arguments = [
        "sweep",
        "a.ron",
        "--set",
        "tolerance.iterations=1,25",
        "--set",
        "schedule.cuts=0",
        "--jobs",
        "1",
        "-o",
        "s",
    ];
    let output = mpm(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(1));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("failed: load step 1") && table.contains("completed"), "{table}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("1 of 2 runs did not complete"));
    // It would fail again.
    let output = mpm(folder.path(), &arguments);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("1 of 1"));

    let text = complains(folder.path(), &["sweep", "a.ron", "--set", "schedule.steps=2,0", "-o", "t"]);
    assert!(text.contains("got 0") && text.contains("[--set:1:16]"), "{text}");
    assert!(!folder.path().join("t").exists(), "nothing is run before all is checked");
    let twice = ["sweep", "a.ron", "--set", "basis=Smpm", "--set", "basis=Cpdi1"];
    assert!(complains(folder.path(), &twice).contains("basis is given twice"));
}

#[test]
fn shells_and_manuals_know_every_command() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let script = says(folder.path(), &["completions", shell]);
        // Fields of points are offered, too; names of templates where a shell's script completes what stands alone.
        let template = if shell == "fish" { "plot" } else { "corner_stretch_kite" };
        for command in ["run", "plot", "sweep", "inspect", "export", "cauchy_stress", template] {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    assert!(says(folder.path(), &["man"]).contains(".TH mpm 1"));
    for section in ["Examples:", "Exit status:", "Files:"] {
        assert!(says(folder.path(), &["man"]).contains(section), "{section}");
    }
    assert!(says(folder.path(), &["man", "-o", "."]).is_empty());
    assert!(std::fs::read_to_string(folder.path().join("mpm-sweep.1")).unwrap().contains("jobs"));
    assert!(complains(folder.path(), &["man", "-o", "none"]).contains("cannot write manual pages to none"));
}

/// Colours are for terminals whose user wants them.
#[test]
fn no_colour_where_nobody_looks() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["help"][..], &["run", "none.ron"], &["walk"]] {
        let output = mpm(folder.path(), arguments);
        let said = [output.stdout, output.stderr].concat();
        assert!(!said.is_empty() && !said.contains(&0x1b), "{arguments:?}");
    }
}
