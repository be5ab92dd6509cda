//! What results show of contact: fields of points, adhesion by their strength, and surfaces of tools.

use mpm_scene::{NoFiles, Scene, compile, tool_surfaces};
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

/// Columns of the history and fields of points by name, at every load step.
#[derive(Default)]
struct Seen {
    names: Vec<String>,
    fields: Vec<Field>,
    rows: Vec<Vec<Vec<f64>>>,
    of_points: Vec<Vec<Vec<f64>>>,
    positions: Vec<Vec<f64>>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.names = run.columns.iter().map(|column| column.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        let reals = |entry: &Entry| match entry {
            Entry::Count(values) => values.iter().map(|count| *count as f64).collect(),
            Entry::Real(values) => values.clone(),
        };
        self.rows.push(step.row.iter().map(reals).collect());
        self.of_points.push(self.fields.iter().map(|&field| step.fields.field(field)).collect());
        self.positions.push(step.fields.positions());
        Ok(())
    }
}

impl Seen {
    fn of(text: &str) -> Self {
        let scene = Scene::from_ron(text).unwrap();
        let mut compiled = compile(&scene).unwrap_or_else(|error| panic!("{error}"));
        let mut seen = Self { fields: compiled.fields(scene.output()).unwrap(), ..Self::default() };
        compiled.run(&mut seen).unwrap();
        seen
    }

    fn history(&self, column: &str, row: usize) -> &[f64] {
        let at = self.names.iter().position(|name| name == column).expect("a column of the history");
        &self.rows[row][at]
    }

    fn field(&self, name: &str, row: usize) -> &[f64] {
        let at = self.fields.iter().position(|field| field.name() == name).expect("a field");
        &self.of_points[row][at]
    }
}

/// A block that a plane presses by 0.05, then slides along it by 0.2.
const SLIDE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 8), Uniform(from: 0, to: 1.25, cells: 5)]),
    basis: Cpdi1, stabilisation: Ghost(),
    materials: { "elastic": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "block", material: "elastic", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [Y]), SIDES],
    tools: [(
        name: "plate", parts: [Plane(through: (0, 1), normal: (0, -1))], INTERFACE
        motion: Move(by: (0, -0.05), ramp: [(0, 0), (0.5, 1)], then: [(by: (0.2, 0), ramp: [(0.5, 0), (1, 1)])]),
    ) MORE],
    schedule: (steps: 8),
    tolerance: (residual: 1e-12),
    output: (fields: [ContactForce, ContactGap, ContactSlip]),
)"#;

#[test]
fn force_gap_and_slip_of_points_are_those_of_the_tool() {
    // Between smooth sides the block is pressed evenly.
    let sides = r#"(name: "left", region: Plane(axis: X, at: 0), fix: [X]), (name: "right", region: Plane(axis: X, at: 2), fix: [X])"#;
    let seen = Seen::of(&SLIDE.replace("INTERFACE", "").replace("MORE", "").replace("SIDES", sides));
    let last = seen.rows.len() - 1;
    for row in 0..=last {
        let (force, gap) = (seen.field("contact_force", row), seen.field("contact_gap", row));
        for i in 0..2 {
            let sum: f64 = force.iter().skip(i).step_by(3).sum();
            let of_tool = seen.history("tool/plate/force", row)[i];
            assert!((sum + of_tool).abs() < 1e-10, "row {row}: {sum} and {of_tool}");
        }
        let least = gap.iter().copied().fold(f64::INFINITY, f64::min);
        let deepest = seen.history("tool/plate/deepest", row)[0];
        assert!((least + 0.125 * deepest).abs() < 1e-12, "row {row}: {least} and {deepest} widths");
        // Points that the tool presses are those inside it.
        for (point, gap) in gap.iter().enumerate() {
            assert_eq!(force[3 * point + 1] < 0.0, *gap < 0.0 && row > 0, "row {row}, point {point}");
        }
    }
    // At rest the lowest points, 2 x 2 in cells of 0.25, reach up to 0.125.
    let at_rest = seen.field("contact_gap", 0).iter().copied().fold(0.0, f64::max);
    assert!((at_rest - 0.875).abs() < 1e-12, "{at_rest}");
    // Nothing holds the block along the plate: all that touches slips as far as the plate goes.
    let (middle, end) = (seen.field("contact_slip", last / 2), seen.field("contact_slip", last));
    let touching = |point: &usize| seen.field("contact_gap", last)[*point] < 0.0;
    let slipped: Vec<f64> = (0..end.len()).filter(touching).map(|point| end[point] - middle[point]).collect();
    assert!(slipped.len() == 16 && slipped.iter().all(|slip| (slip - 0.2).abs() < 1e-9), "{slipped:?}");
    assert!(end.iter().filter(|slip| **slip > 0.0).count() == 16);
}

