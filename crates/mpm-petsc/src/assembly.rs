//! The matrix of all ranks from what each of them has summed: where its blocks go, and how they get there.
//!
//! Rows belong to the owners of their nodes. What a rank has of other rows it sends to their owners, who add it in the order of the
//! ranks. A block is told by one number, the place of its first entry.

use crate::blocks::Blocks;
use crate::error::PetscError;
use crate::ffi::PetscInt;
use crate::handles::{Arrays, Mat};
use crate::numbering::Numbering;
use crate::session::Session;
use mpm_cluster::Wire;
use mpm_linear::{Matrix, Pattern};
use std::rc::Rc;

/// Set in places that are among the columns of other ranks.
const OF_OTHERS: u32 = 1 << 31;

/// Where a block goes.
#[derive(Clone, Copy, Debug)]
enum Goes {
    /// Into an own row, at this place.
    Here { row: u32, place: u32 },
    /// To a rank.
    To(u32),
}

/// Where the blocks of a pattern go, in its order; of a symmetric one each is followed by its transpose, but for the diagonal.
pub(crate) struct Assembly {
    block: usize,
    goes: Vec<Goes>,
    /// Rows and places of the blocks that come from other ranks.
    comes: Vec<(usize, Vec<(u32, u32)>)>,
    /// Ranks that blocks are sent to, and how many.
    sends: Vec<(usize, usize)>,
    /// Distances of the equations of a node in the entries of own columns, and in those of others.
    stride: [Vec<u32>; 2],
}

/// Row and column of every block of a pattern, by nodes, in its order.
fn for_each_block(pattern: Pattern<'_>, mut see: impl FnMut(usize, usize)) {
    let block = pattern.block;
    for column in 0..pattern.blocks {
        let entries = pattern.column_start[column * block]..pattern.column_start[column * block + 1];
        pattern.row[entries].iter().step_by(block).for_each(|row| see(row / block, column));
    }
}

/// The same with the transposes that a symmetric pattern does not store.
pub(crate) fn for_each_pair(pattern: Pattern<'_>, mut see: impl FnMut(usize, usize)) {
    for_each_block(pattern, |row, column| {
        see(row, column);
        if pattern.is_symmetric() && row != column {
            see(column, row);
        }
    });
}

impl Assembly {
    /// Of blocks of so many equations, with a matrix of zeros: rows and columns by the list that is numbered, whose nodes have these
    /// owners, each pair once.
    pub(crate) fn of(
        (session, wire): (&Rc<Session>, &dyn Wire),
        block: usize,
        (numbering, owners): (&Numbering, &[u32]),
        for_each_pair: impl Fn(&mut dyn FnMut(usize, usize)),
    ) -> Result<(Self, Mat), PetscError> {
        let (n, me) = (numbering.own.len(), wire.rank());
        let first = numbering.first as u64;
        let number = |node: usize| numbering.number[node];
        let mut out: Vec<(usize, Vec<u8>)> = (0..wire.size()).map(|rank| (rank, Vec::new())).collect();
        for_each_pair(&mut |row, column| {
            let to = owners[row] as usize;
            if to != me {
                [row, column].into_iter().for_each(|it| out[to].1.extend((number(it) as u32).to_le_bytes()));
            }
        });
        out.retain(|it| !it.1.is_empty());
        let sends = out.iter().map(|(rank, bytes)| (*rank, bytes.len() / 8)).collect();
        let come: Vec<(usize, Vec<(u32, u32)>)> =
            wire.exchange(&out).into_iter().map(|(rank, bytes)| (rank, read_pairs(&bytes))).collect();
        drop(out);
        let own_row = |number: u32| (u64::from(number) - first) as u32;
        let blocks = Blocks::of(n, &|see| {
            for_each_pair(&mut |row, column| {
                if owners[row] as usize == me {
                    see(own_row(number(row) as u32), number(column) as u32);
                }
            });
            // Whoever reads the matrix finds a diagonal in every row.
            (0..n as u32).for_each(|row| see(row, row + first as u32));
            come.iter().flat_map(|it| &it.1).for_each(|&(row, column)| see(own_row(row), column));
        });
        // All ranks are told, so that none goes on alone.
        let mut entries = vec![0.0; wire.size()];
        wire.gather(&[(blocks.column.len() * block * block) as f64], &mut entries);
        if let Some(most) = entries.into_iter().find(|&most| most > PetscInt::MAX as f64) {
            let reason =
                format!("{most:.0} entries of a rank are too many for 32 bits: more ranks have less each");
            return Err(PetscError { call: "MatCreate", code: 0, reason });
        }
        let range = numbering.first as u32..(numbering.first + n) as u32;
        let (arrays, stride) = arrays(&blocks, &range, block);
        let place = |row: u32, column: u32| {
            let of_row = blocks.row(row as usize);
            let of = |it: u32| of_row.partition_point(|&other| other < it);
            let (low, high) = (of(range.start), of(range.end));
            let at = of(column);
            let equation = row as usize * block;
            match at {
                _ if at < low => (arrays[1].start[equation] as u32 + (at * block) as u32) | OF_OTHERS,
                _ if at >= high => {
                    (arrays[1].start[equation] as u32 + ((at - high + low) * block) as u32) | OF_OTHERS
                }
                _ => arrays[0].start[equation] as u32 + ((at - low) * block) as u32,
            }
        };
        let mut goes = Vec::new();
        for_each_pair(&mut |row, column| {
            goes.push(match owners[row] as usize {
                to if to != me => Goes::To(to as u32),
                _ => {
                    let row = own_row(number(row) as u32);
                    Goes::Here { row, place: place(row, number(column) as u32) }
                }
            });
        });
        let placed = |&(row, column): &(u32, u32)| (own_row(row), place(own_row(row), column));
        let comes = come.iter().map(|(rank, pairs)| (*rank, pairs.iter().map(placed).collect())).collect();
        let matrix = Mat::of_arrays(session, (n * block, block), arrays)?;
        Ok((Self { block, goes, comes, sends, stride }, matrix))
    }

