//! Load steps of all sizes, laws at their limits, strains that are tiny or come back.

use super::{effort, reason, run_plane, scene, variant};
use crate::cases::simple_stretch::inhomogeneity;
use crate::cases::{fixed, largest, scientific, sweep};
use crate::history::History;
use crate::scenes::{load, with_cuts};
use crate::variants::{
    ALL, CPDI1, CPDI2Q, GIMP, Method, PlaneScene, SMPM, in_steps, plane, refined, with_points,
};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{FieldInput, MaterialInput, Scene};
use mpm_solver::observe::Field;

pub(super) const STEPS: Case = Case {
    name: "sizes of load steps",
    goal: "Long load steps are cut until they can be solved, short ones need no cut; which sizes converge is told.",
    setup: "Column (hard), collapse, cantilever with 2² points and simple stretch (free sides), in 1 to 200 load steps with up to ten halvings, ghost stabilisation in the first three; GIMP (simple stretch: sMPM).",
    reference: "Completion. The answers of many steps agree with each other; that of few shows the error of the step. (The simple stretch: see the next part.)",
    run: steps,
};

pub(super) const ROUNDING: Case = Case {
    name: "rounding, from step to step",
    goal: "What becomes of the last digit where perfect plasticity leaves no stiffness but that of the stress: a disturbance that grows by a factor per load step, however small the step, is the method's; one that grows with the load is the body's (necking).",
    setup: "The simple stretch with free sides, homogeneous to rounding until it yields at a third of the load, in 40, 80 and 160 load steps.",
    reference: "CPDI1 and CPDI2q on the slides' 2 × 2 cells stay homogeneous to 10⁻⁹ in any number of load steps. The others are reported. In standard MPM a point that stands off by δ changes the forces of its nodes by V σ ∇∇N δ, and a body that yields answers with a displacement of the size of δ: in every load step, whatever its size. Where domains tile a body, what one of them loses its neighbour gains. On 8 × 8 cells there is room for a neck, and CPDI1 takes it, too: which part of that is the body's is not told apart here.",
    run: rounding,
};

pub(super) const EXTREMES: Case = Case {
    name: "laws at their limits",
    goal: "All but incompressible, all but rigid, very soft, very heavy: the same digits, or a named reason.",
    setup: "The collapse on 8 × 8 cells (GIMP, 10 load steps) with ν up to 0.4999 and E/ρ_y from 1 to 10⁶ at a fixed load; with E, ρ_y and density together over 15 and 12 decades.",
    reference: "Completion; with all forces scaled alike the positions are the same.",
    run: extremes,
};

pub(super) const TINY: Case = Case {
    name: "tiny strains",
    goal: "Strains of 10⁻¹⁰ keep their digits.",
    setup: "A square between rollers, elastic, stretched by 10⁻¹⁰ of its length in 10 load steps; every basis.",
    reference: "E ln λ/λ from the exact series; the reaction, which lives on the mesh of the start of the last load step, differs from it by the strain.",
    run: tiny,
};

pub(super) const CYCLES: Case = Case {
    name: "a thousand load steps to and fro",
    goal: "An elastic body does not drift; a plastic one settles into a cycle.",
    setup: "The simple stretch on rollers, stretched by 10 % and back 50 times in 1000 load steps; elastic, and with a yield radius that it passes.",
    reference: "Elastic: the stress at the end of each cycle is zero (over the peak). Plastic: the reaction at the end of the last cycle is that of the second.",
    run: cycles,
};

type SceneOf = fn() -> Result<PlaneScene, Broken>;

