//! Rigid tools in scenes: what is refused and remarked, and what does not depend on how a tool is moved.

use mpm_scene::{Compiled, Scene, compile};
use mpm_solver::observe::{Entry, LoadStep, Observer, ObserverError, RunStart};
use mpm_solver::{Error, Summary};

/// Columns of the history by name.
#[derive(Default)]
struct Seen {
    names: Vec<String>,
    rows: Vec<Vec<Vec<f64>>>,
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
        Ok(())
    }
}

impl Seen {
    fn series(&self, column: &str, component: usize) -> Vec<f64> {
        let at = self.names.iter().position(|name| name == column).expect("a column of the history");
        self.rows.iter().map(|row| row[at][component]).collect()
    }
}

fn run(text: &str) -> (Seen, Result<Summary, Error>) {
    let mut seen = Seen::default();
    let outcome = compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut seen);
    (seen, outcome)
}

/// A block on a rough base, and a polygon over it that is pressed and tilted.
const PRESS: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 8), Uniform(from: 0, to: 2, cells: 8)]),
    basis: Cpdi1, stabilisation: Ghost(),
    materials: { "elastic": Hencky(young: 1e3, poisson: 0.3) },
    bodies: [(name: "block", material: "elastic", shape: Box(from: (0, 0), to: (2, 1.1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    tools: [(
        name: "foot", parts: [Polygon(vertices: [(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)])],
        moment_about: (0.9, 1.1), interface: (friction: 0.3), MOTION,
    )],
    schedule: (steps: 5),
    tolerance: (residual: 1e-12),
    output: (energies: true),
)"#;

#[test]
fn a_press_by_force_is_the_press_by_the_same_poses() {
    let loaded = PRESS.replace("MOTION", "motion: Loaded(free: [X, Y, Turn], force: (4, -60), moment: 3)");
    let (by_force, outcome) = run(&loaded);
    outcome.unwrap();
    let fractions = by_force.series("load_fraction", 0);
    let ramp = |values: &[f64]| {
        let knots: Vec<String> =
            fractions.iter().zip(values).map(|(at, value)| format!("({at:?}, {value:?})")).collect();
        format!("[{}]", knots.join(", "))
    };
    let moved = |component: usize, rest: f64| {
        by_force.series("tool/foot/position", component).iter().map(|x| x - rest).collect::<Vec<f64>>()
    };
    let [x, y, angle] =
        [ramp(&moved(0, 0.9)), ramp(&moved(1, 1.1)), ramp(&by_force.series("tool/foot/angle", 0))];
    let prescribed = PRESS.replace(
        "MOTION",
        &format!(
            "motion: Move(by: (1, 0), ramp: {x}, then: [(by: (0, 1), ramp: {y})], \
             turn: (centre: (0.9, 1.1), angle: 1, ramp: {angle}))"
        ),
    );
    let (by_pose, outcome) = run(&prescribed);
    outcome.unwrap();
    for (column, component, full) in [("force", 0, -4.0), ("force", 1, 60.0), ("moment", 0, -3.0)] {
        let name = format!("tool/foot/{column}");
        let (force, pose) = (by_force.series(&name, component), by_pose.series(&name, component));
        for (row, (force, pose)) in force.iter().zip(&pose).enumerate() {
            assert!(
                (force - full * fractions[row]).abs() < 1e-9 * 60.0,
                "{column} {component}, row {row}: {force}"
            );
            assert!((force - pose).abs() < 1e-9 * 60.0, "{column} {component}, row {row}: {force} and {pose}");
        }
    }
    let tilt = by_force.series("tool/foot/angle", 0);
    assert!(tilt[5].abs() > 0.1, "it tilts: {tilt:?}");
}

/// What is left over in the balance of energies at the end, over the work.
fn unbalanced(text: &str) -> f64 {
    let (seen, outcome) = run(text);
    outcome.unwrap();
    let last = |column: &str| *seen.series(column, 0).last().unwrap();
    let (dissipated, work) = (last("energy/dissipated"), last("energy/external_work"));
    assert!(dissipated > 0.1 * work, "{dissipated} of {work}");
    last("energy/unbalanced") / work
}

#[test]
fn the_energies_of_a_dragged_block_are_balanced() {
    let motion = "motion: Move(by: (0, -0.05), ramp: [(0, 0), (0.5, 1)], then: [(by: (0.2, 0), ramp: [(0.5, 0), (1, 1)])])";
    let foot = PRESS.replace("MOTION", motion);
    let plate = foot.replace(
        "Polygon(vertices: [(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)])",
        "Plane(through: (0, 1.1), normal: (0, -1))",
    );
    let of = |text: &str, steps: u32| unbalanced(&text.replace("steps: 5", &format!("steps: {steps}")));
    // What is left does not depend on the step: it is what corners of domains that are taken anew do to the springs.
    let [coarse, fine] = [10, 20].map(|steps| of(&plate, steps));
    assert!(fine.abs() < 3e-3 && (fine - coarse).abs() < 3e-4, "{coarse}, {fine}");
    let soft = of(&plate.replace("friction: 0.3", "friction: 0.3, shear_stiffness: 0.1"), 20);
    assert!(soft.abs() < 3e-3, "{soft}");
    let foot = of(&foot, 20);
    assert!(foot.abs() < 8e-3, "{foot}");
}

/// A disc that sinks into clay and moves along it.
const SINK: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 16), Uniform(from: 0, to: 1.25, cells: 10)]),
    basis: Cpdi1, domains: (control: Reshape(cells: 1)), stabilisation: Ghost(factor: 0.003),
    materials: { "clay": VonMises(young: 1e4, poisson: 0.49, undrained_strength: 20) },
    bodies: [(name: "ground", material: "clay", shape: Box(from: (0, 0), to: (2, 1)), points_per_cell: 2,
        mean_dilatation: Points)],
    supports: [
        (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
        (name: "left", region: Plane(axis: X, at: 0), fix: [X]),
        (name: "right", region: Plane(axis: X, at: 2), fix: [X]),
    ],
    tools: [(
        name: "foot", parts: [Disc(centre: (0.5, 1.2), radius: 0.2)],
        interface: (adhesion: 10, stiffness: 5, shear_stiffness: SHEAR), motion: Move(by: (0.06, -0.06)),
    )],
    schedule: (steps: 12), output: (fields: []),
)"#;

