//! Ghost stabilisation: what it must not touch, what it must hold, and a value by hand.

use mpm_assembly::{
    Body, Constraints, GhostFaces, MaterialBody, PassInput, SparsityPattern, Sums, TangentSums, finish_tangent,
};
use mpm_basis::{ActiveNodes, Basis, Connectivity, Cpdi1, Cpdi2q, Gimp, Smpm, seed_cells};
use mpm_grid::{
    Axis, Block, Layout, LoadFraction, Mesh, MeshMotion, NodeSpace, Ramp, Reindexing, Span, Vector,
};
use mpm_material::{Elasticity, Hencky};

const YOUNG: f64 = 30.0;

struct Setup<const D: usize> {
    mesh: Mesh<D>,
    active: ActiveNodes<D>,
    pattern: SparsityPattern<D>,
    faces: GhostFaces<D>,
}

/// One point in the middle of each of the chosen cells.
fn setup<const D: usize, B: Basis<D> + 'static>(
    basis: B,
    mesh: Mesh<D>,
    chosen: impl Fn([u32; D]) -> bool,
) -> Setup<D> {
    let points = seed_cells(&basis, &mesh, mesh.cells().filter(|&index| chosen(index)), 1);
    let law = Hencky(Elasticity::from_young_poisson(YOUNG, 0.0).unwrap());
    let body = MaterialBody::new(basis, law, points);
    let stencils = body.stencils(&mesh).unwrap();
    let active = ActiveNodes::of(&nodes(&mesh), std::slice::from_ref(&stencils));
    let connectivity = [Connectivity::of(stencils, &active)];
    let mut cells = Vec::new();
    body.occupied_cells(&connectivity[0], &mesh, &active, &mut cells).unwrap();
    let faces = GhostFaces::of(&mesh, &active, cells, (1.0 / 30.0, body.space()));
    let pattern = SparsityPattern::of(active.len(), body.symmetry(), &[&connectivity[0], &faces]);
    Setup { mesh, active, pattern, faces }
}

/// The nodes of the functions of a mesh.
fn nodes<const D: usize>(mesh: &Mesh<D>) -> NodeSpace<D> {
    NodeSpace::of(mesh.functions(), mesh).unwrap()
}

fn layout<const D: usize>(cells: u32) -> Layout<D> {
    let axes = std::array::from_fn(|d| Axis::geometric(0.0, 4.0, cells + d as u32, 1.5).unwrap());
    Layout::<D>::on_axes(axes).unwrap()
}

fn grid<const D: usize>(cells: u32) -> Mesh<D> {
    Mesh::at_rest(&layout(cells))
}

fn splines<const D: usize>(degree: u32) -> Mesh<D> {
    Mesh::at_rest(&layout(6).with_splines(degree).unwrap())
}

fn inside<const D: usize>(index: [u32; D]) -> bool {
    index.iter().all(|&i| (1..4).contains(&i))
}

impl<const D: usize> Setup<D> {
    fn field(&self, field: impl Fn(Vector<D>) -> Vector<D>) -> Vec<Vector<D>> {
        self.active.nodes().iter().map(|&node| field(nodes(&self.mesh).position(&self.mesh, node))).collect()
    }

    fn sum(
        &self,
        increment: &[Vector<D>],
        constraints: &Constraints<D>,
    ) -> (Vec<Vector<D>>, Vec<f64>, Vec<Vector<D>>) {
        let mut force = vec![Vector::zeros(); self.active.len()];
        let mut lift = force.clone();
        let mut values = vec![0.0; self.pattern.n_entries()];
        let input = PassInput { pattern: &self.pattern, constraints, increment, own: &[] };
        let tangent = Some(TangentSums { values: &mut values, lift: Some(&mut lift), own_lift: &mut [] });
        let sums = Sums { internal: &mut force, own: &mut [], tangent };
        self.faces.assemble(&self.faces.slots(&self.pattern), input, sums);
        (force, values, lift)
    }

    /// The stored lower triangle times a vector.
    fn times(&self, values: &[f64], u: &[Vector<D>]) -> Vec<Vector<D>> {
        let flat: Vec<f64> = u.iter().flat_map(|u| u.iter().copied()).collect();
        let mut product = vec![0.0; flat.len()];
        for column in 0..flat.len() {
            let stored = self.pattern.column_start()[column]..self.pattern.column_start()[column + 1];
            for (&row, value) in self.pattern.row()[stored.clone()].iter().zip(&values[stored]) {
                product[row] += value * flat[column];
                if row != column {
                    product[column] += value * flat[row];
                }
            }
        }
        product.chunks_exact(D).map(Vector::from_column_slice).collect()
    }
}

