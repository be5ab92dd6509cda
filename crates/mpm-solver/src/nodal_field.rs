//! The nodal field of regularised bodies in a load step.

use crate::model::Model;
use crate::ranks::{Shared, total};
use mpm_assembly::{AssemblyPlan, FieldNodes, FieldStart, FollowedBody, SharedField, SparsityPattern, follow};
use std::sync::Arc;

/// The nodal field of regularised bodies in a load step. Its unknowns are the first that belong to no node's displacement.
pub(crate) struct NodalField {
    pub nodes: Arc<FieldNodes>,
    /// Its active nodes, in order.
    pub active: Vec<usize>,
    /// Where it begins.
    pub start: FieldStart,
}

/// The nodes of the field as several ranks share them.
struct FieldOfRanks<'a, const D: usize> {
    nodes: &'a [usize],
    shared: &'a Shared<D>,
    n_nodes: usize,
}

impl<const D: usize> SharedField for FieldOfRanks<'_, D> {
    fn complete(&self, field: &mut [f64]) {
        self.shared.complete_at(self.nodes, field, self.n_nodes);
    }

    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        let products = self.shared.counted_at(self.nodes, a.iter().zip(b)).map(|(a, b)| a * b);
        total(&*self.shared.ranks, products.sum())
    }
}

/// The nodal field as it follows the points at the start of the step.
pub(crate) fn nodal_field<const D: usize>(
    model: &Model<D>,
    nodes: Arc<FieldNodes>,
    plans: &mut [AssemblyPlan<D>],
    (pattern, shared): (&SparsityPattern<D>, &Shared<D>),
) -> NodalField {
    for (named, plan) in model.bodies.iter().zip(&mut *plans) {
        if let Some(regularisation) = named.body.regularisation() {
            plan.begin_field(&regularisation, &|point| named.body.field_point(point));
        }
    }
    let bodies = model.bodies.iter().zip(&*plans).filter_map(|(named, plan)| {
        let regularisation = named.body.regularisation()?;
        Some((plan, regularisation, move |point| named.body.field_point(point)))
    });
    let bodies: Vec<_> = bodies.collect();
    let bodies: Vec<FollowedBody<'_, D>> =
        bodies.iter().map(|(plan, regularisation, point)| (*plan, *regularisation, point as _)).collect();
    let active: Vec<usize> = nodes.active().collect();
    let of_ranks = FieldOfRanks { nodes: &active, shared, n_nodes: pattern.unknowns().n_nodes() };
    NodalField { start: follow(pattern, &bodies, &of_ranks), nodes, active }
}
