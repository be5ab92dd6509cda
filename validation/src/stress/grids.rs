//! Grids that lie badly to the body.

use super::{effort, reason, run_plane, scene, spread, variant};
use crate::cases::{largest, scientific, sweep};
use crate::quasi_random::QuasiRandom;
use crate::scenes::Run;
use crate::variants::{ALL, CPDI1, CPDI2Q, GIMP, Method, PlaneScene, SMPM};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_solver::observe::Field;

pub(super) const OFFSETS: Case = Case {
    name: "grid offsets",
    goal: "However the grid lies to the body, the run comes to its end, and the answer hardly depends on it.",
    setup: "Column (mild, 16 cells), elastic block (4 × 4 cells) and collapse (8 × 8 cells), all under their own weight, on grids shifted by 200 random offsets in both directions (40 without ghost stabilisation and for the other bases); the block on grids turned by 200 random angles about its centre (not GIMP), held in its middle and pulled at its sides. Nodes at or below the base are held; where the row of cells above them is filled in part, its material bears all of the weight and is as much softer. The plane of symmetry of the collapse, along which nothing presses the body against its nodes, is held at the row of nodes next to it, at most half a cell off: a body leaves nodes that it reaches with a hundredth of a cell, and the run ends by that name. A body that is rooted goes on below its base by a cell, and is held at the row of nodes next to it.",
    reference: "All runs of GIMP, CPDI1 and CPDI2q with ghost stabilisation reach their end. The others are reported.",
    run: offsets,
};

pub(super) const PERTURBED: Case = Case {
    name: "perturbed positions",
    goal: "Answers change continuously with where the points lie in their cells.",
    setup: "The elastic block on a grid that lies across it, moved on by 10⁻¹² to 10⁻³ of a cell; largest settlement.",
    reference: "The settlement without the move: it may change by a hundred times the move at most; with standard MPM and CPDI corners cross cell faces only where a point does, and none does here.",
    run: perturbed,
};

pub(super) const GRADED: Case = Case {
    name: "long cells",
    goal: "Cells with an aspect ratio of 10⁴ cost no digits.",
    setup: "A block compressed by a tenth between rollers on a graded mesh whose cells have aspect ratios from 1 to 10⁴; 10 load steps.",
    reference: "The homogeneous stress, E ln λ/λ, in every point of the bases that pass the patch test there.",
    run: graded,
};

/// A problem on a shifted (by parts of a cell) or turned grid.
struct Problem {
    name: &'static str,
    scene: fn([f64; 2]) -> Result<PlaneScene, Broken>,
    /// Whether there is a grid for GIMP.
    rectilinear: bool,
}

/// A body on its base, y = 0, under its own weight.
struct Heavy {
    /// Number of the grid's cells and their size; the grid begins two cells before the origin.
    grid: (u32, f64),
    size: [f64; 2],
    law: &'static str,
    steps: u32,
    /// A support more: its name, whether it goes on to the right and to the top, and what it holds. If not to the right, it
    /// is held at the row of nodes next to x = 0.
    sides: (&'static str, [bool; 2], &'static str),
    /// The body goes on beyond its base, and beyond x = 0 where it is held there, by a cell, and is held in both
    /// directions at the row of nodes next to its base, at most half a cell off. Else it ends at its base and is
    /// held at the nodes there or below: in a row of cells that may be filled to a tenth, a cushion ten times as
    /// soft as the body.
    rooted: bool,
}

