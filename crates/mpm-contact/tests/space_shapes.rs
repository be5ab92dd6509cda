//! Distances, normals, Hessians and samples of solids of revolution and helical plates.

mod common;

use common::{Random, derivatives_hold, near};
use mpm_contact::{Bounds, Helix, HelixSize, Outline, Plane, Pose, Revolution, Sample, Shape, Sphere, Tool};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

type Vec3 = Vector3<f64>;

fn cylinder(rounding: f64) -> Revolution {
    Revolution::cylinder(Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 1.0), 0.5, rounding).unwrap()
}

fn cone(rounding: f64) -> Revolution {
    Revolution::cone(Vec3::new(0.2, 0.1, 0.0), Vec3::new(0.2, 0.6, 1.2), [0.0, 0.7], rounding).unwrap()
}

fn tube() -> Revolution {
    let profile = [[0.4, 0.0], [0.5, 0.0], [0.5, 1.0], [0.4, 1.0]];
    Revolution::new(Vec3::zeros(), Vec3::new(1.0, 1.0, 0.0), &profile, 0.02).unwrap()
}

/// A pile: a shaft with a conical tip and a flange, one part with two concave corners.
fn pile() -> Revolution {
    let profile =
        [[0.0, -0.4], [0.2, 0.0], [0.2, 0.5], [0.5, 0.5], [0.5, 0.7], [0.2, 0.7], [0.2, 1.5], [0.0, 1.5]];
    Revolution::new(Vec3::new(0.1, 0.0, 0.0), Vec3::z(), &profile, 0.03).unwrap()
}

fn plate(turns: f64, pitch: f64) -> Helix {
    let size = HelixSize { radii: [0.1, 0.25], pitch, turns, thickness: 0.05 };
    Helix::new(Vec3::new(0.05, 0.0, -0.1), Vec3::new(0.1, 0.0, 1.0), Vec3::x(), &size).unwrap()
}

fn samples(shape: &dyn Shape<3>, spacing: f64) -> Vec<Sample<3>> {
    let mut out = Vec::new();
    shape.samples(spacing, &Bounds::everything(), &mut out);
    out
}

#[test]
fn a_sharp_cylinder_agrees_with_its_closed_form() {
    let shape = cylinder(0.0);
    let mut random = Random(11);
    for _ in 0..2000 {
        let x: Vec3 = random.vector(-2.0, 2.0);
        let (r, z) = (x[0].hypot(x[1]) - 0.5, x[2].abs() - 1.0);
        let expected = if r > 0.0 && z > 0.0 { r.hypot(z) } else { r.max(z) };
        assert!((near(&shape, &x)[0].distance - expected).abs() < 1e-14, "{x:?}");
    }
}

/// A cylinder rounded by half its height is a sphere swept along a disc; rounded by all but its radius, a capsule.
#[test]
fn rounded_solids_agree_with_swept_spheres() {
    let shape = Revolution::cylinder(Vec3::zeros(), Vec3::new(0.0, 0.0, 2.0), 0.5, 0.499_999).unwrap();
    let mut random = Random(12);
    for _ in 0..500 {
        let x: Vec3 = random.vector(-1.0, 3.0);
        let z = x[2].clamp(0.5, 1.5);
        let expected = (x - Vec3::new(0.0, 0.0, z)).norm() - 0.5;
        assert!((near(&shape, &x)[0].distance - expected).abs() < 1e-5, "{x:?}");
    }
    // A frustum's rounded tip.
    let shape = cone(0.1);
    let axis = Vec3::new(0.0, 0.5, 1.2).normalize();
    let half = (0.7_f64 / 1.3).atan();
    let centre = Vec3::new(0.2, 0.1, 0.0) + axis * (0.1 / half.sin());
    let below = centre - axis * 0.4 + axis.cross(&Vec3::x()) * 0.1;
    assert!((near(&shape, &below)[0].distance - ((below - centre).norm() - 0.1)).abs() < 1e-14);
}

