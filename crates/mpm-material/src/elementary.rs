//! Logarithms and exponentials of one number or of four, the same bits on every machine.
//!
//! Those of a C library differ from library to library and from processor to processor in the last digit, and a library is
//! asked for one number at a time. Logarithms are those of FreeBSD's msun (`s_log1p.c`; Sun Microsystems 1993) without branches,
//! exponentials are reduced as there and summed as Taylor's series, each within 1.5 units in the last place.

use crate::lanes::Number;

const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// 3 · 2⁵¹: a number added to it is rounded to a whole one, which stands in its last bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// ln(1 + x), also of small x; −∞ of −1 and not a number below.
#[inline(always)]
pub fn ln_1p<T: Number>(x: T) -> T {
    let one = T::of(1.0);
    let u = one + x;
    let k = u.map(exponent);
    let is_small = k.compare(T::ZERO, |k, zero| k == zero);
    // What 1 + x has lost by rounding, over 1 + x.
    let lost = T::pick(k.above(T::ZERO), one - (u - x), x - (u - one)) / u;
    let lost = T::pick(is_small, T::ZERO, lost);
    let f = T::pick(is_small, x, u.map(mantissa) - one);
    let result = logarithm(k, f, lost);
    // Where 1 + x is infinite the series is not a number.
    let result = T::pick(x.below(T::of(f64::INFINITY)), result, x);
    edge(x, -1.0, result)
}

/// ln x; −∞ of 0 and not a number below.
#[inline(always)]
pub fn ln<T: Number>(x: T) -> T {
    // Subnormal numbers have no exponent of their own.
    let is_tiny = x.below(T::of(f64::MIN_POSITIVE));
    let scaled = T::pick(is_tiny, x * T::of(18_014_398_509_481_984.0), x);
    let k = scaled.map(exponent) - T::pick(is_tiny, T::of(54.0), T::ZERO);
    let result = logarithm(k, scaled.map(mantissa) - T::of(1.0), T::ZERO);
    let result = T::pick(x.below(T::of(f64::INFINITY)), result, x);
    edge(x, 0.0, result)
}

/// eˣ.
#[inline(always)]
pub fn exp<T: Number>(x: T) -> T {
    let (rest, k) = reduced(x);
    // In two factors, for numbers that are subnormal.
    let half = k.map(|k| (0.5 * k + WHOLE) - WHOLE);
    let result = (T::of(1.0) + rest) * half.map(power_of_2) * (k - half).map(power_of_2);
    let result = T::pick(x.above(T::of(709.782_712_893_384)), T::of(f64::INFINITY), result);
    T::pick(x.below(T::of(-745.133_219_101_941_2)), T::ZERO, result)
}

/// eˣ − 1, also of small x.
#[inline(always)]
pub fn exp_m1<T: Number>(x: T) -> T {
    let (rest, k) = reduced(x);
    // Half of it first: 2ᵏ may be too large where the result is not.
    let half = k.map(|k| power_of_2(k - 1.0));
    // 2⁻ᵏ is lost beside 1 long before it has no exponent.
    let inverse = (-k).map(|k| power_of_2(if k > -64.0 { k } else { -64.0 }));
    let result = ((T::of(1.0) - inverse) + rest) * half * T::of(2.0);
    let result = T::pick(x.above(T::of(709.782_712_893_384)), T::of(f64::INFINITY), result);
    T::pick(x.below(T::of(-56.0)), T::of(-1.0), result)
}

/// −∞ at the edge of where a logarithm is a number, and not a number below.
#[inline(always)]
fn edge<T: Number>(x: T, edge: f64, result: T) -> T {
    let edge = T::of(edge);
    let result = T::pick(x.below(edge), T::of(f64::NAN), result);
    T::pick(x.compare(edge, |x, edge| x == edge), T::of(f64::NEG_INFINITY), result)
}

