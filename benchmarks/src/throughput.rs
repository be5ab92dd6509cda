//! Throughput: points per second and core in every phase, beside the limits of the machine.
//!
//! A time is the processor time of one phase of a load step on one body, the least of several calls, after a load step that
//! has moved the points through their cells. `Work::of` counts the bytes and operations of a phase from the code, each once.
//! The machine's limits turn both into times; the larger one is the bound. The distance is the measured time over the bound.

use crate::kernels::Connected;
use crate::machine::{Limits, timed};
use crate::report::{Report, Settings};
use crate::{Failure, blocks};
use mpm_grid::LoadFraction;
use mpm_scene::language::{Scene, SolidBasis};
use mpm_scene::{Compiled, compile};
use mpm_solver::Model;
use mpm_validation::Table;
use mpm_validation::variants::{ALL, Method};
use serde::Serialize;

const PHASES: [&str; 4] = ["connect", "stress", "assemble", "advance"];

const SOLID: [(&str, SolidBasis); 5] = [
    ("sMPM", SolidBasis::Smpm),
    ("GIMP", SolidBasis::Gimp),
    ("CPDI1", SolidBasis::Cpdi1),
    ("CPDI2 hexahedra", SolidBasis::Cpdi2Hexahedron),
    ("CPDI2 tetrahedra", SolidBasis::Cpdi2Tetrahedron),
];

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Throughput {
    /// Limits of the machine before the runs.
    pub limits: Limits,
    /// The phases of every basis.
    pub rows: Vec<Row>,
}

/// One phase of one basis.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Dimensions of space.
    pub dimensions: usize,
    /// Name of the basis.
    pub basis: &'static str,
    /// Name of the phase; "stress" is the pass for the internal force alone.
    pub phase: &'static str,
    /// Material points.
    pub points: usize,
    /// Mean number of nodes that a point influences.
    pub nodes_per_point: f64,
    /// Mean number of points that are summed together.
    pub points_per_group: f64,
    /// Processor time per point and call of the phase `[s]`.
    pub seconds: f64,
    /// Points per second.
    pub rate: f64,
    /// Operations per point, estimated.
    pub operations: f64,
    /// Bytes per point that have to come from memory or go there, estimated.
    pub bytes: f64,
    /// Time that the machine needs for them at least `[s]`.
    pub least_seconds: f64,
    /// The limit that gives the bound: "memory" or "flops".
    pub limit: &'static str,
    /// Measured time over the least.
    pub distance: f64,
    /// The same, had the machine only the instructions that the program was compiled for.
    pub distance_as_compiled: f64,
}

/// Connectivity of a body, per point.
#[derive(Clone, Copy, Debug)]
struct Shape {
    dimensions: usize,
    points: usize,
    /// Influences per point.
    nodes: f64,
    /// Points per group.
    group: f64,
    /// Nodes per group.
    group_nodes: f64,
    /// Pairs of nodes per group, half of them.
    group_pairs: f64,
    /// Active nodes per point.
    active: f64,
    /// Stored entries of the tangent per point.
    entries: f64,
    /// Bytes of the points' columns that a step writes, per point, and of those it only reads.
    written: f64,
    read: f64,
    /// Bytes of a point's position and domain.
    placed: f64,
}

/// Operations and bytes of a phase per point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Work {
    operations: f64,
    bytes: f64,
}

impl Work {
    /// Counted in the code; a square root, division or logarithm counts as so many operations as it
    /// takes in a good library (logarithm 30, root and quotient 5).
    ///
    /// * *Kinematics*: gradient of the increment `2 n D²`, inverse and determinant of ΔF 10 (plane) or 45,
    ///   trial state 46 or 138. *Law*: principal axes 20 (Mohr's circle) or 1100 (five sweeps of three
    ///   rotations), three logarithms, Hencky's law 20, the stress in the axes 8 or 54.
    /// * *Force*: `4 n D²`.
    /// * *Tangent*: moduli 120 or 1300 and their weight `D⁴`; `2 n D⁴` for the halves and `D³ n (n + 1)` for the
    ///   blocks of the lower triangle; scattered once per group.
    /// * *Memory*: volume and elastic state 56 bytes, gradients `8 n D`, and per group its numbers; nodal
    ///   vectors once; entries of the tangent read and written once.
    /// * *Connect*: points read, values and gradients `8 n (1 + D)` written, the pattern's rows and the
    ///   groups' slots written; operations `D 2^D (D + 1)` per cell corner looked up.
    /// * *Advance*: as kinematics and law, `2 n D` for the displacement, `2 D³` for F; values as well as gradients read,
    ///   the points read and written.
    fn of(phase: &str, shape: &Shape) -> Self {
        let d = shape.dimensions as f64;
        let plane = shape.dimensions == 2;
        let pick = |in_plane: f64, in_space: f64| if plane { in_plane } else { in_space };
        let n = shape.nodes;
        let state = 2.0 * n * d * d
            + pick(10.0 + 46.0, 45.0 + 138.0)
            + pick(20.0, 1100.0)
            + 90.0
            + 20.0
            + pick(8.0, 54.0);
        let force = 4.0 * n * d * d;
        let tangent = pick(120.0, 1300.0) + d.powi(4) + 2.0 * n * d.powi(4) + d.powi(3) * n * (n + 1.0);
        let scatter = shape.group_pairs * d * d / shape.group;

        let group = (8.0 + 8.0 + 4.0 * shape.group_nodes) / shape.group;
        let nodal = 24.0 * d * shape.active;
        let pass = 56.0 + 8.0 * n * d + group + nodal;
        let slots = 4.0 * shape.group_pairs / shape.group;
        let (operations, bytes) = match phase {
            "stress" => (state + force, pass),
            "assemble" => (state + force + tangent + scatter, pass + slots + 16.0 * shape.entries),
            "connect" => (
                n * d * (d + 1.0) * 4.0,
                shape.placed + 8.0 * n * (1.0 + d) + group + slots + 8.0 * shape.entries,
            ),
            _ => (state + 2.0 * n * d + 2.0 * d.powi(3), pass + 8.0 * n + 2.0 * shape.written + shape.read),
        };
        Self { operations, bytes }
    }
}

