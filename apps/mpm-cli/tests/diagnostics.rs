//! Everything that can be wrong with an input is told once, where it stands, with exit code 2.

use std::path::Path;
use std::process::{Command, Output};

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
    motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 1)]),
    basis: Smpm,
    materials: {
        "soft": Hencky(young: 1e3, poisson: 0.3),
    },
    bodies: [
        (name: "block", material: "soft", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2),
    ],
    supports: [
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "bottom", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: "pulled", region: Plane(axis: X, at: 2), follow_mesh: [X]),
    ],
    loads: [
        Traction(body: "block", axis: Y, at: 2, resultant: (0, -1)),
        PointForce(body: "block", near: (2, 2), force: (0, 1)),
    ],
    schedule: (steps: 4),
)
"#;

fn mpm(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mpm"))
        .args(arguments)
        .current_dir(directory)
        .output()
        .expect("the program starts")
}

/// Exit code 2 and one message, in plain text, on standard error alone.
#[track_caller]
fn complaint(case: &str, output: &Output) -> String {
    let text = String::from_utf8(output.stderr.clone()).expect("messages are UTF-8");
    assert_eq!(output.status.code(), Some(2), "{case}: {text}");
    assert!(output.stdout.is_empty(), "{case} prints to standard output");
    assert_eq!(text.matches("  x ").count(), 1, "{case}: {text}");
    for noise in ["\u{1b}", "panicked", "backtrace", "Error("] {
        assert!(!text.contains(noise), "{case}: {text}");
    }
    text
}

/// What is wrong, what replaces what in the scene, line and column of the caret, parts of the message.
type Case = (&'static str, &'static str, &'static str, &'static str, &'static [&'static str]);

const UNREADABLE: &[Case] = &[
    (
        "unknown field",
        "young:",
        "yung:",
        "6:24",
        &["unknown field `yung` of `Hencky`", "`young`, `poisson` or `density`"],
    ),
    ("unknown variant", "Hencky", "Henky", "6:17", &["unknown name `Henky`", "`Hencky`"]),
    ("unknown basis", "Smpm", "Fem", "4:12", &["unknown name `Fem`", "`Smpm`"]),
    ("unknown space", "PlaneStrain", "Plane", "1:1", &["unknown name `Plane`", "`PlaneStrain` or `Solid`"]),
    ("missing field", "young: 1e3, ", "", "6:36", &["missing field `young` of `Hencky`"]),
    ("missing part", "    basis: Smpm,\n", "", "20:1", &["missing field `basis`"]),
    ("field twice", "steps: 4", "steps: 4, steps: 5", "20:26", &["`steps`", "given twice"]),
    ("text for a number", "young: 1e3", "young: \"soft\"", "6:31", &["expected a number, got `\"soft\"`"]),
    (
        "word for a number",
        "at: 0), fix: [X]",
        "at: left), fix: [X]",
        "12:51",
        &["expected a number, got `left`"],
    ),
    ("number for text", "name: \"left\"", "name: 7", "12:16", &["expected text in double quotes, got `7`"]),
    ("no list", "fix: [X]", "fix: X", "12:60", &["expected a list in brackets", "got `X`"]),
    ("no map", "materials: {", "materials: (", "5:16", &["expected named entries in braces", "got `(`"]),
    ("missing comma", "basis: Smpm,", "basis: Smpm", "5:5", &["expected `,`", "got `materials`"]),
    ("missing colon", "young: 1e3", "young 1e3", "6:30", &["expected `:`, got `1e3`"]),
    ("unclosed text", "\"left\"", "\"left", "13:17", &["expected `,`", "got `bottom`"]),
    ("unclosed comment", "(steps: 4)", "(steps: 4) /*", "20:26", &["comment is not closed"]),
    (
        "unclosed scene",
        "(steps: 4),\n)",
        "(steps: 4)",
        "21:1",
        &["`,` or a closing bracket", "end of the text"],
    ),
    ("text behind the scene", "\n)\n", "\n) more\n", "21:3", &["expected the end of the scene, got `more`"]),
    ("negative modulus", "1e3", "-1e3", "6:31", &["expected a finite number above 0, got -1000"]),
    ("signed position", "near: (2, 2)", "near: (2, -inf)", "18:45", &["expected a finite number, got -inf"]),
    ("Poisson's ratio of 1/2", "0.3", "0.5", "6:45", &["above -1 and below 0.5, got 0.5"]),
    ("no number", "0.3", "NaN", "6:45", &["got NaN"]),
    ("steps 0", "steps: 4", "steps: 0", "20:23", &["expected a whole number from 1 to 4294967295, got 0"]),
    ("steps with a point", "steps: 4", "steps: 4.5", "20:23", &["expected a whole number, got `4.5`"]),
    ("steps with an exponent", "steps: 4", "steps: 1e3", "20:23", &["expected a whole number, got `1e3`"]),
    ("cuts beyond a byte", "steps: 4", "steps: 4, cuts: 300", "20:32", &["`300` is out of range"]),
    ("too many coordinates", "from: (0, 0)", "from: (0, 0, 0)", "9:68", &["expected 2 numbers", "got 3"]),
    ("too few coordinates", "from: (0, 0)", "from: (0)", "9:62", &["expected 2 numbers", "got 1"]),
    ("list for coordinates", "from: (0, 0)", "from: [0, 0]", "9:60", &["expected `( … )`, got `[`"]),
    (
        "load fraction above 1",
        "displacement: 1",
        "displacement: 1, ramp: [(0, 0), (2, 1)]",
        "3:87",
        &["load fraction from 0 to 1, got 2"],
    ),
    (
        "two materials of one name",
        "    },\n",
        "        \"soft\": Hencky(young: 1, poisson: 0),\n    },\n",
        "7:9",
        &["`soft` is given twice"],
    ),
    ("umlauts before it", "(name: \"left\"", "(name: \"größe\", nom: 1", "12:25", &["unknown field `nom`"]),
];

