//! Sparsity of the tangent: which node couples with which, and where each coupling is stored.
//!
//! Entries are stored by columns, equation `D·node + component`, in the order of the active nodes: the lower triangle
//! of a symmetric tangent, both triangles of another. The pattern depends on connectivity alone: prescribed
//! components stay in the matrix, as rows and columns with nothing but their diagonal.

use crate::{Constraints, Couplings};
use mpm_linear::Symmetry;
use rayon::prelude::*;

/// Nodes per parallel task; fixed, so that nothing depends on the number of threads.
const CHUNK: usize = 1024;

/// Block-sparse tangent, `D × D` blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern<const D: usize> {
    symmetry: Symmetry,
    /// Start of every node's neighbours in `neighbour`, and its length at the end.
    neighbour_start: Vec<usize>,
    /// Nodes that a node couples with, ascending: those with a higher number of a symmetric tangent, all of another,
    /// the node itself included.
    neighbour: Vec<u32>,
    /// Start of every equation's column.
    column_start: Vec<usize>,
    /// Rows, ascending in each column; the diagonal of a symmetric tangent is the first.
    row: Vec<usize>,
}

impl<const D: usize> Pattern<D> {
    /// Couples all nodes that share a set.
    pub fn of(n_active: usize, symmetry: Symmetry, couplings: &[&dyn Couplings]) -> Self {
        Self::reusing(None, n_active, symmetry, couplings)
    }

    /// Couples all nodes that share a set, in the memory of a pattern that is no longer needed.
    pub fn reusing(
        former: Option<Self>,
        n_active: usize,
        symmetry: Symmetry,
        couplings: &[&dyn Couplings],
    ) -> Self {
        let mut pattern = former.unwrap_or_else(|| Self {
            symmetry,
            neighbour_start: Vec::new(),
            neighbour: Vec::new(),
            column_start: Vec::new(),
            row: Vec::new(),
        });
        pattern.symmetry = symmetry;
        let incidence: Vec<Incidence> = couplings.iter().map(|it| Incidence::of(n_active, *it)).collect();
        let chunks: Vec<(Vec<usize>, Vec<u32>)> = (0..n_active.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let nodes = chunk * CHUNK..((chunk + 1) * CHUNK).min(n_active);
                let mut end = Vec::with_capacity(nodes.len());
                let mut neighbour: Vec<u32> = Vec::new();
                let mut found: Vec<u32> = Vec::new();
                let mut found_by = FoundBy { first: nodes.start, node: Vec::new() };
                for node in nodes {
                    found.clear();
                    for (couplings, incidence) in couplings.iter().zip(&incidence) {
                        for &(set, position) in incidence.at(node) {
                            found.extend_from_slice(&couplings.set(set as usize)[position as usize + 1..]);
                        }
                    }
                    found_by.once(&mut found, node);
                    neighbour.extend_from_slice(&found);
                    end.push(neighbour.len());
                }
                (end, neighbour)
            })
            .collect();

