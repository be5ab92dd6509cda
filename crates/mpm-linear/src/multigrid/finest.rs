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
