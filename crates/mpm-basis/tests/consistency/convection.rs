//! Domains through a load step: affine motions, volumes, failures and remedies.

use crate::completeness::{check, influences};
use crate::random::{Case, Random, cases};
use mpm_basis::{
    ActiveNodes, Basis, Convection, ConvectionError, CornerWeights, Cpdi1, Cpdi2Hexahedron, Cpdi2Tetrahedron,
    Cpdi2q, Cpdi2t, Domain, Fallback, FallbackDomain, Gimp, GimpUpdate, HalfLengths, Parallelepiped,
    Quadrilateral, Simplex, Smpm, Stencils,
};
use mpm_grid::{Axis, Block, Layout, Mesh, NodeSpace, Vector};

/// A point carried through a step in which node v moves by `field(x_v)`.
struct Step<const D: usize, Domain> {
    position: Vector<D>,
    domain: Domain,
    /// `I + Σ_v Δu_v ⊗ ∇S_vp`.
    deformation: Block<D>,
    outcome: Result<(), ConvectionError>,
}

fn step<const D: usize, B: Basis<D>>(
    basis: &B,
    mesh: &Mesh<D>,
    x: Vector<D>,
    domain: &B::Domain,
    mut field: impl FnMut(Vector<D>) -> Vector<D>,
) -> Step<D, B::Domain> {
    let stencils = Stencils::of(basis, mesh, &[x], std::slice::from_ref(domain)).unwrap();
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), &[stencils]);
    let increment: Vec<Vector<D>> = active.nodes().iter().map(|&v| field(mesh.position(v))).collect();
    let (mut displacement, mut deformation) = (Vector::zeros(), Block::identity());
    for entry in influences(basis, mesh, &x, domain).unwrap() {
        if let Some(v) = active.number(entry.node) {
            displacement += increment[v] * entry.value;
            deformation += increment[v] * entry.gradient.transpose();
        }
    }
    let (mut position, mut domain) = (x, domain.clone());
    let convection = Convection {
        displacement,
        deformation_gradient: deformation,
        mesh,
        active: &active,
        increment: &increment,
    };
    let outcome = basis.convect(&mut domain, &mut position, &convection);
    Step { position, domain, deformation, outcome }
}

fn simplices_keep_step<const D: usize, B: Basis<D, Domain = Simplex<D>>>(basis: &B, random: &mut Random) {
    for case in cases::<D>(random) {
        let domain = case.simplex(random);
        let shift = domain.volume().abs().powf(1.0 / D as f64) * 0.1;
        let step = step(basis, &case.mesh, case.x, &domain, |_| random.vector(shift));
        if step.outcome.is_err() {
            continue;
        }
        let ratio = step.domain.volume() / domain.volume();
        let error =
            ratio / step.deformation.try_inverse().map_or(f64::NAN, |_| determinant(&step.deformation)) - 1.0;
        assert!(error.abs() < 1e-12, "{}: {error:e}", case.name);
    }
}

fn determinant<const D: usize>(f: &Block<D>) -> f64 {
    Block::<3>::from_fn(|i, j| if i < D && j < D { f[(i, j)] } else { f64::from(u8::from(i == j)) })
        .determinant()
}

#[test]
fn volumes_of_simplices_follow_the_deformation_gradient() {
    let mut random = Random::new(10);
    for _ in 0..200 {
        simplices_keep_step(&Cpdi2t::default(), &mut random);
        simplices_keep_step(&Cpdi2Tetrahedron, &mut random);
    }
}

/// Under an affine field of displacements every corner moves with it, and so does the point.
fn moves_affinely<const D: usize, B: Basis<D>>(basis: &B, case: &Case<D>, x: Vector<D>, domain: &B::Domain) {
    let name = case.name;
    let mut random = Random::new(11);
    let (gradient, shift) = (random.block::<D>(0.1), random.vector::<D>(0.1));
    let field = |x: Vector<D>| gradient * x + shift;
    let step = step(basis, &case.mesh, x, domain, field);
    step.outcome.unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!((step.position - x - field(x)).norm() < 1e-12, "{name}");
    let before = domain.outline(&x);
    let after = step.domain.outline(&step.position);
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(after) {
        assert!((after - before - field(*before)).norm() < 1e-11, "{name}");
    }
    check(name, basis, &case.mesh, step.position, &step.domain);
}

