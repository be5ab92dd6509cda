//! The rows of the finest matrix, found in the columns that the caller stores.

use super::arithmetic::{LARGE_LEVEL, for_each_part};
use super::source::{Column, Source, TRANSPOSED};
use crate::matrix::Pattern;
use rayon::prelude::*;
use std::ops::Range;

/// Nodes per task: few enough that all threads have some, and not so few that tasks look through the same columns.
const LEAST: usize = 1024;
const TASKS: usize = 32;

/// Rows per task where rows are written.
const ROWS: usize = 1024;

/// Of every node the blocks stored in its rows: the node of the column, and the slot there; columns ascend. Nodes have the
/// caller's numbers.
pub(crate) struct StoredRows {
    nodes_per_task: usize,
    tasks: Vec<RowsOfTask>,
}

struct RowsOfTask {
    /// Start of each row in `block`, and its length.
    start: Vec<usize>,
    block: Vec<(u32, u32)>,
}

impl StoredRows {
    /// Transposes the columns of `n` nodes; calls `see` with both nodes of each block.
    pub(crate) fn of<const D: usize, R: Send>(
        pattern: Pattern<'_>,
        n: usize,
        none: impl Fn() -> R + Sync,
        see: impl Fn(&mut R, usize, usize) + Sync,
    ) -> (Self, Vec<R>) {
        let nodes_per_task = LEAST.max(n.div_ceil(TASKS));
        let nodes = |task: usize| task * nodes_per_task..((task + 1) * nodes_per_task).min(n);
        let n_tasks = n.div_ceil(nodes_per_task);
        // Rows between which the columns of each task have blocks.
        let span = |task: usize| {
            nodes(task)
                .map(|node| Column::<D>::of(pattern, node).span())
                .fold((usize::MAX, 0), |all, of_node| (all.0.min(of_node.0), all.1.max(of_node.1)))
        };
        let spans: Vec<(usize, usize)> = each(n_tasks, span);
        let work = |task: usize| {
            let rows = nodes(task);
            let reaching =
                (0..n_tasks).filter(|&other| spans[other].0 < rows.end && spans[other].1 >= rows.start);
            let mut seen = none();
            let columns = reaching.flat_map(nodes).map(|node| (node, Column::<D>::of(pattern, node)));
            let stored = RowsOfTask::of(rows.clone(), columns, |row, column| see(&mut seen, row, column));
            (stored, seen)
        };
        let (tasks, seen) = each(n_tasks, work).into_iter().unzip();
        (Self { nodes_per_task, tasks }, seen)
    }

    fn of_node(&self, node: usize) -> &[(u32, u32)] {
        let RowsOfTask { start, block } = &self.tasks[node / self.nodes_per_task];
        let row = node % self.nodes_per_task;
        &block[start[row]..start[row + 1]]
    }

    /// Start, columns and sources of the rows of both triangles, columns ascending. Rows and columns are nodes in a new
    /// `order`, which names those of the caller; `number` is where each of these stands in it.
    pub(crate) fn in_order<const D: usize>(
        &self,
        pattern: Pattern<'_>,
        (order, number): (&[usize], &[u32]),
    ) -> (Vec<usize>, Vec<u32>, Vec<Source>) {
        let n = order.len();
        // Of a symmetric matrix the rows hold what stands left of the diagonal, and the column what stands right of it.
        let besides = |node: usize| match pattern.is_symmetric() {
            true => Column::<D>::of(pattern, node).len() - 1,
            false => 0,
        };
        let mut start = Vec::with_capacity(n + 1);
        start.push(0);
        for (row, &node) in order.iter().enumerate() {
            start.push(start[row] + self.of_node(node).len() + besides(node));
        }
        let mut column = vec![0_u32; start[n]];
        let mut source = vec![Source { column: 0, slot: 0 }; start[n]];
        let bounds: Vec<usize> = (0..=n.div_ceil(ROWS)).map(|task| start[(task * ROWS).min(n)]).collect();
        for_each_part(
            n > LARGE_LEVEL,
            &bounds,
            (&mut column[..], &mut source[..]),
            &|task, (column, source)| {
                let mut row = Vec::new();
                let mut place = 0;
                for &node in &order[task * ROWS..((task + 1) * ROWS).min(n)] {
                    row.clear();
                    let stored = self.of_node(node).iter();
                    row.extend(
                        stored.map(|&(column, slot)| (number[column as usize], Source { column, slot })),
                    );
                    if pattern.is_symmetric() {
                        let column = node as u32;
                        Column::<D>::of(pattern, node).for_each(|other, slot| {
                            if other != node {
                                row.push((number[other], Source { column, slot: slot | TRANSPOSED }));
                            }
                        });
                    }
                    row.sort_unstable_by_key(|it| it.0);
                    for &(at, from) in &row {
                        (column[place], source[place]) = (at, from);
                        place += 1;
                    }
                }
            },
        );
        (start, column, source)
    }
}

