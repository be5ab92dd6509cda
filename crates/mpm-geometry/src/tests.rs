//! Surfaces, what is wrong with them, and the parts that they enclose.

use crate::grid::BYTES_OF_PIECE;
use crate::{Face, MemoryLimit, Part, Parts, Round, Solid, Surface, parts};
use mpm_grid::Axis;
use nalgebra::Vector3;

/// No direction in which a body may leave the mesh.
const CLOSED: [bool; 3] = [false; 3];

const MEMORY: MemoryLimit = MemoryLimit { bytes: u64::MAX };

/// Two triangles to a face, seen anticlockwise from outside.
fn cuboid(from: [f64; 3], to: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let corner = |c: usize| std::array::from_fn(|d| if c >> d & 1 == 1 { to[d] } else { from[d] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|facet| facet.map(corner)).collect()
}

fn unit() -> Vec<[[f64; 3]; 3]> {
    cuboid([0.0; 3], [1.0; 3])
}

fn error(triangles: &[[[f64; 3]; 3]]) -> String {
    Surface::new(triangles).unwrap_err().to_string()
}

#[test]
fn a_cube_is_a_surface() {
    let cube = Surface::new(&unit()).unwrap();
    assert_eq!((cube.triangles().vertices.len(), cube.n_facets(), cube.volume()), (8, 12, 1.0));
}

#[test]
fn what_lies_in_a_box_is_measured_wherever_the_box_lies() {
    // Its facets are far larger than the boxes.
    let bar = Surface::new(&cuboid([-5.0, 0.0, 0.0], [5.0, 1.0, 1.0])).unwrap();
    for (from, to, volume) in [
        ([-1.0, -1.0, -1.0], [1.0, 2.0, 2.0], 2.0),
        ([-1.0, 0.25, 0.5], [1.0, 0.75, 3.0], 0.5),
        ([-9.0, -1.0, -1.0], [9.0, 2.0, 2.0], 10.0),
        ([4.5, 0.5, 0.5], [6.0, 0.75, 0.75], 0.5 * 0.25 * 0.25),
        ([-1.0, 1.0, 0.0], [1.0, 2.0, 1.0], 0.0),
        ([5.0, 0.0, 0.0], [6.0, 1.0, 1.0], 0.0),
        ([1.0, 0.0, 0.0], [-1.0, 1.0, 1.0], 0.0),
    ] {
        let found = bar.volume_in(&from, &to);
        assert!((found - volume).abs() < 1e-14, "{from:?} to {to:?}: {found}");
    }
}

#[test]
fn what_is_no_surface_is_refused_with_its_reason() {
    assert_eq!(error(&[]), "the surface has no facets");
    let cube = unit();
    // The first facet is of the bottom, its neighbour there, and of two sides.
    let said = error(&cube[1..]);
    assert!(said.contains("open") && said.contains("and 2 more edges are open"), "{said}");
    let mut turned = cube.clone();
    turned[4].swap(0, 1);
    let said = error(&turned);
    assert!(said.contains("facets") && said.contains("5") && said.contains("face opposite ways"), "{said}");
    let mut inward = cube.clone();
    inward.iter_mut().for_each(|facet| facet.swap(0, 1));
    assert!(error(&inward).contains("face inwards"));
    let mut flat = cube.clone();
    flat[7][2] = [0, 1, 2].map(|d| 0.5 * (flat[7][0][d] + flat[7][1][d]));
    let said = error(&flat);
    assert!(said.contains("the surface is open") && said.contains("and 3 more edges are open"), "{said}");
    let mut broken = cube.clone();
    broken[2][1][1] = f64::NAN;
    assert!(error(&broken).starts_with("facet 3 has a corner at"));
    // Two cubes with a common edge: it belongs to four facets.
    let two = [cube.clone(), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])].concat();
    assert!(error(&two).contains("belongs to 4 facets"), "{}", error(&two));
}

