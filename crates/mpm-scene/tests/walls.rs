//! Walls that hold sides of bodies off the lines of the mesh.

#[path = "walls/column.rs"]
mod column;
#[path = "walls/seen.rs"]
mod seen;

use seen::{functions, run};

/// A block held by walls or by supports on lines of the mesh.
fn block(degree: u32, held: &str) -> String {
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 3, cells: 3), Uniform(from: 0, to: 4, cells: 4)], functions: {}),
            basis: Cpdi2q, stabilisation: Ghost(), materials: {{ "soil": Hencky(young: 100, poisson: 0.3, density: 2) }},
            bodies: [(name: "block", material: "soil", shape: Box(from: (0, 0), to: (3, 3)), points_per_cell: 2)],
            {held}, loads: [BodyForce(acceleration: (0.4, -1))],
            schedule: (steps: 3), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
        )"#,
        functions(degree)
    )
}

#[test]
fn walls_on_lines_of_the_mesh_hold_as_supports_do() {
    let supports = r#"supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]), (name: "right", region: Plane(axis: X, at: 3), fix: [X]),
    ]"#;
    let walls = r#"walls: [
        (name: "base", body: "block", side: "bottom", surface: Plane(through: (0, 0), normal: (0, 1)), exact: true),
        (name: "right", body: "block", side: "right", surface: Plane(through: (3, 0), normal: (-1, 0)), exact: true),
    ]"#;
    for degree in [1, 2] {
        let [nodes, walls] = [supports, walls].map(|held| run(&block(degree, held)));
        let size = nodes.stress.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let apart = nodes.stress.iter().zip(&walls.stress).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6 * size, "degree {degree}: {apart:e} of {size}");
        // The walls carry the weight of 9 times 2.
        let carried = [walls.real("wall/base/reaction")[1], walls.real("wall/right/reaction")[0]];
        assert!((carried[0] - 18.0).abs() < 1e-9 && (carried[1] + 7.2).abs() < 1e-9, "{carried:?}");
        assert!(walls.real("wall/base/gap")[0] < 1e-10);
    }
}

/// A turned square between walls: `held` of its sides, and how the wall on top moves.
fn square(degree: u32, walls: &str) -> String {
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: -3.1, to: 5, cells: 13), Uniform(from: -3.7, to: 5, cells: 14)], functions: {}),
            basis: Cpdi2q, stabilisation: Ghost(), materials: {{ "soil": Hencky(young: 100, poisson: 0.3) }},
            bodies: [(name: "block", material: "soil", shape: Box(from: (1, 0), to: (3, 2), turned: 30), points_per_cell: 2, tiling: Shape)],
            walls: [{walls}], schedule: (steps: 3), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
        )"#,
        functions(degree)
    )
}

#[test]
fn a_turned_square_is_pressed_evenly() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let plane = |[x, y]: [f64; 2], normal: [f64; 2]| {
        format!("surface: Plane(through: ({x:?}, {y:?}), normal: ({:?}, {:?}))", normal[0], normal[1])
    };
    let top = [1.0 - 2.0 * sine, 2.0 * cosine];
    let right = [1.0 + 2.0 * cosine, 2.0 * sine];
    let right = format!(
        r#"(name: "right", body: "block", side: "right", exact: true, {}, motion: Move(by: ({:?}, {:?})))"#,
        plane(right, [-cosine, -sine]),
        0.2 * cosine,
        0.2 * sine
    );
    let walls = [
        format!(
            r#"(name: "base", body: "block", side: "bottom", exact: true, {})"#,
            plane([1.0, 0.0], [-sine, cosine])
        ),
        format!(
            r#"(name: "left", body: "block", side: "left", exact: true, {})"#,
            plane([1.0, 0.0], [cosine, sine])
        ),
        format!(
            r#"(name: "top", body: "block", side: "top", exact: true, {}, motion: Move(by: ({:?}, {:?})))"#,
            plane(top, [sine, -cosine]),
            0.4 * sine,
            -0.4 * cosine
        ),
    ];
    for degree in [1, 2] {
        let seen = run(&square(degree, &walls.join(", ")));
        let along = seen.along([-sine, cosine]);
        // ln λ = ln 0.8 with the side free: σ J = E/(1 − ν²) ln λ, ln λ_side = −ν/(1 − ν) ln λ.
        let log = 0.8_f64.ln();
        let exact = 100.0 / (1.0 - 0.09) * log / (log * (1.0 - 0.3 / 0.7)).exp();
        let worst = along.iter().map(|s| (s - exact).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9 * exact.abs(), "degree {degree}: {worst:e} of {exact}");
        let carried = seen.real("wall/base/reaction");
        let across = carried[0] * cosine + carried[1] * sine;
        assert!(across.abs() < 1e-9 * carried[1].abs(), "{carried:?}");
        // All four sides on walls: 0.8 along and 1.1 across.
        let seen = run(&square(degree, &format!("{}, {right}", walls.join(", "))));
        let [lame, shear] = [100.0 * 0.3 / (1.3 * 0.4), 100.0 / 2.6];
        let logs = [0.8_f64.ln(), 1.1_f64.ln()];
        let volume = logs[0] + logs[1];
        for (log, direction) in logs.into_iter().zip([[-sine, cosine], [cosine, sine]]) {
            let exact = (lame * volume + 2.0 * shear * log) / volume.exp();
            let worst = seen.along(direction).iter().map(|s| (s - exact).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-10 * 100.0, "degree {degree}: {worst:e} of {exact}");
        }
    }
}

