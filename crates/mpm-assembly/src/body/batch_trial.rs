//! The state of the points of a batch under a trial displacement: kinematics, law, stresses, and moduli, four points at a time.

use crate::body::batch::{Answers, BATCH, Entries};
use crate::body::batch_law::{BatchLaw, Strained};
use crate::body::batch_steps::Steps;
use crate::body::kinematics::{inverse_of, trial_excess};
use crate::body::points::Points;
use crate::body::trial::{InadmissiblePoint, step_of};
use mpm_material::lanes::{LANES, Lanes, Number, Work, four, vectorised};
use mpm_material::{PrincipalTrial, PrincipalUpdate, SymmetricTensor};

/// Four points under steps that are all admissible.
#[derive(Clone, Debug)]
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

/// Four points of a batch before their law is asked, or fewer that stand in several lanes.
#[derive(Clone, Debug)]
pub(crate) struct Four<const D: usize> {
    /// Place of the first in the batch.
    pub place: usize,
    pub tried: Tried<D>,
    /// Whether z is a principal direction.
    is_plane: bool,
    pub trial: PrincipalTrial<Lanes>,
}

/// The points of a batch whose law can be asked, four at a time.
#[derive(Debug)]
pub(crate) struct Asked<const D: usize> {
    /// What the law is asked, with room for a batch whose points all stand alone.
    strained: Vec<Strained>,
    fours: Vec<Four<D>>,
    n: usize,
    /// The smallest `det ΔF`.
    pub smallest: f64,
}

impl<const D: usize> Asked<D> {
    pub fn new() -> Self {
        let tried = Tried {
            inverse: [[Lanes::ZERO; D]; D],
            stretch: Lanes::ZERO,
            determinant: Lanes::ZERO,
            excess: SymmetricTensor::default(),
        };
        let four = Four { place: 0, is_plane: true, trial: PrincipalTrial::in_plane(&tried.excess), tried };
        Self { strained: vec![Strained::NONE; BATCH], fours: vec![four; BATCH], n: 0, smallest: f64::INFINITY }
    }

    /// What the law is asked.
    pub fn strained(&self) -> &[Strained] {
        &self.strained[..self.n]
    }

    /// The points, as many as [`Self::strained`].
    pub fn fours(&self) -> &[Four<D>] {
        &self.fours[..self.n]
    }

    /// Works out kinematics and principal axes of all points, which have been [measured](Steps::measure).
    ///
    /// # Errors
    /// The first point (in order) that has no admissible step; the law can be [asked](Self::strained) for those before it.
    pub fn collect<const HOOP: bool>(
        &mut self,
        steps: &Steps<D>,
        points: &Points<D>,
        numbers: &[usize],
    ) -> Result<(), InadmissiblePoint> {
        (self.n, self.smallest) = (0, f64::INFINITY);
        // Works of their own, so that passes share their code.
        let tried = vectorised(Trying::<D, HOOP> { asked: self, steps, points, numbers });
        vectorised(FindingAxes(self));
        tried
    }

    #[inline(always)]
    fn try_all<const HOOP: bool>(
        &mut self,
        steps: &Steps<D>,
        points: &Points<D>,
        numbers: &[usize],
    ) -> Result<(), InadmissiblePoint> {
        for first in (0..numbers.len()).step_by(LANES) {
            let count = LANES.min(numbers.len() - first);
            let places = four(|lane| first + lane.min(count - 1));
            if !self.push::<HOOP>(steps, points, numbers, (places, count)) {
                self.apart::<HOOP>(steps, points, numbers, (first, count))?;
            }
        }
        Ok(())
    }

    /// Takes on the first `count` of the points at four places; not where they have to be taken apart.
    #[inline(always)]
    fn push<const HOOP: bool>(
        &mut self,
        steps: &Steps<D>,
        points: &Points<D>,
        numbers: &[usize],
        (places, count): ([usize; LANES], usize),
    ) -> bool {
        let numbers = four(|lane| numbers[places[lane]]);
        let before = side_by_side(four(|lane| &points.elastic_excess[numbers[lane]]));
        let Some(tried) = Tried::of::<HOOP>(steps.four_steps(places), &before) else { return false };
        // In the plane it is one of all, which the compiler then knows.
        let Some(is_plane) = (if D == 2 { Some(true) } else { PrincipalTrial::is_plane(&tried.excess) }) else {
            return false;
        };
        self.smallest = tried.determinant.0.into_iter().fold(self.smallest, f64::min);
        let strained = &mut self.strained[self.n];
        (strained.numbers, strained.count) = (numbers, count);
        let four = &mut self.fours[self.n];
        (four.place, four.tried, four.is_plane) = (places[0], tried, is_plane);
        self.n += 1;
        true
    }

