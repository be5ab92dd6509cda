//! Binds PETSc's C interface: the PETSc that pkg-config finds, with the MPI of `mpicc`.

use std::env;
use std::path::PathBuf;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    for name in ["PETSC_DIR", "PKG_CONFIG_PATH"] {
        println!("cargo:rerun-if-env-changed={name}");
    }
    let petsc = pkg_config::Config::new().atleast_version("3.18").probe("PETSc");
    let petsc = petsc.unwrap_or_else(|error| {
        panic!("PETSc 3.18 or later is needed (Debian: apt-get install libpetsc-real-dev): {error}")
    });
    // Clusters keep PETSc where the loader does not look.
    for folder in &petsc.link_paths {
        println!("cargo:rustc-link-arg=-Wl,-rpath,{}", folder.display());
    }
    let mut builder = bindgen::Builder::default()
        .header_contents("petsc.h", "#include <petscksp.h>")
        .allowlist_function("(Mat|Vec|IS|KSP|PC|Petsc)[A-Z].*")
        .allowlist_var("(PETSC|MAT|KSP|PC)_?[A-Z_]*")
        .prepend_enum_name(false)
        .layout_tests(false)
        .generate_comments(false);
    let folders = petsc.include_paths.iter().map(|it| it.display().to_string()).chain(mpi_folders());
    for folder in folders {
        builder = builder.clang_arg(format!("-I{folder}"));
    }
    let bindings = builder.generate().expect("the headers of PETSc are C");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("petsc.rs");
    bindings.write_to_file(out).expect("cargo's folder is writable");
}

/// Folders of the headers of MPI: OpenMPI tells them alone, MPICH among the arguments of its compiler.
fn mpi_folders() -> Vec<String> {
    let ask = |argument: &str| {
        let told = Command::new("mpicc").arg(argument).output().ok().filter(|it| it.status.success());
        told.map(|it| String::from_utf8_lossy(&it.stdout).into_owned())
    };
    if let Some(folders) = ask("--showme:incdirs") {
        return folders.split_whitespace().map(String::from).collect();
    }
    let command = ask("-compile_info").expect("mpicc is needed (Debian: apt-get install libopenmpi-dev)");
    command.split_whitespace().filter_map(|it| it.strip_prefix("-I")).map(String::from).collect()
}
