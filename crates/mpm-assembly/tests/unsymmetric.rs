//! Tangents of a law without symmetry: against differences, with prescribed components, and beside other laws.

mod setup;

use mpm_assembly::{Constraints, MeanDilatation, body_stiffness_error};
use mpm_basis::{Basis, Cpdi1, Smpm};
use mpm_linear::Symmetry;
use mpm_material::{Elasticity, Material, NoReturn, PointParameters, Update};
use nalgebra::{Matrix3, Vector3};
use setup::{Setup, apart, connect_as, field, flat, law, setup, sum, times, wave};

/// Elasticity whose pressure grows with shear, `τ = λ tr ε 1 + 2G ε - η |e|² 1`: its tangent has the part
/// `-2η 1 ⊗ e`, which is not symmetric. Or with shear where little is compressed, `-η' v² |e|² 1`, `v = max(tr ε + c, 0)`,
/// so that the tangent is symmetric at the other points.
#[derive(Clone, Copy)]
struct Dilatant {
    elasticity: Elasticity,
    in_part: bool,
}

const ETA: f64 = 2e3;
const ETA_IN_PART: f64 = 1e5;
/// The mean of the field of displacements.
const COMPRESSED: f64 = 0.1;

impl Material for Dilatant {
    type History = ();
    const PLASTIC: bool = false;

    fn has_symmetric_tangent(&self) -> bool {
        false
    }

    fn initial(&self, _point: &PointParameters) {}

    fn update(&self, trial: &Vector3<f64>, _history: &()) -> Result<Update<()>, NoReturn> {
        let (lambda, two_g) = (self.elasticity.lame(), 2.0 * self.elasticity.shear());
        let e = trial.add_scalar(-trial.sum() / 3.0);
        let elastic = Matrix3::from_diagonal_element(two_g).add_scalar(lambda);
        let v = (trial.sum() + COMPRESSED).max(0.0);
        let (pressure, slope) = if self.in_part {
            let by_volume = Vector3::repeat(2.0 * v * e.norm_squared());
            (ETA_IN_PART * v * v * e.norm_squared(), ETA_IN_PART * (by_volume + 2.0 * v * v * e))
        } else {
            (ETA * e.norm_squared(), 2.0 * ETA * e)
        };
        Ok(Update {
            elastic_strain: *trial,
            kirchhoff: (two_g * trial).add_scalar(lambda * trial.sum() - pressure),
            tangent: elastic - Vector3::repeat(1.0) * slope.transpose(),
            secant: Vector3::repeat(two_g),
            plastic: false,
            history: (),
        })
    }

    /// Its stress is no gradient: what elastic strain stores is not known.
    fn stored_energy(&self, _elastic_strain: &Vector3<f64>, _history: &()) -> f64 {
        f64::NAN
    }

    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

fn dilatant(in_part: bool) -> Dilatant {
    Dilatant { elasticity: Elasticity::from_young_poisson(1e3, 0.3).unwrap(), in_part }
}

/// Entry (row, column) of the stored tangent; zero where none is stored.
fn entry<const D: usize>(setup: &Setup<D>, values: &[f64], row: usize, column: usize) -> f64 {
    let entries = setup.pattern.column_start()[column]..setup.pattern.column_start()[column + 1];
    let at = setup.pattern.row()[entries.clone()].binary_search(&row);
    at.map_or(0.0, |at| values[entries.start + at])
}

fn against_differences<const D: usize, B: Basis<D> + 'static>(
    basis: B,
    law: Dilatant,
    mean: Option<MeanDilatation>,
) {
    let setup: Setup<D> = setup(basis, law, 4, 3, mean);
    let error = body_stiffness_error(&*setup.body, &setup.mesh, |x| wave(0.05, x)).unwrap();
    assert!(error < 1e-8, "D = {D}, {mean:?}: {error:e}");

    let at = field(&setup, 0.05);
    let (_, values, _) = sum(&setup, &at, &Constraints::none(setup.active.len()));
    let n = setup.pattern.n_equations();
    let largest = values.iter().fold(0.0, |m: f64, value| m.max(value.abs()));
    let skew = |k: usize| {
        (0..n).map(|j| (entry(&setup, &values, k, j) - entry(&setup, &values, j, k)).abs()).fold(0.0, f64::max)
    };
    let skewness = (0..n).map(skew).fold(0.0, f64::max) / largest;
    assert!(skewness > 1e-3, "D = {D}, {mean:?}: the law is not symmetric, {skewness:e}");
}

#[test]
fn the_tangent_is_the_derivative_of_the_force() {
    for law in [dilatant(false), dilatant(true)] {
        for mean in [None, Some(MeanDilatation::Points), Some(MeanDilatation::Cell)] {
            against_differences::<2, _>(Smpm, law, mean);
            against_differences::<2, _>(Cpdi1, law, mean);
            against_differences::<3, _>(Smpm, law, mean);
        }
        against_differences::<3, _>(Cpdi1, law, None);
    }
}

#[test]
fn prescribed_rows_and_columns_are_empty_and_lifted() {
    for mean in [None, Some(MeanDilatation::Points)] {
        let setup: Setup<2> = setup(Smpm, dilatant(true), 4, 1, mean);
        let at = field(&setup, 0.05);
        let n_nodes = setup.active.len();
        let (_, free, _) = sum(&setup, &at, &Constraints::none(n_nodes));
        let mut held = Constraints::none(n_nodes);
        for node in (0..n_nodes).step_by(3) {
            held.prescribe(node, node % 2, 0.01 * (node as f64 + 1.0));
        }
        let (_, values, lift) = sum(&setup, &at, &held);
        let is_held = |k: usize| held.is_prescribed(k / 2, k % 2);
        for row in 0..2 * n_nodes {
            for column in 0..2 * n_nodes {
                let expected = match (row == column, is_held(row) || is_held(column)) {
                    (true, true) => entry(&setup, &free, row, column).abs(),
                    (false, true) => 0.0,
                    (_, false) => entry(&setup, &free, row, column),
                };
                assert_eq!(entry(&setup, &values, row, column), expected, "{row}, {column}");
            }
        }
        let error = apart(&times(&setup.pattern, &free, held.increment()), &flat(&lift));
        assert!(error < 1e-14, "{error:e}");
    }
}

#[test]
fn a_symmetric_law_scatters_into_both_triangles() {
    for mean in [None, Some(MeanDilatation::Cell)] {
        let own: Setup<2> = setup(Cpdi1, law(), 4, 3, mean);
        let other: Setup<2> = setup(Cpdi1, law(), 4, 3, mean);
        let other = connect_as(other.body, other.mesh, Symmetry::Unsymmetric);
        let at = field(&own, 0.05);
        let mut held = Constraints::none(own.active.len());
        (0..own.active.len()).step_by(4).for_each(|node| held.prescribe(node, 1, 0.02));
        let (force, lower, lift) = sum(&own, &at, &held);
        let (same_force, both, same_lift) = sum(&other, &at, &held);
        assert_eq!((force, lift), (same_force, same_lift));
        let largest = lower.iter().fold(0.0, |m: f64, value| m.max(value.abs()));
        let n = own.pattern.n_equations();
        for (row, column) in (0..n).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            let value = entry(&own, &lower, row, column);
            assert_eq!(entry(&other, &both, row, column), value);
            assert!((entry(&other, &both, column, row) - value).abs() <= 1e-13 * largest);
        }
    }
}
