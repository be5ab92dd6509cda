//! Remedies for convected domains that degenerate.

use super::{domains::doughnut_to, fixed, largest, sweep};
use crate::problems::doughnut::ring;
use crate::scenes::{Run, load, run};
use crate::variants::{
    CPDI1, CPDI2Q, CROSS, Method, PlaneScene, SLASH, SMPM, falling_back, frozen, plane, with_points,
};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;

pub(super) const CASE: Case = Case {
    name: "remedies for distorted domains",
    goal: "What frozen corner weights and falling back to CPDI1 domains do for CPDI2q and CPDI2t, and what they cost where nothing is wrong.",
    setup: "The corner stretch on the kite (2² points, 40 load steps), the elastic doughnut to 20°, and the slides' doughnut to 180° (5 × 32 cells): as published, with frozen weights, and falling back beyond several distortions.",
    reference: "Corner stretch: CPDI2q with 8² points. Elastic doughnut: the one-dimensional torque. Slides' doughnut: standard MPM and CPDI1, the bases that stay physical.",
    run: remedies,
};

#[derive(Clone, Debug, PartialEq)]
enum Remedy {
    None,
    Frozen,
    Fallback(f64),
}

impl Remedy {
    fn apply(&self, scene: PlaneScene) -> PlaneScene {
        match self {
            Remedy::None => scene,
            Remedy::Frozen => frozen(scene),
            Remedy::Fallback(beyond) => falling_back(scene, *beyond),
        }
    }

    fn name(&self) -> String {
        match self {
            Remedy::None => "as published".into(),
            Remedy::Frozen => "frozen weights".into(),
            Remedy::Fallback(beyond) => format!("fallback beyond {beyond}"),
        }
    }
}

/// Thresholds that are recommended: for quadrilaterals, for triangles.
const RECOMMENDED: [(Method, f64); 2] = [(CPDI2Q, 0.5), (SLASH, 2.0)];

fn jobs(extent: Extent) -> Vec<(Method, Remedy)> {
    let mut jobs: Vec<(Method, Remedy)> =
        [SMPM, CPDI1, CPDI2Q, SLASH].map(|method| (method, Remedy::None)).to_vec();
    jobs.push((CPDI2Q, Remedy::Frozen));
    match extent {
        Extent::Tests => jobs.extend(RECOMMENDED.map(|(method, beyond)| (method, Remedy::Fallback(beyond)))),
        Extent::Full => {
            jobs.extend([0.1, 0.25, 0.5, 1.0, 2.0].map(|beyond| (CPDI2Q, Remedy::Fallback(beyond))));
            jobs.extend([1.0, 2.0, 4.0, 8.0].map(|beyond| (SLASH, Remedy::Fallback(beyond))));
            jobs.push((CROSS, Remedy::None));
            jobs.extend([1.0, 2.0, 4.0, 8.0].map(|beyond| (CROSS, Remedy::Fallback(beyond))));
        }
    }
    jobs
}

/// |R| of the corner at D = 1, 2 and 4.
fn corner(scene: PlaneScene) -> Result<[f64; 3], Broken> {
    let run = run(&Scene::PlaneStrain(scene))?;
    Ok([0.25, 0.5, 1.0].map(|fraction| at(&run, fraction, "reaction/corner") * 2_f64.sqrt()))
}

/// A column where the load fraction is `fraction`, if the run got there.
fn at(run: &Run, fraction: f64, column: &str) -> f64 {
    let row = run.history.rows().iter().position(|row| (row.fraction - fraction).abs() < 1e-12);
    row.map_or(f64::NAN, |row| run.history.series(column, 0)[row])
}

struct Measured {
    corner: [f64; 3],
    /// Relative error of the elastic torque at 20°, 5 × 32 and 10 × 64.
    elastic: [f64; 2],
    /// Torques at 45, 90 and 180 degrees over 10⁷.
    slides: [f64; 3],
    end: f64,
}

fn measure(method: &Method, remedy: &Remedy, truth: &[f64; 3], degrees: u32) -> Result<Measured, Broken> {
    let found = corner(remedy.apply(method.of(plane(load("corner_stretch_kite")?)?)))?;
    let mut elastic = [f64::NAN; 2];
    for (error, factor) in elastic.iter_mut().zip([1, 2]) {
        let run = run(&Scene::PlaneStrain(remedy.apply(ring(method, factor)?)))?;
        *error = at(&run, 1.0, "reaction_moment/inner") / 6.764_336_5e7 - 1.0;
    }
    let twisted = run(&Scene::PlaneStrain(remedy.apply(doughnut_to(method, degrees)?)))?;
    let torque = |angle: f64| at(&twisted, angle / f64::from(degrees), "reaction_moment/inner") / 1e7;
    Ok(Measured {
        corner: std::array::from_fn(|k| found[k] / truth[k] - 1.0),
        elastic,
        slides: [45.0, 90.0, 180.0].map(torque),
        end: f64::from(degrees) * twisted.history.last().fraction,
    })
}

