//! Levels of lattices and matrices, and the cycle through them.

use super::arithmetic::{Block, Vector, add, for_each_part};
use super::blocks::BlockMatrix;
use super::coarsening::{Interpolation, Lattice};
use super::conjugate_gradients::{self, Iterates, Stop};
use super::galerkin;
use super::outcome::{Converged, Failure};
use crate::matrix::{Matrix, Pattern};
use crate::solver::LatticePlaces;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

/// Nodes of the coarsest level, whose matrix is factorised, at most (where lattices can still be coarsened).
const COARSEST: usize = 150;

/// Rows of the finest matrix per task.
const ROWS: usize = 1024;

/// A hierarchy for one pattern, and the values last prepared.
#[derive(Clone, Debug)]
pub struct Multigrid<const D: usize> {
    /// From the finest to the coarsest.
    levels: Vec<Level<D>>,
    /// Where each node of the finest level stands in the caller's numbering.
    order: Vec<usize>,
    /// Where the values of each block of the finest matrix stand in the caller's.
    source: Vec<Source>,
    /// Bit i is set where component i of a node of the finest level couples with nothing.
    held: Vec<u8>,
    coarsest: Option<Cholesky<f64, Dyn>>,
    /// Of every level.
    scratch: Vec<Scratch<D>>,
    /// Made when first needed.
    iterates: Option<Iterates<D>>,
}

#[derive(Clone, Debug)]
struct Level<const D: usize> {
    lattice: Lattice,
    matrix: BlockMatrix<D>,
    /// From the next coarser level; none on the coarsest.
    interpolation: Option<Interpolation>,
}

/// A block of the caller's lower triangle: below the diagonal block of a column's node.
#[derive(Clone, Copy, Debug)]
struct Source {
    /// Node of the column.
    column: u32,
    /// 0 for the diagonal block, then the blocks below it; the highest bit is set where it is transposed.
    slot: u32,
}

const TRANSPOSED: u32 = 1 << 31;

/// Size of a hierarchy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Size {
    /// Nodes of each level, the finest first.
    pub nodes: Vec<usize>,
    /// Blocks of each level's matrix, both triangles.
    pub blocks: Vec<usize>,
    /// Bytes held while solving.
    pub bytes: usize,
}

/// Vectors of one level while a cycle runs.
#[derive(Clone, Debug)]
struct Scratch<const D: usize> {
    b: Vec<Vector<D>>,
    x: Vec<Vector<D>>,
    r: Vec<Vector<D>>,
}

impl<const D: usize> Scratch<D> {
    fn zeros(n: usize) -> Self {
        let zeros = vec![Vector::zeros(); n];
        Self { b: zeros.clone(), x: zeros.clone(), r: zeros }
    }
}

