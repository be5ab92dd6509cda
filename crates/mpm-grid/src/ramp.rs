//! Load fractions, and quantities that follow them: motions, supports, loads.

/// Pseudo-time of a quasi-static run: a stage of its schedule, counted from 0, and the part of that stage that has
/// passed, in [0, 1].
///
/// Everything that follows the load is a function of it: ramps, motions of the mesh, forces. The end of a stage and the
/// start of the next are two load fractions: a force may change between them; what moves is at both in the same place.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct LoadFraction {
    stage: u32,
    value: f64,
}

impl LoadFraction {
    /// The start of the first stage: nothing applied.
    pub const START: Self = Self { stage: 0, value: 0.0 };
    /// The end of the first stage; of a run without others, everything applied.
    pub const END: Self = Self { stage: 0, value: 1.0 };

    /// The fraction `value` of the first stage; an error outside [0, 1] and for NaN.
    pub fn new(value: f64) -> Result<Self, RampError> {
        Self::in_stage(0, value)
    }

    /// The fraction `value` of a stage; an error outside [0, 1] and for NaN.
    pub fn in_stage(stage: u32, value: f64) -> Result<Self, RampError> {
        if (0.0..=1.0).contains(&value) {
            Ok(Self { stage, value })
        } else {
            Err(RampError::Fraction { value })
        }
    }

    /// The start of a stage.
    pub const fn start_of(stage: u32) -> Self {
        Self { stage, value: 0.0 }
    }

    /// The end of a stage.
    pub const fn end_of(stage: u32) -> Self {
        Self { stage, value: 1.0 }
    }

    /// The fraction of the same stage nearest to `value`.
    ///
    /// # Panics
    /// If `value` is NaN.
    pub fn with_value(self, value: f64) -> Self {
        Self::in_stage(self.stage, value.clamp(0.0, 1.0)).expect("no number is nearest to NaN")
    }

    /// The load fraction with this [`Self::total`]; where one stage ends and another begins, the end. An error below 0, for
    /// infinity and for NaN.
    pub fn of_total(total: f64) -> Result<Self, RampError> {
        if !(0.0..=f64::from(u32::MAX)).contains(&total) {
            return Err(RampError::Fraction { value: total });
        }
        let stage = (total.ceil() - 1.0).max(0.0);
        Self::in_stage(stage as u32, total - stage)
    }

    /// The part of the stage that has passed, in [0, 1].
    #[inline]
    pub fn get(self) -> f64 {
        self.value
    }

    /// The stage, from 0.
    #[inline]
    pub fn stage(self) -> u32 {
        self.stage
    }

    /// The load fraction as results have it, which count stages: 1.25 is a quarter of the second one.
    #[inline]
    pub fn total(self) -> f64 {
        f64::from(self.stage) + self.value
    }

    /// What has been reached: at the start of a stage, the end of the one before; itself at any other load fraction.
    pub fn reached(self) -> Self {
        if self.value == 0.0 && self.stage > 0 { Self::end_of(self.stage - 1) } else { self }
    }
}

/// What a load fraction or a ramp cannot be made of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RampError {
    /// A load fraction outside [0, 1].
    #[error("load fraction {value} is not in [0, 1]")]
    Fraction {
        /// The offending number.
        value: f64,
    },
    /// A ramp without knots.
    #[error("a ramp needs at least one knot")]
    Empty,
    /// A knot whose value is infinite or not a number.
    #[error("value {value} at load fraction {fraction} is not finite")]
    Value {
        /// Load fraction of the knot.
        fraction: f64,
        /// Its value.
        value: f64,
    },
    /// Two neighbouring knots out of order.
    #[error("knots must increase strictly: fraction {next} follows {previous}")]
    Order {
        /// The earlier knot's fraction.
        previous: f64,
        /// The later knot's fraction.
        next: f64,
    },
    /// Two pieces of a ramp whose stages are out of order.
    #[error("stages must increase: stage {} follows stage {}", next + 1, previous + 1)]
    Stages {
        /// Stage of the earlier piece, from 0.
        previous: u32,
        /// Stage of the later one.
        next: u32,
    },
}

/// A value against the load fraction: in some stages piecewise linear, and constant before the first and after the last
/// knot; in the stages after one of these what it was at its end; before the first of them 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// Ascending in the stage.
    pieces: Vec<Piece>,
}

/// The values of a ramp in one stage.
#[derive(Clone, Debug, PartialEq)]
struct Piece {
    stage: u32,
    /// (fraction, value); at least one.
    knots: Vec<(f64, f64)>,
}

