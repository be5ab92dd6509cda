//! The fronts of a multifrontal factorisation: which equations each of them eliminates, and what it hands on
//! (I. S. Duff and J. K. Reid, ACM Trans. Math. Softw. 9, 1983).
//!
//! A front is a small dense matrix. Its first equations are eliminated in it; what is left of the others, its
//! *remainder*, is added to the front of its parent. Fronts are visited children first.

use super::cholesky;
use crate::matrix::Pattern;
use crate::report::OutOfMemory;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};

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
    pub(super) steps: std::ops::Range<usize>,
    /// Later steps whose equations its columns reach, ascending.
    pub(super) rest: Vec<usize>,
    /// Row or column of the parent's front at which each of the rest stands there.
    pub(super) place_in_parent: Vec<usize>,
    /// Fronts whose remainders are added to this one: those of their level that were finished last.
    pub(super) children: Vec<usize>,
    /// Number of fronts between it and a root, modulo 2. The remainders of a level are stacked.
    pub(super) level: usize,
    /// Where its numbers begin among those of all fronts.
    pub(super) start: usize,
    /// Entries of the matrix that it takes, a range of [`Fronts::entries`].
    pub(super) entries: std::ops::Range<usize>,
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

    /// Numbers of the columns of L and U that are eliminated here, rows of the rest included.
    pub(super) fn n_columns(&self) -> usize {
        (self.n_eliminated() + self.n_rest()) * self.n_eliminated()
    }

    /// Numbers of the rows of U to the right of them.
    pub(super) fn n_right(&self) -> usize {
        self.n_eliminated() * self.n_rest()
    }
}

/// The fronts of a pattern in an order of elimination, children before parents.
pub(super) struct Fronts {
    pub(super) fronts: Vec<Front>,
    pub(super) entries: Vec<Entry>,
    /// Numbers of all fronts: L and U.
    pub(super) n_numbers: usize,
    /// Numbers of the remainders that are kept at one time, of even and of odd levels.
    pub(super) most_kept: [usize; 2],
}

impl Fronts {
    /// Finds the fronts of a pattern with both triangles, eliminated in this order (new to old). An entry whose
    /// mirror image is not stored counts as stored.
    pub(super) fn new(pattern: Pattern<'_>, order: &[usize]) -> Result<Self, OutOfMemory> {
        let (column_start, row) = lower_union(pattern);
        let symbolic = cholesky::analyse(Pattern::symmetric(&column_start, &row, 1), order)?;
        let mut fronts = of_supernodes(&symbolic);
        link(&mut fronts);
        let mut n_numbers = 0;
        for front in &mut fronts {
            front.start = n_numbers;
            n_numbers += front.n_columns() + front.n_right();
        }
        let entries = take_entries(&mut fronts, pattern, order);
        let most_kept = most_kept(&fronts);
        Ok(Self { fronts, entries, n_numbers, most_kept })
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

/// A front for each supernode, children before parents, and those of a front right before it, each after its own.
fn of_supernodes(symbolic: &SymbolicCholesky<usize>) -> Vec<Front> {
    let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else {
        assert_eq!(symbolic.nrows(), 0, "supernodes were asked for");
        return Vec::new();
    };
    let n = supernodes.n_supernodes();
    let begin = supernodes.supernode_begin();
    let end = |s: usize| begin.get(s + 1).copied().unwrap_or(symbolic.nrows());
    let mut of_step = vec![0; symbolic.nrows()];
    (0..n).for_each(|s| of_step[begin[s]..end(s)].fill(s));
    let parent = |s: usize| supernodes.supernode(s).pattern().first().map(|&step| of_step[step]);
    let (start, children) = by_first(n + 1, || (0..n).map(|s| (parent(s).unwrap_or(n), s)));
    let children = |s: usize| &children[start[s]..start[s + 1]];

    let mut fronts: Vec<Front> = Vec::with_capacity(n);
    let mut index = vec![0; n];
    let mut stack: Vec<(usize, bool)> = children(n).iter().rev().map(|&root| (root, false)).collect();
    while let Some((s, is_ready)) = stack.pop() {
        if is_ready {
            index[s] = fronts.len();
            fronts.push(Front {
                steps: begin[s]..end(s),
                rest: supernodes.supernode(s).pattern().to_vec(),
                children: children(s).iter().map(|&child| index[child]).collect(),
                ..Front::default()
            });
        } else {
            stack.push((s, true));
            stack.extend(children(s).iter().rev().map(|&child| (child, false)));
        }
    }
    fronts
}

/// Finds levels, and where the rest of each front stands in its parent.
fn link(fronts: &mut [Front]) {
    for parent in (0..fronts.len()).rev() {
        for child in fronts[parent].children.clone() {
            let Front { steps, rest, level, .. } = &fronts[parent];
            let mut at = 0;
            let places = fronts[child].rest.iter().map(|&step| {
                if step < steps.end {
                    return step - steps.start;
                }
                at +=
                    rest[at..].iter().position(|&other| other == step).expect("a parent has its child's rest");
                steps.len() + at
            });
            let places = places.collect();
            let level = 1 - level;
            fronts[child].place_in_parent = places;
            fronts[child].level = level;
        }
    }
}

/// Gives each entry of the matrix to the front that eliminates its row or its column first.
fn take_entries(fronts: &mut [Front], pattern: Pattern<'_>, order: &[usize]) -> Vec<Entry> {
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
    let mut entries = Vec::with_capacity(pattern.n_entries());
    // Row of the front at which each of its steps stands.
    let mut place = vec![0; n];
    for front in fronts {
        let (first, n_eliminated) = (front.steps.start, front.n_eliminated());
        let (height, n_columns) = (n_eliminated + front.n_rest(), front.n_columns());
        front.steps.clone().for_each(|step| place[step] = step - first);
        front.rest.iter().enumerate().for_each(|(k, &step)| place[step] = n_eliminated + k);
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
                    within if within < n_eliminated => within * height + column,
                    beyond => n_columns + (beyond - n_eliminated) * n_eliminated + column,
                };
                entries.push(Entry { place: at, source });
            }
        }
        front.entries = begin..entries.len();
    }
    entries
}

/// Numbers of remainders that stand at one time on the stacks of even and of odd levels.
fn most_kept(fronts: &[Front]) -> [usize; 2] {
    let (mut kept, mut most) = ([0; 2], [0; 2]);
    for front in fronts {
        kept[front.level] += front.n_rest() * front.n_rest();
        most[front.level] = kept[front.level].max(most[front.level]);
        let of_children: usize = front.children.iter().map(|&child| fronts[child].n_rest().pow(2)).sum();
        kept[1 - front.level] -= of_children;
    }
    most
}
