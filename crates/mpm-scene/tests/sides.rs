//! Loads on sides of bodies, which act on boundary markers.

use mpm_scene::{Scene, compile};
use mpm_solver::observe::{Entry, Field, LoadStep, Observer, ObserverError, RunStart};

/// What the history calls LU.
const LU: u64 = 2;

/// What is seen of the last load step, and how many iterations each took.
#[derive(Default)]
struct Seen {
    columns: Vec<String>,
    row: Vec<Entry>,
    position: Vec<f64>,
    stress: Vec<f64>,
    outlines: Vec<Vec<[f64; 3]>>,
    iterations: Vec<u64>,
}

impl Observer for Seen {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.columns = run.columns.iter().map(|it| it.name.clone()).collect();
        Ok(())
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.row = step.row.to_vec();
        self.position = step.fields.positions();
        self.stress = step.fields.field(Field::CAUCHY_STRESS);
        self.outlines = step.fields.outlines();
        if let Some(Entry::Count(count)) = self.entry("newton_iterations") {
            self.iterations.push(count[0]);
        }
        Ok(())
    }
}

impl Seen {
    fn entry(&self, column: &str) -> Option<&Entry> {
        self.columns.iter().position(|name| name == column).map(|at| &self.row[at])
    }

    fn real(&self, column: &str) -> Vec<f64> {
        match self.entry(column) {
            Some(Entry::Real(values)) => values.clone(),
            other => panic!("{column}: {other:?}"),
        }
    }
}

fn run(text: &str) -> Seen {
    let mut seen = Seen::default();
    compile(&Scene::from_ron(text).unwrap()).unwrap().run(&mut seen).unwrap();
    seen
}

/// A quarter of a thick cylinder, R 5 to 10, in tiles along circles, under a pressure of 60 inside.
fn cylinder(degree: u32, cells: u32, basis: &str) -> String {
    let functions = if degree == 1 { "Linear".to_owned() } else { format!("Splines(degree: {degree})") };
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 12, cells: {cells}), Uniform(from: 0, to: 12, cells: {cells})], functions: {functions}),
            basis: {basis}, stabilisation: Ghost(), materials: {{ "steel": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [(name: "tube", material: "steel", shape: Ring(inner: 5, outer: 10), points_per_cell: 2, tiling: Shape, symmetry: [X, Y])],
            supports: [(name: "x", region: Plane(axis: X, at: 0), fix: [X]), (name: "y", region: Plane(axis: Y, at: 0), fix: [Y])],
            loads: [Pressure(body: "tube", side: "inner", value: 60)],
            schedule: (steps: 5), tolerance: (residual: 1e-10),
        )"#
    )
}

/// Mean radius of the inner circle: of the corners of domains on it.
fn inner_radius(seen: &Seen) -> f64 {
    let radii = seen.outlines.iter().flatten().map(|x| x[0].hypot(x[1]));
    let inner: Vec<f64> = radii.filter(|radius| *radius < 5.8).collect();
    inner.iter().sum::<f64>() / inner.len() as f64
}

/// Inner radius of the one-dimensional solution at a pressure of 60.
const INNER: f64 = 5.709_179_455;

#[test]
fn a_cylinder_widens_under_pressure_as_in_one_dimension() {
    let error = |degree, cells| {
        let seen = run(&cylinder(degree, cells, "Cpdi2q"));
        assert!(seen.iterations.iter().sum::<u64>() <= 15, "{:?}", seen.iterations);
        ((inner_radius(&seen) - INNER) / (INNER - 5.0)).abs()
    };
    let [coarse, fine] = [12, 24].map(|cells| error(2, cells));
    println!("{coarse:e} {fine:e} {:e} {:e}", error(1, 12), error(3, 12));
    assert!(coarse < 3e-5 && fine < 6e-6 && (coarse / fine).log2() > 1.9, "{coarse:e} {fine:e}");
    assert!(error(1, 12) < 3e-3 && error(3, 12) < 3e-5);
}

