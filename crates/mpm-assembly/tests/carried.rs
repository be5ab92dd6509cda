//! What a point that nodes carry adds is what its dense matrix adds, bit for bit.

use mpm_assembly::{
    Constraints, CoupledPlaces, SparsityPattern, SystemSums, SystemTangent, Trial, UnknownId, UnknownVector,
    Unknowns,
};
use mpm_grid::{Block, LoadFraction, Vector};
use mpm_linear::Symmetry;

/// Nodes in no order, so that rows and columns change sides.
const CARRIERS: [(u32, f64); 3] = [(2, 0.5), (0, 0.2), (3, 0.3)];

/// Internal force, tangent, and the tangent times the prescribed increments, in the order of the equations.
fn summed(symmetry: Symmetry, add: impl Fn(&Trial<'_, 3>, &mut SystemSums<'_, 3>)) -> [Vec<f64>; 3] {
    let unknowns = Unknowns::<3>::of_nodes(4);
    let mut places = CoupledPlaces::default();
    places.push([0, 2, 3]);
    places.push([1, 2]);
    let pattern = SparsityPattern::reusing(None, &unknowns, symmetry, &[&places]);
    let mut constraints = Constraints::none(4);
    constraints.prescribe(2, 1, 0.25);
    constraints.prescribe(0, 0, 0.0);
    let increment = UnknownVector::zeros(&unknowns);
    let (mut force, mut lift) = (increment.clone(), increment.clone());
    let mut values = vec![0.125; pattern.n_entries()];
    let trial = Trial {
        pattern: &pattern,
        constraints: &constraints,
        increment: &increment,
        end: LoadFraction::END,
        is_first: false,
    };
    let tangent = SystemTangent { values: &mut values, lift: Some(&mut lift) };
    add(&trial, &mut SystemSums::new(&mut force, Some(tangent)));
    let (mut of_force, mut of_lift) = (Vec::new(), Vec::new());
    force.write_equations(&mut of_force);
    lift.write_equations(&mut of_lift);
    [of_force, values, of_lift]
}

#[test]
fn a_carried_point_adds_what_its_dense_matrix_adds() {
    let force = Vector::<3>::new(0.7, -0.3, 1.1);
    let whole = Block::<3>::new(4.0, 1.0, 0.3, 1.3, 5.0, -0.7, 0.2, -0.6, 6.0);
    let symmetric = (whole + whole.transpose()) * 0.5;
    for (symmetry, block) in [(Symmetry::Symmetric, symmetric), (Symmetry::Unsymmetric, whole)] {
        let carried = summed(symmetry, |trial, sums| sums.add_carried(trial, &CARRIERS, &force, Some(&block)));
        let dense = summed(symmetry, |trial, sums| {
            let entries =
                || CARRIERS.iter().flat_map(|&(v, weight)| (0..3).map(move |i| (v as usize, weight, i)));
            let unknowns: Vec<UnknownId> =
                entries().map(|(v, _, i)| trial.pattern.unknowns().displacement(v, i)).collect();
            let nodal: Vec<f64> = entries().map(|(_, weight, i)| -force[i] * weight).collect();
            let pairs = entries()
                .flat_map(|(_, w, j)| entries().map(move |(_, v, i)| v * w * block[(i, j)]))
                .collect::<Vec<f64>>();
            sums.add(trial, &unknowns, &nodal, &pairs);
        });
        assert_eq!(carried, dense, "{symmetry:?}");
        assert!(carried[1].contains(&0.125), "the other node's entries stay");
        assert!(carried[2].iter().any(|it| *it != 0.0));
    }
}
