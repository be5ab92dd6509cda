//! The fronts of a multifrontal factorisation: which equations each of them eliminates, and what it hands on
//! (I. S. Duff and J. K. Reid, ACM Trans. Math. Softw. 9, 1983).
//!
//! A front is a small dense matrix. Its first equations are eliminated in it; what is left of the others, its
//! *remainder*, is added to the front of its parent. Fronts stand children first, so that those below any front, its
//! *subtree*, come right before it, and so do the steps of elimination that happen there.

use super::symbolic;
use crate::matrix::{Pattern, Symmetry};
use crate::report::OutOfMemory;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use std::ops::Range;

/// An entry of the matrix and its place.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// Place among the numbers of the front: first its columns, then its rows to the right of them.
    pub(super) place: usize,
    /// Number of the entry in the matrix.
    pub(super) source: usize,
}

/// One front.
#[derive(Default)]
pub(super) struct Front {
    /// Steps of elimination that happen here, the first and the one after the last.
    pub(super) steps: Range<usize>,
    /// Equations that are left, a range of [`Fronts::place_in_parent`].
    pub(super) rest: Range<usize>,
    /// Fronts whose remainders are added to this one, a range of [`Fronts::children`].
    pub(super) children: Range<usize>,
    /// The first front of its subtree.
    pub(super) first: usize,
    /// Where its numbers begin among those of all fronts.
    pub(super) start: usize,
    /// Numbers of the rows of U to the right of its columns; none of a symmetric matrix.
    pub(super) n_right: usize,
    /// Entries of the matrix that it takes, a range of [`Fronts::entries`].
    pub(super) entries: Range<usize>,
    /// Multiplications of its subtree.
    pub(super) work: f64,
}

impl Front {
    /// Equations that are eliminated in it.
    pub(super) fn n_eliminated(&self) -> usize {
        self.steps.len()
    }

    /// Equations that are left.
    pub(super) fn n_rest(&self) -> usize {
        self.rest.len()
    }

    /// Numbers of its remainder.
    pub(super) fn n_remainder(&self) -> usize {
        self.n_rest() * self.n_rest()
    }

    /// Rows of its columns.
    pub(super) fn height(&self) -> usize {
        self.n_eliminated() + self.n_rest()
    }

    /// Numbers of the columns of L and U that are eliminated here, rows of the rest included.
    pub(super) fn n_columns(&self) -> usize {
        self.height() * self.n_eliminated()
    }

    /// Its place among the numbers of all fronts.
    pub(super) fn numbers(&self) -> Range<usize> {
        self.start..self.start + self.n_columns() + self.n_right
    }

    /// Multiplications of its own elimination by LLᵀ.
    pub(super) fn own_work(&self) -> f64 {
        let (eliminated, rest) = (self.n_eliminated() as f64, self.n_rest() as f64);
        eliminated * (eliminated * eliminated / 3.0 + eliminated * rest + rest * rest)
    }
}

/// The fronts of a pattern in an order of elimination, children before parents.
pub(super) struct Fronts {
    pub(super) fronts: Vec<Front>,
    /// Equation at each step of elimination.
    pub(super) order: Vec<usize>,
    pub(super) entries: Vec<Entry>,
    /// Row or column of the parent's front at which each of the rest of a front stands there, ascending.
    pub(super) place_in_parent: Vec<usize>,
    pub(super) children: Vec<usize>,
    /// Numbers of all fronts: L, and U of an unsymmetric matrix.
    pub(super) n_numbers: usize,
    /// Whether the matrix is symmetric: fronts then hold lower triangles.
    pub(super) is_symmetric: bool,
}

impl Fronts {
    /// Finds the fronts of a pattern, eliminated in this order (new to old). An entry of an unsymmetric pattern whose
    /// mirror image is not stored counts as stored.
    pub(super) fn new(pattern: Pattern<'_>, order: &[usize]) -> Result<Self, OutOfMemory> {
        let symbolic = match pattern.symmetry {
            Symmetry::Symmetric => symbolic::analyse(pattern, order)?,
            Symmetry::Unsymmetric => {
                let (column_start, row) = lower_union(pattern);
                symbolic::analyse(Pattern::symmetric(&column_start, &row, 1), order)?
            }
        };
        let (mut found, rest) = Self::of_supernodes(&symbolic, order, pattern.is_symmetric());
        found.link(&rest);
        found.take_entries(pattern, &rest);
        Ok(found)
    }

