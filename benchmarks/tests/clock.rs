//! Alone in its process: the clock counts what other threads of it do.

use mpm_benchmarks::machine::timed;

#[test]
fn the_clock_counts_work_and_not_waiting() {
    let waited = timed(|| std::thread::sleep(std::time::Duration::from_millis(60)));
    assert!(waited.wall >= 0.06 && waited.processor < 0.5 * waited.wall, "{waited:?}");
    let worked = timed(|| (0..5_000_000_u64).fold(1.0, |sum: f64, k| std::hint::black_box(sum + k as f64)));
    assert!(worked.processor > 0.0 && worked.result > 1.0, "{worked:?}");
}
