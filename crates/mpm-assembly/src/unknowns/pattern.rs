//! Sparsity of the tangent: which node couples with which, and where each coupling is stored.
//!
//! Entries are stored by columns, in the order of the unknowns: the lower triangle of a symmetric tangent, both triangles
//! of another. The pattern depends on connectivity alone: prescribed
//! components stay in the matrix, as rows and columns with nothing but their diagonal.

use super::incidence::Incidence;
use super::numbering::node_equation;
use super::{Constraints, Couplings, UnknownId, Unknowns};
use mpm_basis::parallel::{each, fill, parts, resize};
use mpm_grid::{Block, Vector};
use mpm_linear::Symmetry;
use std::ops::Range;

/// Nodes per parallel task; fixed, so that nothing depends on the number of threads.
const CHUNK: usize = 1024;

/// Block-sparse tangent: blocks of a place and a place, `D × D` where both are nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SparsityPattern<const D: usize> {
    symmetry: Symmetry,
    unknowns: Unknowns<D>,
    /// Start of every place's neighbours in `neighbour`, and its length at the end.
    neighbour_start: Vec<usize>,
    /// Places that a place couples with, ascending: those with a higher number of a symmetric tangent, all of another,
    /// the place itself included.
    neighbour: Vec<u32>,
    /// Start of every equation's column.
    column_start: Vec<usize>,
    /// Rows, ascending in each column; the diagonal of a symmetric tangent is the first.
    row: Vec<usize>,
}

impl<const D: usize> SparsityPattern<D> {
    /// Couples all nodes that share a set; there are no other unknowns than their displacement.
    pub fn of(n_active: usize, symmetry: Symmetry, couplings: &[&dyn Couplings]) -> Self {
        Self::reusing(None, &Unknowns::of_nodes(n_active), symmetry, couplings)
    }

    /// Couples all places that share a set, in the memory of a pattern that is no longer needed.
    pub fn reusing(
        former: Option<Self>,
        unknowns: &Unknowns<D>,
        symmetry: Symmetry,
        couplings: &[&dyn Couplings],
    ) -> Self {
        let mut pattern = former.unwrap_or_else(|| Self {
            symmetry,
            unknowns: unknowns.clone(),
            neighbour_start: Vec::new(),
            neighbour: Vec::new(),
            column_start: Vec::new(),
            row: Vec::new(),
        });
        pattern.symmetry = symmetry;
        pattern.unknowns.clone_from(unknowns);
        let n_places = unknowns.n_places();
        let incidence: Vec<Incidence> = couplings.iter().map(|it| Incidence::of(n_places, *it)).collect();
        let chunks: Vec<(Vec<usize>, Vec<u32>)> = each(n_places.div_ceil(CHUNK), &|chunk| {
            let nodes = chunk * CHUNK..((chunk + 1) * CHUNK).min(n_places);
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
        });

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
        scalar_columns(symmetry, unknowns, neighbour_start, neighbour, column_start, row);
        pattern
    }

    /// The unknowns of its rows and columns.
    pub fn unknowns(&self) -> &Unknowns<D> {
        &self.unknowns
    }

    /// Which triangles are stored.
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Number of equations, prescribed ones included.
    pub fn n_equations(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Start of every column in [`SparsityPattern::row`], and its length at the end.
    pub fn column_start(&self) -> &[usize] {
        &self.column_start
    }

    /// Row of every stored entry.
    pub fn row(&self) -> &[usize] {
        &self.row
    }

    /// The pattern as linear solvers take it: `D` equations for each node, then those of no node.
    pub fn for_solver(&self) -> mpm_linear::Pattern<'_> {
        mpm_linear::Pattern {
            column_start: &self.column_start,
            row: &self.row,
            symmetry: self.symmetry,
            block: D,
            blocks: self.unknowns.n_nodes(),
        }
    }

    /// Number of stored entries.
    pub fn n_entries(&self) -> usize {
        self.row.len()
    }

    /// Place of the stiffness of an unknown against itself.
    pub(crate) fn diagonal(&self, equation: usize) -> usize {
        match self.symmetry {
            Symmetry::Symmetric => self.column_start[equation],
            Symmetry::Unsymmetric => self.find(equation, equation),
        }
    }

    /// Appends where the entries in some rows, ascending, stand in their column.
    ///
    /// # Panics
    /// No contribution couples one of the rows with the column.
    pub(crate) fn push_offsets(&self, column: usize, rows: &[usize], to: &mut Vec<u32>) {
        let Some(&first) = rows.first() else { return };
        let start = self.column_start[column];
        let mut at = self.find(first, column);
        for &row in rows {
            while self.row[at] != row {
                at += 1;
            }
            to.push(u32::try_from(at - start).expect("fewer than 2^32 rows"));
        }
    }