#[test]
fn supports_carry_the_pressure_under_every_basis() {
    for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"] {
        let seen = run(&cylinder(1, 12, basis));
        let carried = [seen.real("reaction/x")[0], seen.real("reaction/y")[1]];
        // The pressure pushes with p times what the side is long across the direction.
        let ends = carried.map(|force| -force / 60.0);
        assert!((ends[0] - ends[1]).abs() < 1e-4 * INNER, "{basis}: {ends:?}");
        assert!((ends[0] - INNER).abs() < 0.02 * INNER, "{basis}: {ends:?}");
    }
}

/// A plate that is turned in its mesh and slides on walls at its left and its base.
fn plate(basis: &str, functions: &str, loads: &str) -> String {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: -1.07, to: 4, cells: 9), Uniform(from: -0.6, to: 4, cells: 8)], functions: {functions}),
            basis: {basis}, stabilisation: Ghost(), materials: {{ "steel": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [(name: "plate", material: "steel", shape: Box(from: (1, 0), to: (3, 2), turned: 30), points_per_cell: 2, tiling: Shape)],
            walls: [
                (name: "left", body: "plate", side: "left", exact: true, surface: Plane(through: (1, 0), normal: ({cosine:?}, {sine:?}))),
                (name: "base", body: "plate", side: "bottom", exact: true, surface: Plane(through: (1, 0), normal: ({:?}, {cosine:?}))),
            ],
            loads: [{loads}], schedule: (steps: 2), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
        )"#,
        -sine
    )
}

/// Tractions along a turned plate, dead or as a tension that follows, are a patch test: the stress is the same everywhere.
#[test]
fn a_turned_plate_is_pulled_evenly() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let pull = [40.0 * cosine, 40.0 * sine];
    let dead = format!(r#"Traction(body: "plate", side: "right", value: ({:?}, {:?}))"#, pull[0], pull[1]);
    let follows = r#"Pressure(body: "plate", side: "right", value: -40)"#.to_owned();
    for (load, is_dead) in [(dead, true), (follows, false)] {
        for functions in ["Linear", "Splines(degree: 2)"] {
            let seen = run(&plate("Cpdi2q", functions, &load));
            let along = seen
                .stress
                .chunks_exact(9)
                .map(|s| cosine * cosine * s[0] + 2.0 * sine * cosine * s[1] + sine * sine * s[4]);
            let along: Vec<f64> = along.collect();
            let mean = along.iter().sum::<f64>() / along.len() as f64;
            let apart = along.iter().map(|s| (s - mean).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9 * 40.0, "{functions}: {apart:e} of {mean}");
            // A force per length at rest is more per length of a plate that has become thinner.
            assert!(if is_dead { mean > 40.5 } else { (mean - 40.0).abs() < 1e-9 }, "{functions}: {mean}");
        }
    }
}

