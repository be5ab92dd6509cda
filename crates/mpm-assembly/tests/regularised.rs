//! Bodies under a nodal field: tangents against differences, fields that follow their drivers, and steps that change nothing.

use mpm_assembly::{
    AssemblyPlan, Body, BodyConnectivity, ConnectedBody, Constraints, Contribution, Converged, DomainsOfBody,
    FieldNodes, FieldPoint, FieldStart, LawOfBody, MaterialBody, SparsityPattern, SystemSums, Trial,
    UnknownVector, Unknowns, Unshared, body_stiffness_error, follow, stiffness_error,
};
use mpm_basis::{ActiveNodes, Basis, Connectivity, Cpdi1, Smpm, seed_cells};
use mpm_grid::{Axis, Layout, LoadFraction, Mesh, NodeSpace, Vector};
use mpm_linear::Symmetry;
use mpm_material::{
    DruckerPrager, Elasticity, FieldDriver, Hencky, Regularisation, Tresca, UndrainedStrength, VonMises,
};
use std::sync::Arc;

fn elasticity() -> Elasticity {
    Elasticity::from_young_poisson(1e3, 0.3).unwrap()
}

fn softening() -> UndrainedStrength {
    UndrainedStrength::remoulding(10.0, 0.3, 0.3).unwrap()
}

fn regularisation(driver: FieldDriver) -> Regularisation {
    Regularisation::new(driver, 200.0, 0.4).unwrap()
}

/// The laws of the tests, and whether their tangent is symmetric.
fn laws<const D: usize>() -> Vec<(&'static str, LawOfBody<D>)> {
    let (by_flow, by_strain) =
        (regularisation(FieldDriver::PlasticStrain), regularisation(FieldDriver::Strain));
    let cone = DruckerPrager::new(elasticity(), 0.6, 0.1, 8.0).unwrap();
    let of_flow = VonMises::with_strength(elasticity(), softening()).unwrap();
    vec![
        ("von Mises by its flow", LawOfBody::regularised(of_flow, by_flow).unwrap()),
        (
            "Tresca by its flow",
            LawOfBody::regularised(Tresca::new(elasticity(), softening()).unwrap(), by_flow).unwrap(),
        ),
        ("Hencky by its strain", LawOfBody::regularised_by_strain(Hencky(elasticity()), by_strain)),
        ("von Mises by its strain", LawOfBody::regularised_by_strain(of_flow, by_strain)),
        ("a cone by its strain", LawOfBody::regularised_by_strain(cone, by_strain)),
    ]
}

fn mesh<const D: usize>(cells: u32) -> Mesh<D> {
    let axes = std::array::from_fn(|d| Axis::geometric(0.0, 3.0, cells + d as u32, 1.5).unwrap());
    Mesh::at_rest(&Layout::<D>::on_axes(axes).unwrap())
}

fn body<const D: usize, B: Basis<D> + 'static>(
    basis: B,
    law: LawOfBody<D>,
    mesh: &Mesh<D>,
) -> Box<dyn Body<D>> {
    let seeds = seed_cells(&basis, mesh, mesh.cells(), 2);
    let places: Vec<_> = seeds.iter().map(|seed| (seed.position, seed.volume)).collect();
    let domains = DomainsOfBody::new(basis, seeds.into_iter().map(|seed| seed.domain).collect());
    Box::new(MaterialBody::of(law, domains, places))
}

/// A smooth displacement under which a part of the points yields.
fn wave<const D: usize>(size: f64, x: &Vector<D>) -> Vector<D> {
    Vector::from_fn(|i, _| size * (1.3 * x[i] + 0.7 * x[(i + 1) % D] + i as f64).sin())
}

/// A regularised body that is connected to a mesh.
struct Setup<const D: usize> {
    body: Box<dyn Body<D>>,
    active: ActiveNodes<D>,
    pattern: SparsityPattern<D>,
    plan: AssemblyPlan<D>,
    mesh: Mesh<D>,
}

