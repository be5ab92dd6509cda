//! The multifrontal factorisation: sums of fronts, their elimination, and solution with the factor.
//!
//! Each front sums entries of the matrix and the remainders of its children, eliminates its first equations and hands
//! on what is left of the others. Solutions go the same way: values of the equations that are left are handed from
//! child to parent on the way up, and from parent to child on the way down.

use super::elimination::{Kind, Numbers, Work};
use super::fronts::{Front, Fronts};
use super::substitution::{Backward, Factor, Forward};
use super::tree::{Part, Upward};
use crate::matrix::Pattern;
use crate::report::{OutOfMemory, Pivot};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Equations of the rest from which on the work on a front is divided into tiles.
const LARGE: usize = 512;

/// Structure and factor of one pattern.
pub(super) struct Multifrontal {
    fronts: Fronts,
    factor: Factor,
    /// The solution at the steps of elimination.
    x: Vec<f64>,
    /// Where all fronts are one task: what it works with, so that nothing is allocated for each system.
    small: Option<Small>,
}

/// Memory of a system whose fronts are one task.
#[derive(Default)]
struct Small {
    factorise: Option<(Kind, Serial)>,
    /// Of solutions: values that are handed on, and those of a front.
    kept: Vec<f64>,
    values: Vec<f64>,
}

/// Why there is no factor.
pub(super) enum Failed {
    /// The pivot of this step is not positive (LLᵀ); it is left as elimination has found it.
    NotPositive(usize),
    /// Memory does not suffice.
    Memory,
}

/// Why a method has no factor.
pub(super) enum Stopped {
    /// A pivot that it cannot use.
    Pivot(Pivot),
    /// Memory does not suffice.
    Memory,
}

impl Multifrontal {
    /// Finds the structure for an order of elimination (new to old) and makes room for the factor, in memory that is
    /// no longer needed.
    pub(super) fn allocate(
        pattern: Pattern<'_>,
        order: &[usize],
        memory: Vec<f64>,
    ) -> Result<Self, OutOfMemory> {
        let n = order.len();
        let fronts = Fronts::new(pattern, order)?;
        let entries = fronts.n_numbers;
        let mut numbers = memory;
        if numbers.capacity() < entries {
            // The next pattern will be a little larger or smaller: some room keeps the memory.
            numbers = Vec::new();
            let error = OutOfMemory { equations: n, factor_entries: entries };
            numbers.try_reserve_exact(entries + entries / 8).map_err(|_| error)?;
        }
        numbers.resize(entries, 0.0);
        let (exchange, inverse, off_diagonal) = (vec![0; n], vec![0; n], vec![0.0; n]);
        let factor = Factor { numbers, exchange, inverse, off_diagonal };
        let small = fronts.is_one_task().then(Small::default);
        Ok(Self { fronts, factor, x: vec![0.0; n], small })
    }

    /// The memory of the factor, for another pattern.
    pub(super) fn into_memory(self) -> Vec<f64> {
        self.factor.numbers
    }

    /// Numbers of the factor.
    pub(super) fn factor_entries(&self) -> usize {
        self.fronts.n_numbers
    }

    /// Equation at each step of elimination.
    pub(super) fn order(&self) -> &[usize] {
        &self.fronts.order
    }

    /// Off-diagonal entries of 2×2 pivots, see [`Factor::off_diagonal`].
    pub(super) fn off_diagonal(&self) -> &[f64] {
        &self.factor.off_diagonal
    }

    /// Factorises; tells whether rows were exchanged an odd number of times (LU).
    pub(super) fn factorise(&mut self, kind: Kind, values: &[f64]) -> Result<bool, Failed> {
        let Factor { numbers, exchange, inverse, off_diagonal } = &mut self.factor;
        let pass = Factorise {
            fronts: &self.fronts,
            values,
            kind,
            is_odd: AtomicBool::new(false),
            failed: AtomicUsize::new(usize::MAX),
        };
        let part = FactorPart { numbers, exchange, inverse, off_diagonal };
        let done = match &mut self.small {
            None => self.fronts.upward(&pass, part),
            Some(small) => {
                let all = 0..self.fronts.fronts.len();
                if small.factorise.as_ref().is_none_or(|(before, _)| *before != kind) {
                    small.factorise = Serial::new(kind, &self.fronts, all.clone()).map(|serial| (kind, serial));
                }
                small.factorise.as_mut().and_then(|(_, serial)| pass.visit(all, part, serial))
            }
        };
        match (done, pass.failed.into_inner()) {
            (Some(()), _) => Ok(pass.is_odd.into_inner()),
            (None, usize::MAX) => Err(Failed::Memory),
            (None, step) => Err(Failed::NotPositive(step)),
        }
    }

