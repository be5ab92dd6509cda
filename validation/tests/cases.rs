//! Every case of the validation but the long one, see `determinism.rs`; and the README tells of each.

use mpm_validation::{CASES, Check, case};

const README: &str = include_str!("../README.md");

fn passes(name: &str) {
    let case = case(name).unwrap_or_else(|| panic!("there is no case `{name}`"));
    let checks = (case.run)().unwrap_or_else(|broken| panic!("{name}: {broken}"));
    assert!(!checks.is_empty(), "{name} compares nothing");
    let failed: Vec<&Check> = checks.iter().filter(|check| !check.passes()).collect();
    assert!(failed.is_empty(), "{name}: {failed:#?}");
    for check in &checks {
        let row = format!("| {} | ", check.what);
        let tolerance = format!(" | {:.0e} |", check.tolerance);
        let told = README.lines().any(|line| line.starts_with(&row) && line.contains(&tolerance));
        assert!(told, "the README has no row `{row}…{tolerance}` for {name}");
    }
}

#[test]
fn simple_stretch_with_free_sides() {
    passes("simple stretch, sides free");
}

#[test]
fn simple_stretch_on_rollers() {
    passes("simple stretch, rollers");
}

#[test]
fn newton_rate() {
    passes("Newton's rate");
}

#[test]
fn tangent() {
    passes("tangent");
}

#[test]
fn rigid_rotation() {
    passes("rigid rotation");
}

#[test]
fn patch_test() {
    passes("patch test");
}

#[test]
fn a_load_step_that_cannot_be_solved() {
    passes("a load step that cannot be solved");
}

#[test]
fn step_control() {
    passes("step control");
}

#[test]
fn domain_control() {
    passes("domains under large shear");
}

#[test]
fn every_case_has_a_test() {
    let tests = [include_str!("cases.rs"), include_str!("determinism.rs")];
    for case in CASES {
        let call = format!("(\"{}\")", case.name);
        assert!(tests.iter().any(|text| text.contains(&call)), "no test runs `{}`", case.name);
    }
}

#[test]
fn the_readme_tells_of_every_case() {
    for case in CASES {
        for text in [&format!("## {}", case.name), case.goal, case.setup, case.reference] {
            assert!(README.contains(text), "the README lacks of `{}`: {text}", case.name);
        }
    }
}
