//! A body's points and the active nodes they influence.

use crate::active::ActiveNodes;
use crate::stencils::{Chunk, Influences, Stencils, narrow};
use mpm_grid::Vector;
use rayon::prelude::*;
use std::ops::Range;

/// A body's points and the active nodes they influence, by groups of points that share their nodes.
///
/// Points of a group are consecutive. Groups with the same nodes, wherever they are in the list of
/// points, have one *node set*: with standard MPM that is a cell. Node sets ascend in their lowest node.
#[derive(Clone, Debug, PartialEq)]
pub struct Connectivity<const D: usize> {
    groups: Vec<GroupStart>,
    n_points: usize,
    /// Start of every node set's nodes in `node`, and its length at the end.
    set_start: Vec<u32>,
    /// Active numbers, ascending within a node set.
    node: Vec<u32>,
    /// Start of every node set's groups in `set_group`, and its length at the end.
    set_group_start: Vec<u32>,
    /// Groups by node set, ascending within each.
    set_group: Vec<u32>,
    chunks: Vec<Influences<D>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct GroupStart {
    point: u32,
    set: u32,
    /// Where its influences are, and where they start there.
    chunk: u32,
    influence: u32,
}

/// Points of one group: every point has one value and gradient per node.
#[derive(Clone, Copy, Debug)]
pub struct Group<'a, const D: usize> {
    /// Index of the first point.
    pub first_point: usize,
    /// Number of points.
    pub points: usize,
    /// Active numbers of the nodes, ascending.
    pub nodes: &'a [u32],
    /// `S_vp`, `[points][nodes]`.
    pub values: &'a [f64],
    /// `∂S_vp/∂X̃`, `[points][nodes]`.
    pub gradients: &'a [Vector<D>],
    /// Parts of the points' masses, `[points][nodes]`: the values, but where rings have [others](Stencils::of_rings).
    pub masses: &'a [f64],
}

/// The runs of a chunk by active number; nothing of inactive nodes.
struct Renumbered<const D: usize> {
    /// Points and nodes up to the end of each run.
    ends: Vec<(u32, u32)>,
    nodes: Vec<u32>,
    influences: Influences<D>,
}

impl<const D: usize> Connectivity<D> {
    /// Renumbers one body's stencils by active node; influences on inactive nodes are dropped.
    pub fn of(stencils: Stencils<D>, active: &ActiveNodes<D>) -> Self {
        let renumber = |chunk| Renumbered::of(chunk, active);
        let chunks: Vec<Renumbered<D>> = match stencils.chunks.len() {
            // Not worth waking a thread.
            0 | 1 => stencils.chunks.into_iter().map(renumber).collect(),
            _ => stencils.chunks.into_par_iter().map(renumber).collect(),
        };

        let mut sets = NodeSets::new(active.len());
        let mut groups = Vec::with_capacity(chunks.iter().map(|chunk| chunk.ends.len()).sum());
        let mut influences = Vec::with_capacity(chunks.len());
        let mut n_points = 0;
        for (index, chunk) in chunks.into_iter().enumerate() {
            let (mut point, mut node, mut influence) = (0, 0, 0);
            for (end_point, end_node) in chunk.ends {
                let nodes = &chunk.nodes[node..end_node as usize];
                let set = sets.find_or_add(nodes);
                groups.push(GroupStart { point: n_points + point, set, chunk: narrow(index), influence });
                influence += (end_point - point) * narrow(nodes.len());
                (point, node) = (end_point, end_node as usize);
            }
            n_points += point;
            influences.push(chunk.influences);
        }

        let rank = sets.sort();
        if let Some(rank) = &rank {
            groups.iter_mut().for_each(|group| group.set = rank[group.set as usize]);
        }
        let mut set_group_start = vec![0; sets.start.len()];
        for group in &groups {
            set_group_start[group.set as usize + 1] += 1;
        }
        for set in 1..set_group_start.len() {
            set_group_start[set] += set_group_start[set - 1];
        }
        let mut next = set_group_start.clone();
        let mut set_group = vec![0; groups.len()];
        for (index, group) in groups.iter().enumerate() {
            let at = &mut next[group.set as usize];
            set_group[*at as usize] = narrow(index);
            *at += 1;
        }
        Self {
            groups,
            n_points: n_points as usize,
            set_start: sets.start,
            node: sets.node,
            set_group_start,
            set_group,
            chunks: influences,
        }
    }

