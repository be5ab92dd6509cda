//! Polygons, and shapes that are cut out of boxes, to their volumes and centres in every space.

use mpm_assembly::Body;
use mpm_scene::{Compiled, Scene, compile};
use std::f64::consts::PI;

/// A scene whose one body has this shape.
fn scene(space: &str, basis: &str, shape: &str) -> String {
    let axis = |cells: u32| format!("Uniform(from: 0, to: 4, cells: {cells})");
    let third = if space == "Solid" { format!(", {}", axis(8)) } else { String::new() };
    format!(
        r#"{space}(
            mesh: Box(axes: [{}, {}{third}]),
            basis: {basis},
            materials: {{ "clay": Hencky(young: 1e3, poisson: 0.3) }},
            bodies: [(name: "body", material: "clay", shape: {shape}, points_per_cell: 2)],
            schedule: (steps: 1),
        )"#,
        axis(4),
        axis(5)
    )
}

/// Volume and centre of a body.
fn measure<const D: usize>(body: &dyn Body<D>) -> (f64, [f64; D]) {
    let points: Vec<_> = (0..body.n_points()).map(|p| body.point(p)).collect();
    let volume = points.iter().map(|it| it.reference_volume).sum();
    let centre = |d: usize| points.iter().map(|it| it.reference_volume * it.position[d]).sum::<f64>() / volume;
    (volume, std::array::from_fn(centre))
}

/// Volume and centre of a shape, the third coordinate of the plane 0.
fn fill(space: &str, basis: &str, shape: &str) -> (f64, [f64; 3]) {
    match compile(&Scene::from_ron(&scene(space, basis, shape)).unwrap()) {
        Ok(Compiled::Plane(model)) => {
            let (volume, [x, y]) = measure(&*model.bodies[0].body);
            (volume, [x, y, 0.0])
        }
        Ok(Compiled::Solid(model)) => measure(&*model.bodies[0].body),
        Err(error) => panic!("{error}"),
    }
}

fn refusal(space: &str, shape: &str) -> String {
    compile(&Scene::from_ron(&scene(space, "Gimp", shape)).unwrap()).err().expect("refused").to_string()
}

#[test]
fn a_polygon_has_its_area_and_centre_in_every_basis() {
    for basis in ["Smpm", "Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"] {
        // A slope, clockwise, with a hole.
        let shape = "Polygon(vertices: [(0, 0), (0, 3), (1, 3), (3.5, 0.5), (3.5, 0)],
            holes: [[(0.5, 0.5), (1.1, 0.5), (1.1, 1.3), (0.5, 1.3)]])";
        let (area, [x, y, _]) = fill("PlaneStrain", basis, shape);
        // A rectangle of 1 by 3, a trapezoid of 3 and 0.5 over 2.5, less a hole.
        let expected = 3.0 + 0.5 * 3.5 * 2.5 - 0.48;
        assert!((area - expected).abs() < 1e-12, "{basis}: {area}");
        let trapezoid = (1.0 + 2.5 / 3.0 * (3.0 + 2.0 * 0.5) / 3.5, (9.0 + 1.5 + 0.25) / (3.0 * 3.5));
        let moment = |of: [f64; 3]| 3.0 * of[0] + 4.375 * of[1] - 0.48 * of[2];
        let centre = [moment([0.5, trapezoid.0, 0.8]), moment([1.5, trapezoid.1, 0.9])].map(|it| it / expected);
        assert!((x - centre[0]).abs() < 1e-12 && (y - centre[1]).abs() < 1e-12, "{basis}: ({x}, {y})");
    }
}

#[test]
fn polygons_are_drawn_out_along_every_axis_and_turned_about_one() {
    let triangle = "vertices: [(0.5, 0.5), (3.5, 0.5), (0.5, 2)]";
    for (axis, centre) in [("X", [2.0, 1.5, 1.0]), ("Y", [1.5, 2.0, 1.0]), ("Z", [1.5, 1.0, 2.0])] {
        let shape = format!("Polygon({triangle}, axis: {axis}, extent: (0.7, 3.3))");
        let (volume, found) = fill("Solid", "Cpdi2Hexahedron", &shape);
        assert!((volume - 2.25 * 2.6).abs() < 1e-12, "{axis}: {volume}");
        assert!((0..3).all(|d| (found[d] - centre[d]).abs() < 1e-12), "{axis}: {found:?}");
    }
    // A cone; Pappus: the area times the way of its centre.
    let (volume, _) = fill("Axisymmetric", "Gimp", "Polygon(vertices: [(0, 0), (2.3, 0), (0, 3)])");
    assert!((volume - PI * 2.3 * 2.3).abs() < 1e-11, "{volume}");
}

