//! Points that are worked on together: their laws are asked four at a time, whatever nodes they have.
//!
//! A pass walks over the points set by set. It collects [`BATCH`] of them, measures their steps, asks their law, and then adds
//! what it answers to the sums of their nodes, set by set in the same order. What belongs to a point does not depend on the
//! points beside it, so that batches change no bits.

use crate::body::kinematics::StepGradient;
use mpm_basis::Connectivity;
use mpm_grid::{Block, Vector};
use mpm_material::lanes::{LANES, Lanes, Number, four};
use mpm_material::{PrincipalTangent, PrincipalTrial, PrincipalUpdate, SymmetricTensor};
use std::ops::Range;

/// Points of a batch: few enough that what is known of them stays in the first cache.
pub(crate) const BATCH: usize = 32;

/// [`Lanes`] of the displacement gradient of a point.
const fn step_lanes(dimensions: usize) -> usize {
    if dimensions == 2 { 1 } else { 3 }
}

/// [`Lanes`] of the first entries of an answer, see [`entries`].
const fn entry_lanes(dimensions: usize) -> usize {
    if dimensions == 2 { 3 } else { 5 }
}

/// [`Lanes`] of the moduli `a_ikjl` of one l.
const fn row_lanes(dimensions: usize) -> usize {
    dimensions.pow(3).div_ceil(LANES)
}

/// [`Lanes`] of the moduli of a point; in the plane those of the hoop are behind the others.
const fn moduli_lanes(dimensions: usize) -> usize {
    dimensions * row_lanes(dimensions) + if dimensions == 2 { 3 } else { 0 }
}

/// Some points of a group.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    pub set: usize,
    pub group: usize,
    /// Within the group.
    pub points: Range<usize>,
    /// Whether they are the first of their set.
    pub begins: bool,
    /// Whether they are the last of their set.
    pub ends: bool,
}

/// Up to four points and their principal trial strains; where there are fewer, the last one takes the other lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four {
    /// Place of the first one in the batch.
    pub first: usize,
    pub count: usize,
    /// Numbers of the points in their body.
    pub points: [usize; LANES],
    pub strain: [Lanes; 3],
}

/// What is known of four points before their law is asked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tried<const D: usize> {
    /// Columns of the inverse of ΔF.
    pub inverse: [[Lanes; D]; D],
    /// `ΔF_θθ`; 1 where there is no hoop.
    pub hoop: Lanes,
    pub trial: PrincipalTrial<Lanes>,
}

/// Points, their steps, and what their law answers.
#[derive(Debug)]
pub(crate) struct Batch<const D: usize> {
    pub segments: Vec<Segment>,
    /// Numbers of the points in their body.
    pub points: Vec<usize>,
    /// Columns of `ΔF - I`, one in [`Lanes`] or in the plane both.
    steps: Vec<Lanes>,
    /// `ΔF_θθ - 1`; 0 where there is no hoop.
    hoops: Vec<f64>,
    entries: Vec<Lanes>,
    moduli: Vec<Lanes>,
    is_symmetric: Vec<bool>,
    /// `Δu_v` of a set of nodes; in the plane twice.
    increment: Vec<Lanes>,
    /// The points by fours.
    pub fours: Vec<Four>,
    /// What is known of each four before its law is asked.
    pub tried: Vec<Tried<D>>,
    /// What the law answers each.
    pub updates: Vec<PrincipalUpdate<Lanes>>,
}

impl<const D: usize> Batch<D> {
    /// For sets of up to `most_nodes` nodes.
    pub fn new(most_nodes: usize) -> Self {
        Self {
            segments: Vec::with_capacity(BATCH),
            points: Vec::with_capacity(BATCH),
            steps: Vec::with_capacity(BATCH * const { step_lanes(D) }),
            hoops: Vec::with_capacity(BATCH),
            entries: vec![Lanes::ZERO; BATCH * const { entry_lanes(D) }],
            moduli: vec![Lanes::ZERO; BATCH * const { moduli_lanes(D) }],
            is_symmetric: vec![true; BATCH],
            increment: vec![Lanes::ZERO; most_nodes],
            fours: Vec::with_capacity(BATCH),
            tried: Vec::with_capacity(BATCH),
            updates: Vec::with_capacity(BATCH),
        }
    }

