//! The dependency rules of the workspace, read off its manifests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Libraries and applications by package name: the names of what they depend on, and the lines that
/// say so. Dependencies of tests and of build scripts are apart.
struct Manifest {
    dependencies: BTreeMap<String, String>,
    dev_dependencies: BTreeMap<String, String>,
    build_dependencies: BTreeMap<String, String>,
}

/// The tables of dependencies that a manifest may have; a workspace's say which versions there are.
const TABLES: [&str; 4] =
    ["[dependencies]", "[dev-dependencies]", "[build-dependencies]", "[workspace.dependencies]"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The entries of a table: key and the rest of the line.
fn table(text: &str, header: &str) -> BTreeMap<String, String> {
    let lines = text.lines().map(str::trim).skip_while(|line| *line != header).skip(1);
    lines
        .take_while(|line| !line.starts_with('['))
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once('='))
        .map(|(key, value)| {
            let name = key.trim().split('.').next().expect("a split has a first part");
            (name.trim_matches('"').to_owned(), value.trim().to_owned())
        })
        .collect()
}

fn manifests() -> BTreeMap<String, Manifest> {
    let mut paths = vec![root().join("validation"), root().join("benchmarks"), root().join("examples")];
    for group in ["crates", "apps"] {
        let entries = fs::read_dir(root().join(group)).expect("the workspace has this directory");
        paths.extend(entries.map(|entry| entry.expect("a readable directory").path()));
    }
    let mut manifests = BTreeMap::new();
    for path in paths.into_iter().map(|path| path.join("Cargo.toml")).filter(|path| path.exists()) {
        let text = fs::read_to_string(&path).expect("a readable manifest");
        for line in
            text.lines().map(str::trim).filter(|line| line.starts_with('[') && line.contains("dependencies"))
        {
            assert!(TABLES.contains(&line), "{}: this test cannot read the table {line}", path.display());
        }
        let name = table(&text, "[package]")["name"].trim_matches('"').to_owned();
        let dependencies = table(&text, "[dependencies]");
        let dev_dependencies = table(&text, "[dev-dependencies]");
        let build_dependencies = table(&text, "[build-dependencies]");
        manifests.insert(name, Manifest { dependencies, dev_dependencies, build_dependencies });
    }
    manifests
}

/// Packages that depend on `dependency`, in their code, their tests or their build scripts.
fn users(dependency: &str) -> BTreeSet<String> {
    let uses = |it: &Manifest| {
        [&it.dependencies, &it.dev_dependencies, &it.build_dependencies]
            .iter()
            .any(|table| table.contains_key(dependency))
    };
    manifests().into_iter().filter(|(_, manifest)| uses(manifest)).map(|(name, _)| name).collect()
}

fn only(dependency: &str, allowed: &[&str]) {
    let users = users(dependency);
    let strangers: Vec<&String> = users.iter().filter(|name| !allowed.contains(&name.as_str())).collect();
    assert!(strangers.is_empty(), "{strangers:?} may not depend on {dependency}; only {allowed:?} may");
}

const APPLICATIONS: [&str; 6] =
    ["mpm-cli", "mpm-mpi", "mpm-python", "mpm-validation", "mpm-benchmarks", "mpm-examples"];

#[test]
fn the_manifests_are_read() {
    let manifests = manifests();
    for name in [
        "mpm-grid",
        "mpm-geometry",
        "mpm-contact",
        "mpm-basis",
        "mpm-material",
        "mpm-assembly",
        "mpm-solver",
        "mpm-io",
        "mpm-plot",
        "mpm-pictures",
    ] {
        assert!(manifests[name].dependencies.contains_key("thiserror"), "{name}");
    }
    assert!(APPLICATIONS.iter().all(|name| manifests[*name].dependencies.contains_key("mpm-solver")));
    assert!(users("faer").contains("mpm-linear") && users("hdf5").contains("mpm-io"));
}

#[test]
fn a_table_ends_where_the_next_begins() {
    let text = "[package]\nname = \"a\"\n[dependencies]\n# not = this\nx = \"1\"\ny.workspace = true\n[dev-dependencies]\nz = \"2\"";
    let names = |header| table(text, header).into_keys().collect::<Vec<_>>();
    assert_eq!(names("[dependencies]"), ["x", "y"]);
    assert_eq!(names("[dev-dependencies]"), ["z"]);
}

