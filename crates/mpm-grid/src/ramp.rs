//! Load fractions, and quantities that follow them: motions, supports, loads.

/// Pseudo-time of a quasi-static run: the applied share of the full load, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct LoadFraction(f64);

impl LoadFraction {
    /// Nothing applied.
    pub const START: Self = Self(0.0);
    /// Everything applied.
    pub const END: Self = Self(1.0);

    /// The fraction `value`; an error outside [0, 1] and for NaN.
    pub fn new(value: f64) -> Result<Self, RampError> {
        if (0.0..=1.0).contains(&value) { Ok(Self(value)) } else { Err(RampError::Fraction { value }) }
    }

    /// The fraction nearest to `value`.
    ///
    /// # Panics
    /// If `value` is NaN.
    pub fn clamped(value: f64) -> Self {
        Self::new(value.clamp(0.0, 1.0)).expect("no number is nearest to NaN")
    }

    /// The fraction as a number in [0, 1].
    #[inline]
    pub fn get(self) -> f64 {
        self.0
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
}

/// A value, piecewise linear in the load fraction and constant before the first and after the last knot.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    knots: Vec<(f64, f64)>,
}

impl Ramp {
    /// The ramp through `knots` = (fraction, value), strictly increasing in the fraction, values finite.
    pub fn new(knots: Vec<(f64, f64)>) -> Result<Self, RampError> {
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
        Ok(Self { knots })
    }

    /// From nothing at fraction 0 to `end_value` at fraction 1.
    pub fn linear(end_value: f64) -> Self {
        Self { knots: vec![(0.0, 0.0), (1.0, end_value)] }
    }

    /// The same `value` at every fraction.
    pub fn constant(value: f64) -> Self {
        Self { knots: vec![(0.0, value)] }
    }

    /// The value at a load fraction; exactly the knot's value on a knot.
    pub fn value(&self, fraction: LoadFraction) -> f64 {
        let f = fraction.get();
        let above = self.knots.partition_point(|knot| knot.0 <= f);
        let (Some(&(f0, v0)), Some(&(f1, v1))) = (self.knots.get(above.wrapping_sub(1)), self.knots.get(above))
        else {
            return self.knots[above.saturating_sub(1)].1;
        };
        let t = (f - f0) / (f1 - f0);
        v0 * (1.0 - t) + v1 * t
    }

    /// Whether what it prescribes is not at rest at fraction 0.
    pub fn jumps(&self) -> bool {
        self.value(LoadFraction::START) != 0.0
    }

    /// The value at a load fraction as something that begins at rest: 0 at fraction 0. A ramp that is not 0 there
    /// jumps in the first load step.
    pub fn from_rest(&self, fraction: LoadFraction) -> f64 {
        if fraction == LoadFraction::START { 0.0 } else { self.value(fraction) }
    }

    /// The knots (fraction, value), strictly increasing in the fraction.
    pub fn knots(&self) -> &[(f64, f64)] {
        &self.knots
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.knots.iter().all(|knot| knot.1.is_finite())
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
}
