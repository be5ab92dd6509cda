//! Levels of lattices and matrices, and the cycle through them.

use super::arithmetic::{LARGE_LEVEL, Vector, for_each_part};
use super::blocks::BlockMatrix;
use super::coarsening::Lattice;
use super::coarsest::CoarsestFactor;
use super::cycle::{Cycle, Hierarchy, Level, power_of_two_near};
use super::finest::StoredRows;
use super::galerkin;
use super::krylov::Krylov;
use super::outcome::{Converged, Failure, Stop};
use super::roughness::Roughness;
use super::source::Source;
use crate::matrix::{Matrix, Pattern, Symmetry};
use crate::solver::LatticePlaces;
use rayon::prelude::*;
use std::array::from_fn;

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
    coarsest: Option<CoarsestFactor>,
    /// What is added to the correction of the finest level, of splines.
    roughness: Option<Roughness<D>>,
    /// How matrices are taken: as symmetric and positive definite, or not.
    taken_as: Symmetry,
    cycle: Cycle<D>,
    /// Power of two by which the matrices of the cycle are multiplied.
    scale: f64,
    /// Made when first needed.
    krylov: Option<Krylov<D>>,
}

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

impl<const D: usize> Multigrid<D> {
    /// Coarsens the lattice and finds the structure of all matrices. None where the pattern has not
    /// `D` equations for each node and no others, or some of these do not couple with all of a neighbour's.
    ///
    /// # Panics
    /// If there are not as many places as nodes, or a node stands beyond the lines.
    pub fn analyse(pattern: Pattern<'_>, nodes: LatticePlaces<'_>) -> Option<Self> {
        if pattern.block != D || !pattern.has_whole_blocks() {
            return None;
        }
        let n = nodes.index.len();
        assert_eq!(pattern.blocks, n, "a place on the lattice for each node");
        let (stored, reach) = StoredRows::of::<D, _>(
            pattern,
            n,
            || [1; 3],
            |reach, node, other| {
                for (d, reach) in reach.iter_mut().enumerate() {
                    let apart = nodes.index[node][d].abs_diff(nodes.index[other][d]);
                    let apart = nodes.periods[d].map_or(apart, |n| apart.min(n - apart.min(n)));
                    *reach = apart.max(*reach);
                }
            },
        );
        // Lines that couplings span in each direction.
        let reach = reach.iter().fold([1; 3], |all, of_task| from_fn(|d| all[d].max(of_task[d])));
        let (lattice, order) = Lattice::finest(nodes.index, nodes.lines, nodes.periods, reach);
        let mut number = vec![0_u32; n];
        for (new, &old) in order.iter().enumerate() {
            number[old] = new as u32;
        }
        let (start, column, source) = stored.in_order::<D>(pattern, (&order, &number));

        let mut levels =
            vec![Level { lattice, matrix: BlockMatrix::zeros(start, column), interpolation: None }];
        loop {
            let finest = &levels[levels.len() - 1];
            if finest.lattice.index.len() <= COARSEST {
                break;
            }
            let Some((lattice, interpolation)) = finest.lattice.coarser() else {
                break;
            };
            let matrix = galerkin::structure(&finest.matrix, &interpolation, lattice.index.len());
            let last = levels.len() - 1;
            levels[last].interpolation = Some(interpolation);
            levels.push(Level { lattice, matrix, interpolation: None });
        }
        Some(Self {
            cycle: Cycle::zeros(&levels),
            roughness: Roughness::of(&levels[0].lattice, nodes.degree),
            scale: 1.0,
            levels,
            order,
            source,
            held: vec![0; n],
            coarsest: None,
            taken_as: pattern.symmetry,
            krylov: None,
        })
    }

    /// Takes symmetric matrices from now on as positive definite, as they are at first, or as others are: that is how
    /// what [`Failure::Indefinite`] refused is solved, after it is prepared anew.
    pub fn take_as(&mut self, symmetry: Symmetry) {
        if self.taken_as != symmetry {
            (self.taken_as, self.krylov, self.coarsest) = (symmetry, None, None);
        }
    }

