//! Scenes that ask for too much, or for nothing that exists: refused with a message, before memory is asked for.
//!
//! One test, as the counts are those of the whole process.

use mpm_scene::NoFiles;
use mpm_scene::Scene;
use mpm_scene::compile_within;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Memory that scenes may take up `[bytes]`.
const ROOM: u64 = 1 << 30;

/// What a refusal may take `[bytes]`.
const LITTLE: usize = 4 << 20;

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4)]),
    motion: Fixed,
    basis: Smpm,
    materials: { "soft": VonMises(young: 1e3, poisson: 0.3, yield_radius: 5) },
    bodies: [(name: "block", material: "soft", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
    supports: [(name: "left", region: Plane(axis: X, at: 0), fix: [X, Y])],
    loads: [PointForce(body: "block", near: (2, 2), force: (0, 1))],
    schedule: (steps: 4),
)"#;

const RING: &str = r#"PlaneStrain(
    mesh: Ring(radii: Uniform(from: 1, to: 2, cells: 2), sectors: 8),
    basis: Cpdi1,
    materials: { "soft": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "ring", material: "soft", shape: Ring(inner: 1, outer: 2), points_per_cell: 2)],
    supports: [(name: "in", region: Circle(radius: 1), fix: [X, Y])],
    schedule: (steps: 4),
)"#;

