//! Markers that move with their body.

use super::carriers::{BEYOND, carriers};
use super::side::BodySide;
use crate::contribution::{Refused, StepStart};
use crate::sharing::{Scale, Sharing};
use mpm_grid::{Mesh, NodeId, Place, Vector};

/// The markers of a side through the load steps. Of several who share the points of a body each has the markers in its cells,
/// and the facets whose first marker it has.
#[derive(Debug)]
pub(super) struct Moving<const D: usize> {
    pub side: BodySide<D>,
    /// Part of the boundary at rest of every marker `[L^(D-1)]`.
    pub measure: Vec<f64>,
    /// Positions at the start of the step `[L]`.
    pub position: Vec<Vector<D>>,
    /// At the end of the step that has been balanced `[L]`.
    prepared: Vec<Vector<D>>,
    /// One's own markers in this step, and one's own facets.
    pub own: Vec<usize>,
    pub facets: Vec<[u32; D]>,
    /// Active numbers of the nodes that carry each marker in this step, and `N_v(x_b)`; none of markers that are neither one's
    /// own nor at one's own facets.
    pub carriers: Vec<Vec<(u32, f64)>>,
}

impl<const D: usize> Moving<D> {
    pub fn new(side: BodySide<D>) -> Self {
        let (measure, position) = (side.measures(), side.markers.clone());
        let (own, facets) = ((0..position.len()).collect(), side.facets.clone());
        Self { side, measure, prepared: position.clone(), position, own, facets, carriers: Vec::new() }
    }

    /// Of every marker, whether it is one's own; those outside the mesh are of those who lead.
    fn owned(&self, mesh: &Mesh<D>, sharing: &dyn Sharing<D>) -> Vec<bool> {
        let is_own = |x: &Vector<D>| match mesh.locate(x, BEYOND) {
            Ok(place) => sharing.is_own(place.cell),
            Err(_) => sharing.leads(),
        };
        self.position.iter().map(is_own).collect()
    }

    /// Of every marker, whether its nodes are asked for: one's own, and those of one's own facets.
    fn needed(&self, owned: &[bool]) -> Vec<bool> {
        let mut needed = owned.to_vec();
        for facet in self.side.facets.iter().filter(|facet| owned[facet[0] as usize]) {
            facet.iter().for_each(|&marker| needed[marker as usize] = true);
        }
        needed
    }

    /// Nodes that may carry one's own markers and those of one's own facets: of their cells and of the cells beside these.
    pub fn nodes(&self, mesh: &Mesh<D>, sharing: &dyn Sharing<D>) -> Vec<NodeId> {
        let mut nodes = Vec::new();
        let needed = self.needed(&self.owned(mesh, sharing));
        for (x, _) in self.position.iter().zip(needed).filter(|it| it.1) {
            let Ok(place) = mesh.locate(x, BEYOND) else { continue };
            for cell in beside(mesh, place.cell) {
                mesh.values(&Place { cell, local: Vector::zeros() }, |node, _| nodes.push(node));
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Finds the nodes that carry the markers.
    pub fn begin(&mut self, step: &StepStart<'_, D>) -> Result<(), Refused> {
        if !step.is_retry {
            let owned = self.owned(step.mesh, step.sharing);
            let needed = self.needed(&owned);
            let of_marker = |(x, needed)| if needed { carriers(step, x) } else { Ok(Vec::new()) };
            self.carriers = self.position.iter().zip(needed).map(of_marker).collect::<Result<_, _>>()?;
            self.facets = self.side.facets.iter().filter(|it| owned[it[0] as usize]).copied().collect();
            self.own = (0..owned.len()).filter(|&marker| owned[marker]).collect();
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

    /// Takes from the others where their markers are after the step, and `width` numbers of each in `more`.
    pub fn hear(&mut self, (more, width): (&mut [f64], usize), sharing: &dyn Sharing<D>) {
        let mut numbers = Vec::with_capacity(self.own.len() * (1 + D + width));
        for &marker in &self.own {
            numbers.push(marker as f64);
            numbers.extend(self.position[marker].iter());
            numbers.extend(&more[width * marker..width * (marker + 1)]);
        }
        for of_marker in sharing.gathered(numbers).0.chunks_exact(1 + D + width) {
            let marker = of_marker[0] as usize;
            self.position[marker] = Vector::from_column_slice(&of_marker[1..=D]);
            more[width * marker..width * (marker + 1)].copy_from_slice(&of_marker[1 + D..]);
        }
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

/// A cell and those beside it, also across edges and corners.
fn beside<const D: usize>(mesh: &Mesh<D>, cell: [u32; D]) -> Vec<[u32; D]> {
    let (lattice, mut cells) = (mesh.lattice(), vec![cell]);
    for d in 0..D {
        let next: Vec<[u32; D]> =
            cells.iter().flat_map(|&it| [lattice.below(it, d), lattice.above(it, d)]).flatten().collect();
        cells.extend(next);
    }
    cells
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