#[test]
fn workspace_crates_depend_downwards_only() {
    // From the ground up; each may use what it names, and what stands beside or above it may not be named.
    const ASSEMBLY: &[&str] = &["mpm-grid", "mpm-basis", "mpm-contact", "mpm-material", "mpm-linear"];
    const SOLVER: &[&str] =
        &["mpm-grid", "mpm-basis", "mpm-contact", "mpm-material", "mpm-linear", "mpm-assembly"];
    const SCENE: &[&str] = &[
        "mpm-grid",
        "mpm-basis",
        "mpm-geometry",
        "mpm-contact",
        "mpm-material",
        "mpm-linear",
        "mpm-assembly",
        "mpm-solver",
    ];
    const CLUSTER: &[&str] = &[
        "mpm-grid",
        "mpm-basis",
        "mpm-linear",
        "mpm-material",
        "mpm-assembly",
        "mpm-solver",
        // Only its tests.
        "mpm-scene",
    ];
    const IO: &[&str] = &["mpm-geometry", "mpm-linear", "mpm-solver", "mpm-scene"];
    let below: [(&str, &[&str]); 14] = [
        ("mpm-plot", &[]),
        ("mpm-grid", &[]),
        ("mpm-material", &[]),
        ("mpm-linear", &[]),
        ("mpm-basis", &["mpm-grid"]),
        ("mpm-geometry", &["mpm-grid"]),
        ("mpm-contact", &["mpm-grid"]),
        ("mpm-assembly", ASSEMBLY),
        ("mpm-solver", SOLVER),
        ("mpm-scene", SCENE),
        ("mpm-cluster", CLUSTER),
        ("mpm-petsc", &["mpm-cluster", "mpm-linear"]),
        ("mpm-io", IO),
        ("mpm-pictures", &["mpm-grid", "mpm-plot", "mpm-solver", "mpm-scene", "mpm-io"]),
    ];
    let manifests = manifests();
    for (name, allowed) in below {
        let manifest = &manifests[name];
        let all = manifest.dependencies.keys().chain(manifest.dev_dependencies.keys());
        for dependency in all.filter(|dependency| manifests.contains_key(*dependency)) {
            assert!(allowed.contains(&dependency.as_str()), "{name} may not depend on {dependency}");
        }
    }
    let libraries: Vec<&str> = below.iter().map(|(name, _)| *name).collect();
    for name in manifests.keys() {
        let known = libraries.contains(&name.as_str()) || APPLICATIONS.contains(&name.as_str());
        assert!(known, "{name} has no place in the dependency rules");
        assert!(!["core", "common", "util", "utils"].iter().any(|vague| name.ends_with(vague)), "{name}");
    }
}

#[test]
fn foreign_crates_enter_at_one_place() {
    only("faer", &["mpm-linear"]);
    only("hdf5", &["mpm-io"]);
    only("csv", &["mpm-io"]);
    only("robust", &["mpm-geometry"]);
    only("clap", &["mpm-cli", "mpm-validation", "mpm-benchmarks"]);
    only("pyo3", &["mpm-python"]);
    only("numpy", &["mpm-python"]);
    only("mpi", &["mpm-petsc"]);
    only("bindgen", &["mpm-petsc"]);
    only("plotters", &["mpm-plot"]);
    only("serde", &["mpm-solver", "mpm-scene", "mpm-benchmarks"]);
    // Scenes, and how far a run has come: the one text of checkpoints, in which every number keeps its bits.
    only("ron", &["mpm-scene", "mpm-io"]);
    // Programs and tests print the schema of the language.
    only("schemars", &["mpm-scene", "mpm-cli", "mpm-python", "mpm-validation"]);
    // Scenes only in their tests, which compare numbers of threads.
    only(
        "rayon",
        &[
            "mpm-basis",
            "mpm-linear",
            "mpm-assembly",
            "mpm-scene",
            "mpm-cli",
            "mpm-python",
            "mpm-validation",
            "mpm-benchmarks",
        ],
    );
}

/// Features unify: one crate that asks for faer's `rayon` would change the bits of all.
#[test]
fn faer_has_no_parallel_variant() {
    let workspace = fs::read_to_string(root().join("Cargo.toml")).expect("a readable manifest");
    let declared = table(&workspace, "[workspace.dependencies]")["faer"].clone();
    assert!(declared.contains("default-features = false"), "{declared}");
    assert!(!declared.contains("rayon"), "{declared}");
    for (name, manifest) in manifests() {
        let asked =
            [&manifest.dependencies, &manifest.dev_dependencies].map(|table| table.get("faer").cloned());
        for line in asked.into_iter().flatten() {
            assert!(!line.contains("features"), "{name} changes the features of faer: {line}");
        }
    }
}

/// The other workspace has the compiler settings and the versions of this one.
#[test]
fn both_workspaces_agree() {
    let read = |path: &str| fs::read_to_string(root().join(path)).expect("a readable manifest");
    let (ours, theirs) = (read("Cargo.toml"), read("apps/mpm-mpi/Cargo.toml"));
    for header in
        ["[workspace.package]", "[workspace.lints.rust]", "[workspace.lints.clippy]", "[profile.quick]"]
    {
        for (key, value) in table(&theirs, header) {
            assert_eq!(table(&ours, header).get(&key), Some(&value), "{header} {key}");
        }
    }
    let (ours, theirs) = (read("Cargo.lock"), read("apps/mpm-mpi/Cargo.lock"));
    let version = |lock: &str, name: &str| {
        let entry = format!("name = \"{name}\"\nversion = \"");
        let version = lock.split(&entry).nth(1).and_then(|rest| rest.split('"').next());
        version.expect("the package is locked").to_owned()
    };
    for name in ["faer", "nalgebra", "rayon", "hdf5-metno", "ron"] {
        assert_eq!(version(&theirs, name), version(&ours, name), "{name}");
    }
}
