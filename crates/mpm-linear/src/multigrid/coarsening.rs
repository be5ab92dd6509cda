//! Lattices of every second line, and interpolation from them.

use super::arithmetic::CHUNK;
use super::strips::Strips;
use rayon::prelude::*;

/// Directions are coarsened where their lines stand less than this times as far apart as the closest.
const SIMILAR: f64 = 1.5;

/// Nodes of one level, in the order of its strips.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Multi-index of each node, from 0 in each direction that is not periodic.
    pub index: Vec<[u32; 3]>,
    /// Coordinates of the lines.
    pub lines: [Vec<f64>; 3],
    pub periodic: [Option<u32>; 3],
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
        let mut low = [0; 3];
        let mut lines = lines.clone();
        for d in (0..3).filter(|&d| periodic[d].is_none()) {
            low[d] = index.iter().map(|index| index[d]).min().unwrap_or(0);
            let high = index.iter().map(|index| index[d]).max().unwrap_or(0);
            lines[d] = lines[d][low[d] as usize..=high as usize].to_vec();
        }
        let index: Vec<[u32; 3]> =
            index.iter().map(|index| std::array::from_fn(|d| index[d] - low[d])).collect();
        let (strips, order) = Strips::sort(&index, reach, periodic);
        let index = order.iter().map(|&node| index[node]).collect();
        (Self { index, lines, periodic, reach, strips }, order)
    }

    /// The next coarser lattice with the interpolation from it; none where no direction can be coarsened.
    pub(crate) fn coarser(&self) -> Option<(Self, Interpolation)> {
        let directions = self.coarsened();
        if directions == [false; 3] {
            return None;
        }
        let steps: [Vec<Step>; 3] =
            std::array::from_fn(|d| steps(&self.lines[d], self.periodic[d], directions[d]));
        let mut coarse = self.lines.clone();
        let (mut periodic, mut reach) = (self.periodic, self.reach);
        for d in (0..3).filter(|&d| directions[d]) {
            coarse[d] = coarse_lines(&self.lines[d], periodic[d]);
            periodic[d] = periodic[d].map(|n| n / 2);
            reach[d] = (reach[d] + 2) / 2;
        }

        // Numbers of the coarse nodes by their place in the box of coarse lines.
        let extent: [usize; 3] = std::array::from_fn(|d| coarse[d].len());
        let place = |index: [u32; 3]| {
            index[0] as usize + extent[0] * (index[1] as usize + extent[1] * index[2] as usize)
        };
        let mut number = vec![u32::MAX; extent.iter().product()];
        for fine in &self.index {
            for_each_parent(&steps, *fine, |parent, _| number[place(parent)] = 0);
        }
        let mut index = Vec::new();
        for z in 0..extent[2] as u32 {
            for y in 0..extent[1] as u32 {
                let row = (0..extent[0] as u32).map(|x| [x, y, z]);
                index.extend(row.filter(|&index| number[place(index)] == 0));
            }
        }
        let (strips, order) = Strips::sort(&index, reach, periodic);
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
                    for_each_parent(&steps, fine, |parent, weight| entry.push((number[place(parent)], weight)));
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
        Some((Self { index, lines: coarse, periodic, reach, strips }, Interpolation { parents, children }))
    }

    /// Which directions lose every second line: those whose lines stand closest, if they can.
    fn coarsened(&self) -> [bool; 3] {
        let spacing: [f64; 3] = std::array::from_fn(|d| {
            let lines = &self.lines[d];
            let can = match self.periodic[d] {
                Some(n) => n % 2 == 0 && n >= 8,
                None => lines.len() > 2,
            };
            if can {
                (lines[lines.len() - 1] - lines[0]).abs() / (lines.len() - 1) as f64
            } else {
                f64::INFINITY
            }
        });
        let least = spacing.iter().copied().fold(f64::INFINITY, f64::min);
        spacing.map(|spacing| spacing.is_finite() && spacing <= SIMILAR * least)
    }
}

/// Where the value on a fine line comes from: one coarse line, or two.
#[derive(Clone, Copy, Debug)]
struct Step {
    coarse: [u32; 2],
    weight: [f64; 2],
}

fn steps(lines: &[f64], periodic: Option<u32>, coarsened: bool) -> Vec<Step> {
    let n = periodic.map_or(lines.len(), |n| n as usize);
    (0..n)
        .map(|i| {
            let (low, high) = (i as u32 / 2, i as u32 / 2 + 1);
            if !coarsened {
                return Step { coarse: [i as u32; 2], weight: [1.0, 0.0] };
            }
            if i % 2 == 0 {
                return Step { coarse: [low; 2], weight: [1.0, 0.0] };
            }
            match periodic {
                // Lines that close on themselves are equally spaced.
                Some(n) => Step { coarse: [low, high % (n / 2)], weight: [0.5; 2] },
                None if i + 1 == n => Step { coarse: [low, high], weight: [0.5; 2] },
                None => {
                    let upper = (lines[i] - lines[i - 1]) / (lines[i + 1] - lines[i - 1]);
                    Step { coarse: [low, high], weight: [1.0 - upper, upper] }
                }
            }
        })
        .collect()
}

/// Every second line, and one beyond the last where that is not one of them.
fn coarse_lines(lines: &[f64], periodic: Option<u32>) -> Vec<f64> {
    let mut coarse: Vec<f64> = lines.iter().copied().step_by(2).collect();
    match periodic {
        Some(n) => coarse.truncate(n as usize / 2),
        None if lines.len().is_multiple_of(2) => {
            let n = lines.len();
            coarse.push(lines[n - 1] + (lines[n - 1] - lines[n - 2]));
        }
        None => {}
    }
    coarse
}

/// Calls `see` with the coarse nodes that a fine node's value comes from, and their weights.
fn for_each_parent(steps: &[Vec<Step>; 3], fine: [u32; 3], mut see: impl FnMut([u32; 3], f64)) {
    let [x, y, z] = std::array::from_fn(|d| steps[d][fine[d] as usize]);
    for (&kz, &wz) in z.coarse.iter().zip(&z.weight).filter(|it| *it.1 != 0.0) {
        for (&ky, &wy) in y.coarse.iter().zip(&y.weight).filter(|it| *it.1 != 0.0) {
            for (&kx, &wx) in x.coarse.iter().zip(&x.weight).filter(|it| *it.1 != 0.0) {
                see([kx, ky, kz], wx * wy * wz);
            }
        }
    }
}
