//! Rigid motions that nothing holds, of bodies that several ranks share: refused, or kept at zero, as one rank does.

mod setup;

use setup::{alone, check, check_resumed, shared};

/// Blocks of two cells in the plane, pressed by loads that cancel.
fn blocks(bodies: &[(&str, [f64; 4])], supports: &str, rest: &str) -> String {
    let bodies = bodies.iter().map(|(name, [x, y, to_x, to_y])| {
        format!(
            r#"(name: "{name}", material: "m", shape: Box(from: ({x}, {y}), to: ({to_x}, {to_y})), points_per_cell: 2),"#
        )
    });
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 8, cells: 16), Uniform(from: 0, to: 6, cells: 12)]),
            basis: Cpdi1, materials: {{ "m": Hencky(young: 1e3, poisson: 0.3, density: 1) }},
            bodies: [{}], supports: [{supports}], schedule: (steps: 3), tolerance: (residual: 1e-9), {rest}
        )"#,
        bodies.collect::<String>()
    )
}

const ROLLERS: &str = r#"(name: "base", region: Plane(axis: Y, at: 1), fix: [Y]),"#;
const BLOCK: (&str, [f64; 4]) = ("b", [2.0, 1.0, 5.0, 3.0]);

/// Tension of a body across its sides of equal length.
fn pulled(body: &str, [left, right]: [f64; 2]) -> String {
    format!(
        r#"Traction(body: "{body}", axis: X, at: {left}, resultant: (-60, 0)), Traction(body: "{body}", axis: X, at: {right}, resultant: (60, 0)),"#
    )
}

fn zero(loads: &str) -> String {
    format!("unheld_motion: Zero, loads: [{loads}]")
}

#[test]
fn motions_without_load_are_kept_at_zero() {
    let weight = r#"Traction(body: "b", axis: Y, at: 3, resultant: (0, -40)),"#;
    check(&blocks(&[BLOCK], ROLLERS, &zero(weight)), &[1, 2, 3, 4]);
    // Nothing holds this one at all.
    check(&blocks(&[BLOCK], "", &zero(&pulled("b", [2.0, 5.0]))), &[1, 2, 3, 4]);
    // One of two bodies is held.
    let two = [BLOCK, ("c", [6.0, 3.5, 7.5, 5.5])];
    let base = r#"(name: "base", region: Plane(axis: Y, at: 1), fix: [X, Y]),"#;
    check(&blocks(&two, base, &zero(&format!("{weight} {}", pulled("c", [6.0, 7.5])))), &[2, 3, 5]);
}

/// Tension along every direction: a turn that it would not resist would be decided by rounding in later load steps.
#[test]
fn motions_in_space_are_kept_at_zero() {
    let load = |axis: usize, at: f64, size: f64| {
        let force: Vec<String> =
            (0..3).map(|d| if d == axis { size.to_string() } else { "0".into() }).collect();
        let axis = ["X", "Y", "Z"][axis];
        format!(r#"Traction(body: "b", axis: {axis}, at: {at}, resultant: ({})),"#, force.join(", "))
    };
    let pulled = [(0, 4.0, 30.0), (1, 3.0, 25.0), (2, 3.0, 20.0)];
    let loads: String =
        pulled.iter().map(|&(axis, at, size)| load(axis, 1.0, -size) + &load(axis, at, size)).collect();
    for supports in ["", r#"(name: "base", region: Plane(axis: Z, at: 1), fix: [Z])"#] {
        let text = format!(
            r#"Solid(
                mesh: Box(axes: [Uniform(from: 0, to: 5, cells: 5), Uniform(from: 0, to: 5, cells: 5), Uniform(from: 0, to: 5, cells: 5)]),
                basis: Gimp, stabilisation: Ghost(), materials: {{ "m": VonMises(young: 1e3, poisson: 0.3, yield_radius: 5) }},
                bodies: [(name: "b", material: "m", shape: Box(from: (1, 1, 1), to: (4, 3, 3)), points_per_cell: 2)],
                supports: [{supports}], loads: [{loads}],
                schedule: (steps: 3), tolerance: (residual: 1e-10), unheld_motion: Zero,
            )"#
        );
        check(&text, &[2, 3, 4]);
    }
}

#[test]
fn a_run_whose_motion_is_kept_at_zero_goes_on_with_any_number_of_ranks() {
    check_resumed(&blocks(&[BLOCK], ROLLERS, &zero(&pulled("b", [2.0, 5.0]))), 1);
}

/// The error of one rank, which all ranks of several have as well.
fn error(text: &str, ranks: &[usize]) -> String {
    let error = alone(text, &[]).1.unwrap_err().to_string();
    for &size in ranks {
        for (_, outcome) in shared(text, size, &[]) {
            assert_eq!(outcome.unwrap_err(), error, "{size} ranks");
        }
    }
    error
}

#[test]
fn what_nothing_holds_is_named_as_by_one_rank() {
    let weight = r#"loads: [Traction(body: "b", axis: Y, at: 3, resultant: (0, -40))]"#;
    let named = error(&blocks(&[BLOCK], ROLLERS, weight), &[2, 3, 4]);
    assert!(named.contains("body `b` along x"), "{named}");
    let pinned = r#"(name: "p", region: Point(3, 2), fix: [X, Y]),"#;
    let named = error(&blocks(&[BLOCK], pinned, weight), &[2, 3]);
    assert!(named.contains("body `b` in rotation about the point (3, 2)"), "{named}");
    // Three bodies: two that share nodes, and one apart.
    let three = [("a", [1.0, 1.0, 2.0, 3.0]), BLOCK, ("c", [6.0, 3.5, 7.5, 5.5])];
    let named = error(&blocks(&three, ROLLERS, weight), &[2, 3, 5]);
    assert!(
        named.contains("body `a` and body `b` along x; nor body `c` along x, along y and in rotation"),
        "{named}"
    );
    // A load has a part in the motion.
    let push = zero(r#"Traction(body: "b", axis: Y, at: 3, resultant: (1, -40))"#);
    let named = error(&blocks(&[BLOCK], ROLLERS, &push), &[2, 4]);
    assert!(named.contains("`unheld_motion: Zero` cannot keep it at zero"), "{named}");
}

/// Two blocks of linear points that share one node: a hinge, which lies on one rank or between two.
#[test]
fn parts_are_hinged_to_each_other_also_between_ranks() {
    let base = r#"(name: "base", region: Plane(axis: Y, at: 1), fix: [X, Y]),"#;
    for corner in [2.0, 3.5, 5.0] {
        let hinged = [("low", [1.0, 1.0, corner, 3.0]), ("high", [corner, 3.0, 7.0, 5.0])];
        let text = blocks(&hinged, base, "").replace("Cpdi1", "Smpm");
        let named = error(&text, &[2, 3, 4, 7]);
        assert!(named.contains(&format!("body `high` in rotation about the point ({corner}, 3)")), "{named}");
    }
}