#[test]
fn fields_of_several_tools_are_joined() {
    let more =
        r#", (name: "wall", parts: [Plane(through: (2, 0), normal: (-1, 0))], motion: Move(by: (-0.05, 0)))"#;
    let text = SLIDE.replace("INTERFACE", "interface: (friction: 0.2),").replace("MORE", more);
    let seen =
        Seen::of(&text.replace("SIDES", r#"(name: "left", region: Plane(axis: X, at: 0), fix: [X, Y])"#));
    let last = seen.rows.len() - 1;
    let force = seen.field("contact_force", last);
    for i in 0..2 {
        let sum: f64 = force.iter().skip(i).step_by(3).sum();
        let tools: f64 =
            ["plate", "wall"].map(|name| seen.history(&format!("tool/{name}/force"), last)[i]).iter().sum();
        assert!((sum + tools).abs() < 1e-9 && tools.abs() > 1.0, "{sum} and {tools}");
    }
    // A point at the wall's foot is far from the plate.
    let (at, gap) = (&seen.positions[0], seen.field("contact_gap", 0));
    let foot = (0..gap.len()).find(|point| at[3 * point] > 1.9 && at[3 * point + 1] < 0.1).unwrap();
    assert!(gap[foot].abs() < 1e-12, "{}", gap[foot]);
}

#[test]
fn scenes_without_tools_have_no_such_fields() {
    let text = SLIDE.replace("INTERFACE", "").replace("MORE", "").replace("SIDES", "");
    let (from, to) = (text.find("tools: [").unwrap(), text.find("schedule").unwrap());
    let without = text.replace(&text[from..to], "");
    let error = compile(&Scene::from_ron(&without).unwrap()).err().expect("refused").to_string();
    assert!(error.contains("no point has a field `ContactForce`, expected one of Displacement,"), "{error}");
}

/// Clay of strength 5 + 2 z at the depth z, along whose side a wall slides down.
const WALL: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 5), Uniform(from: 0, to: 2, cells: 10)]),
    basis: Cpdi1, stabilisation: Ghost(factor: 0.003),
    materials: { "clay": LAW },
    bodies: [(name: "ground", material: "clay", shape: Box(from: (0, 0), to: (1, 2)), points_per_cell: 2,
        mean_dilatation: Points)],
    supports: [
        (name: "side", region: Plane(axis: X, at: 1), fix: [X, Y]),
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]), (name: "top", region: Plane(axis: Y, at: 2), fix: [Y]),
    ],
    tools: [(
        name: "wall", parts: [Plane(through: (0, 0), normal: (1, 0))], motion: Move(by: (0, -0.05)),
        interface: (adhesion_factor: 0.5, separates: false),
    )],
    schedule: (steps: 5),
    output: (fields: []),
)"#;

#[test]
fn adhesion_is_a_part_of_the_strength_of_each_point() {
    // ½ ∫ (5 + 2 z) dz over a depth of 2.
    for law in ["VonMises", "Tresca"] {
        let clay = format!(
            "{law}(young: 2000, poisson: 0.49, undrained_strength: Linear(at: 2, value: 5, gradient: 2))"
        );
        let seen = Seen::of(&WALL.replace("LAW", &clay));
        let force = seen.history("tool/wall/force", seen.rows.len() - 1)[1];
        assert!((force / 7.0 - 1.0).abs() < 2e-3, "{law}: {force}");
    }
}

#[test]
fn adhesion_by_a_strength_that_is_not_there_is_refused() {
    let refused = |law: &str, interface: &str| {
        let text = WALL.replace("LAW", law).replace("adhesion_factor: 0.5", interface);
        compile(&Scene::from_ron(&text).unwrap()).err().expect("refused").to_string()
    };
    let clay = "VonMises(young: 2000, poisson: 0.49, undrained_strength: 5)";
    let error = refused("Hencky(young: 2000, poisson: 0.49)", "adhesion_factor: 0.5");
    assert!(
        error
            .contains("tools[0].interface.adhesion_factor: the law of body `ground` has no undrained strength"),
        "{error}"
    );
    let error = refused(
        "MohrCoulomb(young: 2000, poisson: 0.3, cohesion: 5, friction: 30, dilation: 0)",
        "adhesion_factor: 0.5",
    );
    assert!(error.contains("has no undrained strength"), "{error}");
    let error = refused(clay, "adhesion_factor: 1.5");
    assert!(error.contains("adhesion_factor is 1.5, expected between 0 and 1"), "{error}");
    let error = refused(clay, "adhesion: 1, adhesion_factor: 0.5");
    assert!(error.contains("stands beside an adhesion, expected one of the two"), "{error}");
}

