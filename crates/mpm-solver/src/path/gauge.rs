//! Lengths of a step, with their derivatives.

use super::Length;
use crate::error::StepFailure;
use crate::newton::Problem;
use mpm_grid::Vector;

/// A length and its derivative with respect to nodal displacements.
pub(super) struct Gauge<const D: usize> {
    pub(super) length: f64,
    pub(super) gradient: Vec<Vector<D>>,
}

impl<const D: usize> Gauge<D> {
    pub(super) fn slope(&self, direction: &[Vector<D>]) -> f64 {
        self.gradient.iter().zip(direction).map(|(g, u)| g.dot(u)).sum()
    }
}

/// Share of the stiffness that each node carries; they sum to 1.
pub(super) fn weights<const D: usize>(problem: &Problem<'_, D>) -> Vec<f64> {
    let mut weights = vec![0.0; problem.active.len()];
    for (named, connection) in problem.bodies.iter().zip(problem.connections) {
        named.body.stiffness_force(connection.links(), &mut weights);
    }
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights
}

pub(super) fn gauge<const D: usize>(
    problem: &Problem<'_, D>,
    weights: &[f64],
    measure: Length,
    increment: &[Vector<D>],
    origin: &[Vector<D>],
) -> Result<Gauge<D>, StepFailure> {
    let mut gradient = vec![Vector::zeros(); increment.len()];
    let mut length = 0.0;
    match measure {
        Length::Displacement => {
            gradient.copy_from_slice(increment);
            for (u, origin) in gradient.iter_mut().zip(origin) {
                *u -= origin;
            }
            problem.constraints.free_part(&mut gradient);
            for (u, weight) in gradient.iter_mut().zip(weights) {
                length += weight * u.norm_squared();
                *u *= *weight;
            }
            length = length.sqrt();
            if length > 0.0 {
                gradient.iter_mut().for_each(|g| *g /= length);
            }
        }
        Length::Dissipation => {
            for (named, connection) in problem.bodies.iter().zip(problem.connections) {
                let energy = named.body.dissipation(connection, increment, &mut gradient).map_err(|it| {
                    let body = named.name.clone();
                    StepFailure::Inverted { body, point: it.point, determinant: it.determinant }
                })?;
                length += energy;
            }
        }
    }
    Ok(Gauge { length, gradient })
}