/// k ln 2 + ln(1 + f) + `lost`.
#[inline(always)]
fn logarithm<T: Number>(k: T, f: T, lost: T) -> T {
    const L: [f64; 7] = [
        6.666_666_666_666_735e-1,
        3.999_999_999_940_942e-1,
        2.857_142_874_366_239e-1,
        2.222_219_843_214_978_4e-1,
        1.818_357_216_161_805e-1,
        1.531_383_769_920_937_3e-1,
        1.479_819_860_511_658_6e-1,
    ];
    let l = |k: usize| T::of(L[k]);
    let half = T::of(0.5) * f * f;
    let s = f / (T::of(2.0) + f);
    let z = s * s;
    let w = z * z;
    let even = w * (l(1) + w * (l(3) + w * l(5)));
    let odd = z * (l(0) + w * (l(2) + w * (l(4) + w * l(6))));
    let r = even + odd;
    k * T::of(LN_2_HIGH) - ((half - (s * (half + r) + (k * T::of(LN_2_LOW) + lost))) - f)
}

/// k of x = 2ᵏ m with √½ ≤ m < √2.
#[inline(always)]
fn exponent(x: f64) -> f64 {
    // A whole number of few bits as a number, without a conversion that AVX2 does not have for four.
    f64::from_bits(WHOLE.to_bits().wrapping_add(exponent_bits(x))) - WHOLE
}

/// m of x = 2ᵏ m.
#[inline(always)]
fn mantissa(x: f64) -> f64 {
    f64::from_bits(x.to_bits().wrapping_sub(exponent_bits(x) << 52))
}

/// k of x = 2ᵏ m, modulo 2⁶⁴.
#[inline(always)]
fn exponent_bits(x: f64) -> u64 {
    const ROOT_HALF: u64 = 0x3fe6_a09e_0000_0000;
    // Above 0 before the shift, because AVX2 cannot shift four signed numbers.
    const OFFSET: u64 = 1024;

    (x.to_bits().wrapping_sub(ROOT_HALF).wrapping_add(OFFSET << 52) >> 52).wrapping_sub(OFFSET)
}

/// 2ᵏ of a whole number.
#[inline(always)]
fn power_of_2(k: f64) -> f64 {
    f64::from_bits((k + WHOLE).to_bits().wrapping_add(1023) << 52)
}

/// eʳ − 1 and k of x = k ln 2 + r, |r| ≤ ½ ln 2; the first without the rounding error of r.
#[inline(always)]
fn reduced<T: Number>(x: T) -> (T, T) {
    let k = x.map(|x| (x * std::f64::consts::LOG2_E + WHOLE) - WHOLE);
    let (high, low) = (x - k * T::of(LN_2_HIGH), k * T::of(LN_2_LOW));
    let r = high - low;
    let lost = (high - r) - low;
    // Σ rⁿ/n! from 2 to 13, in pairs so that products need not wait for one another; the first term left out is 4e-18.
    let (r2, c) = (r * r, |n: usize| T::of(INVERSE_FACTORIALS[n]));
    let r4 = r2 * r2;
    let pair = |n: usize| c(n) + c(n + 1) * r;
    let (first, second, third) = (pair(2) + pair(4) * r2, pair(6) + pair(8) * r2, pair(10) + pair(12) * r2);
    let series = first + (second + third * r4) * r4;
    (r + (r2 * series + (lost + lost * r)), k)
}