fn steps(extent: Extent) -> Result<Findings, Broken> {
    let counts: &[u32] = extent.pick(&[1, 20], &[1, 2, 5, 10, 20, 40, 80, 200]);
    let problems: [(&str, SceneOf, usize); 4] = [
        ("column, hard: height", || Ok(variant(&plane(load("column")?)?, &GIMP, true)), 1),
        ("collapse: largest x", || Ok(variant(&plane(load("collapse")?)?, &GIMP, true)), 0),
        ("cantilever: largest x", || Ok(variant(&with_points(plane(load("cantilever")?)?, 2), &GIMP, true)), 0),
        ("simple stretch: largest x", || plane(load("simple_stretch")?), 0),
    ];
    let mut findings = Findings::default();
    let mut table = Table::new(
        "Runs in N load steps:",
        &["problem", "N", "reaches its end", "load steps taken", "halvings", "linear solutions", "answer"],
    );
    for (name, problem, component) in problems {
        let runs = sweep(counts, |&count| {
            let scene = with_cuts(Scene::PlaneStrain(in_steps(problem()?, count)), 10);
            crate::scenes::run(&scene)
        })?;
        for (count, run) in counts.iter().zip(&runs) {
            let [solves, cuts] = effort(&run.history);
            let answer = largest(run.history.last().positions.iter().skip(component).step_by(3).copied());
            table.push([
                name.to_owned(),
                count.to_string(),
                if run.outcome.is_ok() { "yes".into() } else { reason(run) },
                (run.history.rows().len() - 1).to_string(),
                cuts.to_string(),
                solves.to_string(),
                fixed(answer, 4),
            ]);
        }
        let from_twenty = counts.iter().zip(&runs).filter(|(count, _)| **count >= 20);
        let stopped = from_twenty.filter(|(_, run)| run.outcome.is_err()).count();
        findings.checks.push(Check::none(format!("{name}: runs in 20 load steps or more that stop"), stopped));
    }
    findings.tables.push(table);
    Ok(findings)
}