#[test]
fn sides_that_are_not_there_are_refused() {
    let refused = |loads: &str| {
        let text = plate("Cpdi2q", "Linear", loads);
        compile(&Scene::from_ron(&text).unwrap()).err().expect("it is refused").to_string()
    };
    let unknown = refused(r#"Pressure(body: "plate", side: "lid", value: 1)"#);
    assert!(unknown.contains("has no side `lid`; it has: left, right, bottom, top"), "{unknown}");
    let both = refused(r#"Traction(body: "plate", side: "left", axis: X, at: 0, value: (1, 0))"#);
    assert!(both.contains("expected the side or the plane"), "{both}");
    let neither = refused(r#"Traction(body: "plate", value: (1, 0))"#);
    assert!(neither.contains("expected `axis` and `at`"), "{neither}");
}

/// Bodies that are tiled along themselves, pressed equally all round, are a patch test: the stress is the same everywhere, because
/// points have the volumes of their polygons and markers stand at the corners of these.
#[test]
fn tiled_bodies_are_pressed_evenly() {
    for (shape, sides) in [
        ("Box(from: (0.9, 0.4), to: (2.9, 2.4), turned: 20)", &["left", "right", "bottom", "top"][..]),
        ("Ring(centre: (2, 2), inner: 0.6, outer: 1.7)", &["inner", "outer"]),
        (
            "Polygon(vertices: [(0.6, 0.7), (3.1, 0.9), (2.6, 3.2), (0.8, 2.4)])",
            &["edge 0", "edge 1", "edge 2", "edge 3"],
        ),
        ("Cylinder(centre: (2, 2), radius: 1.7)", &["outer"]),
        ("Tube(centre: (2, 2), inner: 0.6, outer: 1.7)", &["inner", "outer"]),
    ] {
        for functions in ["Linear", "Splines(degree: 2)"] {
            let loads = sides.iter().map(|side| format!(r#"Pressure(body: "b", side: "{side}", value: 30)"#));
            let seen = run(&format!(
                r#"PlaneStrain(
                    mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 8), Uniform(from: 0, to: 4, cells: 8)], functions: {functions}),
                    basis: Cpdi2q, unheld_motion: Zero, stabilisation: Ghost(),
                    materials: {{ "steel": Hencky(young: 1000, poisson: 0.3) }},
                    bodies: [(name: "b", material: "steel", shape: {shape}, points_per_cell: 2, tiling: Shape)],
                    loads: [{}], schedule: (steps: 2), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
                )"#,
                loads.collect::<Vec<_>>().join(", ")
            ));
            let worst = seen.stress.chunks_exact(9).fold(0.0, |worst: f64, s| {
                worst.max((s[0] + 30.0).abs()).max((s[4] + 30.0).abs()).max(s[1].abs())
            });
            assert!(worst < 1e-8, "{shape}, {functions}: {worst:e}");
        }
    }
}

/// The same of bodies in space, which stand askew in the mesh.
#[test]
fn turned_bodies_in_space_are_pressed_evenly() {
    for (shape, turned, sides) in [
        ("Cylinder(centre: (2, 2), radius: 1.7, extent: (0.4, 2.7))", "", &["outer", "bottom", "top"][..]),
        (
            "Tube(centre: (2, 2), inner: 0.6, outer: 1.7, extent: (1, 2))",
            "turned: (axis: (2, 1, 0), about: (2, 2, 1.5), angle: 35),",
            &["inner", "outer", "bottom", "top"],
        ),
        (
            "Box(from: (1, 1.1, 0.8), to: (2.9, 2.7, 2.1), turned: 20)",
            "turned: (axis: (0, -0.3, 0.1), about: (2, 2, 1.5), angle: 17),",
            &["left", "right", "front", "back", "bottom", "top"],
        ),
    ] {
        let loads = sides.iter().map(|side| format!(r#"Pressure(body: "b", side: "{side}", value: 30)"#));
        let seen = run(&format!(
            r#"Solid(
                mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 3, cells: 3)]),
                basis: Cpdi2Hexahedron, unheld_motion: Zero, stabilisation: Ghost(),
                materials: {{ "steel": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "b", material: "steel", shape: {shape}, {turned} points_per_cell: 2, tiling: Shape)],
                loads: [{}], schedule: (steps: 2), tolerance: (residual: 1e-12), output: (fields: [CauchyStress]),
            )"#,
            loads.collect::<Vec<_>>().join(", ")
        ));
        let apart = seen.stress.chunks_exact(9).fold(0.0, |worst: f64, s| {
            let shear = s[1].abs().max(s[2].abs()).max(s[5].abs());
            [s[0], s[4], s[8]].iter().fold(worst.max(shear), |worst, s| worst.max((s + 30.0).abs()))
        });
        assert!(apart < 1e-7, "{shape}: {apart:e}");
    }
}

/// The tangent of a pressure in space is exact where edges of its side are free, too: Newton's method converges quadratically. It
/// stays symmetric where supports hold the edges.
#[test]
fn newtons_method_is_quadratic_where_edges_are_free() {
    let pressed = |supports: &str, loads: &str| {
        let seen = run(&format!(
            r#"Solid(
                mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4), Uniform(from: 0, to: 2, cells: 4)]),
                basis: Cpdi2Hexahedron, stabilisation: Ghost(),
                materials: {{ "steel": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "b", material: "steel", shape: Box(from: (0, 0, 0), to: (1, 1, 1.2)), points_per_cell: 2)],
                supports: [(name: "base", region: Plane(axis: Z, at: 0), fix: [X, Y, Z]), {supports}],
                loads: [Pressure(body: "b", side: "top", value: 300), {loads}],
                schedule: (steps: 2), tolerance: (residual: 1e-11),
            )"#
        ));
        let Some(Entry::Count(factorization)) = seen.entry("factorization") else { panic!("none recorded") };
        (factorization[0] == LU, seen.iterations.clone())
    };
    let (is_unsymmetric, iterations) = pressed("", r#"Pressure(body: "b", side: "right", value: 150)"#);
    assert!(is_unsymmetric && iterations.iter().all(|it| *it <= 6), "{iterations:?}");
    let side = |name: &str, axis: &str, at: u32| {
        format!("(name: \"{name}\", region: Plane(axis: {axis}, at: {at}), fix: [{axis}])")
    };
    let held = [side("left", "X", 0), side("right", "X", 1), side("front", "Y", 0), side("back", "Y", 1)];
    assert!(!pressed(&held.join(", "), "").0);
}