impl<const D: usize> Setup<D> {
    fn of(body: Box<dyn Body<D>>, mesh: Mesh<D>, symmetry: Symmetry) -> Self {
        let stencils = body.stencils(&mesh).unwrap();
        let space = NodeSpace::vertices(mesh.lattice().clone());
        let active = ActiveNodes::of(&space, std::slice::from_ref(&stencils));
        let connectivity = Connectivity::of(stencils, &active);
        let mut unknowns = Unknowns::of_nodes(active.len());
        let nodes = Arc::new(FieldNodes::of(&[&connectivity], &mut unknowns));
        let couplings = nodes.couplings(&connectivity);
        let pattern = SparsityPattern::reusing(None, &unknowns, symmetry, &[&couplings]);
        let linked = BodyConnectivity { connectivity, dilatation: None };
        let plan = AssemblyPlan::new(linked, &pattern).with_field(nodes, &pattern);
        let mut setup = Self { body, active, pattern, plan, mesh };
        setup.begin();
        setup
    }

    fn begin(&mut self) {
        let Self { body, plan, .. } = self;
        plan.begin_field(&body.regularisation().unwrap(), &|point| body.field_point(point));
    }

    fn follow(&self, point: impl Fn(usize) -> FieldPoint<D>) -> FieldStart {
        follow(&self.pattern, &[(&self.plan, self.body.regularisation().unwrap(), &point)], &Unshared)
    }

    fn unknowns(&self, size: f64, field: Vec<f64>) -> UnknownVector<D> {
        let nodes = self.active.nodes().iter().map(|&node| wave(size, &self.mesh.position(node))).collect();
        UnknownVector { nodes, own: field }
    }

    fn trial<'a>(&'a self, constraints: &'a Constraints<D>, increment: &'a UnknownVector<D>) -> Trial<'a, D> {
        Trial { pattern: &self.pattern, constraints, increment, end: LoadFraction::END, is_first: false }
    }

    fn commit(&mut self, unknowns: &UnknownVector<D>) {
        let UnknownVector { nodes, own } = unknowns;
        let step = Converged { mesh: &self.mesh, active: &self.active, increment: nodes, own };
        self.body.prepare(&self.plan, step).unwrap();
        self.body.commit();
        self.begin();
    }
}

fn compare_tangents<const D: usize>(cells: u32) {
    for (name, law) in laws::<D>() {
        let mesh = mesh(cells);
        let body = body(Cpdi1, law, &mesh);
        let fresh = body_stiffness_error(&*body, &mesh, |x| wave(0.02, x)).unwrap();
        assert!(fresh < 2e-7, "{name} at rest: {fresh:e}");

        // After a step, whose yield surface and deformation gradients are no longer those of rest.
        let symmetry = body.symmetry();
        for symmetry in [symmetry, Symmetry::Unsymmetric] {
            let mut setup = Setup::of(body_of::<D>(name, &mesh), mesh.clone(), symmetry);
            let n = setup.pattern.unknowns().n_own();
            let first = setup.unknowns(0.02, (0..n).map(|k| 0.004 * (1.0 + (k as f64).cos())).collect());
            setup.commit(&first);
            let second = setup.unknowns(0.012, (0..n).map(|k| 0.006 * (1.0 + (k as f64).sin())).collect());
            let constraints = Constraints::none(setup.active.len());
            let connected = ConnectedBody { body: &*setup.body, plan: &setup.plan };
            let error = stiffness_error(&connected, &setup.trial(&constraints, &second)).unwrap();
            assert!(error < 2e-7, "{name}, {symmetry:?}: {error:e}");
            let mut yielding = 0;
            (0..setup.body.n_points()).for_each(|p| yielding += usize::from(setup.body.point(p).plastic));
            let can = setup.body.can_yield();
            assert_eq!(yielding > 0, can, "{name}: {yielding} of {} yield", setup.body.n_points());
        }
    }
}

fn body_of<const D: usize>(name: &str, mesh: &Mesh<D>) -> Box<dyn Body<D>> {
    let (_, law) = laws::<D>().into_iter().find(|law| law.0 == name).unwrap();
    body(Cpdi1, law, mesh)
}

#[test]
fn tangents_are_those_of_differences_in_the_plane() {
    compare_tangents::<2>(4);
}

#[test]
fn tangents_are_those_of_differences_in_space() {
    compare_tangents::<3>(2);
}