const INCOMPATIBLE: &[Case] = &[
    ("empty body", "from: (0, 0)", "from: (2, 0)", "9:50", &["box is empty"]),
    ("body outside the mesh", "to: (2, 2)", "to: (2, 5)", "9:50", &["outside the mesh", "from 0 to 4"]),
    (
        "overlapping bodies",
        "    ],\n    supports",
        "        (name: \"b\", material: \"soft\", shape: Box(from: (1, 1), to: (3, 3)), points_per_cell: 1),\n    ],\n    supports",
        "10:46",
        &["body `b` overlaps body `block`"],
    ),
    (
        "two bodies of one name",
        "    ],\n    supports",
        "        (name: \"block\", material: \"soft\", shape: Box(from: (2, 2), to: (3, 3)), points_per_cell: 1),\n    ],\n    supports",
        "10:16",
        &["a second body named `block`"],
    ),
    (
        "unknown material",
        "material: \"soft\"",
        "material: \"hard\"",
        "9:35",
        &["no material named `hard`", "soft"],
    ),
    (
        "unknown body",
        "PointForce(body: \"block\"",
        "PointForce(body: \"blok\"",
        "18:26",
        &["no body named `blok`", "block"],
    ),
    ("region without nodes", "at: 2), follow", "at: 2.5), follow", "14:34", &["holds no node"]),
    (
        "driven nodes without material",
        "at: 2), follow",
        "at: 4), follow",
        "14:34",
        &["support `pulled` drives nodes", "material"],
    ),
    ("two supports of one name", "\"bottom\"", "\"left\"", "13:16", &["name of its own", "`left`"]),
    ("name with a slash", "\"bottom\"", "\"a/b\"", "13:16", &["without `/`", "`a/b`"]),
    ("support that holds nothing", ", fix: [Y]", "", "13:9", &["expected `fix`, `displace` or `follow_mesh`"]),
    (
        "contradictory supports",
        "fix: [Y]",
        "fix: [Y], displace: [(axis: X, by: 1)]",
        "13:9",
        &["`left` and `bottom` prescribe different displacements"],
    ),
    (
        "Z in a plane's region",
        "Plane(axis: X, at: 0)",
        "Plane(axis: Z, at: 0)",
        "12:44",
        &["Z is not a direction", "2 dimensions"],
    ),
    ("Z held in the plane", "fix: [Y]", "fix: [Y, Z]", "13:9", &["Z is not a direction"]),
    ("Z stretched in the plane", "Stretch([(axis: X", "Stretch([(axis: Z", "3:29", &["Z is not a direction"]),
    ("one axis", "Uniform(from: 0, to: 4, cells: 4), ", "", "2:21", &["expected 2 axes", "got 1"]),
    (
        "axis that runs backwards",
        "Uniform(from: 0, to: 4, cells: 4),",
        "Uniform(from: 4, to: 0, cells: 4),",
        "2:22",
        &["4", "0"],
    ),
    (
        "ramp that does not increase",
        "displacement: 1",
        "displacement: 1, ramp: [(0, 0), (0.5, 1), (0.5, 2)]",
        "3:77",
        &["knots must increase strictly"],
    ),
    ("stretch through its anchor", "displacement: 1", "displacement: -2.5", "3:13", &["anchor"]),
    (
        "axis stretched twice",
        "displacement: 1)",
        "displacement: 1), (axis: X, anchor: 0, driven: 4, displacement: 1)",
        "3:72",
        &["X is stretched twice"],
    ),
    (
        "body force without density",
        "    loads: [",
        "    loads: [BodyForce(acceleration: (0, -9.81)), ",
        "6:17",
        &["a body force acts", "`density`"],
    ),
    (
        "traction on no boundary",
        "axis: Y, at: 2, resultant",
        "axis: Y, at: 1.7, resultant",
        "17:9",
        &["body `block` has no boundary"],
    ),
    (
        "more points than there are",
        "near: (2, 2)",
        "near: (2, 2), points: 17",
        "18:57",
        &["only 16 material points"],
    ),
    ("too many cuts", "steps: 4", "steps: 4, cuts: 41", "20:32", &["at most 40 halvings, got 41"]),
    (
        "no bodies",
        "        (name: \"block\", material: \"soft\", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2),\n",
        "",
        "8:13",
        &["expected at least one body"],
    ),
];

