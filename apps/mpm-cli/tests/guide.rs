//! What the guide tells people to do works: its first run, and its example in Python.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn guide(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide").join(file)
}

fn succeeds(name: &str, output: Output) -> String {
    let (said, erred) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{name}: {said}{erred}");
    said.into_owned()
}

/// The lines of a page's shell blocks that call `mpm`.
fn commands(page: &str) -> Vec<String> {
    let (mut inside, mut commands) = (false, Vec::new());
    for line in page.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside && line.starts_with("mpm ") {
            commands.push(line.to_owned());
        }
    }
    commands
}

#[test]
fn the_first_run_works_and_python_reads_it() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let page = std::fs::read_to_string(guide("src/first_run.md")).expect("the guide has this page");
    let commands = commands(&page);
    assert!(commands.len() > 8, "{commands:?}");
    for line in &commands {
        let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
        let mut mpm = Command::new(env!("CARGO_BIN_EXE_mpm"));
        let output = mpm.args(&arguments).current_dir(directory.path()).output().expect("the program starts");
        succeeds(line, output);
    }
    for file in ["stretch.ron", "stretch.h5", "stretch.png", "stretch_csv", "coarse.h5"] {
        assert!(directory.path().join(file).exists(), "{file} is missing");
    }

    // As in the tests of results: an interpreter with h5py and pyvista.
    let python = std::env::var("MPM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let mut read = Command::new(&python);
    read.arg(guide("examples/read.py")).arg("stretch.h5").current_dir(directory.path());
    let said = succeeds(&python, read.output().expect("the interpreter starts; MPM_PYTHON names it"));
    for part in
        ["status: completed", "reaction of pulled: at most 596.4109 0.0000", "after 40 load steps", "16 points"]
    {
        assert!(said.contains(part), "{part} in\n{said}");
    }
    let mut draw = Command::new(&python);
    draw.arg(guide("examples/picture.py")).args(["stretch.h5", "points.png"]).current_dir(directory.path());
    let said = succeeds(&python, draw.output().expect("the interpreter starts"));
    assert!(said.contains("16 points at load fraction 1"), "{said}");
    // Coloured, and larger than an empty picture.
    let picture = std::fs::metadata(directory.path().join("points.png")).expect("a picture").len();
    assert!(picture > 10_000, "{picture} bytes");
    for (example, most) in [("examples/read.py", 30), ("examples/picture.py", 25)] {
        let lines = std::fs::read_to_string(guide(example)).expect("the guide has this file");
        assert!(lines.lines().count() < most, "{example}");
    }
}

/// Every page is in the summary, and every file that a page links to exists.
#[test]
fn links_lead_somewhere() {
    let pages: Vec<PathBuf> = std::fs::read_dir(guide("src"))
        .expect("the guide has pages")
        .map(|entry| entry.expect("a readable directory").path())
        .collect();
    let summary = std::fs::read_to_string(guide("src/SUMMARY.md")).expect("the guide has a summary");
    for page in &pages {
        let name = page.file_name().and_then(|name| name.to_str()).expect("pages have plain names");
        assert!(name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name} is not in the summary");
        let text = std::fs::read_to_string(page).expect("a readable page");
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if !target.starts_with("http") {
                let file = guide("src").join(target.split('#').next().unwrap_or(target));
                assert!(file.exists(), "{name} links to {target}");
            }
        }
    }
}