impl<const D: usize> Multigrid<D> {
    /// Coarsens the lattice and finds the structure of all matrices. None where the pattern is not that of
    /// a symmetric matrix with `D` equations for each node and no others: conjugate gradients do not solve it.
    ///
    /// # Panics
    /// If there are not as many places as nodes, or a node stands beyond the lines.
    pub fn analyse(pattern: Pattern<'_>, nodes: LatticePlaces<'_>) -> Option<Self> {
        if !pattern.is_symmetric() || !pattern.has_blocks_only() || pattern.block != D {
            return None;
        }
        let n = nodes.index.len();
        assert_eq!(pattern.blocks, n, "a place on the lattice for each node");
        let neighbours = |node: usize| Neighbours::<D>::of(pattern, node);
        let reach = reach(n, &nodes, |node, see| neighbours(node).for_each(see));
        let (lattice, order) = Lattice::finest(nodes.index, nodes.lines, nodes.periods, reach);
        let mut number = vec![0_u32; n];
        for (new, &old) in order.iter().enumerate() {
            number[old] = new as u32;
        }

        // Both triangles by rows, in the order of the strips.
        let mut start = vec![0; n + 1];
        for node in 0..n {
            start[number[node] as usize + 1] += 1;
            neighbours(node).for_each(|other| {
                start[number[node] as usize + 1] += 1;
                start[number[other] as usize + 1] += 1;
            });
        }
        for row in 0..n {
            start[row + 1] += start[row];
        }
        let mut next = start.clone();
        let mut entry = vec![(0_u32, Source { column: 0, slot: 0 }); start[n]];
        let mut put = |row: u32, column: u32, source: Source| {
            let place = &mut next[row as usize];
            entry[*place] = (column, source);
            *place += 1;
        };
        for node in 0..n {
            let (here, column) = (number[node], node as u32);
            put(here, here, Source { column, slot: 0 });
            let mut slot = 0;
            neighbours(node).for_each(|other| {
                slot += 1;
                put(number[other], here, Source { column, slot });
                put(here, number[other], Source { column, slot: slot | TRANSPOSED });
            });
        }
        for_each_part(&row_bounds(&start), &mut entry, &|task, entries| {
            let rows = task * ROWS..((task + 1) * ROWS).min(n);
            let offset = start[rows.start];
            for row in rows {
                entries[start[row] - offset..start[row + 1] - offset].sort_unstable_by_key(|it| it.0);
            }
        });
        let (column, source) = entry.into_iter().unzip();

        let mut levels =
            vec![Level { lattice, matrix: BlockMatrix::zeros(start, column), interpolation: None }];
        loop {
            let finest = &levels[levels.len() - 1];
            if finest.lattice.index.len() <= COARSEST {
                break;
            }
            let Some((lattice, interpolation)) = finest.lattice.coarser() else { break };
            let matrix = galerkin::structure(&finest.matrix, &interpolation, lattice.index.len());
            let last = levels.len() - 1;
            levels[last].interpolation = Some(interpolation);
            levels.push(Level { lattice, matrix, interpolation: None });
        }
        let scratch = levels.iter().map(|level| Scratch::zeros(level.matrix.n_rows())).collect();
        Some(Self { levels, order, source, held: vec![0; n], coarsest: None, scratch, iterates: None })
    }

