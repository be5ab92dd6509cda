//! A small part of what `fuzz` runs, and that it would see what it looks for.

use mpm_validation::fuzz::{Plan, Target, fuzz, here};

#[test]
fn hostile_scenes_are_refused_or_run() {
    let [unreadable, refused, accepted, run] = here(Target::Scenes, 20, 0..3000).unwrap();
    // The changes are such that all depths are reached.
    assert!(
        unreadable > 300 && refused > 300 && accepted > 300 && run > 100,
        "{unreadable} {refused} {accepted} {run}"
    );
}

#[test]
fn hostile_surfaces_and_tables_are_refused_or_run() {
    // Those of HDF5, which may crash, are for processes of their own.
    let text = (0..600).filter(|case| case % 8 < 6);
    let mut depths = [0; 4];
    for case in text {
        let found = here(Target::Bodies, 20, case..case + 1).unwrap();
        depths.iter_mut().zip(found).for_each(|(all, more)| *all += more);
    }
    let [unreadable, refused, _, run] = depths;
    assert!(unreadable > 50 && refused > 20 && run > 50, "{depths:?}");
}

#[test]
fn what_fuzzing_looks_for_is_seen() {
    let keep = tempfile::tempdir().unwrap();
    let plan =
        Plan { target: Target::Traps, seed: 1, cases: 50, processes: 2, keep: keep.path().join("findings") };
    let report = fuzz(&plan, env!("CARGO_BIN_EXE_fuzz").as_ref()).unwrap();
    let text = report.to_string();
    assert_eq!(report.findings.iter().map(|it| it.0).collect::<Vec<_>>(), [10, 20, 30, 40], "{text}");
    let seen = ["panic", "too much memory", "takes longer", "ends the process"];
    for ((_, what), seen) in report.findings.iter().zip(seen) {
        assert!(what.contains(seen), "{text}");
    }
    assert_eq!((report.executions(), std::fs::read_dir(&plan.keep).unwrap().count()), (50, 4), "{text}");
}
