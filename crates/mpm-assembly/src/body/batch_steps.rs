//! The steps of the points of a batch: displacement gradients, measured point by point and read four at a time.

use crate::body::batch::{BATCH, Gathered, transposed};
use crate::body::kinematics::StepGradient;
use mpm_grid::{Block, Vector};
use mpm_material::lanes::{LANES, Lanes, Number, Work, four, vectorised};

/// [`Lanes`] of the displacement gradient of a point.
const fn step_lanes(dimensions: usize) -> usize {
    if dimensions == 2 { 1 } else { 3 }
}

/// The steps of the points of a batch.
#[derive(Debug)]
pub(crate) struct Steps<const D: usize> {
    /// Columns of `ΔF - I`, one in [`Lanes`] or in the plane both.
    steps: [Lanes; 3 * BATCH],
    /// `ΔF_θθ - 1`; 0 where there is no hoop.
    hoops: [f64; BATCH],
    /// `Δu_v` of a set of nodes; in the plane twice.
    increment: Vec<Lanes>,
}

impl<const D: usize> Steps<D> {
    /// With room for sets of `most_nodes` nodes; larger ones make it.
    pub fn new(most_nodes: usize) -> Self {
        let increment = vec![Lanes::ZERO; most_nodes];
        Self { steps: [Lanes::ZERO; 3 * BATCH], hoops: [0.0; BATCH], increment }
    }

    /// Measures the steps of all points under `Δu_v`.
    pub fn measure<const HOOP: bool>(
        &mut self,
        gathered: &Gathered<'_, D>,
        increment: &[Vector<D>],
        position: &[Vector<D>],
    ) {
        vectorised(Measuring::<D, HOOP> { steps: self, gathered, increment, position });
    }

    #[inline(always)]
    fn measure_all<const HOOP: bool>(
        &mut self,
        gathered: &Gathered<'_, D>,
        increment: &[Vector<D>],
        position: &[Vector<D>],
    ) {
        let (mut nodes, mut at): (&[u32], usize) = (&[], 0);
        for segment in gathered.segments() {
            let group = &segment.group;
            let n = group.nodes.len();
            // Groups of a set share its list.
            if !std::ptr::eq(nodes, group.nodes) {
                nodes = group.nodes;
                if self.increment.len() < n {
                    self.increment.resize(n, Lanes::ZERO);
                }
                for (of, &node) in self.increment.iter_mut().zip(nodes) {
                    let u = &increment[node as usize];
                    *of = Lanes(if D == 2 { [u[0], u[1], u[0], u[1]] } else { [u[0], u[1], u[D - 1], 0.0] });
                }
            }
            for k in segment.from..segment.to {
                let mut columns = [Lanes::ZERO; 3];
                for (u, g) in self.increment.iter().zip(&group.gradients[k * n..(k + 1) * n]) {
                    if D == 2 {
                        columns[0] += *u * Lanes([g[0], g[0], g[1], g[1]]);
                    } else {
                        for (j, column) in columns.iter_mut().enumerate() {
                            *column += *u * Lanes::of(g[j]);
                        }
                    }
                }
                if HOOP {
                    let radius = position[group.first_point + k][0];
                    let values = &group.values[k * n..(k + 1) * n];
                    let hoop = self.increment.iter().zip(values).map(|(u, value)| u.0[0] * value).sum::<f64>()
                        / radius;
                    if D == 3 {
                        // As in `StepGradient::of`.
                        columns.iter_mut().for_each(|column| column.0[2] *= radius * (1.0 + hoop));
                        columns[2].0[2] = hoop;
                    }
                    self.hoops[at] = hoop;
                }
                let step = &mut self.steps[at * const { step_lanes(D) }..][..const { step_lanes(D) }];
                step.copy_from_slice(&columns[..const { step_lanes(D) }]);
                at += 1;
            }
        }
    }

    /// `ΔF - I` of the point at a place, and of its hoop.
    pub fn step(&self, at: usize) -> StepGradient<D> {
        let columns = &self.steps[at * const { step_lanes(D) }..];
        let block = Block::from_fn(|i, j| if D == 2 { columns[0].0[i + 2 * j] } else { columns[j].0[i] });
        StepGradient { block, hoop: self.hoops[at] }
    }

    /// Columns of `ΔF - I` of the points at four places, and those of their hoops.
    #[inline(always)]
    pub fn four_steps(&self, at: [usize; LANES]) -> ([[Lanes; D]; D], Lanes) {
        let column = |j: usize| transposed(four(|k| self.steps[at[k] * const { step_lanes(D) } + j]));
        let mut columns = [[Lanes::ZERO; D]; D];
        if D == 2 {
            columns.as_flattened_mut().copy_from_slice(&column(0));
        } else {
            for (j, to) in columns.iter_mut().enumerate() {
                to.copy_from_slice(&column(j)[..D]);
            }
        }
        (columns, Lanes(four(|k| self.hoops[at[k]])))
    }

    /// Takes a step that has been measured otherwise.
    #[inline(always)]
    pub fn set(&mut self, at: usize, step: &StepGradient<D>) {
        let h = &step.block;
        if D == 2 {
            self.steps[at] = Lanes([h[(0, 0)], h[(1, 0)], h[(0, 1)], h[(1, 1)]]);
        } else {
            for j in 0..D {
                self.steps[at * const { step_lanes(D) } + j] =
                    Lanes([h[(0, j)], h[(1, j)], h[(D - 1, j)], 0.0]);
            }
        }
        self.hoops[at] = step.hoop;
    }
}

/// Measures the steps of a batch.
struct Measuring<'a, const D: usize, const HOOP: bool> {
    steps: &'a mut Steps<D>,
    gathered: &'a Gathered<'a, D>,
    increment: &'a [Vector<D>],
    position: &'a [Vector<D>],
}

impl<const D: usize, const HOOP: bool> Work for Measuring<'_, D, HOOP> {
    type Output = ();

    #[inline(always)]
    fn run<const VECTORS: bool>(self) {
        self.steps.measure_all::<HOOP>(self.gathered, self.increment, self.position);
    }
}
