//! Walls that hold sides of bodies off the lines of the mesh.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

/// What is seen of a run: positions at the start, and the last step.
#[derive(Default)]
struct Seen {
    columns: Vec<String>,
    row: Vec<Entry>,
    rest: Vec<f64>,
    position: Vec<f64>,
    stress: Vec<f64>,
    residuals: Vec<Vec<f64>>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.row = step.row.to_vec();
        self.position = step.fields.positions();
        if step.index == 0 {
            self.rest.clone_from(&self.position);
        }
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.residuals.push(step.residuals.to_vec());
        Ok(())
    }
}

impl Seen {
    fn real(&self, column: &str) -> Vec<f64> {
        let at = self.columns.iter().position(|name| name == column).expect("a column of the history");
        match &self.row[at] {
            Entry::Real(values) => values.clone(),
            Entry::Count(_) => panic!("{column} is a count"),
        }
    }

    /// Stresses along a direction.
    fn along(&self, [x, y]: [f64; 2]) -> Vec<f64> {
        self.stress.chunks_exact(9).map(|s| x * x * s[0] + 2.0 * x * y * s[1] + y * y * s[4]).collect()
    }
}

fn run(text: &str) -> Seen {
    let mut seen = Seen::default();
    compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut seen).unwrap();
    seen
}

fn functions(degree: u32) -> String {
    if degree == 1 { "Linear".into() } else { format!("Splines(degree: {degree})") }
}

/// The hard self-weight column of so many cells, 12.5 wide, turned in a square grid whose corner is `offset` cells below that
/// of the box round the column, and held by walls on its base and both sides.
struct Column {
    degree: u32,
    cells: u32,
    angle: f64,
    offset: [f64; 2],
}

const HEIGHT: f64 = 50.0;
const WIDTH: f64 = 12.5;
/// ρ₀ g H.
const PRESSURE: f64 = 80.0 * 10.0 * HEIGHT;

impl Column {
    /// Directions across and along the column.
    fn directions(&self) -> [[f64; 2]; 2] {
        let (sine, cosine) = self.angle.to_radians().sin_cos();
        [[cosine, sine], [-sine, cosine]]
    }

    fn size(&self) -> f64 {
        HEIGHT / f64::from(self.cells)
    }

    fn foot(&self) -> [f64; 2] {
        let [[_, sine], _] = self.directions();
        [self.offset[0] * self.size() + HEIGHT * sine, self.offset[1] * self.size()]
    }

    fn scene(&self) -> String {
        let ([across, along], h, [x, y]) = (self.directions(), self.size(), self.foot());
        let cells = |extent: f64, offset: f64| (extent / h + offset).ceil() + 3.0;
        let nx = cells(HEIGHT * across[1] + WIDTH * across[0], self.offset[0]);
        let ny = cells(HEIGHT * across[0] + WIDTH * across[1], self.offset[1]);
        let wall = |side: &str, at: f64, normal: [f64; 2], sign: f64| {
            let through = [x + at * across[0], y + at * across[1]];
            format!(
                r#"(name: "{side}", body: "column", side: "{side}", surface: Plane(through: ({:?}, {:?}), normal: ({:?}, {:?})))"#,
                through[0],
                through[1],
                sign * normal[0],
                sign * normal[1]
            )
        };
        let walls = [
            wall("bottom", 0.0, along, 1.0),
            wall("left", 0.0, across, 1.0),
            wall("right", WIDTH, across, -1.0),
        ];
        format!(
            r#"PlaneStrain(
                mesh: Box(axes: [Uniform(from: 0, to: {:?}, cells: {nx}), Uniform(from: 0, to: {:?}, cells: {ny})], functions: {}),
                basis: Cpdi2q, stabilisation: Ghost(), materials: {{ "soil": Hencky(young: 1e4, poisson: 0, density: 80) }},
                bodies: [(name: "column", material: "soil", tiling: Shape, points_per_cell: 2,
                    shape: Box(from: ({x:?}, {y:?}), to: ({:?}, {:?}), turned: {:?}))],
                walls: [{}], loads: [BodyForce(acceleration: ({:?}, {:?}))],
                schedule: (steps: 40), output: (fields: [CauchyStress]),
            )"#,
            nx * h,
            ny * h,
            functions(self.degree),
            x + WIDTH,
            y + HEIGHT,
            self.angle,
            walls.join(", "),
            -10.0 * along[0],
            -10.0 * along[1],
        )
    }

    /// Mean error of the stress along the column, and the largest stress across it, over ρ₀ g H; the largest gap.
    fn errors(&self) -> [f64; 3] {
        let (seen, [across, along], [x, y]) = (run(&self.scene()), self.directions(), self.foot());
        let depth =
            seen.rest.chunks_exact(3).map(|at| HEIGHT - ((at[0] - x) * along[0] + (at[1] - y) * along[1]));
        let errors = seen.along(along).into_iter().zip(depth).map(|(s, depth)| (s + 800.0 * depth).abs());
        let errors: Vec<f64> = errors.collect();
        let lateral = seen.along(across).into_iter().map(f64::abs).fold(0.0, f64::max);
        let gaps = ["bottom", "left", "right"].map(|wall| seen.real(&format!("wall/{wall}/gap"))[0]);
        [
            errors.iter().sum::<f64>() / (errors.len() as f64 * PRESSURE),
            lateral / PRESSURE,
            gaps.into_iter().fold(0.0, f64::max),
        ]
    }
}