/// Runs the set.
///
/// # Errors
/// A scene cannot be made or does not run to its end.
pub fn run(settings: &Settings) -> Result<Report<Throughput>, Failure> {
    let limits = Limits::measure();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let repetitions = settings.pick(2, 9);
    let mut rows = Vec::new();
    for method in &ALL {
        let scene = blocks::plane(method, settings.pick(24, 160), 1)?;
        rows.extend(pool.install(|| phases_of(&scene, method.name, repetitions, &limits))?);
    }
    for (name, basis) in SOLID {
        let scene = blocks::solid(basis, settings.pick(6, 18), 1)?;
        rows.extend(pool.install(|| phases_of(&scene, name, repetitions, &limits))?);
    }
    let tables = vec![limits_table(&limits), table(&rows), totals(&rows)];
    Ok(Report { set: "throughput", tables, pictures: Vec::new(), results: Throughput { limits, rows } })
}

fn phases_of(
    scene: &Scene,
    basis: &'static str,
    repetitions: usize,
    limits: &Limits,
) -> Result<Vec<Row>, Failure> {
    let mut compiled = compile(scene)?;
    compiled.run(&mut ())?;
    let (shape, least) = match compiled {
        Compiled::Plane(model) => measure(model, repetitions)?,
        Compiled::Solid(model) => measure(model, repetitions)?,
    };
    eprintln!("{basis}, {} points: done", shape.points);
    Ok(PHASES.iter().zip(least).map(|(phase, seconds)| row(basis, phase, seconds, &shape, limits)).collect())
}

/// Connectivity of a model's first body, and the least seconds per point of every phase.
fn measure<const D: usize>(
    model: Model<D>,
    repetitions: usize,
) -> Result<(Shape, [f64; PHASES.len()]), Failure> {
    let mut connected = Connected::of(model, LoadFraction::END)?;
    let shape = shape_of(&connected);
    let work: [fn(&mut Connected<D>); PHASES.len()] =
        [Connected::connect, |it| it.pass(false), |it| it.pass(true), Connected::advance];
    let mut least = [f64::INFINITY; PHASES.len()];
    // In turn, so that a busy moment of the machine does not hit all calls of one phase.
    for _ in 0..repetitions {
        for (least, work) in least.iter_mut().zip(work) {
            let seconds = timed(|| work(&mut connected)).processor / shape.points as f64;
            *least = least.min(seconds);
        }
    }
    Ok((shape, least))
}

fn row(basis: &'static str, phase: &'static str, seconds: f64, shape: &Shape, limits: &Limits) -> Row {
    let Work { operations, bytes } = Work::of(phase, shape);
    let (memory, flops) = (bytes / limits.bandwidth, operations / limits.fused);
    let compiled = memory.max(operations / limits.compiled);
    Row {
        dimensions: shape.dimensions,
        basis,
        phase,
        points: shape.points,
        nodes_per_point: shape.nodes,
        points_per_group: shape.group,
        seconds,
        rate: 1.0 / seconds,
        operations,
        bytes,
        least_seconds: memory.max(flops),
        limit: if memory > flops { "memory" } else { "flops" },
        distance: seconds / memory.max(flops),
        distance_as_compiled: seconds / compiled,
    }
}