#[test]
fn shapes_are_cut_out_of_boxes() {
    let rest = |space: &str, cutouts: &str| {
        let corner =
            |x: &str| if space == "Solid" { format!("({x}, {x}, {x})") } else { format!("({x}, {x})") };
        let shape = format!("Box(from: {}, to: {}, cutouts: [{cutouts}])", corner("0"), corner("4"));
        fill(space, "Gimp", &shape).0
    };
    let trench = "Polygon(vertices: [(1, 4.5), (1.7, 2.2), (2.3, 2.2), (3, 4.5)])";
    // The trapezoid of 2.3 high is cut by the surface at 4.
    let wide = 0.6 + 1.4 * 1.8 / 2.3;
    assert!((rest("PlaneStrain", trench) - (16.0 - 0.5 * (0.6 + wide) * 1.8)).abs() < 1e-12);
    let two = "Box(from: (0.3, 0.3), to: (1.1, 3.3)), Cylinder(centre: (2.5, 2.5), radius: 1.2)";
    assert!((rest("PlaneStrain", two) - (16.0 - 2.4 - 1.44 * PI)).abs() < 1e-8);
    let ball = "Sphere(centre: (2, 2, 2), radius: 0.9), Box(from: (3, 3, 3), to: (9, 9, 9))";
    assert!((rest("Solid", ball) - (64.0 - 4.0 / 3.0 * PI * 0.729 - 1.0)).abs() < 1e-8);
    // A spherical cavity on the axis.
    let cavity = rest("Axisymmetric", "Sphere(centre: (0, 2), radius: 0.9)");
    assert!((cavity / (16.0 * PI * 4.0 - 4.0 / 3.0 * PI * 0.729) - 1.0).abs() < 1e-5, "{cavity}");
}

#[test]
fn what_is_no_polygon_is_refused() {
    for (space, shape, part) in [
        (
            "PlaneStrain",
            "Polygon(vertices: [(0, 0), (1, 0)])",
            "the outline has 2 corners, expected at least 3",
        ),
        ("PlaneStrain", "Polygon(vertices: [(0, 0), (1, 1), (1, 0), (0, 1)])", "cross or touch"),
        ("PlaneStrain", "Polygon(vertices: [(0, 0), (1, 0), (0, 1)], extent: (0, 1))", "for three dimensions"),
        ("PlaneStrain", "Polygon(vertices: [(0, 0), (1, 0), (0, 1)], axis: X)", "has its axis along `Z`"),
        ("PlaneStrain", "Polygon(vertices: [(0, 0), (5, 0), (0, 1)])", "outside the mesh"),
        ("Axisymmetric", "Polygon(vertices: [(-1, 0), (1, 0), (0, 1)])", "a corner has a negative r"),
        ("Solid", "Polygon(vertices: [(0, 0), (1, 0), (0, 1)], extent: (2, 1))", "expected `extent` to ascend"),
        (
            "PlaneStrain",
            "Box(from: (0, 0), to: (4, 4), cutouts: [Ring(inner: 1, outer: 2)])",
            "expected a `Cylinder`, `Tube`, `Sphere`, `Polygon` or `Surface`",
        ),
        (
            "PlaneStrain",
            "Box(from: (0, 0), to: (4, 4), cutouts: [Box(from: (1, 1), to: (1, 2))])",
            "`cutouts[0]`: edge",
        ),
        (
            "PlaneStrain",
            "Box(from: (0.1, 0), to: (4, 4), cutouts: [Cylinder(centre: (2, 2), radius: 1)])",
            "has its ends on mesh lines",
        ),
        (
            "PlaneStrain",
            "Box(from: (0, 0), to: (4, 4), cutouts: [
                Cylinder(centre: (2, 2), radius: 1), Box(from: (1, 1), to: (2, 2)),
            ])",
            "overlap near",
        ),
    ] {
        let said = refusal(space, shape);
        assert!(said.contains(part), "{shape}: {said}");
    }
}

#[test]
fn polygons_that_overlap_are_refused() {
    let both = |second: &str| {
        let first = "Polygon(vertices: [(0, 0), (2, 0), (2, 2)]), points_per_cell: 2),
            (name: \"other\", material: \"clay\", shape: ";
        compile(&Scene::from_ron(&scene("PlaneStrain", "Gimp", &format!("{first}{second}"))).unwrap())
    };
    assert!(both("Polygon(vertices: [(0, 0), (2, 2), (0, 2)])").is_ok(), "they share an edge");
    let error = both("Polygon(vertices: [(0, 0), (2, 0), (0, 2)])").err().expect("refused").to_string();
    assert!(error.contains("body `other` overlaps body `body`"), "{error}");
}