/// Columns, with the error, the largest gap and the largest lateral stress of an independent implementation.
const COLUMNS: &[(Column, [f64; 3])] = &[
    (Column { degree: 1, cells: 4, angle: 30.0, offset: [2.137, 2.291] }, [4.8845e-3, 1.2912e-2, 1.4323e-2]),
    (Column { degree: 1, cells: 8, angle: 30.0, offset: [2.137, 2.291] }, [3.4165e-3, 6.4479e-3, 1.0053e-2]),
    (Column { degree: 2, cells: 4, angle: 30.0, offset: [2.137, 2.291] }, [3.8448e-4, 1.2506e-2, 4.1696e-4]),
    (Column { degree: 2, cells: 8, angle: 30.0, offset: [2.137, 2.291] }, [1.4913e-4, 6.2534e-3, 1.8605e-4]),
    (Column { degree: 2, cells: 16, angle: 30.0, offset: [2.137, 2.291] }, [2.2955e-5, 3.1254e-3, 4.1606e-5]),
    (Column { degree: 3, cells: 4, angle: 30.0, offset: [2.137, 2.291] }, [5.3912e-5, 1.2500e-2, 2.8741e-5]),
    (Column { degree: 3, cells: 8, angle: 30.0, offset: [2.137, 2.291] }, [1.7603e-5, 6.2503e-3, 3.9231e-5]),
    (Column { degree: 2, cells: 8, angle: 17.0, offset: [2.41, 2.77] }, [2.4028e-4, 6.2519e-3, 1.4255e-4]),
    (Column { degree: 2, cells: 8, angle: 45.0, offset: [2.2, 2.6] }, [1.0141e-4, 6.2511e-3, 1.5692e-4]),
];

#[test]
fn inclined_columns_are_those_of_an_independent_implementation() {
    for (column, [error, gap, lateral]) in COLUMNS {
        let found = column.errors();
        let Column { degree, cells, angle, .. } = column;
        let named = format!("degree {degree}, {cells} cells, {angle} degrees: {found:?}");
        assert!((0.85..1.05).contains(&(found[0] / error)), "{named}, expected {error:e}");
        assert!(found[1] < 1.05 * lateral, "{named}, expected {lateral:e}");
        assert!((found[2] / gap - 1.0).abs() < 0.01, "{named}, expected {gap:e}");
    }
}

#[test]
fn columns_at_any_angle() {
    for step in 0..13 {
        let angle = 7.0 * f64::from(step);
        let [error, ..] = Column { degree: 2, cells: 8, angle, offset: [2.137, 2.291] }.errors();
        assert!(error < 6e-4, "{angle} degrees: {error:e}");
    }
}

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

/// A wall that turns and moves carries a body with it without stress.
#[test]
fn a_body_is_carried_without_stress() {
    let motion = "motion: Move(by: (0.3, 0.5), turn: (centre: (1, 0), angle: 75))";
    let hand = format!(r#"(name: "hand", body: "block", side: "left", hold: All, {motion})"#);
    let seen = run(&square(1, &hand).replace("steps: 3", "steps: 15"));
    let worst = seen.stress.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!(worst < 1e-9, "{worst:e}");
    let rest = [seen.rest[0] - 1.0, seen.rest[1]];
    let (sine, cosine) = 75_f64.to_radians().sin_cos();
    let expected = [1.3 + cosine * rest[0] - sine * rest[1], 0.5 + sine * rest[0] + cosine * rest[1]];
    let apart = (seen.position[0] - expected[0]).hypot(seen.position[1] - expected[1]);
    assert!(apart < 1e-9, "{apart:e}");
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