    /// Takes the values of the matrix, whose pattern is the one analysed, and forms the coarse matrices.
    /// Components that couple with nothing are left out of these.
    ///
    /// # Errors
    /// [`Failure::NotFinite`], or [`Failure::Indefinite`] where a diagonal block or the coarsest matrix is not
    /// positive definite (where they all are, the matrix may still not be).
    ///
    /// # Panics
    /// If there is not one value per entry of the pattern.
    pub fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        assert_eq!(matrix.values.len(), matrix.pattern.n_entries(), "one value per entry of the pattern");
        self.coarsest = None;
        self.take(matrix)?;
        for level in 0..self.levels.len() {
            if let Err(row) = self.levels[level].matrix.invert_diagonal() {
                return Err(Failure::Indefinite { node: self.on_finest(level, row) });
            }
            let (fine, coarse) = self.levels.split_at_mut(level + 1);
            let Some(interpolation) = &fine[level].interpolation else { break };
            let held: &[u8] = if level == 0 { &self.held } else { &[] };
            galerkin::fill(&fine[level].matrix, held, interpolation, &mut coarse[0].matrix);
        }
        let last = self.levels.len() - 1;
        match dense(&self.levels[last].matrix).cholesky() {
            Some(factor) => self.coarsest = Some(factor),
            None => return Err(Failure::Indefinite { node: self.on_finest(last, 0) }),
        }
        Ok(())
    }

    /// Replaces the right-hand side b by x with `|b − A x| ≤ tolerance · |b|`.
    ///
    /// # Errors
    /// [`Failure`]; `x` holds the best approximation then, or is unchanged where nothing was found.
    ///
    /// # Panics
    /// If no matrix was prepared or `x` does not fit it.
    pub fn solve(&mut self, x: &mut [f64], tolerance: f64, iterations: u32) -> Result<Converged, Failure> {
        assert_eq!(x.len(), self.order.len() * D, "{D} numbers for each node");
        let mut iterates = self.iterates.take().unwrap_or_else(|| Iterates::zeros(self.order.len()));
        for (b, &node) in iterates.b.iter_mut().zip(&self.order) {
            b.copy_from_slice(&x[node * D..(node + 1) * D]);
        }
        let infinite = iterates.b.iter().position(|b| b.iter().any(|b| !b.is_finite()));
        let stop = infinite.is_none().then(|| self.iterate(&mut iterates, tolerance, iterations));
        if stop.is_some() {
            for (&node, found) in self.order.iter().zip(&iterates.x) {
                x[node * D..(node + 1) * D].copy_from_slice(found.as_slice());
            }
        }
        self.iterates = Some(iterates);
        let Some(stop) = stop else {
            return Err(Failure::NotFinite { node: self.order[infinite.unwrap_or(0)] });
        };
        match stop {
            Stop::Solved(solved) => Ok(solved),
            Stop::NotConverged(Converged { iterations, residual }) => {
                Err(Failure::NotConverged { iterations, residual })
            }
            Stop::Indefinite { row } => Err(Failure::Indefinite { node: self.order[row] }),
        }
    }

    /// Conjugate gradients with one cycle as preconditioner.
    fn iterate(&mut self, iterates: &mut Iterates<D>, tolerance: f64, iterations: u32) -> Stop {
        let mut scratch = std::mem::take(&mut self.scratch);
        let precondition = |r: &[Vector<D>], z: &mut [Vector<D>]| {
            scratch[0].b.copy_from_slice(r);
            self.cycle(0, &mut scratch);
            z.copy_from_slice(&scratch[0].x);
        };
        let matrix = &self.levels[0].matrix;
        let stop = conjugate_gradients::solve(matrix, iterates, precondition, tolerance, iterations);
        self.scratch = scratch;
        stop
    }

    /// Size of the hierarchy.
    pub fn size(&self) -> Size {
        let per_level = |level: &Level<D>| {
            let interpolation =
                level.interpolation.as_ref().map_or(0, |it| it.parents.bytes() + it.children.bytes());
            level.matrix.bytes() + interpolation + level.matrix.n_rows() * (3 * size_of::<Vector<D>>() + 12)
        };
        let own = size_of_val(&self.order[..]) + size_of_val(&self.source[..]) + self.held.len();
        // Vectors of the conjugate gradients.
        let vectors = 6 * self.order.len() * size_of::<Vector<D>>();
        Size {
            nodes: self.levels.iter().map(|level| level.matrix.n_rows()).collect(),
            blocks: self.levels.iter().map(|level| level.matrix.column.len()).collect(),
            bytes: own + vectors + self.levels.iter().map(per_level).sum::<usize>(),
        }
    }

    /// The values of the finest matrix, and which components couple with nothing.
    fn take(&mut self, Matrix { pattern, values }: Matrix<'_>) -> Result<(), Failure> {
        let matrix = &mut self.levels[0].matrix;
        let (n, source) = (matrix.n_rows(), &self.source);
        let BlockMatrix { start, block, .. } = matrix;
        for_each_part(&row_bounds(start), block, &|task, blocks| {
            let offset = start[task * ROWS];
            for (place, block) in blocks.iter_mut().enumerate() {
                *block = source[offset + place].read(pattern, values);
            }
        });
        let matrix = &self.levels[0].matrix;
        let infinite = self.held.par_iter_mut().enumerate().filter_map(|(row, held)| {
            let mut largest = [0.0_f64; D];
            let mut finite = true;
            for entry in matrix.start[row]..matrix.start[row + 1] {
                let block = &matrix.block[entry];
                for i in 0..D {
                    for j in (0..D).filter(|&j| entry != matrix.diagonal[row] || j != i) {
                        largest[i] = largest[i].max(block[(i, j)].abs());
                    }
                }
                finite &= block.iter().all(|it| it.is_finite());
            }
            *held = (0..D).filter(|&i| largest[i] == 0.0).fold(0, |held, i| held | 1 << i);
            (!finite).then_some(row)
        });
        debug_assert_eq!(n, self.order.len());
        match infinite.min() {
            Some(row) => Err(Failure::NotFinite { node: self.order[row] }),
            None => Ok(()),
        }
    }

    /// A caller's node near a node of a level.
    fn on_finest(&self, level: usize, row: usize) -> usize {
        let row = (0..level).rev().fold(row, |row, level| {
            let interpolation = self.levels[level].interpolation.as_ref().expect("a coarser level exists");
            interpolation.children.of(row)[0].0 as usize
        });
        self.order[row]
    }

    /// `x ≈ A⁻¹ b` of one level.
    fn cycle(&self, level: usize, scratch: &mut [Scratch<D>]) {
        let Level { lattice, matrix, interpolation } = &self.levels[level];
        let (here, coarser) = scratch.split_at_mut(1);
        let Scratch { b, x, r } = &mut here[0];
        let Some(Interpolation { parents, children }) = interpolation else {
            let factor = self.coarsest.as_ref().expect("prepared before");
            let mut dense = DVector::from_iterator(b.len() * D, b.iter().flat_map(|b| b.iter().copied()));
            factor.solve_mut(&mut dense);
            for (x, found) in x.iter_mut().zip(dense.as_slice().chunks_exact(D)) {
                x.copy_from_slice(found);
            }
            return;
        };
        matrix.sweep_from_zero(&lattice.strips, b, x);
        matrix.residual_after_sweep(x, r);
        coarser[0].b.par_iter_mut().with_min_len(256).enumerate().for_each(|(node, b)| {
            *b = children
                .of(node)
                .iter()
                .fold(Vector::zeros(), |sum, &(child, weight)| sum + r[child as usize] * weight);
        });
        self.cycle(level + 1, coarser);
        let correction = &coarser[0].x;
        r.par_iter_mut().with_min_len(1024).enumerate().for_each(|(node, r)| {
            *r = parents
                .of(node)
                .iter()
                .fold(Vector::zeros(), |sum, &(parent, weight)| sum + correction[parent as usize] * weight);
        });
        add(x, 1.0, r);
        matrix.sweep_back(&lattice.strips, b, x);
    }
}

