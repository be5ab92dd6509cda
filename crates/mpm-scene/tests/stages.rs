//! Stages of the schedule: what begins and ends with them, and what they leave as it is.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Column, Entry, Field, LoadStep, Observer, ObserverError, RunStart};

#[derive(Default)]
struct Seen {
    columns: Vec<Column>,
    rows: Vec<Vec<Entry>>,
    /// Displacements and positions of the points, row by row.
    displacements: Vec<Vec<f64>>,
    positions: Vec<Vec<f64>>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns.clone_from(&run.columns);
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.rows.push(step.row.to_vec());
        self.displacements.push(step.fields.field(Field::DISPLACEMENT));
        self.positions.push(step.fields.positions());
        Ok(())
    }
}

impl Seen {
    /// A component of a column, row by row.
    fn column(&self, name: &str, component: usize) -> Vec<f64> {
        let at = self.columns.iter().position(|column| column.name == name);
        let at = at.unwrap_or_else(|| panic!("no column {name}"));
        let entry = |row: &Vec<Entry>| match &row[at] {
            Entry::Count(values) => values[component] as f64,
            Entry::Real(values) => values[component],
        };
        self.rows.iter().map(entry).collect()
    }

    fn last(&self) -> &[f64] {
        self.displacements.last().unwrap()
    }
}

fn run(text: &str) -> Seen {
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let mut compiled = compile(&scene).unwrap_or_else(|error| panic!("{error}: {text}"));
    let mut seen = Seen::default();
    compiled.run(&mut seen).unwrap_or_else(|error| panic!("{error}: {text}"));
    seen
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, x| most.max(x.abs()))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// A beam of length 4.2 and height 0.8, clamped at the left: supports, loads and schedule are given. Its faces lie within
/// cells, and its deflection is so small that the mesh it is on does not matter.
fn beam(supports: &str, loads: &str, schedule: &str) -> String {
    format!(
        r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 5, cells: 10), Uniform(from: -1, to: 2, cells: 6)]),
    basis: Cpdi1,
    materials: {{ "steel": Hencky(young: 1e9, poisson: 0.3, density: 1) }},
    bodies: [(name: "beam", material: "steel", shape: Box(from: (0, 0.1), to: (4.2, 0.9)), points_per_cell: 2)],
    supports: [(name: "clamp", region: Plane(axis: X, at: 0), fix: [X, Y]), {supports}],
    loads: [{loads}],
    schedule: ({schedule}),
    tolerance: (residual: 1e-11),
    output: (fields: [Displacement]),
)"#
    )
}

const WEIGHT: &str = "BodyForce(acceleration: (0, -1))";

/// Part of the displacement by which two ways to one state may differ.
const SAME: f64 = 1e-10;

