//! The report is one page that a browser shows whole.

use std::path::Path;
use std::process::{Command, Output};

fn validation(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mpm-validation"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

#[test]
fn the_report_tells_of_every_comparison() {
    let folder = tempfile::tempdir().unwrap();
    let output = validation(folder.path(), &["--quick", "--report", "r.html", "sides free", "Newton's rate"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{table}{}", String::from_utf8_lossy(&output.stderr));
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    for row in table.lines().skip(2) {
        let what = row.split('|').nth(2).unwrap().trim().replace('<', "&lt;");
        assert!(page.contains(&what.replace('`', "")), "{what}");
    }
    assert!(page.contains("All 2 cases pass.") && page.contains("coarse meshes only"));
    assert!(page.contains("name=\"viewport\""));
    // It needs nothing else: no script, and nothing from anywhere.
    for foreign in ["<script", "src=\"http", "href=\"http", "@import", "url("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    shown_without_complaint(folder.path(), "r.html");
}

#[test]
fn arguments_are_checked_before_anything_is_run() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["--report"][..],
        &["--fast"],
        &["no such case"],
        &["--report", "none/r.html", "kite"],
        &["--quick", "--pages", "v", "kite"],
    ] {
        let output = validation(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
    }
    let list = String::from_utf8(validation(folder.path(), &["--list"]).stdout).unwrap();
    assert!(list.lines().any(|line| line == "corner stretch, kite"), "{list}");
}

/// Opens a page in a browser, if there is one, on a screen as wide as a phone's.
fn shown_without_complaint(folder: &Path, file: &str) {
    let page = format!("file://{}", folder.join(file).display());
    let profile = format!("--user-data-dir={}", folder.join("profile").display());
    let arguments = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--enable-logging=stderr",
        "--window-size=390,844",
        &profile,
        "--screenshot=shot.png",
        &page,
    ];
    let Ok(output) = Command::new("chromium").args(arguments).current_dir(folder).output() else { return };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("CONSOLE"), "{said}");
    assert!(folder.join("shot.png").exists(), "{said}");
}
