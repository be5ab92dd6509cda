//! Bodies of every shape, from the scene to the points.

use mpm_geometry::Surface;
use mpm_scene::Scene;
use mpm_scene::{Compiled, compile, compile_with};
use mpm_scene::{NamedColumns, PointTable, SceneFiles};
use mpm_solver::Model;

/// A tetrahedron, and two points.
struct Files;

impl SceneFiles for Files {
    fn surface(&self, file: &str) -> Result<Surface, String> {
        let [a, b, c, d] = [[0.5, 0.5, 0.5], [3.5, 0.5, 0.5], [0.5, 3.5, 0.5], [0.5, 0.5, 3.5]];
        let facets = [[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
        Surface::new(&facets).map_err(|it| format!("{file}: {it}"))
    }

    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String> {
        Ok(PointTable {
            file: file.into(),
            row_kind: "row",
            row: vec![0, 1],
            position: [[1.2, 1.3, 1.4], [2.6, 1.3, 1.4]]
                .iter()
                .flat_map(|x| x[..dimensions].to_vec())
                .collect(),
            volume: vec![0.5, 0.25],
            domain: Vec::new(),
            notes: Vec::new(),
        })
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        Err(format!("{file} has no columns"))
    }
}

const BASES: [&str; 5] = ["Smpm", "Gimp", "Cpdi1", "Cpdi2Hexahedron", "Cpdi2Tetrahedron"];

fn scene(basis: &str, shape: &str, count: &str) -> String {
    format!(
        r#"Solid(
            mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 5), Uniform(from: 0, to: 4, cells: 8)]),
            basis: {basis},
            materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3, density: 2) }},
            bodies: [(name: "body", material: "clay", shape: {shape}{count})],
            supports: [(name: "all", region: Everywhere, fix: [X, Y, Z])],
            loads: [BodyForce(acceleration: (0, -1, 0))],
            schedule: (steps: 1),
        )"#
    )
}

fn solid(basis: &str, shape: &str) -> Model<3> {
    let count = if shape.starts_with("Points") { "" } else { ", points_per_cell: 2" };
    let scene = Scene::from_ron(&scene(basis, shape, count)).unwrap();
    match compile_with(&scene, &Files) {
        Ok(Compiled::Solid(model)) => model,
        Ok(Compiled::Plane(_)) => panic!("a scene in space"),
        Err(error) => panic!("{error}"),
    }
}

/// Volume and centre of the first body.
fn measure(model: &Model<3>) -> (f64, [f64; 3]) {
    let body = &model.bodies[0].body;
    let points: Vec<_> = (0..body.n_points()).map(|p| body.point(p)).collect();
    let volume = points.iter().map(|it| it.reference_volume).sum();
    (
        volume,
        [0, 1, 2].map(|d| points.iter().map(|it| it.reference_volume * it.position[d]).sum::<f64>() / volume),
    )
}