/// Corners of CPDI2q domains move as markers do, so that a traction on a plane is the same at markers. Those of CPDI1 do not, and
/// with ghost faces both still agree.
#[test]
fn a_traction_is_the_same_on_a_plane_and_at_markers() {
    let bent = |basis: &str, ghost: &str, load: &str| {
        run(&format!(
            r#"PlaneStrain(
                mesh: Box(axes: [Uniform(from: 0, to: 5.5, cells: 11), Uniform(from: -4.65, to: 0.85, cells: 11)]),
                basis: {basis}, {ghost} materials: {{ "steel": Hencky(young: 12e3, poisson: 0.2) }},
                bodies: [(name: "beam", material: "steel", shape: Box(from: (0, -0.5), to: (5, 0.5)), points_per_cell: 3)],
                supports: [(name: "root", region: Plane(axis: X, at: 0), fix: [X, Y])],
                loads: [Traction(body: "beam", {load}, resultant: (0, -300))],
                schedule: (steps: 10),
            )"#
        ))
        .position
    };
    let ghost = "stabilisation: Ghost(),";
    for (basis, ghost, most) in
        [("Cpdi2q", "", 1e-4), ("Cpdi2q", ghost, 1e-4), ("Cpdi1", ghost, 1e-3), ("Gimp", ghost, 1e-3)]
    {
        let on_plane = bent(basis, ghost, "axis: X, at: 5");
        let at_markers = bent(basis, ghost, r#"side: "right""#);
        let apart = on_plane.iter().zip(&at_markers).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let lowest = on_plane.iter().copied().fold(0.0, f64::min);
        assert!(lowest < -2.0 && apart < most && apart > 0.0, "{basis} {ghost}: {lowest}, {apart:e}");
    }
}

/// Polygons and discs that cells cut have outlines of their own: a pressure all round leaves them in place.
#[test]
fn outlines_that_cells_cut_are_closed() {
    let text = |shape: &str, sides: &[&str]| {
        let loads = sides.iter().map(|side| format!(r#"Pressure(body: "b", side: "{side}", value: 30)"#));
        format!(
            r#"PlaneStrain(
                mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 8), Uniform(from: 0, to: 4, cells: 8)]),
                basis: Cpdi1, unheld_motion: Zero, stabilisation: Ghost(),
                materials: {{ "steel": Hencky(young: 1000, poisson: 0.3) }},
                bodies: [(name: "b", material: "steel", shape: {shape}, points_per_cell: 3)],
                loads: [{}], schedule: (steps: 2), output: (fields: [CauchyStress]),
            )"#,
            loads.collect::<Vec<_>>().join(", ")
        )
    };
    for (shape, sides) in [
        ("Cylinder(centre: (2, 2), radius: 1.4)", &["outer"][..]),
        ("Polygon(vertices: [(0.6, 0.7), (3.1, 0.9), (1.9, 3.2)])", &["edge 0", "edge 1", "edge 2"]),
        ("Polygon(vertices: [(0.6, 0.7), (1.9, 3.2), (3.1, 0.9)])", &["edge 0", "edge 1", "edge 2"]),
    ] {
        let seen = run(&text(shape, sides));
        let mean = seen.stress.chunks_exact(9).map(|s| 0.5 * (s[0] + s[4])).sum::<f64>()
            / (seen.stress.len() / 9) as f64;
        assert!((mean + 30.0).abs() < 1.0, "{shape}: {mean}");
    }
}
