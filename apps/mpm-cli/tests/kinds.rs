//! Files that people have, and what once was answered wrongly about them: `validation/scenes/faults`.

mod common;

use common::{complains, flat, mpm, says, workspace};
use mpm_io::Results;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A folder with these files of `validation/scenes/faults`.
fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        fs::copy(workspace("validation/scenes/faults").join(name), folder.path().join(name)).unwrap();
    }
    folder
}

/// Mean volume of the points times their number, as the first row of a run says it.
fn volume(folder: &Path, scene: &str) -> f64 {
    let arguments = ["run", scene, "-q", "--force", "-o", "v.h5", "--set", "output.fields=[Volume]"];
    let output = mpm(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    Results::open(folder.join("v.h5")).unwrap().field("volume", 0).unwrap().values().iter().sum()
}

#[test]
fn every_solid_of_a_text_is_filled_and_a_cavity_stays_empty() {
    let folder = folder(&["two_solids.ron", "two_solids.stl"]);
    assert!((volume(folder.path(), "two_solids.ron") - 2.0).abs() < 1e-12);

    // A cube of 4 with one of 1 inside whose facets face the other way.
    let text = fs::read_to_string(folder.path().join("two_solids.stl")).unwrap();
    let first = &text[..text.find("endsolid").unwrap()];
    let first = format!("{first}endsolid\n");
    let large: String = first
        .lines()
        .map(|line| match line.trim().strip_prefix("vertex ") {
            Some(numbers) => {
                let moved =
                    numbers.split_whitespace().map(|x| (4.0 * x.parse::<f64>().unwrap() - 1.0).to_string());
                format!("vertex {}\n", moved.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    let mut lines: Vec<&str> = first.lines().collect();
    let vertices: Vec<usize> = (0..lines.len()).filter(|&k| lines[k].trim().starts_with("vertex")).collect();
    vertices.chunks(3).for_each(|facet| lines.swap(facet[0], facet[1]));
    fs::write(folder.path().join("two_solids.stl"), large + &lines.join("\n")).unwrap();
    let scene = fs::read_to_string(folder.path().join("two_solids.ron")).unwrap();
    let larger = scene.replace("to: 2, cells: 6", "to: 4, cells: 10");
    fs::write(folder.path().join("two_solids.ron"), larger).unwrap();
    assert!((volume(folder.path(), "two_solids.ron") - 63.0).abs() < 1e-9);
}

#[test]
fn text_in_capitals_marks_and_loose_ends_are_read() {
    let folder = folder(&["capitals.ron", "capitals.stl"]);
    let text = fs::read_to_string(folder.path().join("capitals.stl")).unwrap();
    let end = text.rfind("ENDSOLID").unwrap();
    let shaken = text.replacen("VERTEX 2 2 2", "VERTEX 2.00000004 1.99999996 2", 3).replacen(
        "VERTEX -2 -2 -2",
        "VERTEX -2 -2.00000002 -2",
        2,
    );
    // A facet without area in a corner that is there.
    let flat = text.replacen(
        "ENDSOLID",
        "FACET NORMAL 0 0 0 OUTER LOOP VERTEX 2 2 2 VERTEX 2 2 2 VERTEX -2 2 2 ENDLOOP ENDFACET\nENDSOLID",
        1,
    );
    for text in
        [text.clone(), format!("\u{feff}{text}"), format!("\n\t  {text}"), text[..end].into(), shaken, flat]
    {
        fs::write(folder.path().join("capitals.stl"), &text).unwrap();
        let found = volume(folder.path(), "capitals.ron");
        assert!((found - 64.0).abs() < 1e-5, "{found}: {text}");
    }
    for (text, said) in [
        ("sold a\nendsolid", "15 bytes are no STL file"),
        ("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0,5\n", "line 4: expected a finite number"),
        (
            &format!("STL {}", "x".repeat(100)),
            "read as binary STL, because STL text begins with `solid`: 104 bytes",
        ),
    ] {
        fs::write(folder.path().join("capitals.stl"), text).unwrap();
        let text = flat_complaint(folder.path(), "capitals.ron");
        assert!(text.contains(said) || said.starts_with("15"), "{said} in {text}");
    }
}

fn flat_complaint(folder: &Path, scene: &str) -> String {
    flat(&complains(folder, 2, &["check", scene]))
}

#[test]
fn tables_of_other_programs_are_read_or_the_message_says_what_they_lack() {
    let folder = folder(&["points_plotted.ron", "points_plotted.csv"]);
    let path = folder.path().join("points_plotted.csv");
    let text = fs::read_to_string(&path).unwrap();
    for text in [
        text.replace(',', ";"),
        text.replace(',', "\t"),
        text.replacen("x,y,volume", "X [m],Y [m],volume [m2]", 1),
    ] {
        fs::write(&path, &text).unwrap();
        let said = says(folder.path(), &["check", "points_plotted.ron"]);
        assert!(said.contains("material points   16") && !said.contains("note"), "{said}");
    }
    let numbered: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(k, line)| match k {
            0 => format!("id,{line}\n"),
            k => format!("{k},{line}\n"),
        })
        .collect();
    fs::write(&path, numbered.concat()).unwrap();
    let note = "points_plotted.csv: the column `id` is not read";
    assert!(says(folder.path(), &["check", "points_plotted.ron"]).contains(note));
    let json: Value =
        serde_json::from_str(&says(folder.path(), &["check", "points_plotted.ron", "--json"])).unwrap();
    assert_eq!(json["notes"], serde_json::json!([note]));
    let run = mpm(folder.path(), &["run", "points_plotted.ron"]);
    assert_eq!(String::from_utf8_lossy(&run.stderr), format!("note: {note}\n"));
    for (text, said) in [
        (text.replace(',', "|"), "unknown column `x|y|volume` (columns parted by commas)"),
        (text.replacen("x,y,volume", "x [mm],y [m],volume", 1), "different units, which are not converted"),
        (
            text.replacen("x,y,volume", "x [mm],y [mm],volume [m2]", 1),
            "has another unit than the square of `x [mm]`, and units are not converted",
        ),
        (text.replace(',', ";").replace("0.25;0.75", "0,25;0.75"), "expected a number, got `0,25` (decimals"),
    ] {
        fs::write(&path, text).unwrap();
        let text = flat_complaint(folder.path(), "points_plotted.ron");
        assert!(text.contains(said), "{said} in {text}");
    }
}

#[test]
fn results_whose_scene_names_files_are_drawn_without_a_field_too() {
    let folder = folder(&["points_plotted.ron", "points_plotted.csv"]);
    says(folder.path(), &["run", "points_plotted.ron", "-q"]);
    // The files may have gone.
    fs::remove_file(folder.path().join("points_plotted.csv")).unwrap();
    says(folder.path(), &["plot", "points_plotted.h5", "-o", "a.svg"]);
    let svg = fs::read_to_string(folder.path().join("a.svg")).unwrap();
    let marks_of_curves = svg.matches("r=\"3\"").count();
    assert_eq!(svg.matches("<circle").count() - marks_of_curves, 16, "a disc for each point");
    assert!(svg.contains("Reactions"), "and the reactions");
    let text = flat(&complains(folder.path(), 2, &["plot", "points_plotted.h5", "--field", "rho"]));
    assert!(text.contains("no field `rho` is recorded; there are"), "{text}");
}

#[test]
fn a_corner_of_a_domain_is_not_called_its_point() {
    let folder = folder(&["domain_corner.ron", "domain_corner.csv"]);
    let text = flat_complaint(folder.path(), "domain_corner.ron");
    let expected =
        "material point 0 at (1, 1): a corner of its domain: (0.5, -3) lies 3 cells outside the mesh";
    assert!(text.contains(expected), "{text}");
}

#[test]
fn rows_of_many_small_steps_are_all_there() {
    let folder = folder(&["many_steps.ron"]);
    let run = ["run", "many_steps.ron", "--json", "--set", "schedule.steps=4000"];
    let said: Value = serde_json::from_str(&says(folder.path(), &run)).unwrap();
    assert_eq!(said["rows"], 4001);
    let results = Results::open(folder.path().join("many_steps.h5")).unwrap();
    assert_eq!(results.rows(), 4001);
}

#[test]
fn what_nothing_holds_and_what_no_stabilisation_reaches_is_told_before_the_run() {
    let folder = folder(&["unheld_on_rollers.ron", "not_stabilised.ron", "soft_on_stiff.ron"]);
    let notes = |arguments: &[&str]| flat(&says(folder.path(), &[&["check"], arguments].concat()));
    let told = notes(&["unheld_on_rollers.ron"]);
    assert!(told.contains("nothing holds body `b` along x: the run will end in its first load step"), "{told}");
    let told = notes(&["unheld_on_rollers.ron", "--set", "unheld_motion=Zero"]);
    assert!(told.contains("along x: which is kept at zero if no load acts along it"), "{told}");
    let told = notes(&["not_stabilised.ron"]);
    assert!(told.contains("the remedy is `stabilisation: Ghost()`"), "{told}");
    assert!(!notes(&["not_stabilised.ron", "--set", "stabilisation=Ghost()"]).contains("Ghost()"));
}

#[test]
fn a_base_that_is_a_million_million_times_as_stiff_takes_what_the_top_gives() {
    let folder = folder(&["soft_on_stiff.ron"]);
    let output = mpm(folder.path(), &["run", "soft_on_stiff.ron", "-q", "-o", "s.h5"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let results = Results::open(folder.path().join("s.h5")).unwrap();
    let last = |name: &str| results.column(name).unwrap().values().last().copied().unwrap();
    let (top, base) = (last("reaction/top"), last("reaction/base"));
    assert!(
        (top + base).abs() < 1e-12 && (base - 1.0151854).abs() < 1e-6,
        "{top} at the top, {base} at the base"
    );
    assert!(last("residual") < 1e-9);
}