    /// Calls `see` with each step of elimination, the step (as before exchanges) whose equation has its pivot, and the
    /// diagonal entry of its column of the factor.
    pub(super) fn for_each_diagonal(&self, mut see: impl FnMut(usize, usize, f64)) {
        for front in &self.fronts.fronts {
            for (j, step) in front.steps.clone().enumerate() {
                let value = self.factor.numbers[front.start + j * front.height() + j];
                see(step, front.steps.start + self.factor.exchange[step], value);
            }
        }
    }

    /// Replaces b by x.
    pub(super) fn solve(&mut self, kind: Kind, b: &mut [f64]) {
        let Self { fronts, factor, x, small } = self;
        fronts.order.iter().zip(&mut *x).for_each(|(&equation, x)| *x = b[equation]);
        let (forward, backward) = (Forward { fronts, factor, kind }, Backward { fronts, factor, kind });
        match small {
            None => {
                fronts.upward(&forward, &mut x[..]);
                fronts.downward(&backward, &mut x[..]);
            }
            Some(Small { kept, values, .. }) => {
                let all = 0..fronts.fronts.len();
                forward.visit(all.clone(), x, (kept, values));
                kept.clear();
                backward.visit(all, x, (kept, values));
            }
        }
        fronts.order.iter().zip(&*x).for_each(|(&equation, x)| b[equation] = *x);
    }
}

/// What a pass of factorisation writes.
struct FactorPart<'a> {
    numbers: &'a mut [f64],
    exchange: &'a mut [usize],
    inverse: &'a mut [usize],
    off_diagonal: &'a mut [f64],
}

impl Part for FactorPart<'_> {
    fn split(self, numbers: usize, steps: usize) -> (Self, Self) {
        let (numbers, more_numbers) = self.numbers.split_at_mut(numbers);
        let (exchange, more_exchange) = self.exchange.split_at_mut(steps);
        let (inverse, more_inverse) = self.inverse.split_at_mut(steps);
        let (off_diagonal, more_off_diagonal) = self.off_diagonal.split_at_mut(steps);
        let rest = Self {
            numbers: more_numbers,
            exchange: more_exchange,
            inverse: more_inverse,
            off_diagonal: more_off_diagonal,
        };
        (Self { numbers, exchange, inverse, off_diagonal }, rest)
    }
}

/// The pass from the leaves to the roots that factorises.
struct Factorise<'a> {
    fronts: &'a Fronts,
    values: &'a [f64],
    kind: Kind,
    is_odd: AtomicBool,
    /// The first step whose pivot is not positive: what comes later need not be done.
    failed: AtomicUsize,
}

impl<'a> Upward for Factorise<'a> {
    type Part = FactorPart<'a>;

    fn subtrees(&self, range: Range<usize>, part: FactorPart<'a>) -> Option<Vec<f64>> {
        let mut serial = Serial::new(self.kind, self.fronts, range.clone())?;
        let level = self.visit(range, part, &mut serial).map(|()| serial.levels.level.last().copied())?;
        let [even, odd] = serial.kept;
        Some(if level == Some(1) { odd } else { even })
    }

    fn front(&self, k: usize, part: FactorPart<'a>, children: Vec<Vec<f64>>) -> Option<Vec<f64>> {
        let front = &self.fronts.fronts[k];
        let mut work = Work::new(self.kind, front.n_eliminated())?;
        let mut remainder = with_room(front.n_remainder())?;
        remainder.resize(front.n_remainder(), 0.0);
        let mut numbers = self.begin(front, part, &mut remainder);
        for (&child, of_child) in self.fronts.children(k).iter().zip(children).rev() {
            numbers.add(self.fronts.places(child), &of_child, self.fronts.is_symmetric);
        }
        self.eliminate(front, numbers, &mut work, front.height() >= LARGE)?;
        Some(remainder)
    }
}

/// What fronts that are visited one after the other work with.
struct Serial {
    work: Work,
    levels: Levels,
    /// Remainders that no parent has taken yet, of even and of odd levels: fronts whose remainders are added to
    /// one another stand on different stacks.
    kept: [Vec<f64>; 2],
}

impl Serial {
    /// For a few subtrees; None if memory does not suffice.
    fn new(kind: Kind, fronts: &Fronts, range: Range<usize>) -> Option<Self> {
        let widest = fronts.fronts[range.clone()].iter().map(Front::n_eliminated).max().unwrap_or(0);
        let levels = Levels::of(fronts, range);
        let kept = [with_room(levels.most_kept[0])?, with_room(levels.most_kept[1])?];
        Some(Self { work: Work::new(kind, widest)?, levels, kept })
    }
}