#[test]
fn what_is_wrong_is_reported_where_it_stands() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("scene.ron");
    let mut wrong = Vec::new();
    for (case, from, to, place, parts) in UNREADABLE.iter().chain(INCOMPATIBLE) {
        assert!(SCENE.contains(from), "{case}: nothing to replace");
        std::fs::write(&file, SCENE.replacen(from, to, 1)).unwrap();
        let text = complaint(case, &mpm(directory.path(), &["check", "scene.ron"]));
        // A message can be longer than a line.
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if !text.contains(&format!("[scene.ron:{place}]")) || !parts.iter().all(|part| flat.contains(part)) {
            wrong.push(format!("{case}: expected {place} {parts:?}, got\n{text}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_scene_itself_is_right() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("scene.ron"), SCENE).unwrap();
    let output = mpm(directory.path(), &["check", "scene.ron"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for line in
        ["material points   16", "cells             16, 4 with material", "nodes             25, 9 active"]
    {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn the_caret_stands_under_the_culprit() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("scene.ron"), SCENE.replace("0.3", "0.7")).unwrap();
    let text = complaint("caret", &mpm(directory.path(), &["check", "scene.ron"]));
    let lines: Vec<&str> = text.lines().collect();
    let shown = lines.iter().position(|line| line.contains("poisson: 0.7")).expect("the line is shown");
    let column = lines[shown].find("0.7").unwrap();
    assert_eq!(lines[shown + 1].find('^'), Some(column), "{text}");
}

#[test]
fn files_and_arguments_are_checked_before_the_run() {
    let directory = tempfile::tempdir().unwrap();
    let inside = |name: &str| directory.path().join(name);
    std::fs::write(inside("scene.ron"), SCENE).unwrap();
    std::fs::write(inside("latin1.ron"), b"PlaneStrain(\n    title: \"gr\xf6\xdfe\",\n)").unwrap();
    std::fs::create_dir(inside("directory")).unwrap();
    // All of it a hole: it takes no space.
    std::fs::File::create(inside("endless.ron")).unwrap().set_len(1 << 40).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["run", "none.ron"], &["cannot read scene none.ron", "No such file"]),
        (&["run", "directory"], &["cannot read scene directory"]),
        (&["run", "endless.ron"], &["cannot read scene endless.ron", "longer than 64 MiB"]),
        (&["run", "latin1.ron"], &["not UTF-8", "[latin1.ron:2:15]"]),
        (&["run", "scene.ron", "--output", "directory"], &["cannot create results file directory"]),
        (&["run", "scene.ron", "-o", "none/run.h5"], &["cannot create results file none/run.h5"]),
        (&["run", "scene.ron", "-o", "run.xdmf"], &["run.xdmf", "another ending"]),
        (&["run", "scene.ron", "-o", "./scene.ron"], &["is the scene itself"]),
    ];
    for (arguments, parts) in cases {
        let text = complaint(&arguments.join(" "), &mpm(directory.path(), arguments));
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(parts.iter().all(|part| flat.contains(part)), "{arguments:?}: {text}");
    }
    assert_eq!(std::fs::read_to_string(inside("scene.ron")).unwrap(), SCENE);
    let arguments: &[&[&str]] =
        &[&["run"], &["run", "scene.ron", "--threads", "0"], &["walk"], &["check", "scene.ron", "--fast"]];
    for arguments in arguments {
        let output = mpm(directory.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
    }
}
