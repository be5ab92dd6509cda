//! Closed surfaces of triangles against brute force: a cube, a prism over an L, a sphere of triangles.

mod common;

use common::{Random, derivatives_hold, near};
use mpm_contact::{Bounds, Near, Polygon, Sample, Shape, Surface};
use mpm_grid::Vector;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

type Vec3 = Vector3<f64>;
type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

fn at(mesh: &Mesh, facet: &[u32; 3]) -> [Vec3; 3] {
    facet.map(|k| mesh.0[usize::try_from(k).unwrap()])
}

/// A prism of height 1 over a polygon that its first vertex sees whole.
fn prism(section: &[[f64; 2]]) -> Mesh {
    let n = u32::try_from(section.len()).unwrap();
    let vertices = [0.0, 1.0].iter().flat_map(|&z| section.iter().map(move |x| Vec3::new(x[0], x[1], z)));
    let mut facets = Vec::new();
    for k in 0..n {
        let next = (k + 1) % n;
        facets.extend([[k, next, next + n], [k, next + n, k + n]]);
    }
    for k in 1..n - 1 {
        facets.extend([[0, k + 1, k], [n, n + k, n + k + 1]]);
    }
    (vertices.collect(), facets)
}

fn cube() -> Mesh {
    prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
}

const ANGLE: [[f64; 2]; 6] = [[1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0], [3.0, 0.0], [3.0, 1.0]];

/// An icosahedron whose facets are cut in four `times` times.
fn sphere(times: u32) -> Mesh {
    let g = 0.5 * (1.0 + 5_f64.sqrt());
    let mut vertices: Vec<Vec3> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        vertices.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    vertices.iter_mut().for_each(|x| *x = x.normalize());
    let edge = (vertices[0] - vertices[3]).norm();
    let mut facets = Vec::new();
    for a in 0..12_u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [x, y, z] = [a, b, c].map(|k| vertices[usize::try_from(k).unwrap()]);
                let close = |p: &Vec3, q: &Vec3| (p - q).norm() < 1.01 * edge;
                if close(&x, &y) && close(&y, &z) && close(&z, &x) {
                    let outwards = (y - x).cross(&(z - x)).dot(&x) > 0.0;
                    facets.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..times {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut finer = Vec::new();
        for &[a, b, c] in &facets {
            let [d, e, f] = [[a, b], [b, c], [c, a]].map(|[i, j]| {
                *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                    let [x, y] = [i, j].map(|k| vertices[usize::try_from(k).unwrap()]);
                    vertices.push((x + y).normalize());
                    u32::try_from(vertices.len() - 1).unwrap()
                })
            });
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        facets = finer;
    }
    (vertices, facets)
}

fn surface(mesh: &Mesh, rounding: f64) -> Surface {
    Surface::new(mesh.0.clone(), mesh.1.clone(), rounding).unwrap()
}

/// Distance to a triangle, as the least over its edges and, where the foot lies within, its plane.
fn to_triangle(x: &Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a)).normalize();
    let within = [(a, b), (b, c), (c, a)].iter().all(|(p, q)| normal.cross(&(q - p)).dot(&(x - p)) >= 0.0);
    if within {
        return normal.dot(&(x - a)).abs();
    }
    let to_edge = |p: &Vec3, q: &Vec3| {
        let along = ((x - p).dot(&(q - p)) / (q - p).norm_squared()).clamp(0.0, 1.0);
        (x - p - (q - p) * along).norm()
    };
    to_edge(&a, &b).min(to_edge(&b, &c)).min(to_edge(&c, &a))
}

