//! The system of all ranks, as rank 0 has it.

use crate::message::{Reader, Writer};
use crate::numbering::Numbering;
use mpm_linear::{Analysis, Hints, LatticePlaces, LinearSolver, Matrix, OutOfMemory, Pattern, Symmetry};

use super::answer::Place;

/// The sum of the systems of all ranks, its nodes in ascending order. Behind the blocks of the nodes come further unknowns of
/// some of them, and then those that belong to no node, which are the same on all ranks.
#[derive(Default)]
pub(super) struct System {
    column_start: Vec<usize>,
    row: Vec<usize>,
    is_unsymmetric: bool,
    block: usize,
    /// The nodes, ascending.
    nodes: Vec<u64>,
    /// Numbers of those with a further unknown, ascending.
    further: Vec<usize>,
    index: Vec<[u32; 3]>,
    position: Vec<[f64; 3]>,
    held: Vec<bool>,
    /// Of every rank: where its entries stand among those of all, and its equations.
    ranks: Vec<Part>,
    values: Vec<f64>,
}

struct Part {
    entries: Vec<usize>,
    equations: Vec<usize>,
}

/// What a rank tells of its pattern.
struct Seen {
    nodes: Vec<u64>,
    /// Those with a further unknown.
    further: Vec<u64>,
    index: Vec<u64>,
    position: Vec<f64>,
    held: Vec<u64>,
    column_start: Vec<u64>,
    row: Vec<u64>,
}

/// The nodes with a further unknown, in the order of these.
pub(super) fn further(pattern: &Pattern<'_>, hints: &Hints<'_>, numbering: &Numbering) -> Vec<u64> {
    let equations = numbering.nodes.len() * pattern.block..pattern.n_equations();
    let node = |equation| hints.further.and_then(|further| further(equation));
    equations.map_while(node).map(|node| numbering.nodes[node].index() as u64).collect()
}

/// Writes the pattern of a rank and what is known of it.
pub(super) fn write(pattern: &Pattern<'_>, hints: &Hints<'_>, numbering: &Numbering, to: &mut Writer) {
    to.counts(numbering.nodes.iter().map(|node| node.index() as u64));
    to.counts(further(pattern, hints, numbering).into_iter());
    let index: Vec<u64> = numbering.index.iter().flatten().map(|&i| u64::from(i)).collect();
    to.counts(index.into_iter());
    let nodes = 0..numbering.nodes.len();
    let positions: Option<Vec<f64>> = hints.position.map(|position| nodes.flat_map(position).collect());
    to.numbers(&positions.unwrap_or_default());
    let held = |equation| u64::from(hints.is_held.is_some_and(|is_held| is_held(equation)));
    to.counts((0..pattern.n_equations()).map(held));
    to.counts(pattern.column_start.iter().map(|&start| start as u64));
    to.counts(pattern.row.iter().map(|&row| row as u64));
}

fn read(bytes: &[u8]) -> Seen {
    let mut from = Reader::new(bytes);
    Seen {
        nodes: from.counts(),
        further: from.counts(),
        index: from.counts(),
        position: from.numbers(),
        held: from.counts(),
        column_start: from.counts(),
        row: from.counts(),
    }
}