    /// The entries of some columns.
    pub(crate) fn column_range(&self, columns: std::ops::Range<usize>) -> std::ops::Range<usize> {
        self.column_start[columns.start]..self.column_start[columns.end]
    }

    /// Place of the entry in a row and a column; of a symmetric tangent the row is not above the column.
    fn find(&self, row: usize, column: usize) -> usize {
        let entries = self.column_start[column]..self.column_start[column + 1];
        let at = self.row[entries.clone()].binary_search(&row);
        entries.start + at.unwrap_or_else(|_| panic!("no contribution couples unknowns {row} and {column}"))
    }

    /// Adds the dense `stiffness` of some unknowns, column by column, leaving out what is prescribed.
    pub(crate) fn add_dense(
        &self,
        unknowns: &[UnknownId],
        stiffness: &[f64],
        constraints: &Constraints<D>,
        values: &mut [f64],
    ) {
        let n = unknowns.len();
        let is_free = |unknown: UnknownId| match self.unknowns.node_of(unknown.equation()) {
            Some((node, component)) => !constraints.is_prescribed(node, component),
            None => true,
        };
        for (w, &column) in unknowns.iter().enumerate() {
            // Components of a node follow each other.
            let mut next = self.column_start[column.equation()];
            for (v, &row) in unknowns.iter().enumerate() {
                let is_stored = self.symmetry == Symmetry::Unsymmetric || row >= column;
                // A prescribed component keeps its own stiffness, alone in its row and column.
                if is_stored && (row == column || (is_free(row) && is_free(column))) {
                    let is_next =
                        next < self.column_start[column.equation() + 1] && self.row[next] == row.equation();
                    let at = if is_next { next } else { self.find(row.equation(), column.equation()) };
                    values[at] += stiffness[w * n + v];
                    next = at + 1;
                }
            }
        }
    }

    /// Adds `W_v W_w k` for each pair of nodes v (rows) and w, leaving out what is prescribed. Of a symmetric tangent the lower
    /// triangle of k is taken.
    pub(crate) fn add_carried(
        &self,
        carriers: &[(u32, f64)],
        block: &Block<D>,
        constraints: &Constraints<D>,
        values: &mut [f64],
    ) {
        let is_symmetric = self.symmetry == Symmetry::Symmetric;
        for &(column, w) in carriers {
            let neighbours = self.neighbours(column as usize);
            for &(row, v) in carriers.iter().filter(|it| !is_symmetric || it.0 >= column) {
                let is_own = row == column;
                // Of a symmetric tangent a column begins with the rows of its own node, from the diagonal on.
                let slot = match is_symmetric && is_own {
                    true => 0,
                    false => neighbours
                        .binary_search(&row)
                        .unwrap_or_else(|_| panic!("no contribution couples nodes {row} and {column}")),
                };
                for j in 0..D {
                    let start = self.column_start[node_equation::<D>(column as usize, j)];
                    for i in if is_symmetric && is_own { j } else { 0 }..D {
                        let is_free =
                            |node: u32, component| !constraints.is_prescribed(node as usize, component);
                        // A prescribed component keeps its own stiffness, alone in its row and column.
                        if (is_own && i == j) || (is_free(row, i) && is_free(column, j)) {
                            let at = match (is_symmetric, is_own) {
                                (true, true) => i - j,
                                (true, false) => D - j + node_equation::<D>(slot, i),
                                (false, _) => node_equation::<D>(slot, i),
                            };
                            values[start + at] += v * w * block[(i, j)];
                        }
                    }
                }
            }
        }
    }

    /// Subtracts the product of a stored tangent and a vector, both in the order of the equations.
    pub(crate) fn subtract_product(&self, values: &[f64], vector: &[f64], from: &mut [f64]) {
        for column in 0..self.n_equations() {
            let entries = self.column_start[column]..self.column_start[column + 1];
            for (&row, value) in self.row[entries.clone()].iter().zip(&values[entries]) {
                from[row] -= value * vector[column];
                if self.symmetry == Symmetry::Symmetric && row != column {
                    from[column] -= value * vector[row];
                }
            }
        }
    }

