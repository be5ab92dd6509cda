//! The same bits on any number of threads; alone in its file, for it takes all of the machine.

use mpm_validation::{Check, Extent, case};

#[test]
fn threads_change_nothing() {
    let case = case("determinism").expect("the case exists");
    let checks = (case.run)(Extent::Tests).unwrap_or_else(|broken| panic!("{broken}")).checks;
    let failed: Vec<&Check> = checks.iter().filter(|check| !check.passes()).collect();
    assert!(checks.len() > 3 && failed.is_empty(), "{failed:#?}");
}