/// What replaces what, and a part of the message.
type Case = (&'static str, &'static str, &'static str);

const X_AXIS: &str = "[Uniform(from: 0, to: 4, cells: 4)";

const CASES: &[Case] = &[
    // What is no number, or beyond numbers.
    ("young: 1e3", "young: NaN", "finite number above 0"),
    ("young: 1e3", "young: inf", "finite number above 0"),
    ("young: 1e3", "young: 1e999", "finite number above 0"),
    ("poisson: 0.3", "poisson: -inf", "above -1 and below 0.5"),
    ("near: (2, 2)", "near: (NaN, 2)", "finite number"),
    (X_AXIS, "[Uniform(from: -1e308, to: 1e308, cells: 4)", "too long for its nodes"),
    (X_AXIS, "[Uniform(from: -1e308, to: 4, cells: 4)", "too long for its nodes"),
    (X_AXIS, "[Nodes([-1e308, 0, 1e308])", "too long for its nodes"),
    (X_AXIS, "[Nodes([0, 1, inf])", "finite number"),
    // Cells that rounding closes.
    (X_AXIS, "[Nodes([0, 0.49999999999999994, 0.5, 2])", "no volume"),
    // Nothing at all.
    (X_AXIS, "[Uniform(from: 0, to: 0, cells: 4)", "increase strictly"),
    (X_AXIS, "[Uniform(from: 0, to: 4, cells: 0)", "from 1 to"),
    (X_AXIS, "[Nodes([])", "at least one cell"),
    ("to: (2, 2)", "to: (0, 2)", "box is empty"),
    ("to: (2, 2)", "to: (1e-16, 2)", "box is empty"),
    ("points_per_cell: 2", "points_per_cell: 0", "from 1 to"),
    ("steps: 4", "steps: 0", "from 1 to"),
    ("young: 1e3", "young: 0", "above 0"),
    // Too much.
    ("points_per_cell: 2", "points_per_cell: 1000000", "4e12 material points are more than"),
    ("points_per_cell: 2", "points_per_cell: 4294967295", "material points are more than"),
    ("points_per_cell: 2", "points_per_cell: 10000", "would take at least"),
    (X_AXIS, "[Uniform(from: 0, to: 4, cells: 1000000000)", "more nodes than"),
    (X_AXIS, "[Uniform(from: 0, to: 4, cells: 800000000)", "material points"),
    (X_AXIS, "[Graded(from: 0, to: 4, cells: 800000000, ratio: 2)", "the axis would take at least"),
    (X_AXIS, "[Graded(from: 0, to: 4, cells: 4294967295, ratio: 2)", "the axis would take at least"),
    ("Plane(axis: X, at: 0)", "All([Everywhere, Everywhere])", ""),
    // Bases and motions that do not go together.
    ("motion: Fixed,\n    basis: Smpm", "motion: Rotate(angle: 30),\n    basis: Gimp", "GIMP needs a mesh"),
];

const RINGS: &[Case] = &[
    ("sectors: 8", "sectors: 4294967295", "the ring would take at least"),
    ("sectors: 8", "sectors: 1000000000", "the ring would take at least"),
    ("cells: 2", "cells: 1000000000", "the ring would take at least"),
    ("from: 1, to: 2", "from: 1e-200, to: 1e-199", "no volume"),
    ("from: 1, to: 2", "from: 1e200, to: 1e201", "no volume"),
    ("from: 1, to: 2", "from: 0, to: 2", "must be positive"),
    ("outer: 2)", "outer: 1)", "0 < inner < outer"),
];

#[test]
fn what_cannot_be_is_refused_before_memory_is_asked_for() {
    let mut wrong = Vec::new();
    let mut check = |text: &str, case: &Case| {
        let region = Region::new(ALLOCATOR);
        let said = match Scene::from_ron(text) {
            Ok(scene) => compile_within(&scene, &NoFiles, ROOM).err().map(|it| it.to_string()),
            Err(error) => Some(error.to_string()),
        };
        let taken = region.change().bytes_allocated;
        let part = case.2;
        let right = match &said {
            None => part.is_empty(),
            Some(said) => !part.is_empty() && said.contains(part) && taken < LITTLE + 8 * text.len(),
        };
        if !right {
            let scene: String = text.chars().take(300).collect();
            wrong.push(format!("{said:?}, {taken} bytes, expected {part:?}: {scene}"));
        }
    };
    for (scene, cases) in [(SCENE, CASES), (RING, RINGS)] {
        check(scene, &("", "", ""));
        for case in cases {
            assert!(scene.contains(case.0), "{case:?}: nothing to replace");
            check(&scene.replacen(case.0, case.1, 1), case);
        }
    }
    // A large grid round a small body is no harm; its nodes in a list would be.
    let wide = SCENE
        .replace(X_AXIS, "[Uniform(from: 0, to: 40000, cells: 40000)")
        .replace("Uniform(from: 0, to: 4, cells: 4)]", "Uniform(from: 0, to: 40000, cells: 40000)]");
    check(&wide, &("", "", ""));
    check(&wide.replace("Plane(axis: X, at: 0)", "Everywhere"), &("", "", "are to be sought among"));
    // Two bodies far apart: the box round them is a table.
    let apart = wide.replace(
        "points_per_cell: 2)]",
        "points_per_cell: 2), (name: \"b\", material: \"soft\", shape: Box(from: (39998, 39998), to: (39999, 39999)), points_per_cell: 1)]",
    );
    check(&apart, &("", "", "the part of the mesh around the bodies would take at least"));
    // An axis is stretched in part: its nodes would be listed.
    let long = SCENE.replace(X_AXIS, "[Uniform(from: 0, to: 5e8, cells: 500000000)");
    let stretched =
        long.replace("motion: Fixed", "motion: Stretch([(axis: X, anchor: 0, driven: 4, displacement: 1)])");
    assert_ne!(long, stretched);
    check(&stretched, &("", "", "the axis that is stretched in part would take at least"));
    // Pieces of a round body, before they are cut.
    let round = SCENE.replace(
        "Box(from: (0, 0), to: (2, 2)), points_per_cell: 2",
        "Cylinder(centre: (2, 2), radius: 1.5), points_per_cell: 3000",
    );
    assert_ne!(round, SCENE);
    check(&round, &("", "", "a layer of pieces around the body would take at least"));
    // Parts of a round body so long that their numbers overflow.
    let cylinder = include_str!("../../../scenes/cylinder.ron");
    let endless =
        cylinder.replace("Uniform(from: 0, to: 50, cells: 16)", "Uniform(from: 0, to: 1e300, cells: 16)");
    assert_ne!(endless, cylinder);
    check(&endless, &("", "", "that a point stands for has no volume that can be computed"));
    // Nested beyond what a stack holds.
    for (open, close) in [("(", ")"), ("[", "]"), ("All([", "])"), ("{\"a\":", "}")] {
        for depth in [200, 100_000] {
            let nested = format!("{}Everywhere{}", open.repeat(depth), close.repeat(depth));
            let text = SCENE.replace("Plane(axis: X, at: 0)", &nested);
            let part = if open == "All([" { "recursion" } else { "expected" };
            check(&text, &("", "", part));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