fn rounding(extent: Extent) -> Result<Findings, Broken> {
    let counts: &[u32] = extent.pick(&[40], &[40, 80, 160]);
    let mut findings = Findings::default();
    let mut heads = vec!["variant".to_owned(), "cells".to_owned()];
    heads.extend(counts.iter().map(|count| format!("{count} load steps")));
    let mut table = Table::new(
        "How much F differs between points at the end; in brackets the factor by which that grows in a load step, where it grows from 10⁻¹³ to 10⁻⁴:",
        &heads.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    let square = plane(load("simple_stretch")?)?;
    let mut variants: Vec<(String, u32, PlaneScene)> = Vec::new();
    for method in &ALL {
        let scene = method.of(square.clone());
        variants.push((method.name.into(), 2, scene.clone()));
        variants.push((method.name.into(), 4, refined(scene, 2)));
    }
    for method in [&SMPM, &GIMP, &CPDI1, &CPDI2Q] {
        variants.push((method.name.into(), 8, refined(method.of(square.clone()), 4)));
    }
    let fine = refined(square, 2);
    variants.push(("sMPM, 4² points".into(), 4, with_points(fine.clone(), 4)));
    variants.push(("sMPM, ghost stabilisation".into(), 4, variant(&fine, &SMPM, true)));
    variants.push(("sMPM, elastic".into(), 4, elastic(fine)));
    for (name, cells, scene) in variants {
        let runs = sweep(counts, |&count| run_plane(in_steps(scene.clone(), count)))?;
        let spreads: Vec<Vec<f64>> = runs.iter().map(|run| spreads(&run.history)).collect();
        let told = spreads.iter().zip(&runs).map(|(spreads, run)| {
            let last = scientific(spreads.last().copied().unwrap_or_default(), 1);
            let growth = growth(spreads).map_or(String::new(), |it| format!(" ({})", fixed(it, 2)));
            let stop = if run.outcome.is_ok() { "" } else { ", stops" };
            format!("{last}{growth}{stop}")
        });
        table.push([name.clone(), format!("{cells} × {cells}")].into_iter().chain(told));
        if cells == 2 && [CPDI1.name, CPDI2Q.name].contains(&name.as_str()) {
            let worst = largest(spreads.into_iter().flatten());
            findings.checks.push(Check::new(format!("{name}: largest difference of F"), worst, 1e-9));
        }
    }
    findings.tables.push(table);
    Ok(findings)
}

/// The scene with its bodies elastic.
fn elastic(mut scene: PlaneScene) -> PlaneScene {
    for material in scene.materials.values_mut() {
        if let MaterialInput::VonMises { young, poisson, density, .. } = material.clone() {
            *material = MaterialInput::Hencky { young, poisson, gradient: None, density };
        }
    }
    scene.output.fields.retain(|field| !matches!(field, FieldInput::Plastic | FieldInput::Rho));
    scene
}

/// How much the deformation gradient differs between points after each load step.
fn spreads(history: &History) -> Vec<f64> {
    (1..history.rows().len()).map(|row| inhomogeneity(history, row)).collect()
}

/// Mean factor by which values grow from one to the next, over those between 1e-13 (rounding) and 1e-4.
fn growth(values: &[f64]) -> Option<f64> {
    let small = |it: &f64| (1e-13..1e-4).contains(it);
    let (first, last) = (values.iter().position(small)?, values.iter().rposition(small)?);
    (last >= first + 4).then(|| (values[last] / values[first]).powf(1.0 / (last - first) as f64))
}

/// The collapse with another law and gravity.
fn collapse(young: f64, poisson: f64, yield_radius: f64, density: f64) -> Result<PlaneScene, Broken> {
    scene(&format!(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 16, cells: 16), Uniform(from: 0, to: 8, cells: 8)]),
            basis: Gimp,
            stabilisation: Ghost(),
            materials: {{ \"clay\": VonMises(young: {young:e}, poisson: {poisson}, yield_radius: {yield_radius:e}, density: {density:e}) }},
            bodies: [(name: \"block\", material: \"clay\", shape: Box(from: (0, 0), to: (8, 8)), points_per_cell: 2)],
            supports: [
                (name: \"base\", region: Plane(axis: Y, at: 0), fix: [Y]),
                (name: \"symmetry\", region: Plane(axis: X, at: 0), fix: [X]),
            ],
            loads: [BodyForce(acceleration: (0, -10))],
            schedule: (steps: 10),
            output: (fields: []),
        )"
    ))
}

fn extremes(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let mut table = Table::new(
        "Runs at the limits:",
        &["law", "reaches its end", "linear solutions", "halvings", "largest x"],
    );
    let mut tell = |what: String, run: &crate::scenes::Run| {
        let [solves, cuts] = effort(&run.history);
        let answer = largest(run.history.last().positions.iter().step_by(3).copied());
        let end = if run.outcome.is_ok() { "yes".into() } else { reason(run) };
        table.push([what, end, solves.to_string(), cuts.to_string(), fixed(answer, 6)]);
    };
    for poisson in extent.pick(&[0.4999][..], &[0.45, 0.49, 0.499, 0.4999]) {
        let run = run_plane(collapse(1e6, *poisson, 20e3, 1000.0)?)?;
        tell(format!("ν = {poisson}"), &run);
        let what = format!("ν = {poisson}: the collapse stops");
        findings.checks.push(Check::none(what, usize::from(run.outcome.is_err())).remark(reason(&run)));
    }
    // The load is that of ρ_y = 20·10³; the stiffness varies.
    for exponent in extent.pick(&[1, 6][..], &[0, 1, 2, 3, 4, 5, 6]) {
        let run = run_plane(collapse(20e3 * 10_f64.powi(*exponent), 0.3, 20e3, 500.0)?)?;
        tell(format!("E/ρ_y = 10^{exponent}"), &run);
        if *exponent >= 1 {
            let what = format!("E/ρ_y = 10^{exponent}: the collapse stops");
            findings.checks.push(Check::none(what, usize::from(run.outcome.is_err())).remark(reason(&run)));
        }
    }
    let reference = run_plane(collapse(1e6, 0.3, 20e3, 1000.0)?)?;
    for exponent in extent.pick(&[-9, 6][..], &[-9, -6, -3, 3, 6]) {
        let scale = 10_f64.powi(*exponent);
        let run = run_plane(collapse(1e6 * scale, 0.3, 20e3 * scale, 1000.0 * scale)?)?;
        tell(format!("E = {:e}, density {:e}", 1e6 * scale, 1000.0 * scale), &run);
        let expected = &reference.history.last().positions;
        let found = &run.history.last().positions;
        let apart = largest(expected.iter().zip(found).map(|(a, b)| (a - b).abs())) / 8.0;
        findings.checks.push(Check::new(
            format!("forces scaled by 10^{exponent}: positions (relative)"),
            apart,
            1e-9,
        ));
    }
    findings.tables.push(table);
    Ok(findings)
}

/// The simple stretch on rollers with a law, a displacement and its ramp.
fn stretch(law: &str, by: f64, ramp: &str, steps: u32) -> Result<PlaneScene, Broken> {
    scene(&format!(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
            motion: Stretch([(axis: X, anchor: 0, driven: 2, displacement: {by:e}{ramp})]),
            basis: Smpm,
            materials: {{ \"metal\": {law} }},
            bodies: [(name: \"square\", material: \"metal\", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
            supports: [
                (name: \"left\", region: Plane(axis: X, at: 0), fix: [X]),
                (name: \"bottom\", region: Plane(axis: Y, at: 0), fix: [Y]),
                (name: \"top\", region: Plane(axis: Y, at: 2), fix: [Y]),
                (name: \"pulled\", region: Plane(axis: X, at: 2), follow_mesh: [X]),
            ],
            schedule: (steps: {steps}),
            output: (fields: [CauchyStress]),
        )"
    ))
}

fn tiny(_: Extent) -> Result<Findings, Broken> {
    let strain = 1e-10_f64;
    // The mesh stays at rest, because a moving one rounds its positions and with them the prescribed displacements.
    let scene = scene(&format!(
        "PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
            basis: Smpm,
            materials: {{ \"metal\": Hencky(young: 1e3, poisson: 0) }},
            bodies: [(name: \"square\", material: \"metal\", shape: Box(from: (0, 0), to: (2, 2)), points_per_cell: 2)],
            supports: [
                (name: \"left\", region: Plane(axis: X, at: 0), fix: [X]),
                (name: \"rollers\", region: Everywhere, fix: [Y]),
                (name: \"pulled\", region: Plane(axis: X, at: 2), displace: [(axis: X, by: {:e})]),
            ],
            schedule: (steps: 10),
            output: (fields: [CauchyStress]),
        )",
        2.0 * strain
    ))?;
    let stretch = 10.0 * (0.1 * strain).ln_1p();
    let expected = 1e3 * stretch * (-stretch).exp();
    let mut findings = Findings::default();
    for method in ALL {
        let run = run_plane(variant(&scene, &method, false))?;
        if run.outcome.is_err() {
            findings.checks.push(Check::none(format!("{}: stops", method.name), 1).remark(reason(&run)));
            continue;
        }
        let stress = run.history.field(Field::CAUCHY_STRESS, 10);
        let error = largest(stress.iter().step_by(9).map(|s| (s / expected - 1.0).abs()));
        let reaction = run.history.series("reaction/pulled", 0)[10] / 2.0;
        findings.checks.push(Check::new(
            format!("{}: stress in every point (relative)", method.name),
            error,
            1e-9,
        ));
        let error = (reaction / expected - 1.0).abs();
        findings.checks.push(Check::new(format!("{}: reaction (relative)", method.name), error, 1e-9));
    }
    Ok(findings)
}

fn cycles(extent: Extent) -> Result<Findings, Broken> {
    let (count, steps) = extent.pick((5, 100), (50, 1000));
    let knots: Vec<String> =
        (0..=2 * count).map(|k| format!("({}, {})", f64::from(k) / f64::from(2 * count), k % 2)).collect();
    let ramp = format!(", ramp: [{}]", knots.join(", "));
    let per_cycle = (steps / count) as usize;
    let methods: &[Method] = extent.pick(&[SMPM, CPDI1], &ALL);
    let mut findings = Findings::default();
    for method in methods {
        for (law, name) in [
            ("Hencky(young: 1e3, poisson: 0.3)", "elastic"),
            ("VonMises(young: 1e3, poisson: 0.3, yield_radius: 30)", "plastic"),
        ] {
            let run = run_plane(variant(&stretch(law, 0.2, &ramp, steps)?, method, false))?;
            let what = format!("{}, {name}: ", method.name);
            if run.outcome.is_err() {
                findings.checks.push(Check::none(format!("{what}stops"), 1).remark(reason(&run)));
                continue;
            }
            let force = run.history.series("reaction/pulled", 0);
            let peak = largest(force.iter().map(|it| it.abs()));
            let ends: Vec<f64> = force.iter().step_by(per_cycle).copied().collect();
            let drift = if name == "elastic" {
                largest(ends.iter().map(|it| it.abs())) / peak
            } else {
                largest(ends[2..].iter().map(|it| (it - ends[2]).abs())) / peak
            };
            findings.checks.push(
                Check::new(format!("{what}drift of the reaction over its peak"), drift, 1e-9)
                    .remark(format!("{count} cycles, {steps} load steps, peak {}", scientific(peak, 5))),
            );
        }
    }
    Ok(findings)
}