    /// Row or column of the parent's front at which each of the rest of a front stands there.
    pub(super) fn places(&self, k: usize) -> &[usize] {
        &self.place_in_parent[self.fronts[k].rest.clone()]
    }

    /// Fronts whose remainders are added to this one.
    pub(super) fn children(&self, k: usize) -> &[usize] {
        &self.children[self.fronts[k].children.clone()]
    }

    /// Bytes of the structure.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.fronts[..])
            + size_of_val(&self.order[..])
            + size_of_val(&self.entries[..])
            + size_of_val(&self.place_in_parent[..])
            + size_of_val(&self.children[..])
    }

    /// A front for each supernode, children before parents, and those of a front right before it, each after its own;
    /// and the steps at which what is left of each front is eliminated.
    fn of_supernodes(
        symbolic: &SymbolicCholesky<usize>,
        order: &[usize],
        is_symmetric: bool,
    ) -> (Self, Vec<usize>) {
        let mut all = Self {
            fronts: Vec::new(),
            order: Vec::with_capacity(order.len()),
            entries: Vec::new(),
            place_in_parent: Vec::new(),
            children: Vec::new(),
            n_numbers: 0,
            is_symmetric,
        };
        let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else {
            assert_eq!(symbolic.nrows(), 0, "supernodes were asked for");
            return (all, Vec::new());
        };
        let n = supernodes.n_supernodes();
        let (begin, end) = (supernodes.supernode_begin(), supernodes.supernode_end());
        let mut of_step = vec![0; symbolic.nrows()];
        (0..n).for_each(|s| of_step[begin[s]..end[s]].fill(s));
        let parent = |s: usize| supernodes.supernode(s).pattern().first().map(|&step| of_step[step]);
        let (start, children) = by_first(n + 1, || (0..n).map(|s| (parent(s).unwrap_or(n), s)));
        let children = |s: usize| &children[start[s]..start[s + 1]];

        // Supernode and, once it is reached for the first time, the first front of its subtree.
        let mut stack: Vec<(usize, Option<usize>)> = children(n).iter().rev().map(|&s| (s, None)).collect();
        let mut index = vec![0; n];
        let mut new_step = vec![0; symbolic.nrows()];
        let mut rest = Vec::new();
        while let Some((s, reached)) = stack.pop() {
            let Some(first) = reached else {
                stack.push((s, Some(all.fronts.len())));
                stack.extend(children(s).iter().rev().map(|&child| (child, None)));
                continue;
            };
            index[s] = all.fronts.len();
            let first_step = all.order.len();
            for step in begin[s]..end[s] {
                new_step[step] = all.order.len();
                all.order.push(order[step]);
            }
            let (first_rest, first_child) = (rest.len(), all.children.len());
            rest.extend_from_slice(supernodes.supernode(s).pattern());
            all.children.extend(children(s).iter().map(|&child| index[child]));
            let mut front = Front {
                steps: first_step..all.order.len(),
                rest: first_rest..rest.len(),
                children: first_child..all.children.len(),
                first,
                start: all.n_numbers,
                ..Front::default()
            };
            front.n_right = if is_symmetric { 0 } else { front.n_eliminated() * front.n_rest() };
            front.work = front.own_work()
                + all.children[first_child..].iter().map(|&child| all.fronts[child].work).sum::<f64>();
            all.n_numbers = front.numbers().end;
            all.fronts.push(front);
        }
        // Steps of the rest of a front are those of its ancestors, whose sequence is what it was.
        rest.iter_mut().for_each(|step| *step = new_step[*step]);
        (all, rest)
    }

    /// Finds where the rest of each front, given as steps, stands in its parent.
    fn link(&mut self, rest: &[usize]) {
        self.place_in_parent = vec![0; rest.len()];
        for front in &self.fronts {
            let steps = &front.steps;
            for child in self.children[front.children.clone()].iter().map(|&child| &self.fronts[child]) {
                let (mut at, beyond) = (0, &rest[front.rest.clone()]);
                let places = &mut self.place_in_parent[child.rest.clone()];
                for (place, &step) in places.iter_mut().zip(&rest[child.rest.clone()]) {
                    *place = if step < steps.end {
                        step - steps.start
                    } else {
                        let ahead = beyond[at..].iter().position(|&other| other == step);
                        at += ahead.expect("a parent has its child's rest");
                        steps.len() + at
                    };
                }
            }
        }
    }

    /// Gives each entry of the matrix to the front that eliminates its row or its column first.
    fn take_entries(&mut self, pattern: Pattern<'_>, rest: &[usize]) {
        let Self { fronts, order, entries, is_symmetric, .. } = self;
        let n = order.len();
        let mut position = vec![0; n];
        order.iter().enumerate().for_each(|(step, &equation)| position[equation] = step);
        let position = &position;
        // Entries to the right of the diagonal, by rows.
        let each = || {
            (0..n).flat_map(|j| {
                let sources = pattern.column_start[j]..pattern.column_start[j + 1];
                let of_row = move |source: usize| (position[pattern.row[source]], (position[j], source));
                sources.map(of_row).filter(move |&(row, _)| row < position[j])
            })
        };
        let (start, right) = by_first(n, each);
        entries.reserve_exact(pattern.n_entries());
        // Row of the front at which each of its steps stands.
        let mut place = vec![0; n];
        for front in fronts {
            let (first, n_eliminated) = (front.steps.start, front.n_eliminated());
            let (height, n_columns) = (front.height(), front.n_columns());
            front.steps.clone().for_each(|step| place[step] = step - first);
            rest[front.rest.clone()].iter().enumerate().for_each(|(k, &step)| place[step] = n_eliminated + k);
            let begin = entries.len();
            for step in front.steps.clone() {
                let (column, equation) = (step - first, order[step]);
                for source in pattern.column_start[equation]..pattern.column_start[equation + 1] {
                    let below = position[pattern.row[source]];
                    if below >= step {
                        entries.push(Entry { place: column * height + place[below], source });
                    }
                }
                for &(other, source) in &right[start[step]..start[step + 1]] {
                    let at = match place[other] {
                        mirrored if *is_symmetric => column * height + mirrored,
                        within if within < n_eliminated => within * height + column,
                        beyond => n_columns + (beyond - n_eliminated) * n_eliminated + column,
                    };
                    entries.push(Entry { place: at, source });
                }
            }
            front.entries = begin..entries.len();
        }
    }
}

