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

/// Pages whose commands are run, in this order, in one folder.
const PAGES: [&str; 9] = [
    "first_run.md",
    "bodies.md",
    "pushing.md",
    "stages.md",
    "running.md",
    "pictures.md",
    "results.md",
    "recipes.md",
    "laws/driver.md",
];

/// What a page's blocks hold: files by their names, and the lines of shell that call `mpm`. The validation is another
/// program, which only a whole build has.
fn files_and_commands(page: &str) -> (Vec<(String, String)>, Vec<String>) {
    let (mut files, mut commands) = (Vec::new(), Vec::new());
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(info) = line.strip_prefix("```") else { continue };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        match info.split_once(' ') {
            Some((_, name)) => files.push((name.to_owned(), block.join("\n") + "\n")),
            None if info == "sh" => {
                let called =
                    block.iter().filter(|line| line.starts_with("mpm ") && !line.starts_with("mpm validate"));
                commands.extend(called.map(|line| line.to_string()));
            }
            None => {}
        }
    }
    (files, commands)
}

#[test]
fn the_commands_of_the_guide_work_and_python_reads_what_they_write() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let programs = Path::new(env!("CARGO_BIN_EXE_mpm")).parent().expect("the program lies in a folder");
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    let mut count = 0;
    for name in PAGES {
        let page = std::fs::read_to_string(guide("src").join(name)).expect("the guide has this page");
        let (files, commands) = files_and_commands(&page);
        for (file, text) in files {
            std::fs::write(directory.path().join(file), text).expect("a file can be written");
        }
        for line in &commands {
            let mut shell = Command::new("sh");
            let shell = shell.args(["-c", line]).env("PATH", &path).env("RAYON_NUM_THREADS", "1");
            succeeds(line, shell.current_dir(directory.path()).output().expect("there is a shell"));
        }
        count += commands.len();
    }
    assert!(count > 25, "{count} commands");
    let written = [
        "stretch.ron",
        "stretch.h5",
        "stretch.png",
        "stretch_csv",
        "coarse.h5",
        "pile.svg",
        "corner.png",
        "hollow.h5",
        "staged.png",
        "short.h5",
        "energy.png",
        "pile_csv",
        "kept.h5",
        "sweep/results.csv",
        "refined/results.csv",
        "cell.csv",
        "cell.svg",
        "stretch_vtu.pvd",
    ];
    for file in written {
        assert!(directory.path().join(file).exists(), "{file} is missing");
    }
    let rows =
        std::fs::read_to_string(directory.path().join("sweep/results.csv")).expect("a table").lines().count();
    assert_eq!(rows, 1 + 6);

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
    let mut steps = Command::new(&python);
    steps.arg(guide("examples/mpm_results.py")).arg("stretch.h5").current_dir(directory.path());
    let said = succeeds(&python, steps.output().expect("the interpreter starts"));
    assert!(said.contains("step 40 at load fraction 1: 16 points, mean position ["), "{said}");

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

/// Markdown files of a folder and of the folders in it.
fn documents(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("a readable directory").path();
        match path.is_dir() {
            true => found.extend(documents(&path)),
            false if path.extension().is_some_and(|it| it == "md") => found.push(path),
            false => {}
        }
    }
    found
}

/// Every page of the guide is in its summary.
#[test]
fn the_summary_lists_every_page() {
    let summary = std::fs::read_to_string(guide("src/SUMMARY.md")).expect("the guide has a summary");
    for page in documents(&guide("src")) {
        let name =
            page.strip_prefix(guide("src")).expect("it is below").to_str().expect("pages have plain names");
        assert!(name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name} is not in the summary");
    }
}

/// Every file that a document links to exists.
#[test]
fn links_lead_somewhere() {
    let root = guide("../..");
    let mut pages = documents(&root.join("docs"));
    pages.extend(documents(&root.join("validation/cases")));
    let others =
        ["README.md", "ARCHITECTURE.md", "scenes/README.md", "benchmarks/README.md", "validation/README.md"];
    pages.extend(others.map(|file| root.join(file)));
    assert!(pages.len() > 70, "{} documents", pages.len());
    for page in pages {
        let text = std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if !target.starts_with("http") && !target.starts_with('#') {
                let file = page.with_file_name("").join(target.split('#').next().unwrap_or(target));
                assert!(file.exists(), "{} links to {target}", page.display());
            }
        }
    }
}

/// The book for browsers has every page of the guide, the reference, and the pictures; mdBook itself is not run.
#[test]
fn the_book_is_put_together() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let python = std::env::var("MPM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/book.py");
    let mut book = Command::new(&python);
    book.arg(script).arg(folder.path().join("book"));
    succeeds(&python, book.output().expect("the interpreter starts; MPM_PYTHON names it"));
    let source = folder.path().join("book/src");
    let summary = std::fs::read_to_string(source.join("SUMMARY.md")).expect("a summary");
    let pages: Vec<&str> = summary.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert!(pages.len() > 30 && pages.contains(&"reference.md"), "{pages:?}");
    for page in pages {
        let text = std::fs::read_to_string(source.join(page)).expect(page);
        assert!(!text.contains("](../../../") && !text.contains("](../../pictures"), "{page}");
    }
    assert!(source.join("pictures/plough.png").exists());
}
