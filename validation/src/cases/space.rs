//! Problems of the plane as problems in space.

use super::view::view;
use super::{fixed, largest, relative, sweep};
use crate::history::History;
use crate::picture::{Panel, Picture};
use crate::scenes::{Run, load, run};
use crate::variants::{PlaneScene, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{
    ActiveInput, AxisInput, Coordinates, Count, Direction, Finite, LoadInput, MeshInput, Positive, RegionInput,
    Scene, SceneIn, ShapeInput, SolidBasis, StabilisationInput, SupportInput,
};
use mpm_solver::observe::Field;

type SolidScene = SceneIn<3, SolidBasis>;

pub(super) const CANTILEVER: Case = Case {
    name: "cantilever in space",
    goal: "A beam bent far is, between smooth walls, the beam in plane strain; with its sides free it follows the elastica of its own stiffness.",
    setup: "A beam 10 × 1 × 1 (E = 12·10⁶, ν = 0.2) under a traction of 10⁵ on its end in 50 load steps, cells of 0.5, GIMP, 2³ points a cell, ghost stabilisation; P l²/EI = 10 with free sides.",
    reference: "The same in plane strain (2² points), every load step; the inextensible elastica.",
    run: cantilever,
};

pub(super) const COLLAPSE: Case = Case {
    name: "collapse in space",
    goal: "Large plastic flow in space: between smooth walls that of plane strain; and a block that spreads to two sides spreads alike to both.",
    setup: "The collapse with cells of 2, 2³ points a cell, GIMP, ghost stabilisation: one cell deep between walls; and a quarter of a block of 16 × 8 × 16. 40 load steps (10 in the tests).",
    reference: "The same in plane strain, every load step; the block's own symmetry.",
    run: collapse,
};

/// Deflection of the elastica over the length at P l²/EI = 1, …, 9.
const ELASTICA: [f64; 9] = [0.302, 0.494, 0.603, 0.670, 0.714, 0.744, 0.767, 0.785, 0.799];

fn solid(name: &str) -> Result<SolidScene, Broken> {
    match load(name)? {
        Scene::Solid(scene) => Ok(scene),
        Scene::PlaneStrain(_) | Scene::Axisymmetric(_) => Err("expected a scene in three dimensions".into()),
    }
}

fn across(at: f64) -> RegionInput<3> {
    RegionInput::Plane { axis: Direction::Z, at: Finite(at) }
}

/// Walls in place of what held the z direction.
fn walled(mut scene: SolidScene, depth: f64) -> SolidScene {
    scene.supports.retain(|support| support.fix != [Direction::Z]);
    for (name, at) in [("front", 0.0), ("back", depth)] {
        scene.supports.push(SupportInput {
            name: name.into(),
            region: across(at),
            fix: vec![Direction::Z],
            displace: Vec::new(),
            follow_mesh: Vec::new(),
            turn: None,
            moment_about: None,
            moment_axis: None,
            active: ActiveInput::default(),
        });
    }
    if let MeshInput::Box { axes, .. } = &mut scene.mesh {
        let cell = axes.first().and_then(cell).unwrap_or(depth);
        let cells = Count((depth / cell).round() as u32);
        axes[2] = AxisInput::Uniform { from: Finite(0.0), to: Finite(depth), cells };
    }
    if let ShapeInput::Box { to, .. } = &mut scene.bodies[0].shape {
        to.0[2] = depth;
    }
    scene
}

fn cell(axis: &AxisInput) -> Option<f64> {
    match axis {
        AxisInput::Uniform { from, to, cells } => Some((to.0 - from.0) / f64::from(cells.0)),
        _ => None,
    }
}

/// Position of the points at the end of every load step of a run in space, per point of the plane: those with equal x
/// and y stand behind each other, z after z.
fn difference(space: &History, flat: &History) -> f64 {
    largest(space.rows().iter().zip(flat.rows()).map(|(space, flat)| {
        let sorted = |positions: &[f64]| {
            let mut points: Vec<[f64; 2]> = positions.chunks_exact(3).map(|x| [x[0], x[1]]).collect();
            points.sort_by_key(|x| x.map(|it| (it * 1e6).round() as i64));
            points
        };
        let (space, flat) = (sorted(&space.positions), sorted(&flat.positions));
        let layers = space.len() / flat.len();
        let repeated: Vec<f64> =
            flat.iter().flat_map(|x| std::iter::repeat_n(x, layers)).flatten().copied().collect();
        relative(&space.into_iter().flatten().collect::<Vec<f64>>(), &repeated)
    }))
}

fn cantilever(extent: Extent) -> Result<Findings, Broken> {
    let free = solid("cantilever_solid")?;
    let mut flat: PlaneScene = plane(load("cantilever")?)?;
    flat.bodies[0].points_per_cell = Some(Count(2));
    flat.stabilisation = Some(StabilisationInput::Ghost { factor: Some(Positive(1.0 / 30.0)) });
    flat.loads = vec![LoadInput::Traction {
        moment: None,
        body: "beam".into(),
        axis: Some(Direction::X),
        at: Some(Finite(10.0)),
        side: None,
        within: None,
        resultant: Some(Coordinates([0.0, -100e3])),
        value: None,
        ramp: Default::default(),
        active: ActiveInput::default(),
    }];
    let scenes = [Scene::Solid(walled(free.clone(), 1.0)), Scene::PlaneStrain(flat), Scene::Solid(free)];
    let runs = sweep(&scenes, run)?;
    let [walled, flat, free] = &runs[..] else { return Err("three runs".into()) };

    let mut findings = Findings::default();
    for (name, run) in [("walls", walled), ("plane", flat), ("sides free", free)] {
        let reason = run.outcome.as_ref().err().map_or(String::new(), ToString::to_string);
        findings.checks.push(
            Check::none(format!("{name}: does not finish"), usize::from(run.outcome.is_err())).remark(reason),
        );
    }
    findings.checks.push(
        Check::new(
            "walls: positions against plane strain (relative, every load step)",
            difference(&walled.history, &flat.history),
            1e-8,
        )
        .remark(format!("{} load steps", walled.history.rows().len() - 1)),
    );
    // The end's deflection: the mean over its points.
    let moved = |history: &History, row: usize| {
        let rest = &history.rows()[0].positions;
        let ends: Vec<usize> = (0..rest.len() / 3).filter(|p| rest[3 * p] > 9.75).collect();
        let displacement = history.field(Field::DISPLACEMENT, row);
        [0, 1].map(|i| ends.iter().map(|p| displacement[3 * p + i]).sum::<f64>() / ends.len() as f64)
    };
    let mut table = Table::new(
        "Deflection and shortening of the end over the length, sides free:",
        &["P l²/EI", "elastica v/l", "v/l", "u/l"],
    );
    let mut departures = Vec::new();
    for (load, expected) in (1..).zip(ELASTICA) {
        let at =
            free.history.rows().iter().position(|row| (10.0 * row.fraction - f64::from(load)).abs() < 1e-9);
        let [u, v] = at.map_or([f64::NAN; 2], |row| moved(&free.history, row).map(|it| -it / 10.0));
        departures.push((v - expected).abs());
        table.push([load.to_string(), fixed(expected, 3), fixed(v, 4), fixed(u, 4)]);
    }
    findings.tables.push(table);
    findings.checks.push(Check::new(
        "sides free: departure of the deflection from the elastica, over the length",
        largest(departures),
        0.02,
    ));
    if extent == Extent::Full {
        findings.pictures.push(Picture {
            file: "cantilever_solid.png",
            caption: "The beam in space at full load: domains of its points.".into(),
            panels: vec![Panel::Shapes(view(
                "cantilever in space".into(),
                free.history.outlines(),
                &[],
                [(-1.5, 8.5), (-1.5, 10.5)],
            ))],
        });
    }
    Ok(findings)
}

/// The collapse in the plane, on cells twice as long.
fn coarse_collapse() -> Result<PlaneScene, Broken> {
    let mut flat = plane(load("collapse")?)?;
    if let MeshInput::Box { axes, .. } = &mut flat.mesh {
        for axis in axes {
            if let AxisInput::Uniform { cells, .. } = axis {
                cells.0 /= 2;
            }
        }
    }
    Ok(flat)
}

fn collapse(extent: Extent) -> Result<Findings, Broken> {
    let steps = Some(Count(extent.pick(10, 40)));
    let mut quarter = solid("collapse_solid")?;
    quarter.schedule.steps = steps;
    let mut flat = coarse_collapse()?;
    flat.schedule.steps = steps;
    flat.stabilisation = quarter.stabilisation;
    let scenes = [Scene::Solid(walled(quarter.clone(), 2.0)), Scene::PlaneStrain(flat), Scene::Solid(quarter)];
    let runs = sweep(&scenes, run)?;
    let [walled, flat, quarter] = &runs[..] else { return Err("three runs".into()) };

    let mut findings = Findings::default();
    let mut table = Table::new(
        "How far each run gets:",
        &[
            "body",
            "points",
            "load steps",
            "linear solves",
            "halvings",
            "largest x",
            "largest y",
            "largest z",
            "ends because",
        ],
    );
    for (name, run) in ["walls", "plane", "quarter"].into_iter().zip(&runs) {
        let reason = run.outcome.as_ref().err().map_or(String::new(), ToString::to_string);
        let unfinished = Check::none(format!("{name}: does not finish"), usize::from(run.outcome.is_err()));
        findings.checks.push(unfinished.remark(reason.clone()));
        let total = |column: &str| run.history.series(column, 0).iter().sum::<f64>().to_string();
        let last = &run.history.last().positions;
        let most = |i: usize| fixed(largest(last.chunks_exact(3).map(|x| x[i])), 4);
        table.push([
            name.to_owned(),
            (last.len() / 3).to_string(),
            (run.history.rows().len() - 1).to_string(),
            total("newton_iterations"),
            total("cuts"),
            most(0),
            most(1),
            most(2),
            reason,
        ]);
    }
    findings.tables.push(table);
    findings.checks.push(Check::new(
        "walls: positions against plane strain (relative, every load step)",
        difference(&walled.history, &flat.history),
        1e-8,
    ));
    findings.checks.push(Check::new(
        "quarter: positions against those with x and z exchanged (relative, at the end)",
        asymmetry(quarter),
        1e-8,
    ));
    if extent == Extent::Full {
        let history = &quarter.history;
        let rho = history.field(Field::RHO, history.rows().len() - 1);
        let shades: Vec<f64> = rho.iter().map(|rho| rho / 20e3).collect();
        findings.pictures.push(Picture {
            file: "collapse_solid.png",
            caption:
                "A quarter of the block at the end: domains, from pale (no deviatoric stress) to red (yield)."
                    .into(),
            panels: vec![Panel::Shapes(view(
                "collapse in space".into(),
                history.outlines(),
                &shades,
                [(-8.0, 14.0), (-6.0, 7.0)],
            ))],
        });
    }
    Ok(findings)
}

/// Each point against the one whose place at rest is its own with x and z exchanged.
fn asymmetry(run: &Run) -> f64 {
    let (rest, last) = (&run.history.rows()[0].positions, &run.history.last().positions);
    let key = |x: &[f64]| [x[0], x[1], x[2]].map(|it| (it * 1e6).round() as i64);
    let mut places: Vec<([i64; 3], usize)> =
        rest.chunks_exact(3).enumerate().map(|(p, x)| (key(x), p)).collect();
    places.sort_unstable();
    let mirrored = rest.chunks_exact(3).map(|x| {
        let at = places.binary_search_by_key(&key(&[x[2], x[1], x[0]]), |it| it.0).ok()?;
        let p = places[at].1;
        Some([last[3 * p + 2], last[3 * p + 1], last[3 * p]])
    });
    match mirrored.collect::<Option<Vec<[f64; 3]>>>() {
        None => f64::NAN,
        Some(mirrored) => relative(&mirrored.concat(), last),
    }
}