impl System {
    /// The sum of the patterns that ranks have [written](write).
    pub(super) fn of(all: &[Vec<u8>], (symmetry, block): (Symmetry, usize)) -> Self {
        let seen: Vec<Seen> = all.iter().map(|bytes| read(bytes)).collect();
        let mut nodes: Vec<u64> = seen.iter().flat_map(|it| it.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: &u64| nodes.binary_search(node).expect("a node of all ranks");
        let mut further: Vec<usize> = seen.iter().flat_map(|it| it.further.iter().map(place)).collect();
        further.sort_unstable();
        further.dedup();
        let behind = |it: &Seen| it.held.len() - block * it.nodes.len() - it.further.len();
        let n_behind = seen.iter().map(behind).max().unwrap_or(0);
        let n = block * nodes.len() + further.len() + n_behind;
        let mut system = Self {
            is_unsymmetric: symmetry == Symmetry::Unsymmetric,
            block,
            index: vec![[0; 3]; nodes.len()],
            position: vec![[0.0; 3]; nodes.len()],
            held: vec![false; n],
            nodes,
            further,
            ..Self::default()
        };
        let equations: Vec<Vec<usize>> = seen.iter().map(|it| system.take(it)).collect();
        // Row and column of every entry, on the stored side of the diagonal.
        let of_rank = |(seen, equations): (&Seen, &Vec<usize>)| {
            let columns = seen.column_start.windows(2).enumerate();
            let entries = columns.flat_map(|(j, range)| (range[0]..range[1]).map(move |entry| (j, entry)));
            let places = entries.map(|(j, entry)| {
                let (row, column) = (equations[seen.row[entry as usize] as usize], equations[j]);
                if symmetry == Symmetry::Symmetric && row < column { (row, column) } else { (column, row) }
            });
            places.collect::<Vec<(usize, usize)>>()
        };
        let places: Vec<Vec<(usize, usize)>> = seen.iter().zip(&equations).map(of_rank).collect();
        let mut entries: Vec<(usize, usize)> = places.iter().flatten().copied().collect();
        entries.sort_unstable();
        entries.dedup();
        let find = |place: &(usize, usize)| entries.binary_search(place).expect("an entry of all ranks");
        system.ranks = places
            .iter()
            .zip(equations)
            .map(|(places, equations)| Part { entries: places.iter().map(find).collect(), equations })
            .collect();
        system.column_start = (0..=n).map(|j| entries.partition_point(|entry| entry.0 < j)).collect();
        system.row = entries.iter().map(|entry| entry.1).collect();
        system.values = vec![0.0; entries.len()];
        system
    }

    /// Takes what a rank knows of its nodes; its equations among those of all ranks.
    fn take(&mut self, seen: &Seen) -> Vec<usize> {
        let block = self.block;
        let mut equations = Vec::with_capacity(seen.held.len());
        for (v, node) in seen.nodes.iter().enumerate() {
            let place = self.nodes.binary_search(node).expect("a node of all ranks");
            self.index[place] = std::array::from_fn(|d| seen.index[3 * v + d] as u32);
            if !seen.position.is_empty() {
                self.position[place] = std::array::from_fn(|d| seen.position[3 * v + d]);
            }
            equations.extend((0..block).map(|i| block * place + i));
        }
        for node in &seen.further {
            let place = self.nodes.binary_search(node).expect("a node of all ranks");
            let entry = self.further.binary_search(&place).expect("a further unknown of all ranks");
            equations.push(block * self.nodes.len() + entry);
        }
        let (n_behind, behind) = (seen.held.len() - equations.len(), self.behind());
        equations.extend(behind..behind + n_behind);
        for (&equation, &held) in equations.iter().zip(&seen.held) {
            self.held[equation] |= held > 0;
        }
        equations
    }

    /// The first of the unknowns that belong to no node.
    fn behind(&self) -> usize {
        self.block * self.nodes.len() + self.further.len()
    }

    fn pattern(&self) -> Pattern<'_> {
        Pattern {
            column_start: &self.column_start,
            row: &self.row,
            symmetry: if self.is_unsymmetric { Symmetry::Unsymmetric } else { Symmetry::Symmetric },
            block: self.block,
            blocks: self.nodes.len(),
        }
    }

    /// The matrix that was summed last.
    pub(super) fn matrix(&self) -> Matrix<'_> {
        Matrix { pattern: self.pattern(), values: &self.values }
    }

    /// Has a solver analyse the pattern; the lattice is that of the rank's hints.
    pub(super) fn analyse(
        &self,
        solver: &mut dyn LinearSolver,
        hints: &Hints<'_>,
        is_kept: bool,
    ) -> Result<Analysis, OutOfMemory> {
        let (position, is_held) = (|node: usize| self.position[node], |equation: usize| self.held[equation]);
        let first = self.block * self.nodes.len();
        let further = |equation: usize| self.further.get(equation.checked_sub(first)?).copied();
        let all = Hints {
            lattice: hints.lattice.map(|lattice| LatticePlaces { index: &self.index, ..lattice }),
            position: if hints.position.is_some() { Some(&position) } else { None },
            further: if self.further.is_empty() { None } else { Some(&further) },
            is_held: if hints.is_held.is_some() { Some(&is_held) } else { None },
            is_kept,
            owned: None,
        };
        solver.analyse(self.pattern(), &all)
    }

    /// The matrix is the sum of those that ranks have sent, in their order.
    pub(super) fn sum(&mut self, all: &[Vec<u8>]) {
        self.values.fill(0.0);
        for (part, bytes) in self.ranks.iter().zip(all) {
            let values = Reader::new(bytes).numbers();
            part.entries.iter().zip(&values).for_each(|(&entry, value)| self.values[entry] += value);
        }
    }

    /// The right-hand side of all ranks, of which each has sent its part; what several have is the same.
    pub(super) fn right_hand_side(&self, all: &[Vec<u8>]) -> Vec<f64> {
        let mut rhs = vec![0.0; self.held.len()];
        for (part, bytes) in self.ranks.iter().zip(all) {
            let values = Reader::new(bytes).numbers();
            part.equations.iter().zip(&values).for_each(|(&equation, value)| rhs[equation] = *value);
        }
        rhs
    }

    /// For every rank an answer and the solution of its equations.
    pub(super) fn shared_out(&self, x: &[f64], answer: &[u8]) -> Vec<Vec<u8>> {
        let of_rank = |part: &Part| {
            let mut told = Writer::default();
            told.bytes(answer);
            told.numbers(&part.equations.iter().map(|&equation| x[equation]).collect::<Vec<_>>());
            told.finish()
        };
        self.ranks.iter().map(of_rank).collect()
    }

    /// Where an equation stands; none where it is none.
    pub(super) fn place(&self, equation: usize) -> Option<Place> {
        let (of_nodes, behind) = (self.block * self.nodes.len(), self.behind());
        if (behind..self.held.len()).contains(&equation) {
            return Some(Place::Behind(equation - behind));
        }
        if let Some(further) = equation.checked_sub(of_nodes) {
            return Some(Place::Further { node: self.nodes[*self.further.get(further)?] });
        }
        let node = *self.nodes.get(equation / self.block)?;
        Some(Place::Node { node, component: equation % self.block })
    }
}