    /// Number of groups.
    #[inline]
    pub fn n_groups(&self) -> usize {
        self.groups.len()
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Number of influences, that is of pairs (point, node).
    pub fn n_influences(&self) -> usize {
        self.chunks.iter().map(|chunk| chunk.value.len()).sum()
    }

    /// One group.
    #[inline]
    pub fn group(&self, group: usize) -> Group<'_, D> {
        let points = self.group_points(group);
        let GroupStart { set, chunk, influence, .. } = self.groups[group];
        let nodes = self.node_set(set as usize);
        let chunk = &self.chunks[chunk as usize];
        let influences = influence as usize..influence as usize + points.len() * nodes.len();
        Group {
            first_point: points.start,
            points: points.len(),
            nodes,
            values: &chunk.value[influences.clone()],
            masses: &if chunk.mass.is_empty() { &chunk.value } else { &chunk.mass }[influences.clone()],
            gradients: &chunk.gradient[influences],
        }
    }

    /// Points of one group.
    #[inline]
    pub fn group_points(&self, group: usize) -> Range<usize> {
        let end = self.groups.get(group + 1).map_or(self.n_points, |next| next.point as usize);
        self.groups[group].point as usize..end
    }

    /// Active numbers of the nodes of one group, ascending.
    #[inline]
    pub fn group_nodes(&self, group: usize) -> &[u32] {
        self.node_set(self.groups[group].set as usize)
    }

    /// Number of node sets.
    #[inline]
    pub fn n_node_sets(&self) -> usize {
        self.set_start.len() - 1
    }

    /// Active numbers of the nodes of one node set, ascending.
    #[inline]
    pub fn node_set(&self, set: usize) -> &[u32] {
        &self.node[self.set_start[set] as usize..self.set_start[set + 1] as usize]
    }

    /// Groups that have this node set, ascending.
    #[inline]
    pub fn node_set_groups(&self, set: usize) -> &[u32] {
        &self.set_group[self.set_group_start[set] as usize..self.set_group_start[set + 1] as usize]
    }

    /// The same list with gradients of another number of components.
    pub(crate) fn with_gradients<const E: usize>(
        &self,
        of: impl Fn(&Vector<D>) -> Vector<E>,
    ) -> Connectivity<E> {
        let influences = |chunk: &Influences<D>| Influences {
            value: chunk.value.clone(),
            gradient: chunk.gradient.iter().map(&of).collect(),
            mass: chunk.mass.clone(),
        };
        Connectivity {
            groups: self.groups.clone(),
            n_points: self.n_points,
            set_start: self.set_start.clone(),
            node: self.node.clone(),
            set_group_start: self.set_group_start.clone(),
            set_group: self.set_group.clone(),
            chunks: self.chunks.iter().map(influences).collect(),
        }
    }

    /// Whether the same points have the same nodes as in `other`.
    pub fn is_connected_as(&self, other: &Self) -> bool {
        self.n_points == other.n_points
            && self.groups == other.groups
            && self.set_start == other.set_start
            && self.node == other.node
    }

    /// Bytes of the list.
    pub fn bytes(&self) -> usize {
        let lists = [&self.set_start, &self.node, &self.set_group_start, &self.set_group];
        size_of_val(&self.groups[..])
            + lists.map(|list| size_of_val(&list[..])).iter().sum::<usize>()
            + self.n_influences() * (size_of::<f64>() + size_of::<Vector<D>>())
            + self.chunks.iter().map(|chunk| size_of_val(&chunk.mass[..])).sum::<usize>()
    }
}

