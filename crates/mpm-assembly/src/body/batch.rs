//! Points that are worked on together: their laws are asked four at a time, whatever nodes they have.
//!
//! A pass walks over the points set by set. It collects [`BATCH`] of them, measures their steps, asks their law, and then adds
//! what it answers to the sums of their nodes, set by set in the same order. What belongs to a point does not depend on the
//! points beside it, so that batches change no bits.

use mpm_basis::Group;
use mpm_material::lanes::{LANES, Lanes, Number, four};
use mpm_material::{PrincipalTangent, SymmetricTensor};

/// Points of a batch: few enough that what is known of them stays in the first cache.
pub(crate) const BATCH: usize = 32;

/// [`Lanes`] of what sums need of a point besides its moduli, see [`Entries`].
const fn entry_lanes(dimensions: usize) -> usize {
    if dimensions == 2 { 3 } else { 6 }
}

/// The first of them, which are all that forces need.
const fn force_lanes(dimensions: usize, has_hoop: bool) -> usize {
    match (dimensions, has_hoop) {
        (2, false) => 1,
        (2, true) => 2,
        _ => 3,
    }
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
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment<'a, const D: usize> {
    pub set: usize,
    pub group: Group<'a, D>,
    /// The points, within the group.
    pub from: usize,
    pub to: usize,
    /// Whether they are the first of their set.
    pub begins: bool,
    /// Whether they are the last of their set.
    pub ends: bool,
}

/// Up to [`BATCH`] points.
#[derive(Debug)]
pub(crate) struct Gathered<'a, const D: usize> {
    segments: [Segment<'a, D>; BATCH],
    n_segments: usize,
    points: [usize; BATCH],
    n_points: usize,
}

impl<'a, const D: usize> Gathered<'a, D> {
    pub fn new() -> Self {
        let group = Group { first_point: 0, points: 0, nodes: &[], values: &[], gradients: &[], masses: &[] };
        let segment = Segment { set: 0, group, from: 0, to: 0, begins: false, ends: false };
        Self { segments: [segment; BATCH], n_segments: 0, points: [0; BATCH], n_points: 0 }
    }

    /// Takes on the points of a group from one on, as many as there is room for; the first that stays.
    #[inline(always)]
    pub fn push(
        &mut self,
        (set, group): (usize, Group<'a, D>),
        from: usize,
        (is_first, is_last): (bool, bool),
    ) -> usize {
        let to = group.points.min(from + BATCH - self.n_points);
        for (number, k) in self.points[self.n_points..].iter_mut().zip(from..to) {
            *number = group.first_point + k;
        }
        let (begins, ends) = (is_first && from == 0, is_last && to == group.points);
        self.segments[self.n_segments] = Segment { set, group, from, to, begins, ends };
        self.n_segments += 1;
        self.n_points += to - from;
        to
    }

    pub fn is_full(&self) -> bool {
        self.n_points == BATCH
    }

    pub fn clear(&mut self) {
        (self.n_segments, self.n_points) = (0, 0);
    }

    pub fn segments(&self) -> &[Segment<'a, D>] {
        &self.segments[..self.n_segments]
    }

    /// Numbers of the points in their body.
    pub fn points(&self) -> &[usize] {
        &self.points[..self.n_points]
    }
}

/// What sums need of the points of a batch.
#[derive(Debug)]
pub(crate) struct Answers<const D: usize> {
    entries: Vec<Lanes>,
    moduli: Vec<Lanes>,
    is_symmetric: Vec<bool>,
}

impl<const D: usize> Answers<D> {
    pub fn new() -> Self {
        Self {
            entries: vec![Lanes::ZERO; BATCH * const { entry_lanes(D) }],
            moduli: vec![Lanes::ZERO; BATCH * const { moduli_lanes(D) }],
            is_symmetric: vec![true; BATCH],
        }
    }