        let Self { neighbour_start, neighbour, column_start, row, .. } = &mut pattern;
        neighbour_start.clear();
        neighbour_start.push(0);
        neighbour.clear();
        for (end, list) in chunks {
            let offset = neighbour.len();
            neighbour_start.extend(end.into_iter().map(|end| end + offset));
            neighbour.extend(list);
        }
        if symmetry == Symmetry::Unsymmetric {
            (*neighbour_start, *neighbour) = both_ways(neighbour_start, neighbour);
        }
        scalar_columns::<D>(symmetry, neighbour_start, neighbour, column_start, row);
        pattern
    }

    /// Which triangles are stored.
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Number of equations, prescribed ones included.
    pub fn n_equations(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Start of every column in [`Pattern::row`], and its length at the end.
    pub fn column_start(&self) -> &[usize] {
        &self.column_start
    }

    /// Row of every stored entry.
    pub fn row(&self) -> &[usize] {
        &self.row
    }

    /// The pattern as linear solvers take it: `D` equations for each node.
    pub fn for_solver(&self) -> mpm_linear::Pattern<'_> {
        let pattern = match self.symmetry {
            Symmetry::Symmetric => mpm_linear::Pattern::symmetric,
            Symmetry::Unsymmetric => mpm_linear::Pattern::unsymmetric,
        };
        pattern(&self.column_start, &self.row, D)
    }

    /// Number of stored entries.
    pub fn n_entries(&self) -> usize {
        self.row.len()
    }

    /// Place of a component's own stiffness.
    pub(crate) fn diagonal(&self, node: usize, component: usize) -> usize {
        let start = self.column_start[node * D + component];
        match self.symmetry {
            Symmetry::Symmetric => start,
            Symmetry::Unsymmetric => {
                start + self.neighbours(node).partition_point(|&it| (it as usize) < node) * D + component
            }
        }
    }

    /// Neighbours that the node's columns hold.
    fn neighbours(&self, node: usize) -> &[u32] {
        &self.neighbour[self.neighbour_start[node]..self.neighbour_start[node + 1]]
    }

    /// Number of [slots](Self::slots) of a set of `n` nodes.
    pub(crate) fn n_slots(&self, n: usize) -> usize {
        match self.symmetry {
            Symmetry::Symmetric => n * n.saturating_sub(1) / 2,
            Symmetry::Unsymmetric => n * n,
        }
    }

    /// For each pair (column node, row node) of each set in turn, column by column: position of the row among the
    /// column's neighbours. The pairs are those with the column before the row where the tangent is symmetric, else all.
    pub(crate) fn slots(&self, couplings: &dyn Couplings) -> Vec<u32> {
        let is_symmetric = self.symmetry == Symmetry::Symmetric;
        let n_slots = (0..couplings.n_sets()).map(|set| self.n_slots(couplings.set(set).len()));
        let mut slots = Vec::with_capacity(n_slots.sum());
        for set in 0..couplings.n_sets() {
            let nodes = couplings.set(set);
            for (k, &node) in nodes.iter().enumerate() {
                let neighbours = self.neighbours(node as usize);
                let mut at = 0;
                for &other in &nodes[if is_symmetric { k + 1 } else { 0 }..] {
                    while neighbours[at] != other {
                        at += 1;
                    }
                    slots.push(u32::try_from(at).expect("fewer than 2^32 neighbours"));
                }
            }
        }
        slots
    }

    /// Adds `stiffness · I` for each pair of nodes (columns in turn from the diagonal down, the same both ways), leaving
    /// out what is prescribed; `slots` as from [`Pattern::slots`].
    pub(crate) fn add_isotropic(
        &self,
        nodes: &[u32],
        slots: &[u32],
        stiffness: &[f64],
        constraints: &Constraints<D>,
        values: &mut [f64],
    ) {
        let n = nodes.len();
        let is_symmetric = self.symmetry == Symmetry::Symmetric;
        let (mut stiffness, mut slot) = (stiffness.iter(), 0);
        for (w, &column) in nodes.iter().enumerate() {
            let column = column as usize;
            let diagonal = stiffness.next().expect("one for each pair");
            for j in 0..D {
                // A prescribed component keeps its own stiffness, alone in its row and column.
                values[self.diagonal(column, j)] += diagonal;
            }
            for (v, &row) in nodes.iter().enumerate().skip(w + 1) {
                let (row, value) = (row as usize, stiffness.next().expect("one for each pair"));
                let free =
                    |j: &usize| !constraints.is_prescribed(column, *j) && !constraints.is_prescribed(row, *j);
                for j in (0..D).filter(free) {
                    let column_start = self.column_start[column * D + j];
                    if is_symmetric {
                        values[column_start + (D - j) + slots[slot] as usize * D + j] += value;
                    } else {
                        values[column_start + slots[w * n + v] as usize * D + j] += value;
                        values[self.column_start[row * D + j] + slots[v * n + w] as usize * D + j] += value;
                    }
                }
                slot += 1;
            }
        }
    }
}

