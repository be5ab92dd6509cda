//! Load fractions at which load steps end: those of equal steps, and the knots of ramps between them.

/// A knot this near to the end of an equal step is that end [equal steps].
const NEAR: f64 = 1e-9;

/// The ends of load steps. A ramp is straight between its knots, and so is the loading of a load step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stations {
    /// Number of equal steps.
    equal: u32,
    /// The knots between their ends, ascending.
    knots: Vec<Knot>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    /// Its number among the stations.
    number: u64,
    /// Load fraction `[-]`.
    fraction: f64,
}

impl Stations {
    /// Ends of `equal` steps, and of steps that end at `knots` between 0 and 1.
    pub(crate) fn new(equal: u32, knots: &[f64]) -> Self {
        let steps = f64::from(equal);
        let mut between: Vec<f64> = knots
            .iter()
            .copied()
            .filter(|knot| *knot > 0.0 && *knot < 1.0)
            .filter(|knot| (knot * steps - (knot * steps).round()).abs() > NEAR)
            .collect();
        between.sort_by(f64::total_cmp);
        between.dedup_by(|next, kept| (*next - *kept) * steps <= NEAR);
        let number = |(k, fraction): (usize, f64)| Knot {
            number: (fraction * steps).floor() as u64 + 1 + k as u64,
            fraction,
        };
        Self { equal, knots: between.into_iter().enumerate().map(number).collect() }
    }

    /// Number of steps from the first station to the last.
    pub(crate) fn steps(&self) -> u64 {
        u64::from(self.equal) + self.knots.len() as u64
    }

    /// Load fractions of the knots between the ends of equal steps, ascending.
    pub(crate) fn knots(&self) -> impl Iterator<Item = f64> {
        self.knots.iter().map(|knot| knot.fraction)
    }

    /// Load fraction of a station; the first is number 0.
    pub(crate) fn fraction(&self, number: u64) -> f64 {
        match self.place(number) {
            (_, Some(knot)) => knot,
            (place, None) => place / f64::from(self.equal),
        }
    }

    /// Load fraction so far between a station (0) and the next (1).
    pub(crate) fn between(&self, number: u64, inside: f64) -> f64 {
        let ((from, _), (to, _)) = (self.place(number), self.place(number + 1));
        (from + (to - from) * inside) / f64::from(self.equal)
    }

    /// Where a station lies, in equal steps, and its load fraction where it is a knot.
    fn place(&self, number: u64) -> (f64, Option<f64>) {
        let before = self.knots.partition_point(|knot| knot.number <= number);
        match self.knots[..before].last() {
            Some(knot) if knot.number == number => (knot.fraction * f64::from(self.equal), Some(knot.fraction)),
            _ => ((number - before as u64) as f64, None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_come_between_the_ends_of_equal_steps() {
        let all = |equal, knots: &[f64]| {
            let stations = Stations::new(equal, knots);
            (0..=stations.steps()).map(|number| stations.fraction(number)).collect::<Vec<_>>()
        };
        assert_eq!(all(2, &[]), [0.0, 0.5, 1.0]);
        assert_eq!(all(2, &[0.75, 0.25, 0.5, 0.25, 0.0, 1.0]), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(all(4, &[0.3, 0.26]), [0.0, 0.25, 0.26, 0.3, 0.5, 0.75, 1.0]);
        let stations = Stations::new(4, &[0.3]);
        assert_eq!(stations.between(1, 0.0), 0.25);
        assert!((stations.between(1, 0.5) - 0.275).abs() < 1e-15);
        assert_eq!(stations.between(3, 0.5), 0.625);
    }
}