impl RowsOfTask {
    /// The blocks of some columns, which ascend, in these rows.
    fn of<'a, const D: usize>(
        rows: Range<usize>,
        columns: impl Iterator<Item = (usize, Column<'a, D>)>,
        mut see: impl FnMut(usize, usize),
    ) -> Self {
        let mut start = vec![0; rows.len() + 1];
        let mut found: Vec<(u32, u32, u32)> = Vec::new();
        for (node, column) in columns {
            column.within(&rows, |row, slot| {
                see(row, node);
                start[row - rows.start + 1] += 1;
                found.push(((row - rows.start) as u32, node as u32, slot));
            });
        }
        for row in 0..rows.len() {
            start[row + 1] += start[row];
        }
        let mut next = start.clone();
        let mut block = vec![(0, 0); found.len()];
        for (row, column, slot) in found {
            let place = &mut next[row as usize];
            block[*place] = (column, slot);
            *place += 1;
        }
        Self { start, block }
    }
}

fn each<R: Send>(n_tasks: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    match n_tasks {
        0 | 1 => (0..n_tasks).map(work).collect(),
        _ => (0..n_tasks).into_par_iter().map(&work).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Symmetry;
    use std::collections::{BTreeMap, BTreeSet};

    /// More nodes than two tasks have; each couples with its neighbours by number, and some with nodes far away.
    const N: usize = 2600;

    fn couplings() -> BTreeSet<(usize, usize)> {
        let far = (0..N).step_by(97).map(|node| (node, (node * 31 + 1200) % N));
        let near = (0..N).flat_map(|node| [0, 1, 40].map(|apart| (node, (node + apart).min(N - 1))));
        near.chain(far).flat_map(|(a, b)| [(a, b), (b, a)]).collect()
    }

    #[test]
    fn rows_hold_what_columns_store_in_any_order() {
        let couplings = couplings();
        // Every third node first, then the others backwards.
        let order: Vec<usize> = (0..N).step_by(3).chain((0..N).rev().filter(|node| node % 3 != 0)).collect();
        let mut number = vec![0; N];
        order.iter().enumerate().for_each(|(new, &old)| number[old] = new as u32);
        for symmetry in [Symmetry::Symmetric, Symmetry::Unsymmetric] {
            let is_stored = |row: usize, column: usize| symmetry == Symmetry::Unsymmetric || row >= column;
            let (mut column_start, mut row) = (vec![0], Vec::new());
            for column in 0..N {
                let rows = couplings.range((column, 0)..(column + 1, 0)).map(|it| it.1);
                row.extend(rows.filter(|&row| is_stored(row, column)));
                column_start.push(row.len());
            }
            let pattern = Pattern { column_start: &column_start, row: &row, symmetry, block: 1, blocks: N };
            let values: Vec<f64> = (0..row.len()).map(|k| k as f64).collect();
            let place: BTreeMap<(usize, usize), f64> = (0..N)
                .flat_map(|column| (column_start[column]..column_start[column + 1]).map(move |k| (column, k)))
                .map(|(column, k)| ((row[k], column), values[k]))
                .collect();

            let (stored, seen) = StoredRows::of::<1, _>(pattern, N, || 0, |count, _, _| *count += 1);
            assert_eq!(seen.iter().sum::<usize>(), row.len(), "each stored block is seen once");
            let (start, column, source) = stored.in_order::<1>(pattern, (&order, &number));
            assert_eq!(column.len(), couplings.len());
            for r in 0..N {
                let entries = start[r]..start[r + 1];
                assert!(column[entries.clone()].is_sorted_by(|a, b| a < b));
                for entry in entries {
                    let (i, j) = (order[r], order[column[entry] as usize]);
                    let expected = place.get(&(i, j)).or(place.get(&(j, i))).expect("they couple");
                    assert_eq!(source[entry].read::<1>(pattern, &values)[(0, 0)], *expected);
                }
            }
        }
    }
}