#[test]
fn derivatives_agree_with_finite_differences() {
    let mut random = Random(13);
    let shapes: [&dyn Shape<3>; 7] =
        [&cylinder(0.1), &cylinder(0.0), &cone(0.05), &tube(), &pile(), &plate(1.5, 0.2), &plate(2.0, -0.3)];
    for shape in shapes {
        let bounds = shape.bounds().grown(0.3);
        let mut checked = 0;
        for _ in 0..400 {
            let x = Vec3::from_fn(|d, _| random.between(bounds.from[d], bounds.to[d]));
            let found = near(shape, &x);
            // Away from the skeletons: the middle of a plate, the axis of a shaft, equal distances.
            let split = found.get(1).is_some_and(|it| it.distance - found[0].distance < 1e-3);
            let deep = found[0].distance < -0.8 * 0.5 * shape.thickness();
            if !split && !deep && found[0].hessian.norm() < 30.0 {
                checked += u32::from(derivatives_hold(shape, &x, 1e-5, 1e-6));
            }
        }
        assert!(checked > 200, "{checked} of {shape:?}");
    }
}

#[test]
fn the_helicoid_agrees_with_the_table() {
    let size = HelixSize { radii: [0.1, 0.25], pitch: 0.2, turns: 1.5, thickness: 0.05 };
    let shape = Helix::new(Vec3::zeros(), Vec3::z(), Vec3::x(), &size).unwrap();
    let table = include_str!("reference/helicoid_distance.csv");
    let mut rows = 0;
    for line in table.lines().filter(|line| !line.starts_with('#') && !line.starts_with('x')) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let found = near(&shape, &Vec3::new(row[0], row[1], row[2]))[0];
        assert!((found.distance + 0.025 - row[3]).abs() < 1e-9, "{line}: {found:?}");
        let foot = Vec3::new(row[0], row[1], row[2]) - found.normal * row[3];
        assert!((foot.xy().norm() - row[4]).abs() < 1e-6, "{line}: {foot:?}");
        rows += 1;
    }
    assert_eq!(rows, 200);
}

/// Left-handed plates and plates elsewhere are images of the one in the table.
#[test]
fn helices_agree_with_brute_force() {
    let mut random = Random(14);
    for (pitch, turns) in [(0.2, 2.3), (-0.2, 2.3), (1.5, 0.4)] {
        let size = HelixSize { radii: [0.1, 0.25], pitch, turns, thickness: 0.05 };
        let shape = Helix::new(Vec3::zeros(), Vec3::z(), Vec3::x(), &size).unwrap();
        for _ in 0..60 {
            let x = Vec3::new(
                random.between(-0.35, 0.35),
                random.between(-0.35, 0.35),
                pitch * random.between(-0.5, turns + 0.5),
            );
            let mut least = f64::INFINITY;
            for k in 0..=40_000 {
                let angle = TAU * turns * f64::from(k) / 40_000.0;
                let r = (x[0] * angle.cos() + x[1] * angle.sin()).clamp(0.1, 0.25);
                let foot = Vec3::new(r * angle.cos(), r * angle.sin(), pitch * angle / TAU);
                least = least.min((x - foot).norm());
            }
            let found = near(&shape, &x)[0].distance + 0.025;
            // Between two angles tried the square of the distance grows by half a step squared at most.
            assert!(found <= least + 1e-12 && least * least - found * found < 1e-8, "{x:?}: {found} {least}");
        }
    }
}

#[test]
fn between_two_turns_a_corner_meets_both() {
    let size = HelixSize { radii: [0.1, 0.25], pitch: 0.2, turns: 3.0, thickness: 0.05 };
    let shape = Helix::new(Vec3::zeros(), Vec3::z(), Vec3::x(), &size).unwrap();
    let found = near(&shape, &Vec3::new(0.2, 0.0, 0.29));
    assert!(found.len() >= 2);
    assert!(found[0].normal[2] > 0.9 && found[1].normal[2] < -0.9, "{found:?}");
    let mut few = Vec::new();
    shape.near(&Vec3::new(0.2, 0.0, 0.23), 0.02, &mut few);
    assert_eq!(few.len(), 1);
}

