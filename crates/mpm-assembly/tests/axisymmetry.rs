//! Bodies of revolution: one cell against a table, tangents, balance, what points remember, and the axis.

mod setup;

use mpm_assembly::{
    Body, BodyLoads, Constraints, Converged, InadmissibleState, MaterialBody, MeanDilatation, PassInput,
    PointView, Space, Sums, body_stiffness_error, views,
};
use mpm_basis::{Basis, Cpdi1, Cpdi2q, Cpdi2t, DomainControl, Gimp, Seed, Smpm, seed_cells};
use mpm_grid::{Axis, Block, Layout, LinearCell, Mesh, Vector};
use mpm_material::{Elasticity, Hencky, Material, MohrCoulomb, VonMises};
use setup::{Setup, apart, connect, field, flat, law, sum, wave};
use std::f64::consts::TAU;

const MEANS: [Option<MeanDilatation>; 3] = [None, Some(MeanDilatation::Points), Some(MeanDilatation::Cell)];

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(1e3, 0.3).unwrap()
}

fn mesh(r: (f64, f64, u32), z: (f64, f64, u32)) -> Mesh<2> {
    let axis = |(from, to, cells)| Axis::uniform(from, to, cells).unwrap();
    Mesh::at_rest(&Layout::<2>::on_axes([axis(r), axis(z)]).unwrap())
}

/// A body of revolution in some cells of a mesh.
fn body<B: Basis<2> + 'static, M: Material + 'static>(
    (basis, law): (B, M),
    mesh: &Mesh<2>,
    cells: impl Fn([u32; 2]) -> bool,
    mean: Option<MeanDilatation>,
) -> Box<dyn Body<2>> {
    let seeds = seed_cells(&basis, mesh, mesh.cells().filter(|index| cells(*index)), 2);
    Box::new(MaterialBody::axisymmetric(basis, law, seeds).with_mean_dilatation(mean))
}

fn free(setup: &Setup<2>) -> Constraints<2> {
    Constraints::none(setup.active.len())
}

fn force(setup: &Setup<2>, increment: &[Vector<2>]) -> Vec<Vector<2>> {
    let mut internal = vec![Vector::zeros(); increment.len()];
    let constraints = free(setup);
    let input = PassInput { pattern: &setup.pattern, constraints: &constraints, increment, own: &[] };
    setup
        .body
        .assemble(&setup.plan, input, Sums { internal: &mut internal, own: &mut [], tangent: None })
        .unwrap();
    internal
}

fn advanced(mut setup: Setup<2>, increment: &[Vector<2>]) -> Setup<2> {
    let step = Converged { mesh: &setup.mesh, active: &setup.active, increment, own: &[] };
    setup.body.prepare(&setup.plan, step).unwrap();
    setup.body.commit();
    connect(setup.body, setup.mesh)
}

/// Columns of `tables/ring_cell.csv`.
fn one_cell<B: Basis<2> + 'static>(name: &str, basis: fn() -> B) {
    let table: Vec<Vec<&str>> =
        include_str!("tables/ring_cell.csv").lines().skip(2).map(|line| line.split(',').collect()).collect();
    for rows in table.chunks(8).filter(|rows| rows[0][0] == name) {
        let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
        let radius = if rows[0][2] == "inf" { 1e9 } else { number(0, 2) };
        let mean = (rows[0][1] == "Points").then_some(MeanDilatation::Points);
        let mesh = mesh((0.5, 0.9, 1), (0.0, 0.3, 1));
        let law = VonMises::new(elasticity(), radius).unwrap();
        let setup = connect(body((basis(), law), &mesh, |_| true, mean), mesh);
        let increment: Vec<Vector<2>> =
            (0..4).map(|v| Vector::<2>::new(number(2 * v, 7), number(2 * v + 1, 7))).collect();
        let (force, values, _) = sum(&setup, &increment, &free(&setup));
        let expected: Vec<f64> = (0..8).map(|row| number(row, 8)).collect();
        assert!(apart(&expected, &flat(&force)) < 1e-12, "{name} {mean:?} {radius}");
        for column in 0..8 {
            let mut unit = vec![Vector::zeros(); 4];
            unit[column / 2][column % 2] = 1.0;
            let found = setup::times(&setup.pattern, &values, &unit);
            let expected: Vec<f64> = (0..8).map(|row| number(row, 9 + column)).collect();
            let error = apart(&expected, &found);
            assert!(error < 1e-12, "{name} {mean:?} {radius}, column {column}: {error:e}");
        }
    }
}