#[test]
fn a_surface_that_meets_itself_is_refused() {
    let with = |from, to| [unit(), cuboid(from, to)].concat();
    // Through a side; on a side; in a corner; the same twice is no surface at all.
    assert!(error(&with([0.5, 0.2, 0.2], [1.5, 0.8, 0.8])).contains("meets itself"));
    assert!(error(&with([1.0, 0.2, 0.2], [1.5, 0.8, 0.8])).contains("meets itself"));
    assert!(error(&with([0.5, 0.5, 1.0], [2.0, 2.0, 2.0])).contains("meets itself"));
    assert!(error(&with([0.0; 3], [1.0; 3])).contains("belongs to 4 facets"));
    // Apart by next to nothing.
    assert!(Surface::new(&with([1.0 + 1e-15, 0.2, 0.2], [1.5, 0.8, 0.8])).is_ok());
    // A common vertex alone is no crossing.
    assert!(Surface::new(&with([1.0; 3], [2.0; 3])).is_ok());
    // A spike through the opposite side shares vertices with what it pierces.
    let mut spiked = unit();
    for corner in spiked.iter_mut().flatten().filter(|x| **x == [1.0; 3]) {
        *corner = [-0.5, 0.4, 0.3];
    }
    assert!(error(&spiked).contains("meets itself"), "{}", error(&spiked));
    // A facet and its back enclose nothing.
    let facet = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(Surface::new(&[facet, [facet[0], facet[2], facet[1]]]).is_err());
}

/// All of a plane.
fn plane<const D: usize>(axis: usize, at: f64) -> Face<D> {
    Face { axis, at, within: None }
}

fn axes(cells: u32) -> [Axis; 3] {
    [0.0, -1.0, 2.0].map(|from| Axis::uniform(from, from + 4.0, cells).unwrap())
}

/// Volume, its first and its second moments of what parts stand for.
fn sums<const D: usize>(made: &Parts<D>) -> (f64, Vec<f64>, Vec<f64>) {
    let volume = made.parts.iter().map(|it| it.volume).sum();
    let first = (0..D).map(|d| made.parts.iter().map(|it| it.volume * it.centre[d]).sum()).collect();
    let second = (0..D).map(|d| {
        let square = |it: &Part<D>| it.centre[d].powi(2) + it.half_vectors[(d, d)].powi(2) / 3.0;
        made.parts.iter().map(|it| it.volume * square(it)).sum()
    });
    (volume, first, second.collect())
}

/// `∫ 1, x_d, x_d²` over a tetrahedron.
fn tetrahedron([a, b, c, d]: [Vector3<f64>; 4]) -> (f64, Vec<f64>, Vec<f64>) {
    let volume = (b - a).dot(&(c - a).cross(&(d - a))) / 6.0;
    let corners = [a, b, c, d];
    let sum: Vector3<f64> = corners.iter().sum();
    let squares: Vector3<f64> = corners.iter().map(|x| x.component_mul(x)).sum();
    let second = (squares + sum.component_mul(&sum)) * (volume / 20.0);
    (volume, (sum * (volume / 4.0)).as_slice().to_vec(), second.as_slice().to_vec())
}

#[test]
fn parts_keep_volume_centre_and_mean_squares_exactly() {
    let corners = [[0.3, -0.7, 2.2], [3.6, 0.1, 2.9], [1.1, 2.7, 2.4], [1.7, 0.6, 5.9]].map(Vector3::from);
    let facet = |a: usize, b: usize, c: usize| [a, b, c].map(|k| corners[k].into());
    let surface = Surface::new(&[facet(0, 2, 1), facet(0, 1, 3), facet(1, 2, 3), facet(2, 0, 3)]).unwrap();
    let (volume, first, second) = tetrahedron(corners);
    assert!((surface.volume() / volume - 1.0).abs() < 1e-14);
    for (cells, n) in [(1, 1), (4, 2), (9, 3)] {
        let made = parts(&Solid::Surface(&surface), CLOSED, &axes(cells), n, &[], MEMORY).unwrap();
        let (v, f, s) = sums(&made);
        assert!((v / volume - 1.0).abs() < 1e-12, "{cells}: {v} for {volume}");
        for d in 0..3 {
            assert!((f[d] - first[d]).abs() < 1e-12 * volume * 6.0, "{cells}: {f:?} for {first:?}");
            assert!((s[d] - second[d]).abs() < 1e-12 * volume * 36.0, "{cells}: {s:?} for {second:?}");
        }
        assert!(made.parts.iter().all(|it| it.half_vectors.diagonal().min() > 0.0));
    }
}