impl Source {
    #[inline]
    fn read<const D: usize>(self, pattern: Pattern<'_>, values: &[f64]) -> Block<D> {
        let first = self.column as usize * D;
        if self.slot == 0 {
            return Block::from_fn(|i, j| {
                let (i, j) = (i.max(j), i.min(j));
                values[pattern.column_start[first + j] + i - j]
            });
        }
        let slot = (self.slot & !TRANSPOSED) as usize - 1;
        let block = Block::from_fn(|i, j| values[pattern.column_start[first + j] + (D - j) + slot * D + i]);
        if self.slot & TRANSPOSED == 0 { block } else { block.transpose() }
    }
}

/// Nodes below the diagonal in a node's columns.
struct Neighbours<'a, const D: usize> {
    rows: &'a [usize],
}

impl<'a, const D: usize> Neighbours<'a, D> {
    fn of(pattern: Pattern<'a>, node: usize) -> Self {
        let entries = pattern.column_start[node * D] + D..pattern.column_start[node * D + 1];
        Self { rows: &pattern.row[entries] }
    }

    fn for_each(&self, mut see: impl FnMut(usize)) {
        for rows in self.rows.chunks_exact(D) {
            see(rows[0] / D);
        }
    }
}

/// Lines that couplings span in each direction.
fn reach(n: usize, nodes: &LatticePlaces<'_>, neighbours: impl Fn(usize, &mut dyn FnMut(usize))) -> [u32; 3] {
    let mut reach = [1; 3];
    for node in 0..n {
        neighbours(node, &mut |other| {
            for (d, reach) in reach.iter_mut().enumerate() {
                let apart = nodes.index[node][d].abs_diff(nodes.index[other][d]);
                let apart = nodes.periods[d].map_or(apart, |n| apart.min(n - apart.min(n)));
                *reach = (*reach).max(apart);
            }
        });
    }
    reach
}

/// Places in the list of entries at which tasks of rows begin, and the end.
fn row_bounds(start: &[usize]) -> Vec<usize> {
    let n = start.len() - 1;
    (0..=n.div_ceil(ROWS)).map(|task| start[(task * ROWS).min(n)]).collect()
}

/// A matrix with ones on the diagonal where a component carries nothing.
fn dense<const D: usize>(matrix: &BlockMatrix<D>) -> DMatrix<f64> {
    let n = matrix.n_rows();
    let mut dense = DMatrix::zeros(n * D, n * D);
    for row in 0..n {
        for entry in matrix.start[row]..matrix.start[row + 1] {
            let column = matrix.column[entry] as usize;
            dense.view_mut((row * D, column * D), (D, D)).copy_from(&matrix.block[entry]);
        }
        for i in row * D..(row + 1) * D {
            if matrix.inverse[row].row(i - row * D).iter().all(|&it| it == 0.0) {
                dense.row_mut(i).fill(0.0);
                dense.column_mut(i).fill(0.0);
                dense[(i, i)] = 1.0;
            }
        }
    }
    dense
}
