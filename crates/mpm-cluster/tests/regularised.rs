//! Laws that a nodal field regularises, shared by several ranks: the answers of one.

mod setup;

use setup::{check, check_resumed, repository_scene, shared};

/// A block with a regularised half that a wall pushes over the cells of several ranks, so that nodes of the field, and points, change
/// hands; the other half has no field.
const PUSHED: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 6, cells: 12), Uniform(from: 0, to: 3, cells: 6)]),
    basis: BASIS, stabilisation: Ghost(),
    materials: {
        "soft": VonMises(young: 1e3, poisson: 0.3, undrained_strength: 6, softening: Linear(modulus: 40, residual: 2), density: 1,
            gradient: (DRIVER modulus: 300, length: 0.4)),
        "plain": Hencky(young: 2e3, poisson: 0.2, density: 1),
    },
    bodies: [
        (name: "low", material: "soft", shape: Box(from: (0.3, 0), to: (2.4, 1)), points_per_cell: 2),
        (name: "high", material: "plain", shape: Box(from: (0.3, 1), to: (2.4, 2)), points_per_cell: 2),
    ],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [Y])],
    walls: [(name: "left", body: "low", side: "left", hold: All, exact: false, motion: Move(by: (1.5, 0)))],
    loads: [BodyForce(acceleration: (0, -3))],
    schedule: (steps: 10), tolerance: (residual: 1e-9), output: (energies: true),
)"#;

fn pushed(basis: &str, driver: &str) -> String {
    PUSHED.replace("BASIS", basis).replace("DRIVER", driver)
}

#[test]
fn fields_of_plastic_strain_and_of_shear() {
    check(&pushed("Cpdi1", ""), &[1, 2, 3, 4]);
    // Nodes that are new in a load step begin with a mean over groups of points, which are other ones on ranks; here few are new.
    check(
        &pushed("Gimp", "driver: Strain,").replace("by: (1.5, 0)", "by: (0.1, 0)").replace("1e-9", "1e-11"),
        &[2, 5],
    );
}

#[test]
fn a_field_in_space_and_one_in_splines() {
    let text = r#"Solid(
        mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 4, cells: 4)]),
        basis: Cpdi1,
        materials: { "m": VonMises(young: 1e3, poisson: 0.3, undrained_strength: 3, softening: Linear(modulus: 10, residual: 1), density: 1,
            gradient: (modulus: 200, length: 0.6)) },
        bodies: [(name: "b", material: "m", shape: Box(from: (0, 0, 0), to: (2, 2, 3)), points_per_cell: 2)],
        supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z])],
        loads: [BodyForce(acceleration: (0.4, 0, -2))],
        schedule: (steps: 3), tolerance: (residual: 1e-9),
    )"#;
    check(text, &[2, 3]);
    let short = [("steps: 90", "steps: 6"), ("angle: 90", "angle: 6")];
    check(&repository_scene("scenes/doughnut_regularised.ron", &short), &[2, 3]);
}

/// A tangent that is not symmetric, and a tool whose motion is unknown behind the field.
#[test]
fn a_field_beside_a_loaded_tool() {
    let tool = r#"tools: [(name: "weight", parts: [Polygon(vertices: [(0.6, 2), (1.8, 2), (1.8, 2.6), (0.6, 2.6)])], moment_about: (1.2, 2),
        motion: Loaded(free: [Y, Turn], force: (0, -8)), interface: (friction: 0.2))],"#;
    let text = pushed("Cpdi1", "").replace("loads:", &format!("{tool} loads:"));
    let text = text.replace("Move(by: (1.5, 0))", "Move(by: (0.3, 0))").replace("steps: 10", "steps: 6");
    check(&text, &[2, 3]);
}

#[test]
fn a_run_with_a_field_goes_on_with_any_number_of_ranks() {
    check_resumed(&pushed("Cpdi1", ""), 5);
}

#[test]
fn the_same_ranks_find_the_same_bits() {
    let run = || {
        let seen = shared(&pushed("Cpdi1", ""), 3, &[]).remove(0).0;
        let all = seen.positions.iter().chain(&seen.stress).chain(&seen.strain);
        all.map(|x| x.to_bits()).collect::<Vec<u64>>()
    };
    assert_eq!(run(), run());
}