#[test]
fn a_box_on_the_lines_is_whole_pieces_also_in_single_precision() {
    let single = |x: f64| f64::from(x as f32);
    let box_ = cuboid([1.0, 0.0, 2.4].map(single), [3.2, 2.2, 5.6].map(single));
    let surface = Surface::new(&box_).unwrap();
    let made = parts(&Solid::Surface(&surface), CLOSED, &axes(10), 2, &[plane(0, 3.2)], MEMORY).unwrap();
    assert_eq!(made.parts.len(), 11 * 11 * 16);
    for part in &made.parts {
        assert!(part.half_vectors.diagonal().iter().all(|half| (half - 0.1).abs() < 1e-14));
        assert!((part.volume - 0.008).abs() < 1e-15);
    }
    // The points next to the face at 3.2 share its area.
    let area: f64 = made.faces[0].iter().map(|it| it.area).sum();
    assert_eq!(made.faces[0].len(), 11 * 16);
    assert!((area - 2.2 * 3.2).abs() < 1e-6, "{area}");
    assert!(made.faces[0].iter().all(|it| (made.parts[it.part].centre.x - 3.1).abs() < 1e-12));
}

#[test]
fn a_box_between_the_lines_is_boxes_of_its_own() {
    let surface = Surface::new(&cuboid([0.5, 0.25, 2.5], [2.95, 1.75, 4.25])).unwrap();
    let made = parts(&Solid::Surface(&surface), CLOSED, &axes(4), 1, &[plane(2, 4.25)], MEMORY).unwrap();
    // 0.95 of a piece is no sliver, and the boxes are those of the parts: cut exactly.
    let (low, high) =
        made.parts.iter().fold((Vector3::repeat(9.0), Vector3::repeat(-9.0)), |(low, high), it| {
            let half = it.half_vectors.diagonal();
            (low.inf(&(it.centre - half)), high.sup(&(it.centre + half)))
        });
    assert!((low - Vector3::new(0.5, 0.25, 2.5)).amax() < 1e-12, "{low}");
    assert!((high - Vector3::new(2.95, 1.75, 4.25)).amax() < 1e-12, "{high}");
    let area: f64 = made.faces[0].iter().map(|it| it.area).sum();
    assert!((area - 2.45 * 1.5).abs() < 1e-12);
}

#[test]
fn slivers_go_to_their_neighbours() {
    let surface = Surface::new(&cuboid([0.0, 0.0, 2.0], [1.05, 1.0, 3.0])).unwrap();
    let made = parts(&Solid::Surface(&surface), CLOSED, &axes(4), 1, &[plane(0, 1.05)], MEMORY).unwrap();
    let [part] = made.parts[..] else { panic!("one part, got {}", made.parts.len()) };
    assert!((part.volume - 1.05).abs() < 1e-12 && (part.centre.x - 0.525).abs() < 1e-12);
    assert!((part.half_vectors[(0, 0)] - 0.525).abs() < 1e-12);
    assert_eq!(made.faces[0].len(), 1);
}

