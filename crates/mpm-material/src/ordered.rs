//! Principal strains in descending order, and the way back to their axes.

use nalgebra::{Matrix3, Vector3};

use crate::Elasticity;
use crate::lanes::{Lanes, Number};

/// Strains ε₁ ≥ ε₂ ≥ ε₃ of axes that are in no order.
///
/// Equal strains keep the order of their axes. Everything that is computed in descending order has to go
/// back to the axes through the same object, so that an exchange of equal strains changes nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ordered {
    /// Descending.
    pub strain: [f64; 3],
    /// Place of each axis in this order.
    place: [usize; 3],
}

/// The part of a tangent that plastic flow takes away, in descending order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Loss {
    /// Left and right vector of a dyad [√(F/L²)], each.
    pub dyad: ([f64; 3], [f64; 3]),
    /// The two places that flow makes equal, whose difference then has no stiffness.
    pub equal: Option<(usize, usize)>,
}

/// Largest and smallest of three numbers, none of which is NaN unless all are.
#[inline]
pub(crate) fn extremes(values: &Vector3<f64>) -> (f64, f64) {
    let [a, b, c] = [values[0], values[1], values[2]];
    let (high, low) = if b > a { (b, a) } else { (a, b) };
    (if c > high { c } else { high }, if c < low { c } else { low })
}

/// Largest and smallest of three numbers, of four points; a number that is none need not be seen.
#[inline(always)]
pub(crate) fn extremes_of_four([a, b, c]: &[Lanes; 3]) -> (Lanes, Lanes) {
    let larger = |a: Lanes, b: Lanes| Lanes::pick(b.above(a), b, a);
    let smaller = |a: Lanes, b: Lanes| Lanes::pick(b.below(a), b, a);
    (larger(larger(*a, *b), *c), smaller(smaller(*a, *b), *c))
}

impl Ordered {
    #[inline]
    pub fn of(strain: &Vector3<f64>) -> Self {
        let [a, b, c] = [strain[0], strain[1], strain[2]];
        let place = [
            usize::from(b > a) + usize::from(c > a),
            usize::from(a >= b) + usize::from(c > b),
            usize::from(a >= c) + usize::from(b >= c),
        ];
        let mut ordered = [f64::NAN; 3];
        ordered[place[0]] = a;
        ordered[place[1]] = b;
        ordered[place[2]] = c;
        Self { strain: ordered, place }
    }

    /// ε₁ − ε₂ and ε₂ − ε₃.
    #[inline]
    pub fn gaps(&self) -> (f64, f64) {
        (self.strain[0] - self.strain[1], self.strain[1] - self.strain[2])
    }

    /// Numbers in descending order, by axis.
    #[inline]
    pub fn by_axis(&self, values: &[f64; 3]) -> Vector3<f64> {
        Vector3::new(values[self.place[0]], values[self.place[1]], values[self.place[2]])
    }

    /// Secants of the pairs (ε₁, ε₂), (ε₂, ε₃), (ε₁, ε₃), as [`crate::Update::secant`] wants them.
    #[inline]
    pub fn secants(&self, [first, second, outer]: [f64; 3]) -> Vector3<f64> {
        // By the place that is not in the pair.
        let without = [second, outer, first];
        Vector3::new(without[self.place[2]], without[self.place[0]], without[self.place[1]])
    }

    /// Elastic moduli less those that flow takes away.
    #[inline]
    pub fn tangent(&self, elasticity: &Elasticity, loss: &Loss) -> Matrix3<f64> {
        let (u, v) = (self.by_axis(&loss.dyad.0), self.by_axis(&loss.dyad.1));
        let (lambda, g) = (elasticity.lame(), elasticity.shear());
        let mut tangent = Matrix3::from_diagonal_element(2.0 * g).add_scalar(lambda) - u * v.transpose();
        if let Some((i, j)) = loss.equal {
            let mut difference = [0.0; 3];
            difference[i] = 1.0;
            difference[j] = -1.0;
            let d = self.by_axis(&difference);
            tangent -= d * d.transpose() * g;
        }
        tangent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_undone() {
        let values = [[0.1, 0.2, 0.3], [0.2, 0.2, 0.1], [0.1, 0.2, 0.2], [0.2, 0.1, 0.2], [0.2, 0.2, 0.2]];
        let turns = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        for values in values {
            for turn in turns {
                let strain = Vector3::new(values[turn[0]], values[turn[1]], values[turn[2]]);
                let ordered = Ordered::of(&strain);
                let [a, b, c] = ordered.strain;
                assert!(a >= b && b >= c);
                assert_eq!(ordered.by_axis(&ordered.strain), strain);
                let differences = ordered.secants([a - b, b - c, a - c]);
                for (pair, (i, j)) in [(0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
                    assert_eq!(differences[pair], (strain[i] - strain[j]).abs());
                }
            }
        }
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        let ordered = Ordered::of(&Vector3::repeat(f64::NAN));
        assert!(ordered.by_axis(&ordered.strain).iter().all(|value| value.is_nan()));
    }
}
