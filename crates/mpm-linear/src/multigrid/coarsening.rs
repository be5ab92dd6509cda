//! Lattices of every second line, and interpolation from them.

use super::arithmetic::CHUNK;
use super::lines::LatticeLines;
use super::strips::Strips;
use rayon::prelude::*;

/// Nodes of one level, in the order of its strips.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Multi-index of each node, from 0 in each direction that is not periodic.
    pub index: Vec<[u32; 3]>,
    pub lines: LatticeLines,
    /// Lines that a coupling spans in each direction.
    pub reach: [u32; 3],
    pub strips: Strips,
}

/// `x_fine = P x_coarse`, componentwise: of each fine node the coarse ones, and of each coarse node the
/// fine ones.
#[derive(Clone, Debug)]
pub(crate) struct Interpolation {
    pub parents: Weights,
    pub children: Weights,
}

/// Rows of weights.
#[derive(Clone, Debug)]
pub(crate) struct Weights {
    start: Vec<usize>,
    entry: Vec<(u32, f64)>,
}

impl Weights {
    /// Of one node.
    #[inline]
    pub(crate) fn of(&self, node: usize) -> &[(u32, f64)] {
        &self.entry[self.start[node]..self.start[node + 1]]
    }

    fn transposed(&self, n: usize) -> Self {
        let mut start = vec![0; n + 1];
        for &(to, _) in &self.entry {
            start[to as usize + 1] += 1;
        }
        for node in 0..n {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut entry = vec![(0, 0.0); self.entry.len()];
        for node in 0..self.start.len() - 1 {
            for &(to, weight) in self.of(node) {
                let place = &mut next[to as usize];
                entry[*place] = (node as u32, weight);
                *place += 1;
            }
        }
        Self { start, entry }
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.start[..]) + size_of_val(&self.entry[..])
    }
}

impl Lattice {
    /// The finest lattice, and where each of its nodes stood in the caller's list.
    pub(crate) fn finest(
        index: &[[u32; 3]],
        lines: &[Vec<f64>; 3],
        periodic: [Option<u32>; 3],
        reach: [u32; 3],
    ) -> (Self, Vec<usize>) {
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for d in (0..3).filter(|&d| periodic[d].is_none()) {
            low[d] = index.iter().map(|index| index[d]).min().unwrap_or(0);
            high[d] = index.iter().map(|index| index[d]).max().unwrap_or(0);
        }
        let lines = LatticeLines::of(lines, periodic, low, high);
        let index: Vec<[u32; 3]> =
            index.iter().map(|index| std::array::from_fn(|d| index[d] - low[d])).collect();
        let (strips, order) = Strips::sort(&index, reach, periodic);
        let index = order.iter().map(|&node| index[node]).collect();
        (Self { index, lines, reach, strips }, order)
    }

    /// The next coarser lattice with the interpolation from it; none where no direction can be coarsened.
    pub(crate) fn coarser(&self) -> Option<(Self, Interpolation)> {
        let coarsening = self.lines.coarser()?;
        let mut reach = self.reach;
        for d in (0..3).filter(|&d| coarsening.directions[d]) {
            reach[d] = (reach[d] + 2) / 2;
        }

        // Numbers of the coarse nodes by their place in the box of coarse lines.
        let extent = coarsening.lines.extent();
        let place = |index: [u32; 3]| {
            index[0] as usize + extent[0] * (index[1] as usize + extent[1] * index[2] as usize)
        };
        let mut number = vec![u32::MAX; extent.iter().product()];
        for fine in &self.index {
            coarsening.for_each_parent(*fine, |parent, _| number[place(parent)] = 0);
        }
        let mut index = Vec::new();
        for z in 0..extent[2] as u32 {
            for y in 0..extent[1] as u32 {
                let row = (0..extent[0] as u32).map(|x| [x, y, z]);
                index.extend(row.filter(|&index| number[place(index)] == 0));
            }
        }
        let (strips, order) = Strips::sort(&index, reach, coarsening.lines.periods());
        let index: Vec<[u32; 3]> = order.iter().map(|&node| index[node]).collect();
        for (node, &index) in index.iter().enumerate() {
            number[place(index)] = node as u32;
        }

        let rows: Vec<Weights> = self
            .index
            .par_chunks(CHUNK)
            .map(|chunk| {
                let (mut start, mut entry) = (vec![0], Vec::with_capacity(4 * chunk.len()));
                for &fine in chunk {
                    coarsening
                        .for_each_parent(fine, |parent, weight| entry.push((number[place(parent)], weight)));
                    start.push(entry.len());
                }
                Weights { start, entry }
            })
            .collect();
        let mut parents = Weights { start: vec![0], entry: Vec::new() };
        for part in rows {
            let offset = parents.entry.len();
            parents.start.extend(part.start[1..].iter().map(|end| end + offset));
            parents.entry.extend(part.entry);
        }
        let children = parents.transposed(index.len());
        Some((Self { index, lines: coarsening.lines, reach, strips }, Interpolation { parents, children }))
    }
}