    /// Writes the sum of what all ranks have into the matrix.
    pub(crate) fn take(&self, wire: &dyn Wire, from: Matrix<'_>, to: &Mat) -> Result<(), PetscError> {
        match self.block {
            1 => self.take_blocks(wire, to, |put| for_each_value::<1>(from, put)),
            2 => self.take_blocks(wire, to, |put| for_each_value::<2>(from, put)),
            3 => self.take_blocks(wire, to, |put| for_each_value::<3>(from, put)),
            _ => self.take_blocks(wire, to, |put| for_each_value::<4>(from, put)),
        }
    }

    /// The same from the blocks of this rank in the order of the pairs, by equation and component.
    pub(crate) fn take_blocks<const D: usize>(
        &self,
        wire: &dyn Wire,
        to: &Mat,
        for_each: impl FnOnce(&mut dyn FnMut(&[[f64; D]; D])),
    ) -> Result<(), PetscError> {
        let of_block = 8 * D * D;
        let mut out: Vec<(usize, Vec<u8>)> =
            self.sends.iter().map(|&(rank, n)| (rank, Vec::with_capacity(n * of_block))).collect();
        let mut index = vec![usize::MAX; wire.size()];
        self.sends.iter().enumerate().for_each(|(k, it)| index[it.0] = k);
        to.with_values(|own, others| {
            own.fill(0.0);
            others.fill(0.0);
            let mut goes = self.goes.iter();
            for_each(&mut |values| match goes.next().expect("the blocks are those analysed") {
                Goes::To(rank) => {
                    let numbers = values.as_flattened().iter().flat_map(|it| it.to_le_bytes());
                    out[index[*rank as usize]].1.extend(numbers);
                }
                &Goes::Here { row, place } => {
                    self.put([&mut *own, &mut *others], (row, place), |to, p, q| *to = values[p][q]);
                }
            });
            let come = wire.exchange(&out);
            for ((_, bytes), (_, places)) in come.iter().zip(&self.comes) {
                let numbers = bytes.as_chunks::<8>().0;
                for (&to, values) in places.iter().zip(numbers.chunks_exact(D * D)) {
                    let value = |p: usize, q: usize| f64::from_le_bytes(values[p * D + q]);
                    self.put([&mut *own, &mut *others], to, |to, p, q| *to += value(p, q));
                }
            }
        })
    }

    /// Sees all entries of a block, with its equation and component.
    #[inline(always)]
    fn put(
        &self,
        [own, others]: [&mut [f64]; 2],
        (row, place): (u32, u32),
        mut see: impl FnMut(&mut f64, usize, usize),
    ) {
        let (to, stride) =
            if place & OF_OTHERS == 0 { (own, &self.stride[0]) } else { (others, &self.stride[1]) };
        let (place, stride) = ((place & !OF_OTHERS) as usize, stride[row as usize] as usize);
        for p in 0..self.block {
            let begin = place + p * stride;
            to[begin..begin + self.block].iter_mut().enumerate().for_each(|(q, to)| see(to, p, q));
        }
    }
}