#[test]
fn force_and_tangent_of_one_cell_are_those_of_the_table() {
    one_cell("smpm", || Smpm);
    one_cell("gimp", Gimp::default);
    one_cell("cpdi1", || Cpdi1);
}

fn tangent_is_the_derivative<B: Basis<2> + Clone + 'static>(basis: B) {
    let mesh = mesh((0.0, 2.0, 6), (0.0, 2.0, 5));
    let cells = |index: [u32; 2]| index[0] < 4 && (1..4).contains(&index[1]);
    for mean in MEANS {
        let check = |body: Box<dyn Body<2>>| {
            // From points that are strained, and stand nowhere in particular.
            let rest = connect(body, mesh.clone());
            let onto = |x: &Vector<2>| Vector::<2>::new(0.05 * x[0], 0.0) + wave(0.02, x) * x[0];
            let before: Vec<Vector<2>> =
                rest.active.nodes().iter().map(|&node| onto(&mesh.position(node))).collect();
            let setup = advanced(rest, &before);
            let (error, symmetry) =
                (body_stiffness_error(&*setup.body, &mesh, |x| wave(-0.01, x) * x[0]), setup.body.symmetry());
            let error = error.unwrap();
            println!("{} {mean:?} {symmetry:?}: {error:e}", basis.name());
            assert!(error < 2e-6, "{} {mean:?} {symmetry:?}: {error:e}", basis.name());
            views(&*setup.body).filter(|point| point.plastic).count() as f64 / setup.body.n_points() as f64
        };
        let yielding = check(body((basis.clone(), law()), &mesh, cells, mean));
        assert!(yielding > 0.1, "{yielding}");
        check(body((basis.clone(), Hencky(elasticity())), &mesh, cells, mean));
        let dilating = MohrCoulomb::new(elasticity(), 5.0, 30.0, 5.0).unwrap();
        check(body((basis.clone(), dilating), &mesh, cells, mean));
    }
}

#[test]
fn the_tangent_is_the_derivative_of_the_internal_force() {
    tangent_is_the_derivative(Smpm);
    tangent_is_the_derivative(Gimp::default());
    tangent_is_the_derivative(Cpdi1);
    tangent_is_the_derivative(Cpdi2q::default());
    tangent_is_the_derivative(Cpdi2t::default());
}

/// Contracts a body by 15 and 12 % in 4 steps on a grid that stays: the same stress in all points, and no force on nodes
/// that no end of the body reaches. The body begins at the axis, or at r = 5.
fn patch<B: Basis<2> + Clone + 'static>(basis: B, is_at_axis: bool, law: impl Material + Clone + 'static) {
    const H: f64 = 0.125;
    let (low, first) = if is_at_axis { (0.0, 0) } else { (4.0, 8) };
    for mean in [None, Some(MeanDilatation::Points)] {
        let mesh = mesh((low, low + H * f64::from(first + 8), first + 8), (0.0, 8.0 * H, 8));
        let cells = |index: [u32; 2]| (first..first + 7).contains(&index[0]) && (1..7).contains(&index[1]);
        let mut setup = connect(body((basis.clone(), law.clone()), &mesh, cells, mean), mesh);
        let mut stretches = [1.0; 2];
        let mut inner = 0;
        for step in 1..=4 {
            let next = [0.15, 0.12].map(|it| 1.0 - it * f64::from(step) / 4.0);
            let nodes = setup.active.nodes().to_vec();
            let place = |node| setup.mesh.position(node);
            let by = |x: Vector<2>| Vector::<2>::from_fn(|d, _| (next[d] / stretches[d] - 1.0) * x[d]);
            let increment: Vec<Vector<2>> = nodes.iter().map(|&node| by(place(node))).collect();
            let forces = force(&setup, &increment);
            let size = forces.iter().map(|it| it.norm()).fold(0.0, f64::max);
            let ends = [[low + H * f64::from(first), low + H * f64::from(first + 7)], [H, 7.0 * H]];
            for (&node, force) in nodes.iter().zip(&forces) {
                let x = place(node);
                let inside = |d: usize| {
                    let [from, to] = ends[d].map(|it| it * stretches[d]);
                    (x[d] > from + 1.9 * H || d == 0 && is_at_axis) && x[d] < to - 1.9 * H
                };
                if inside(0) && inside(1) {
                    // Of a node on the axis the radial component is held.
                    let part = if x[0] == 0.0 { force[1].abs() } else { force.norm() };
                    assert!(part < 1e-12 * size, "{} step {step} at {x}: {part:e}", basis.name());
                    inner += 1;
                }
            }
            stretches = next;
            setup = advanced(setup, &increment);
            let [a, b] = stretches;
            let points: Vec<PointView<2>> = views(&*setup.body).collect();
            let first = setup.body.kirchhoff(0);
            for (p, point) in points.iter().enumerate() {
                let apart = (setup.body.kirchhoff(p).to_matrix() - first.to_matrix()).norm();
                assert!(apart < 1e-12 * first.norm(), "{} step {step}: {apart:e}", basis.name());
                assert!((point.hoop_stretch.unwrap() - a).abs() < 1e-13);
                assert!((point.volume_ratio - a * a * b).abs() < 1e-13);
            }
            assert!((first.xx - first.zz).abs() < 1e-12 * first.norm(), "σ_rr = σ_θθ");
        }
        assert!(inner > 8, "{inner}");
    }
}