fn largest<const D: usize>(field: &[Vector<D>]) -> f64 {
    field.iter().map(|f| f.amax()).fold(0.0, f64::max)
}

fn wave<const D: usize>(x: Vector<D>) -> Vector<D> {
    Vector::from_fn(|i, _| (1.3 * x[i] + 0.7 * x[(i + 1) % D] + i as f64).sin())
}

fn checks<const D: usize>(setup: &Setup<D>, straight: bool) {
    assert!(!setup.faces.is_empty());
    let n = setup.active.len();
    let free = Constraints::none(n);
    let waves = setup.field(wave);
    let (force, values, _) = setup.sum(&waves, &free);
    assert!(largest(&force) > 1e-3);

    let gradient = Block::<D>::from_fn(|i, j| 0.3 * i as f64 - 0.2 * j as f64 + 0.1);
    let (of_linear, _, _) = setup.sum(&setup.field(|x| gradient * x + Vector::repeat(3.0)), &free);
    assert!(largest(&of_linear) < 1e-12, "a uniform gradient is resisted: {}", largest(&of_linear));

    // The tangent is the derivative of the force, and no mode loses energy.
    let product = setup.times(&values, &waves);
    let error = force.iter().zip(&product).map(|(f, p)| (f - p).amax()).fold(0.0, f64::max);
    assert!(error < 1e-12 * largest(&force).max(1.0), "{error}");
    assert!(waves.iter().zip(&force).map(|(u, f)| u.dot(f)).sum::<f64>() > 0.0);
    let total: Vector<D> = force.iter().sum();
    assert!(total.amax() < 1e-12, "forces do not balance: {total}");
    if straight {
        // Bilinear in the cells, with a gradient that jumps nowhere.
        let (of_product, _, _) = setup.sum(&setup.field(|x| Vector::repeat(x[0] * x[1])), &free);
        assert!(largest(&of_product) < 1e-12);
    }

    let mut held = Constraints::none(n);
    for v in (0..n).step_by(3) {
        held.prescribe(v, v % D, 0.1 + v as f64);
    }
    let (_, masked, lift) = setup.sum(&waves, &held);
    let expected = setup.times(&values, held.increment());
    assert!(lift.iter().zip(&expected).all(|(a, b)| (a - b).amax() < 1e-11 * n as f64));
    let mut masked = masked;
    finish_tangent(&setup.pattern, &held, &mut masked);
    let mut freed = waves.clone();
    held.free_part(&mut freed);
    let (mut a, mut b) = (setup.times(&masked, &freed), setup.times(&values, &freed));
    held.free_part(&mut a);
    held.free_part(&mut b);
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).amax() < 1e-12));
}

#[test]
fn it_resists_jumps_and_nothing_else_in_the_plane() {
    checks(&setup(Smpm, grid::<2>(6), inside), true);
    checks(&setup(Gimp::default(), grid::<2>(6), inside), true);
    checks(&setup(Cpdi1, grid::<2>(6), inside), true);
    checks(&setup(Cpdi2q::default(), grid::<2>(6), inside), true);
}

#[test]
fn it_resists_jumps_and_nothing_else_in_space() {
    checks(&setup(Smpm, grid::<3>(5), inside), true);
    checks(&setup(Cpdi1, grid::<3>(5), inside), true);
}

#[test]
fn it_does_so_between_splines() {
    for degree in 2..=3 {
        checks(&setup(Smpm, splines::<2>(degree), inside), true);
        checks(&setup(Cpdi1, splines::<2>(degree), inside), true);
    }
    checks(&setup(Cpdi1, splines::<3>(2), inside), true);
    let shift = |x, y| [Ramp::linear(x), Ramp::linear(y)];
    let bend = MeshMotion::corners(vec![shift(0.0, 0.4), shift(0.5, 0.0), shift(-0.3, 0.2), shift(0.4, 0.6)]);
    let bent = bend.unwrap().mesh_at(&layout(6).with_splines(2).unwrap(), LoadFraction::END).unwrap();
    checks(&setup(Cpdi2q::default(), bent, inside), false);
    let ring =
        Layout::<2>::ring([1.0, 2.0], Axis::uniform(5.0, 10.0, 6).unwrap(), 16, Span::Full, None).unwrap();
    let ring = Mesh::at_rest(&ring.with_splines(3).unwrap());
    checks(
        &setup(Cpdi2q::default(), ring, |[theta, r]| (theta < 2 || theta == 15) && (1..4).contains(&r)),
        false,
    );
}