#[test]
fn affine_fields_carry_domains_along() {
    let mut random = Random::new(12);
    for _ in 0..20 {
        for case in cases::<2>(&mut random) {
            moves_affinely(&Smpm, &case, case.x, &());
            let half_vectors = case.half_edges * 0.3;
            moves_affinely(&Cpdi1, &case, case.x, &Parallelepiped::at_rest(half_vectors));
            let fallback = Fallback { basis: Cpdi2q::default(), beyond: 1.0 };
            Cpdi2q::default().seed(&case.mesh.linear_cell([3, 3]), &mut |seed| {
                moves_affinely(&Cpdi2q::default(), &case, seed.position, &seed.domain);
                let frozen = Cpdi2q { weights: CornerWeights::Frozen };
                moves_affinely(&frozen, &case, seed.position, &seed.domain);
                let domain = FallbackDomain::Sound { domain: seed.domain, half_vectors };
                moves_affinely(&fallback, &case, seed.position, &domain);
            });
            Cpdi2t::default().seed(&case.mesh.linear_cell([3, 3]), &mut |seed| {
                moves_affinely(&Cpdi2t::default(), &case, seed.position, &seed.domain);
            });
        }
        for case in cases::<3>(&mut random) {
            Cpdi1.seed(&case.mesh.linear_cell([2, 2, 2]), &mut |seed| {
                moves_affinely(&Cpdi1, &case, seed.position, &seed.domain);
            });
            Cpdi2Hexahedron.seed(&case.mesh.linear_cell([2, 2, 2]), &mut |seed| {
                moves_affinely(&Cpdi2Hexahedron, &case, seed.position, &seed.domain);
            });
            Cpdi2Tetrahedron.seed(&case.mesh.linear_cell([2, 2, 2]), &mut |seed| {
                moves_affinely(&Cpdi2Tetrahedron, &case, seed.position, &seed.domain);
            });
        }
    }
}

/// Five by five unit cells (by five).
fn unit_cells<const D: usize>() -> Mesh<D> {
    let axis = Axis::uniform(0.0, 5.0, 5).unwrap();
    Mesh::at_rest(&Layout::<D>::on_axes(std::array::from_fn(|_| axis.clone())).unwrap())
}

/// A step with a given F; nodes rest.
fn with_gradient<const D: usize, B: Basis<D>>(
    basis: &B,
    domain: &B::Domain,
    f: Block<D>,
) -> (Result<(), ConvectionError>, B::Domain) {
    let mesh = unit_cells::<D>();
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), &[]);
    let mut domain = domain.clone();
    let mut position = Vector::repeat(2.5);
    let convection = Convection {
        displacement: Vector::zeros(),
        deformation_gradient: f,
        mesh: &mesh,
        active: &active,
        increment: &[],
    };
    (basis.convect(&mut domain, &mut position, &convection), domain)
}

#[test]
fn half_lengths_follow_their_update() {
    let f = Block::<2>::new(-0.4, -1.1, 0.9, -0.2);
    let l0 = Vector::<2>::new(0.3, 0.5);
    let domain = HalfLengths::at_rest(l0);
    let lengths = |update, f| {
        let (outcome, domain) = with_gradient(&Gimp { update }, &domain, f);
        outcome.map(|()| domain.current.component_div(&l0))
    };
    let j: f64 = 1.07;
    let c = f.transpose() * f;
    let scale = (c.trace() + 2.0 * j).sqrt();
    let u = Vector::<2>::new((c[(0, 0)] + j) / scale, (c[(1, 1)] + j) / scale);
    assert!((lengths(GimpUpdate::Stretch, f).unwrap() - u).norm() < 1e-15);
    assert!((lengths(GimpUpdate::Volume, f).unwrap() - Vector::repeat(j.sqrt())).norm() < 1e-15);
    assert_eq!(lengths(GimpUpdate::Fixed, f).unwrap(), Vector::<2>::repeat(1.0));
    assert_eq!(lengths(GimpUpdate::Diagonal, f.transpose() * -1.0).unwrap(), Vector::<2>::new(0.4, 0.2));
    // Past a quarter turn.
    let error = lengths(GimpUpdate::Diagonal, f).unwrap_err();
    assert_eq!(error, ConvectionError::HalfLength { axis: 0, half_length: -0.4 * 0.3 });

    let stretch = Block::<3>::from_diagonal(&Vector::<3>::new(2.0, 0.5, 3.0));
    let cube = HalfLengths::at_rest(Vector::<3>::repeat(0.1));
    let (_, stretched) = with_gradient(&Gimp::default(), &cube, stretch);
    assert!((stretched.current - Vector::<3>::new(0.2, 0.05, 0.3)).norm() < 1e-15);
}