/// Where the slip turns round, a stiff surface takes many iterations for the same force.
#[test]
fn a_surface_that_is_soft_in_shear_takes_fewer_iterations() {
    let of = |shear: &str| {
        let (seen, outcome) = run(&SINK.replace("SHEAR", shear));
        outcome.unwrap();
        let iterations: f64 = seen.series("newton_iterations", 0).iter().sum();
        let last = |component| *seen.series("tool/foot/force", component).last().unwrap();
        (iterations, [last(0), last(1)])
    };
    let ((stiff, force), (soft, other)) = (of("1"), of("0.01"));
    assert!(soft < 0.7 * stiff, "{soft} and {stiff} iterations");
    let apart = (force[0] - other[0]).hypot(force[1] - other[1]) / force[0].hypot(force[1]);
    assert!(apart < 0.03, "{force:?} and {other:?}");
}

/// The tool stands apart, comes down in the second stage and slides in the third: as in one run over all of it.
#[test]
fn a_tool_that_arrives_in_a_stage_is_the_tool_that_arrives_in_time() {
    let vertices = "(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)";
    let apart = PRESS.replace(vertices, "(0.6, 1.2), (1.3, 1.2), (1.3, 1.7), (0.6, 1.7)");
    let whole = apart.replace("steps: 5", "steps: 12").replace(
        "MOTION",
        "motion: Move(by: (0, -0.15), ramp: [(0.333333333333333333, 0), (0.66666666666666666667, 1)], \
         then: [(by: (0.06, 0), ramp: [(0.66666666666666666667, 0), (1, 1)])])",
    );
    let stages = r#"stages: [(name: "wait", steps: 4), (name: "press", steps: 4), (name: "slide", steps: 4)]"#;
    let staged = apart.replace("steps: 5", stages).replace(
        "MOTION",
        r#"motion: Move(by: (0, -0.15), ramp: {"press": [(0, 0), (1, 1)]},
            then: [(by: (0.06, 0), ramp: {"slide": [(0, 0), (1, 1)]})])"#,
    );
    let ((whole, outcome), (staged, staged_outcome)) = (run(&whole), run(&staged));
    outcome.and(staged_outcome).unwrap();
    for component in [0, 1] {
        let [whole, staged] = [&whole, &staged].map(|seen| seen.series("tool/foot/force", component));
        assert_eq!(whole.len(), staged.len());
        let largest = whole.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        assert!(largest > 1.0 && whole[..5].iter().chain(&staged[..5]).all(|force| *force == 0.0), "{whole:?}");
        let apart = whole.iter().zip(&staged).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-8 * largest, "{whole:?} and {staged:?}");
    }
}

#[test]
fn a_tool_that_passes_through_a_body_ends_the_run_by_name() {
    // Half of the body's height: nothing but a tool of stiffness 1 gets there.
    let text = PRESS
        .replace("MOTION", "motion: Move(by: (0, -0.7)), rounding: 0")
        .replace("friction: 0.3", "stiffness: 1")
        .replace("steps: 5", "steps: 20, cuts: 2");
    let (seen, outcome) = run(&text);
    let error = outcome.unwrap_err().to_string();
    assert!(error.contains("contribution `tool foot`: a body has entered it by 0.5"), "{error}");
    let deepest = seen.series("tool/foot/deepest", 0);
    assert!(deepest.iter().all(|deepest| *deepest <= 0.5) && deepest.last() > Some(&0.1), "{deepest:?}");
}

