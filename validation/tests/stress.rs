//! A small part of every stress test; and STRESS.md tells of each.

use mpm_validation::{Check, Extent, STRESS};

const REPORT: &str = include_str!("../STRESS.md");

#[test]
fn nothing_breaks() {
    for case in STRESS {
        let checks =
            (case.run)(Extent::Tests).unwrap_or_else(|broken| panic!("{}: {broken}", case.name)).checks;
        assert!(!checks.is_empty(), "{} compares nothing", case.name);
        let failed: Vec<&Check> = checks.iter().filter(|check| !check.passes()).collect();
        assert!(failed.is_empty(), "{}: {failed:#?}", case.name);
        assert!(REPORT.contains(&format!("## {}\n", case.name)), "the report does not tell of {}", case.name);
    }
}
