//! Walls and loads on sides of bodies, and ghost faces of splines, that several ranks share.

mod setup;

use setup::{check, check_resumed, repository_scene};

/// A turned block between a wall that moves and on which it slides, and a frame with a load, under a pressure and a traction.
const WALLS: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: -3, to: 5, cells: 13), Uniform(from: -3, to: 5, cells: 13)] FUNCTIONS),
    basis: BASIS, stabilisation: Ghost(),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (1, 0), to: (3, 2), turned: 30), points_per_cell: 2, tiling: Shape)],
    walls: [
        (name: "left", body: "block", side: "left", surface: Plane(through: (1, 0), normal: (0.8660254037844387, 0.5)), EXACT,
            motion: Move(by: (0.017, 0.01))),
        (name: "right", body: "block", side: "right", hold: All, moment_about: (2, 1), motion: Loaded(free: [X, Turn], force: (9, 0), moment: 2)),
    ],
    loads: [Pressure(body: "block", side: "top", value: 8), Traction(body: "block", side: "top", value: (1, -1))],
    schedule: (steps: 6), output: (energies: true), tolerance: (residual: 1e-9),
)"#;

/// A slab that moves over the cells of several ranks with the wall that holds its side.
const CARRIED: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 12), Uniform(from: 0, to: 2, cells: 4)]),
    basis: Cpdi1, stabilisation: Ghost(),
    materials: { "soft": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "slab", material: "soft", shape: Box(from: (0.3, 0.3), to: (1.8, 1.4)), points_per_cell: 2, tiling: Shape)],
    walls: [(name: "left", body: "slab", side: "left", hold: All, exact: false, motion: Move(by: (3, 0.1)))],
    loads: [Pressure(body: "slab", side: "right", value: 8), Pressure(body: "slab", side: "top", value: 3)],
    schedule: (steps: 12), tolerance: (residual: 1e-9),
)"#;

fn walls(basis: &str, functions: &str, exact: &str) -> String {
    WALLS.replace("BASIS", basis).replace("FUNCTIONS", functions).replace("EXACT", exact)
}

#[test]
fn walls_and_loads_on_sides() {
    check(&walls("Cpdi1", "", "exact: false"), &[1, 2, 3, 4]);
    check(&walls("Gimp", "", "stiffness: 50"), &[2, 5]);
    check(&walls("Cpdi2q", ", functions: Splines(degree: 2)", "exact: true"), &[2, 3]);
    check(&walls("Smpm", "", "exact: false"), &[2, 3]);
}

#[test]
fn markers_go_from_rank_to_rank() {
    check(CARRIED, &[2, 4]);
}

#[test]
fn a_run_with_walls_goes_on_with_any_number_of_ranks() {
    for (text, after) in [(walls("Cpdi1", "", "exact: false"), 3), (CARRIED.to_owned(), 6)] {
        check_resumed(&text, after);
    }
}

#[test]
fn walls_in_space() {
    let text = r#"Solid(
        mesh: Box(axes: [Uniform(from: -2, to: 4, cells: 6), Uniform(from: -2, to: 4, cells: 6), Uniform(from: 0, to: 3, cells: 3)]),
        basis: Cpdi1, stabilisation: Ghost(),
        materials: { "soft": Hencky(young: 1e3, poisson: 0.3) },
        bodies: [(name: "block", material: "soft", shape: Box(from: (0, 0, 0.2), to: (2, 2, 2.1)), points_per_cell: 2, tiling: Shape)],
        walls: [(name: "base", body: "block", side: "bottom", hold: All, exact: false)],
        loads: [Pressure(body: "block", side: "top", value: 20), Traction(body: "block", side: "left", value: (0, 0, -3))],
        schedule: (steps: 2), tolerance: (residual: 1e-9),
    )"#;
    check(text, &[2, 3]);
}

#[test]
fn ghost_faces_of_splines() {
    for degree in [2, 3] {
        let text = r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 12), Uniform(from: 0, to: 4, cells: 8)], functions: Splines(degree: DEGREE)),
            basis: Cpdi1, stabilisation: Ghost(),
            materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 8, density: 1) },
            bodies: [(name: "bank", material: "clay", shape: Polygon(vertices: [(0, 0), (4.3, 0), (2.2, 2.1), (0, 2.1)]), points_per_cell: 2)],
            supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]), (name: "left", region: Plane(axis: X, at: 0), fix: [X])],
            loads: [BodyForce(acceleration: (0, -5))],
            schedule: (steps: 4), tolerance: (residual: 1e-9),
        )"#;
        check(&text.replace("DEGREE", &degree.to_string()), &[2, 3, 7]);
    }
    let short = [("steps: 20", "steps: 4")];
    let text = repository_scene("validation/scenes/ring_splines.ron", &short);
    check(&text.replacen("basis:", "stabilisation: Ghost(), basis:", 1), &[2, 3]);
}
