//! A field on the nodes, solved with the displacement in one system.

use super::setup::{History, square};
use mpm_assembly::{
    Begun, Block, Contribution, CoupledPlaces, Couplings, Inadmissible, Recorded, Refused, StepStart,
    SystemSums, Trial, UnknownId, Unknowns,
};
use mpm_grid::Vector;
use mpm_linear::Symmetry;
use mpm_solver::run;
use std::f64::consts::PI;

/// A field k on the nodes with the potential `Σ_p V⁰ [½ (k - s)² + ½ l² |∇k|² + c k div Δu]`, so that
/// `k - l² ∇²k = s - c div Δu` with no flux through the boundary.
struct Field {
    length: f64,
    coupling: f64,
    block: Option<Block>,
    places: CoupledPlaces,
    points: Vec<FieldPoint>,
    error: f64,
}

struct FieldPoint {
    volume: f64,
    position: Vector<2>,
    nodes: Vec<usize>,
    values: Vec<f64>,
    gradients: Vec<Vector<2>>,
}

impl Field {
    fn new(length: f64, coupling: f64) -> Self {
        let (places, points) = (CoupledPlaces::default(), Vec::new());
        Self { length, coupling, block: None, places, points, error: 0.0 }
    }

    /// The source of k = cos πx where c = 0.
    fn source(&self, x: &Vector<2>) -> f64 {
        (1.0 + (self.length * PI).powi(2)) * (PI * x[0]).cos()
    }

    /// Force on the unknowns of a point (displacements, then the field), and its derivative.
    fn of_point(&self, point: &FieldPoint, field: &[f64], trial: &Trial<'_, 2>) -> (Vec<f64>, Vec<f64>) {
        let (mut k, mut slope, mut divergence) = (0.0, Vector::<2>::zeros(), 0.0);
        for (v, &node) in point.nodes.iter().enumerate() {
            k += point.values[v] * field[node];
            slope += point.gradients[v] * field[node];
            divergence += point.gradients[v].dot(&trial.increment.nodes[node]);
        }
        let (n, volume, l2, c) = (point.nodes.len(), point.volume, self.length.powi(2), self.coupling);
        let mut force: Vec<f64> =
            point.gradients.iter().flat_map(|g| [g[0], g[1]].map(|g| volume * c * k * g)).collect();
        let by_value = k - self.source(&point.position) + c * divergence;
        let own = point.values.iter().zip(&point.gradients);
        force.extend(own.map(|(value, gradient)| volume * (by_value * value + l2 * slope.dot(gradient))));
        let mut stiffness = vec![0.0; 9 * n * n];
        for (v, w) in (0..n).flat_map(|v| (0..n).map(move |w| (v, w))) {
            let own = point.values[v] * point.values[w] + l2 * point.gradients[v].dot(&point.gradients[w]);
            stiffness[(2 * n + w) * 3 * n + 2 * n + v] = volume * own;
            for i in 0..2 {
                let mixed = volume * c * point.gradients[v][i] * point.values[w];
                stiffness[(2 * n + w) * 3 * n + 2 * v + i] = mixed;
                stiffness[(2 * v + i) * 3 * n + 2 * n + w] = mixed;
            }
        }
        (force, stiffness)
    }
}

impl Contribution<2> for Field {
    fn begin(&mut self, step: &StepStart<'_, 2>, unknowns: &mut Unknowns<2>) -> Result<Begun, Refused> {
        let block = unknowns.push(step.active.len(), 1);
        (self.block, self.places) = (Some(block), CoupledPlaces::default());
        self.points.clear();
        let body = &step.bodies[0];
        for group in (0..body.connectivity.n_groups()).map(|group| body.connectivity.group(group)) {
            let own = group.nodes.iter().map(|&node| block.place(node as usize));
            self.places.push(group.nodes.iter().copied().chain(own));
            for k in 0..group.points {
                let (view, (values, gradients)) = (body.body.point(group.first_point + k), group.point(k));
                self.points.push(FieldPoint {
                    volume: view.reference_volume,
                    position: view.position,
                    nodes: group.nodes.iter().map(|&node| node as usize).collect(),
                    values: values.to_vec(),
                    gradients: gradients.to_vec(),
                });
            }
        }
        Ok(Begun::Anew)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.places
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        let (block, numbering) = (self.block.unwrap(), trial.pattern.unknowns());
        let field = block.of(&trial.increment.own);
        for point in &self.points {
            let (force, stiffness) = self.of_point(point, field, trial);
            let displacement = |&node: &usize| [0, 1].map(|i| numbering.displacement(node, i));
            let mut unknowns: Vec<UnknownId> = point.nodes.iter().flat_map(displacement).collect();
            unknowns.extend(point.nodes.iter().map(|&node| block.unknown(node, 0)));
            sums.add(trial, &unknowns, &force, &stiffness);
        }
        Ok(())
    }

    fn own_scale(&self, _: &Trial<'_, 2>) -> Vec<f64> {
        vec![self.points.iter().map(|point| point.volume * self.source(&point.position).abs()).sum()]
    }

    fn prepare(&mut self, trial: &Trial<'_, 2>) -> Result<(), Inadmissible> {
        let field = self.block.unwrap().of(&trial.increment.own);
        let error = |point: &FieldPoint| {
            let k: f64 = point.nodes.iter().zip(&point.values).map(|(&node, value)| value * field[node]).sum();
            point.volume * (k - (PI * point.position[0]).cos()).powi(2)
        };
        self.error = self.points.iter().map(error).sum::<f64>().sqrt();
        Ok(())
    }

    fn history(&self) -> Vec<Recorded> {
        vec![Recorded::real("field/error", [self.error])]
    }
}

#[test]
fn a_nodal_field_converges_with_order_two() {
    let error = |cells: u32| {
        let mut model = square(cells);
        model.add_contribution("field", Box::new(Field::new(0.3, 0.0)));
        let mut history = History::default();
        run(&mut model, &mut history).unwrap();
        history.columns["field/error"][1]
    };
    let errors = [4, 8, 16].map(error);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.9..2.3).contains(&order), "order {order} from {errors:?}");
    }
}

#[test]
fn a_field_that_pushes_the_body_is_solved_with_it() {
    let run_with = |coupling: f64| {
        let mut model = square(6);
        model.add_contribution("field", Box::new(Field::new(0.3, coupling)));
        let mut history = History::default();
        run(&mut model, &mut history).unwrap();
        let moved = model.bodies[0].body.point(100).position;
        (history, moved)
    };
    let (_, rest) = run_with(0.0);
    let (history, moved) = run_with(30.0);
    assert!((moved - rest).norm() > 1e-4, "the field moves the body");
    let residuals = &history.residuals[1];
    let [.., a, b, c] = residuals[..] else { panic!("few iterations: {residuals:?}") };
    let slope = (c / b).ln() / (b / a).ln();
    assert!(slope > 1.7 && residuals.len() <= 6, "Newton's method is not quadratic: {residuals:?}");
}