fn shape_of<const D: usize>(connected: &Connected<D>) -> Shape {
    let connectivity = connected.plan.connectivity();
    let (points, groups) = (connectivity.n_points() as f64, connectivity.n_groups() as f64);
    let sizes = || (0..connectivity.n_groups()).map(|group| connectivity.group_nodes(group).len() as f64);
    let bytes = |of: &dyn Fn(&str) -> bool| {
        let columns = connected.body.columns();
        columns.iter().filter(|(name, _)| of(name)).map(|(_, bytes)| *bytes as f64).sum::<f64>() / points
    };
    let fixed = |name: &str| name.ends_with("at rest") || name == "mass";
    Shape {
        dimensions: D,
        points: connectivity.n_points(),
        nodes: connectivity.n_influences() as f64 / points,
        group: points / groups,
        group_nodes: sizes().sum::<f64>() / groups,
        group_pairs: sizes().map(|n| 0.5 * n * (n + 1.0)).sum::<f64>() / groups,
        active: connected.active.len() as f64 / points,
        entries: connected.pattern.n_entries() as f64 / points,
        written: bytes(&|name| !fixed(name)),
        read: bytes(&fixed),
        placed: bytes(&|name| ["position", "domain"].contains(&name)),
    }
}

fn limits_table(limits: &Limits) -> Table {
    let mut table = Table::new("Limits of one core, measured in this run.", &["limit", "figure"]);
    let giga = |x: f64| format!("{:.1}", x * 1e-9);
    table.push(["triad over 192 MB".into(), format!("{} GB/s", giga(limits.bandwidth))]);
    let fused = format!("fused multiply-adds, {} lanes", limits.lanes);
    table.push([fused, format!("{} Gflop/s", giga(limits.fused))]);
    let compiled = "multiplications and additions as compiled".to_owned();
    table.push([compiled, format!("{} Gflop/s", giga(limits.compiled))]);
    table
}

fn table(rows: &[Row]) -> Table {
    let heads = [
        "D",
        "basis",
        "phase",
        "nodes/pt",
        "ns/pt",
        "Mpt/s",
        "flop/pt",
        "B/pt",
        "bound by",
        "distance",
        "as compiled",
    ];
    let mut table =
        Table::new("Time per point and call of a phase, one core, and how many times the bound it is.", &heads);
    for row in rows {
        table.push([
            row.dimensions.to_string(),
            row.basis.into(),
            row.phase.into(),
            format!("{:.1}", row.nodes_per_point),
            format!("{:.1}", 1e9 * row.seconds),
            format!("{:.2}", 1e-6 * row.rate),
            format!("{:.0}", row.operations),
            format!("{:.0}", row.bytes),
            row.limit.into(),
            format!("{:.1}", row.distance),
            format!("{:.1}", row.distance_as_compiled),
        ]);
    }
    table
}

/// The sums that have targets.
fn totals(rows: &[Row]) -> Table {
    let heads = ["D", "basis", "assemble, µs/pt", "connect + advance, µs/pt", "ratio"];
    let mut table = Table::new(
        "A Newton iteration's stress and assembly (one fused pass) against connecting and advancing.",
        &heads,
    );
    for phases in rows.chunks_exact(PHASES.len()) {
        let of = |phase: &str| phases.iter().find(|row| row.phase == phase).map_or(f64::NAN, |row| row.seconds);
        let (pass, rest) = (of("assemble"), of("connect") + of("advance"));
        table.push([
            phases[0].dimensions.to_string(),
            phases[0].basis.into(),
            format!("{:.3}", 1e6 * pass),
            format!("{:.3}", 1e6 * rest),
            format!("{:.2}", rest / pass),
        ]);
    }
    table
}

/// Names of the bases of the plane.
pub fn method(name: &str) -> Option<&'static Method> {
    ALL.iter().find(|method| method.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One cell of standard MPM inside a large body, four points, four nodes.
    const CELL: Shape = Shape {
        dimensions: 2,
        points: 4,
        nodes: 4.0,
        group: 4.0,
        group_nodes: 4.0,
        group_pairs: 10.0,
        active: 0.25,
        entries: 4.75,
        written: 96.0,
        read: 8.0,
        placed: 16.0,
    };

    #[test]
    fn counts_are_those_of_the_formulas() {
        let stress = Work::of("stress", &CELL);
        assert_eq!(stress.operations, 32.0 + 56.0 + 20.0 + 90.0 + 20.0 + 8.0 + 64.0);
        assert_eq!(stress.bytes, 56.0 + 64.0 + 8.0 + 12.0);
        let assemble = Work::of("assemble", &CELL);
        assert_eq!(assemble.operations - stress.operations, 120.0 + 16.0 + 128.0 + 160.0 + 10.0);
        assert_eq!(assemble.bytes - stress.bytes, 10.0 + 76.0);
    }

    #[test]
    fn the_larger_time_binds() {
        let limits = Limits { bandwidth: 1e10, fused: 1e12, lanes: 8, compiled: 1e9 };
        let row = row("sMPM", "stress", 1e-7, &CELL, &limits);
        assert_eq!(row.limit, "memory");
        assert!((row.distance - 1e-7 / 140e-10).abs() < 1e-9);
        assert!((row.distance_as_compiled - 1e-7 / 290e-9).abs() < 1e-9);
    }
}