    /// Works out principal axes and strains of all points that have been tried.
    #[inline(always)]
    fn find_axes(&mut self) {
        let mut at = 0;
        loop {
            match &mut self.fours[at..self.n] {
                [] => break,
                [first, ..] if D == 2 || first.is_plane => {
                    first.trial = PrincipalTrial::in_plane(&first.tried.excess);
                    at += 1;
                }
                [first, second, ..] if !second.is_plane => {
                    let excesses = [&first.tried.excess, &second.tried.excess];
                    [first.trial, second.trial] = PrincipalTrial::in_space(excesses);
                    at += 2;
                }
                [first, ..] => {
                    [first.trial] = PrincipalTrial::in_space([&first.tried.excess]);
                    at += 1;
                }
            }
        }
        for (strained, four) in self.strained.iter_mut().zip(&self.fours[..self.n]) {
            strained.strain = four.trial.strain;
        }
    }

    /// As [`Self::push`], of points that are taken one after the other, each in all lanes.
    #[cold]
    #[inline(never)]
    fn apart<const HOOP: bool>(
        &mut self,
        steps: &Steps<D>,
        points: &Points<D>,
        numbers: &[usize],
        (first, count): (usize, usize),
    ) -> Result<(), InadmissiblePoint> {
        for place in first..first + count {
            step_of::<D, HOOP>(numbers[place], &steps.step(place))?;
            let is_taken = self.push::<HOOP>(steps, points, numbers, ([place; LANES], 1));
            assert!(is_taken, "four times the same admissible point is of one kind");
        }
        Ok(())
    }
}

/// Works out the kinematics of all points of a batch.
struct Trying<'a, const D: usize, const HOOP: bool> {
    asked: &'a mut Asked<D>,
    steps: &'a Steps<D>,
    points: &'a Points<D>,
    numbers: &'a [usize],
}

impl<const D: usize, const HOOP: bool> Work for Trying<'_, D, HOOP> {
    type Output = Result<(), InadmissiblePoint>;

    #[inline(always)]
    fn run<const VECTORS: bool>(self) -> Self::Output {
        self.asked.try_all::<HOOP>(self.steps, self.points, self.numbers)
    }
}

/// Works out principal axes and strains of all points that have been tried.
struct FindingAxes<'a, const D: usize>(&'a mut Asked<D>);

impl<const D: usize> Work for FindingAxes<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<const VECTORS: bool>(self) {
        self.0.find_axes();
    }
}

/// What is known of the points of a batch, from their steps to what sums need.
#[derive(Debug)]
pub(crate) struct Batch<const D: usize> {
    pub steps: Steps<D>,
    pub asked: Asked<D>,
    /// Answers of the law to what it is [asked](Asked::strained).
    pub updates: Vec<PrincipalUpdate<Lanes>>,
    pub answers: Answers<D>,
}

impl<const D: usize> Batch<D> {
    /// For sets of up to `most_nodes` nodes.
    pub fn new(most_nodes: usize) -> Self {
        Self {
            steps: Steps::new(most_nodes),
            asked: Asked::new(),
            updates: vec![PrincipalUpdate::default(); BATCH],
            answers: Answers::new(),
        }
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
    /// Works out the state of all points, which have been [measured](Steps::measure); returns the smallest `det ΔF`.
    ///
    /// # Errors
    /// The first point (in order) that has no admissible state.
    pub fn answer<const HOOP: bool, const MODULI: bool>(
        &self,
        batch: &mut Batch<D>,
    ) -> Result<f64, InadmissiblePoint> {
        let collected = batch.asked.collect::<HOOP>(&batch.steps, self.points, self.numbers);
        // A point that its law refuses may stand before one that has no step.
        let n = batch.asked.strained().len();
        let updates = &mut batch.updates[..n];
        if MODULI {
            self.law.update(batch.asked.strained(), updates)?;
        } else {
            self.law.stresses(batch.asked.strained(), updates)?;
        }
        collected?;
        let Batch { asked, updates, answers, .. } = batch;
        let Self { points, .. } = *self;
        vectorised(Keeping::<D, HOOP, MODULI> { asked, updates, points, answers });
        Ok(asked.smallest)
    }
}

/// Keeps what sums need of the points of a batch.
struct Keeping<'a, const D: usize, const HOOP: bool, const MODULI: bool> {
    asked: &'a Asked<D>,
    updates: &'a [PrincipalUpdate<Lanes>],
    points: &'a Points<D>,
    answers: &'a mut Answers<D>,
}

impl<const D: usize, const HOOP: bool, const MODULI: bool> Work for Keeping<'_, D, HOOP, MODULI> {
    type Output = ();

    #[inline(always)]
    fn run<const VECTORS: bool>(self) {
        let Self { asked, updates, points, answers } = self;
        for ((strained, four), update) in asked.strained().iter().zip(asked.fours()).zip(updates) {
            let volume = Lanes(strained.numbers.map(|p| points.reference_volume[p]));
            let stress = four.trial.stress(&update.kirchhoff);
            let entries = Entries::of(&four.tried.inverse, &stress, (volume, four.tried.stretch));
            let places = (four.place, strained.count);
            answers.keep_entries::<HOOP, MODULI>(places, &entries);
            if MODULI {
                answers.keep_moduli::<HOOP>(places, &four.trial.tangent(update));
            }
        }
    }
}