#[test]
fn a_negative_volume_ratio_is_refused() {
    let mirror = Block::<2>::new(-2.0, 0.0, 0.0, 1.0);
    let inverted = |volume| Err(ConvectionError::Inverted { volume });
    let half = Parallelepiped::at_rest(Block::<2>::identity() * 0.5);
    assert_eq!(with_gradient(&Cpdi1, &half, mirror).0, inverted(-2.0));
    let half = HalfLengths::at_rest(Vector::<2>::repeat(0.5));
    for update in [GimpUpdate::Stretch, GimpUpdate::Diagonal, GimpUpdate::Volume, GimpUpdate::Fixed] {
        assert_eq!(with_gradient(&Gimp { update }, &half, mirror).0, inverted(-2.0));
    }
    let nan = with_gradient(&Cpdi1, &Parallelepiped::at_rest(Block::<2>::identity()), mirror * f64::NAN).0;
    assert!(matches!(nan, Err(ConvectionError::Inverted { .. })));
}

/// Seeds the middle cell and folds it over its middle plane.
fn fold<const D: usize, B: Basis<D>>(basis: &B) -> Vec<Result<(), ConvectionError>> {
    let mesh = unit_cells::<D>();
    let mut outcomes = Vec::new();
    basis.seed(&mesh.linear_cell([2; D]), &mut |seed| {
        let mirrored = |x: Vector<D>| Vector::from_fn(|d, _| if d == 0 { 2.0 * (2.5 - x[0]) } else { 0.0 });
        outcomes.push(step(basis, &mesh, seed.position, &seed.domain, mirrored).outcome);
    });
    outcomes
}

#[test]
fn folded_domains_are_refused() {
    let all_inverted = |outcomes: Vec<Result<(), ConvectionError>>, volume: f64| {
        assert!(!outcomes.is_empty());
        for outcome in outcomes {
            let Err(ConvectionError::Inverted { volume: found }) = outcome else { panic!("{outcome:?}") };
            assert!((found + volume).abs() < 1e-14, "{found}");
        }
    };
    all_inverted(fold::<2, _>(&Cpdi2q::default()), 1.0);
    all_inverted(fold::<2, _>(&Cpdi2q { weights: CornerWeights::Frozen }), 1.0);
    all_inverted(fold::<2, _>(&Cpdi2t::default()), 0.25);
    all_inverted(fold::<3, _>(&Cpdi2Hexahedron), 1.0);
    all_inverted(fold::<3, _>(&Cpdi2Tetrahedron), 1.0 / 6.0);
}

#[test]
fn corners_far_outside_end_the_step() {
    let mesh = unit_cells::<2>();
    let at = |x, y| Vector::<2>::new(x, y);
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), &[]);
    let convection = Convection {
        displacement: at(0.0, 0.0),
        deformation_gradient: Block::identity(),
        mesh: &mesh,
        active: &active,
        increment: &[],
    };
    for (out, outcome) in [(5.4, true), (5.6, false)] {
        let mut domain = Simplex::at_rest(at(4.5, 4.5), [at(out, 4.5), at(4.5, 4.9)]);
        let found = Cpdi2t::default().convect(&mut domain, &mut at(4.8, 4.6), &convection);
        assert_eq!(found.is_ok(), outcome, "{found:?}");
        if let Err(error) = found {
            assert!(matches!(error, ConvectionError::Outside(_)));
            assert!(error.to_string().contains("5.6"), "{error}");
        }
    }
}

/// Hourglass displacements of the cell around (2.5, 2.5).
fn hourglass(size: f64) -> impl Fn(Vector<2>) -> Vector<2> {
    move |x| Vector::<2>::new(size * 4.0 * (x.x - 2.5) * (x.y - 2.5), 0.0)
}

#[test]
fn distorted_domains_fall_back_only_beyond_the_limit() {
    let mesh = unit_cells::<2>();
    let x = Vector::<2>::new(2.5, 2.5);
    let basis = Fallback { basis: Cpdi2q::default(), beyond: 0.5 };
    let mut seeds = Vec::new();
    basis.seed(&mesh.linear_cell([2, 2]), &mut |seed| seeds.push(seed));
    let [seed] = &seeds[..] else { panic!("one point") };

    // κ = 0.4: as without the remedy.
    let sound = step(&basis, &mesh, x, &seed.domain, hourglass(0.2));
    sound.outcome.unwrap();
    let FallbackDomain::Sound { domain, .. } = &sound.domain else { panic!("fell too early") };
    assert!((sound.domain.distortion() - 0.4).abs() < 1e-14);
    let alone = influences(&Cpdi2q::default(), &mesh, &sound.position, domain).unwrap();
    assert_eq!(alone, influences(&basis, &mesh, &sound.position, &sound.domain).unwrap());
    assert!(!basis.diagnose(&mesh, &sound.position, &sound.domain).unwrap().fallen_back);

    // κ = 0.8: CPDI1 with F = I from here on, whatever the corners do.
    let fallen = step(&basis, &mesh, x, &seed.domain, hourglass(0.4));
    fallen.outcome.unwrap();
    let square = Parallelepiped::at_rest(Block::<2>::identity() * 0.5);
    assert_eq!(fallen.domain, FallbackDomain::Fallen(square));
    assert!(basis.diagnose(&mesh, &fallen.position, &fallen.domain).unwrap().fallen_back);
    let again = step(&basis, &mesh, fallen.position, &fallen.domain, hourglass(10.0));
    again.outcome.unwrap();
    assert!(matches!(again.domain, FallbackDomain::Fallen(_)));
    check("fallen", &basis, &mesh, again.position, &again.domain);
}

