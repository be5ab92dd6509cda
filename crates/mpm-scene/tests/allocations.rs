//! What a run allocates: nothing in a Newton iteration, as long as its system is one task of a factorisation, and nothing for a
//! grid without material.
//!
//! One test, as the counts are those of the whole process.

use mpm_scene::Scene;
use mpm_scene::{Compiled, compile};
use mpm_solver::Summary;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A block of 8 × 8 cells that yields under its weight, in a grid of `cells` × `cells`.
fn scene(basis: &str, cells: u32, tolerance: f64) -> String {
    format!(
        r#"PlaneStrain(
            mesh: Box(axes: [
                Uniform(from: 0, to: {cells}, cells: {cells}),
                Uniform(from: 0, to: {cells}, cells: {cells}),
            ]),
            basis: {basis},
            materials: {{
                "a": VonMises(young: 1e3, poisson: 0.3, yield_radius: 8, density: 1),
            }},
            bodies: [(name: "b", material: "a", shape: Box(from: (0, 0), to: (8, 8)), points_per_cell: 2)],
            supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
            loads: [BodyForce(acceleration: (0, -1.5))],
            schedule: (steps: 2),
            tolerance: (residual: {tolerance:e}),
            output: (fields: []),
        )"#
    )
}

/// Allocations and bytes of a run, and of its compilation.
fn count(text: &str) -> (Summary, [usize; 4]) {
    let parsed = Scene::from_ron(text).unwrap();
    let region = Region::new(ALLOCATOR);
    let mut compiled: Compiled = compile(&parsed).unwrap();
    let compilation = region.change();
    let region = Region::new(ALLOCATOR);
    let summary = compiled.run(&mut ()).unwrap();
    let run = region.change();
    let counts = [
        compilation.allocations + compilation.reallocations,
        compilation.bytes_allocated,
        run.allocations + run.reallocations,
        run.bytes_allocated,
    ];
    (summary, counts)
}

#[test]
fn iterations_allocate_nothing_and_empty_cells_cost_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        // What is made once per process.
        count(&scene("Smpm", 14, 1e-9));
        for basis in ["Smpm", "Cpdi1"] {
            let (short, few) = count(&scene(basis, 14, 1e-3));
            let (long, many) = count(&scene(basis, 14, 1e-11));
            assert!(long.iterations >= short.iterations + 2, "{} {}", long.iterations, short.iterations);
            assert_eq!(few[2], many[2], "{basis}: {} against {} iterations", short.iterations, long.iterations);
            assert_eq!(few[3], many[3], "{basis}");

            // A hundred times the cells, and as many nodes.
            let (_, small) = count(&scene(basis, 14, 1e-9));
            let (wide, large) = count(&scene(basis, 140, 1e-9));
            let skipped = |name| wide.skipped.iter().find(|it| it.0 == name).unwrap().1;
            assert!(skipped("skipped: grid cells") > 19_000 && skipped("skipped: grid nodes") > 19_000);
            // Bytes of ten times the lines of nodes.
            let lines = [0, 8_000, 0, 8_000];
            for ((small, large), lines) in small.into_iter().zip(large).zip(lines) {
                assert!(20 * large <= 21 * small + 20 * lines, "{basis}: {small} and {large}");
            }
        }
    });
}
