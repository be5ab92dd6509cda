//! Puts the package together from the extension module of this build, and runs its tests in Python.
//!
//! `scripts/wheel.sh --test` does the same with an installed wheel.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The interpreter named by `MPM_PYTHON`, else `python3`, if it has what the tests need.
fn python() -> String {
    let python = std::env::var("MPM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let probe = Command::new(&python).args(["-c", "import numpy, pandas, pytest"]).output();
    let ready = probe.as_ref().is_ok_and(|probe| probe.status.success());
    assert!(
        ready,
        "{python} cannot import numpy, pandas and pytest ({probe:?}).\nInstall them (pip install numpy pandas pytest), or name an \
         interpreter that has them: MPM_PYTHON=/path/to/venv/bin/python"
    );
    python
}

#[test]
fn the_package_passes_its_tests() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let test = std::env::current_exe().expect("this test is a file");
    let built = test.parent().expect("it lies in a folder");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let package = folder.path().join("implicit_mpm");
    fs::create_dir(&package).expect("the folder can be written to");
    for entry in fs::read_dir(here.join("python/implicit_mpm")).expect("the package is there") {
        let file = entry.expect("a readable folder").path();
        if file.is_file() && file.extension().is_none_or(|it| it != "so") {
            fs::copy(&file, package.join(file.file_name().expect("a file"))).expect("the file can be copied");
        }
    }
    let module = built.join(format!("{DLL_PREFIX}mpm_python{DLL_SUFFIX}"));
    fs::copy(&module, package.join("_native.abi3.so")).expect("the module is built before its tests");

    let mut pytest = Command::new(python());
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=5"]).arg(here.join("tests"));
    pytest.current_dir(folder.path()).env("PYTHONPATH", folder.path()).env("PYTHONDONTWRITEBYTECODE", "1");
    // The program of the same build, if all of the workspace is tested.
    let program = built.parent().map(|it| it.join("mpm")).filter(|it| it.is_file());
    pytest.envs(program.map(|program| ("MPM_PROGRAM", program)));
    let output = pytest.output().expect("the interpreter starts");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}
