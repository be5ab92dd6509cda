//! Stressed bodies carried around by their mesh.

use super::super::{largest, scientific, sweep};
use crate::history::History;
use crate::scenes::{load, load_own, run};
use crate::variants::{CPDI1, CPDI2Q, CROSS, GENERAL, Method, PlaneScene, SLASH, SMPM, plane};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{MaterialInput, MotionInput, ReindexingInput, Scene};
use mpm_solver::observe::Field;
use nalgebra::{Matrix3, Rotation3, Vector3};

pub(in super::super) const CASE: Case = Case {
    name: "carried around",
    goal: "A stressed body that its mesh and its supports carry through two full turns keeps its stress in axes that turn along, and nothing has to work for it.",
    setup: "The ring of doughnut_carried.ron: twisted by 15° (elastic; and with ρ_y = 4.2·10⁵, so that its inner part yields), left alone for ten load steps, then carried by both edges in 80 steps of 9°. And a block with residual stress between two walls on a rotating box mesh (carried_block.ron). The meshes turn as rigid bodies.",
    reference: "The stress before, turned; the elastic energy before; no work (the sum of the supports' moments along the angle, over that of one of the ring's edges, or over the block's energy).",
    run: carried,
};

/// Where being carried begins and how far it goes.
const FROM: f64 = 0.2;
const TURNS: f64 = 2.0;

fn ring(method: &Method, elastic: bool, reindexing: ReindexingInput) -> Result<PlaneScene, Broken> {
    let mut scene = method.of(plane(load("doughnut_carried")?)?);
    if let MotionInput::Twist { reindexing: of, .. } = &mut scene.motion {
        *of = reindexing;
    }
    for material in scene.materials.values_mut() {
        if let (true, MaterialInput::VonMises { young, poisson, density, .. }) = (elastic, &*material) {
            *material = MaterialInput::Hencky {
                young: young.clone(),
                poisson: *poisson,
                gradient: None,
                density: density.clone(),
            };
        }
    }
    Ok(scene)
}

/// What two turns did.
struct Drift {
    /// Largest change of a point's stress in turning axes over the largest stress.
    stress: f64,
    /// Largest relative change of the elastic energy.
    energy: f64,
    /// Work of the supports `[F L]`.
    work: f64,
    /// Points that yielded in some load step before.
    yielded: usize,
    /// Largest moment of the support `inner`, or the elastic energy where there is none `[F L]`.
    scale: f64,
}

fn drift(history: &History) -> Drift {
    let rows = history.rows();
    let start = rows.iter().position(|row| row.fraction > FROM - 1e-9).unwrap_or(0);
    let turned = |row: usize| std::f64::consts::TAU * TURNS * (rows[row].fraction - FROM) / (1.0 - FROM);
    let stress = |row: usize| {
        let values = history.field(Field::CAUCHY_STRESS, row).chunks_exact(9);
        values.map(Matrix3::from_row_slice).collect::<Vec<_>>()
    };
    let before = stress(start);
    let size = largest(before.iter().map(Matrix3::norm));
    let energy = |row: usize| {
        let strain = history.field(Field::ELASTIC_STRAIN, row).chunks_exact(9);
        let volume = history.field(Field::VOLUME, row);
        let density =
            stress(row).into_iter().zip(strain.map(Matrix3::from_row_slice)).map(|(s, e)| s.dot(&e) / 2.0);
        density.zip(volume).map(|(density, volume)| density * volume).sum::<f64>()
    };
    let at_start = energy(start);
    let yields = |row: usize| history.field(Field::PLASTIC, row).iter().filter(|&&it| it > 0.0).count();

    let moments: Vec<Vec<f64>> = history
        .columns()
        .iter()
        .filter(|column| column.name.starts_with("reaction_moment/"))
        .map(|column| history.series(&column.name, 0))
        .collect();
    let moment = |row: usize| moments.iter().map(|of| of[row]).sum::<f64>();
    let inner = history.columns().iter().any(|column| column.name == "reaction_moment/inner");
    let scale = if inner {
        largest(history.series("reaction_moment/inner", 0).iter().map(|m| m.abs()))
    } else {
        at_start
    };

    let yielded = (1..=start).map(yields).max().unwrap_or(0);
    let mut drift = Drift { stress: 0.0, energy: 0.0, work: 0.0, yielded, scale };
    for row in start + 1..rows.len() {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turned(row)).into_inner();
        let off = stress(row)
            .iter()
            .zip(&before)
            .map(|(now, before)| (now - turn * before * turn.transpose()).norm() / size)
            .collect::<Vec<_>>();
        drift.stress = largest(off.into_iter().chain([drift.stress]));
        drift.energy = largest([drift.energy, (energy(row) / at_start - 1.0).abs()]);
        // The trapezoidal rule: the first row is still that of rest, whose moments balance as well.
        drift.work += 0.5 * (moment(row) + moment(row - 1)) * (turned(row) - turned(row - 1));
    }
    drift
}

fn carried(extent: Extent) -> Result<Findings, Broken> {
    let rings: &[Method] = extent.pick(&[SMPM, CPDI1, CPDI2Q, CROSS], &GENERAL);
    let off = ReindexingInput::Off;
    let mut jobs: Vec<(String, PlaneScene)> = Vec::new();
    for method in rings {
        jobs.push((format!("ring, elastic, {}", method.name), ring(method, true, off)?));
        jobs.push((format!("ring, yielded, {}", method.name), ring(method, false, off)?));
    }
    for method in [SMPM, CPDI1, CPDI2Q, SLASH] {
        let scene = method.of(plane(load_own("carried_block")?)?);
        jobs.push((format!("block, {}", method.name), scene));
    }
    let reindexed = jobs.len();
    if extent == Extent::Full {
        for method in rings {
            let scene = ring(method, false, ReindexingInput::WholeCells)?;
            jobs.push((method.name.to_owned(), scene));
        }
    }
    let drifts = sweep(&jobs, |(_, scene)| Ok(drift(&run(&Scene::PlaneStrain(scene.clone()))?.completed()?)))?;

    let mut checks = Vec::new();
    for ((name, _), it) in jobs[..reindexed].iter().zip(&drifts) {
        checks.push(
            Check::new(format!("{name}: stress in turning axes"), it.stress, 1e-9)
                .remark(format!("{} points had yielded", it.yielded)),
        );
        checks.push(Check::new(format!("{name}: elastic energy"), it.energy, 1e-9));
        let work = it.work.abs() / (it.scale * std::f64::consts::TAU * TURNS);
        checks.push(Check::new(format!("{name}: work of the supports"), work, 1e-9));
    }
    let mut table = Table::new(
        "The same ring, yielded, where whole cells are taken off each ring's angle: rings of nodes jump at different times, points meet other cells than before, and what that leaves out of balance moves them. Twist in cells that change is no rigid motion of the mesh; over many turns the changes do not add up to work.",
        &["basis", "stress in turning axes", "elastic energy", "work over moment × angle"],
    );
    for ((name, _), it) in jobs[reindexed..].iter().zip(&drifts[reindexed..]) {
        table.push([
            name.clone(),
            scientific(it.stress, 2),
            scientific(it.energy, 2),
            scientific(it.work / (it.scale * std::f64::consts::TAU * TURNS), 2),
        ]);
    }
    let tables = if extent == Extent::Full { vec![table] } else { Vec::new() };
    Ok(Findings { checks, tables, pictures: Vec::new() })
}