/// What is prescribed enters the residual of the field through the tangent.
#[test]
fn prescribed_displacements_are_lifted_into_the_field() {
    let mesh = mesh::<2>(3);
    let setup = Setup::of(body_of("Hencky by its strain", &mesh), mesh, Symmetry::Symmetric);
    let n = setup.pattern.unknowns().n_own();
    let at = setup.unknowns(0.05, vec![0.01; n]);
    let mut constraints = Constraints::none(setup.active.len());
    constraints.prescribe(2, 1, 0.3);
    let sum = |constraints: &Constraints<2>, increment: &UnknownVector<2>, wanted: bool| {
        let (mut force, mut lift) =
            (UnknownVector::zeros(setup.pattern.unknowns()), UnknownVector::zeros(setup.pattern.unknowns()));
        let mut values = vec![0.0; setup.pattern.n_entries()];
        let tangent = mpm_assembly::SystemTangent { values: &mut values, lift: Some(&mut lift) };
        let tangent = wanted.then_some(tangent);
        let mut sums = SystemSums::new(&mut force, tangent);
        let connected = ConnectedBody { body: &*setup.body, plan: &setup.plan };
        connected.add(&setup.trial(constraints, increment), &mut sums).unwrap();
        (force, lift)
    };
    let lift = sum(&constraints, &at, true).1;
    let free = Constraints::none(setup.active.len());
    let beside = |by: f64| {
        let mut beside = at.clone();
        beside.nodes[2][1] += by;
        sum(&free, &beside, false).0
    };
    let (more, less) = (beside(1e-6), beside(-1e-6));
    let size = lift.own.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
    assert!(size > 0.0);
    for k in 0..n {
        let difference = 0.3 * (more.own[k] - less.own[k]) / 2e-6;
        assert!((lift.own[k] - difference).abs() < 1e-6 * size, "{k}: {} {difference}", lift.own[k]);
    }
}

/// k is uniform where its driver is, on any mesh, and leaves no residual.
#[test]
fn the_field_of_a_uniform_driver_is_uniform() {
    let mesh = mesh::<2>(5);
    let setup = Setup::of(body_of("Hencky by its strain", &mesh), mesh, Symmetry::Symmetric);
    let start = setup.follow(|p| FieldPoint { driver: 0.3, ..setup.body.field_point(p) });
    assert!(start.field.iter().all(|k| (k - 0.3).abs() < 1e-10), "{:?}", start.field);
    assert!(start.change.iter().all(|k| *k == 0.0));
}

/// k − l² k'' = cos(πx/L) has the amplitude 1/(1 + (πl/L)²).
#[test]
fn helmholtz_alone_converges_with_order_two() {
    let pi = std::f64::consts::PI;
    let errors: Vec<f64> = [8, 16, 32]
        .into_iter()
        .map(|cells| {
            let axes = [Axis::uniform(0.0, 2.0, cells).unwrap(), Axis::uniform(0.0, 0.25, 1).unwrap()];
            let mesh = Mesh::at_rest(&Layout::<2>::on_axes(axes).unwrap());
            let law =
                LawOfBody::regularised_by_strain(Hencky(elasticity()), regularisation(FieldDriver::Strain));
            let setup = Setup::of(body(Smpm, law, &mesh), mesh, Symmetry::Symmetric);
            let driver = |p: usize| (0.5 * pi * setup.body.point(p).position[0]).cos();
            let start = setup.follow(|p| FieldPoint { driver: driver(p), ..setup.body.field_point(p) });
            let amplitude = 1.0 / (1.0 + (0.5 * pi * 0.4).powi(2));
            let nodes = setup.active.nodes().iter().zip(&start.field);
            let error = |(&node, k): (&mpm_grid::NodeId, &f64)| {
                (k - amplitude * (0.5 * pi * setup.mesh.position(node)[0]).cos()).abs()
            };
            nodes.map(error).fold(0.0, f64::max)
        })
        .collect();
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    assert!(errors[2] < 1e-3 && orders.iter().all(|order| (order - 2.0).abs() < 0.15), "{errors:?} {orders:?}");
}