    /// Forgets the points.
    pub fn clear(&mut self) {
        self.segments.clear();
        self.points.clear();
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Takes points on.
    pub fn push(&mut self, segment: Segment, first_point: usize) {
        self.points.extend(segment.points.clone().map(|k| first_point + k));
        self.segments.push(segment);
    }

    /// Measures the steps of all points under `Δu_v`.
    #[inline(always)]
    pub fn measure<const HOOP: bool>(
        &mut self,
        connectivity: &Connectivity<D>,
        increment: &[Vector<D>],
        position: &[Vector<D>],
    ) {
        self.steps.clear();
        self.hoops.clear();
        for segment in &self.segments {
            let group = connectivity.group(segment.group);
            let n = group.nodes.len();
            for (of, &node) in self.increment.iter_mut().zip(group.nodes) {
                let u = &increment[node as usize];
                *of = Lanes(if D == 2 { [u[0], u[1], u[0], u[1]] } else { [u[0], u[1], u[D - 1], 0.0] });
            }
            for k in segment.points.clone() {
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
                let mut hoop = 0.0;
                if HOOP {
                    let radius = position[group.first_point + k][0];
                    let values = &group.values[k * n..(k + 1) * n];
                    hoop = self.increment.iter().zip(values).map(|(u, value)| u.0[0] * value).sum::<f64>()
                        / radius;
                    if D == 3 {
                        // As in `StepGradient::of`.
                        columns.iter_mut().for_each(|column| column.0[2] *= radius * (1.0 + hoop));
                        columns[2].0[2] = hoop;
                    }
                }
                self.steps.extend_from_slice(&columns[..const { step_lanes(D) }]);
                self.hoops.push(hoop);
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

    /// Keeps the entries of the first `count` of four points, from a place on.
    #[inline(always)]
    pub fn keep_entries(&mut self, (first, count): (usize, usize), entries: &[Lanes; 20]) {
        let entries = &entries[..LANES * const { entry_lanes(D) }];
        put_four(
            &mut self.entries[first * const { entry_lanes(D) }..],
            const { entry_lanes(D) },
            0,
            (entries, count),
        );
    }

    /// Keeps the moduli of the same points.
    #[inline(always)]
    pub fn keep_moduli<const HOOP: bool>(
        &mut self,
        (first, count): (usize, usize),
        tangent: &PrincipalTangent<Lanes>,
    ) {
        let to = &mut self.moduli[first * const { moduli_lanes(D) }..];
        for (l, row) in tangent.moduli::<D>().iter().enumerate() {
            let row = row.as_flattened().as_flattened();
            put_four(to, const { moduli_lanes(D) }, l * const { row_lanes(D) }, (row, count));
        }
        if HOOP && D == 2 {
            // By columns.
            let ([[a, b], [c, d]], [[e, f], [g, h]], hoop) = tangent.hoop_moduli();
            put_four(
                to,
                const { moduli_lanes(D) },
                D * const { row_lanes(D) },
                (&[a, b, c, d, e, f, g, h, hoop], count),
            );
        }
        let is_symmetric = tangent.is_symmetric().0;
        self.is_symmetric[first..first + count].copy_from_slice(&is_symmetric[..count]);
    }

    /// What is known of the point at a place.
    #[inline(always)]
    pub fn answered(&self, at: usize) -> Answered<'_, D> {
        Answered {
            entries: &self.entries[at * const { entry_lanes(D) }..][..const { entry_lanes(D) }],
            moduli: &self.moduli[at * const { moduli_lanes(D) }..][..const { moduli_lanes(D) }],
            is_symmetric: self.is_symmetric[at],
        }
    }
}

/// Writes the first `count` of four points' numbers, which are in `from` one after the other, to every `stride`-th place
/// from `offset` on.
#[inline(always)]
fn put_four(to: &mut [Lanes], stride: usize, offset: usize, (from, count): (&[Lanes], usize)) {
    let entry = |k: usize| from.get(k).copied().unwrap_or(Lanes::ZERO);
    for pack in 0..from.len().div_ceil(LANES) {
        let at = LANES * pack;
        let four = transposed([entry(at), entry(at + 1), entry(at + 2), entry(at + 3)]);
        for (point, numbers) in four.into_iter().enumerate().take(count) {
            to[point * stride + offset + pack] = numbers;
        }
    }
}

/// Four of four numbers the other way round.
#[inline(always)]
fn transposed(of: [Lanes; LANES]) -> [Lanes; LANES] {
    four(|k| Lanes([of[0].0[k], of[1].0[k], of[2].0[k], of[3].0[k]]))
}

/// Columns of the inverse of ΔF one after the other, `V⁰ τ` (xx, yy, xy in the plane, xx, yy, zz, xy, yz, zx in space), and
/// of the hoop `V⁰ τ_θθ` and `ΔF_θθ`; then V⁰.
#[inline(always)]
pub(crate) fn entries<T: Number, const D: usize>(
    inverse: &[[T; D]; D],
    kirchhoff: &SymmetricTensor<T>,
    (volume, hoop): (T, T),
) -> [T; 20] {
    let mut entries = [T::ZERO; 20];
    entries[..D * D].copy_from_slice(inverse.as_flattened());
    let SymmetricTensor { xx, yy, zz, xy, yz, zx } = *kirchhoff;
    if D == 2 {
        entries[4..7].copy_from_slice(&[xx * volume, yy * volume, xy * volume]);
    } else {
        let stress = [xx * volume, yy * volume, zz * volume, xy * volume, yz * volume, zx * volume];
        entries[9..15].copy_from_slice(&stress);
    }
    let last = if D == 2 { 7 } else { 15 };
    entries[last..last + 3].copy_from_slice(&[zz * volume, hoop, volume]);
    entries
}

/// What is known of a point after its law has been asked.
#[derive(Clone, Copy)]
pub(crate) struct Answered<'a, const D: usize> {
    entries: &'a [Lanes],
    moduli: &'a [Lanes],
    pub is_symmetric: bool,
}

impl<const D: usize> Answered<'_, D> {
    #[inline(always)]
    fn entry(&self, k: usize) -> f64 {
        self.entries[k / LANES].0[k % LANES]
    }

    /// Entry (d, i) of the inverse of ΔF.
    #[inline(always)]
    pub fn inverse(&self, d: usize, i: usize) -> f64 {
        self.entry(i * D + d)
    }

    /// Entry (i, j) of `V⁰ τ`.
    #[inline(always)]
    pub fn stress(&self, i: usize, j: usize) -> f64 {
        if D == 2 {
            return self.entry(4 + if i == j { i } else { 2 });
        }
        self.entry(9 + if i == j { i } else { [0, 3, 5, 4][i + j] })
    }

    /// `V⁰ τ_θθ`.
    #[inline(always)]
    pub fn hoop_stress(&self) -> f64 {
        self.entry(if D == 2 { 7 } else { 15 })
    }

    /// `ΔF_θθ`.
    #[inline(always)]
    pub fn hoop(&self) -> f64 {
        self.entry(if D == 2 { 8 } else { 16 })
    }

    /// V⁰.
    #[inline(always)]
    pub fn volume(&self) -> f64 {
        self.entry(if D == 2 { 9 } else { 17 })
    }

    /// `a_ikjl`.
    #[inline(always)]
    pub fn modulus(&self, [i, k, j, l]: [usize; 4]) -> f64 {
        let at = (k * D + j) * D + i;
        self.moduli[l * const { row_lanes(D) } + at / LANES].0[at % LANES]
    }

    /// `Σ_l a_ikjl w_l` at (k D + j) D + i, over the first `terms` of l.
    #[inline(always)]
    pub fn half(&self, weight: &[f64; D], terms: usize) -> [f64; 28] {
        let mut half = [0.0; 28];
        for (pack, half) in half.as_chunks_mut::<LANES>().0[..const { row_lanes(D) }].iter_mut().enumerate() {
            let mut sum = self.moduli[pack] * Lanes::of(weight[0]);
            for (l, weight) in weight.iter().enumerate().take(terms).skip(1) {
                sum += self.moduli[l * const { row_lanes(D) } + pack] * Lanes::of(*weight);
            }
            *half = sum.0;
        }
        half
    }

    /// Of the hoop in the plane: `c_ik` and `c'_ik`.
    #[inline(always)]
    pub fn by_hoop(&self, i: usize, k: usize) -> (f64, f64) {
        let hoop = &self.moduli[D * const { row_lanes(D) }..];
        (hoop[0].0[2 * k + i], hoop[1].0[2 * k + i])
    }

    /// `a_θθθθ` in the plane.
    #[inline(always)]
    pub fn hoop_modulus(&self) -> f64 {
        self.moduli[D * const { row_lanes(D) } + 2].0[0]
    }
}
