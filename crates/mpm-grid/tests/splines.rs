//! B-splines as functions of a mesh: completeness, gradients, nodes at faces, and what is refused.

use mpm_grid::{
    Axis, Block, DrivenPlane, Layout, LayoutError, LoadFraction, Mesh, MeshMotion, MotionError, NodeKind,
    NodeSpace, Place, Ramp, Region, Reindexing, Span, Vector,
};
use std::f64::consts::{PI, TAU};

fn box_layout() -> Layout<2> {
    let x = Axis::geometric(-1.0, 2.0, 5, 3.0).unwrap();
    Layout::on_axes([x, Axis::uniform(0.1, 0.7, 4).unwrap()]).unwrap()
}

fn solid_layout() -> Layout<3> {
    let axis = |from, to, n| Axis::uniform(from, to, n).unwrap();
    let z = Axis::graded(vec![0.0, 0.5, 0.7, 2.0]).unwrap();
    Layout::on_axes([axis(0.0, 1.0, 3), axis(-1.0, 0.0, 1), z]).unwrap()
}

fn ring_layout() -> Layout<2> {
    Layout::ring([0.3, -0.2], Axis::geometric(1.0, 2.0, 4, 2.0).unwrap(), 7, Span::Full, None).unwrap()
}

fn solid_ring() -> Layout<3> {
    let height = Axis::graded(vec![0.0, 0.4, 1.0]).unwrap();
    Layout::ring([0.0, 0.0], Axis::uniform(1.0, 2.0, 2).unwrap(), 9, Span::Full, Some(height)).unwrap()
}

fn plane(displacement: f64) -> Option<DrivenPlane> {
    Some(DrivenPlane { anchor: 0.1, driven: 0.4, displacement: Ramp::linear(displacement) })
}

/// The meshes of boxes in the plane.
fn boxes(degree: u32) -> Vec<Mesh<2>> {
    let layout = box_layout().with_splines(degree).unwrap();
    let at = |motion: MeshMotion<2>| motion.mesh_at(&layout, LoadFraction::END).unwrap();
    let shift = |x, y| [Ramp::linear(x), Ramp::linear(y)];
    vec![
        Mesh::at_rest(&layout),
        at(MeshMotion::stretch([None, plane(0.2)]).unwrap()),
        at(MeshMotion::corners(vec![shift(0.0, 0.1), shift(0.3, 0.0), shift(0.2, 0.1), shift(-0.1, 0.4)])
            .unwrap()),
        at(MeshMotion::rotate([0.5, 0.5], Ramp::linear(0.7)).unwrap()),
    ]
}

fn rings(degree: u32) -> Vec<Mesh<2>> {
    let layout = ring_layout().with_splines(degree).unwrap();
    let turned = MeshMotion::rotate([0.1, 0.0], Ramp::linear(2.0)).unwrap();
    let driven = DrivenPlane { anchor: 2.0, driven: 1.0, displacement: Ramp::linear(0.1) };
    vec![
        Mesh::at_rest(&layout),
        turned.mesh_at(&layout, LoadFraction::END).unwrap(),
        MeshMotion::expand(driven).unwrap().mesh_at(&layout, LoadFraction::END).unwrap(),
    ]
}

/// Numbers in (0, 1) that fill it evenly.
fn share(k: u32, step: f64) -> f64 {
    (0.37 + step * f64::from(k)).fract()
}

/// Places all over a mesh and up to half a cell outside of it.
fn places<const D: usize>(mesh: &Mesh<D>) -> Vec<Place<D>> {
    let steps = [0.618_033_988_7, 0.414_213_562_4, 0.732_050_807_6];
    let (cells, closed) = (mesh.lattice().cells(), mesh.lattice().periodic());
    let mut places = Vec::new();
    for k in 0..300 {
        let mut place = Place { cell: [0; D], local: Vector::zeros() };
        for d in 0..D {
            let n = f64::from(cells[d]);
            // From half a cell below the mesh to half a cell above it, and the faces between cells.
            let at = if closed[d] { n * share(k, steps[d]) } else { (n + 1.0) * share(k, steps[d]) - 0.5 };
            let at = if k % 7 == 0 { at.round() } else { at };
            let cell = at.floor().clamp(0.0, n - 1.0);
            place.cell[d] = cell as u32;
            place.local[d] = 2.0 * (at - cell) - 1.0;
        }
        places.push(place);
    }
    places
}