#[test]
fn a_cavity_is_empty_and_a_shell_inside_out_is_refused() {
    let inverted = |mut it: Vec<[[f64; 3]; 3]>| {
        it.iter_mut().for_each(|facet| facet.swap(0, 1));
        it
    };
    let outer = cuboid([0.5, 0.5, 2.5], [3.5, 2.5, 5.5]);
    let inner = cuboid([1.2, 1.2, 3.2], [2.7, 2.2, 4.6]);
    let hollow = Surface::new(&[outer.clone(), inverted(inner.clone())].concat()).unwrap();
    let made = parts(&Solid::Surface(&hollow), CLOSED, &axes(8), 2, &[], MEMORY).unwrap();
    let volume: f64 = made.parts.iter().map(|it| it.volume).sum();
    assert!((volume - (3.0 * 2.0 * 3.0 - 1.5 * 1.0 * 1.4)).abs() < 1e-12, "{volume}");
    let twice = Surface::new(&[outer, inner].concat()).unwrap();
    let said = parts(&Solid::Surface(&twice), CLOSED, &axes(8), 2, &[], MEMORY).unwrap_err();
    assert!(said.contains("more than once"), "{said}");
}

#[test]
fn round_bodies_far_from_the_origin_are_as_good_as_near_it() {
    let axes = [Axis::uniform(5e6, 5e6 + 6.0, 12).unwrap(), Axis::uniform(-6e5, -6e5 + 6.0, 12).unwrap()];
    let round = Round { axis: 2, centre: [5e6 + 1.0, -6e5 + 3.0], inner: 0.0, outer: 0.7, ends: (0.0, 1.0) };
    let made = parts(&Solid::Round(round), [false; 2], &axes, 2, &[], MEMORY).unwrap();
    let (volume, ..) = sums(&made);
    // Of coordinates of seven digits nine are left behind the point.
    assert!((volume / round.volume() - 1.0).abs() < 1e-7, "{volume}");
}

#[test]
fn round_bodies_have_their_volume_wherever_their_axis_lies() {
    for axis in 0..3 {
        for inner in [0.0, 0.6] {
            let middle = [2.0, 1.0, 4.0];
            let mut centre = [0, 1, 2].into_iter().filter(|d| *d != axis).map(|d| middle[d] + 0.03);
            let centre = [centre.next().unwrap(), centre.next().unwrap()];
            let ends = (middle[axis] - 1.3, middle[axis] + 1.1);
            let round = Round { axis, centre, inner, outer: 1.4, ends };
            let surface = round.surface(1e-3);
            assert!((surface.volume() / round.volume() - 1.0).abs() < 1e-12, "{}", surface.volume());
            let made =
                parts(&Solid::Round(round), CLOSED, &axes(8), 2, &[plane(axis, ends.1)], MEMORY).unwrap();
            let (volume, first, _) = sums(&made);
            assert!((volume / round.volume() - 1.0).abs() < 1e-9, "{axis}, {inner}: {volume}");
            for d in 0..3 {
                let expected = if d == axis { middle[d] - 0.1 } else { middle[d] + 0.03 };
                assert!((first[d] / volume - expected).abs() < 1e-9, "{axis}, {inner}, {d}");
            }
            let area: f64 = made.faces[0].iter().map(|it| it.area).sum();
            assert!((area / (round.volume() / 2.4) - 1.0).abs() < 1e-9, "{axis}, {inner}: {area}");
        }
    }
}

#[test]
fn a_disc_is_a_cylinder_of_the_plane() {
    let axes = [0.0, 0.0].map(|from| Axis::uniform(from, 4.0, 8).unwrap());
    let round = Round { axis: 2, centre: [2.0, 2.0], inner: 0.0, outer: 1.7, ends: (0.0, 1.0) };
    let made = parts::<2>(&Solid::Round(round), [false; 2], &axes, 3, &[], MEMORY).unwrap();
    let (volume, first, second) = sums(&made);
    assert!((volume / (std::f64::consts::PI * 1.7 * 1.7) - 1.0).abs() < 1e-9);
    assert!(first.iter().all(|it| (it / volume - 2.0).abs() < 1e-9));
    // r²/4 about the middle, of a polygon that stands off by a thousandth of a piece.
    assert!(second.iter().all(|it| (it / volume - 4.0 - 1.7 * 1.7 / 4.0).abs() < 1e-3));
}

