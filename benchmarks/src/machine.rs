//! The machine: clocks, memory, and the two limits that no code on it can pass.

use pulp::{Arch, Simd, WithSimd};
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Processor time of this process so far, all threads together `[s]`.
pub fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// What some work returned, and how long it took.
#[derive(Clone, Copy, Debug)]
pub struct Timed<T> {
    /// What the work returned.
    pub result: T,
    /// Processor time, all threads together `[s]`.
    pub processor: f64,
    /// Time on the wall `[s]`.
    pub wall: f64,
}

/// Does `work` under both clocks.
pub fn timed<T>(work: impl FnOnce() -> T) -> Timed<T> {
    let (wall, processor) = (Instant::now(), processor_seconds());
    let result = work();
    Timed { result, processor: processor_seconds() - processor, wall: wall.elapsed().as_secs_f64() }
}

/// Largest resident memory of this process so far, where the system tells `[B]`.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// How many processes wanted to run in the last minute, where the system tells.
pub fn load_average() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// Limits of one core of the machine.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Limits {
    /// Bytes per second of a triad over arrays larger than every cache; the read that precedes each store is not
    /// counted `[B/s]`.
    pub bandwidth: f64,
    /// Operations per second of fused multiply-adds in the widest registers `[1/s]`.
    pub fused: f64,
    /// Lanes of those registers.
    pub lanes: usize,
    /// Operations per second of multiplications and additions with the instructions that this program
    /// was compiled for `[1/s]`.
    pub compiled: f64,
}

impl Limits {
    /// Measures them, the best of several tries, in a second or so.
    pub fn measure() -> Self {
        let best = |work: &mut dyn FnMut() -> f64| (0..7).map(|_| work()).fold(0.0, f64::max);
        let mut arrays = Arrays::new();
        let bandwidth = best(&mut || arrays.triad());
        let arch = Arch::new();
        let (mut fused, mut lanes) = (0.0_f64, 0);
        for _ in 0..7 {
            let work = timed(|| arch.dispatch(MultiplyAdd));
            (fused, lanes) = (fused.max(work.result.operations / work.processor), work.result.lanes);
        }
        let compiled = best(&mut || {
            let work = timed(multiply_then_add);
            work.result / work.processor
        });
        Self { bandwidth, fused, lanes, compiled }
    }
}

/// Numbers of each array of the triad: 64 MB.
const LONG: usize = 1 << 23;

struct Arrays {
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
}

impl Arrays {
    fn new() -> Self {
        Self { a: vec![0.0; LONG], b: vec![1.0; LONG], c: vec![2.0; LONG] }
    }

    /// `a = b + s c` (McCalpin's STREAM); bytes per second.
    fn triad(&mut self) -> f64 {
        let s = black_box(3.0);
        let work = timed(|| {
            for ((a, b), c) in self.a.iter_mut().zip(&self.b).zip(&self.c) {
                *a = b + s * c;
            }
        });
        black_box(&self.a);
        (3 * 8 * LONG) as f64 / work.processor
    }
}

/// Independent chains: enough to keep two pipelines of four cycles' latency busy.
const CHAINS: usize = 12;
const ROUNDS: usize = 10_000_000;

struct MultiplyAdd;

struct Done {
    operations: f64,
    lanes: usize,
}

impl WithSimd for MultiplyAdd {
    type Output = Done;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Done {
        let (m, c) = (simd.splat_f64s(black_box(0.999)), simd.splat_f64s(black_box(1e-3)));
        let mut chains = [simd.splat_f64s(black_box(0.5)); CHAINS];
        for _ in 0..ROUNDS {
            for chain in &mut chains {
                *chain = simd.mul_add_f64s(*chain, m, c);
            }
        }
        black_box(chains.into_iter().map(|chain| simd.reduce_sum_f64s(chain)).sum::<f64>());
        Done { operations: (2 * S::F64_LANES * CHAINS * ROUNDS) as f64, lanes: S::F64_LANES }
    }
}

/// The same with plain operators, compiled for the target of this build. Returns the number of operations.
#[inline(never)]
fn multiply_then_add() -> f64 {
    let (m, c) = (black_box(0.999), black_box(1e-3));
    let mut chains = [black_box(0.5); 2 * CHAINS];
    for _ in 0..ROUNDS {
        for chain in &mut chains {
            *chain = *chain * m + c;
        }
    }
    black_box(chains);
    (2 * 2 * CHAINS * ROUNDS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_a_processor() {
        let limits = Limits::measure();
        assert!(limits.lanes.is_power_of_two());
        // Anything outside would be an optimised-away loop or a broken clock.
        assert!(limits.bandwidth > 1e8 && limits.bandwidth < 1e12, "{limits:?}");
        assert!(limits.compiled > 1e8 && limits.compiled < 1e12, "{limits:?}");
        assert!(limits.fused > 1e8 && limits.fused < 1e12, "{limits:?}");
    }
}
