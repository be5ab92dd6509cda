//! Markers that move with their body.

use super::carriers::carriers;
use super::side::BodySide;
use crate::contribution::{Refused, StepStart};
use crate::sharing::Scale;
use mpm_grid::Vector;

/// The markers of a side through the load steps.
#[derive(Debug)]
pub(super) struct Moving<const D: usize> {
    pub side: BodySide<D>,
    /// Part of the boundary at rest of every marker `[L^(D-1)]`.
    pub measure: Vec<f64>,
    /// Positions at the start of the step `[L]`.
    pub position: Vec<Vector<D>>,
    /// At the end of the step that has been balanced `[L]`.
    prepared: Vec<Vector<D>>,
    /// Active numbers of the nodes that carry each marker in this step, and `N_v(x_b)`.
    pub carriers: Vec<Vec<(u32, f64)>>,
}

impl<const D: usize> Moving<D> {
    pub fn new(side: BodySide<D>) -> Self {
        let (measure, position) = (side.measures(), side.markers.clone());
        Self { side, measure, prepared: position.clone(), position, carriers: Vec::new() }
    }

    /// Finds the nodes that carry the markers.
    pub fn begin(&mut self, step: &StepStart<'_, D>) -> Result<(), Refused> {
        if !step.is_retry {
            self.carriers = self.position.iter().map(|x| carriers(step, x)).collect::<Result<_, _>>()?;
        }
        Ok(())
    }

    /// Where the markers are after an increment `[L]`.
    pub fn moved(&self, increment: &[Vector<D>]) -> Vec<Vector<D>> {
        let moved = |(x, carriers): (&Vector<D>, &Vec<(u32, f64)>)| {
            carriers.iter().fold(*x, |x, &(node, value)| x + increment[node as usize] * value)
        };
        self.position.iter().zip(&self.carriers).map(moved).collect()
    }

    /// Adds a force on every marker `[F]`, times `factor`, to those of the nodes.
    pub fn spread(&self, factor: f64, forces: &[Vector<D>], nodes: &mut [Vector<D>]) {
        for (force, carriers) in forces.iter().zip(&self.carriers) {
            carriers.iter().for_each(|&(node, value)| nodes[node as usize] += force * (factor * value));
        }
    }

    /// The size of forces on the markers: the norm of what they are on the nodes.
    pub fn of_nodes(&self, forces: &[Vector<D>], n_nodes: usize) -> Scale<D> {
        let mut nodes = vec![Vector::zeros(); n_nodes];
        self.spread(1.0, forces, &mut nodes);
        Scale::OfNodes(nodes)
    }

    pub fn prepare(&mut self, increment: &[Vector<D>]) {
        self.prepared = self.moved(increment);
    }

    pub fn commit(&mut self) {
        std::mem::swap(&mut self.position, &mut self.prepared);
    }

    /// Numbers in a file.
    pub fn n_saved(&self) -> usize {
        D * self.position.len()
    }

    pub fn save(&self, to: &mut Vec<f64>) {
        to.extend(self.position.iter().flatten());
    }

    /// Takes [`Self::n_saved`] numbers.
    pub fn restore(&mut self, from: &[f64]) {
        self.position = from.chunks_exact(D).map(Vector::from_column_slice).collect();
    }
}

/// Refuses numbers of another count, or that are none.
pub(super) fn check_saved(saved: &[f64], expected: usize) -> Result<(), String> {
    if saved.len() != expected {
        return Err(format!("has {} numbers, expected {expected} for its markers", saved.len()));
    }
    match saved.iter().find(|number| !number.is_finite()) {
        Some(number) => Err(format!("has the number {number}, expected finite ones")),
        None => Ok(()),
    }
}