/// From the neighbours with a higher number to all of them, both ways, and each node itself; ascending.
fn both_ways(start: &[usize], neighbour: &[u32]) -> (Vec<usize>, Vec<u32>) {
    let n = start.len() - 1;
    let of = |node: usize| &neighbour[start[node]..start[node + 1]];
    let mut count = vec![1; n];
    for node in 0..n {
        count[node] += of(node).len();
        of(node).iter().for_each(|&higher| count[higher as usize] += 1);
    }
    let mut all_start = Vec::with_capacity(n + 1);
    all_start.push(0);
    all_start.extend(count.iter().scan(0, |end, count| {
        *end += count;
        Some(*end)
    }));
    let (mut next, mut all) = (all_start.clone(), vec![0; all_start[n]]);
    let mut push = |node: usize, other: u32| {
        all[next[node]] = other;
        next[node] += 1;
    };
    // Every node has its lower neighbours by the time that its own turn comes.
    for node in 0..n {
        push(node, node as u32);
        for &higher in of(node) {
            push(node, higher);
            push(higher as usize, node as u32);
        }
    }
    (all_start, all)
}

/// Node that each node from `first` on was last found to be a neighbour of.
struct FoundBy {
    first: usize,
    node: Vec<u32>,
}

impl FoundBy {
    /// Sorts the nodes found above `node`, each once.
    fn once(&mut self, found: &mut Vec<u32>, node: usize) {
        // Few are sorted as they are; of many most are repeated.
        if found.len() > 32 {
            found.retain(|&other| {
                let other = other as usize - self.first;
                if self.node.len() <= other {
                    self.node.resize(other + 1, u32::MAX);
                }
                std::mem::replace(&mut self.node[other], node as u32) != node as u32
            });
        }
        found.sort_unstable();
        found.dedup();
    }
}

/// Which sets each node belongs to, and at which position.
struct Incidence {
    start: Vec<usize>,
    entry: Vec<(u32, u32)>,
}

impl Incidence {
    fn of(n_active: usize, couplings: &dyn Couplings) -> Self {
        let mut start = vec![0; n_active + 1];
        for set in 0..couplings.n_sets() {
            for &node in couplings.set(set) {
                start[node as usize + 1] += 1;
            }
        }
        for node in 0..n_active {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut entry = vec![(0, 0); start[n_active]];
        for set in 0..couplings.n_sets() {
            for (position, &node) in couplings.set(set).iter().enumerate() {
                let slot = &mut next[node as usize];
                entry[*slot] = (set as u32, position as u32);
                *slot += 1;
            }
        }
        Self { start, entry }
    }

    fn at(&self, node: usize) -> &[(u32, u32)] {
        &self.entry[self.start[node]..self.start[node + 1]]
    }
}

/// Columns of the equations from neighbours of the nodes.
fn scalar_columns<const D: usize>(
    symmetry: Symmetry,
    neighbour_start: &[usize],
    neighbour: &[u32],
    column_start: &mut Vec<usize>,
    row: &mut Vec<usize>,
) {
    let n_active = neighbour_start.len() - 1;
    column_start.clear();
    column_start.reserve(n_active * D + 1);
    column_start.push(0);
    row.clear();
    let is_symmetric = symmetry == Symmetry::Symmetric;
    row.reserve(neighbour.len() * D * D + if is_symmetric { n_active * D * (D + 1) / 2 } else { 0 });
    for node in 0..n_active {
        for component in 0..D {
            if is_symmetric {
                row.extend((component..D).map(|i| node * D + i));
            }
            for &other in &neighbour[neighbour_start[node]..neighbour_start[node + 1]] {
                row.extend((0..D).map(|i| other as usize * D + i));
            }
            column_start.push(row.len());
        }
    }
}