impl Heavy {
    fn on_grid(&self, offset: [f64; 2]) -> Result<PlaneScene, Broken> {
        let (cells, size) = self.grid;
        let axis = |offset: f64| {
            let from = -(2.0 + offset) * size;
            format!("Uniform(from: {from}, to: {}, cells: {cells})", from + f64::from(cells) * size)
        };
        let (sides, [right, top], held) = self.sides;
        let (beyond, row) = if self.rooted { (size, 0.5 * size) } else { (0.0, 1e-9) };
        scene(&format!(
            "PlaneStrain(
                mesh: Box(axes: [{x}, {y}]),
                basis: Smpm,
                materials: {{ \"ground\": {law} }},
                bodies: [(name: \"body\", material: \"ground\", shape: Box(from: ({left}, {bottom}), to: ({width}, {height})), points_per_cell: 2)],
                supports: [
                    (name: \"base\", region: Box(from: (-1e9, -1e9), to: (1e9, {row})), fix: [{base}]),
                    (name: \"{sides}\", region: Box(from: (-1e9, -1e9), to: ({right}, {top})), fix: [{held}]),
                ],
                loads: [BodyForce(acceleration: (0, -10))],
                schedule: (steps: {steps}),
                output: (fields: [Displacement]),
            )",
            x = axis(offset[0]),
            y = axis(offset[1]),
            law = self.law,
            left = if right { 0.0 } else { -beyond },
            bottom = -beyond,
            width = self.size[0],
            height = self.size[1],
            base = if self.rooted { "X, Y" } else { "Y" },
            right = if right { 1e9 } else { 0.5 * size },
            top = if top { 1e9 } else { row },
            steps = self.steps,
        ))
    }
}

fn column(offset: [f64; 2]) -> Result<PlaneScene, Broken> {
    Heavy {
        grid: (20, 3.125),
        size: [3.125, 50.0],
        law: "Hencky(young: 1e6, poisson: 0, density: 80)",
        steps: 20,
        sides: ("sides", [true, true], "X"),
        rooted: false,
    }
    .on_grid(offset)
}

fn block(offset: [f64; 2], rooted: bool) -> Result<PlaneScene, Broken> {
    Heavy {
        grid: (10, 1.0),
        size: [4.0, 4.0],
        law: "Hencky(young: 1e4, poisson: 0.3, density: 30)",
        steps: 5,
        sides: ("rough", [true, false], "X"),
        rooted,
    }
    .on_grid(offset)
}

fn collapse(offset: [f64; 2], rooted: bool) -> Result<PlaneScene, Broken> {
    Heavy {
        grid: (26, 1.0),
        size: [8.0, 8.0],
        law: "VonMises(young: 1e6, poisson: 0.3, yield_radius: 20e3, density: 1000)",
        steps: 40,
        sides: ("symmetry", [false, true], "X"),
        rooted,
    }
    .on_grid(offset)
}

/// The angle is a quarter turn times the first number.
fn turned([angle, _]: [f64; 2]) -> Result<PlaneScene, Broken> {
    scene(&format!(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: -4, to: 4, cells: 8), Uniform(from: -4, to: 4, cells: 8)]),
            motion: Rotate(angle: {}, ramp: [(0, 1), (1, 1)]),
            basis: Smpm,
            materials: {{ \"ground\": Hencky(young: 1e4, poisson: 0.3) }},
            bodies: [(name: \"body\", material: \"ground\", shape: Box(from: (-2, -2), to: (2, 2)), points_per_cell: 2)],
            supports: [
                (name: \"centre\", region: Point(0, 0), fix: [X, Y]),
                (name: \"spin\", region: Point(1, 0), fix: [Y]),
            ],
            loads: [
                Traction(body: \"body\", axis: X, at: 2, resultant: (1000, 0)),
                Traction(body: \"body\", axis: X, at: -2, resultant: (-1000, 0)),
            ],
            schedule: (steps: 5),
            output: (fields: [Displacement]),
        )",
        90.0 * angle
    ))
}

const PROBLEMS: [Problem; 6] = [
    Problem { name: "column", scene: column, rectilinear: true },
    Problem { name: "block", scene: |at| block(at, false), rectilinear: true },
    Problem { name: "collapse", scene: |at| collapse(at, false), rectilinear: true },
    Problem { name: "rooted block", scene: |at| block(at, true), rectilinear: true },
    Problem { name: "rooted collapse", scene: |at| collapse(at, true), rectilinear: true },
    Problem { name: "turned block", scene: turned, rectilinear: false },
];

/// Largest displacement of a point in any direction.
fn moved(run: &Run) -> f64 {
    let last = run.history.rows().len() - 1;
    largest(run.history.field(Field::DISPLACEMENT, last).iter().map(|u| u.abs()))
}

fn offsets(extent: Extent) -> Result<Findings, Broken> {
    let count: usize = extent.pick(3, 200);
    let mut random = QuasiRandom::new(7);
    let offsets: Vec<[f64; 2]> =
        (0..count).map(|_| [0.5 + 0.5 * random.next(), 0.5 + 0.5 * random.next()]).collect();
    let methods: &[Method] = extent.pick(&[GIMP, CPDI1], &ALL);
    let mut findings = Findings::default();
    let mut table = Table::new(
        format!(
            "{count} grids for the bases that must not stop, a fifth of them for the others; the answer is the largest displacement of a point:"
        ),
        &[
            "problem",
            "basis",
            "ghost",
            "reach their end",
            "smallest, median, largest answer",
            "most linear solutions",
            "halvings in all",
            "first to end",
        ],
    );
    for problem in &PROBLEMS {
        for method in methods.iter().filter(|it| problem.rectilinear || **it != GIMP) {
            for ghost in [false, true] {
                let required = ghost && [GIMP, CPDI1, CPDI2Q].contains(method);
                let offsets = if required { &offsets[..] } else { &offsets[..count.div_ceil(5)] };
                let count = offsets.len();
                let runs =
                    sweep(offsets, |&offset| run_plane(variant(&(problem.scene)(offset)?, method, ghost)))?;
                let ended = runs.iter().filter(|run| run.outcome.is_err()).count();
                let finished = || runs.iter().filter(|run| run.outcome.is_ok());
                let first = runs.iter().find(|run| run.outcome.is_err()).map_or(String::new(), reason);
                let answers = spread(finished().map(moved).collect());
                let efforts: Vec<[f64; 2]> = finished().map(|run| effort(&run.history)).collect();
                table.push([
                    problem.name.to_owned(),
                    method.name.to_owned(),
                    if ghost { "yes" } else { "no" }.to_owned(),
                    format!("{} of {count}", count - ended),
                    answers.map_or("–".into(), |it| it.map(|it| scientific(it, 4)).join(", ")),
                    largest(efforts.iter().map(|it| it[0])).to_string(),
                    efforts.iter().map(|it| it[1]).sum::<f64>().to_string(),
                    first.clone(),
                ]);
                if required {
                    let what =
                        format!("{}, {}, ghost: grids on which the run stops", problem.name, method.name);
                    findings.checks.push(Check::none(what, ended).remark(first));
                }
            }
        }
    }
    findings.tables.push(table);
    Ok(findings)
}

fn perturbed(extent: Extent) -> Result<Findings, Broken> {
    let moves: &[f64] = extent.pick(&[1e-9, 1e-3], &[1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3]);
    let methods: &[Method] = extent.pick(&[SMPM, GIMP], &ALL);
    let at = [0.37, 0.41];
    let heads: Vec<String> = moves.iter().map(|it| scientific(*it, 1)).collect();
    let heads: Vec<&str> = std::iter::once("basis").chain(heads.iter().map(String::as_str)).collect();
    let mut table = Table::new(
        "Relative change of the largest settlement by a move of the grid (in cells), with ghost stabilisation:",
        &heads,
    );
    let mut findings = Findings::default();
    for method in methods {
        let settled = |by: f64| -> Result<f64, Broken> {
            let run = run_plane(variant(&block([at[0] + by, at[1] + by], false)?, method, true))?;
            Ok(if run.outcome.is_ok() { moved(&run) } else { f64::NAN })
        };
        let before = settled(0.0)?;
        let changes: Vec<f64> =
            sweep(moves, |&by| settled(by))?.iter().map(|after| (after / before - 1.0).abs()).collect();
        table.push(std::iter::once(method.name.to_owned()).chain(changes.iter().map(|&it| scientific(it, 1))));
        let factor = largest(changes.iter().zip(moves).map(|(change, by)| change / (by + 1e-12)));
        findings.checks.push(Check::new(
            format!("{}: largest change over the move", method.name),
            factor,
            100.0,
        ));
    }
    findings.tables.push(table);
    Ok(findings)
}

fn graded(_: Extent) -> Result<Findings, Broken> {
    let scene = scene(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 1), Nodes([0, 0.0001, 0.001, 0.01, 0.1, 1, 2])]),
            motion: Stretch([(axis: Y, anchor: 0, driven: 2, displacement: -0.2)]),
            basis: Smpm,
            materials: { \"bar\": Hencky(young: 1e3, poisson: 0) },
            bodies: [(name: \"bar\", material: \"bar\", shape: Box(from: (0, 0), to: (1, 2)), points_per_cell: 2)],
            supports: [
                (name: \"base\", region: Plane(axis: Y, at: 0), fix: [Y]),
                (name: \"sides\", region: Everywhere, fix: [X]),
                (name: \"top\", region: Plane(axis: Y, at: 2), follow_mesh: [Y]),
            ],
            schedule: (steps: 10),
            output: (fields: [CauchyStress]),
        )",
    )?;
    let expected = 1e3 * 0.9_f64.ln() / 0.9;
    let mut findings = Findings::default();
    for method in ALL {
        let run = run_plane(variant(&scene, &method, false))?;
        let reached = reason(&run);
        let error = if run.outcome.is_ok() {
            let stress = run.history.field(Field::CAUCHY_STRESS, 10);
            largest(stress.iter().skip(4).step_by(9).map(|s| (s / expected - 1.0).abs()))
        } else {
            f64::NAN
        };
        findings.checks.push(
            Check::new(format!("{}: stress in every point (relative)", method.name), error, 1e-9)
                .remark(reached),
        );
    }
    Ok(findings)
}