/// The same in space: a block that is turned about z, pressed by a pressure on its top and held by walls on three sides.
#[test]
fn a_turned_block_in_space_is_pressed_evenly() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let text = format!(
        r#"Solid(
            mesh: Box(axes: [Uniform(from: -2.1, to: 4, cells: 7), Uniform(from: -1.3, to: 4, cells: 6), Uniform(from: -0.6, to: 3, cells: 4)]),
            basis: Cpdi2Hexahedron, stabilisation: Ghost(), materials: {{ "soil": Hencky(young: 100, poisson: 0.3) }},
            bodies: [(name: "block", material: "soil", shape: Box(from: (1, 0, 0), to: (3, 2, 2), turned: 30), points_per_cell: 2, tiling: Shape)],
            walls: [
                (name: "base", body: "block", side: "bottom", exact: true, surface: Plane(through: (0, 0, 0), normal: (0, 0, 1))),
                (name: "left", body: "block", side: "left", exact: true, surface: Plane(through: (1, 0, 0), normal: ({cosine:?}, {sine:?}, 0))),
                (name: "front", body: "block", side: "front", exact: true, surface: Plane(through: (1, 0, 0), normal: ({:?}, {cosine:?}, 0))),
            ],
            loads: [Pressure(body: "block", side: "top", value: 10), Traction(body: "block", side: "top", value: (0, 0, -5))],
            schedule: (steps: 2), tolerance: (residual: 1e-11), output: (fields: [CauchyStress]),
        )"#,
        -sine
    );
    let seen = run(&text);
    let upright: Vec<f64> = seen.stress.chunks_exact(9).map(|s| s[8]).collect();
    let others = seen.stress.chunks_exact(9).flat_map(|s| [s[0], s[1], s[2], s[4], s[5]]);
    let worst = others.map(f64::abs).fold(0.0, f64::max);
    let apart = upright.iter().map(|s| (s - upright[0]).abs()).fold(0.0, f64::max);
    // The pressure follows, the traction is one of the area at rest.
    let base = seen.real("wall/base/reaction")[2];
    assert!(worst < 1e-7 && apart < 1e-7, "{worst:e} {apart:e}");
    let area = (base - 20.0) / 10.0;
    assert!(area > 4.1 && (upright[0] + base / area).abs() < 1e-7, "{area} {} {base}", upright[0]);
}

/// A wall that turns and moves carries a body with it without stress: what is left is rounding, of ghost faces as well.
#[test]
fn a_body_is_carried_without_stress() {
    let motion = "motion: Move(by: (0.3, 0.5), turn: (centre: (1, 0), angle: 75))";
    let hand = format!(r#"(name: "hand", body: "block", side: "left", hold: All, {motion})"#);
    for degree in [1, 2, 3] {
        let seen = run(&square(degree, &hand).replace("steps: 3", "steps: 15"));
        assert_eq!(seen.residuals.len(), 16, "degree {degree}: steps were cut");
        let worst = seen.stress.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(worst < 1e-9, "degree {degree}: {worst:e}");
        let rest = [seen.rest[0] - 1.0, seen.rest[1]];
        let (sine, cosine) = 75_f64.to_radians().sin_cos();
        let expected = [1.3 + cosine * rest[0] - sine * rest[1], 0.5 + sine * rest[0] + cosine * rest[1]];
        let apart = (seen.position[0] - expected[0]).hypot(seen.position[1] - expected[1]);
        assert!(apart < 1e-9, "degree {degree}: {apart:e}");
    }
}

/// A disc presses into a block that slides on it: Newton's method converges quadratically.
#[test]
fn newtons_method_is_quadratic_at_round_walls() {
    let walls = r#"walls: [
        (name: "base", body: "block", side: "bottom", hold: All),
        (name: "ball", body: "block", side: "top", hold: Contact, surface: Disc(centre: (1.4, 5.001), radius: 2), motion: Move(by: (0.1, -0.4))),
    ]"#;
    let seen =
        run(&block(2, walls).replace("to: 4, cells: 4", "to: 5, cells: 5").replace("(0.4, -1)", "(0, 0)"));
    let force = seen.real("wall/ball/reaction");
    assert!(force[1] < -1.0, "{force:?}");
    for residuals in &seen.residuals[1..] {
        let last = &residuals[residuals.len() - 3..];
        assert!(residuals.len() < 12 && last[2] < 1e-10 && last[1] < last[0], "{residuals:?}");
    }
}