    /// Takes the values of the matrix, whose pattern is the one analysed, and forms the coarse matrices.
    /// Components that couple with nothing are left out of these.
    ///
    /// # Errors
    /// [`Failure::NotFinite`]; of a matrix taken as symmetric [`Failure::Indefinite`] where a diagonal block or the coarsest
    /// matrix is not positive definite (where they all are, the matrix may still not be), of another one
    /// [`Failure::Singular`] where the coarsest matrix is singular; [`Failure::OutOfRange`].
    ///
    /// # Panics
    /// If there is not one value per entry of the pattern.
    pub fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        assert_eq!(matrix.values.len(), matrix.pattern.n_entries(), "one value per entry of the pattern");
        self.coarsest = None;
        self.take(matrix)?;
        self.scale = power_of_two_near(self.levels[0].matrix.largest_diagonal(&self.held).recip());
        for level in 0..self.levels.len() {
            self.finish(level)?;
            let (fine, coarse) = self.levels.split_at_mut(level + 1);
            let Some(interpolation) = &fine[level].interpolation else { break };
            let held: &[u8] = if level == 0 { &self.held } else { &[] };
            galerkin::fill(&fine[level].matrix, held, interpolation, &mut coarse[0].matrix);
        }
        let last = self.levels.len() - 1;
        self.coarsest = CoarsestFactor::of(&self.levels[last].matrix, self.taken_as);
        if self.coarsest.is_none() {
            return Err(self.unusable(last, 0));
        }
        Ok(())
    }

    /// Takes the values of another matrix, and keeps the coarse matrices of the last one that was prepared. A matrix
    /// near that one is solved with few more iterations.
    ///
    /// # Errors
    /// As [`Self::prepare`]; coarse matrices tell nothing of this one.
    ///
    /// # Panics
    /// As [`Self::prepare`].
    pub fn update(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        if self.coarsest.is_none() || self.levels.len() == 1 {
            return self.prepare(matrix);
        }
        assert_eq!(matrix.values.len(), matrix.pattern.n_entries(), "one value per entry of the pattern");
        self.take(matrix)?;
        self.finish(0)
    }

    /// What a level needs besides the values of its matrix.
    fn finish(&mut self, level: usize) -> Result<(), Failure> {
        if let Err(row) = self.levels[level].matrix.invert_diagonal(self.taken_as) {
            return Err(self.unusable(level, row));
        }
        if let Some(roughness) = self.roughness.as_mut().filter(|_| level == 0) {
            roughness.prepare(&self.levels[0].matrix, &self.held, self.scale);
        }
        let taken = self.cycle.take(&self.levels, level, self.scale);
        taken.map_err(|row| Failure::OutOfRange { node: self.on_finest(level, row) })
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
        let n = self.order.len();
        let mut krylov = self.krylov.take().unwrap_or_else(|| Krylov::zeros(self.taken_as, n));
        let (b, _) = krylov.system();
        for (b, &node) in b.iter_mut().zip(&self.order) {
            b.copy_from_slice(&x[node * D..(node + 1) * D]);
        }
        let infinite = b.iter().position(|b| b.iter().any(|b| !b.is_finite()));
        let stop = infinite.is_none().then(|| self.iterate(&mut krylov, tolerance, iterations));
        if stop.is_some() {
            let (_, found) = krylov.system();
            for (&node, found) in self.order.iter().zip(found) {
                x[node * D..(node + 1) * D].copy_from_slice(found.as_slice());
            }
        }
        self.krylov = Some(krylov);
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

    /// The iteration with one cycle as preconditioner.
    fn iterate(&mut self, krylov: &mut Krylov<D>, tolerance: f64, iterations: u32) -> Stop {
        let coarsest = self.coarsest.as_ref().expect("prepared before");
        let roughness = self.roughness.as_ref();
        let (cycle, hierarchy) =
            (&mut self.cycle, Hierarchy { levels: &self.levels, coarsest, roughness, scale: self.scale });
        let precondition =
            |r: &[Vector<D>], size: f64, z: &mut [Vector<D>]| cycle.apply(&hierarchy, (r, size), z);
        krylov.solve(&self.levels[0].matrix, precondition, self.scale, (tolerance, iterations))
    }

    /// Size of the hierarchy.
    pub fn size(&self) -> Size {
        let per_level = |level: &Level<D>| {
            let interpolation =
                level.interpolation.as_ref().map_or(0, |it| it.parents.bytes() + it.children.bytes());
            {
                let (blocks, rows) = (level.matrix.column.len(), level.matrix.n_rows());
                level.matrix.bytes()
                    + interpolation
                    + Cycle::<D>::bytes(blocks, rows)
                    + rows * size_of::<[u32; 3]>()
            }
        };
        let own = size_of_val(&self.order[..]) + size_of_val(&self.source[..]) + self.held.len();
        let vectors = Krylov::<D>::vectors(self.taken_as) * self.order.len() * size_of::<Vector<D>>();
        Size {
            nodes: self.levels.iter().map(|level| level.matrix.n_rows()).collect(),
            blocks: self.levels.iter().map(|level| level.matrix.column.len()).collect(),
            bytes: own
                + vectors
                + self.roughness.as_ref().map_or(0, Roughness::bytes)
                + self.levels.iter().map(per_level).sum::<usize>(),
        }
    }

    /// The values of the finest matrix, and which components couple with nothing.
    fn take(&mut self, Matrix { pattern, values }: Matrix<'_>) -> Result<(), Failure> {
        let matrix = &mut self.levels[0].matrix;
        let (n, source) = (matrix.n_rows(), &self.source);
        let BlockMatrix { start, block, .. } = matrix;
        for_each_part(n > LARGE_LEVEL, &row_bounds(start), &mut block[..], &|task, blocks: &mut [_]| {
            let offset = start[task * ROWS];
            for (place, block) in blocks.iter_mut().enumerate() {
                *block = source[offset + place].read(pattern, values);
            }
        });
        let matrix = &self.levels[0].matrix;
        let look = |(row, held): (usize, &mut u8)| {
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
        };
        let infinite = if n > LARGE_LEVEL {
            self.held.par_iter_mut().enumerate().filter_map(look).min()
        } else {
            self.held.iter_mut().enumerate().filter_map(look).min()
        };
        match infinite {
            Some(row) => Err(Failure::NotFinite { node: self.order[row] }),
            None => Ok(()),
        }
    }

    /// A diagonal block or the coarsest matrix cannot be inverted.
    fn unusable(&self, level: usize, row: usize) -> Failure {
        let node = self.on_finest(level, row);
        match self.taken_as {
            Symmetry::Symmetric => Failure::Indefinite { node },
            Symmetry::Unsymmetric => Failure::Singular { node },
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
}

/// Places in the list of entries at which tasks of rows begin, and the end.
fn row_bounds(start: &[usize]) -> Vec<usize> {
    let n = start.len() - 1;
    (0..=n.div_ceil(ROWS)).map(|task| start[(task * ROWS).min(n)]).collect()
}