/// The hourglass loses a domain's area where F stays healthy: refused without, carried on with the remedy.
#[test]
fn fallen_domains_are_not_inverted() {
    let mesh = unit_cells::<2>();
    let at = |x, y| Vector::<2>::new(x, y);
    // A domain folded over by one corner; F given as healthy.
    let quad = Quadrilateral::at_rest([at(2.2, 2.2), at(2.8, 2.2), at(2.2, 2.8), at(2.8, 2.8)]);
    let x = at(2.5, 2.5);
    let far_corner = |v: Vector<2>| if v == at(3.0, 3.0) { at(-3.0, -3.0) } else { at(0.0, 0.0) };
    let plain = step(&Cpdi2q::default(), &mesh, x, &quad, far_corner);
    assert!(matches!(plain.outcome, Err(ConvectionError::Inverted { volume }) if volume < 0.0));

    let stencils = Stencils::of(&Cpdi2q::default(), &mesh, &[x], &[quad]).unwrap();
    let active = ActiveNodes::of(&NodeSpace::vertices(mesh.lattice().clone()), &[stencils]);
    let increment: Vec<_> = active.nodes().iter().map(|&v| far_corner(mesh.position(v))).collect();
    let healthy = Block::<2>::new(1.1, 0.2, 0.0, 0.9);
    let convection = Convection {
        displacement: at(0.1, 0.2),
        deformation_gradient: healthy,
        mesh: &mesh,
        active: &active,
        increment: &increment,
    };
    let half_vectors = Block::<2>::identity() * 0.3;
    let basis = Fallback { basis: Cpdi2q::default(), beyond: f64::INFINITY };
    let mut domain = FallbackDomain::Sound { domain: quad, half_vectors };
    let mut position = x;
    basis.convect(&mut domain, &mut position, &convection).unwrap();
    assert_eq!(position, at(2.6, 2.7));
    let expected = Parallelepiped { initial: half_vectors, current: healthy * half_vectors };
    assert_eq!(domain, FallbackDomain::Fallen(expected));

    // Where F itself is not healthy there is nothing to fall back on.
    let sick =
        Convection { deformation_gradient: -healthy * Block::<2>::new(1.0, 0.0, 0.0, -1.0), ..convection };
    let mut domain = FallbackDomain::Sound { domain: quad, half_vectors };
    assert!(basis.convect(&mut domain, &mut at(2.5, 2.5), &sick).is_err());
}

#[test]
fn slivers_fall_back() {
    let mesh = unit_cells::<2>();
    let basis = Fallback { basis: Cpdi2t::default(), beyond: 4.0 };
    basis.seed(&mesh.linear_cell([2, 2]), &mut |seed| {
        let shear = |amount: f64| move |x: Vector<2>| Vector::<2>::new(amount * (x.y - 2.5), 0.0);
        let mild = step(&basis, &mesh, seed.position, &seed.domain, shear(0.5));
        assert!(matches!(mild.domain, FallbackDomain::Sound { .. }));
        let sheared = step(&basis, &mesh, seed.position, &seed.domain, shear(12.0));
        let FallbackDomain::Fallen(parallelogram) = sheared.domain else { panic!("still a sliver") };
        assert!((4.0 * parallelogram.current.determinant() / seed.volume - 1.0).abs() < 1e-13);
    });
}

#[test]
fn frozen_weights_stay_positive() {
    let mesh = unit_cells::<2>();
    let at = |x, y| Vector::<2>::new(x, y);
    let rest = Quadrilateral::at_rest([at(2.0, 2.0), at(3.0, 2.0), at(2.0, 3.0), at(3.0, 3.0)]);
    // The upper right corner drawn in past the opposite diagonal: nearly no area left.
    let quad = Quadrilateral { corners: [at(2.0, 2.0), at(3.0, 2.0), at(2.0, 3.0), at(2.05, 2.05)], ..rest };
    let frozen = Cpdi2q { weights: CornerWeights::Frozen };
    let published = Cpdi2q::default().diagnose(&mesh, &at(2.5, 2.5), &quad).unwrap();
    assert!(published.smallest_weight < 0.0 && published.distortion > 1.0);
    assert!((published.measure - 0.05).abs() < 1e-14);
    assert_eq!(frozen.diagnose(&mesh, &at(2.5, 2.5), &quad).unwrap().smallest_weight, 0.25);
}
