//! Runs from scene file to results file.

mod common;

use common::mpm;
use mpm_io::Results;

fn shipped(scene: &str) -> String {
    format!("{}/../../scenes/{scene}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_quiet_run_says_nothing_and_leaves_its_results() {
    let directory = tempfile::tempdir().unwrap();
    let output = mpm(directory.path(), &["run", "--quiet", &shipped("simple_stretch.ron")]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());

    let results = Results::open(directory.path().join("simple_stretch.h5")).unwrap();
    assert_eq!((results.status(), results.rows()), ("completed", 41));
    assert!(results.scene().contains("The simple stretch"));
    assert!(results.program().starts_with("mpm "));
    let fraction = results.column("load_fraction").unwrap();
    assert_eq!(fraction.row(40), [1.0]);
    assert!(directory.path().join("simple_stretch.xdmf").exists());
}

/// Names that differ behind a dot are names of different results.
#[test]
fn results_have_the_whole_name_of_their_scene() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::copy(shipped("simple_stretch.ron"), directory.path().join("stretch_0.5.ron")).unwrap();
    let output = mpm(directory.path(), &["run", "--quiet", "stretch_0.5.ron"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for file in ["stretch_0.5.h5", "stretch_0.5.xdmf"] {
        assert!(directory.path().join(file).exists(), "{file}");
    }
}

#[test]
fn a_run_reports_every_step_and_its_totals() {
    let directory = tempfile::tempdir().unwrap();
    let output = mpm(directory.path(), &["run", &shipped("simple_stretch_rollers.ron"), "-o", "r.h5"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    for part in ["step  fraction", "1.000000", "load steps        40", "smallest det ΔF", "r.h5 (and r.xdmf)"]
    {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    // No progress bar where nobody looks.
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Pulled gently for half of the way, then so fast that five iterations are too few.
const TOO_FAST: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 8, ramp: [(0, 0), (0.5, 0.001), (1, 1)])]),
    basis: Smpm,
    materials: { "metal": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4) },
    bodies: [(name: "square", material: "metal", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
    supports: [
        (name: "left", region: Plane(axis: X, at: 0), fix: [X, Y]),
        (name: "pulled", region: Plane(axis: X, at: 2), follow_mesh: [X]),
    ],
    schedule: (steps: 4, cuts: 0),
    tolerance: (iterations: 3),
)"#;

#[test]
fn a_run_that_cannot_finish_keeps_what_it_has() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("fast.ron"), TOO_FAST).unwrap();
    let output = mpm(directory.path(), &["run", "fast.ron", "--quiet"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(output.stdout.is_empty());
    for part in
        ["load step 3", "load fraction 0.5 to 0.75", "no equilibrium after 3 Newton iterations", "fast.h5"]
    {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let results = Results::open(directory.path().join("fast.h5")).unwrap();
    assert!(results.status().starts_with("failed: load step 3"), "{}", results.status());
    assert_eq!(results.rows(), 3);
    assert_eq!(results.column("load_fraction").unwrap().values(), [0.0, 0.25, 0.5]);
    assert_eq!(results.fractions(), [0.0, 0.25, 0.5]);
    assert_eq!(results.points(2).unwrap().len(), 16);
}

#[test]
fn threads_change_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let scene = shipped("simple_stretch_rollers.ron");
    let [one, two] = ["1", "2"].map(|threads| {
        let name = format!("{threads}.h5");
        let output = mpm(directory.path(), &["run", &scene, "-q", "--threads", threads, "-o", &name]);
        assert_eq!(output.status.code(), Some(0));
        Results::open(directory.path().join(name)).unwrap()
    });
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(one.columns(), two.columns());
    for column in one.columns().iter().filter(|column| column.name != "wall_seconds") {
        let [a, b] = [&one, &two].map(|results| bits(results.column(&column.name).unwrap().values()));
        assert_eq!(a, b, "{}", column.name);
    }
    let last = one.fractions().len() - 1;
    for field in one.fields().unwrap() {
        let [a, b] = [&one, &two].map(|results| bits(results.field(&field, last).unwrap().values()));
        assert_eq!(a, b, "{field}");
    }
}

#[test]
fn the_reference_of_the_language_is_that_of_its_types() {
    let directory = tempfile::tempdir().unwrap();
    let output = mpm(directory.path(), &["schema", "--markdown"]);
    let generated = String::from_utf8(output.stdout).unwrap();
    let kept = std::fs::read_to_string(shipped("README.md")).unwrap();
    let differing = generated.lines().zip(kept.lines()).enumerate().find(|(_, (a, b))| a != b);
    let place = differing.map(|(line, (now, kept))| format!("line {}:\n  {kept}\nis now\n  {now}", line + 1));
    assert!(
        generated == kept,
        "scenes/README.md is not up to date; regenerate it by `mpm schema --markdown > scenes/README.md`\n{}",
        place.unwrap_or_else(|| "one ends before the other".into())
    );

    // Its example is a scene.
    let example = generated.split("```ron\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    std::fs::write(directory.path().join("example.ron"), example).unwrap();
    let output = mpm(directory.path(), &["run", "example.ron"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_schema_is_json() {
    let directory = tempfile::tempdir().unwrap();
    let output = mpm(directory.path(), &["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(schema["title"], "Scene");
    assert!(schema["$defs"]["RampInput"].is_object());
}

#[test]
fn files_of_drive_have_a_schema() {
    let directory = tempfile::tempdir().unwrap();
    let output = mpm(directory.path(), &["schema", "--drive"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(schema["title"], "Drive");
    assert!(schema["properties"]["path"].is_object() && schema["$defs"]["SegmentInput"].is_object());
    let output = mpm(directory.path(), &["schema", "--drive", "--markdown"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for part in ["## Drive", "`path`", "## SegmentInput", "**`Oedometer(…)`**", "## MaterialInput"] {
        assert!(text.contains(part), "{part} is not in:\n{text}");
    }
}

/// A block of rubber that a plate of the least stiffness presses.
const SOFT_TOOL: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 2), Uniform(from: 0, to: 2, cells: 4)]),
    basis: Cpdi1,
    materials: { "rubber": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "block", material: "rubber", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    tools: [(name: "plate", parts: [Plane(through: (0, 1), normal: (0, -1))], motion: Move(by: (0, -DEPTH)),
        interface: (stiffness: 1))],
    schedule: (steps: 8, cuts: 1),
)"#;

#[test]
fn a_tool_that_enters_a_body_is_told_of_or_ends_the_run() {
    let directory = tempfile::tempdir().unwrap();
    let run = |depth: &str| {
        let file = directory.path().join(format!("{depth}.ron"));
        std::fs::write(&file, SOFT_TOOL.replace("DEPTH", depth)).unwrap();
        mpm(directory.path(), &["run", "--quiet", &file.display().to_string(), "-o", &format!("{depth}.h5")])
    };
    let words = "warning: tool `plate` has entered a body by ";
    let (gentle, deep, through) = (run("0.01"), run("0.3"), run("0.9"));
    assert!(gentle.status.success() && gentle.stderr.is_empty(), "{}", String::from_utf8_lossy(&gentle.stderr));
    let said = String::from_utf8(deep.stderr).unwrap();
    assert!(deep.status.success() && said.lines().count() == 1 && said.starts_with(words), "{said}");
    let said = String::from_utf8(through.stderr).unwrap();
    assert!(said.contains("contribution `tool plate`: a body has entered it by 0.5"), "{said}");
    assert_eq!(
        Results::open(directory.path().join("0.9.h5")).unwrap().status().split(':').next(),
        Some("failed")
    );

    let told = |file: &str| String::from_utf8(mpm(directory.path(), &["inspect", file]).stdout).unwrap();
    assert!(told("0.3.h5").contains(&words["warning: ".len()..]) && !told("0.01.h5").contains("has entered"));
}

#[test]
fn what_is_probably_not_meant_is_told_before_the_run() {
    let directory = tempfile::tempdir().unwrap();
    let scene = shipped("laws/mohr_coulomb.ron");
    let settings = ["--set", "materials.soil.friction=0.5236", "--set", "materials.soil.dilation=0"];
    let run = |more: &[&str]| {
        let arguments = [&["run", &scene, "--force"], &settings[..], more].concat();
        String::from_utf8(mpm(directory.path(), &arguments).stderr).unwrap()
    };
    let said = run(&[]);
    let words = "is 0.5236 degrees; if it is meant in radians, it is 30 degrees";
    assert!(
        said.starts_with("warning: the angle of friction of material `soil`") && said.contains(words),
        "{said}"
    );
    assert_eq!(said.lines().filter(|line| line.starts_with("warning: the angle")).count(), 1, "{said}");
    assert!(!run(&["--quiet"]).contains("degrees"));
    // Where it is the reason why the scene is refused.
    let ground = shipped("soil/at_rest.ron");
    let settings =
        ["--set", "materials.mohr_coulomb.friction=0.5236", "--set", "materials.mohr_coulomb.dilation=0"];
    let output = mpm(directory.path(), &[&["run", "--quiet", &ground], &settings[..]].concat());
    let said = common::flat(&String::from_utf8(output.stderr).unwrap());
    assert!(output.status.code() == Some(2) && said.contains("it is 30 degrees"), "{said}");
}

#[test]
fn supports_that_agree_may_share_nodes() {
    let directory = tempfile::tempdir().unwrap();
    let scene = std::fs::read_to_string(shipped("simple_stretch.ron")).unwrap();
    let check = |support: &str| {
        let more = format!("follow_mesh: [X]),\n        (name: \"again\", {support}),");
        std::fs::write(directory.path().join("scene.ron"), scene.replace("follow_mesh: [X]),", &more)).unwrap();
        let output = mpm(directory.path(), &["check", "scene.ron", "--threads", "1"]);
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let right = "region: Plane(axis: X, at: 2), displace: [(axis: X, by: ";
    assert_eq!(check(&format!("{right}4)]")), (Some(0), String::new()), "as the mesh moves");
    assert_eq!(
        check("region: Plane(axis: X, at: 0), follow_mesh: [X]"),
        (Some(0), String::new()),
        "which rests"
    );
    for other in ["3.999)]", "4, ramp: [(0, 0), (0.5, 0.6), (1, 1)])]"] {
        let (code, said) = check(&format!("{right}{other}"));
        assert!(code == Some(2) && said.contains("prescribe different displacements along x"), "{said}");
    }
}