#[test]
fn a_free_component_that_nothing_resists_is_named() {
    let smooth = PRESS.replace("interface: (friction: 0.3), ", "");
    // A smooth disc turns about its middle against nothing.
    let disc = smooth
        .replace(
            "Polygon(vertices: [(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)])",
            "Disc(centre: (0.9, 1.37), radius: 0.3)",
        )
        .replace("(0.9, 1.1)", "(0.9, 1.37)");
    for (text, free, named) in [(&smooth, "X, Y", "the shift along x"), (&disc, "Y, Turn", "the turn about z")]
    {
        let motion = format!("motion: Loaded(free: [{free}], force: (0, -1))");
        let error = run(&text.replace("MOTION", &motion)).1.unwrap_err().to_string();
        assert!(error.contains(&format!("nothing resists {named} of contribution `tool foot`")), "{error}");
    }
}

#[test]
fn a_tool_that_is_not_there_changes_nothing() {
    let vertices = "(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)";
    let with = PRESS
        .replace("MOTION", "motion: Rest")
        .replace(vertices, "(0.6, 1.5), (1.3, 1.5), (1.3, 1.9), (0.6, 1.9)");
    let (seen, outcome) = run(&with);
    outcome.unwrap();
    assert!(seen.series("tool/foot/force", 1).iter().all(|force| *force == 0.0));
}

#[test]
fn a_tool_thinner_than_a_cell_is_remarked() {
    let text = PRESS
        .replace("MOTION", "rounding: 0.02")
        .replace("points_per_cell: 2", "points_per_cell: 4")
        .replace("(1.3, 1.1), (1.3, 1.6)", "(0.8, 1.1), (0.8, 1.6)");
    let remarks = remarks(&text);
    assert!(remarks.iter().any(|remark| remark.contains("tool `foot` is 0.2 thick")), "{remarks:?}");
}

/// What a check remarks.
fn remarks(text: &str) -> Vec<String> {
    let Compiled::Plane(mut model) = compile(&Scene::from_ron(text).unwrap()).unwrap() else { panic!() };
    mpm_solver::estimate(&mut model).unwrap().remarks
}

#[test]
fn facets_that_will_show_are_remarked() {
    let clay = PRESS.replace("MOTION", "motion: Rest").replace(
        "Hencky(young: 1e3, poisson: 0.3)",
        "VonMises(young: 1e3, poisson: 0.3, undrained_strength: Linear(at: 1.1, value: 5, gradient: 2))",
    );
    let round = |n: u32| {
        let corner = |k: u32| {
            let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
            format!("({:?}, {:?})", 0.9 + 0.25 * cosine, 1.4 + 0.25 * sine)
        };
        let corners = (0..n).map(corner).collect::<Vec<_>>().join(", ");
        clay.replace("(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)", &corners)
            .replace("motion: Rest", "motion: Rest, rounding: 0.001")
    };
    let told = |text: &str| remarks(text).into_iter().find(|remark| remark.contains("has facets"));
    // E/8 times the turn over the strength at the top, that of the point nearest to it.
    let remark = told(&round(64)).unwrap();
    assert!(
        remark.contains("tool `foot` has facets that turn by 5.625°") && remark.contains("body `block`"),
        "{remark}"
    );
    let swing = 1e3 * 5.625_f64.to_radians() / 8.0;
    let about: f64 = remark.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(swing / 5.2 < about && about < swing / 5.0, "{about} of {swing}");
    assert_eq!(told(&clay), None, "corners are no facets");
    let elastic = round(64)
        .replace("VonMises", "Hencky")
        .replace(", undrained_strength: Linear(at: 1.1, value: 5, gradient: 2)", "");
    assert_eq!(told(&elastic), None, "what has no strength is not moved by a part of it");
}

#[test]
fn sizes_of_tools_are_told() {
    let told = |motion: &str| {
        let text = PRESS.replace("MOTION", motion);
        let Compiled::Plane(mut model) = compile(&Scene::from_ron(&text).unwrap()).unwrap() else { panic!() };
        let estimate = mpm_solver::estimate(&mut model).unwrap();
        assert_eq!(estimate.tools.len(), 1);
        (estimate.tools[0].clone(), estimate.seconds.tools)
    };
    let (tool, seconds) = told("motion: Loaded(free: [Y, Turn], force: (0, -1))");
    assert!(
        tool.starts_with(
            "`foot`: polygon; 0.7 × 0.5; free: the shift along y, the turn about z; 0.5 thick, 4.0 times"
        ),
        "{tool}"
    );
    assert!(!tool.ends_with(": 0") && seconds > 0.0, "{tool}, {seconds} s");
    let (tool, seconds) = told("motion: Rest");
    assert!(tool.contains("; at rest; ") && seconds == 0.0, "{tool}, {seconds} s");
}