#[test]
fn samples_stand_on_the_surface_with_its_area() {
    let (r, h) = (0.5, 2.0);
    // A rim rounded by ρ: Pappus' rule for a quarter circle.
    let rho = 0.1;
    let rims = 2.0 * TAU * (rho * FRAC_PI_2 * (r - rho) + rho * rho);
    let rounded = TAU * r * (h - 2.0 * rho) + 2.0 * PI * (r - rho) * (r - rho) + rims;
    let slanted = PI * 0.7 * (0.7_f64.hypot(1.3) + 0.7);
    let walls = TAU * (0.4 + 0.5);
    let cases: [(&dyn Shape<3>, Option<f64>); 6] = [
        (&cylinder(0.0), Some(TAU * r * (h + r))),
        (&cylinder(rho), Some(rounded)),
        (&cone(0.0), Some(slanted)),
        (&tube(), None),
        (&pile(), None),
        (&plate(1.5, 0.2), None),
    ];
    for (shape, area) in cases {
        let found = samples(shape, 0.03);
        let whole: f64 = found.iter().map(|it| it.area).sum();
        if let Some(area) = area {
            assert!((whole / area - 1.0).abs() < 1e-12, "{whole} {area}");
        }
        assert!((samples(shape, 0.05).iter().map(|it| it.area).sum::<f64>() / whole - 1.0).abs() < 1e-12);
        for sample in &found {
            // A chord's middle stands a little inside of an arc.
            let it = near(shape, &sample.position)[0];
            assert!(it.distance.abs() < 1e-12, "{sample:?} {it:?} of {shape:?}");
            assert!(it.normal.dot(&sample.normal) > 0.99, "{sample:?} {it:?} of {shape:?}");
        }
    }
    assert!(samples(&tube(), 0.03).iter().map(|it| it.area).sum::<f64>() < walls + TAU * 0.45 * 0.2);
}

/// The area of a plate is the growth of its volume with the thickness, counted with random points.
#[test]
fn a_plate_has_the_area_of_its_volumes_growth() {
    let half = |thickness: f64| HelixSize { radii: [0.1, 0.25], pitch: 0.2, turns: 1.0, thickness };
    let shape = Helix::new(Vec3::zeros(), Vec3::z(), Vec3::x(), &half(0.05)).unwrap();
    let mut random = Random(15);
    let (n, band) = (400_000, 0.004);
    let bounds = shape.bounds().grown(band);
    let size = bounds.to - bounds.from;
    let mut inside = 0_u32;
    for _ in 0..n {
        let x = Vec3::from_fn(|d, _| random.between(bounds.from[d], bounds.to[d]));
        let mut out = Vec::new();
        shape.near(&x, band, &mut out);
        inside += u32::from(out.first().is_some_and(|it| it.distance > -band));
    }
    let counted = f64::from(inside) / f64::from(n) * size.product() / (2.0 * band);
    let told: f64 = samples(&shape, 0.02).iter().map(|it| it.area).sum();
    assert!((counted / told - 1.0).abs() < 0.02, "{counted} {told}");
}

fn volume(outline: &Outline<3>) -> f64 {
    let at = |k: u32| outline.vertices[usize::try_from(k).unwrap()];
    outline.facets.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))) / 6.0).sum()
}

#[test]
fn outlines_enclose_their_volumes() {
    let told = |shape: &dyn Shape<3>| volume(&shape.outline(0.01, &Bounds::everything()));
    assert!((told(&cylinder(0.0)) / (0.5 * PI) - 1.0).abs() < 1e-3);
    assert!((told(&cone(0.0)) / (PI * 0.49 * 1.3 / 3.0) - 1.0).abs() < 1e-3);
    assert!((told(&Sphere::new(Vec3::zeros(), 1.0).unwrap()) / (4.0 * PI / 3.0) - 1.0).abs() < 1e-3);
    assert!(told(&tube()) > 0.9 * PI * (0.25 - 0.16) && told(&tube()) < PI * (0.25 - 0.16));
    // Sheet times thickness, and half a tube about the rims.
    let plate = plate(1.5, 0.2);
    let sheet = 1.5 * PI * (0.0625 - 0.01) * 0.05;
    assert!(told(&plate) > sheet && told(&plate) < 1.5 * sheet, "{} {sheet}", told(&plate));
}