/// Symmetry planes through the axis leave a half and a quarter, planes beside it what a closed form says.
#[test]
fn symmetry_planes_cut_round_bodies() {
    let mesh = |from: [f64; 3]| from.map(|from| Axis::uniform(from, from + 4.0, 8).unwrap());
    for axis in 0..3 {
        let across = [0, 1, 2].into_iter().filter(|d| *d != axis).collect::<Vec<_>>();
        let round = Round { axis, centre: [1.0, 2.0], inner: 0.4, outer: 0.9, ends: (0.5, 1.5) };
        let mut from = [0.0; 3];
        from[across[0]] = 1.0;
        let (mut open, mut share) = ([false; 3], 0.5);
        open[across[0]] = true;
        for quarter in [false, true] {
            if quarter {
                from[across[1]] = 2.0;
                open[across[1]] = true;
                share = 0.25;
            }
            let made = parts(&Solid::Round(round), open, &mesh(from), 2, &[plane(axis, 1.5)], MEMORY).unwrap();
            let (volume, first, _) = sums(&made);
            assert!((volume / (share * round.volume()) - 1.0).abs() < 1e-9, "{axis}: {volume}");
            assert!((made.volume.unwrap() / volume - 1.0).abs() < 1e-9);
            let area: f64 = made.faces[0].iter().map(|it| it.area).sum();
            assert!((area / volume - 1.0).abs() < 1e-9, "{axis}: {area}");
            // Centroid of half a ring, 4 (R³ - r³)/(3π (R² - r²)) from the plane; its polygon stands a little off.
            let expected =
                4.0 * (0.9_f64.powi(3) - 0.4_f64.powi(3)) / (3.0 * std::f64::consts::PI * (0.81 - 0.16));
            let apart = first[across[0]] / volume - 1.0;
            assert!((apart / expected - 1.0).abs() < 1e-3, "{axis}: {apart} {expected}");
            let inside = |x: &[f64]| (0..3).all(|d| x[d] >= from[d] - 1e-12);
            assert!(made.parts.iter().all(|it| inside((it.centre - it.half_vectors.diagonal()).as_slice())));
        }
    }
}

#[test]
fn spheres_have_their_volume_whole_and_in_parts() {
    let ball = crate::Ball { centre: [0.0, 2.0, 2.0], radius: 1.3 };
    let mesh = |from: [f64; 3]| from.map(|from| Axis::uniform(from, from + 4.0, 10).unwrap());
    let whole = parts(&Solid::Ball(ball), CLOSED, &mesh([-2.0, 0.0, 0.0]), 2, &[], MEMORY).unwrap();
    let (volume, first, second) = sums(&whole);
    assert!((volume / ball.volume() - 1.0).abs() < 1e-9, "{volume}");
    assert!((0..3).all(|d| (first[d] / volume - ball.centre[d]).abs() < 1e-9));
    // R²/5 about the centre.
    assert!((0..3).all(|d| (second[d] / volume - ball.centre[d].powi(2) - 1.69 / 5.0).abs() < 1e-3));
    for (from, open, share) in [
        ([0.0, 0.0, 0.0], [true, false, false], 0.5),
        ([0.0, 2.0, 0.0], [true, true, false], 0.25),
        ([0.0, 2.0, 2.0], [true, true, true], 0.125),
        // A cap above half the radius: π h² (3R - h)/3.
        ([0.65, 0.0, 0.0], [true, true, true], 5.0 / 32.0),
    ] {
        let made = parts(&Solid::Ball(ball), open, &mesh(from), 2, &[], MEMORY).unwrap();
        let found = sums(&made).0 / ball.volume();
        let tolerance = if from[0] == 0.65 { 1e-4 } else { 1e-9 };
        assert!((found / share - 1.0).abs() < tolerance, "{from:?}: {found}");
    }
    // On the upper side of the mesh, too.
    let made = parts(&Solid::Ball(ball), [true; 3], &mesh([-4.0, 0.0, 0.0]), 2, &[], MEMORY).unwrap();
    assert!((sums(&made).0 / ball.volume() - 0.5).abs() < 1e-9);
    let said = parts(&Solid::Ball(ball), CLOSED, &mesh([0.0; 3]), 2, &[], MEMORY).unwrap_err();
    assert!(said.contains("along x, outside the mesh"), "{said}");
    let said = parts(&Solid::Ball(ball), [true; 3], &mesh([5.0; 3]), 2, &[], MEMORY).unwrap_err();
    assert!(said.contains("too small for the mesh"), "{said}");
}

