//! Levels of lattices and matrices, and the cycle through them.

use super::arithmetic::{Vector, add, for_each_part};
use super::blocks::BlockMatrix;
use super::coarsening::{Interpolation, Lattice};
use super::coarsest::CoarsestFactor;
use super::galerkin;
use super::krylov::Krylov;
use super::outcome::{Converged, Failure, Stop};
use super::roughness::Roughness;
use super::source::{Column, Source, TRANSPOSED};
use crate::matrix::{Matrix, Pattern, Symmetry};
use crate::solver::LatticePlaces;
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
    coarsest: Option<CoarsestFactor>,
    /// What is added to the correction of the finest level, of splines.
    roughness: Option<Roughness<D>>,
    symmetry: Symmetry,
    /// Of every level.
    scratch: Vec<Scratch<D>>,
    /// Made when first needed.
    krylov: Option<Krylov<D>>,
}

#[derive(Clone, Debug)]
struct Level<const D: usize> {
    lattice: Lattice,
    matrix: BlockMatrix<D>,
    /// From the next coarser level; none on the coarsest.
    interpolation: Option<Interpolation>,
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

/// Vectors of one level while a cycle runs.
#[derive(Clone, Debug)]
struct Scratch<const D: usize> {
    b: Vec<Vector<D>>,
    x: Vec<Vector<D>>,
    r: Vec<Vector<D>>,
    /// For [`Roughness`]; empty where there is none.
    rough: [Vec<Vector<D>>; 2],
}

impl<const D: usize> Scratch<D> {
    fn zeros(n: usize) -> Self {
        let zeros = vec![Vector::zeros(); n];
        Self { b: zeros.clone(), x: zeros.clone(), r: zeros, rough: Default::default() }
    }

    /// Of all levels, of the finest also for [`Roughness`] where there is one.
    fn of(levels: &[Level<D>], is_rough: bool) -> Vec<Self> {
        let mut scratch: Vec<Self> = levels.iter().map(|level| Self::zeros(level.matrix.n_rows())).collect();
        if is_rough {
            scratch[0].rough = [scratch[0].b.clone(), scratch[0].b.clone()];
        }
        scratch
    }
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
        let column = |node: usize| Column::<D>::of(pattern, node);
        let reach = reach(n, &nodes, |node, see| column(node).for_each(|other, _| see(other)));
        let (lattice, order) = Lattice::finest(nodes.index, nodes.lines, nodes.periods, reach);
        let mut number = vec![0_u32; n];
        for (new, &old) in order.iter().enumerate() {
            number[old] = new as u32;
        }

        // Both triangles by rows, in the order of the strips.
        let both = |node: usize, other: usize| pattern.is_symmetric() && node != other;
        let mut start = vec![0; n + 1];
        for node in 0..n {
            column(node).for_each(|other, _| {
                start[number[other] as usize + 1] += 1;
                start[number[node] as usize + 1] += usize::from(both(node, other));
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
            let (here, from) = (number[node], node as u32);
            column(node).for_each(|other, slot| {
                put(number[other], here, Source { column: from, slot });
                if both(node, other) {
                    put(here, number[other], Source { column: from, slot: slot | TRANSPOSED });
                }
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
        let roughness = Roughness::of(&levels[0].lattice, nodes.degree);
        let scratch = Scratch::of(&levels, roughness.is_some());
        Some(Self {
            levels,
            order,
            source,
            held: vec![0; n],
            coarsest: None,
            roughness,
            symmetry: pattern.symmetry,
            scratch,
            krylov: None,
        })
    }

    /// Takes the values of the matrix, whose pattern is the one analysed, and forms the coarse matrices.
    /// Components that couple with nothing are left out of these.
    ///
    /// # Errors
    /// [`Failure::NotFinite`]; of a symmetric matrix [`Failure::Indefinite`] where a diagonal block or the coarsest
    /// matrix is not positive definite (where they all are, the matrix may still not be), of another one
    /// [`Failure::Singular`] where the coarsest matrix is singular.
    ///
    /// # Panics
    /// If there is not one value per entry of the pattern.
    pub fn prepare(&mut self, matrix: Matrix<'_>) -> Result<(), Failure> {
        assert_eq!(matrix.values.len(), matrix.pattern.n_entries(), "one value per entry of the pattern");
        self.coarsest = None;
        self.take(matrix)?;
        if let Some(roughness) = &mut self.roughness {
            roughness.prepare(&self.levels[0].matrix, &self.held);
        }
        for level in 0..self.levels.len() {
            if let Err(row) = self.levels[level].matrix.invert_diagonal(self.symmetry) {
                return Err(self.unusable(level, row));
            }
            let (fine, coarse) = self.levels.split_at_mut(level + 1);
            let Some(interpolation) = &fine[level].interpolation else { break };
            let held: &[u8] = if level == 0 { &self.held } else { &[] };
            galerkin::fill(&fine[level].matrix, held, interpolation, &mut coarse[0].matrix);
        }
        let last = self.levels.len() - 1;
        self.coarsest = CoarsestFactor::of(&self.levels[last].matrix, self.symmetry);
        if self.coarsest.is_none() {
            return Err(self.unusable(last, 0));
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
        let n = self.order.len();
        let mut krylov = self.krylov.take().unwrap_or_else(|| Krylov::zeros(self.symmetry, n));
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
        let mut scratch = std::mem::take(&mut self.scratch);
        let precondition = |r: &[Vector<D>], z: &mut [Vector<D>]| {
            scratch[0].b.copy_from_slice(r);
            self.cycle(0, &mut scratch);
            z.copy_from_slice(&scratch[0].x);
        };
        let stop = krylov.solve(&self.levels[0].matrix, precondition, tolerance, iterations);
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
        let vectors = Krylov::<D>::vectors(self.symmetry) * self.order.len() * size_of::<Vector<D>>();
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

    /// A diagonal block or the coarsest matrix cannot be inverted.
    fn unusable(&self, level: usize, row: usize) -> Failure {
        let node = self.on_finest(level, row);
        match self.symmetry {
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

    /// `x ≈ A⁻¹ b` of one level.
    fn cycle(&self, level: usize, scratch: &mut [Scratch<D>]) {
        let Level { lattice, matrix, interpolation } = &self.levels[level];
        let (here, coarser) = scratch.split_at_mut(1);
        let Scratch { b, x, r, rough: [rough, lines] } = &mut here[0];
        let Some(Interpolation { parents, children }) = interpolation else {
            let factor = self.coarsest.as_ref().expect("prepared before");
            return factor.solve(b, x);
        };
        matrix.sweep_from_zero(&lattice.strips, b, x);
        matrix.residual_after_sweep(x, r);
        coarser[0].b.par_iter_mut().with_min_len(256).enumerate().for_each(|(node, b)| {
            *b = children
                .of(node)
                .iter()
                .fold(Vector::zeros(), |sum, &(child, weight)| sum + r[child as usize] * weight);
        });
        let roughness = self.roughness.as_ref().filter(|_| level == 0);
        if let Some(roughness) = roughness {
            roughness.correct(r, rough, lines);
        }
        self.cycle(level + 1, coarser);
        let correction = &coarser[0].x;
        r.par_iter_mut().with_min_len(1024).enumerate().for_each(|(node, r)| {
            *r = parents
                .of(node)
                .iter()
                .fold(Vector::zeros(), |sum, &(parent, weight)| sum + correction[parent as usize] * weight);
        });
        add(x, 1.0, r);
        if roughness.is_some() {
            add(x, 1.0, rough);
        }
        matrix.sweep_back(&lattice.strips, b, x);
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