#[test]
fn a_uniform_stress_leaves_no_force_inside() {
    for is_at_axis in [true, false] {
        patch(Gimp::default(), is_at_axis, law());
        patch(Cpdi1, is_at_axis, law());
        patch(Cpdi2q::default(), is_at_axis, law());
        patch(Cpdi2t::default(), is_at_axis, law());
        patch(Gimp::default(), is_at_axis, Hencky(elasticity()));
        patch(Cpdi1, is_at_axis, Hencky(elasticity()));
        patch(Cpdi2q::default(), is_at_axis, Hencky(elasticity()));
    }
}

/// Smoothly distorted quadrilaterals that tile (0, 1) × (0, 1), on a grid that knows nothing of them.
#[test]
fn distorted_tiles_balance() {
    let mesh = mesh((0.0, 1.3, 7), (-0.2, 1.3, 8));
    let n = 10;
    let corner = |i: usize, j: usize| {
        let (x, y) = (i as f64 / f64::from(n), j as f64 / f64::from(n));
        let bend = 0.06 * (std::f64::consts::PI * x).sin() * (std::f64::consts::PI * y).sin();
        Vector::<2>::new(x + bend, y - 0.7 * bend)
    };
    let mut seeds = Vec::new();
    for (i, j) in (0..n as usize).flat_map(|i| (0..n as usize).map(move |j| (i, j))) {
        let corners = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
        let piece = LinearCell::<2>::new(std::array::from_fn(|c| corners[c % 4]));
        Cpdi2q::default().seed(&piece, &mut |seed| seeds.push(seed));
    }
    let body = MaterialBody::axisymmetric(Cpdi2q::default(), Hencky(elasticity()), seeds);
    let volume: f64 = views(&body).map(|point| point.reference_volume).sum();
    assert!((volume - TAU / 2.0).abs() < 1e-12, "a cylinder of radius and height 1: {volume}");
    let setup = connect(Box::new(body), mesh);
    let nodes = setup.active.nodes().to_vec();
    let place = |x: Vector<2>| Vector::<2>::new(-0.15 * x[0], -0.12 * x[1]);
    let increment: Vec<Vector<2>> = nodes.iter().map(|&node| place(setup.mesh.position(node))).collect();
    let forces = force(&setup, &increment);
    let size = forces.iter().map(|it| it.norm()).fold(0.0, f64::max);
    let mut inner = 0;
    for (node, force) in nodes.iter().zip(&forces) {
        let x = setup.mesh.position(*node);
        if x[0] < 0.75 && x[1] > 0.25 && x[1] < 0.75 {
            inner += 1;
            let part = if x[0] == 0.0 { force[1].abs() } else { force.norm() };
            assert!(part < 1e-13 * size, "at {x}: {part:e} of {size:e}");
        }
    }
    assert!(inner > 8);
}

/// The radius of a point and the stretch of its hoop go together, whatever the displacement.
fn hoop_follows_the_radius<B: Basis<2> + Clone + 'static>(basis: B) {
    let mesh = mesh((0.0, 2.0, 6), (0.0, 2.0, 5));
    let cells = |index: [u32; 2]| index[0] < 4 && (1..4).contains(&index[1]);
    let mut setup = connect(body((basis, law()), &mesh, cells, None), mesh.clone());
    let rest: Vec<f64> = views(&*setup.body).map(|point| point.position[0]).collect();
    for step in 0..5 {
        let onto = |x: &Vector<2>| wave(0.03 + 0.01 * f64::from(step), x) * x[0];
        let increment: Vec<Vector<2>> =
            setup.active.nodes().iter().map(|&node| onto(&mesh.position(node))).collect();
        setup = advanced(setup, &increment);
    }
    for (point, rest) in views(&*setup.body).zip(rest) {
        let error = point.position[0] / rest - point.hoop_stretch.unwrap();
        assert!(error.abs() < 3e-15, "{error:e}");
    }
}