/// Largest errors of `Σ N = 1`, `Σ X N = x`, `Σ ∇N = 0` and `Σ X ⊗ ∇N = I`, over the sizes of the terms.
fn incompleteness<const D: usize>(mesh: &Mesh<D>) -> [f64; 4] {
    let nodes = NodeSpace::of(mesh.functions(), mesh).unwrap();
    let mut worst = [0.0_f64; 4];
    for place in places(mesh) {
        let (mut one, mut x, mut zero, mut identity) =
            (0.0, Vector::<D>::zeros(), Vector::<D>::zeros(), Block::<D>::zeros());
        let (mut slopes, mut moments) = (0.0, 0.0);
        mesh.values_and_gradients(&place, |node, value, gradient| {
            let position = nodes.position(mesh, node);
            one += value;
            x += position * value;
            zero += gradient;
            identity += position * gradient.transpose();
            slopes += gradient.norm();
            moments += position.norm() * gradient.norm();
        });
        // The place of the position that they describe is the place that they came from.
        let back = mesh.locate(&x, 0.6).unwrap();
        let apart = (0..D).map(|d| {
            let ahead = f64::from(back.cell[d]) - f64::from(place.cell[d]);
            let apart = 2.0 * ahead + back.local[d] - place.local[d];
            let round = 2.0 * f64::from(mesh.lattice().cells()[d]);
            if mesh.lattice().periodic()[d] { apart - round * (apart / round).round() } else { apart }
        });
        let found = [
            (one - 1.0).abs(),
            apart.map(f64::abs).fold(0.0, f64::max),
            zero.norm() / slopes,
            (identity - Block::identity()).norm() / moments,
        ];
        for (worst, found) in worst.iter_mut().zip(found) {
            assert!(found.is_finite());
            *worst = worst.max(found);
        }
        let mut sum = 0.0;
        mesh.values(&place, |_, value| sum += value);
        assert!((sum - one).abs() < 1e-15);
    }
    worst
}

#[test]
fn linear_fields_are_reproduced_inside_and_half_a_cell_outside() {
    let check = |worst: [f64; 4], of: &str| {
        assert!(worst[0] < 1e-14 && worst[2] < 1e-14 && worst[3] < 1e-14, "{of}: {worst:?}");
        // Local coordinates next to ±1 are snapped by 2e-9; otherwise rounding of a position in extents of a cell.
        assert!(worst[1] < 1e-12, "{of}: {worst:?}");
    };
    for degree in 1..=3 {
        for (k, mesh) in boxes(degree).iter().enumerate() {
            check(incompleteness(mesh), &format!("box {k} of degree {degree}"));
        }
        check(incompleteness(&Mesh::at_rest(&solid_layout().with_splines(degree).unwrap())), "solid");
    }
    for degree in 2..=3 {
        for (k, mesh) in rings(degree).iter().enumerate() {
            check(incompleteness(mesh), &format!("ring {k} of degree {degree}"));
        }
        check(incompleteness(&Mesh::at_rest(&solid_ring().with_splines(degree).unwrap())), "solid ring");
    }
}

