//! What a load on a side adds to force and tangent.

use super::load::{MarkerForce, MarkerLoad};
use super::moving::check_saved;
use super::side::area_by_corner;
use crate::contribution::{Begun, Contribution, ContributionEnergy, Inadmissible, Refused, StepStart};
use crate::sharing::{Scale, Sharing};
use crate::trial::{SystemSums, Trial};
use crate::unknowns::{CoupledPlaces, Couplings, UnknownId, Unknowns};
use mpm_grid::{Block, LoadFraction, Mesh, NodeId, Ramp, Vector};
use mpm_linear::Symmetry;

/// Nodes that carry the corners of a facet: number, corner and value.
type OfFacet = Vec<(u32, usize, f64)>;

impl<const D: usize> MarkerLoad<D> {
    fn of_facet(&self, facet: &[u32; D]) -> OfFacet {
        let of_corner = |(k, &marker): (usize, &u32)| {
            self.markers.carriers[marker as usize].iter().map(move |&(node, value)| (node, k, value))
        };
        let mut all: OfFacet = facet.iter().enumerate().flat_map(of_corner).collect();
        all.sort_by_key(|it| it.0);
        all
    }

    /// `∂f_int/∂u` of a pressure by the nodes of a facet: those, and the dense matrix column by column.
    fn stiffness(&self, facet: &[u32; D], positions: &[Vector<D>], end: LoadFraction) -> (Vec<u32>, Vec<f64>) {
        let per_corner = self.pressure_on_corner(end);
        let by_corner: [Block<D>; D] =
            std::array::from_fn(|k| area_by_corner(facet, k, positions) * per_corner);
        // Each corner has the same force, so that the block of two corners is that of the second.
        let block = |of: usize, by: usize| match self.symmetry {
            Symmetry::Unsymmetric => by_corner[by],
            Symmetry::Symmetric => (by_corner[by] + by_corner[of].transpose()) * 0.5,
        };
        let carriers = self.of_facet(facet);
        let mut nodes: Vec<u32> = carriers.iter().map(|it| it.0).collect();
        nodes.dedup();
        let n = D * nodes.len();
        let mut dense = vec![0.0; n * n];
        let (mut row, mut before) = (0, carriers.first().map(|it| it.0));
        let mut rows = Vec::with_capacity(carriers.len());
        for carrier in &carriers {
            row += usize::from(before != Some(carrier.0));
            before = Some(carrier.0);
            rows.push(row);
        }
        for (&w, &(_, by, of_w)) in rows.iter().zip(&carriers) {
            for (&v, &(_, of, of_v)) in rows.iter().zip(&carriers) {
                let block = block(of, by) * (of_v * of_w);
                for (j, i) in (0..D).flat_map(|j| (0..D).map(move |i| (j, i))) {
                    dense[(D * w + j) * n + D * v + i] += block[(i, j)];
                }
            }
        }
        (nodes, dense)
    }
}

impl<const D: usize> Contribution<D> for MarkerLoad<D> {
    fn begin(&mut self, step: &StepStart<'_, D>, _unknowns: &mut Unknowns<D>) -> Result<Begun, Refused> {
        self.from = step.from;
        self.markers.begin(step)?;
        if step.is_retry || matches!(self.force, MarkerForce::Dead(_)) {
            return Ok(Begun::AsBefore);
        }
        let mut couplings = CoupledPlaces::default();
        for facet in &self.markers.facets {
            let mut nodes: Vec<u32> = self.of_facet(facet).into_iter().map(|it| it.0).collect();
            nodes.dedup();
            couplings.push(nodes);
        }
        let before = std::mem::replace(&mut self.couplings, couplings);
        Ok(if before == self.couplings { Begun::AsBefore } else { Begun::Anew })
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.couplings
    }

    fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible> {
        let MarkerForce::Pressure(_) = self.force else {
            self.markers.spread(-1.0, &self.forces(&[], trial.end), &mut sums.force.nodes);
            return Ok(());
        };
        let positions = self.markers.moved(&trial.increment.nodes);
        self.markers.spread(-1.0, &self.forces(&positions, trial.end), &mut sums.force.nodes);
        if !sums.wants_tangent() {
            return Ok(());
        }
        let numbering = trial.pattern.unknowns();
        for facet in &self.markers.facets {
            let (nodes, dense) = self.stiffness(facet, &positions, trial.end);
            let of_node = |&node: &u32| (0..D).map(move |i| numbering.displacement(node as usize, i));
            let unknowns: Vec<UnknownId> = nodes.iter().flat_map(of_node).collect();
            sums.add(trial, &unknowns, &vec![0.0; unknowns.len()], &dense);
        }
        Ok(())
    }

    fn scale(&self, trial: &Trial<'_, D>) -> Scale<D> {
        let forces = self.forces(&self.markers.moved(&trial.increment.nodes), trial.end);
        self.markers.of_nodes(&forces, trial.increment.nodes.len())
    }

    fn can_be_shared(&self) -> bool {
        true
    }

    fn nodes(&self, mesh: &Mesh<D>, sharing: &dyn Sharing<D>) -> Vec<NodeId> {
        self.markers.nodes(mesh, sharing)
    }

    fn hear(&mut self, sharing: &dyn Sharing<D>) {
        self.markers.hear((&mut [], 0), sharing);
    }

    fn moves_with_load(&self) -> bool {
        true
    }

    fn is_load(&self) -> bool {
        true
    }

    fn ramps(&self) -> Vec<&Ramp> {
        vec![&self.ramp]
    }

    fn needs_functions_of_mesh(&self) -> bool {
        true
    }

    /// The work of forces that change linearly through the step. On prescribed components that at its start counts with the
    /// body's, which its supports carry.
    fn energy(&self, trial: &Trial<'_, D>) -> ContributionEnergy {
        let increment = &trial.increment.nodes;
        let moved = self.markers.moved(increment);
        let ends = [(&self.markers.position, self.from), (&moved, trial.end)];
        let [start, end] = ends.map(|(positions, at)| {
            let mut nodes = vec![Vector::<D>::zeros(); increment.len()];
            self.markers.spread(0.5, &self.forces(positions, at), &mut nodes);
            nodes
        });
        let mut work = 0.0;
        for (v, u) in increment.iter().enumerate() {
            for i in 0..D {
                let before = if trial.constraints.is_prescribed(v, i) { 0.0 } else { start[v][i] };
                work += (before + end[v][i]) * u[i];
            }
        }
        ContributionEnergy { work, ..ContributionEnergy::default() }
    }

    fn prepare(&mut self, trial: &Trial<'_, D>) -> Result<(), Inadmissible> {
        self.markers.prepare(&trial.increment.nodes);
        Ok(())
    }

    fn commit(&mut self) {
        self.markers.commit();
    }

    fn save(&self) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.markers.n_saved());
        self.markers.save(&mut numbers);
        numbers
    }

    fn restore(&mut self, saved: &[f64]) -> Result<(), String> {
        check_saved(saved, self.markers.n_saved())?;
        self.markers.restore(saved);
        Ok(())
    }
}
