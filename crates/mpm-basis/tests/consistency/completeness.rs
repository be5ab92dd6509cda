//! `Σ S = 1`, `Σ ∇S = 0`, `Σ x_v ⊗ ∇S_v = I`, `Σ S_v x_v` = the point's position.

use crate::random::{Case, Random, cases, spline_cases};
use mpm_basis::{
    ActiveNodes, Basis, Completeness, Convection, CornerPoint, CornerWeights, Cpdi1, Cpdi2Hexahedron,
    Cpdi2Tetrahedron, Cpdi2q, Cpdi2t, Fallback, FallbackDomain, Gimp, HalfLengths, Influence, Smpm, Stencil,
    Stencils,
};
use mpm_grid::{Block, LinearCell, Mesh, NodeSpace, OutsideMesh, Vector};

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
    reproduced_in_the_plane(&mut Random::new(1), cases);
    reproduced_in_the_plane(&mut Random::new(11), spline_cases);
}

fn reproduced_in_the_plane(random: &mut Random, cases: fn(&mut Random) -> Vec<Case<2>>) {
    for _ in 0..300 {
        for case in cases(random) {
            check_all(&case, random);
            let named = |basis| format!("{basis}, {}", case.name);

            let quad = case.quadrilateral(random);
            // The centroid from two triangles of either diagonal cut.
            let [a, b, c, d] = quad.corners;
            let area = |a: Vector<2>, b: Vector<2>, c: Vector<2>| (b - a).perp(&(c - a)) / 2.0;
            let (one, two) = (area(a, b, d), area(a, d, c));
            let centroid = ((a + b + d) * one + (a + d + c) * two) / (3.0 * (one + two));
            check(&named("CPDI2q"), &Cpdi2q::default(), &case.mesh, centroid, &quad);

            let rest = case.quadrilateral(random);
            let frozen = mpm_basis::Quadrilateral { corners: quad.corners, ..rest };
            let weigh = |corners: &[Vector<2>; 4]| corner_weights(corners);
            let position = weigh(&rest.corners).iter().zip(quad.corners).map(|(w, x)| x * *w).sum();
            let basis = Cpdi2q { weights: CornerWeights::Frozen };
            check(&named("CPDI2q frozen"), &basis, &case.mesh, position, &frozen);

            let triangle = case.simplex(random);
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
    reproduced_in_space(&mut Random::new(2), cases);
    reproduced_in_space(&mut Random::new(12), spline_cases);
}

fn reproduced_in_space(random: &mut Random, cases: fn(&mut Random) -> Vec<Case<3>>) {
    for _ in 0..100 {
        for case in cases(random) {
            check_all(&case, random);
            let named = |basis| format!("{basis}, {}", case.name);

            let hexahedron = case.hexahedron(random);
            let centroid = volume_centroid(&hexahedron.corners);
            check(&named("hexahedron"), &Cpdi2Hexahedron, &case.mesh, centroid, &hexahedron);

            let tetrahedron = case.simplex(random);
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

/// Corners of domains carry their own positions, by nodes that the point influences, and move with the field.
#[test]
fn corners_on_splines_move_with_the_nodes() {
    let mut random = Random::new(4);
    for case in (0..100).flat_map(|seed| spline_cases::<2>(&mut Random::new(seed))) {
        let space = NodeSpace::of(case.mesh.functions(), &case.mesh).unwrap();
        let domain = case.parallelepiped(&mut random);
        let of_point = influences(&Cpdi1, &case.mesh, &case.x, &domain).unwrap();
        let point = CornerPoint {
            position: case.x,
            reference_size: 1.0,
            volume: 1.0,
            is_ring: false,
            deformation_gradient: Block::identity(),
        };
        let mut corners = Vec::new();
        Cpdi1.corners(&case.mesh, &point, &domain, &mut corners).unwrap();
        assert_eq!(corners.len(), 4);
        let (mut share, mut area) = (0.0, Vector::<2>::zeros());
        for corner in &corners {
            let mut x = Vector::<2>::zeros();
            for (node, weight) in corner.weights() {
                x += space.position(&case.mesh, node) * weight;
                assert!(of_point.iter().any(|it| it.node == node), "{node:?}");
            }
            assert!((x - corner.position).norm() < 1e-13);
            share += corner.share;
            area += corner.area;
        }
        assert!((share - 1.0).abs() < 1e-15 && area.norm() < 1e-12);

        let gradient = random.block::<2>(0.2);
        let mut quad = case.quadrilateral(&mut random);
        let stencils = [Stencils::of(&Cpdi2q::default(), &case.mesh, &[case.x], &[quad]).unwrap()];
        let active = ActiveNodes::of(&space, &stencils);
        let moved: Vec<_> =
            active.nodes().iter().map(|&node| gradient * space.position(&case.mesh, node)).collect();
        let step = Convection {
            displacement: Vector::zeros(),
            deformation_gradient: Block::identity() + gradient,
            mesh: &case.mesh,
            active: &active,
            increment: &moved,
        };
        let before = quad.corners;
        let mut x = case.x;
        Cpdi2q::default().convect(&mut quad, &mut x, &step).unwrap();
        for (now, before) in quad.corners.iter().zip(before) {
            assert!((now - before - gradient * before).norm() < 1e-13);
        }
    }
}

#[test]
fn bases_of_boxes_refuse_splines() {
    for case in spline_cases::<2>(&mut Random::new(3)) {
        let refused = Basis::<2>::suits(&Gimp::default(), &case.mesh).unwrap_err();
        assert!(refused.starts_with("GIMP averages linear functions"), "{refused}");
        let fallback = Fallback { basis: Cpdi2q::default(), beyond: 1.0 };
        assert!(Basis::<2>::suits(&fallback, &case.mesh).is_ok());
    }
}

#[test]
fn gimp_refuses_other_meshes() {
    for case in cases::<2>(&mut Random::new(3)) {
        let verdict = Basis::<2>::suits(&Gimp::default(), &case.mesh);
        assert_eq!(verdict.is_ok(), case.name == "graded box", "{}", case.name);
    }
}