/// A tip moment on a frame bends a strip into an arc, `M = E I κ/(1 − ν²)`.
#[test]
fn a_frame_with_a_moment_bends_a_strip() {
    let text = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: -1.13, to: 5.6, cells: 27), Uniform(from: -0.63, to: 4.2, cells: 20)], functions: Splines(degree: 2)),
        basis: Cpdi2q, stabilisation: Ghost(), materials: { "steel": Hencky(young: 1200, poisson: 0) },
        bodies: [(name: "strip", material: "steel", shape: Box(from: (0, 0), to: (5, 0.5)), points_per_cell: 4, tiling: Shape)],
        walls: [
            (name: "clamp", body: "strip", side: "left", hold: All),
            (name: "tip", body: "strip", side: "right", hold: All, exact: true, moment_about: (5, 0.25),
                motion: Loaded(free: [X, Y, Turn], moment: 3.9269908169872414)),
        ],
        schedule: (steps: 4), output: (fields: [CauchyStress]),
    )"#;
    let seen = run(text);
    // E I = 12.5, so that κ L = π/2.
    let (angle, position) = (seen.real("wall/tip/angle")[0], seen.real("wall/tip/position"));
    assert!((angle - 90.0).abs() < 2.0, "{angle}");
    let radius = 5.0 / std::f64::consts::FRAC_PI_2;
    assert!((position[0] - radius).abs() < 0.05 && (position[1] - 0.25 - radius).abs() < 0.05, "{position:?}");
    let moment = seen.real("wall/tip/moment")[0];
    assert!((moment - 3.926_990_816_987_241_4).abs() < 1e-6, "{moment}");
}

/// A force at the tip that turns with it bends a strip as the elastica has it. From the tip backwards, with ψ the angle between
/// the tangent and that of the tip, `E I ψ'' = P cos ψ` from `ψ = ψ' = 0` on, whatever the tip's own angle is.
#[test]
fn a_force_that_follows_bends_a_strip_as_the_elastica() {
    let text = r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: -0.63, to: 5.6, cells: 25), Uniform(from: -0.63, to: 4.7, cells: 22)], functions: Splines(degree: 2)),
        basis: Cpdi2q, stabilisation: Ghost(), materials: { "steel": Hencky(young: 1200, poisson: 0) },
        bodies: [(name: "strip", material: "steel", shape: Box(from: (0, 0), to: (5, 0.5)), points_per_cell: 4, tiling: Shape)],
        walls: [
            (name: "clamp", body: "strip", side: "left", hold: All),
            (name: "tip", body: "strip", side: "right", hold: All, exact: true, moment_about: (5, 0.25),
                motion: Loaded(free: [X, Y, Turn], force: (0, 1), follows: true)),
        ],
        schedule: (steps: 8), output: (fields: [CauchyStress]),
    )"#;
    let seen = run(text);
    let (angle, position) = (seen.real("wall/tip/angle")[0], seen.real("wall/tip/position"));
    // Strain is the same all over a tile: eight through the height have 1 − 1/64 of I.
    let [expected, x, y] = elastica(1.0 / (12.5 * (1.0 - 1.0 / 64.0)), 5.0);
    assert!((angle / expected.to_degrees() - 1.0).abs() < 0.01, "{angle}, expected {}", expected.to_degrees());
    let apart = (position[0] - x).hypot(position[1] - 0.25 - y);
    assert!(apart < 0.03, "{position:?}, expected {x} {y}");
    let (sine, cosine) = angle.to_radians().sin_cos();
    let carried = seen.real("wall/clamp/reaction");
    assert!((carried[0] - sine).hypot(carried[1] + cosine) < 1e-6, "{carried:?}");
    assert!(seen.residuals[1..].iter().all(|it| it.len() <= 25), "{:?}", seen.residuals);
}

/// Angle at the tip of a strip of this length `[rad]`, and where that is, under a force over E I that follows.
fn elastica(force: f64, length: f64) -> [f64; 3] {
    const STEPS: usize = 2000;
    let h = length / STEPS as f64;
    // ψ, ψ', and the integrals of cos ψ and sin ψ from the tip on.
    let rate = |[psi, bent, ..]: [f64; 4]| [bent, force * psi.cos(), psi.cos(), psi.sin()];
    let mut at = [0.0_f64; 4];
    for _ in 0..STEPS {
        let middle = |rate: [f64; 4]| std::array::from_fn(|i| at[i] + 0.5 * h * rate[i]);
        let first = rate(at);
        let second = rate(middle(rate(middle(first))));
        at = std::array::from_fn(|i| at[i] + h * second[i]);
    }
    let [psi, _, along, across] = at;
    let (sine, cosine) = psi.sin_cos();
    [psi, cosine * along + sine * across, sine * along - cosine * across]
}
