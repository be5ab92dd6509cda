//! The V-cycle through the levels of a hierarchy, in single precision.

use super::arithmetic::{Vector, for_each_node};
use super::blocks::BlockMatrix;
use super::coarsening::{Interpolation, Lattice};
use super::coarsest::CoarsestFactor;
use super::roughness::Roughness;
use super::single::Single;

/// One level of a hierarchy.
#[derive(Clone, Debug)]
pub(crate) struct Level<const D: usize> {
    pub lattice: Lattice,
    pub matrix: BlockMatrix<D>,
    /// From the next coarser level; none on the coarsest.
    pub interpolation: Option<Interpolation>,
}

/// Numbers of a cycle by levels, whose blocks have as many rows as fill a register.
#[derive(Clone, Debug)]
pub(crate) enum Cycle<const D: usize> {
    /// One equation a node.
    One(Vec<Single<D, 1>>),
    /// Two.
    Two(Vec<Single<D, 2>>),
    /// Three or four.
    Four(Vec<Single<D, 4>>),
}

impl<const D: usize> Cycle<D> {
    pub(crate) fn zeros(levels: &[Level<D>]) -> Self {
        fn of<const D: usize, const L: usize>(levels: &[Level<D>]) -> Vec<Single<D, L>> {
            levels.iter().map(|level| Single::zeros(&level.matrix)).collect()
        }
        match D {
            1 => Self::One(of(levels)),
            2 => Self::Two(of(levels)),
            _ => Self::Four(of(levels)),
        }
    }

    /// Bytes of a level with so many blocks and rows.
    pub(crate) fn bytes(blocks: usize, rows: usize) -> usize {
        match D {
            1 => Single::<D, 1>::bytes(blocks, rows),
            2 => Single::<D, 2>::bytes(blocks, rows),
            _ => Single::<D, 4>::bytes(blocks, rows),
        }
    }

    /// Takes the values of a level's matrix times a power of two.
    ///
    /// # Errors
    /// The first row whose numbers are beyond single precision.
    pub(crate) fn take(&mut self, levels: &[Level<D>], level: usize, scale: f64) -> Result<(), usize> {
        let matrix = &levels[level].matrix;
        match self {
            Self::One(single) => single[level].take(matrix, scale),
            Self::Two(single) => single[level].take(matrix, scale),
            Self::Four(single) => single[level].take(matrix, scale),
        }
    }

    /// `z ≈ A⁻¹ r` with the `scale` of [`Self::take`]; `size` is the norm of r.
    pub(crate) fn apply(&mut self, of: &Hierarchy<'_, D>, (r, size): (&[Vector<D>], f64), z: &mut [Vector<D>]) {
        match self {
            Self::One(single) => of.apply(single, r, size, z),
            Self::Two(single) => of.apply(single, r, size, z),
            Self::Four(single) => of.apply(single, r, size, z),
        }
    }
}

/// What a cycle needs besides its own numbers.
pub(crate) struct Hierarchy<'a, const D: usize> {
    pub levels: &'a [Level<D>],
    pub coarsest: &'a CoarsestFactor,
    /// Of the finest level, where it is of splines.
    pub roughness: Option<&'a Roughness<D>>,
    /// Power of two by which matrices were multiplied.
    pub scale: f64,
}

impl<const D: usize> Hierarchy<'_, D> {
    fn apply<const L: usize>(
        &self,
        single: &mut [Single<D, L>],
        r: &[Vector<D>],
        size: f64,
        z: &mut [Vector<D>],
    ) {
        // The residual is brought near 1 before it is rounded.
        let up = power_of_two_near(size.recip());
        for_each_node(&mut single[0].b, |node, b| {
            for (b, r) in b.iter_mut().zip(r[node].iter()) {
                *b = (r * up) as f32;
            }
        });
        self.cycle(0, single);
        let (x, down) = (&single[0].x, self.scale / up);
        for_each_node(z, |node, z| {
            for (z, x) in z.iter_mut().zip(&x[node]) {
                *z = f64::from(*x) * down;
            }
        });
    }

    /// `x ≈ A⁻¹ b` of one level.
    fn cycle<const L: usize>(&self, level: usize, single: &mut [Single<D, L>]) {
        let Level { lattice, matrix, interpolation } = &self.levels[level];
        let (here, coarser) = single.split_at_mut(1);
        let here = &mut here[0];
        let Some(interpolation) = interpolation else {
            return self.coarsest.solve::<D, L>(self.scale, &here.b, &mut here.x);
        };
        here.sweep_from_zero(matrix, &lattice.strips);
        here.residual_after_sweep(matrix);
        coarser[0].restrict(here, &interpolation.children);
        self.cycle(level + 1, coarser);
        if let Some(roughness) = self.roughness.filter(|_| level == 0) {
            roughness.correct(here);
        }
        here.correct(&coarser[0], &interpolation.parents);
        here.sweep_back(matrix, &lattice.strips);
    }
}

/// A power of two near a positive number; 1 for others.
pub(crate) fn power_of_two_near(number: f64) -> f64 {
    if number.is_normal() && number > 0.0 { number.log2().round().clamp(-1000.0, 1000.0).exp2() } else { 1.0 }
}