/// A screw above a block, which turns by 20° and goes down.
const SCREW: &str = r#"Solid(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 3, cells: 3)]),
    basis: Cpdi1, stabilisation: Ghost(),
    materials: { "a": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "block", material: "a", shape: Box(from: (0, 0, 0), to: (2, 2, 1)), points_per_cell: 4)],
    supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z])],
    tools: [
        (name: "pile", rounding: 0.01, moment_about: (1, 0.5, 1), motion: Screw(axis: Z, through: (1, 1), angle: -20, advance: -0.02),
            parts: [Helix(axis: Z, start: (1, 1, 1.5), radii: (0.3, 0.8), pitch: 0.9, turns: 1, thickness: 0.7)]),
    ],
    schedule: (steps: 2),
    output: (fields: []),
)"#;

#[test]
fn surfaces_of_tools_stand_where_the_tools_do() {
    let scene = Scene::from_ron(SCREW).unwrap();
    let surfaces = tool_surfaces(&scene, &NoFiles).unwrap();
    assert_eq!(surfaces, tool_surfaces(&scene, &NoFiles).unwrap());
    let [surface] = &surfaces[..] else { panic!("one tool") };
    let seen = Seen::of(SCREW);
    let row = seen.rows.len() - 1;
    let placed =
        surface.placed(seen.history("tool/pile/position", row), seen.history("tool/pile/rotation", row));
    let (sine, cosine) = (-20_f64).to_radians().sin_cos();
    for (rest, x) in surface.vertices.iter().zip(&placed) {
        let arm = [rest[0] - 1.0, rest[1] - 1.0];
        let expected =
            [1.0 + cosine * arm[0] - sine * arm[1], 1.0 + sine * arm[0] + cosine * arm[1], rest[2] - 0.02];
        let apart = expected.iter().zip(x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-14, "{expected:?} {x:?}");
    }
    // Closed, and fine enough for a thread: every edge is one of two triangles, 24 sections a turn.
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for facet in &surface.facets {
        edges.extend((0..3).map(|k| [facet[k], facet[(k + 1) % 3]]));
    }
    edges.sort_unstable();
    assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()));
    assert!(surface.vertices.len() >= 24 * 14);
}

#[test]
fn adhesion_acts_on_what_touches_and_on_stairs() {
    // A plate that slides over the block at a height in widths of a domain, and the force per length of its adhesion.
    let drag = |height: f64, shape: &str| {
        let sides = r#"(name: "left", region: Plane(axis: X, at: 0), fix: [X])"#;
        let text = SLIDE
            .replace("INTERFACE", "interface: (adhesion: 2),")
            .replace("MORE", "")
            .replace("SIDES", sides)
            .replace("by: (0, -0.05)", "by: (0, 0)")
            .replace("through: (0, 1)", &format!("through: (0, {})", 1.0 + 0.125 * height))
            .replace("shape: Box(from: (0, 0), to: (2, 1))", shape);
        let seen = Seen::of(&text);
        seen.history("tool/plate/force", seen.rows.len() - 1)[0].abs()
    };
    let block = "shape: Box(from: (0, 0), to: (2, 1))";
    assert_eq!(drag(0.5, block), 0.0);
    assert!((drag(0.1, block) / (2.0 * 2.0) - 1.0).abs() < 1e-2, "{}", drag(0.1, block));
    // One that is cut along the plate has its stairs there.
    let stairs = r#"shape: Box(from: (0, 0), to: (2, 1.25), without: ["plate"])"#;
    assert!((drag(0.0, stairs) / (2.0 * 2.0) - 1.0).abs() < 1e-2, "{}", drag(0.0, stairs));
    assert!((drag(0.5, stairs) / (2.0 * 2.0) - 1.0).abs() < 1e-2, "{}", drag(0.5, stairs));
}