fn remedies(extent: Extent) -> Result<Findings, Broken> {
    let truth = corner(with_points(CPDI2Q.of(plane(load("corner_stretch_kite")?)?), 8))?;
    let jobs = jobs(extent);
    let degrees = extent.pick(90, 180);
    let measured = sweep(&jobs, |(method, remedy)| measure(method, remedy, &truth, degrees))?;

    let mut table = Table::new(
        "Frozen weights enter S alone, so without body forces and loads on points they change nothing: they are a remedy for negative masses, not for stiffness. Falling back helps where a domain has grown beyond its cell: beyond 0.5 is recommended for CPDI2q (a domain stops being convex at 1) and beyond 2 for CPDI2t slash or backslash. Both leave the elastic doughnut, where nothing is wrong, as it is, and bring the slides' torques to those of CPDI1; what remains is the error of CPDI1. Thresholds twice as large still help at the end but come late; much smaller ones amount to CPDI1. Crossed triangles with 2² points are larger than a quarter of a cell from the start and are not cured: falling back beyond 2 keeps the doughnut physical but loses the pulled corner.\n\nErrors of √2 R_x at D = 1, 2, 4; of the elastic torque at 20°; torque of the slides' doughnut over 10⁷ at 45°, 90°, 180°:",
        &["basis", "remedy", "corner stretch", "elastic 5 × 32", "elastic 10 × 64", "slides' doughnut"],
    );
    for ((method, remedy), it) in jobs.iter().zip(&measured) {
        let percent = it
            .corner
            .map(|e| if e.is_nan() { "not reached".into() } else { format!("{:+.0} %", 100.0 * e) })
            .join(", ");
        let mut torques: Vec<String> = it.slides.iter().filter(|t| !t.is_nan()).map(|&t| fixed(t, 1)).collect();
        if it.end < f64::from(degrees) {
            torques.push(format!("ends at {}°", fixed(it.end, 1)));
        }
        table.push([
            method.name.to_owned(),
            remedy.name(),
            percent,
            format!("{:+.1e}", it.elastic[0]),
            format!("{:+.1e}", it.elastic[1]),
            torques.join(", "),
        ]);
    }

    let of = |method: &Method, remedy: &Remedy| {
        let at = jobs.iter().position(|(m, r)| m == method && r == remedy).expect("a job");
        &measured[at]
    };
    let (plain, still) = (of(&CPDI2Q, &Remedy::None), of(&CPDI2Q, &Remedy::Frozen));
    let pairs = plain.corner.iter().zip(&still.corner).chain(plain.elastic.iter().zip(&still.elastic));
    let change = largest(pairs.map(|(a, b)| (a - b).abs()));
    let mut checks = vec![Check::new("CPDI2q: what frozen weights change without body forces", change, 1e-9)];
    for (method, beyond) in RECOMMENDED {
        let (plain, cured) = (of(&method, &Remedy::None), of(&method, &Remedy::Fallback(beyond)));
        let name = format!("{} beyond {beyond}", method.name);
        let worst = |it: &Measured| largest(it.corner.iter().map(|e| e.abs()));
        checks.push(
            Check::new(
                format!("{name}: largest error on the corner stretch over that as published"),
                worst(cured) / worst(plain),
                1.0,
            )
            .remark(format!("{:.3} instead of {:.3}", worst(cured), worst(plain))),
        );
        let elastic = |it: &Measured| largest(it.elastic.iter().map(|e| e.abs()));
        checks.push(
            Check::new(
                format!("{name}: largest error of the elastic torque over that as published"),
                elastic(cured) / elastic(plain),
                1.05,
            )
            .remark(format!("{:.1e} instead of {:.1e}", elastic(cured), elastic(plain))),
        );
        checks.push(
            Check::new(
                format!("{name}: slides' torque at 90° over that as published"),
                cured.slides[1] / plain.slides[1],
                1.0,
            )
            .remark(format!("{:.2} instead of {:.2}", cured.slides[1], plain.slides[1])),
        );
    }
    Ok(Findings { checks, tables: vec![table], pictures: Vec::new() })
}