/// The values of every block in the order of [`for_each_pair`], by equation and component.
fn for_each_value<const D: usize>(from: Matrix<'_>, see: &mut dyn FnMut(&[[f64; D]; D])) {
    let Matrix { pattern, values } = from;
    let is_symmetric = pattern.is_symmetric();
    for column in 0..pattern.blocks {
        let begin: [usize; D] = std::array::from_fn(|q| {
            // Columns of a symmetric matrix begin at the diagonal.
            let lacking = if is_symmetric { q } else { 0 };
            pattern.column_start[column * D + q].wrapping_sub(lacking)
        });
        let blocks = (pattern.column_start[column * D + 1] - pattern.column_start[column * D]) / D;
        for k in 0..blocks {
            let is_diagonal = is_symmetric && k == 0;
            let value = |p: usize, q: usize| values[begin[q].wrapping_add(k * D + p)];
            let of = |p: usize, q: usize| if is_diagonal && p < q { value(q, p) } else { value(p, q) };
            see(&std::array::from_fn(|p| std::array::from_fn(|q| of(p, q))));
            if is_symmetric && !is_diagonal {
                see(&std::array::from_fn(|p| std::array::from_fn(|q| of(q, p))));
            }
        }
    }
}

/// Equations of blocks, those of columns in the range apart from others, and the distances of equations of a node among their entries.
fn arrays(blocks: &Blocks, range: &std::ops::Range<u32>, block: usize) -> ([Arrays; 2], [Vec<u32>; 2]) {
    let n = blocks.start.len() - 1;
    let (mut arrays, mut strides) = ([Arrays::default(), Arrays::default()], [Vec::new(), Vec::new()]);
    for (is_own, (to, stride)) in [true, false].into_iter().zip(arrays.iter_mut().zip(&mut strides)) {
        // Own columns are counted from the first of this rank.
        let less = if is_own { range.start } else { 0 };
        to.start = Vec::with_capacity(n * block + 1);
        to.start.push(0);
        for row in 0..n {
            let columns = || blocks.row(row).iter().filter(|it| range.contains(*it) == is_own);
            for _ in 0..block {
                for column in columns() {
                    let equation = (column - less) as usize * block;
                    to.column.extend((equation..equation + block).map(|it| it as PetscInt));
                }
                to.start.push(to.column.len() as PetscInt);
            }
            stride.push((columns().count() * block) as u32);
        }
        to.value = vec![0.0; to.column.len()];
    }
    (arrays, strides)
}

fn read_pairs(bytes: &[u8]) -> Vec<(u32, u32)> {
    let numbers: Vec<u32> = bytes.as_chunks().0.iter().map(|it| u32::from_le_bytes(*it)).collect();
    numbers.as_chunks().0.iter().map(|&[row, column]| (row, column)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_columns_stand_apart() {
        let pairs = [(1, 5), (0, 2), (1, 3), (1, 5), (0, 1)];
        let blocks = Blocks::of(3, &|see| pairs.iter().for_each(|&(row, column)| see(row, column)));
        let (arrays, stride) = arrays(&blocks, &(1..4), 2);
        assert_eq!(arrays[0].start, [0, 4, 8, 10, 12, 12, 12]);
        assert_eq!(arrays[0].column, [0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 4, 5]);
        assert_eq!(
            (&arrays[1].start[..], &arrays[1].column[..]),
            (&[0, 0, 0, 2, 4, 4, 4][..], &[10, 11, 10, 11][..])
        );
        assert_eq!(stride, [vec![4, 2, 0], vec![0, 2, 0]]);
    }

    #[test]
    fn values_of_a_lower_triangle_are_whole_blocks() {
        // Two nodes of two equations.
        let (start, row) = ([0, 4, 7, 9, 10], [0, 1, 2, 3, 1, 2, 3, 2, 3, 3]);
        let pattern = Pattern::symmetric(&start, &row, 2);
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
        let mut found = Vec::new();
        for_each_value::<2>(Matrix { pattern, values: &values }, &mut |block| found.push(*block));
        let expected = [
            [[1.0, 2.0], [2.0, 5.0]],
            [[3.0, 6.0], [4.0, 7.0]],
            [[3.0, 4.0], [6.0, 7.0]],
            [[8.0, 9.0], [9.0, 10.0]],
        ];
        assert_eq!(found, expected);
    }
}
