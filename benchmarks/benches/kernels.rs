//! Micro-benchmarks of the fixed set of kernels: `cargo bench -p mpm-benchmarks -- stencils`.

use criterion::{Criterion, criterion_group, criterion_main};
use mpm_benchmarks::kernels;

fn micro(criterion: &mut Criterion) {
    // Built where nothing else runs: a kernel's parallel loops stay on this one thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread can be had");
    for kernel in kernels::all() {
        // Prepared when first asked for, so that a filter saves the time of the others.
        let mut work = None;
        criterion.bench_function(&kernel.name, |bencher| {
            let work = work.get_or_insert_with(|| kernel.work().expect("the kernel's scene runs"));
            pool.install(|| bencher.iter(&mut *work));
        });
    }
}

criterion_group!(benches, micro);
criterion_main!(benches);
