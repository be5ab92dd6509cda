//! The state of the points of a batch under a trial displacement: kinematics, law, stresses, and moduli, four points at a time.

use crate::body::batch::{Batch, Four, Tried, entries};
use crate::body::batch_law::BatchLaw;
use crate::body::kinematics::{inverse_of, trial_excess};
use crate::body::points::Points;
use crate::body::trial::{InadmissiblePoint, step_of};
use mpm_material::lanes::{LANES, Lanes, Number, Work, four, vectorised};
use mpm_material::{PrincipalTrial, SymmetricTensor};

/// Works out the state of all points, which have been [measured](Batch::measure); returns the smallest `det ΔF`.
///
/// # Errors
/// The first point (in order) that has no admissible state.
pub(crate) fn answer<const D: usize, const HOOP: bool>(
    law: &dyn BatchLaw,
    points: &Points<D>,
    batch: &mut Batch<D>,
    wants_moduli: bool,
) -> Result<f64, InadmissiblePoint> {
    let (smallest, refused) = vectorised(Trying::<D, HOOP> { points, batch: &mut *batch });
    let Batch { fours, updates, .. } = &mut *batch;
    law.update(fours, updates)?;
    if let Some(refused) = refused {
        return Err(refused);
    }
    vectorised(Keeping::<D, HOOP> { points, batch, wants_moduli });
    Ok(smallest)
}

/// Tries the steps of all points; with the smallest `det ΔF` it returns the first point that has no admissible step, behind
/// which none is tried.
struct Trying<'a, const D: usize, const HOOP: bool> {
    points: &'a Points<D>,
    batch: &'a mut Batch<D>,
}

impl<const D: usize, const HOOP: bool> Work for Trying<'_, D, HOOP> {
    type Output = (f64, Option<InadmissiblePoint>);

    #[inline(always)]
    fn run(mut self) -> Self::Output {
        self.batch.fours.clear();
        self.batch.tried.clear();
        let mut smallest = f64::INFINITY;
        let (mut first, mut end, mut refused) = (0, self.batch.len(), None);
        while first < end {
            let count = LANES.min(end - first);
            match self.four(first, count) {
                Some(determinants) => {
                    smallest = determinants.0.into_iter().fold(smallest, f64::min);
                    first += count;
                }
                None => {
                    let (at, reason) = first_refused::<D, HOOP>(self.batch, first, count);
                    (end, refused) = (at, Some(reason));
                }
            }
        }
        (smallest, refused)
    }
}

/// The first point whose step is not admissible, of some that are not all admissible: its place and why.
#[cold]
#[inline(never)]
fn first_refused<const D: usize, const HOOP: bool>(
    batch: &Batch<D>,
    first: usize,
    count: usize,
) -> (usize, InadmissiblePoint) {
    let reason = |at: usize| step_of::<D, HOOP>(batch.points[at], &batch.step(at)).err();
    let found = (first..first + count).find_map(|at| Some((at, reason(at)?)));
    found.expect("a step is refused alone as it is beside others")
}

impl<const D: usize, const HOOP: bool> Trying<'_, D, HOOP> {
    /// Tries `count` points from a place on; none where one of them has no admissible step.
    #[inline(always)]
    fn four(&mut self, first: usize, count: usize) -> Option<Lanes> {
        let at = four(|lane| first + lane.min(count - 1));
        let (h, hoop) = self.batch.four_steps(at);
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
        if !Lanes::all(are_good) {
            return None;
        }
        let points = four(|lane| self.batch.points[at[lane]]);
        let [a, b, c, d] = four(|lane| &self.points.elastic_excess[points[lane]]);
        let before = SymmetricTensor {
            xx: Lanes([a.xx, b.xx, c.xx, d.xx]),
            yy: Lanes([a.yy, b.yy, c.yy, d.yy]),
            zz: Lanes([a.zz, b.zz, c.zz, d.zz]),
            xy: Lanes([a.xy, b.xy, c.xy, d.xy]),
            yz: Lanes([a.yz, b.yz, c.yz, d.yz]),
            zx: Lanes([a.zx, b.zx, c.zx, d.zx]),
        };
        let excess = trial_excess::<Lanes, D, HOOP>(&h, hoop, &before);
        if let Some(trial) = PrincipalTrial::of_four(&excess) {
            self.batch.fours.push(Four { first, count, points, strain: trial.strain });
            self.batch.tried.push(Tried { inverse, hoop: stretch, trial });
        } else {
            self.apart((first, count), &points, &Apart { inverse, hoop: stretch, excess });
        }
        Some(determinant)
    }

    /// Takes four points apart, each of which is then in all lanes.
    #[cold]
    #[inline(never)]
    fn apart(&mut self, (first, count): (usize, usize), points: &[usize; LANES], of: &Apart<D>) {
        for lane in 0..count {
            let alone = |x: Lanes| Lanes::of(x.0[lane]);
            let SymmetricTensor { xx, yy, zz, xy, yz, zx } = of.excess;
            let [xx, yy, zz, xy, yz, zx] = [xx, yy, zz, xy, yz, zx].map(alone);
            let trial = PrincipalTrial::of_four(&SymmetricTensor { xx, yy, zz, xy, yz, zx });
            let trial = trial.expect("four times the same point is of one kind");
            let points = [points[lane]; LANES];
            self.batch.fours.push(Four { first: first + lane, count: 1, points, strain: trial.strain });
            let inverse = of.inverse.map(|column| column.map(alone));
            self.batch.tried.push(Tried { inverse, hoop: alone(of.hoop), trial });
        }
    }
}

/// Four points before they are taken apart.
struct Apart<const D: usize> {
    inverse: [[Lanes; D]; D],
    hoop: Lanes,
    excess: SymmetricTensor<Lanes>,
}

/// Keeps what the sums need of every point.
struct Keeping<'a, const D: usize, const HOOP: bool> {
    points: &'a Points<D>,
    batch: &'a mut Batch<D>,
    wants_moduli: bool,
}

impl<const D: usize, const HOOP: bool> Work for Keeping<'_, D, HOOP> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { points, batch, wants_moduli } = self;
        for k in 0..batch.fours.len() {
            let Four { first, count, points: of, .. } = batch.fours[k];
            let Tried { inverse, hoop, trial } = batch.tried[k];
            let update = batch.updates[k];
            let volume = Lanes(four(|lane| points.reference_volume[of[lane]]));
            let entries = entries(&inverse, &trial.kirchhoff(&update), (volume, hoop));
            batch.keep_entries((first, count), &entries);
            if wants_moduli {
                batch.keep_moduli::<HOOP>((first, count), &trial.tangent(&update));
            }
        }
    }
}
