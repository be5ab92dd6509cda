//! Cost of laws per point and iteration: the pass for force and tangent under every law, in pairs with von Mises.
//!
//! A block at rest is strained by waves of some tenths of a per cent, as a load step does, so that neighbours take different ways through a return. Each
//! pair times both passes one after the other, so that a machine that is not ours alone slows down both. The ratio
//! of a law is the median of its pairs.

use crate::Failure;
use crate::kernels::Connected;
use crate::machine::timed;
use crate::report::{Report, Settings};
use mpm_grid::{LoadFraction, Vector};
use mpm_scene::language::Scene;
use mpm_scene::{Compiled, compile};
use mpm_validation::Table;
use serde::Serialize;

/// A law and the stress in which its points begin.
struct Law {
    name: &'static str,
    material: &'static str,
    /// Mean stress at the start `[F/L²]`; points that have one are compressed besides.
    stress: f64,
    /// With what it is compared: a law of the same list.
    beside: &'static str,
}

const fn law(name: &'static str, beside: &'static str, stress: f64, material: &'static str) -> Law {
    Law { name, material, stress, beside }
}

const YIELDING: &str = "von Mises, yielding";
const ELASTIC: &str = "von Mises, elastic";

/// All have E = 10⁴ and ν = 0.3; those of Cam-Clay are so at the stress at which it begins.
const LAWS: [Law; 15] = [
    law(YIELDING, YIELDING, 0.0, "VonMises(young: 1e4, poisson: 0.3, undrained_strength: 2)"),
    law("Tresca, yielding", YIELDING, 0.0, "Tresca(young: 1e4, poisson: 0.3, undrained_strength: 2)"),
    law(
        "Mohr-Coulomb, yielding",
        YIELDING,
        0.0,
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 2, friction: 30, dilation: 5)",
    ),
    law(
        "Mohr-Coulomb with cut-off, yielding",
        YIELDING,
        0.0,
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 2, friction: 30, dilation: 5, tensile_strength: 2)",
    ),
    law(
        "Mohr-Coulomb, associated, yielding",
        YIELDING,
        0.0,
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 2, friction: 30, dilation: 30)",
    ),
    law(
        "Drucker-Prager, yielding",
        YIELDING,
        0.0,
        "DruckerPrager(young: 1e4, poisson: 0.3, cone: Slopes(slope: 1, flow_slope: 0.2, strength: 2))",
    ),
    law(
        "Cam-Clay, constant shear modulus, yielding",
        YIELDING,
        -100.0,
        "CamClay(critical_ratio: 1, compression: 0.1, swelling: 0.012, shear: 3850, reference_pressure: 100, \
         preconsolidation: 101)",
    ),
    law(
        "Cam-Clay, shear modulus with pressure, yielding",
        YIELDING,
        -100.0,
        "CamClay(critical_ratio: 1, compression: 0.1, swelling: 0.012, shear_ratio: 38.5, reference_pressure: 100, \
         preconsolidation: 101)",
    ),
    law(
        "von Mises with fields, yielding",
        YIELDING,
        0.0,
        "VonMises(young: 1e4, poisson: 0.3, undrained_strength: Linear(at: 0, value: 2, gradient: 0))",
    ),
    law(
        "Mohr-Coulomb with fields, yielding",
        "Mohr-Coulomb, yielding",
        0.0,
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: Linear(at: 0, value: 2, gradient: 0), friction: 30, dilation: 5)",
    ),
    law(ELASTIC, ELASTIC, 0.0, "VonMises(young: 1e4, poisson: 0.3, undrained_strength: 1e6)"),
    law("Tresca, elastic", ELASTIC, 0.0, "Tresca(young: 1e4, poisson: 0.3, undrained_strength: 1e6)"),
    law(
        "Mohr-Coulomb, elastic",
        ELASTIC,
        0.0,
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 1e6, friction: 30, dilation: 5)",
    ),
    law(
        "Mohr-Coulomb, associated, elastic",
        ELASTIC,
        0.0,
        "MohrCoulomb(young: 1e4, poisson: 0.3, cohesion: 1e6, friction: 30, dilation: 30)",
    ),
    law(
        "Drucker-Prager, elastic",
        ELASTIC,
        0.0,
        "DruckerPrager(young: 1e4, poisson: 0.3, cone: Slopes(slope: 1, flow_slope: 0.2, strength: 1e6))",
    ),
];

