//! What the error of the elastic doughnut is made of.

use super::super::{largest, scientific, sweep};
use super::at_stations;
use crate::problems::doughnut::ring;
use crate::reference::Reference;
use crate::scenes::run;
use crate::variants::{CPDI1, CPDI2Q, GENERAL, Method, SMPM, in_steps, with_points};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;

pub(in super::super) const CASE: Case = Case {
    name: "doughnut twist, error by cause",
    goal: "How much of the elastic torque's error is due to the load step, to the cells, and (with standard MPM) to points that drift through their cells?",
    setup: "The elastic doughnut to 20° in 20, 40 and 80 load steps on 5 × 32 cells and finer by 2, 4 and 8 (there 20 and 40 steps); 2² points a cell. Standard MPM with up to 24² points as well.",
    reference: "The converged one-dimensional torque at every degree. The error of the step is of first order, so that of the cells is what remains when it is extrapolated to no step at all: 2 e(Δα/2) - e(Δα).",
    run: refinement,
};

/// Relative error of the torque at every degree; not a number from where the run ended.
fn errors(method: &Method, factor: u32, points: u32, steps: u32) -> Result<Vec<f64>, Broken> {
    let mut scene = in_steps(with_points(ring(method, factor)?, points), steps);
    scene.output.fields.clear();
    let history = run(&Scene::PlaneStrain(scene))?.history;
    let exact = Reference::read("doughnut_elastic_torque")?.column("torque")?;
    let mut errors: Vec<f64> =
        at_stations(&history, 20).iter().zip(&exact[1..]).map(|(torque, exact)| torque / exact - 1.0).collect();
    errors.resize(20, f64::NAN);
    Ok(errors)
}

fn told(error: f64) -> String {
    if error.is_nan() { "-".into() } else { format!("{error:+.2e}") }
}

fn refinement(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    by_step(extent, &mut findings)?;
    by_points(extent, &mut findings)?;
    Ok(findings)
}

const STEPS: [u32; 3] = [20, 40, 80];

/// Errors at 20° on one mesh, in as many load steps as [`STEPS`] says.
struct Cells {
    factor: u32,
    errors: Vec<f64>,
}

impl Cells {
    /// The error without any step.
    fn extrapolated(&self) -> f64 {
        let n = self.errors.len();
        2.0 * self.errors[n - 1] - self.errors[n - 2]
    }

    /// The part of the error in 20 load steps that is due to their length.
    fn of_step(&self) -> f64 {
        self.errors[0] - self.extrapolated()
    }
}

fn by_step(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let methods = extent.pick(vec![CPDI1, CPDI2Q], GENERAL.to_vec());
    let factors: &[u32] = extent.pick(&[1], &[1, 2, 4, 8]);
    let steps = |factor: u32| if factor < 8 { &STEPS[..] } else { &STEPS[..2] };
    let mut jobs: Vec<(&Method, u32, u32)> = Vec::new();
    for method in &methods {
        for &factor in factors {
            jobs.extend(steps(factor).iter().map(|&steps| (method, factor, steps)));
        }
    }
    let found = sweep(&jobs, |&(method, factor, steps)| Ok(errors(method, factor, 2, steps)?[19]))?;
    let mut found = found.into_iter();

    let mut table = Table::new(
        "Relative error of the torque at 20° by the number of load steps. In parentheses the order in h of what remains without a step. The error of the step falls with the cells, too. With triangles the rest is of second order; with quadrilaterals it changes sign, and with them and parallelograms it falls slowly once it is about 10⁻⁴. The error of standard MPM is neither the step's nor the cells'.",
        &["basis", "cells", "20 steps", "40 steps", "80 steps", "no step (order)", "of the step, 20 steps"],
    );
    for method in &methods {
        let mut before: Option<f64> = None;
        let mut shares = Vec::new();
        for &factor in factors {
            let errors: Vec<f64> = found.by_ref().take(steps(factor).len()).collect();
            let cells = Cells { factor, errors };
            let rest = cells.extrapolated();
            let order = before.map(|coarse| (coarse / rest).abs().log2()).filter(|order| order.is_finite());
            let order = order.map_or(String::new(), |order| format!(" ({order:.1})"));
            let error = |k: usize| cells.errors.get(k).map_or(String::new(), |&error| told(error));
            table.push([
                method.name.into(),
                format!("{} × {}", 5 * cells.factor, 32 * cells.factor),
                error(0),
                error(1),
                error(2),
                format!("{}{order}", told(rest)),
                told(cells.of_step()),
            ]);
            if factor == 1 && (*method == CPDI1 || *method == CPDI2Q) {
                let order = ((cells.errors[0] - cells.errors[1]) / (cells.errors[1] - cells.errors[2])).log2();
                let what = format!("{}, 5 × 32: order of the step's error against 1", method.name);
                findings.checks.push(Check::new(what, (order - 1.0).abs(), 0.1).remark(format!("{order:.2}")));
            }
            before = Some(rest);
            shares.push(cells.of_step().abs());
        }
        if extent == Extent::Full && *method != SMPM {
            let rising = shares.windows(2).filter(|pair| pair[1].is_nan() || pair[1] >= pair[0]).count();
            let what = format!(
                "{}: meshes on which the step's error is not smaller than on coarser ones",
                method.name
            );
            let told = shares.iter().map(|&share| scientific(share, 2)).collect::<Vec<_>>().join(", ");
            findings.checks.push(Check::none(what, rising).remark(told));
        }
    }
    findings.tables.push(table);
    Ok(())
}

