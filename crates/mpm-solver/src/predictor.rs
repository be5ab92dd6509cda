//! The last load step, from which the solver predicts the next one.

use crate::connection::Connected;
use crate::loading::impose;
use crate::ranks::Ranks;
use crate::state::StoredPredictor;
use mpm_assembly::{Constraints, UnknownVector};
use mpm_basis::ActiveNodes;
use mpm_grid::{NodeId, Vector};

/// The last load step, as a direction for the next.
#[derive(Clone)]
pub(crate) struct Predictor<const D: usize> {
    /// Displacement of every node that was active `[L]`, ascending in the node.
    pub increment: Vec<(NodeId, Vector<D>)>,
    /// Change of the load fraction.
    pub fraction: f64,
    /// Its length along the path; 0 without path control.
    pub length: f64,
}

impl<const D: usize> Predictor<D> {
    /// A step that moved the active nodes by `increment` `[L]`.
    pub(crate) fn of(
        active: &ActiveNodes<D>,
        increment: impl IntoIterator<Item = Vector<D>>,
        fraction: f64,
        length: f64,
    ) -> Self {
        Self { increment: active.nodes().iter().copied().zip(increment).collect(), fraction, length }
    }

    /// The unknowns of a load step over `span` of the load fraction: those of the last step in proportion, with
    /// the components that `constraints` prescribes `[L]`.
    ///
    /// None where contributions have unknowns of their own, of which nothing is guessed: a guess without them would be out
    /// of balance.
    pub(crate) fn unknowns(
        &self,
        connected: &Connected<D>,
        span: f64,
        constraints: &Constraints<D>,
    ) -> Option<UnknownVector<D>> {
        if connected.unknowns().n_own() > connected.n_field() {
            return None;
        }
        let scale = span / self.fraction;
        let mut unknowns = connected.onwards(scale);
        unknowns.nodes = self.carried(connected);
        unknowns.nodes.iter_mut().for_each(|u| *u *= scale);
        impose(constraints, constraints.increment(), &mut unknowns.nodes);
        Some(unknowns)
    }

    /// Its displacement on the nodes of this step; a node that was not active then takes the mean of those with which it shares
    /// points, by the number of these, so that it depends on no grouping of points.
    pub(crate) fn carried(&self, connected: &Connected<D>) -> Vec<Vector<D>> {
        let known = connected.active.nodes().iter().map(|node| {
            let place = self.increment.binary_search_by_key(node, |entry| entry.0).ok()?;
            Some(self.increment[place].1)
        });
        let known = known_to_any(known.collect(), &*connected.shared.ranks);
        let mut sums = vec![(Vector::<D>::zeros(), 0.0); known.len()];
        for assembly_plan in &connected.assembly_plans {
            let connectivity = assembly_plan.connectivity();
            for group in 0..connectivity.n_groups() {
                let nodes = connectivity.group_nodes(group);
                if nodes.iter().all(|&node| known[node as usize].is_some()) {
                    continue;
                }
                let points = connectivity.group_points(group).len() as f64;
                let known_here = nodes.iter().filter_map(|&node| known[node as usize]);
                let (of_group, n) = known_here.fold((Vector::zeros(), 0.0), |(sum, n), u| (sum + u, n + 1.0));
                for &node in nodes {
                    let (sum, count) = &mut sums[node as usize];
                    *sum += of_group * points;
                    *count += n * points;
                }
            }
        }
        complete(&mut sums, &*connected.shared.ranks);
        let known = known.iter().zip(sums);
        known.map(|(known, (sum, count))| known.unwrap_or(sum / f64::max(count, 1.0))).collect()
    }

    /// Its displacement, as plain numbers.
    pub(crate) fn save(&self) -> StoredPredictor {
        StoredPredictor {
            nodes: self.increment.iter().map(|(node, _)| node.index() as u64).collect(),
            increment: self.increment.iter().flat_map(|(_, u)| u.iter().copied()).collect(),
        }
    }

    /// The step with these numbers, on a grid of `n_nodes`; none where `measures`, its change of the load
    /// fraction and its length, are none.
    ///
    /// # Errors
    /// What in the numbers cannot be that of a step.
    pub(crate) fn restore(
        measures: Option<(f64, f64)>,
        stored: &StoredPredictor,
        n_nodes: usize,
    ) -> Result<Option<Self>, String> {
        let StoredPredictor { nodes, increment } = stored;
        if nodes.len().checked_mul(D) != Some(increment.len()) || (measures.is_none() && !nodes.is_empty()) {
            let (n, m) = (nodes.len(), increment.len());
            return Err(format!("has a last step of {m} numbers on {n} nodes, expected {D} on each"));
        }
        let ascending = nodes.windows(2).all(|pair| pair[0] < pair[1]);
        if !ascending || nodes.last().is_some_and(|&last| last >= n_nodes as u64) {
            return Err(format!("has a last step on nodes that do not ascend below {n_nodes}"));
        }
        let Some((fraction, length)) = measures else { return Ok(None) };
        if !increment.iter().chain([&fraction, &length]).all(|it| it.is_finite()) {
            return Err("has a last step that is not finite".into());
        }
        let nodes = nodes.iter().filter_map(|&node| NodeId::from_index(node as usize));
        let increment = nodes.zip(increment.chunks_exact(D).map(Vector::from_column_slice)).collect();
        Ok(Some(Self { increment, fraction, length }))
    }
}

/// What any rank knows of the nodes: one that is new to a rank may be known to others, who have the same of it.
fn known_to_any<const D: usize>(
    mut known: Vec<Option<Vector<D>>>,
    ranks: &dyn Ranks<D>,
) -> Vec<Option<Vector<D>>> {
    if ranks.size() > 1 {
        let sum = |known: &Option<Vector<D>>| known.map_or((Vector::zeros(), 0.0), |u| (u, 1.0));
        let mut sums: Vec<(Vector<D>, f64)> = known.iter().map(sum).collect();
        complete(&mut sums, ranks);
        known = sums.into_iter().map(|(sum, count)| (count > 0.0).then(|| sum / count)).collect();
    }
    known
}

/// Adds what other ranks have of the sums and counts.
fn complete<const D: usize>(sums: &mut [(Vector<D>, f64)], ranks: &dyn Ranks<D>) {
    if ranks.size() > 1 {
        let (mut vectors, mut counts): (Vec<_>, Vec<_>) = sums.iter().copied().unzip();
        ranks.complete(&mut vectors);
        ranks.complete_numbers(&mut counts);
        sums.iter_mut().zip(vectors.into_iter().zip(counts)).for_each(|(sum, it)| *sum = it);
    }
}