#[test]
fn the_hoop_stretch_is_the_ratio_of_radii() {
    hoop_follows_the_radius(Smpm);
    hoop_follows_the_radius(Gimp::default());
    hoop_follows_the_radius(Cpdi1);
    hoop_follows_the_radius(Cpdi2t::default());
}

/// In the cell at the axis every field with u_r = 0 there has the same stretch along r and the hoop.
#[test]
fn stretches_along_radius_and_hoop_agree_beside_the_axis() {
    let mesh = mesh((0.0, 1.0, 1), (0.0, 1.0, 1));
    let setup = connect(body((Cpdi1, Hencky(elasticity())), &mesh, |_| true, None), mesh.clone());
    let increment = [(0.0, 0.1), (0.2, -0.1), (0.0, 0.0), (-0.1, 0.3)].map(|(r, z)| Vector::<2>::new(r, z));
    let setup = advanced(setup, &increment);
    for point in views(&*setup.body) {
        assert!((point.deformation_gradient[(0, 0)] - point.hoop_stretch.unwrap()).abs() < 1e-14);
    }
}

#[test]
fn two_reversals_are_refused_each_by_itself() {
    let mesh = mesh((0.0, 1.0, 1), (0.0, 1.0, 1));
    let setup = connect(body((Smpm, Hencky(elasticity())), &mesh, |_| true, None), mesh.clone());
    let refusal = |by: [f64; 2]| {
        let increment: Vec<Vector<2>> = setup
            .active
            .nodes()
            .iter()
            .map(|&node| {
                let x = mesh.position(node);
                Vector::<2>::new(by[0] * x[0], by[1] * x[1])
            })
            .collect();
        let constraints = free(&setup);
        let input =
            PassInput { pattern: &setup.pattern, constraints: &constraints, increment: &increment, own: &[] };
        let mut internal = vec![Vector::zeros(); 4];
        let sums = Sums { internal: &mut internal, own: &mut [], tangent: None };
        setup.body.assemble(&setup.plan, input, sums).unwrap_err().reason
    };
    // ΔF_rr and ΔF_θθ are negative, and so is det ΔF_2; with z reversed, too, det ΔF_2 is positive.
    assert!(matches!(refusal([-1.5, 0.0]), InadmissibleState::Inverted { .. }));
    let reason = refusal([-1.5, -1.5]);
    assert!(
        matches!(reason, InadmissibleState::ReachesAxis { hoop } if (hoop + 0.5).abs() < 1e-14),
        "{reason}"
    );
}

/// The dissipation's gradient is that of isochoric flow whose yield stress stays.
#[test]
fn dissipation_has_the_gradient_that_it_says() {
    let mesh = mesh((0.0, 2.0, 4), (0.0, 2.0, 4));
    for mean in MEANS {
        let setup = connect(body((Cpdi1, law()), &mesh, |_| true, mean), mesh.clone());
        let nodes = setup.active.nodes().to_vec();
        let at = |by: f64| -> Vec<Vector<2>> {
            let place = |x: Vector<2>| Vector::<2>::new(0.08 * x[0], -0.15 * x[1]) + wave(0.01 + by, &x) * x[0];
            nodes.iter().map(|&node| place(mesh.position(node))).collect()
        };
        let energy = |by: f64| {
            let mut gradient = vec![Vector::zeros(); nodes.len()];
            let energy = setup.body.dissipation(&setup.plan, (&at(by), &[]), &mut gradient).unwrap();
            (energy, gradient)
        };
        let (_, gradient) = energy(0.0);
        let step = 1e-6;
        let difference = (energy(step).0 - energy(-step).0) / (2.0 * step);
        let along: f64 = at(1.0).iter().zip(at(0.0)).zip(&gradient).map(|((a, b), g)| (a - b).dot(g)).sum();
        assert!((along / difference - 1.0).abs() < 0.05, "{mean:?}: {along} {difference}");
    }
}

/// Σ f = m g, and the resultant's place is the centre of mass: a disc weighs its outer nodes more.
#[test]
fn weights_go_to_nodes_by_the_radius() {
    let mesh = mesh((0.0, 1.0, 1), (0.0, 1.0, 1));
    let seeds = seed_cells(&Cpdi1, &mesh, mesh.cells(), 1);
    let body = MaterialBody::axisymmetric(Cpdi1, Hencky(elasticity()), seeds).with_density(3.0);
    let setup = connect(Box::new(body), mesh);
    let acceleration = Some(Vector::<2>::new(0.0, -10.0));
    let mut external = vec![Vector::zeros(); 4];
    let loads = BodyLoads { acceleration, ..BodyLoads::default() };
    setup.body.external_force(setup.plan.connectivity(), &loads, &mut external);
    let weight = 30.0 * TAU / 2.0;
    // ∫ (1 - r) 2π r dr = π/3 of π, half of it at each end.
    for (v, part) in [1.0 / 6.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0].into_iter().enumerate() {
        assert!((external[v][1] + weight * part).abs() < 1e-13 * weight, "{external:?}");
        assert_eq!(external[v][0], 0.0);
    }
}

