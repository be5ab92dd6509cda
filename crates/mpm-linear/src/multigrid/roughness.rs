//! A correction of what alternates between the coefficients of splines.
//!
//! Values of splines at their control points are means of neighbouring coefficients, (1, 6, 1)/8 of degree 2 and (1, 4, 1)/6 of
//! degree 3. Of coefficients that alternate a half or a third is left along each direction. In space modes that alternate
//! along all directions therefore have little energy, as smooth ones have; but sweeps take what is rough for stiff, and
//! coarse lattices do not see it. This is why iterations grow with the degree (C. Hofreither and S. Takacs, "Robust multigrid
//! for isogeometric analysis based on stable splittings of spline spaces", SIAM J. Numer. Anal. 55, 2017, who smooth by the
//! mass matrix). With F, which turns values into coefficients line by line,
//!
//! ```text
//! z = ω S F Fᵀ S r      S = diag(A)^(−1/2)
//! ```
//!
//! is added to the correction from the coarse lattice. As both are symmetric and not negative, the cycle stays symmetric and positive
//! definite. S stands outside, so that functions which reach into the body a little do not spread: eigenvalues of `S F Fᵀ S A` were 16 to 24
//! (degree 2) and 30 to 66 (degree 3) on cubes, whatever part of the outermost cells was filled.

use super::arithmetic::{CHUNK, LARGE_LEVEL, Vector, for_each_node, for_each_part};
use super::blocks::BlockMatrix;
use super::coarsening::Lattice;
use super::single::{Short, Single};

/// ω: between 0.05 and 0.2 iterations are the same within a few per cent.
const SHARE: f64 = 0.1;

/// The correction pays where the degrees of all directions exceed 1 by this in sum: not in the plane for degree 2.
const LEAST_EXCESS: u32 = 3;

/// The correction of one lattice.
#[derive(Clone, Debug)]
pub(crate) struct Roughness<const D: usize> {
    directions: Vec<Lines>,
    /// `A_ii^(−1/2)`, 0 of what couples with nothing.
    scale: Vec<Vector<D>>,
}

/// The nodes by lines along a direction; a line ends where a node is missing.
#[derive(Clone, Debug)]
struct Lines {
    /// Nodes, line by line.
    order: Vec<u32>,
    /// Where each node stands in them.
    place: Vec<u32>,
    /// First places of lines, and the end.
    start: Vec<usize>,
    /// Those of them at which tasks begin.
    tasks: Vec<usize>,
    /// What a neighbour's coefficient adds to a value.
    side: f32,
    /// Inverse pivots of the elimination along a line.
    inverse: Vec<f32>,
}

impl<const D: usize> Roughness<D> {
    /// None where it does not pay.
    pub(crate) fn of(lattice: &Lattice, degree: [u32; 3]) -> Option<Self> {
        let directions: Vec<usize> = (0..3).filter(|&d| degree[d] > 1).collect();
        if directions.iter().map(|&d| degree[d] - 1).sum::<u32>() < LEAST_EXCESS {
            return None;
        }
        let directions = directions.into_iter().map(|d| Lines::along(d, degree[d], &lattice.index)).collect();
        Some(Self { directions, scale: vec![Vector::zeros(); lattice.index.len()] })
    }

    /// Takes the diagonal of the matrix times a power of two; bit i of a node's `held` is set where its component i couples
    /// with nothing.
    pub(crate) fn prepare(&mut self, matrix: &BlockMatrix<D>, held: &[u8], power: f64) {
        for_each_node(&mut self.scale, |row, scale| {
            let block = &matrix.block[matrix.diagonal[row]];
            *scale = Vector::from_fn(|i, _| {
                let is_free = held[row] & (1 << i) == 0 && block[(i, i)] != 0.0;
                if is_free { (block[(i, i)] * power).abs().sqrt().recip() } else { 0.0 }
            });
        });
    }