/// Winding number by solid angles (van Oosterom & Strackee 1983).
fn winding(x: &Vec3, mesh: &Mesh) -> f64 {
    let angle = |facet: &[u32; 3]| {
        let [a, b, c] = at(mesh, facet).map(|corner| corner - x);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    mesh.1.iter().map(angle).sum::<f64>() / (4.0 * PI)
}

#[test]
fn distances_and_signs_agree_with_brute_force() {
    let mut random = Random(21);
    for mesh in [cube(), prism(&ANGLE), sphere(0), sphere(2)] {
        let shape = surface(&mesh, 0.0);
        for _ in 0..600 {
            let x: Vec3 = random.vector(-1.5, 3.5);
            let least = mesh.1.iter().map(|it| to_triangle(&x, at(&mesh, it))).fold(f64::INFINITY, f64::min);
            let expected = if winding(&x, &mesh) > 0.5 { -least } else { least };
            let found = near(&shape, &x)[0];
            assert!((found.distance - expected).abs() < 1e-14, "{x:?}: {found:?} {expected}");
            let mut few = Vec::new();
            shape.near(&x, expected + 0.1, &mut few);
            assert_eq!(few[0], found);
            few.clear();
            shape.near(&x, expected - 1e-9, &mut few);
            assert!(few.is_empty());
        }
    }
}

/// Points of vertices, edges and facets, and straight off them along their normals.
#[test]
fn features_are_exact() {
    for (mesh, rounding) in [(cube(), 0.0), (prism(&ANGLE), 0.0), (sphere(1), 0.0), (cube(), 0.1)] {
        let shape = surface(&mesh, rounding);
        for facet in &mesh.1 {
            let [a, b, c] = at(&mesh, facet);
            let normal = (b - a).cross(&(c - a)).normalize();
            for x in
                [a, b, c, (a + b) * 0.5, b * 0.75 + c * 0.25, (a + b + c) / 3.0, a * 0.5 + b * 0.3 + c * 0.2]
            {
                let found = near(&shape, &x)[0];
                assert!((found.distance + rounding).abs() < 1e-14, "{x:?} {found:?}");
                assert!(found.normal.dot(&normal) > 0.3 || rounding == 0.0, "{x:?} {found:?}");
                // Straight off a facet; beside a concave edge another one may be as near.
                let x = x + normal * 0.01;
                let least =
                    mesh.1.iter().map(|it| to_triangle(&x, at(&mesh, it))).fold(f64::INFINITY, f64::min);
                let off = near(&shape, &x)[0];
                assert!((off.distance + rounding - least).abs() < 1e-14, "{x:?} {off:?}");
            }
        }
    }
}

/// The minima of a prism across its axis are those of its section.
#[test]
fn all_minima_of_a_prism_are_those_of_its_section() {
    let shape = surface(&prism(&ANGLE), 0.0);
    let section = Polygon::new(ANGLE.iter().map(|&x| Vector::<2>::from(x)).collect(), 0.0).unwrap();
    let mut random = Random(22);
    let mut double = 0;
    for _ in 0..1500 {
        let x = Vector::<2>::new(random.between(-0.4, 3.4), random.between(-0.4, 2.4));
        let (mut flat, mut solid): (Vec<Near<2>>, Vec<Near<3>>) = (Vec::new(), Vec::new());
        section.near(&x, 0.45, &mut flat);
        // In the middle of the height the ends are farther than the reach.
        shape.near(&Vec3::new(x[0], x[1], 0.5), 0.45, &mut solid);
        if flat.first().is_some_and(|it| it.distance < -0.45) {
            continue;
        }
        assert_eq!(flat.len(), solid.len(), "{x:?}: {flat:?} {solid:?}");
        for (a, b) in flat.iter().zip(&solid) {
            assert!((a.distance - b.distance).abs() < 1e-14);
            assert!((a.normal - b.normal.xy()).norm() < 1e-12 && b.normal[2].abs() < 1e-12);
            assert!((a.hessian[(0, 0)] - b.hessian[(0, 0)]).abs() < 1e-9 * (1.0 + a.hessian.norm()));
        }
        double += u32::from(flat.len() == 2);
    }
    assert!(double > 20, "{double}");
}

#[test]
fn derivatives_agree_with_finite_differences() {
    let mut random = Random(23);
    for (mesh, rounding) in [(cube(), 0.0), (cube(), 0.2), (prism(&ANGLE), 0.1), (sphere(1), 0.05)] {
        let shape = surface(&mesh, rounding);
        let mut checked = 0;
        for _ in 0..400 {
            let x: Vec3 = random.vector(-1.2, 2.2);
            let found = near(&shape, &x);
            let split = found.get(1).is_some_and(|it| it.distance - found[0].distance < 1e-3);
            if !split && found[0].hessian.norm() < 30.0 {
                checked += u32::from(derivatives_hold(&shape, &x, 1e-5, 1e-6));
            }
        }
        assert!(checked > 250, "{checked}");
    }
}

/// The surface of a cube that has grown by ρ: faces, quarter cylinders, one sphere.
#[test]
fn samples_have_the_area_of_the_grown_surface() {
    let area = |mesh: &Mesh, rounding: f64| {
        let mut out: Vec<Sample<3>> = Vec::new();
        let shape = surface(mesh, rounding);
        shape.samples(0.07, &Bounds::everything(), &mut out);
        for sample in &out {
            let found = near(&shape, &sample.position)[0];
            assert!(
                found.distance.abs() < 1e-12 && found.normal.dot(&sample.normal) > 0.9,
                "{sample:?} {found:?}"
            );
        }
        out.iter().map(|it| it.area).sum::<f64>()
    };
    assert!((area(&cube(), 0.0) - 6.0).abs() < 1e-12);
    let rho = 0.1;
    assert!((area(&cube(), rho) - (6.0 + 6.0 * PI * rho + 4.0 * PI * rho * rho)).abs() < 1e-12);
    assert!((area(&sphere(2), 0.0) / (4.0 * PI) - 1.0).abs() < 0.05);
}

#[test]
fn thickness_and_turns_of_facets_are_told() {
    assert!((surface(&prism(&ANGLE), 0.0).thickness() - 1.0).abs() < 1e-12);
    assert!((surface(&cube(), 0.1).thickness() - 1.2).abs() < 1e-12);
    assert!(surface(&cube(), 0.0).facet_turn() < 1e-7, "edges of a cube are no facets of what is smooth");
    let [coarse, fine] = [2, 3].map(|level| surface(&sphere(level), 0.0).facet_turn());
    assert!((coarse / fine - 2.0).abs() < 0.1 && coarse < 0.4, "{coarse} {fine}");
}

#[test]
fn bad_surfaces_are_refused() {
    let (vertices, facets) = cube();
    let refused = |vertices: &[Vec3], facets: &[[u32; 3]], rounding: f64| {
        let error = Surface::new(vertices.to_vec(), facets.to_vec(), rounding).unwrap_err();
        (error.name, error.value)
    };
    assert_eq!(refused(&vertices, &facets[1..], 0.0).0, "triangle");
    assert_eq!(refused(&vertices, &[], 0.0), ("number of triangles", 0.0));
    let mut turned = facets.clone();
    turned[3].swap(0, 1);
    assert_eq!(refused(&vertices, &turned, 0.0).0, "triangle");
    let inward: Vec<[u32; 3]> = facets.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(refused(&vertices, &inward, 0.0), ("volume", -1.0));
    let mut flat = vertices.clone();
    flat[1] = flat[0];
    assert_eq!(refused(&flat, &facets, 0.0), ("triangle", 1.0));
    let mut nowhere = facets.clone();
    nowhere[5][1] = 99;
    assert_eq!(refused(&vertices, &nowhere, 0.0), ("triangle", 6.0));
    flat[1] = Vec3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(refused(&flat, &facets, 0.0).0, "vertices");
    assert_eq!(refused(&vertices, &facets, -1.0), ("rounding", -1.0));
}
