//! `A_c = Pᵀ A P`.

use super::arithmetic::{Block, LARGE_LEVEL, for_each_part};
use super::blocks::BlockMatrix;
use super::coarsening::Interpolation;
use rayon::prelude::*;

/// Coarse rows per task, at least.
const ROWS: usize = 128;

/// Tasks at most: each has a table of all coarse nodes.
const TASKS: usize = 64;

/// Structure of the coarse matrix, with zeros for values.
pub(crate) fn structure<const D: usize>(
    fine: &BlockMatrix<D>,
    interpolation: &Interpolation,
    n_coarse: usize,
) -> BlockMatrix<D> {
    let rows: Vec<(Vec<usize>, Vec<u32>)> = (0..n_coarse.div_ceil(ROWS))
        .into_par_iter()
        .map_init(
            || vec![u32::MAX; n_coarse],
            |found_by, task| {
                let (mut end, mut column): (Vec<usize>, Vec<u32>) = (Vec::new(), Vec::new());
                for row in task * ROWS..((task + 1) * ROWS).min(n_coarse) {
                    let begin = column.len();
                    for &(child, _) in interpolation.children.of(row) {
                        for &neighbour in
                            &fine.column[fine.start[child as usize]..fine.start[child as usize + 1]]
                        {
                            for &(parent, _) in interpolation.parents.of(neighbour as usize) {
                                let found = &mut found_by[parent as usize];
                                if std::mem::replace(found, row as u32) != row as u32 {
                                    column.push(parent);
                                }
                            }
                        }
                    }
                    column[begin..].sort_unstable();
                    end.push(column.len());
                }
                (end, column)
            },
        )
        .collect();
    let (mut start, mut column) = (vec![0], Vec::new());
    for (end, part) in rows {
        let offset = column.len();
        start.extend(end.into_iter().map(|end| end + offset));
        column.extend(part);
    }
    BlockMatrix::zeros(start, column)
}

/// Values of the coarse matrix; bit i of a fine node's `held` is set where its component i couples with
/// nothing, and is left out.
pub(crate) fn fill<const D: usize>(
    fine: &BlockMatrix<D>,
    held: &[u8],
    interpolation: &Interpolation,
    coarse: &mut BlockMatrix<D>,
) {
    let n = coarse.n_rows();
    let rows = ROWS.max(n.div_ceil(TASKS));
    let tasks = n.div_ceil(rows);
    let BlockMatrix { start, column, block, .. } = coarse;
    let bounds: Vec<usize> = (0..=tasks).map(|task| start[(task * rows).min(n)]).collect();
    for_each_part(fine.n_rows() > LARGE_LEVEL, &bounds, &mut block[..], &|task, block: &mut [Block<D>]| {
        block.fill(Block::zeros());
        let mut place_of = vec![0_u32; n];
        for row in task * rows..((task + 1) * rows).min(n) {
            let entries = start[row]..start[row + 1];
            for entry in entries {
                place_of[column[entry] as usize] = (entry - bounds[task]) as u32;
            }
            for &(child, of_child) in interpolation.children.of(row) {
                let child = child as usize;
                for entry in fine.start[child]..fine.start[child + 1] {
                    let neighbour = fine.column[entry] as usize;
                    let mut value = fine.block[entry] * of_child;
                    if entry == fine.diagonal[child] && held.get(child).is_some_and(|&held| held != 0) {
                        for i in (0..D).filter(|i| held[child] & (1 << i) != 0) {
                            value[(i, i)] = 0.0;
                        }
                    }
                    for &(parent, weight) in interpolation.parents.of(neighbour) {
                        block[place_of[parent as usize] as usize] += value * weight;
                    }
                }
            }
        }
    });
}