impl Piece {
    fn new(stage: u32, knots: Vec<(f64, f64)>) -> Result<Self, RampError> {
        if knots.is_empty() {
            return Err(RampError::Empty);
        }
        for &(fraction, value) in &knots {
            LoadFraction::new(fraction)?;
            if !value.is_finite() {
                return Err(RampError::Value { fraction, value });
            }
        }
        for pair in knots.windows(2) {
            let (previous, next) = (pair[0].0, pair[1].0);
            if previous >= next {
                return Err(RampError::Order { previous, next });
            }
        }
        Ok(Self { stage, knots })
    }

    fn value(&self, f: f64) -> f64 {
        let above = self.knots.partition_point(|knot| knot.0 <= f);
        let (Some(&(f0, v0)), Some(&(f1, v1))) = (self.knots.get(above.wrapping_sub(1)), self.knots.get(above))
        else {
            return self.knots[above.saturating_sub(1)].1;
        };
        let t = (f - f0) / (f1 - f0);
        v0 * (1.0 - t) + v1 * t
    }
}

impl Ramp {
    /// The ramp through `knots` = (fraction, value) of the first stage, strictly increasing in the fraction, values finite.
    pub fn new(knots: Vec<(f64, f64)>) -> Result<Self, RampError> {
        Self::in_stage(0, knots)
    }

    /// As [`Self::new`], over another stage.
    pub fn in_stage(stage: u32, knots: Vec<(f64, f64)>) -> Result<Self, RampError> {
        Ok(Self { pieces: vec![Piece::new(stage, knots)?] })
    }

    /// The ramp through the knots of several stages, which increase. In each it goes on from where the stage before has
    /// left it, in the first from 0, unless the stage has a knot at fraction 0.
    pub fn of_stages(stages: impl IntoIterator<Item = (u32, Vec<(f64, f64)>)>) -> Result<Self, RampError> {
        let mut ramp = Self { pieces: Vec::new() };
        for (stage, mut knots) in stages {
            if let Some(last) = ramp.pieces.last().filter(|last| last.stage >= stage) {
                return Err(RampError::Stages { previous: last.stage, next: stage });
            }
            if knots.first().is_some_and(|knot| knot.0 > 0.0) {
                knots.insert(0, (0.0, ramp.value(LoadFraction::end_of(stage))));
            }
            ramp.pieces.push(Piece::new(stage, knots)?);
        }
        if ramp.pieces.is_empty() { Err(RampError::Empty) } else { Ok(ramp) }
    }

    /// The same up to the start of `stage`, in which it goes to 0: at once, or linearly by the end of the stage.
    pub fn released(mut self, stage: u32, at_once: bool) -> Self {
        self.pieces.retain(|piece| piece.stage < stage);
        let left = self.value(LoadFraction::start_of(stage));
        let knots = if at_once { vec![(0.0, 0.0)] } else { vec![(0.0, left), (1.0, 0.0)] };
        self.pieces.push(Piece { stage, knots });
        self
    }

    /// From nothing at fraction 0 to `end_value` at fraction 1 of the first stage.
    pub fn linear(end_value: f64) -> Self {
        Self { pieces: vec![Piece { stage: 0, knots: vec![(0.0, 0.0), (1.0, end_value)] }] }
    }

    /// The same `value` at every fraction.
    pub fn constant(value: f64) -> Self {
        Self { pieces: vec![Piece { stage: 0, knots: vec![(0.0, value)] }] }
    }

    /// The value at a load fraction; exactly the knot's value on a knot.
    pub fn value(&self, at: LoadFraction) -> f64 {
        let begun = self.pieces.partition_point(|piece| piece.stage <= at.stage);
        match self.pieces[..begun].last() {
            None => 0.0,
            Some(piece) if piece.stage == at.stage => piece.value(at.value),
            Some(piece) => piece.value(1.0),
        }
    }

    /// Whether what it prescribes is not at rest at the start of a stage: it jumps in the first load step of that stage.
    pub fn jumps_in(&self, stage: u32) -> bool {
        let start = LoadFraction::start_of(stage);
        self.value(start) != self.from_rest(start)
    }

    /// The value at a load fraction as that of something that moves: 0 at the very start, and at the start of another
    /// stage where the stage before has left it. A ramp that has other values there jumps in the first load step of the
    /// stage.
    pub fn from_rest(&self, at: LoadFraction) -> f64 {
        if at == LoadFraction::START { 0.0 } else { self.value(at.reached()) }
    }