/// 1/n!
const INVERSE_FACTORIALS: [f64; 14] = {
    let (mut inverse, mut factorial, mut n) = ([1.0; 14], 1.0, 1);
    while n < 14 {
        factorial *= n as f64;
        inverse[n] = 1.0 / factorial;
        n += 1;
    }
    inverse
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, Lanes, Work, vectorised};

    type One = fn(f64) -> f64;
    type Four = fn(Lanes) -> Lanes;

    const ALL: [(One, Four, One, [f64; 2]); 4] = [
        (ln_1p, ln_1p, f64::ln_1p, [-1.0, 1e300]),
        (ln, ln, f64::ln, [0.0, 1e300]),
        (exp, exp, f64::exp, [-708.0, 709.7]),
        (exp_m1, exp_m1, f64::exp_m1, [-50.0, 709.7]),
    ];

    /// Numbers of all sizes and both signs, dense about 1.
    fn numbers() -> Vec<f64> {
        let mut numbers = Vec::new();
        for step in 1..4000 {
            let step = f64::from(step);
            numbers.extend([1e-3 * step, 1.0 + 1e-4 * (step - 2000.0), 0.17 * step]);
        }
        for size in -300..300 {
            numbers.extend([1.7, 3.1, 9.3].map(|digits| digits * 10_f64.powi(size)));
        }
        numbers.extend([f64::MIN_POSITIVE, 5e-324, 1e-310, 0.5_f64.ln(), 2.0_f64.ln()]);
        let negative: Vec<f64> = numbers.iter().map(|number| -number).collect();
        numbers.extend(negative);
        numbers
    }

    fn distance(ours: f64, theirs: f64) -> f64 {
        let spacing = (theirs.abs().next_up() - theirs.abs()).max(f64::MIN_POSITIVE * f64::EPSILON);
        (ours - theirs).abs() / spacing
    }

    #[test]
    fn they_are_within_two_units_in_the_last_place() {
        for (ours, _, theirs, [low, high]) in ALL {
            for x in numbers().into_iter().filter(|x| *x > low && *x < high) {
                let far = distance(ours(x), theirs(x));
                assert!(far <= 2.0, "{x:e}: {} is {far} from {}", ours(x), theirs(x));
            }
        }
    }

    #[test]
    fn the_ends_of_what_they_take() {
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        let cases: [(One, &[(f64, f64)]); 4] = [
            (ln_1p, &[(0.0, 0.0), (-1.0, -inf), (-1.5, nan), (-inf, nan), (inf, inf), (nan, nan)]),
            (ln, &[(1.0, 0.0), (0.0, -inf), (-0.0, -inf), (-1.0, nan), (-inf, nan), (inf, inf), (nan, nan)]),
            (exp, &[(0.0, 1.0), (-inf, 0.0), (-800.0, 0.0), (inf, inf), (710.0, inf), (nan, nan)]),
            (exp_m1, &[(0.0, 0.0), (-inf, -1.0), (-800.0, -1.0), (inf, inf), (710.0, inf), (nan, nan)]),
        ];
        for (function, values) in cases {
            for &(x, expected) in values {
                let value = function(x);
                assert!(
                    value == expected || value.is_nan() && expected.is_nan(),
                    "{x}: {value}, not {expected}"
                );
            }
        }
        assert!(distance(exp(-740.0), (-740.0_f64).exp()) <= 2.0);
        assert!(exp_m1(709.7).is_finite() && ln_1p(f64::MAX) > 709.0);
    }

    struct Of<'a>(Four, &'a [Lanes]);

    impl Work for Of<'_> {
        type Output = Vec<Lanes>;

        #[inline(always)]
        fn run<const VECTORS: bool>(self) -> Vec<Lanes> {
            self.1.iter().map(|x| self.0(*x)).collect()
        }
    }

    #[test]
    fn four_at_once_are_four_with_and_without_vector_registers() {
        let mut numbers = numbers();
        numbers.extend([0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN]);
        let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
        let lanes: Vec<Lanes> = numbers.chunks_exact(LANES).map(|x| Lanes([x[0], x[1], x[2], x[3]])).collect();
        for (one, four, ..) in ALL {
            for answers in [vectorised(Of(four, &lanes)), Of(four, &lanes).run::<false>()] {
                for (x, value) in lanes.iter().zip(answers).flat_map(|(x, value)| x.0.into_iter().zip(value.0))
                {
                    assert_eq!(bits(one(x)), bits(value), "{x:e}");
                }
            }
        }
    }
}
