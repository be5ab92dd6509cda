//! Four numbers side by side, and code that is written once for one number and for four.
//!
//! Element-wise operations of IEEE 754 are the same in any register: what is computed with [`Lanes`] has the bits of the
//! same code with `f64`, on every machine. The number of lanes is a constant of the method and not that of the machine.
//! [`vectorised`] chooses at run time between the code of every machine and that with vector registers of four
//! numbers; products and sums are never fused.
//!
//! Everything that is to run in vector registers has to be inlined into the work that [`vectorised`] is given:
//! a function that stays a call is compiled for every machine.

use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use std::sync::OnceLock;

/// Numbers in [`Lanes`].
pub const LANES: usize = 4;

/// One number, or four of which each goes its own way.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// What a comparison answers.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;

    /// The same number in all lanes.
    fn of(value: f64) -> Self;

    /// `f` of every lane.
    fn map(self, f: impl Fn(f64) -> f64) -> Self;

    /// `f` of every two lanes.
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;

    /// `f` of every two lanes, yes or no.
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> Self::Mask;

    /// `yes` where the mask says so, else `no`.
    fn pick(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Whether the mask says yes anywhere.
    fn any(mask: Self::Mask) -> bool;

    /// Whether the mask says yes everywhere.
    fn all(mask: Self::Mask) -> bool;

    /// 0.
    const ZERO: Self;

    /// |x|.
    #[inline(always)]
    fn absolute(self) -> Self {
        self.map(f64::abs)
    }

    /// √x.
    #[inline(always)]
    fn root(self) -> Self {
        self.map(f64::sqrt)
    }

    /// |x| with the sign of another.
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        self.zip(other, f64::copysign)
    }

    /// Whether x is above another number; no where one of them is not a number.
    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a > b)
    }

    /// Whether x is below another number; no where one of them is not a number.
    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a < b)
    }
}

impl Number for f64 {
    type Mask = bool;
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        f(self, other)
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> bool {
        f(self, other)
    }

    #[inline(always)]
    fn pick(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn all(mask: bool) -> bool {
        mask
    }
}

/// Four numbers.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
#[repr(align(32))]
pub struct Lanes(
    /// The numbers.
    pub [f64; LANES],
);

/// Four answers, each in all bits of a number, as vector registers hold them.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(align(32))]
pub struct Mask([u64; LANES]);

impl Mask {
    /// No, four times.
    pub const NONE: Self = Self([0; LANES]);

    /// The answer in a lane.
    #[inline(always)]
    pub fn get(self, lane: usize) -> bool {
        self.0[lane] != 0
    }

    /// Gives a lane another answer.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, answer: bool) {
        self.0[lane] = all_bits(answer);
    }
}

impl Not for Mask {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        let Self([a, b, c, d]) = self;
        Self([!a, !b, !c, !d])
    }
}

#[inline(always)]
fn all_bits(answer: bool) -> u64 {
    if answer { u64::MAX } else { 0 }
}

macro_rules! operators {
    ($type:ident: $($name:ident $function:ident $operator:tt),*) => {
        $(impl $name for $type {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                let (Self([a, b, c, d]), Self([e, f, g, h])) = (self, other);
                Self([a $operator e, b $operator f, c $operator g, d $operator h])
            }
        })*
    };
}

operators!(Lanes: Add add +, Sub sub -, Mul mul *, Div div /);
operators!(Mask: BitAnd bitand &, BitOr bitor |);

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Number for Lanes {
    type Mask = Mask;
    const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    fn of(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let Self([a, b, c, d]) = self;
        Self([f(a), f(b), f(c), f(d)])
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (Self([a, b, c, d]), Self([e, g, h, i])) = (self, other);
        Self([f(a, e), f(b, g), f(c, h), f(d, i)])
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> Mask {
        let (Self([a, b, c, d]), Self([e, g, h, i])) = (self, other);
        Mask([all_bits(f(a, e)), all_bits(f(b, g)), all_bits(f(c, h)), all_bits(f(d, i))])
    }

    #[inline(always)]
    fn pick(Mask(mask): Mask, Self(yes): Self, Self(no): Self) -> Self {
        let pick = |k: usize| f64::from_bits((yes[k].to_bits() & mask[k]) | (no[k].to_bits() & !mask[k]));
        Self([pick(0), pick(1), pick(2), pick(3)])
    }

    #[inline(always)]
    fn any(Mask([a, b, c, d]): Mask) -> bool {
        (a | b | c | d) != 0
    }

    #[inline(always)]
    fn all(Mask([a, b, c, d]): Mask) -> bool {
        (a & b & c & d) != 0
    }
}

/// The numbers `f(0)`, `f(1)`, …: [`std::array::from_fn`], of which the compiler leaves calls.
#[inline(always)]
pub fn each<T: Number, const N: usize>(f: impl Fn(usize) -> T) -> [T; N] {
    let mut all = [T::ZERO; N];
    for (k, of) in all.iter_mut().enumerate() {
        *of = f(k);
    }
    all
}

/// `f` of every lane's number.
#[inline(always)]
pub fn four<T>(f: impl Fn(usize) -> T) -> [T; LANES] {
    [f(0), f(1), f(2), f(3)]
}

/// Work that runs in vector registers where there are any; `run` has to be `#[inline(always)]`, and all that it calls.
pub trait Work {
    /// What it answers.
    type Output;

    /// Does it, with vector registers of four numbers or without, where code that is specialised is not worth its size.
    fn run<const VECTORS: bool>(self) -> Self::Output;
}

/// Does `work` in vector registers of four numbers where the machine has them (AVX2), and else as compiled: the same
/// bits either way. The variable `MPM_VECTORS=off` of the environment turns it off.
#[inline(always)]
pub fn vectorised<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = *has_vectors() {
        return v3.vectorize(Vectorised(work));
    }
    work.run::<false>()
}

#[cfg(target_arch = "x86_64")]
struct Vectorised<W>(W);

#[cfg(target_arch = "x86_64")]
impl<W: Work> pulp::NullaryFnOnce for Vectorised<W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.0.run::<true>()
    }
}

#[cfg(target_arch = "x86_64")]
#[inline]
fn has_vectors() -> &'static Option<pulp::x86::V3> {
    static VECTORS: OnceLock<Option<pulp::x86::V3>> = OnceLock::new();
    VECTORS.get_or_init(|| {
        let is_off = std::env::var_os("MPM_VECTORS").is_some_and(|value| value == "off");
        if is_off { None } else { pulp::x86::V3::try_new() }
    })
}