    /// The knots (fraction, value), in the order of stages, and strictly increasing in the fraction of each.
    pub fn knots(&self) -> impl Iterator<Item = (LoadFraction, f64)> {
        self.pieces.iter().flat_map(|piece| {
            let at = |value| LoadFraction { stage: piece.stage, value };
            piece.knots.iter().map(move |&(value, knot)| (at(value), knot))
        })
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.knots().all(|knot| knot.1.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ramp: &Ramp, fraction: f64) -> f64 {
        ramp.value(LoadFraction::new(fraction).unwrap())
    }

    #[test]
    fn fractions_are_checked() {
        assert_eq!(LoadFraction::new(1.0).unwrap(), LoadFraction::END);
        for bad in [-1e-12, 1.0 + 1e-12, f64::NAN] {
            assert!(LoadFraction::new(bad).is_err());
        }
    }

    #[test]
    fn ramps_interpolate_and_hold() {
        let ramp = Ramp::new(vec![(0.25, 1.0), (0.5, 3.0), (0.75, -1.0)]).unwrap();
        let table = [(0.0, 1.0), (0.25, 1.0), (0.375, 2.0), (0.5, 3.0), (0.625, 1.0), (1.0, -1.0)];
        for (fraction, value) in table {
            assert_eq!(at(&ramp, fraction), value, "at {fraction}");
        }
        assert_eq!(at(&Ramp::linear(8.0), 0.3), 2.4);
        assert_eq!(at(&Ramp::constant(8.0), 0.3), 8.0);
        assert_eq!(ramp.from_rest(LoadFraction::START), 0.0);
        assert_eq!(ramp.from_rest(LoadFraction::new(0.25).unwrap()), 1.0);
    }

    #[test]
    fn bad_knots_are_refused() {
        assert_eq!(Ramp::new(vec![]), Err(RampError::Empty));
        let order = RampError::Order { previous: 0.5, next: 0.5 };
        assert_eq!(Ramp::new(vec![(0.5, 0.0), (0.5, 1.0)]), Err(order));
        assert_eq!(Ramp::new(vec![(1.5, 0.0)]), Err(RampError::Fraction { value: 1.5 }));
        assert!(Ramp::new(vec![(0.5, f64::NAN)]).is_err());
    }

    #[test]
    fn ramps_hold_what_the_stage_before_has_left() {
        let of_stage = |stage, value| LoadFraction::in_stage(stage, value).unwrap();
        let ramp = Ramp::of_stages([(1, vec![(0.5, 2.0), (1.0, 3.0)]), (3, vec![(1.0, 5.0)])]).unwrap();
        let table = [
            (0, 0.5, 0.0),
            (1, 0.0, 0.0),
            (1, 0.25, 1.0),
            (1, 1.0, 3.0),
            (2, 0.5, 3.0),
            (3, 0.0, 3.0),
            (3, 0.5, 4.0),
            (4, 0.1, 5.0),
        ];
        for (stage, value, expected) in table {
            assert_eq!(ramp.value(of_stage(stage, value)), expected, "in stage {stage} at {value}");
        }
        // A knot at fraction 0 may jump; what moves jumps in the first load step.
        let jumping = Ramp::of_stages([(0, vec![(1.0, 1.0)]), (1, vec![(0.0, 4.0)])]).unwrap();
        assert!(jumping.jumps_in(1) && !jumping.jumps_in(0) && !ramp.jumps_in(1) && !ramp.jumps_in(3));
        assert_eq!((jumping.value(of_stage(1, 0.0)), jumping.from_rest(of_stage(1, 0.0))), (4.0, 1.0));
        let ended = ramp.clone().released(2, false);
        assert_eq!(ended.value(of_stage(2, 0.25)), 2.25);
        assert_eq!(ended.value(of_stage(4, 0.5)), 0.0);
        assert_eq!(ramp.released(2, true).value(of_stage(2, 0.0)), 0.0);
        assert_eq!(
            Ramp::of_stages([(1, vec![(0.0, 1.0)]), (1, vec![(1.0, 0.0)])]),
            Err(RampError::Stages { previous: 1, next: 1 })
        );
    }

    #[test]
    fn load_fractions_count_stages() {
        let at = LoadFraction::in_stage(2, 0.25).unwrap();
        assert_eq!((at.total(), LoadFraction::of_total(2.25).unwrap()), (2.25, at));
        assert_eq!(LoadFraction::of_total(2.0).unwrap(), LoadFraction::end_of(1));
        assert_eq!(LoadFraction::start_of(2).reached(), LoadFraction::end_of(1));
        assert_eq!(LoadFraction::START.reached(), LoadFraction::START);
        assert!(LoadFraction::end_of(1) < LoadFraction::start_of(2));
        assert!(LoadFraction::of_total(-0.5).is_err() && LoadFraction::of_total(f64::NAN).is_err());
    }
}