/// `u = (x − a)²₊` is a spline with a kink of its second derivative at the face x = a.
#[test]
fn a_jump_of_the_second_derivative_by_hand() {
    let axes = [Axis::uniform(0.0, 8.0, 4).unwrap(), Axis::uniform(0.0, 2.0, 1).unwrap()];
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes(axes).unwrap().with_splines(2).unwrap());
    let setup = setup(Smpm, mesh, |[i, _]| i == 1 || i == 2);
    assert_eq!(setup.faces.len(), 1);
    // Coefficients of splines of degree 2 by their blossom, the product of the distances of two knots above 4.
    let lattice = setup.active.space().lattice();
    let knot = |k: u32| 2.0 * f64::from(k.saturating_sub(2).min(4));
    let coefficient = |i: u32| (knot(i + 1) - 4.0).max(0.0) * (knot(i + 2) - 4.0).max(0.0);
    let u: Vec<Vector<2>> = setup
        .active
        .nodes()
        .iter()
        .map(|&v| Vector::<2>::new(coefficient(lattice.node_index(v)[0]), 0.0))
        .collect();
    let (force, _, _) = setup.sum(&u, &Constraints::none(setup.active.len()));
    let energy = 0.5 * u.iter().zip(&force).map(|(u, f)| u.dot(f)).sum::<f64>();
    // ½ γ h³ [u'']² A with γ = E/30, h = 2, [u''] = 2 and A = 2.
    let expected = 0.5 * YOUNG / 30.0 * 8.0 * 4.0 * 2.0;
    assert!((energy / expected - 1.0).abs() < 1e-13, "{energy} for {expected}");
}

#[test]
fn it_does_so_on_a_twisted_ring() {
    let radii = Axis::uniform(5.0, 10.0, 6).unwrap();
    let layout = Layout::<2>::ring([1.0, 2.0], radii, 16, Span::Full, None).unwrap();
    let inner = (5.0, Ramp::linear(0.9));
    let outer = (10.0, Ramp::linear(0.0));
    let motion = MeshMotion::twist([1.0, 2.0], inner, outer, Reindexing::WholeCells).unwrap();
    let mesh = motion.mesh_at(&layout, LoadFraction::END).unwrap();
    // Only the sectors from the last to the second, across the seam.
    checks(&setup(Smpm, mesh, |[theta, r]| (theta < 2 || theta == 15) && (1..4).contains(&r)), false);
}

#[test]
fn two_cells_side_by_side_by_hand() {
    // Squares of side 2 in a row of four; the middle two hold material.
    let axes = [Axis::uniform(0.0, 8.0, 4).unwrap(), Axis::uniform(0.0, 2.0, 1).unwrap()];
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes(axes).unwrap());
    let setup = setup(Smpm, mesh, |[i, _]| i == 1 || i == 2);
    assert_eq!(setup.faces.len(), 1);
    // u_x = |x - 4|: the gradient jumps from -1 to 1 over a face of 2, so the energy is
    // ½ γ h/3 · 2² · 2 with γ = E/30 and h = 2.
    let u = setup.field(|x| Vector::<2>::new((x[0] - 4.0).abs(), 0.0));
    let (force, _, _) = setup.sum(&u, &Constraints::none(setup.active.len()));
    let energy = 0.5 * u.iter().zip(&force).map(|(u, f)| u.dot(f)).sum::<f64>();
    let expected = 0.5 * YOUNG / 30.0 * 2.0 / 3.0 * 4.0 * 2.0;
    assert!((energy - expected).abs() < 1e-13, "{energy} for {expected}");
}

#[test]
fn only_faces_at_the_edge_of_the_body_are_penalised() {
    // 5 × 5 cells of material inside 7 × 7: of 40 inner faces, those between the 9 cells inside are spared.
    let axis = || Axis::uniform(0.0, 7.0, 7).unwrap();
    let mesh = || Mesh::at_rest(&Layout::<2>::on_axes([axis(), axis()]).unwrap());
    let inner = setup(Smpm, mesh(), |index| index.iter().all(|&i| (1..6).contains(&i)));
    assert_eq!(inner.faces.len(), 40 - 12);
    // The edge of the mesh is none of the body.
    let full = setup(Smpm, mesh(), |_| true);
    assert!(full.faces.is_empty());
    // A slit one cell wide is not bridged, although all its nodes are active.
    let slit = setup(Smpm, mesh(), |index| index[0] != 3);
    assert_eq!(slit.faces.len(), 2 * 7 + 2 * 6);
}
