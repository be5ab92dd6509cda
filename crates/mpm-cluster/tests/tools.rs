//! Rigid tools that several ranks share: the answers of one.

mod setup;

use setup::{Seen, alone, assert_same, check, check_resumed, repository_scene, shared, shared_with_border};

/// A block on which a disc rolls and slides, and a weight that sinks and tilts.
const TOOLS: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 6), Uniform(from: 0, to: 3, cells: 6)]),
    basis: Cpdi1 DOMAINS, stabilisation: Ghost(),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 20, density: 1) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (3, 1.6)), points_per_cell: 2)],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]), (name: "right", region: Plane(axis: X, at: 3), fix: [X]),
    ],
    tools: [
        (name: "wheel", parts: [Disc(centre: (1, 2.2), radius: 0.6)],
            motion: Move(by: (0, -0.08), ramp: [(0, 0), (0.5, 1)], then: [(by: (0.015, 0), ramp: [(0.5, 0), (1, 1)])],
                turn: (centre: (1, 2.2), angle: -20)),
            interface: (friction: 0.3, adhesion: 1), moment_about: (1, 2.2)),
        (name: "weight", parts: [Polygon(vertices: [(2.2, 1.6), (3, 1.6), (3, 2.2), (2.2, 2.2)])], moment_about: (2.5, 1.6),
            motion: Loaded(free: [Y, Turn], force: (0, -20)), interface: (friction: 0.2, augment: 1)),
    ],
    schedule: (steps: 8), tolerance: (residual: 1e-10),
    output: (energies: true, fields: [ContactForce, ContactGap, ContactSlip]),
)"#;

/// A heavy block that slides along a plane, over the cells of several ranks, with a hole that a tool fills.
const SLIDE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 16), Uniform(from: 0, to: 2, cells: 8)]),
    basis: BASIS, stabilisation: Ghost(),
    materials: { "elastic": Hencky(young: 1e5, poisson: 0.3, density: 1) },
    bodies: [(name: "block", material: "elastic", shape: Box(from: (0.25, 0.26), to: (1.5, 1)), points_per_cell: 2)],
    loads: [BodyForce(acceleration: (0, -10), ramp: [(0, 1)])],
    tools: [
        (name: "plane", parts: [Plane(through: (0, 0.26), normal: (0, 1))], interface: (friction: 0.2)),
        (name: "ram", parts: [Polygon(vertices: [(-1, 0.27), (0.25, 0.27), (0.25, 1.2), (-1, 1.2)])],
            motion: Move(by: (1.6, 0))),
    ],
    schedule: (steps: 24), tolerance: (residual: 1e-9), output: (fields: [ContactForce, ContactSlip]),
)"#;

/// The same with domains that are split. What corners dissipate is as their slip: rounding decides whose it is.
fn split() -> String {
    let text = TOOLS.replace("DOMAINS", ", domains: (control: Split(cells: 0.51, growth: 9))");
    text.replace("energies: true, ", "")
}

#[test]
fn tools_that_press_slide_and_sink() {
    check(&TOOLS.replace("DOMAINS", ""), &[1, 2, 3, 4]);
    check(&split(), &[2, 3]);
}

#[test]
fn the_motion_of_tools_is_found_apart_from_that_of_nodes() {
    // With friction the tangent is not symmetric.
    for (friction, rough) in [("friction: 0.2, ", "friction: 0.3, "), ("", "")] {
        let text = TOOLS.replace("DOMAINS", "").replace("friction: 0.3, ", rough);
        let text = text.replace("friction: 0.2, ", friction);
        let (one, summary) = alone(&text, &[]);
        for size in [1, 3] {
            let all = shared_with_border(&text, size);
            assert_same(&text, (&one, &all[0].0), &format!("{size} ranks"));
            let several = all[0].1.as_ref().unwrap();
            assert_eq!(several.iterations, summary.as_ref().unwrap().iterations);
        }
    }
    let nothing = TOOLS
        .replace("DOMAINS", "")
        .replace("free: [Y, Turn], force: (0, -20)", "free: [X, Y, Turn], force: (0, 0)");
    let nothing = nothing.replace("friction: 0.2, augment", "augment");
    for (_, outcome) in shared_with_border(&nothing, 2) {
        let message = outcome.unwrap_err();
        assert!(
            message.contains("nothing resists the shift along x of contribution `tool weight`"),
            "{message}"
        );
    }
}

#[test]
fn what_corners_remember_goes_with_their_points() {
    for basis in ["Cpdi1", "Gimp"] {
        check(&SLIDE.replace("BASIS", basis), &[2, 4]);
    }
}

#[test]
fn tools_of_scenes() {
    let by = [("steps: 100", "steps: 4"), ("Move(by: (0.5, 0))", "Move(by: (0.02, 0))")];
    check(&repository_scene("scenes/plough.ron", &by), &[2, 3]);
    check(&repository_scene("validation/scenes/contact/pulled_pile.ron", &[]), &[2]);
}

#[test]
fn the_same_ranks_find_the_same_bits() {
    let bits = |seen: &Seen| {
        let rows = seen.rows.iter().flatten();
        seen.positions
            .iter()
            .chain(&seen.stress)
            .chain(&seen.contact)
            .chain(rows)
            .copied()
            .collect::<Vec<f64>>()
    };
    // The seconds are the last of the columns that depend on the clock.
    let timeless = |mut seen: Seen| {
        let clock = seen.columns.iter().position(|it| it == "wall_seconds").unwrap();
        seen.rows.iter_mut().for_each(|row| row[clock] = 0.0);
        bits(&seen)
    };
    let text = TOOLS.replace("DOMAINS", "");
    let run = || timeless(shared(&text, 3, &[]).remove(0).0);
    assert_eq!(run(), run());
}

#[test]
fn a_run_with_tools_goes_on_with_any_number_of_ranks() {
    for text in [split(), SLIDE.replace("BASIS", "Cpdi1")] {
        let [one, three] = check_resumed(&text, 5);
        let numbers = |state: &mpm_solver::State| {
            state.contributions.iter().map(|it| it.numbers.len()).collect::<Vec<usize>>()
        };
        assert_eq!(numbers(&three), numbers(&one));
    }
}

#[test]
fn all_ranks_end_with_one_message() {
    let text = TOOLS.replace("DOMAINS", "");
    let free = text.replace("free: [Y, Turn], force: (0, -20)", "free: [X, Y, Turn], force: (0, -20)");
    let (text, said) = (free.replace("friction: 0.2, augment", "augment"), "nothing resists the shift along x");
    let (_, error) = alone(&text, &[]);
    let error = error.unwrap_err().to_string();
    assert!(error.contains(said), "{error}");
    for size in [2, 3] {
        let messages: Vec<String> =
            shared(&text, size, &[]).into_iter().map(|(_, outcome)| outcome.unwrap_err()).collect();
        assert!(messages.iter().all(|it| *it == messages[0] && it.contains(said)), "{messages:?}");
    }
}
