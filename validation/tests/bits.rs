//! The program that compares two builds of `mpm`, applied to one build twice.

use std::path::Path;
use std::process::{Command, Output};

fn bits(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bits")).args(arguments).output().expect("the program starts")
}

/// `mpm` is a program of another package: it lies beside this one where the workspace's tests are built.
#[test]
fn a_program_writes_the_same_results_twice() {
    let mpm = Path::new(env!("CARGO_BIN_EXE_bits")).with_file_name("mpm");
    if !mpm.exists() {
        eprintln!("not run: {} is not built", mpm.display());
        return;
    }
    let mpm = mpm.to_str().expect("the path is UTF-8");
    let output = bits(&[mpm, mpm, "simple_stretch", "corner_stretch_kite", "points", "collapse, resumed"]);
    let said = String::from_utf8(output.stdout).expect("output is UTF-8");
    assert_eq!(output.status.code(), Some(0), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("All 5 runs are equal, bit for bit."), "{said}");
    for row in ["| corner_stretch_kite | completed | 40 |", "| collapse, resumed after 25 | completed | 40 |"] {
        assert!(said.contains(row), "{said}");
    }
}

#[test]
fn arguments_are_checked() {
    let here = env!("CARGO_BIN_EXE_bits");
    for arguments in [&[][..], &[here], &[here, "no such program"], &[here, here, "no such scene"]] {
        let output = bits(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty());
    }
}