    /// Keeps the entries of the first `count` of four points, from a place on; those of forces alone, or all.
    #[inline(always)]
    pub fn keep_entries<const HOOP: bool, const MODULI: bool>(
        &mut self,
        (first, count): (usize, usize),
        entries: &Entries,
    ) {
        let packs = if MODULI { const { entry_lanes(D) } } else { force_lanes(D, HOOP) };
        put_four(
            &mut self.entries[first * const { entry_lanes(D) }..],
            const { entry_lanes(D) },
            0,
            (&entries.0[..LANES * packs], count),
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
        let is_symmetric = tangent.is_symmetric();
        for (lane, of_point) in self.is_symmetric[first..first + count].iter_mut().enumerate() {
            *of_point = is_symmetric.get(lane);
        }
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
        if count == LANES {
            for (point, numbers) in four.into_iter().enumerate() {
                to[point * stride + offset + pack] = numbers;
            }
        } else {
            for (point, numbers) in four.into_iter().enumerate().take(count) {
                to[point * stride + offset + pack] = numbers;
            }
        }
    }
}

/// Four of four numbers the other way round.
#[inline(always)]
pub(crate) fn transposed(of: [Lanes; LANES]) -> [Lanes; LANES] {
    four(|k| Lanes([of[0].0[k], of[1].0[k], of[2].0[k], of[3].0[k]]))
}

/// What sums need of four points besides moduli: columns of `V⁰ τ ΔF⁻ᵀ`, then `V⁰ τ_θθ`, `ΔF_θθ`, V⁰; columns of the inverse of ΔF;
/// in space `V⁰ τ_zx` and `V⁰ τ_yz`.
pub(crate) struct Entries([Lanes; 24]);

impl Entries {
    #[inline(always)]
    pub fn of<const D: usize>(
        inverse: &[[Lanes; D]; D],
        kirchhoff: &SymmetricTensor<Lanes>,
        (volume, hoop): (Lanes, Lanes),
    ) -> Self {
        let SymmetricTensor { xx, yy, zz, xy, yz, zx } = *kirchhoff;
        let [xx, yy, zz, xy, yz, zx] =
            [xx * volume, yy * volume, zz * volume, xy * volume, yz * volume, zx * volume];
        let stress = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let mut entries = [Lanes::ZERO; 24];
        for d in 0..D {
            for i in 0..D {
                let mut sum = stress[i][0] * inverse[0][d];
                for k in 1..D {
                    sum += stress[i][k] * inverse[k][d];
                }
                entries[d * D + i] = sum;
            }
        }
        let (rest, second) = if D == 2 { (4, 8) } else { (9, 12) };
        entries[rest] = zz;
        entries[rest + 1] = hoop;
        entries[rest + 2] = volume;
        entries[second..second + D * D].copy_from_slice(inverse.as_flattened());
        if D == 3 {
            entries[second + 9] = zx;
            entries[second + 10] = yz;
        }
        Self(entries)
    }
}

/// What is known of a point after its law has been asked.
#[derive(Clone, Copy)]
pub(crate) struct Answered<'a, const D: usize> {
    entries: &'a [Lanes],
    moduli: &'a [Lanes],
    pub is_symmetric: bool,
}

impl<const D: usize> Answered<'_, D> {
    /// Nothing is known.
    pub const NONE: Self = Self { entries: &[], moduli: &[], is_symmetric: true };

    #[inline(always)]
    fn entry(&self, k: usize) -> f64 {
        self.entries[k / LANES].0[k % LANES]
    }

    /// Entry (i, d) of `V⁰ τ ΔF⁻ᵀ`.
    #[inline(always)]
    pub fn force(&self, i: usize, d: usize) -> f64 {
        self.entry(d * D + i)
    }

    /// Entry (d, i) of the inverse of ΔF.
    #[inline(always)]
    pub fn inverse(&self, d: usize, i: usize) -> f64 {
        self.entry(if D == 2 { 8 } else { 12 } + i * D + d)
    }

    /// `V⁰ τ_xz` and `V⁰ τ_yz`, in space.
    #[inline(always)]
    pub fn shear_stress(&self) -> [f64; 2] {
        [self.entry(21), self.entry(22)]
    }

    /// `V⁰ τ_θθ`.
    #[inline(always)]
    pub fn hoop_stress(&self) -> f64 {
        self.entry(if D == 2 { 4 } else { 9 })
    }

    /// `ΔF_θθ`.
    #[inline(always)]
    pub fn hoop(&self) -> f64 {
        self.entry(if D == 2 { 5 } else { 10 })
    }

    /// V⁰.
    #[inline(always)]
    pub fn volume(&self) -> f64 {
        self.entry(if D == 2 { 6 } else { 11 })
    }

    /// `a_ikjl`.
    #[inline(always)]
    pub fn modulus(&self, [i, k, j, l]: [usize; 4]) -> f64 {
        let at = (k * D + j) * D + i;
        self.moduli[l * const { row_lanes(D) } + at / LANES].0[at % LANES]
    }

    /// `Σ_l a_ikjl w_l` at (k D + j) D + i, over the first `terms` of l.
    #[inline(always)]
    pub fn put_half(&self, weight: &[f64; D], terms: usize, to: &mut [f64; 28]) {
        for (pack, half) in to.as_chunks_mut::<LANES>().0[..const { row_lanes(D) }].iter_mut().enumerate() {
            let mut sum = self.moduli[pack] * Lanes::of(weight[0]);
            for (l, weight) in weight.iter().enumerate().take(terms).skip(1) {
                sum += self.moduli[l * const { row_lanes(D) } + pack] * Lanes::of(*weight);
            }
            *half = sum.0;
        }
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