/// Largest difference of gradients and central differences of values, over the largest gradient.
fn slope_error(mesh: &Mesh<2>) -> f64 {
    let mut worst = 0.0_f64;
    for place in places(mesh).into_iter().filter(|it| it.local.amax() < 0.9) {
        let mut x = Vector::<2>::zeros();
        let nodes = NodeSpace::of(mesh.functions(), mesh).unwrap();
        mesh.values(&place, |node, value| x += nodes.position(mesh, node) * value);
        let values = |x: &Vector<2>| {
            let mut found = Vec::new();
            mesh.values(&mesh.locate(x, 0.5).unwrap(), |node, value| found.push((node, value)));
            found
        };
        let mut gradients = Vec::new();
        mesh.values_and_gradients(&place, |node, _, gradient| gradients.push((node, gradient)));
        let largest = gradients.iter().map(|it| it.1.norm()).fold(0.0, f64::max);
        for d in 0..2 {
            let mut step = Vector::<2>::zeros();
            step[d] = 1e-6;
            let (above, below) = (values(&(x + step)), values(&(x - step)));
            for (k, (node, gradient)) in gradients.iter().enumerate() {
                assert!(above[k].0 == *node && below[k].0 == *node);
                worst = worst.max(((above[k].1 - below[k].1) / 2e-6 - gradient[d]).abs() / largest);
            }
        }
    }
    worst
}

#[test]
fn gradients_are_differences_of_values() {
    for degree in 2..=3 {
        for mesh in boxes(degree).iter().chain(&rings(degree)) {
            let error = slope_error(mesh);
            assert!(error < 1e-8, "degree {degree}: {error:e}");
        }
    }
}

#[test]
fn products_of_directions_are_the_values() {
    for mesh in boxes(2).iter().chain(&rings(3)) {
        for place in places(mesh) {
            let product = mesh.spline_product(&place).unwrap();
            let mut entries = product.entries();
            mesh.values(&place, |node, value| {
                let (same, found) = entries.next().unwrap();
                assert!(same == node && (found - value).abs() < 1e-15);
            });
            assert!(entries.next().is_none());
        }
    }
    assert!(
        Mesh::at_rest(&box_layout()).spline_product(&Place { cell: [0; 2], local: Vector::zeros() }).is_none()
    );
}

/// Along each direction the lower derivatives are continuous at faces, and highest ones those of differences.
#[test]
fn highest_derivatives_are_those_of_the_values() {
    for mesh in [boxes(2).remove(0), boxes(3).remove(0), rings(2).remove(0), rings(3).remove(0)] {
        for direction in 0..2 {
            let cell = [1, 1];
            for at_end in [false, true] {
                let found = mesh.highest_derivatives(cell, direction, at_end).unwrap();
                let local = |share: f64| {
                    let mut local = Vector::<2>::zeros();
                    local[direction] = 2.0 * share - 1.0;
                    mesh.spline_product(&Place { cell, local }).unwrap().values[direction]
                };
                // Differences of the order within the cell, near the end in question.
                let h = 1e-3;
                let start = if at_end { 1.0 - 3.0 * h } else { 0.0 };
                let at: Vec<[f64; 4]> = (0..4).map(|k| local(start + f64::from(k) * h)).collect();
                for (k, value) in found.values.iter().enumerate().take(found.count) {
                    let of = |n: usize| at[n][k];
                    let difference = match found.order {
                        2 => of(2) - 2.0 * of(1) + of(0),
                        _ => of(3) - 3.0 * of(2) + 3.0 * of(1) - of(0),
                    };
                    let expected = difference / (h * found.extent).powi(found.order as i32);
                    let size = found.values.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
                    // Curvatures change along a sector, by its angle times the step.
                    assert!((value - expected).abs() < 5e-3 * size, "{expected} {found:?}");
                }
            }
        }
    }
}

#[test]
fn regions_pick_the_control_points_on_faces() {
    let layout = box_layout().with_splines(3).unwrap();
    let nodes = NodeSpace::of(layout.functions(), &Mesh::at_rest(&layout)).unwrap();
    let base = Region::Plane { axis: 1, at: 0.1 }.nodes(&nodes, &layout);
    assert_eq!(base.len(), 8);
    assert!(base.iter().all(|&node| nodes.interpolates_at(node)));
    let ring = ring_layout().with_splines(2).unwrap();
    let nodes = NodeSpace::of(ring.functions(), &Mesh::at_rest(&ring)).unwrap();
    for radius in [1.0, 2.0] {
        let circle = Region::Circle { centre: [0.3, -0.2], radius }.nodes(&nodes, &ring);
        assert!(circle.len() == 7 && circle.iter().all(|&node| nodes.interpolates_at(node)));
    }
    assert!(Region::Circle { centre: [0.3, -0.2], radius: 1.5 }.nodes(&nodes, &ring).is_empty());
    let whole = Region::Everywhere.nodes(&nodes, &ring);
    assert_eq!((whole.len(), whole.iter().filter(|&&node| nodes.interpolates_at(node)).count()), (7 * 6, 14));
}

