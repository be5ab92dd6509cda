//! What a second thread gains: whole processes on one thread and on two, in pairs.

use crate::Failure;
use crate::program::{Program, Took, median, scene};
use crate::report::{Report, Settings};
use mpm_validation::Table;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Load steps of the blocks, recorded every second one.
const STEPS: u32 = 6;

/// A scene, on one thread and on two.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What is run.
    pub scene: String,
    /// Material points.
    pub points: usize,
    /// Time on the wall on one thread, median `[s]`.
    pub one: f64,
    /// Median of the ratios of the pairs: time on one thread over that on two.
    pub gain: f64,
    /// Processor time on two threads over that on one, likewise.
    pub extra: f64,
}

/// What is run: a scene with other values in it.
struct Case {
    name: String,
    scene: PathBuf,
    set: Vec<String>,
}

/// Runs the set with the program at a path, or that beside this one.
///
/// # Errors
/// There is no program; a run fails.
pub fn run(settings: &Settings, program: Option<PathBuf>) -> Result<Report<Vec<Row>>, Failure> {
    let program = Program::find(program)?;
    let folder = settings.output.join("threads");
    std::fs::create_dir_all(&folder)?;
    let mut rows = Vec::new();
    for Case { name, scene, set } in cases(settings) {
        let points = program.points(&scene, &set)?;
        // Small runs are repeated until they outlast what the clock cannot tell.
        let times = settings.pick(1, (100_000 / points).clamp(1, 20)) as u32;
        let time = |threads| program.run(&scene, &set, threads, (&folder, times));
        let pair = |_| Ok::<_, Failure>([time(1)?, time(2)?]);
        let pairs: Vec<[Took; 2]> = (0..settings.pick(1, 5)).map(pair).collect::<Result<_, _>>()?;
        let of = |what: &dyn Fn(&[Took; 2]) -> f64| median(pairs.iter().map(what).collect());
        let row = Row {
            scene: name,
            points,
            one: of(&|pair| pair[0].wall),
            gain: of(&|pair| pair[0].wall / pair[1].wall),
            extra: of(&|pair| pair[1].processor / pair[0].processor),
        };
        eprintln!("{}: {:.2}", row.scene, row.gain);
        rows.push(row);
    }
    Ok(Report { set: "threads", tables: vec![table(&rows)], pictures: Vec::new(), results: rows })
}

/// Blocks in the plane and in space, and the collapse, whose tangents are factorised.
fn cases(settings: &Settings) -> Vec<Case> {
    let mut cases = Vec::new();
    for basis in ["Smpm", "Cpdi1"] {
        for &cells in settings.pick(&[8][..], &[16, 32, 45, 160, 300, 500]) {
            cases.push(block::<2>(basis, cells));
        }
    }
    cases.extend(settings.pick(&[3][..], &[5, 8, 10, 24, 32]).iter().map(|&cells| block::<3>("Cpdi1", cells)));
    for &cells in settings.pick(&[8][..], &[16, 128]) {
        let set = [
            format!("mesh.axes[0].cells={}", 2 * cells),
            format!("mesh.axes[1].cells={cells}"),
            format!("schedule.steps={STEPS}"),
            "output.every=2".into(),
            "solver=Direct".into(),
            // So much that it yields and does not collapse, on which meshes differ.
            "loads[0].acceleration=(0, -6)".into(),
        ];
        cases.push(Case { name: format!("collapse, {cells}²"), scene: scene("collapse"), set: set.into() });
    }
    cases
}

/// A block of so many cells along each direction, settling by a tenth.
fn block<const D: usize>(basis: &str, cells: u32) -> Case {
    let file = if D == 2 { "million_points.ron" } else { "block_solid.ron" };
    let corner = vec![cells.to_string(); D].join(", ");
    let mut set = vec![
        format!("basis={basis}"),
        format!("bodies[0].shape.to=({corner})"),
        format!("loads[0].acceleration=(0, {}{})", -100.0 / f64::from(cells), if D == 2 { "" } else { ", 0" }),
        format!("schedule.steps={STEPS}"),
        "output.fields=[CauchyStress, Displacement]".into(),
        "output.every=2".into(),
    ];
    for d in 0..D {
        set.extend([format!("mesh.axes[{d}].to={cells}"), format!("mesh.axes[{d}].cells={cells}")]);
    }
    let ends = if D == 2 { 2..3 } else { 3..5 };
    set.extend(ends.map(|k| format!("supports[{k}].region.at={cells}")));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(file);
    Case { name: format!("block, {basis}, {cells}{}", if D == 2 { "²" } else { "³" }), scene, set }
}

fn table(rows: &[Row]) -> Table {
    let text = format!(
        "Whole processes of `mpm run`, {STEPS} load steps, recorded every second one: one thread over two, medians of five pairs."
    );
    let heads = ["scene", "points", "s, one thread", "gain on the wall", "processor time, two over one"];
    let mut table = Table::new(text, &heads);
    for Row { scene, points, one, gain, extra } in rows {
        table.push([
            scene.clone(),
            points.to_string(),
            format!("{one:.3}"),
            format!("{gain:.2}"),
            format!("{extra:.2}"),
        ]);
    }
    table
}
