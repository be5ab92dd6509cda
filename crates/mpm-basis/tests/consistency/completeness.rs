//! `Σ S = 1`, `Σ ∇S = 0`, `Σ x_v ⊗ ∇S_v = I`, `Σ S_v x_v` = the point's position.

use crate::random::{Case, Random, cases};
use mpm_basis::{
    Basis, Completeness, CornerWeights, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, Fallback,
    FallbackDomain, Gimp, HalfLengths, Influence, Smpm, Stencil,
};
use mpm_grid::{Block, LinearCell, Mesh, OutsideMesh, Vector};

pub fn influences<const D: usize, B: Basis<D>>(
    basis: &B,
    mesh: &Mesh<D>,
    x: &Vector<D>,
    domain: &B::Domain,
) -> Result<Vec<Influence<D>>, OutsideMesh<D>> {
    let mut stencil = Stencil::new();
    basis.influences(mesh, x, domain, &mut stencil)?;
    stencil.finish();
    assert!(stencil.entries().windows(2).all(|pair| pair[0].node < pair[1].node), "ascending in node");
    Ok(stencil.entries().to_vec())
}

/// `x` is where the point must be.
pub fn check<const D: usize, B: Basis<D>>(
    name: &str,
    basis: &B,
    mesh: &Mesh<D>,
    x: Vector<D>,
    domain: &B::Domain,
) {
    let found = Completeness::of(basis, mesh, &x, domain).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(found.is_within(1e-12), "{name}: {found}");
    assert!(found.unity < 1e-13, "{name}: {found}");
}

/// Bases that exist in any dimension.
fn check_all<const D: usize>(case: &Case<D>, random: &mut Random) {
    let named = |basis| format!("{basis}, D = {D}, {}", case.name);
    check(&named("sMPM"), &Smpm, &case.mesh, case.x, &());
    check(&named("CPDI1"), &Cpdi1, &case.mesh, case.x, &case.parallelepiped(random));
    if Basis::<D>::suits(&Gimp::default(), &case.mesh).is_ok() {
        for size in [0.01, 0.25, 0.5, 0.8, 1.6] {
            let mut domain = HalfLengths::at_rest(Vector::repeat(1.0));
            domain.current = Vector::from_fn(|_, _| case.h * size * random.between(0.5, 1.0));
            check(&named("GIMP"), &Gimp::default(), &case.mesh, case.x, &domain);
        }
    }
    let fallen = FallbackDomain::Fallen(case.parallelepiped(random));
    check(&named("fallen"), &Fallback { basis: Smpm, beyond: 0.0 }, &case.mesh, case.x, &fallen);
}

#[test]
fn linear_fields_are_reproduced_in_the_plane() {
    let mut random = Random::new(1);
    for _ in 0..300 {
        for case in cases::<2>(&mut random) {
            check_all(&case, &mut random);
            let named = |basis| format!("{basis}, {}", case.name);

            let quad = case.quadrilateral(&mut random);
            // The centroid from two triangles of either diagonal cut.
            let [a, b, c, d] = quad.corners;
            let area = |a: Vector<2>, b: Vector<2>, c: Vector<2>| (b - a).perp(&(c - a)) / 2.0;
            let (one, two) = (area(a, b, d), area(a, d, c));
            let centroid = ((a + b + d) * one + (a + d + c) * two) / (3.0 * (one + two));
            check(&named("CPDI2q"), &Cpdi2q::default(), &case.mesh, centroid, &quad);

            let rest = case.quadrilateral(&mut random);
            let frozen = mpm_basis::Quadrilateral { corners: quad.corners, ..rest };
            let weigh = |corners: &[Vector<2>; 4]| corner_weights(corners);
            let position = weigh(&rest.corners).iter().zip(quad.corners).map(|(w, x)| x * *w).sum();
            let basis = Cpdi2q { weights: CornerWeights::Frozen };
            check(&named("CPDI2q frozen"), &basis, &case.mesh, position, &frozen);

            let triangle = case.simplex(&mut random);
            let centroid = (triangle.first + triangle.others[0] + triangle.others[1]) / 3.0;
            check(&named("CPDI2t"), &Cpdi2t::default(), &case.mesh, centroid, &triangle);
        }
    }
}