#[test]
fn every_basis_fills_every_shape_to_its_volume_and_about_its_centre() {
    let pi = std::f64::consts::PI;
    let shapes = [
        ("Surface(file: \"a.stl\")", 4.5, [1.25; 3]),
        ("Surface(file: \"a.stl\", scale: 0.5, shift: (1, 0.2, 0))", 4.5 / 8.0, [1.625, 0.825, 0.625]),
        ("Cylinder(centre: (2, 2.1), radius: 1.3, extent: (0.6, 3.1))", pi * 1.69 * 2.5, [2.0, 2.1, 1.85]),
        ("Cylinder(axis: X, centre: (2, 2.1), radius: 1.3)", pi * 1.69 * 4.0, [2.0, 2.0, 2.1]),
        (
            "Tube(axis: Y, centre: (2, 2.1), inner: 0.7, outer: 1.7, extent: (0, 3))",
            pi * 2.4 * 3.0,
            [2.0, 1.5, 2.1],
        ),
        ("Points(file: \"a.h5\")", 0.75, [5.0 / 3.0, 1.3, 1.4]),
    ];
    for basis in BASES {
        for (shape, expected, centre) in shapes {
            let model = solid(basis, shape);
            let (volume, found) = measure(&model);
            assert!((volume / expected - 1.0).abs() < 1e-9, "{basis}, {shape}: {volume} for {expected}");
            // Tetrahedra have their points at their own centres, which balance about that of the box.
            for d in 0..3 {
                assert!((found[d] - centre[d]).abs() < 1e-9, "{basis}, {shape}: {found:?}");
            }
            if let Some(shape_volume) = model.bodies[0].shape_volume {
                assert!((shape_volume / expected - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn they_carry_their_weight() {
    for basis in BASES {
        for shape in
            ["Surface(file: \"a.stl\")", "Cylinder(centre: (2, 2), radius: 1.3)", "Points(file: \"a.h5\")"]
        {
            let count = if shape.starts_with("Points") { "" } else { ", points_per_cell: 2" };
            let scene = Scene::from_ron(&scene(basis, shape, count)).unwrap();
            let summary = compile_with(&scene, &Files).unwrap().run(&mut ()).unwrap();
            assert_eq!(summary.steps, 1, "{basis}, {shape}");
        }
    }
}

#[test]
fn a_tube_in_a_ring_mesh_is_its_cells() {
    let text = |shape: &str| {
        format!(
            r#"Solid(
                mesh: Ring(radii: Uniform(from: 1, to: 3, cells: 4), sectors: 16, height: Uniform(from: 0, to: 2, cells: 4)),
                basis: Cpdi1,
                materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3) }},
                bodies: [(name: "body", material: "clay", shape: {shape}, points_per_cell: 2)],
                schedule: (steps: 1),
            )"#
        )
    };
    let scene = Scene::from_ron(&text("Tube(inner: 1.5, outer: 2.5, extent: (0.5, 1.5))")).unwrap();
    let Compiled::Solid(model) = compile(&scene).unwrap() else { panic!("a scene in space") };
    // Polygons of sixteen sides: ½ n sin(2π/n) (R² - r²), one high.
    let (volume, _) = measure(&model);
    let expected = 8.0 * (std::f64::consts::PI / 8.0).sin() * (2.5 * 2.5 - 1.5 * 1.5);
    assert!((volume / expected - 1.0).abs() < 1e-12, "{volume} for {expected}");
}

#[test]
fn a_disc_fills_the_plane() {
    let text = |shape: &str| {
        format!(
            r#"PlaneStrain(
                mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 5)]),
                basis: Gimp,
                materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3) }},
                bodies: [(name: "body", material: "clay", shape: {shape}, points_per_cell: 2)],
                schedule: (steps: 1),
            )"#
        )
    };
    let area = |shape: &str| match compile(&Scene::from_ron(&text(shape)).unwrap()) {
        Ok(Compiled::Plane(model)) => {
            let body = &model.bodies[0].body;
            (0..body.n_points()).map(|p| body.point(p).reference_volume).sum::<f64>()
        }
        Ok(Compiled::Solid(_)) => panic!("a scene in the plane"),
        Err(error) => panic!("{error}"),
    };
    let pi = std::f64::consts::PI;
    assert!((area("Cylinder(centre: (2, 2), radius: 1.5)") / (2.25 * pi) - 1.0).abs() < 1e-9);
    assert!((area("Tube(centre: (2, 2), inner: 0.5, outer: 1.5)") / (2.0 * pi) - 1.0).abs() < 1e-9);
    let error =
        |shape: &str| compile(&Scene::from_ron(&text(shape)).unwrap()).err().expect("refused").to_string();
    assert!(error("Cylinder(centre: (2, 2), radius: 1, extent: (0, 1))").contains("three dimensions"));
    assert!(error("Cylinder(axis: X, centre: (2, 2), radius: 1)").contains("along `Z`"));
    assert!(error("Surface(file: \"a.stl\")").contains("three dimensions only"));
    assert!(error("Cylinder(centre: (2, 2), radius: 2.5)").contains("outside the mesh"));
}

#[test]
fn without_files_nothing_is_read() {
    let scene = Scene::from_ron(&scene("Smpm", "Surface(file: \"a.stl\")", ", points_per_cell: 2")).unwrap();
    assert!(compile(&scene).err().expect("refused").to_string().contains("compiled without files"));
}

