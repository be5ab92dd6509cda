//! Sparsity of the tangent: which node couples with which, and where each coupling is stored.
//!
//! The lower triangle is stored by columns, equation `D·node + component`, in the order of the
//! active nodes. It depends on connectivity alone: prescribed components stay in the matrix, as rows
//! and columns with nothing but their diagonal.

use crate::{Constraints, Couplings, GhostFaces};
use rayon::prelude::*;

/// Nodes per parallel task; fixed, so that nothing depends on the number of threads.
const CHUNK: usize = 1024;

/// Lower triangle of the block-sparse tangent, `D × D` blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern<const D: usize> {
    /// Start of every node's neighbours in `neighbour`, and its length at the end.
    neighbour_start: Vec<usize>,
    /// Neighbours with a higher active number than the node itself, ascending.
    neighbour: Vec<u32>,
    /// Start of every equation's column.
    column_start: Vec<usize>,
    /// Rows, ascending in each column, the diagonal first.
    row: Vec<usize>,
}

impl<const D: usize> Pattern<D> {
    /// Couples all nodes that share a set of any body.
    pub fn of<C: Couplings>(n_active: usize, bodies: &[C]) -> Self {
        Self::reusing(None, n_active, bodies, None)
    }

    /// Couples all nodes that share a set of any body or a face, in the memory of a pattern that is
    /// no longer needed.
    pub fn reusing<C: Couplings>(
        former: Option<Self>,
        n_active: usize,
        bodies: &[C],
        faces: Option<&GhostFaces<D>>,
    ) -> Self {
        let mut pattern = former.unwrap_or_else(|| Self {
            neighbour_start: Vec::new(),
            neighbour: Vec::new(),
            column_start: Vec::new(),
            row: Vec::new(),
        });
        let incidence: Vec<Incidence> = bodies.iter().map(|links| Incidence::of(n_active, links)).collect();
        let faces = faces.map(|faces| (faces, Incidence::of(n_active, faces)));
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
                    for (links, incidence) in bodies.iter().zip(&incidence) {
                        for &(group, position) in incidence.at(node) {
                            found.extend_from_slice(&links.set(group as usize)[position as usize + 1..]);
                        }
                    }
                    if let Some((faces, incidence)) = &faces {
                        for &(face, position) in incidence.at(node) {
                            found.extend_from_slice(&faces.set(face as usize)[position as usize + 1..]);
                        }
                    }
                    found_by.once(&mut found, node);
                    neighbour.extend_from_slice(&found);
                    end.push(neighbour.len());
                }
                (end, neighbour)
            })
            .collect();

        let Self { neighbour_start, neighbour, column_start, row } = &mut pattern;
        neighbour_start.clear();
        neighbour_start.push(0);
        neighbour.clear();
        for (end, list) in chunks {
            let offset = neighbour.len();
            neighbour_start.extend(end.into_iter().map(|end| end + offset));
            neighbour.extend(list);
        }
        scalar_columns::<D>(neighbour_start, neighbour, column_start, row);
        pattern
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
        mpm_linear::Pattern::symmetric(&self.column_start, &self.row, D)
    }

    /// Number of stored entries.
    pub fn n_entries(&self) -> usize {
        self.row.len()
    }

    /// Neighbours with a higher number.
    fn neighbours(&self, node: usize) -> &[u32] {
        &self.neighbour[self.neighbour_start[node]..self.neighbour_start[node + 1]]
    }

    /// For each pair (column node, row node), column before row, of each set in turn: position of
    /// the row among the column's neighbours.
    pub(crate) fn slots(&self, couplings: &impl Couplings) -> Vec<u32> {
        let pairs = |set| {
            let n = couplings.set(set).len();
            n * n.saturating_sub(1) / 2
        };
        let mut slots = Vec::with_capacity((0..couplings.n_sets()).map(pairs).sum());
        for set in 0..couplings.n_sets() {
            let nodes = couplings.set(set);
            for (k, &node) in nodes.iter().enumerate() {
                let neighbours = self.neighbours(node as usize);
                let mut at = 0;
                for &other in &nodes[k + 1..] {
                    while neighbours[at] != other {
                        at += 1;
                    }
                    slots.push(u32::try_from(at).expect("fewer than 2^32 neighbours"));
                }
            }
        }
        slots
    }

    /// Adds `stiffness · I` for each pair of nodes, columns in turn from the diagonal down, leaving out
    /// what is prescribed; `slots` as from [`Pattern::slots`].
    pub(crate) fn add_isotropic(
        &self,
        nodes: &[u32],
        slots: &[u32],
        stiffness: &[f64],
        constraints: &Constraints<D>,
        values: &mut [f64],
    ) {
        let (mut stiffness, mut slots) = (stiffness.iter(), slots.iter());
        for (w, &column) in nodes.iter().enumerate() {
            let column = column as usize;
            let diagonal = stiffness.next().expect("one for each pair");
            for j in 0..D {
                // A prescribed component keeps its own stiffness, alone in its row and column.
                values[self.column_start[column * D + j]] += diagonal;
            }
            for &row in &nodes[w + 1..] {
                let value = stiffness.next().expect("one for each pair");
                let slot = *slots.next().expect("one for each pair") as usize;
                let free = |j: &usize| {
                    !constraints.is_prescribed(column, *j) && !constraints.is_prescribed(row as usize, *j)
                };
                for j in (0..D).filter(free) {
                    values[self.column_start[column * D + j] + (D - j) + slot * D + j] += value;
                }
            }
        }
    }
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
    fn of(n_active: usize, couplings: &impl Couplings) -> Self {
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
    row.reserve(n_active * D * (D + 1) / 2 + neighbour.len() * D * D);
    for node in 0..n_active {
        for component in 0..D {
            row.extend((component..D).map(|i| node * D + i));
            for &other in &neighbour[neighbour_start[node]..neighbour_start[node + 1]] {
                row.extend((0..D).map(|i| other as usize * D + i));
            }
            column_start.push(row.len());
        }
    }
}