#[test]
fn steps_in_which_a_tool_could_be_passed_are_cut() {
    let text = PRESS.replace("MOTION", "motion: Move(by: (-1, 0.2))").replace("steps: 5", "steps: 1");
    assert!(remarks(&text).is_empty(), "a check finds nothing wrong with that");
    let (seen, outcome) = run(&text);
    outcome.unwrap();
    assert!(seen.rows.len() > 3, "{} rows", seen.rows.len());
}

/// The points of the only body, and how much of it the points hold.
fn points_of(text: &str) -> (Vec<[f64; 2]>, f64) {
    let Compiled::Plane(model) = compile(&Scene::from_ron(text).unwrap()).unwrap() else { panic!() };
    let body = &model.bodies[0].body;
    let extents: Vec<_> = (0..body.n_points()).map(|point| body.extent(point)).collect();
    let places = extents.iter().map(|it| [it.position[0], it.position[1]]).collect();
    (places, extents.iter().map(|it| it.width * it.width).sum())
}

#[test]
fn a_body_is_cut_by_the_tool_that_stands_in_it() {
    let shape = "shape: Box(from: (0, 0), to: (2, 1.5), without: [\"foot\"])";
    let whole =
        PRESS.replace("shape: Box(from: (0, 0), to: (2, 1.1))", shape).replace("MOTION", "motion: Rest");
    let polygon = "Polygon(vertices: [(0.6, 1.1), (1.3, 1.1), (1.3, 1.6), (0.6, 1.6)])";
    // A disc is cut out exactly, as a body would be.
    let (_, volume) = points_of(&whole.replace(polygon, "Disc(centre: (1, 1), radius: 0.3)"));
    let disc = std::f64::consts::PI * 0.09;
    assert!((volume - (3.0 - disc)).abs() < 1e-3 * disc, "{volume}");
    // Of a polygon the points inside are left out.
    let (places, volume) = points_of(&whole);
    let is_inside = |x: &[f64; 2]| (0.6..1.3).contains(&x[0]) && x[1] > 1.1;
    assert!(!places.is_empty() && !places.iter().any(is_inside));
    assert!((volume - (3.0 - 0.7 * 0.4)).abs() < 0.1, "{volume}");
    let (seen, outcome) = run(&whole);
    outcome.unwrap();
    assert!(seen.series("tool/foot/deepest", 0).iter().all(|deepest| *deepest == 0.0));
    let refused = |text: String| compile(&Scene::from_ron(&text).unwrap()).map(drop).unwrap_err().to_string();
    let error = refused(whole.replace("[\"foot\"]", "[\"hand\"]"));
    assert!(
        error.contains("no body named `hand` stands before this one, and no tool has this name"),
        "{error}"
    );
    let error = refused(whole.replace(polygon, "Polygon(vertices: [(-1, -1), (3, -1), (3, 3), (-1, 3)])"));
    assert!(error.contains("all of its points stand inside the tools that it is without"), "{error}");
    let ring = "shape: Ring(inner: 0.2, outer: 0.5, centre: (1, 1), without: [\"hand\"])";
    let error = refused(whole.replace(shape, ring));
    assert!(error.contains("`without`: no tool is named `hand`"), "{error}");
}

#[test]
fn a_body_that_moves_to_a_tool_at_rest_meets_it() {
    let (seen, outcome) = run(r#"PlaneStrain(
        mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 4), Uniform(from: -0.5, to: 2, cells: 10)]),
        basis: Cpdi1, stabilisation: Ghost(),
        materials: { "elastic": Hencky(young: 1e3, poisson: 0) },
        bodies: [(name: "block", material: "elastic", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
        supports: [
            (name: "sides", region: Plane(axis: X, at: 0), fix: [X]),
            (name: "base", region: Plane(axis: Y, at: 0), displace: [(axis: Y, by: 0.06)]),
        ],
        tools: [(name: "lid", parts: [Plane(through: (0, 1.05), normal: (0, -1))], motion: Rest, interface: (stiffness: 20))],
        schedule: (steps: 1), tolerance: (residual: 1e-12),
    )"#);
    outcome.unwrap();
    // The block is shortened by 0.01 less what it enters the lid: in one load step, over a gap that it crosses.
    let force = seen.series("tool/lid/force", 1).pop().unwrap();
    assert!((9.0..10.1).contains(&force), "{force}");
}
