//! How the load fraction goes from 0 to 1: equal steps, halved where one does not converge.

use crate::model::Schedule;
use crate::state::ControlProgress;
use mpm_grid::LoadFraction;

/// One load step to be tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Load fraction at its start.
    pub start: LoadFraction,
    /// Load fraction at its end.
    pub end: LoadFraction,
    /// Nominal step that it is (a part of), from 1.
    pub nominal: u32,
    /// Times that the nominal step is halved.
    pub level: u8,
}

/// Walks through the load steps.
///
/// A nominal step may be halved up to [`Schedule::cuts`] times. After a success the next step is
/// twice as long where it can be, so that every nominal step ends exactly where it would have.
#[derive(Clone, Debug)]
pub struct Pace {
    schedule: Schedule,
    /// Nominal steps completed.
    done: u32,
    /// Position inside the present nominal step, in units of its smallest part.
    position: u64,
    level: u8,
    cuts: u64,
}

impl Pace {
    /// At the start.
    pub fn new(schedule: Schedule) -> Self {
        Self { schedule, done: 0, position: 0, level: 0, cuts: 0 }
    }

    fn parts(&self) -> u64 {
        1 << self.schedule.cuts
    }

    /// Load fraction at `position` of the present nominal step.
    fn fraction(&self, position: u64) -> LoadFraction {
        let steps = f64::from(self.schedule.steps);
        let inside = position as f64 / self.parts() as f64;
        let fraction = (f64::from(self.done) + inside) / steps;
        LoadFraction::new(fraction.min(1.0)).expect("between 0 and 1")
    }

    /// The next step to try; `None` at the end.
    pub fn next(&self) -> Option<Step> {
        (self.done < self.schedule.steps).then(|| Step {
            start: self.fraction(self.position),
            end: self.fraction(self.position + (self.parts() >> self.level)),
            nominal: self.done + 1,
            level: self.level,
        })
    }

    /// The step converged.
    pub fn succeed(&mut self) {
        self.position += self.parts() >> self.level;
        if self.position == self.parts() {
            self.position = 0;
            self.done += 1;
        }
        // Grow where the longer step starts on its own raster.
        if self.level > 0 && self.position.is_multiple_of(self.parts() >> (self.level - 1)) {
            self.level -= 1;
        }
    }

    /// Whether the step may not be halved again.
    pub fn is_at_floor(&self) -> bool {
        self.level == self.schedule.cuts
    }

    /// The step did not converge: halve it. `false` where it may not be halved again.
    pub fn cut(&mut self) -> bool {
        if self.is_at_floor() {
            return false;
        }
        self.level += 1;
        self.cuts += 1;
        true
    }

    /// Load fraction reached.
    pub fn at(&self) -> LoadFraction {
        self.fraction(self.position)
    }

    /// With the change of the load fraction in the last step, where the next one is guessed from it.
    pub(crate) fn store(&self, last: Option<f64>) -> ControlProgress {
        let Self { done, position, level, cuts, .. } = *self;
        ControlProgress::Load { done, position, level, cuts, last }
    }

    /// Where a walk through these steps can have come to.
    ///
    /// # Errors
    /// What cannot be.
    pub(crate) fn recall(schedule: Schedule, progress: &ControlProgress) -> Result<Self, String> {
        let &ControlProgress::Load { done, position, level, cuts, last } = progress else {
            return Err("is that of path control, expected equal load steps".into());
        };
        let pace = Self { schedule, done, position, level, cuts };
        if done > schedule.steps || (done == schedule.steps && position > 0) {
            return Err(format!("has {done} nominal steps done, expected at most {}", schedule.steps));
        }
        if level > schedule.cuts {
            return Err(format!("has halved a step {level} times, expected at most {}", schedule.cuts));
        }
        if let Some(wrong) = last.filter(|it| !(*it > 0.0 && *it <= 1.0)) {
            return Err(format!("has a last step over {wrong} of the load, expected above 0 to 1"));
        }
        if position >= pace.parts() || !position.is_multiple_of(pace.parts() >> level) {
            return Err(format!(
                "stands at part {position} of a step halved {level} times, of {}",
                pace.parts()
            ));
        }
        Ok(pace)
    }

    /// Cuts so far.
    pub fn cuts(&self) -> u64 {
        self.cuts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_steps_end_on_their_stations() {
        let mut pace = Pace::new(Schedule { cuts: 4, ..Schedule::equal(3) });
        let mut ends = Vec::new();
        while let Some(step) = pace.next() {
            ends.push(step.end.get());
            pace.succeed();
        }
        assert_eq!(ends, [1.0 / 3.0, 2.0 / 3.0, 1.0]);
    }

    #[test]
    fn a_cut_step_grows_again_and_meets_every_station() {
        let mut pace = Pace::new(Schedule { cuts: 3, ..Schedule::equal(2) });
        assert!(pace.cut() && pace.cut());
        let mut ends = Vec::new();
        while let Some(step) = pace.next() {
            ends.push(step.end.get());
            pace.succeed();
        }
        // A quarter, a quarter, then a half of the first step, and the whole second.
        assert_eq!(ends, [0.125, 0.25, 0.5, 1.0]);
        assert_eq!(pace.cuts(), 2);
    }

    #[test]
    fn the_floor_is_reached_after_the_stated_cuts() {
        let mut pace = Pace::new(Schedule { cuts: 2, ..Schedule::equal(1) });
        assert!(pace.cut() && pace.cut() && !pace.cut());
        assert_eq!(pace.next().unwrap().end.get(), 0.25);
    }
}