/// One law.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the law.
    pub law: &'static str,
    /// With which law it is paired.
    pub beside: &'static str,
    /// Whether the pass sums both triangles of the tangent.
    pub unsymmetric: bool,
    /// Part of the points that yield.
    pub plastic: f64,
    /// Processor time per point and pass for force and tangent, the median `[s]`.
    pub seconds: f64,
    /// Time over that of the other law, the median of all pairs.
    pub ratio: f64,
    /// The same of the pass for the force alone.
    pub force_ratio: f64,
}

/// Times the passes of all laws.
///
/// # Errors
/// A scene cannot be made, or its points are not strained.
pub fn run(settings: &Settings) -> Result<Report<Vec<Row>>, Failure> {
    let (cells, pairs) = (settings.pick(6, 48), settings.pick(1, 41));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let rows = pool.install(|| -> Result<Vec<Row>, Failure> {
        let mut rows = Vec::new();
        for law in &LAWS {
            let beside = LAWS.iter().find(|other| other.name == law.beside).ok_or("a law to compare with")?;
            rows.push(pair(&mut block(law, cells)?, &mut block(beside, cells)?, law, pairs)?);
        }
        Ok(rows)
    })?;
    Ok(Report { set: "laws", tables: vec![table(&rows)], pictures: Vec::new(), results: rows })
}

fn block(law: &Law, cells: u32) -> Result<Connected<2>, Failure> {
    let Law { material, stress, .. } = law;
    let scene = format!(
        r#"PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: {cells}, cells: {cells}), Uniform(from: 0, to: {cells}, cells: {cells})]),
            basis: Smpm,
            materials: {{ "soil": {material} }},
            bodies: [(
                name: "block", material: "soil", points_per_cell: 2,
                shape: Box(from: (0, 0), to: ({cells}, {cells})),
                initial: Stress(xx: {stress}, yy: {stress}, zz: {stress}),
            )],
            schedule: (steps: 1),
            output: (fields: []),
        )"#
    );
    let Compiled::Plane(model) = compile(&Scene::from_ron(&scene)?)? else {
        return Err("expected a scene in plane strain".into());
    };
    // Lengths of the waves that no number of cells is a multiple of.
    let mean = if *stress == 0.0 { 0.0 } else { 0.003 };
    let wave = |x: Vector<2>| {
        Vector::<2>::new(
            -mean * x[0] + 0.004 * (0.9 * x[1] + 0.4 * x[0]).sin(),
            -mean * x[1] + 0.004 * (0.7 * x[0] - 0.5 * x[1]).sin(),
        )
    };
    Ok(Connected::of(model, LoadFraction::START)?.strained(wave))
}

fn pair(block: &mut Connected<2>, beside: &mut Connected<2>, law: &Law, pairs: usize) -> Result<Row, Failure> {
    let points = block.body.n_points() as f64;
    block.advance();
    block.body.commit();
    let plastic = (0..block.body.n_points()).filter(|&point| block.body.point(point).plastic).count() as f64;
    // The points as they were.
    let cells = f64::sqrt(points / 4.0).round() as u32;
    *block = self::block(law, cells)?;
    let (mut seconds, mut ratios, mut forces) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..pairs {
        for (tangent, ratios) in [(true, &mut ratios), (false, &mut forces)] {
            let other = timed(|| beside.pass(tangent)).processor;
            let own = timed(|| block.pass(tangent)).processor;
            ratios.push(own / other);
            if tangent {
                seconds.push(own / points);
            }
        }
    }
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Ok(Row {
        law: law.name,
        beside: law.beside,
        unsymmetric: block.body.symmetry() == mpm_linear::Symmetry::Unsymmetric,
        plastic: plastic / points,
        seconds: median(seconds),
        ratio: median(ratios),
        force_ratio: median(forces),
    })
}

fn table(rows: &[Row]) -> Table {
    let text = "Processor time per point and pass of standard MPM in the plane, 4 nodes per point; ratios are medians of pairs.";
    let heads = ["law", "beside", "tangent", "yielding", "ns", "force and tangent", "force"];
    let mut table = Table::new(text, &heads);
    for row in rows {
        table.push([
            row.law.into(),
            row.beside.into(),
            if row.unsymmetric { "unsymmetric" } else { "symmetric" }.into(),
            format!("{:.0} %", 100.0 * row.plastic),
            format!("{:.0}", 1e9 * row.seconds),
            format!("{:.2}", row.ratio),
            format!("{:.2}", row.force_ratio),
        ]);
    }
    table
}
