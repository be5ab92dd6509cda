//! What a body can be cut out of: a closed surface, a round body, a sphere, a prism.

use crate::ball::Ball;
use crate::prism::Prism;
use crate::round::Round;
use crate::surface::Surface;

/// What numbers of files that have single precision are off by [coordinates].
const SINGLE: f64 = f32::EPSILON as f64;

/// What numbers of double precision are off by, after a few operations [coordinates].
pub(crate) const DOUBLE: f64 = 8.0 * f64::EPSILON;

/// What is enclosed.
#[derive(Clone, Copy, Debug)]
pub enum Solid<'a> {
    /// A closed surface.
    Surface(&'a Surface),
    /// A cylinder or tube.
    Round(Round),
    /// A sphere.
    Ball(Ball),
    /// A polygon drawn out.
    Prism(&'a Prism),
}

impl Solid<'_> {
    pub(crate) fn volume(&self) -> f64 {
        match self {
            Solid::Surface(surface) => surface.volume(),
            Solid::Round(round) => round.volume(),
            Solid::Ball(ball) => ball.volume(),
            Solid::Prism(prism) => prism.volume(),
        }
    }

    /// What its coordinates are off by [coordinates].
    pub(crate) fn precision(&self) -> f64 {
        match self {
            Solid::Surface(_) => SINGLE,
            Solid::Round(_) | Solid::Ball(_) | Solid::Prism(_) => DOUBLE,
        }
    }

    /// Lowest and highest coordinate in one direction `[L]`.
    pub fn ends(&self, d: usize) -> (f64, f64) {
        match self {
            Solid::Surface(surface) => {
                let (low, high) = surface.bounds();
                (low[d], high[d])
            }
            Solid::Round(round) if round.axis == d => round.ends,
            Solid::Round(round) => {
                let middle = round.centre[usize::from(round.across()[1] == d)];
                (middle - round.outer, middle + round.outer)
            }
            Solid::Ball(ball) => (ball.centre[d] - ball.radius, ball.centre[d] + ball.radius),
            Solid::Prism(prism) => prism.ends(d),
        }
    }
}