impl Factorise<'_> {
    /// Visits the fronts of a few subtrees; the remainder of the last stays on the stack of its level.
    fn visit(&self, range: Range<usize>, mut part: FactorPart<'_>, serial: &mut Serial) -> Option<()> {
        let Serial { work, levels, kept } = serial;
        kept.iter_mut().for_each(Vec::clear);
        for k in range.clone() {
            let front = &self.fronts.fronts[k];
            let (own, rest) = part.split(front.numbers().len(), front.n_eliminated());
            part = rest;
            let [even, odd] = &mut *kept;
            let (kept, of_children) =
                if levels.level[k - range.start] == 0 { (even, odd) } else { (odd, even) };
            let begin = kept.len();
            kept.resize(begin + front.n_remainder(), 0.0);
            let mut numbers = self.begin(front, own, &mut kept[begin..]);
            for &child in self.fronts.children(k).iter().rev() {
                let places = self.fronts.places(child);
                let from = of_children.len() - places.len().pow(2);
                numbers.add(places, &of_children[from..], self.fronts.is_symmetric);
                of_children.truncate(from);
            }
            self.eliminate(front, numbers, work, false)?;
        }
        Some(())
    }

    /// A front with its entries of the matrix.
    fn begin<'a>(&self, front: &Front, own: FactorPart<'a>, remainder: &'a mut [f64]) -> Numbers<'a> {
        let FactorPart { numbers, exchange, inverse, off_diagonal } = own;
        numbers.fill(0.0);
        for entry in &self.fronts.entries[front.entries.clone()] {
            numbers[entry.place] += self.values[entry.source];
        }
        let (columns, right) = numbers.split_at_mut(front.n_columns());
        let (n_eliminated, n_rest) = (front.n_eliminated(), front.n_rest());
        Numbers { n_eliminated, n_rest, columns, right, remainder, exchange, inverse, off_diagonal }
    }

    fn eliminate(&self, front: &Front, numbers: Numbers<'_>, work: &mut Work, in_tiles: bool) -> Option<()> {
        if front.steps.start > self.failed.load(Ordering::Relaxed) {
            return None;
        }
        match numbers.eliminate(self.kind, work, in_tiles) {
            Ok(is_odd) => {
                self.is_odd.fetch_xor(is_odd, Ordering::Relaxed);
                Some(())
            }
            Err(index) => {
                self.failed.fetch_min(front.steps.start + index, Ordering::Relaxed);
                None
            }
        }
    }
}

impl Numbers<'_> {
    /// Adds the remainder of a child, whose rows and columns stand at these places.
    fn add(&mut self, places: &[usize], of_child: &[f64], is_symmetric: bool) {
        let Self { n_eliminated, n_rest, columns, right, remainder, .. } = self;
        let (n_eliminated, n_rest) = (*n_eliminated, *n_rest);
        let height = n_eliminated + n_rest;
        let eliminated = places.partition_point(|&place| place < n_eliminated);
        for (j, (column, &place)) in of_child.chunks_exact(places.len().max(1)).zip(places).enumerate() {
            let first = if is_symmetric { j } else { 0 };
            if place < n_eliminated {
                let sums = &mut columns[place * height..(place + 1) * height];
                places[first..].iter().zip(&column[first..]).for_each(|(&i, value)| sums[i] += value);
                continue;
            }
            let within = place - n_eliminated;
            if !is_symmetric {
                let sums = &mut right[within * n_eliminated..(within + 1) * n_eliminated];
                places[..eliminated].iter().zip(column).for_each(|(&i, value)| sums[i] += value);
            }
            let first = first.max(eliminated);
            let sums = &mut remainder[within * n_rest..(within + 1) * n_rest];
            places[first..]
                .iter()
                .zip(&column[first..])
                .for_each(|(&i, value)| sums[i - n_eliminated] += value);
        }
    }
}

/// A vector with room for so many numbers; None if memory does not suffice.
fn with_room(size: usize) -> Option<Vec<f64>> {
    let mut numbers = Vec::new();
    numbers.try_reserve_exact(size).ok()?;
    Some(numbers)
}

/// Levels of a few subtrees that are visited one front after the other.
struct Levels {
    /// Number of fronts between each front and the root of its subtree, modulo 2.
    level: Vec<usize>,
    /// Numbers of the remainders that are kept at one time, of even and of odd levels.
    most_kept: [usize; 2],
}

impl Levels {
    fn of(fronts: &Fronts, range: Range<usize>) -> Self {
        let mut level = vec![0; range.len()];
        for k in range.clone().rev() {
            let of_children = 1 - level[k - range.start];
            fronts.children(k).iter().for_each(|&child| level[child - range.start] = of_children);
        }
        let size = |k: usize| fronts.fronts[k].n_remainder();
        let (mut kept, mut most_kept) = ([0; 2], [0; 2]);
        for k in range.clone() {
            let level = level[k - range.start];
            kept[level] += size(k);
            most_kept[level] = kept[level].max(most_kept[level]);
            kept[1 - level] -= fronts.children(k).iter().map(|&child| size(child)).sum::<usize>();
        }
        Self { level, most_kept }
    }
}