#[test]
fn bodies_cut_out_of_a_box_leave_its_rest() {
    let text = |first: &str, without: &str| {
        format!(
            r#"Solid(
                mesh: Box(axes: [Uniform(from: 0, to: 4, cells: 4), Uniform(from: 0, to: 4, cells: 5), Uniform(from: 0, to: 4, cells: 8)]),
                basis: Gimp,
                materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3) }},
                bodies: [
                    (name: "inner", material: "clay", shape: {first}, points_per_cell: 2),
                    (name: "outer", material: "clay", shape: Box(from: (0, 0, 0.5), to: (4, 4, 3), without: [{without}]), points_per_cell: 2),
                ],
                schedule: (steps: 1),
            )"#
        )
    };
    let volumes = |first: &str| match compile_with(&Scene::from_ron(&text(first, "\"inner\"")).unwrap(), &Files)
    {
        Ok(Compiled::Solid(model)) => [0, 1].map(|b| {
            let body = &model.bodies[b].body;
            (0..body.n_points()).map(|p| body.point(p).reference_volume).sum::<f64>()
        }),
        Ok(Compiled::Plane(_)) => panic!("a scene in space"),
        Err(error) => panic!("{error}"),
    };
    // Wholly inside; and through both ends.
    let [inner, outer] = volumes("Cylinder(axis: X, centre: (2, 2.1), radius: 0.7, extent: (0.3, 3.4))");
    assert!((inner + outer - 40.0).abs() < 1e-9, "{inner} + {outer}");
    let [inner, outer] = volumes("Cylinder(centre: (2, 2.1), radius: 1.3)");
    assert!((inner / 4.0 * 2.5 + outer - 40.0).abs() < 1e-9, "{inner}, {outer}");
    let [_, outer] = volumes("Surface(file: \"a.stl\", shift: (0, 0, 0.1))");
    // The tetrahedron from 0.6 to 3.6 loses its tip above 3.
    assert!((outer - (40.0 - 4.5 + 0.036)).abs() < 1e-9, "{outer}");
    // What is left out by nobody is there twice.
    for first in ["Cylinder(centre: (2, 2.1), radius: 1.3)", "Surface(file: \"a.stl\")"] {
        let error = compile_with(&Scene::from_ron(&text(first, "")).unwrap(), &Files).err().expect("refused");
        assert!(error.to_string().contains("body `outer` overlaps body `inner`; a box can"), "{error}");
    }
}

/// Keeps where the points are.
#[derive(Default)]
struct Positions(Vec<Vec<f64>>);

impl mpm_solver::observe::Observer for Positions {
    fn load_step(
        &mut self,
        step: &mpm_solver::observe::LoadStep<'_>,
    ) -> Result<(), mpm_solver::observe::ObserverError> {
        self.0.push(step.fields.positions());
        Ok(())
    }
}

#[test]
fn nodes_that_turn_take_the_body_along() {
    for (axis, [d, e]) in [("X", [1, 2]), ("Y", [2, 0]), ("Z", [0, 1])] {
        let text = format!(
            r#"Solid(
                mesh: Box(axes: [Uniform(from: -2, to: 2, cells: 4), Uniform(from: -2, to: 2, cells: 4), Uniform(from: -2, to: 2, cells: 4)]),
                basis: Smpm,
                materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3) }},
                bodies: [(name: "body", material: "clay", shape: Box(from: (-1, -1, -1), to: (1, 1, 1)), points_per_cell: 1)],
                supports: [
                    (name: "turned", region: Everywhere, turn: (axis: {axis}, centre: (0.2, -0.1), angle: 60), fix: [{axis}]),
                ],
                schedule: (steps: 5),
            )"#
        );
        let mut seen = Positions::default();
        compile(&Scene::from_ron(&text).unwrap()).unwrap().run(&mut seen).unwrap();
        let centre = if axis == "Y" { [-0.1, 0.2] } else { [0.2, -0.1] };
        let (sine, cosine) = 60.0_f64.to_radians().sin_cos();
        for (rest, end) in seen.0[0].chunks_exact(3).zip(seen.0[5].chunks_exact(3)) {
            let (a, b) = (rest[d] - centre[0], rest[e] - centre[1]);
            assert!(
                (end[d] - centre[0] - (cosine * a - sine * b)).abs() < 1e-12,
                "{axis}: {rest:?} to {end:?}"
            );
            assert!(
                (end[e] - centre[1] - (sine * a + cosine * b)).abs() < 1e-12,
                "{axis}: {rest:?} to {end:?}"
            );
        }
    }
}