/// `(1/A) ∫ M_c dA` by 3 × 3 Gauss points.
pub fn corner_weights(corners: &[Vector<2>; 4]) -> [f64; 4] {
    let cell = LinearCell::new(std::array::from_fn(|c| corners[c % 4]));
    let a = 0.6_f64.sqrt();
    let (mut area, mut weights) = (0.0, [0.0; 4]);
    for (xi, w_xi) in [(-a, 5.0), (0.0, 8.0), (a, 5.0)] {
        for (eta, w_eta) in [(-a, 5.0), (0.0, 8.0), (a, 5.0)] {
            let local = Vector::<2>::new(xi, eta);
            let share = cell.determinant(&local) * w_xi * w_eta;
            area += share;
            for (weight, m) in weights.iter_mut().zip(LinearCell::values(&local)) {
                *weight += m * share;
            }
        }
    }
    weights.map(|it| it / area)
}

#[test]
fn linear_fields_are_reproduced_in_space() {
    let mut random = Random::new(2);
    for _ in 0..100 {
        for case in cases::<3>(&mut random) {
            check_all(&case, &mut random);
            let named = |basis| format!("{basis}, {}", case.name);

            let hexahedron = case.hexahedron(&mut random);
            let centroid = volume_centroid(&hexahedron.corners);
            check(&named("hexahedron"), &Cpdi2Hexahedron, &case.mesh, centroid, &hexahedron);

            let tetrahedron = case.simplex(&mut random);
            let centroid = (tetrahedron.first + tetrahedron.others.iter().sum::<Vector<3>>()) / 4.0;
            check(&named("tetrahedron"), &Cpdi2Tetrahedron, &case.mesh, centroid, &tetrahedron);
        }
    }
}

/// `∫ x dV / ∫ dV` by 3 × 3 × 3 Gauss points.
fn volume_centroid(corners: &[Vector<3>; 8]) -> Vector<3> {
    let cell = LinearCell::new(*corners);
    let a = 0.6_f64.sqrt();
    let rule = [(-a, 5.0), (0.0, 8.0), (a, 5.0)];
    let (mut volume, mut moment) = (0.0, Vector::<3>::zeros());
    for (xi, w_xi) in rule {
        for (eta, w_eta) in rule {
            for (zeta, w_zeta) in rule {
                let local = Vector::<3>::new(xi, eta, zeta);
                let share = cell.determinant(&local) * w_xi * w_eta * w_zeta;
                volume += share;
                moment += cell.position(&local) * share;
            }
        }
    }
    moment / volume
}

#[test]
fn parts_outside_the_mesh_see_the_boundary_cell_continued() {
    use mpm_grid::{Axis, Layout};
    let axis = Axis::graded(vec![0.0, 1.0, 3.0]).unwrap();
    let mesh = Mesh::at_rest(&Layout::<2>::on_axes([axis.clone(), axis]).unwrap());
    // The last cell is 2 wide: half a cell is 1.
    let inside = Vector::<2>::new(2.5, 0.5);
    let mut box_domain = HalfLengths::at_rest(Vector::<2>::new(1.4, 0.9));
    check("GIMP", &Gimp::default(), &mesh, inside, &box_domain);
    box_domain.current.x = 1.6;
    let error = influences(&Gimp::default(), &mesh, &inside, &box_domain).unwrap_err();
    assert_eq!(error.position, Vector::<2>::new(4.1, 0.5));
    assert!((error.distance - 0.55).abs() < 1e-14);

    let mut domain = mpm_basis::Parallelepiped::at_rest(Block::<2>::new(1.0, 0.4, 0.0, 0.3));
    check("CPDI1", &Cpdi1, &mesh, inside, &domain);
    let report = Cpdi1.diagnose(&mesh, &inside, &domain).unwrap();
    assert_eq!(report.corners_outside, 2);
    domain.current = Block::<2>::new(1.3, 0.4, 0.0, 0.3);
    let error = influences(&Cpdi1, &mesh, &inside, &domain).unwrap_err();
    assert!((error.position - Vector::<2>::new(4.2, 0.8)).norm() < 1e-15);
    assert!(error.to_string().starts_with("(4.2, 0.8) lies 0.6 cells"), "{error}");
}

#[test]
fn gimp_refuses_other_meshes() {
    for case in cases::<2>(&mut Random::new(3)) {
        let verdict = Basis::<2>::suits(&Gimp::default(), &case.mesh);
        assert_eq!(verdict.is_ok(), case.name == "graded box", "{}", case.name);
    }
}