#[test]
fn a_stage_has_steps_of_its_own_and_says_so_in_the_history() {
    let staged = run(&beam("", WEIGHT, r#"stages: [(name: "a", steps: 2), (name: "b", steps: 4)]"#));
    assert_eq!(staged.column("load_fraction", 0), [0.0, 0.5, 1.0, 1.25, 1.5, 1.75, 2.0]);
    assert_eq!(staged.column("stage/number", 0), [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
    assert_eq!(staged.column("stage/fraction", 0), [0.0, 0.5, 1.0, 0.25, 0.5, 0.75, 1.0]);
    // The load stays what it was at the end of its stage.
    assert!(apart(&staged.displacements[2], staged.last()) < 1e-6 * largest(staged.last().to_vec()));
    let plain = run(&beam("", WEIGHT, "steps: 2"));
    assert!(!plain.columns.iter().any(|column| column.name.starts_with("stage/")));
    // The same bits, as far as both go.
    for row in 0..3 {
        assert_eq!(plain.positions[row], staged.positions[row]);
    }
}

#[test]
fn two_stages_with_half_the_load_each_are_one_with_all_of_it() {
    let whole = run(&beam("", WEIGHT, "steps: 2, predictor: Rest"));
    let half = "BodyForce(acceleration: (0, -0.5))";
    let halves = run(&beam(
        "",
        &format!(r#"{half}, {}"#, half.replace("))", r#"), active: (from: "second"))"#)),
        r#"predictor: Rest, stages: [(name: "first", steps: 1), (name: "second", steps: 1)]"#,
    ));
    let size = largest(whole.last().to_vec());
    assert!(
        apart(whole.last(), halves.last()) < SAME * size,
        "{:e}",
        apart(whole.last(), halves.last()) / size
    );
    // By the names of stages.
    let ramp = r#"BodyForce(acceleration: (0, -1), ramp: {"first": [(1, 0.5)], "second": [(1, 1)]})"#;
    let stages = r#"predictor: Rest, stages: [(name: "first", steps: 1), (name: "second", steps: 1)]"#;
    let named = run(&beam("", ramp, stages));
    assert!(apart(whole.last(), named.last()) < SAME * size);
}

#[test]
fn a_support_that_ends_lets_go_over_its_stage_or_at_once() {
    let free = run(&beam("", WEIGHT, "steps: 1"));
    let prop = |release: &str, steps: u32| {
        let prop = format!(
            r#"(name: "prop", region: Box(from: (4, 0), to: (4, 1)), fix: [Y], active: (until: "removed", release: {release}))"#
        );
        run(&beam(
            &prop,
            WEIGHT,
            &format!(r#"stages: [(name: "held", steps: 1), (name: "removed", steps: {steps})]"#),
        ))
    };
    let size = largest(free.last().to_vec());
    let (gradual, at_once) = (prop("Linear", 4), prop("AtOnce", 2));
    for seen in [&gradual, &at_once] {
        assert!(largest(seen.displacements[1].to_vec()) < 0.3 * size, "the prop holds");
        assert!(
            apart(free.last(), seen.last()) < SIMILAR * size,
            "{:e}",
            apart(free.last(), seen.last()) / size
        );
    }
    // At once: all of it in the first load step. Over the stage: a quarter in each of four.
    assert!(apart(&at_once.displacements[2], free.last()) < SIMILAR * size);
    let held = &gradual.displacements[1];
    for (k, part) in [(2, 0.25), (3, 0.5), (4, 0.75)] {
        let expected: Vec<f64> = held.iter().zip(free.last()).map(|(a, b)| a + part * (b - a)).collect();
        assert!(apart(&gradual.displacements[k], &expected) < SIMILAR * size, "at {part}");
    }
    let reaction = gradual.column("reaction/prop", 1);
    assert!(reaction[1] > 0.1 && reaction[2..].iter().all(|force| *force == 0.0), "{reaction:?}");
    // The clamp carries the weight in the end.
    let clamp = gradual.column("reaction/clamp", 1);
    assert!((clamp[5] - 3.36).abs() < 1e-6, "{clamp:?}");
}

/// Of second order in the deflection.
const SIMILAR: f64 = 1e-6;

#[test]
fn a_support_that_begins_takes_hold_where_the_body_is() {
    let prop = |displace: &str| {
        let prop = format!(
            r#"(name: "prop", region: Box(from: (4, 0), to: (4, 1)), {displace}, active: (from: "propped"))"#
        );
        run(&beam(&prop, WEIGHT, r#"stages: [(name: "bent", steps: 1), (name: "propped", steps: 2)]"#))
    };
    let held = prop("fix: [Y]");
    let size = largest(held.displacements[1].to_vec());
    assert!(apart(&held.displacements[1], held.last()) < SIMILAR * size, "it is held, not pulled back");
    assert_eq!(held.column("reaction/prop", 1)[1], 0.0);
    // Pushed by so much from there.
    let pushed = prop("displace: [(axis: Y, by: 1e-8)]");
    let moved = pushed.column("displacement/prop", 1);
    assert!(moved[1] == 0.0 && (moved[3] - 1e-8).abs() < 1e-20, "{moved:?}");
    assert!(pushed.column("reaction/prop", 1)[3] > 0.0);
}

#[test]
fn one_support_takes_over_from_another() {
    let free =
        run(&beam(r#"(name: "prop", region: Box(from: (4, 0), to: (4, 1)), fix: [Y])"#, WEIGHT, "steps: 1"));
    let seen = run(&beam(
        r#"(name: "prop", region: Box(from: (4, 0), to: (4, 1)), fix: [Y], active: (until: "second")),
           (name: "jack", region: Box(from: (4, 0), to: (4, 1)), fix: [Y], active: (from: "second"))"#,
        WEIGHT,
        r#"stages: [(name: "first", steps: 1), (name: "second", steps: 2)]"#,
    ));
    let size = largest(free.last().to_vec());
    assert!(apart(free.last(), seen.last()) < SIMILAR * size);
    let (before, after) = (seen.column("reaction/prop", 1)[1], seen.column("reaction/jack", 1)[3]);
    assert!((before - after).abs() < 1e-6 * before, "{before} {after}");
}

#[test]
fn a_load_that_ends_leaves_the_body_as_it_was() {
    for release in ["Linear", "AtOnce"] {
        let load = format!(
            r#"PointForce(body: "beam", near: (4, 0.5), force: (0, -1), active: (until: "unload", release: {release}))"#
        );
        let seen = run(&beam("", &load, r#"stages: [(name: "load", steps: 2), (name: "unload", steps: 2)]"#));
        let size = largest(seen.displacements[2].to_vec());
        assert!(size > 1e-9 && largest(seen.last().to_vec()) < SIMILAR * size);
        let half = largest(seen.displacements[3].to_vec()) / size;
        assert!((half - if release == "Linear" { 0.5 } else { 0.0 }).abs() < SIMILAR, "{half}");
    }
}

#[test]
fn displacements_count_from_their_reset() {
    let stages = r#"stages: [(name: "a", steps: 1), (name: "b", steps: 2, reset_displacements: true)]"#;
    let more = r#"BodyForce(acceleration: (0, -1)), BodyForce(acceleration: (0, -2), active: (from: "b"))"#;
    let probe =
        r#"output: (fields: [Displacement]), probes: [(name: "tip", body: "beam", points: Near(4, 0.5))]"#;
    let text = beam(r#"(name: "tip", region: Box(from: (4, 0), to: (4, 1)), fix: [X])"#, more, stages)
        .replace("output: (fields: [Displacement])", probe);
    let (reset, through) =
        (run(&text), run(&text.replace("reset_displacements: true", "reset_displacements: false")));
    // Nothing else changes.
    assert_eq!(reset.positions, through.positions);
    assert_eq!(reset.column("reaction/clamp", 1), through.column("reaction/clamp", 1));
    assert_eq!(reset.displacements[1], through.displacements[1]);
    let since: Vec<f64> = through.positions[3].iter().zip(&through.positions[1]).map(|(a, b)| a - b).collect();
    assert_eq!(reset.last(), since);
    for name in ["displacement/tip", "probe/tip/displacement"] {
        let (reset, through) = (reset.column(name, 1), through.column(name, 1));
        assert!((reset[3] - (through[3] - through[1])).abs() < 1e-15, "{name}");
    }
}

#[test]
fn ground_at_rest_does_not_move_until_it_is_loaded() {
    let text = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 10, cells: 5)]),
    basis: Cpdi1,
    materials: { "soil": MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 5, friction: 30, dilation: 0, density: 2) },
    bodies: [(name: "ground", material: "soil", shape: Box(from: (0, 0), to: (2, 10)), points_per_cell: 2,
        initial: Geostatic(surface: 10, unit_weight: 20, k0: 0.5))],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "right", region: Plane(axis: X, at: 2), fix: [X]),
    ],
    loads: [
        BodyForce(acceleration: (0, -10), ramp: [(0, 1)]),
        Traction(body: "ground", axis: Y, at: 10, resultant: (0, -10), active: (from: "load", until: "unload")),
    ],
    schedule: (stages: [(name: "geostatic", steps: 1), (name: "load", steps: 3), (name: "unload", steps: 2)]),
    output: (fields: [Displacement]),
)"#;
    let seen = run(text);
    assert!(largest(seen.displacements[1].to_vec()) < 1e-12 * 10.0);
    let settled = largest(seen.displacements[4].to_vec());
    assert!(settled > 1e-3, "{settled}");
    // It was elastic.
    assert!(largest(seen.last().to_vec()) < 1e-2 * settled, "{:e}", largest(seen.last().to_vec()));
}

#[test]
fn a_mesh_goes_on_from_where_the_stage_before_has_left_it() {
    let text = |motion: &str, schedule: &str| {
        format!(
            r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 1, cells: 1)]),
    motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: 0.4, ramp: {motion})]),
    basis: Gimp,
    materials: {{ "rubber": Hencky(young: 1e3, poisson: 0.3) }},
    bodies: [(name: "bar", material: "rubber", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2)],
    supports: [
        (name: "sides", region: Everywhere, fix: [Y]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "right", region: Plane(axis: X, at: 2), follow_mesh: [X]),
    ],
    schedule: ({schedule}),
    output: (fields: [Displacement]),
)"#
        )
    };
    let plain = run(&text("[(0, 0), (0.5, 1), (1, 0.5)]", "steps: 4, predictor: Rest"));
    let staged = run(&text(
        r#"{"out": [(1, 1)], "back": [(1, 0.5)]}"#,
        r#"predictor: Rest, stages: [(name: "out", steps: 2), (name: "still", steps: 1), (name: "back", steps: 2)]"#,
    ));
    let at = staged.column("displacement/right", 0);
    for (found, expected) in at.iter().zip([0.0, 0.2, 0.4, 0.4, 0.3, 0.2]) {
        assert!((found - expected).abs() < 1e-14, "{at:?}");
    }
    assert!(apart(plain.last(), staged.last()) < 1e-9);
}