    /// Adds `z` of the residual to the solution of a level.
    pub(crate) fn correct<const L: usize>(&self, level: &mut Single<D, L>) {
        let Single { x, r, rough: [z, lines], .. } = level;
        // Room is made when it is first needed.
        lines.resize(r.len(), [0.0; L]);
        z.clone_from(r);
        self.scale(z, 1.0);
        for direction in self.directions.iter().chain(self.directions.iter().rev()) {
            direction.coefficients(z, lines);
        }
        self.scale(z, SHARE);
        for_each_node(x, |node, x| {
            for (x, z) in x.iter_mut().zip(&z[node]) {
                *x += z;
            }
        });
    }

    /// Multiplies each component by its scale and by `share`.
    fn scale<const L: usize>(&self, z: &mut [Short<L>], share: f64) {
        for_each_node(z, |node, z| {
            for (z, scale) in z.iter_mut().zip(&self.scale[node]) {
                *z *= (scale * share) as f32;
            }
        });
    }

    pub(crate) fn bytes(&self) -> usize {
        let of_lines =
            |it: &Lines| size_of_val(&it.order[..]) + size_of_val(&it.place[..]) + size_of_val(&it.start[..]);
        // With the two vectors in single precision that it works on.
        2 * size_of_val(&self.scale[..]) + self.directions.iter().map(of_lines).sum::<usize>()
    }
}

impl Lines {
    fn along(direction: usize, degree: u32, index: &[[u32; 3]]) -> Self {
        let (across, next) = ((direction + 1) % 3, (direction + 2) % 3);
        let key = |node: u32| {
            let index = index[node as usize];
            (index[next], index[across], index[direction])
        };
        let mut order: Vec<u32> = (0..index.len() as u32).collect();
        order.sort_by_cached_key(|&node| key(node));
        let mut place = vec![0; order.len()];
        let mut start = Vec::new();
        for (at, &node) in order.iter().enumerate() {
            place[node as usize] = at as u32;
            let (z, y, x) = key(node);
            if at == 0 || key(order[at - 1]) != (z, y, x.wrapping_sub(1)) {
                start.push(at);
            }
        }
        start.push(order.len());
        let mut tasks = vec![0];
        for &at in &start {
            if at >= tasks[tasks.len() - 1] + CHUNK {
                tasks.push(at);
            }
        }
        if tasks[tasks.len() - 1] < order.len() {
            tasks.push(order.len());
        }
        let side: f32 = if degree == 2 { 1.0 / 8.0 } else { 1.0 / 6.0 };
        let longest = start.windows(2).map(|line| line[1] - line[0]).max().unwrap_or(0);
        let centre = 1.0 - 2.0 * side;
        let inverse =
            std::iter::successors(Some(1.0 / centre), |before| Some(1.0 / (centre - side * side * before)));
        Self { order, place, start, tasks, side, inverse: inverse.take(longest).collect() }
    }

    /// Turns values at the nodes into coefficients, line by line; `lines` is room to work in.
    fn coefficients<const L: usize>(&self, values: &mut [Short<L>], lines: &mut [Short<L>]) {
        let nodes = &*values;
        for_each_node(lines, |at, it| *it = nodes[self.order[at] as usize]);
        for_each_part(self.order.len() > LARGE_LEVEL, &self.tasks, &mut *lines, &|task, part| {
            let first = self.tasks[task];
            let (lines, end) = (self.start.partition_point(|&start| start < first), first + part.len());
            for line in self.start[lines..].windows(2).take_while(|line| line[1] <= end) {
                self.eliminate(&mut part[line[0] - first..line[1] - first]);
            }
        });
        let lines = &*lines;
        for_each_node(values, |node, it| *it = lines[self.place[node] as usize]);
    }

    /// Solves the tridiagonal system of a line.
    fn eliminate<const L: usize>(&self, line: &mut [Short<L>]) {
        for i in 1..line.len() {
            let (before, factor) = (line[i - 1], self.side * self.inverse[i - 1]);
            for (value, before) in line[i].iter_mut().zip(before) {
                *value -= before * factor;
            }
        }
        let mut after = [0.0; L];
        for (value, inverse) in line.iter_mut().zip(&self.inverse).rev() {
            for (value, after) in value.iter_mut().zip(after) {
                *value = (*value - after * self.side) * inverse;
            }
            after = *value;
        }
    }
}