#[test]
fn a_tool_leaves_out_what_its_parts_cover() {
    let shaft = Revolution::cylinder(Vec3::zeros(), Vec3::new(0.0, 0.0, 1.0), 0.1, 0.0).unwrap();
    let tip = Revolution::cone(Vec3::new(0.0, 0.0, -0.2), Vec3::zeros(), [0.0, 0.1], 0.0).unwrap();
    let tool = Tool::new(vec![Box::new(shaft), Box::new(tip)]).unwrap();
    let found = tool.samples(0.01, &Bounds::everything());
    let area = |part: usize| found[part].iter().map(|it| it.area).sum::<f64>();
    // The disc in between belongs to neither.
    assert!((area(0) - (TAU * 0.1 + PI * 0.01)).abs() < 1e-9, "{}", area(0));
    assert!((area(1) - PI * 0.1 * 0.1_f64.hypot(0.2)).abs() < 1e-9);
    let flange = HelixSize { radii: [0.1, 0.25], pitch: 0.2, turns: 1.0, thickness: 0.05 };
    let plate = Helix::new(Vec3::new(0.0, 0.0, 0.4), Vec3::z(), Vec3::x(), &flange).unwrap();
    let shaft = Revolution::cylinder(Vec3::zeros(), Vec3::new(0.0, 0.0, 1.0), 0.1, 0.0).unwrap();
    let tool = Tool::new(vec![Box::new(shaft), Box::new(plate)]).unwrap();
    let found = tool.samples(0.005, &Bounds::everything());
    let shaft: f64 = found[0].iter().map(|it| it.area).sum();
    // Along the axis the root of the plate covers t √(1 + (c/R)²) over the turn, and half a tube at both ends.
    let slope = (0.2 / TAU) / 0.1;
    let root = TAU * 0.1 * 0.05 * f64::hypot(1.0, slope) + PI * 0.025 * 0.025;
    assert!((shaft - (TAU * 0.1 + TAU * 0.01 - root)).abs() < 0.02 * root, "{shaft} {root}");
    assert!(tool.contains(&Vec3::new(0.0, 0.0, 0.5)) && !tool.contains(&Vec3::new(0.3, 0.0, 0.5)));
    assert_eq!(tool.thickness(), 0.05);
}

#[test]
fn bad_shapes_are_refused() {
    let at = |z: f64| Vec3::new(0.0, 0.0, z);
    let names = [
        Revolution::cylinder(at(0.0), at(0.0), 1.0, 0.0).unwrap_err().name,
        Revolution::cylinder(at(0.0), at(1.0), -1.0, 0.0).unwrap_err().name,
        Revolution::cylinder(at(0.0), at(1.0), 1.0, 0.5).unwrap_err().name,
        Revolution::cylinder(at(0.0), at(f64::NAN), 1.0, 0.0).unwrap_err().name,
        Revolution::cone(at(0.0), at(1.0), [0.5, 0.5], 0.0).unwrap_err().name,
        Revolution::cone(at(0.0), at(1.0), [-0.5, 0.5], 0.0).unwrap_err().name,
        Revolution::new(at(0.0), Vec3::z(), &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 0.0).unwrap_err().name,
        Revolution::new(at(0.0), Vec3::zeros(), &[[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]], 0.0).unwrap_err().name,
    ];
    assert_eq!(names, ["extent", "radius", "rounding", "extent", "radius", "radius", "profile", "axis"]);
    let good = HelixSize { radii: [0.1, 0.25], pitch: 0.2, turns: 1.0, thickness: 0.05 };
    let refused = |size: HelixSize| Helix::new(at(0.0), Vec3::z(), Vec3::x(), &size).unwrap_err().name;
    assert_eq!(refused(HelixSize { radii: [0.3, 0.25], ..good }), "radii");
    assert_eq!(refused(HelixSize { pitch: 0.0, ..good }), "pitch");
    assert_eq!(refused(HelixSize { turns: f64::NAN, ..good }), "turns");
    assert_eq!(refused(HelixSize { thickness: 0.2, ..good }), "thickness");
    assert_eq!(refused(HelixSize { thickness: 0.0, ..good }), "thickness");
    assert_eq!(Helix::new(at(0.0), Vec3::z(), Vec3::z(), &good).unwrap_err().name, "from");
    assert_eq!(Tool::<3>::new(Vec::new()).unwrap_err().name, "parts");
    assert!(Plane::new(at(0.0), Vec3::new(0.0, f64::INFINITY, 0.0)).is_err());
}