#[test]
fn the_load_fraction_follows_the_path_in_one_of_the_stages() {
    let control = "control: Path(first: 0.25, measure: ArcLength())";
    let text = beam(
        "",
        r#"BodyForce(acceleration: (0, -1)), PointForce(body: "beam", near: (4, 0.5), force: (0, -1), active: (from: "path"))"#,
        &format!(
            r#"stages: [(name: "weight", steps: 1), (name: "path", steps: 40, {control}), (name: "after", steps: 1)]"#
        ),
    );
    let seen = run(&text);
    let expected = run(&text.replace(&format!(", {control}"), "").replace("steps: 40", "steps: 4"));
    let size = largest(expected.last().to_vec());
    assert!(apart(expected.last(), seen.last()) < SIMILAR * size);
    let fractions = seen.column("load_fraction", 0);
    assert!(
        fractions.windows(2).all(|pair| pair[0] < pair[1]) && fractions.last() == Some(&3.0),
        "{fractions:?}"
    );
}

/// The shipped scene: clay that is at rest, then carries a footing, then is let go.
#[test]
fn a_footing_comes_and_goes() {
    let path = format!("{}/../../scenes/footing_stages.ron", env!("CARGO_MANIFEST_DIR"));
    let seen = run(&std::fs::read_to_string(path).unwrap());
    assert_eq!(seen.rows.len(), 16);
    assert!(largest(seen.displacements[1].to_vec()) < 1e-12 * 5.0);
    let (force, moved) = (seen.column("reaction/footing", 1), seen.column("displacement/footing", 1));
    assert_eq!(force[1], 0.0);
    // (2 + π) s_u at the surface is the least of a strength that grows with depth; half the footing is 1 wide.
    let least = (2.0 + std::f64::consts::PI) * 10.0;
    assert!((least..1.5 * least).contains(&-force[11]), "{force:?}");
    assert!((moved[11] + 0.05).abs() < 1e-12, "{moved:?}");
    assert!(force[12..].iter().all(|force| *force == 0.0));
    // What the base carries is the weight in the end; the surface has come up, but not all the way.
    let base = seen.column("reaction/base", 1);
    assert!((base[15] - 450.0).abs() < 1e-6 && base[11] > 450.0 + 0.9 * least, "{base:?}");
    let surface = |row: usize| {
        let under = |x: &[f64]| x[0] < 1.0 && x[1] > 4.7;
        let points = seen.positions[1].chunks(3).zip(seen.displacements[row].chunks(3));
        let under: Vec<f64> = points.filter(|(x, _)| under(x)).map(|(_, u)| u[1]).collect();
        under.iter().sum::<f64>() / under.len() as f64
    };
    assert!(
        surface(11) < -0.02 && surface(15) > surface(11) && surface(15) < 0.5 * surface(11),
        "{}",
        surface(15)
    );
}