/// Points split by the volumes of their rings.
#[test]
fn parts_have_the_volume_of_their_rings() {
    let mesh = mesh((0.0, 2.0, 8), (0.0, 2.0, 8));
    let sides = Block::<2>::new(0.5, 0.0, 0.0, 0.1);
    let domain = mpm_basis::Parallelepiped::at_rest(sides);
    let seed = Seed { position: Vector::<2>::new(0.6, 1.0), volume: 0.2, domain };
    let mut body = MaterialBody::axisymmetric(Cpdi1, Hencky(elasticity()), [seed]).with_density(2.0);
    let whole = body.point(0).reference_volume;
    assert!((whole - TAU * 0.6 * 0.2).abs() < 1e-15);
    let done = body.control(&mesh, DomainControl::Split { cells: 1.0 }, 100).unwrap();
    assert_eq!((done.split, body.n_points()), (1, 4));
    assert_eq!(body.space(), Space::Axisymmetric);
    let mut sum = 0.0;
    for point in views(&body) {
        assert!((point.reference_volume / (TAU * point.position[0] * 0.05) - 1.0).abs() < 1e-14);
        assert_eq!(point.hoop_stretch, Some(1.0));
        sum += point.reference_volume;
    }
    assert!((sum / whole - 1.0).abs() < 1e-14);
}

#[test]
fn stored_points_come_back_and_foreign_ones_are_refused() {
    let mesh = mesh((0.0, 2.0, 4), (0.0, 2.0, 4));
    let made = || connect(body((Cpdi1, law()), &mesh, |_| true, None), mesh.clone());
    let setup = made();
    let onto = |x: &Vector<2>| wave(0.03, x) * x[0];
    let increment: Vec<Vector<2>> =
        setup.active.nodes().iter().map(|&node| onto(&mesh.position(node))).collect();
    let setup = advanced(setup, &increment);
    let stored = setup.body.store();
    let mut other = made().body;
    other.restore(&stored).unwrap();
    assert!(views(&*other).eq(views(&*setup.body)));
    let mut refused = |change: &dyn Fn(&mut mpm_assembly::StoredPoints)| {
        let mut stored = stored.clone();
        change(&mut stored);
        other.restore(&stored).unwrap_err().to_string()
    };
    let place = |name: &str| stored.columns.iter().position(|it| it.name == name).unwrap();
    let (hoop, position) = (place("hoop_stretch"), place("position"));
    assert_eq!(
        refused(&|it| it.columns[hoop].values[3] = -1.0),
        "hoop_stretch: is -1 at point 3, expected above 0"
    );
    assert_eq!(
        refused(&|it| it.columns[position].values[0] = -0.5),
        "position: point 0: its radius is -0.5, expected above 0"
    );
    let flat = MaterialBody::new(Cpdi1, law(), seed_cells(&Cpdi1, &mesh, mesh.cells(), 2));
    let error = refused(&|it| *it = flat.store());
    assert_eq!(error, "hoop_stretch: expected 1 numbers per point");
}

/// Far from the axis a body is one in plane strain, `2πr` thick.
#[test]
fn far_from_the_axis_a_ring_is_plane() {
    const FAR: f64 = 1e6;
    for mean in [None, Some(MeanDilatation::Points)] {
        let plane = setup::setup(Cpdi1, law(), 7, 1, mean);
        let axes = [(FAR, 7), (0.0, 8)].map(|(at, cells)| Axis::geometric(at, at + 3.0, cells, 1.5).unwrap());
        let mesh = Mesh::at_rest(&Layout::<2>::on_axes(axes).unwrap());
        let inner = |index: [u32; 2]| (1..6).contains(&index[0]) && (1..7).contains(&index[1]);
        let ring = connect(body((Cpdi1, law()), &mesh, inner, mean), mesh);
        let increment = field(&plane, 0.02);
        let expected = flat(&force(&plane, &increment));
        let found: Vec<f64> = flat(&force(&ring, &increment)).iter().map(|it| it / (TAU * FAR)).collect();
        // With mean dilatation the hoop takes part in what is averaged.
        let error = apart(&expected, &found);
        assert!(error < if mean.is_none() { 2e-5 } else { 0.05 }, "{mean:?}: {error:e}");
    }
}