    /// Neighbours that the place's columns hold.
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
        let n = couplings.n_sets();
        let first = |chunk: usize| (chunk * CHUNK).min(n);
        let sets = |chunk| first(chunk)..first(chunk + 1);
        let length = |chunk| sets(chunk).map(|set| self.n_slots(couplings.set(set).len())).sum();
        let n_chunks = n.div_ceil(CHUNK);
        let lengths: Vec<usize> = (0..n_chunks).map(length).collect();
        let mut slots = vec![0; lengths.iter().sum()];
        fill(parts(&mut slots, lengths).collect(), &|chunk, slots| {
            self.write_slots(sets(chunk).map(|set| couplings.set(set)), slots);
        });
        slots
    }

    /// Writes the [slots](Self::slots) of some sets.
    fn write_slots<'a>(&self, sets: impl Iterator<Item = &'a [u32]>, slots: &mut [u32]) {
        let is_symmetric = self.symmetry == Symmetry::Symmetric;
        let mut slots = slots.iter_mut();
        for nodes in sets {
            for (k, &node) in nodes.iter().enumerate() {
                let neighbours = self.neighbours(node as usize);
                let mut at = 0;
                for &other in &nodes[if is_symmetric { k + 1 } else { 0 }..] {
                    while neighbours[at] != other {
                        at += 1;
                    }
                    let slot = slots.next().expect("one for each pair");
                    *slot = u32::try_from(at).expect("fewer than 2^32 neighbours");
                }
            }
        }
    }

    /// Adds `stiffness`, times a factor for each component, for each pair of nodes (columns in turn from the diagonal down,
    /// the same both ways), leaving out what is prescribed; `slots` as from [`SparsityPattern::slots`].
    pub(crate) fn add_by_component(
        &self,
        nodes: &[u32],
        slots: &[u32],
        (stiffness, factors): (&[f64], &Vector<D>),
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
                values[self.diagonal(node_equation::<D>(column, j))] += diagonal * factors[j];
            }
            for (v, &row) in nodes.iter().enumerate().skip(w + 1) {
                let (row, value) = (row as usize, stiffness.next().expect("one for each pair"));
                let free =
                    |j: &usize| !constraints.is_prescribed(column, *j) && !constraints.is_prescribed(row, *j);
                for j in (0..D).filter(free) {
                    let value = value * factors[j];
                    let column_start = self.column_start[node_equation::<D>(column, j)];
                    if is_symmetric {
                        values[column_start + (D - j) + node_equation::<D>(slots[slot] as usize, j)] += value;
                    } else {
                        values[column_start + node_equation::<D>(slots[w * n + v] as usize, j)] += value;
                        let column_start = self.column_start[node_equation::<D>(row, j)];
                        values[column_start + node_equation::<D>(slots[v * n + w] as usize, j)] += value;
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

/// Columns of the equations from neighbours of the places.
fn scalar_columns<const D: usize>(
    symmetry: Symmetry,
    unknowns: &Unknowns<D>,
    neighbour_start: &[usize],
    neighbour: &[u32],
    column_start: &mut Vec<usize>,
    row: &mut Vec<usize>,
) {
    let is_symmetric = symmetry == Symmetry::Symmetric;
    let neighbours = |place: usize| &neighbour[neighbour_start[place]..neighbour_start[place + 1]];
    column_start.clear();
    column_start.reserve(unknowns.n_equations() + 1);
    column_start.push(0);
    let n = unknowns.n_places();
    let mut lengths = Vec::with_capacity(n.div_ceil(CHUNK));
    let mut entries = 0;
    for first in (0..n).step_by(CHUNK) {
        let before = entries;
        for place in first..(first + CHUNK).min(n) {
            let others = neighbours(place).iter().map(|&other| unknowns.equations(other as usize).len());
            let (own, others) = (unknowns.equations(place).len(), others.sum::<usize>());
            for k in 0..own {
                entries += others + if is_symmetric { own - k } else { 0 };
                column_start.push(entries);
            }
        }
        lengths.push(entries - before);
    }
    resize(row, entries);
    fill(parts(row, lengths).collect(), &|chunk, row: &mut [usize]| {
        let mut row = row.iter_mut();
        let mut push = |equations: Range<usize>| equations.zip(&mut row).for_each(|(of, row)| *row = of);
        for place in chunk * CHUNK..((chunk + 1) * CHUNK).min(n) {
            let own = unknowns.equations(place);
            for equation in own.clone() {
                if is_symmetric {
                    push(equation..own.end);
                }
                neighbours(place).iter().for_each(|&other| push(unknowns.equations(other as usize)));
            }
        }
    });
}