/// A box in a quarter of space, without what a cylinder about its edge takes of it.
#[test]
fn a_box_is_left_of_what_a_symmetry_plane_cuts() {
    let axes = [0.0; 3].map(|from| Axis::uniform(from, 4.0, 8).unwrap());
    let round = Round { axis: 2, centre: [0.0, 0.0], inner: 0.0, outer: 1.2, ends: (0.0, 4.0) };
    let left = crate::rest((&[0.0; 3], &[4.0; 3]), &[Solid::Round(round)], &axes, 2, MEMORY).unwrap();
    let volume: f64 = left.parts.iter().map(|it| it.volume).sum();
    assert!((volume - (64.0 - 0.25 * round.volume())).abs() < 1e-9, "{volume}");
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let surface = Surface::new(&cuboid([0.5, 0.5, 2.5], [4.5, 1.0, 3.0])).unwrap();
    let said = parts(&Solid::Surface(&surface), CLOSED, &axes(8), 2, &[], MEMORY).unwrap_err();
    assert!(said.contains("along x, outside the mesh from 0 to 4"), "{said}");
    let said = parts(
        &Solid::Surface(&Surface::new(&unit()).unwrap().placed(0.5, &[0.5, 0.0, 3.0])),
        CLOSED,
        &axes(8),
        u32::MAX,
        &[],
        MEMORY,
    );
    assert!(said.unwrap_err().contains("too many"));
}

#[test]
fn pieces_that_there_is_no_room_for_are_refused_before_they_are_held() {
    let surface = Surface::new(&cuboid([0.5, -0.5, 2.5], [3.5, 2.5, 5.5])).unwrap();
    let within = |bytes, n| parts(&Solid::Surface(&surface), CLOSED, &axes(8), n, &[], MemoryLimit { bytes });
    // 6³ pieces.
    let n_pieces = within(u64::MAX, 1).unwrap().parts.len();
    assert_eq!(n_pieces, 216);
    let needed = (216 * BYTES_OF_PIECE) as u64;
    assert!(within(needed, 1).is_ok());
    let said = within(needed - 1, 1).unwrap_err();
    assert!(said.contains("2.160e2 pieces of the body would take"), "{said}");
    let said = within(1 << 20, 100_000).unwrap_err();
    assert!(said.contains("6e5 material points along"), "{said}");
    let said = within(1 << 24, 200).unwrap_err();
    assert!(said.contains("a layer of pieces around the body would take"), "{said}");
    let rest = |bytes| {
        let ends = (&[0.0, -1.0, 2.0], &[4.0, 3.0, 6.0]);
        crate::rest(ends, &[Solid::Surface(&surface)], &axes(8), 1, MemoryLimit { bytes })
    };
    assert_eq!(rest(u64::MAX).unwrap().parts.len(), 512 - 216);
    let said = rest((512 * BYTES_OF_PIECE - 1) as u64).unwrap_err();
    assert!(said.contains("5.120e2 pieces of the body would take"), "{said}");
    // A film has less volume than its pieces could hold: it is counted as it is cut.
    let film = Surface::new(&cuboid([0.5, -0.5, 2.6], [3.5, 2.5, 2.7])).unwrap();
    let said = parts(
        &Solid::Surface(&film),
        CLOSED,
        &axes(8),
        1,
        &[],
        MemoryLimit { bytes: 20 * BYTES_OF_PIECE as u64 },
    );
    assert!(said.unwrap_err().contains("3.600e1 pieces of the body"));
}