impl<const D: usize> Renumbered<D> {
    fn of(chunk: Chunk<D>, active: &ActiveNodes<D>) -> Self {
        let Chunk { runs, nodes, influences, .. } = chunk;
        let ends = runs.iter().map(|run| (run.points, run.nodes)).collect();
        let numbers: Vec<Option<usize>> = nodes.iter().map(|&node| active.number(node)).collect();
        if numbers.iter().all(|number| number.is_some()) {
            let nodes = numbers.into_iter().flatten().map(narrow).collect();
            return Self { ends, nodes, influences };
        }
        let mut kept = Self { ends: Vec::new(), nodes: Vec::new(), influences: Influences::default() };
        let (mut point, mut node, mut at) = (0, 0, 0);
        for (end_point, end_node) in ends {
            let run = &numbers[node..end_node as usize];
            for _ in point..end_point {
                for number in run {
                    if number.is_some() {
                        kept.influences.value.push(influences.value[at]);
                        kept.influences.gradient.push(influences.gradient[at]);
                        kept.influences.mass.extend(influences.mass.get(at));
                    }
                    at += 1;
                }
            }
            kept.nodes.extend(run.iter().flatten().copied().map(narrow));
            kept.ends.push((end_point, narrow(kept.nodes.len())));
            (point, node) = (end_point, end_node as usize);
        }
        kept
    }
}

/// Distinct lists of nodes.
struct NodeSets {
    /// Start of every list in `node`, and its length at the end.
    start: Vec<u32>,
    node: Vec<u32>,
    /// Last list added that begins with each node.
    first: Vec<u32>,
    /// The one added before it, for each list.
    before: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl NodeSets {
    fn new(n_active: usize) -> Self {
        Self { start: vec![0], node: Vec::new(), first: vec![NONE; n_active.max(1)], before: Vec::new() }
    }

    fn len(&self) -> usize {
        self.before.len()
    }

    #[inline]
    fn nodes(&self, set: usize) -> &[u32] {
        &self.node[self.start[set] as usize..self.start[set + 1] as usize]
    }

    /// Number of the list, which is added unless it is there.
    #[inline]
    fn find_or_add(&mut self, nodes: &[u32]) -> u32 {
        let lowest = lowest(nodes) as usize;
        let mut candidate = self.first[lowest];
        while candidate != NONE {
            if self.nodes(candidate as usize) == nodes {
                return candidate;
            }
            candidate = self.before[candidate as usize];
        }
        let new = narrow(self.len());
        self.before.push(self.first[lowest]);
        self.first[lowest] = new;
        self.node.extend_from_slice(nodes);
        self.start.push(narrow(self.node.len()));
        new
    }

    /// Brings the lists into the order of their lowest nodes, those with the same in the order in which
    /// they were added; the new number of each, where that is another.
    fn sort(&mut self) -> Option<Vec<u32>> {
        if (1..self.len()).all(|set| lowest(self.nodes(set - 1)) <= lowest(self.nodes(set))) {
            return None;
        }
        let mut rank = vec![0; self.len()];
        let (mut start, mut node) = (Vec::with_capacity(self.start.len()), Vec::with_capacity(self.node.len()));
        start.push(0);
        let mut chain = Vec::new();
        for &last in &self.first {
            let mut set = last;
            while set != NONE {
                chain.push(set);
                set = self.before[set as usize];
            }
            while let Some(set) = chain.pop() {
                rank[set as usize] = narrow(start.len() - 1);
                node.extend_from_slice(self.nodes(set as usize));
                start.push(narrow(node.len()));
            }
        }
        (self.start, self.node) = (start, node);
        Some(rank)
    }
}

/// The lowest node of an ascending list; 0 where it has none.
#[inline]
fn lowest(nodes: &[u32]) -> u32 {
    nodes.first().copied().unwrap_or(0)
}

impl<'a, const D: usize> Group<'a, D> {
    /// Values and gradients of the `k`-th point of the group, one per node.
    #[inline]
    pub fn point(&self, k: usize) -> (&'a [f64], &'a [Vector<D>]) {
        let n = self.nodes.len();
        (&self.values[k * n..(k + 1) * n], &self.gradients[k * n..(k + 1) * n])
    }
}