/// Standard MPM with several numbers of points.
fn by_points(extent: Extent, findings: &mut Findings) -> Result<(), Broken> {
    let mut jobs = vec![(1, 2), (1, 12)];
    if extent == Extent::Full {
        jobs = vec![(1, 2), (1, 6), (1, 12), (1, 24), (2, 2), (2, 6), (2, 12), (8, 2), (8, 3), (8, 4)];
    }
    let found = sweep(&jobs, |&(factor, points)| errors(&SMPM, factor, points, 20))?;
    let of = |job: (u32, u32)| {
        let at = jobs.iter().position(|it| *it == job);
        at.map(|at| &found[at]).ok_or("no such job")
    };
    let (few, many) = (of((1, 2))?, of((1, 12))?);
    findings.checks.push(
        Check::new("sMPM, 5 × 32, 2² points: error at 1°, before points have drifted", few[0].abs(), 1e-3)
            .remark(told(few[0])),
    );
    findings.checks.push(
        Check::new(
            "sMPM, 5 × 32: error at 20° with 12² points over that with 2²",
            (many[19] / few[19]).abs(),
            0.7,
        )
        .remark(format!("{} instead of {}", told(many[19]), told(few[19]))),
    );
    if extent == Extent::Full {
        let lost = of((8, 3))?.iter().chain(of((8, 4))?).filter(|error| error.is_nan()).count();
        let what = "sMPM, 40 × 256: degrees not reached with 3² and 4² points (2² end at 18°)";
        findings.checks.push(Check::none(what, lost));
        let (coarse, fine) =
            (largest(few.iter().map(|e| e.abs())), largest(of((2, 2))?.iter().map(|e| e.abs())));
        findings.checks.push(
            Check::new(
                "sMPM, 2² points: largest error of all degrees on 10 × 64 over that on 5 × 32, above a half",
                f64::max(0.0, 0.5 - fine / coarse),
                0.0,
            )
            .remark(format!(
                "{} instead of {}: finer cells do not help",
                scientific(fine, 2),
                scientific(coarse, 2)
            )),
        );
    }
    let mut table = Table::new(
        "Why standard MPM stays at about one per cent: relative error of the torque by angle and points. The mesh turns along linearly in r, the material does not, so points drift through the cells around the ring. As integration points off their places they make cells too stiff, with the square of the drift, until they cross and others take their places: a saw-tooth (5 × 32, 2²: up to 12°, then 14°). Drift over a cell's length is the larger the finer the cells, so refinement is no help; more points are, slowly, as the drift between two crossings is shorter. On 40 × 256 cells with 2² points a whole row of points leaves its row of cells at 17° (it has moved outward by a quarter of a cell of 0.125): the 512 points that stay behind have to carry twice their stress (a shear stress of 2.7·10⁵ there, and the law bears hardly more than 5.6·10⁵), are torn apart to 2.7 times their volume in the next step, and then no load step, however short, finds an equilibrium. With 3² or 4² points the row that is left behind is not torn, but gives way: the run reaches its end with a torque that is 3 to 4 % too low.",
        &["cells", "points", "1°", "4°", "8°", "12°", "14°", "16°", "20°"],
    );
    for (&(factor, points), errors) in jobs.iter().zip(&found) {
        let at = [1, 4, 8, 12, 14, 16, 20].map(|degree: usize| told(errors[degree - 1]));
        table.push([format!("{} × {}", 5 * factor, 32 * factor), format!("{points}²")].into_iter().chain(at));
    }
    findings.tables.push(table);
    Ok(())
}