/// The lower triangle of the union of a pattern and its mirror image.
fn lower_union(pattern: Pattern<'_>) -> (Vec<usize>, Vec<usize>) {
    let n = pattern.n_equations();
    let each = || (0..n).flat_map(|j| pattern.rows_of(j).iter().map(move |&i| (i.min(j), i.max(j))));
    let (start, all) = by_first(n, each);
    let (mut column_start, mut row) = (vec![0], Vec::with_capacity(pattern.n_entries()));
    for j in 0..n {
        let first = row.len();
        row.extend_from_slice(&all[start[j]..start[j + 1]]);
        row[first..].sort_unstable();
        let mut kept = first;
        for k in first..row.len() {
            if k == first || row[k] != row[kept - 1] {
                row[kept] = row[k];
                kept += 1;
            }
        }
        row.truncate(kept);
        column_start.push(kept);
    }
    (column_start, row)
}

/// Pairs grouped by their first number, below `n`: where each group starts, and the second ones.
fn by_first<T: Copy + Default, I: Iterator<Item = (usize, T)>>(
    n: usize,
    pairs: impl Fn() -> I,
) -> (Vec<usize>, Vec<T>) {
    let mut start = vec![0; n + 1];
    pairs().for_each(|(first, _)| start[first + 1] += 1);
    for k in 0..n {
        start[k + 1] += start[k];
    }
    let mut next = start.clone();
    let mut grouped = vec![T::default(); start[n]];
    for (first, second) in pairs() {
        grouped[next[first]] = second;
        next[first] += 1;
    }
    (start, grouped)
}