#[test]
fn what_slides_along_itself_is_not_carried() {
    let flange = HelixSize { radii: [0.1, 0.25], pitch: 0.2, turns: 1.0, thickness: 0.05 };
    let plate = Helix::new(Vec3::new(0.0, 0.0, 0.4), Vec3::z(), Vec3::x(), &flange).unwrap();
    let shaft = Revolution::cylinder(Vec3::new(0.0, 0.0, -2.0), Vec3::new(0.0, 0.0, 2.0), 0.1, 0.0).unwrap();
    let pose = |turn: f64, shift: Vec3| Pose::turned(&Vec3::zeros(), &Vec3::new(0.0, 0.0, turn), &shift);
    let rest = Pose::identity();
    let tool = Tool::new(vec![Box::new(shaft)]).unwrap();
    // The facets of the drawn shaft are not quite the shaft.
    let (turned, thickness) = tool.carried(&rest, &pose(0.1, Vec3::zeros())).unwrap();
    assert!(turned < 0.2 * 0.1 * 0.1 && thickness == 0.2, "{turned} {thickness}");
    let (pushed, _) = tool.carried(&rest, &pose(0.0, Vec3::new(0.03, 0.0, 0.0))).unwrap();
    assert!((pushed / 0.03 - 1.0).abs() < 0.01, "{pushed}");
    // A plate along its thread goes on at its ends alone; across, as it is pushed. It is the thinner part.
    let shaft = tool.into_parts().remove(0);
    let tool = Tool::new(vec![shaft, Box::new(plate)]).unwrap();
    let (screwed, thickness) = tool.carried(&rest, &pose(0.1, Vec3::new(0.0, 0.0, 0.02 / TAU))).unwrap();
    assert!((screwed / (0.1 * 0.25) - 1.0).abs() < 0.15 && thickness == 0.05, "{screwed} {thickness}");
    let (pushed, _) = tool.carried(&rest, &pose(0.0, Vec3::new(0.0, 0.0, 0.03))).unwrap();
    assert!((pushed / 0.03 - 1.0).abs() < 0.05, "{pushed}");
    let plane = Tool::<3>::new(vec![Box::new(Plane::new(Vec3::zeros(), Vec3::z()).unwrap())]).unwrap();
    assert_eq!(plane.carried(&rest, &pose(0.0, Vec3::new(0.0, 0.0, 9.0))), None);
}

#[test]
fn samples_in_a_box_are_those_of_all() {
    let within = Bounds { from: Vec3::repeat(-0.3), to: Vec3::new(0.9, 0.2, 0.6) };
    let sphere = Sphere::new(Vec3::zeros(), 0.7).unwrap();
    let tool = Tool::<3>::new(vec![Box::new(sphere), Box::new(cylinder(0.1))]).unwrap();
    let all = tool.samples(0.05, &Bounds::everything());
    let some = tool.samples(0.05, &within);
    for (all, some) in all.iter().zip(&some) {
        let expected: Vec<_> = all.iter().filter(|it| within.contains(&it.position)).copied().collect();
        assert!(some.len() < all.len());
        assert_eq!(*some, expected);
    }
}