#[test]
fn the_displacement_of_a_rotation_keeps_its_digits() {
    let layout = ring_layout().with_splines(2).unwrap();
    let motion = MeshMotion::rotate([0.3, -0.2], Ramp::linear(1e-9)).unwrap();
    let mesh = Mesh::at_rest(&layout);
    let nodes = NodeSpace::of(layout.functions(), &mesh).unwrap();
    let node = nodes.lattice().node([2, 3]);
    let moved =
        nodes.displacement((&motion, &layout), node, &mesh, (LoadFraction::START, LoadFraction::END)).unwrap();
    let arm = nodes.position(&mesh, node) - Vector::<2>::new(0.3, -0.2);
    assert!((moved - Vector::<2>::new(-arm.y, arm.x) * 1e-9).norm() < 1e-17);
    // Outside the circle of its Greville radius, half a sector before its line.
    let angle = (2.0 - 0.5) * TAU / 7.0;
    assert!((arm.y.atan2(arm.x) - angle).abs() < 1e-14);
    assert!(arm.norm() * (PI / 7.0).cos() < 2.0);
}

#[test]
fn pieces_of_round_cells_have_their_corners_on_circles() {
    let layout = Layout::ring([0.0; 2], Axis::uniform(1.0, 2.0, 2).unwrap(), 8, Span::Full, None).unwrap();
    let mesh = Mesh::at_rest(&layout.with_splines(2).unwrap());
    let piece = mesh.piece([1, 0], &Vector::<2>::new(-1.0, -1.0), &Vector::<2>::new(0.0, 1.0));
    for (corner, (radius, sector)) in
        piece.corners().iter().zip([(1.0, 1.0), (1.0, 1.5), (1.5, 1.0), (1.5, 1.5)])
    {
        let angle: f64 = sector * TAU / 8.0;
        assert!((corner - Vector::<2>::new(angle.cos(), angle.sin()) * radius).norm() < 1e-15);
    }
    let (angle, squares) = (TAU / 16.0, 1.5 * 1.5 - 1.0);
    assert!((piece.volume() - 0.5 * f64::sin(angle) * squares).abs() < 1e-15);
}

#[test]
fn impossible_splines_are_refused() {
    let said = |it: Result<Layout<2>, LayoutError>| it.unwrap_err().to_string();
    assert_eq!(said(box_layout().with_splines(4)), "expected a degree from 1 to 3, got 4");
    assert_eq!(said(box_layout().with_splines(0)), "expected a degree from 1 to 3, got 0");
    assert_eq!(box_layout().with_splines(1), Ok(box_layout()));
    let ring =
        |sectors, span| Layout::<2>::ring([0.0; 2], Axis::uniform(1.0, 2.0, 2).unwrap(), sectors, span, None);
    let sector = Span::Sector { from: 0.0, to: 1.0 };
    assert_eq!(
        said(ring(8, sector).unwrap().with_splines(2)),
        "splines need a full ring: there are none on a sector"
    );
    assert_eq!(
        said(ring(3, Span::Full).unwrap().with_splines(2)),
        "splines need a ring of at least 4 sectors, got 3"
    );
    let layout = ring(8, Span::Full).unwrap().with_splines(2).unwrap();
    let twist =
        MeshMotion::twist([0.0; 2], (1.0, Ramp::linear(0.1)), (2.0, Ramp::linear(0.0)), Reindexing::WholeCells);
    assert_eq!(twist.unwrap().mesh_at(&layout, LoadFraction::END), Err(MotionError::Splines));
    assert_eq!(layout.functions(), NodeKind::ControlPoints { degree: 2 });
}
