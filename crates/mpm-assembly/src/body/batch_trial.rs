//! The state of the points of a batch under a trial displacement: kinematics, law, stresses, and moduli, four points at a time.

use crate::body::batch::{Batch, Entries};
use crate::body::batch_law::BatchLaw;
use crate::body::kinematics::{inverse_of, trial_excess};
use crate::body::points::Points;
use crate::body::trial::{InadmissiblePoint, step_of};
use mpm_material::lanes::{LANES, Lanes, Number, four};
use mpm_material::{PrincipalTrial, SymmetricTensor};

/// Four points under steps that are all admissible.
pub(crate) struct Tried<const D: usize> {
    /// Columns of its inverse.
    pub inverse: [[Lanes; D]; D],
    /// `ΔF_θθ`; 1 where there is no hoop.
    pub stretch: Lanes,
    /// `det ΔF`.
    pub determinant: Lanes,
    /// `b_tr - I`.
    pub excess: SymmetricTensor<Lanes>,
}

impl<const D: usize> Tried<D> {
    /// Of the columns of `ΔF - I`, the steps of the hoops, and `b_e - I` before; none where a step is not admissible.
    #[inline(always)]
    pub fn of<const HOOP: bool>(
        (h, hoop): ([[Lanes; D]; D], Lanes),
        before: &SymmetricTensor<Lanes>,
    ) -> Option<Self> {
        let one = Lanes::of(1.0);
        let mut step = h;
        for (i, column) in step.iter_mut().enumerate() {
            column[i] = one + column[i];
        }
        let (inverse, mut determinant) = inverse_of(&step);
        let is_good = |x: Lanes| x.above(Lanes::ZERO) & x.below(Lanes::of(f64::INFINITY));
        let mut are_good = is_good(determinant);
        let stretch = one + hoop;
        if HOOP {
            are_good = are_good & is_good(stretch);
        }
        if HOOP && D == 2 {
            determinant = determinant * stretch;
        }
        let excess = trial_excess::<Lanes, D, HOOP>(&h, hoop, before);
        Lanes::all(are_good).then_some(Self { inverse, stretch, determinant, excess })
    }

    /// Principal axes and strains; none where z is a principal direction of some of the points only.
    #[inline(always)]
    pub fn principal(&self) -> Option<PrincipalTrial<Lanes>> {
        // In the plane it is that of all, which the compiler then knows.
        if D == 2 {
            Some(PrincipalTrial::in_plane(&self.excess))
        } else {
            PrincipalTrial::of_four(&self.excess)
        }
    }
}

/// Elastic states of four points side by side.
#[inline(always)]
pub(crate) fn side_by_side([a, b, c, d]: [&SymmetricTensor; LANES]) -> SymmetricTensor<Lanes> {
    SymmetricTensor {
        xx: Lanes([a.xx, b.xx, c.xx, d.xx]),
        yy: Lanes([a.yy, b.yy, c.yy, d.yy]),
        zz: Lanes([a.zz, b.zz, c.zz, d.zz]),
        xy: Lanes([a.xy, b.xy, c.xy, d.xy]),
        yz: Lanes([a.yz, b.yz, c.yz, d.yz]),
        zx: Lanes([a.zx, b.zx, c.zx, d.zx]),
    }
}

/// A law and the points that it is asked for.
pub(crate) struct Question<'a, const D: usize> {
    pub law: &'a dyn BatchLaw,
    pub points: &'a Points<D>,
    /// Numbers of the points of the batch.
    pub numbers: &'a [usize],
}

impl<const D: usize> Question<'_, D> {
    /// Works out the state of all points, which have been [measured](crate::body::batch::Steps::measure); returns the smallest `det ΔF`.
    ///
    /// # Errors
    /// The first point (in order) that has no admissible state.
    #[inline(always)]
    pub fn answer<const HOOP: bool, const MODULI: bool>(
        &self,
        batch: &mut Batch<D>,
    ) -> Result<f64, InadmissiblePoint> {
        let n = self.numbers.len();
        let mut smallest = f64::INFINITY;
        for first in (0..n).step_by(LANES) {
            let count = LANES.min(n - first);
            let at = four(|lane| first + lane.min(count - 1));
            let determinants = match self.four::<HOOP, MODULI>(batch, at, count)? {
                Some(determinants) => determinants,
                None => self.apart::<HOOP, MODULI>(batch, first, count)?,
            };
            smallest = determinants.0.into_iter().fold(smallest, f64::min);
        }
        Ok(smallest)
    }

    /// Works out the states of the first `count` of the points at four places; none where they have to be taken apart.
    #[inline(always)]
    fn four<const HOOP: bool, const MODULI: bool>(
        &self,
        batch: &mut Batch<D>,
        at: [usize; LANES],
        count: usize,
    ) -> Result<Option<Lanes>, InadmissiblePoint> {
        let numbers = four(|lane| self.numbers[at[lane]]);
        let before = side_by_side(four(|lane| &self.points.elastic_excess[numbers[lane]]));
        let Some(tried) = Tried::of::<HOOP>(batch.steps.four_steps(at), &before) else { return Ok(None) };
        let Some(trial) = tried.principal() else { return Ok(None) };
        let others = (Lanes(four(|lane| self.points.reference_volume[numbers[lane]])), tried.stretch);
        let strain = trial.strain;
        if MODULI {
            let update = self.law.update(&numbers, &strain)?;
            let entries = Entries::of(&tried.inverse, &trial.stress(&update.kirchhoff), others);
            batch.keep_entries::<HOOP, true>((at[0], count), &entries);
            batch.keep_moduli::<HOOP>((at[0], count), &trial.tangent(&update));
        } else {
            let stresses = self.law.stresses(&numbers, &strain)?;
            let entries = Entries::of(&tried.inverse, &trial.stress(&stresses), others);
            batch.keep_entries::<HOOP, false>((at[0], count), &entries);
        }
        Ok(Some(tried.determinant))
    }

    /// As [`Self::four`], of points that are taken one after the other, each in all lanes.
    #[cold]
    #[inline(never)]
    fn apart<const HOOP: bool, const MODULI: bool>(
        &self,
        batch: &mut Batch<D>,
        first: usize,
        count: usize,
    ) -> Result<Lanes, InadmissiblePoint> {
        let mut determinants = Lanes::of(f64::INFINITY);
        for lane in 0..count {
            let at = first + lane;
            step_of::<D, HOOP>(self.numbers[at], &batch.steps.step(at))?;
            let answered = self.four::<HOOP, MODULI>(batch, [at; LANES], 1)?;
            determinants.0[lane] = answered.expect("four times the same admissible point is of one kind").0[0];
        }
        Ok(determinants)
    }
}
