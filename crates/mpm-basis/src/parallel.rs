//! Work in parallel, compiled once for what it gives and not for each closure that does it.
//!
//! A law or a basis has closures of its own. Each of them would bring its own copy of the machinery that hands work to
//! threads, several times as much code as the work itself.

use rayon::prelude::*;

/// Points whose work takes about as long as waking a thread, some 50 µs.
const FEW_POINTS: usize = 512;

/// Numbers that are worth a task.
const FEW_NUMBERS: usize = 1 << 16;

/// Does both, at the same time if a thread is free.
pub fn both<A: Send, B: Send>(low: impl FnOnce() -> A + Send, high: impl FnOnce() -> B + Send) -> (A, B) {
    let (mut low, mut high) = (Some(low), Some(high));
    let (mut of_low, mut of_high) = (None, None);
    join(&mut || of_low = low.take().map(|work| work()), &mut || of_high = high.take().map(|work| work()));
    (of_low.expect("the work was done"), of_high.expect("the work was done"))
}

fn join(low: &mut (dyn FnMut() + Send), high: &mut (dyn FnMut() + Send)) {
    rayon::join(low, high);
}

/// What `work` gives for the tasks 0 to `n` - 1, in order.
pub fn each<R: Send>(n: usize, work: &(dyn Fn(usize) -> R + Sync)) -> Vec<R> {
    if n < 2 {
        return (0..n).map(work).collect();
    }
    (0..n).into_par_iter().map(work).collect()
}

/// Cuts a list into consecutive parts of these lengths.
pub fn parts<T>(
    mut list: &mut [T],
    lengths: impl IntoIterator<Item = usize>,
) -> impl Iterator<Item = &mut [T]> {
    lengths.into_iter().map(move |length| {
        let (part, rest) = std::mem::take(&mut list).split_at_mut(length);
        list = rest;
        part
    })
}

/// Lets `work` fill each of the parts, of which it is given the number.
pub fn fill<T: Send>(parts: Vec<&mut [T]>, work: &(dyn Fn(usize, &mut [T]) + Sync)) {
    if parts.len() < 2 {
        return parts.into_iter().enumerate().for_each(|(k, part)| work(k, part));
    }
    parts.into_par_iter().enumerate().for_each(|(k, part)| work(k, part));
}

/// The same of points, each of which is little work: a few of them are not worth waking a thread.
pub fn each_point<R: Send>(n: usize, work: &(dyn Fn(usize) -> R + Sync)) -> Vec<R> {
    if n < FEW_POINTS {
        return (0..n).map(work).collect();
    }
    (0..n).into_par_iter().map(work).collect()
}

/// Sets all numbers.
pub fn set(numbers: &mut [f64], to: f64) {
    if numbers.len() <= FEW_NUMBERS {
        return numbers.fill(to);
    }
    numbers.par_chunks_mut(FEW_NUMBERS).for_each(|numbers| numbers.fill(to));
}

/// Multiplies all numbers.
pub fn multiply(numbers: &mut [f64], by: f64) {
    numbers.par_chunks_mut(FEW_NUMBERS).for_each(|numbers| numbers.iter_mut().for_each(|it| *it *= by));
}

/// The largest size; what is not a number does not count.
pub fn largest_size(numbers: &[f64]) -> f64 {
    let of_some = |numbers: &[f64]| numbers.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
    if numbers.len() <= FEW_NUMBERS {
        return of_some(numbers);
    }
    let of_parts: Vec<f64> = numbers.par_chunks(FEW_NUMBERS).map(of_some).collect();
    of_some(&of_parts)
}

/// Changes the length of a list. If it has no room, all of its items are defaults afterwards: for numbers the system hands out memory of
/// zeros, whose pages are made when tasks first write them.
pub fn resize<T: Clone + Default>(list: &mut Vec<T>, n: usize) {
    if list.capacity() < n {
        *list = Vec::new();
        *list = vec![T::default(); n];
    } else {
        list.resize(n, T::default());
    }
}

/// What `work` gives for those points for which it gives something, in order, with their numbers.
pub fn some_points<R: Send>(n: usize, work: &(dyn Fn(usize) -> Option<R> + Sync)) -> Vec<(usize, R)> {
    let numbered = |k| Some((k, work(k)?));
    if n < FEW_POINTS {
        return (0..n).filter_map(numbered).collect();
    }
    (0..n).into_par_iter().filter_map(numbered).collect()
}
