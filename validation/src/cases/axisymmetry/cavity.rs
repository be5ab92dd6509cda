//! Cavities, balls and cylinders, that are driven open to twice their radius.

use super::Rays;
use crate::cases::soil::cavity::{self, Pressed, RADII};
use crate::cases::{largest, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings};
use mpm_scene::Scene;
use std::f64::consts::{SQRT_2, TAU};

pub(in crate::cases) const CASE: Case = Case {
    name: "cavities of revolution",
    goal: "Balls and cylinders that are driven open to twice their radius, in sand under pressure and in unbounded clay, meet the pressures of one-dimensional solutions and of closed forms, and converge to them.",
    setup: "CPDI1, 2² points a cell, n cells along the radius, 100 load steps; the mesh follows. Balls: a quarter ring, n/2 cells around; cylinders: one row of cells between plates. *Under pressure*: from radius 1 to 10 (the last cell four times as long as the first) under σ₀ = −100 I, the outer face held; Mohr–Coulomb E = 10⁴, ν = 0.2, c = 1, φ = 30°, ψ = 10° with mean dilatation over points. *Unbounded*: from 1 to 400 (400 times as long), free outside, n/6 cells around the ball, G/s_u = 100, ν = 0.4995, Tresca and von Mises, mean dilatation of cells.",
    reference: "Under pressure: the same equations in one dimension, solved apart (800 elements, 800 load steps; changes below 1e-5 from half as many). In a ball von Mises' law is Tresca's where `ρ_y = √(2/3) 2 s_u`; in a cylinder of a material that keeps its volume where `ρ_y = √2 s_u`. Unbounded, once plastic: `p = s_u [1 + ln(G/s_u) + ln(1 − 1/a²)] + s_u²/4G` for the cylinder (Gibson & Anderson 1961), `p = (4/3) s_u [1 + ln(G/s_u) + ln(1 − 1/a³)] + s_u²/3G` for the ball.",
    run: cavities,
};

/// Pressures on balls at the radii `RADII`.
const SAND: [f64; 9] =
    [243.844, 321.538, 465.547, 615.084, 801.144, 1_016.911, 1_158.967, 1_276.218, 1_386.608];

/// A cavity: what is driven, in which law, with which averages, and what is found in the end.
struct Cavity {
    name: &'static str,
    is_ball: bool,
    law: String,
    mean: &'static str,
    is_unbounded: bool,
    reference: [f64; 9],
    /// Error allowed at n cells, times n².
    allowed: f64,
}

impl Cavity {
    fn scene(&self, cells: u32) -> Result<Scene, Broken> {
        let (end, ratio) = if self.is_unbounded { (400, 400) } else { (10, 4) };
        let radii = format!("Graded(from: 1, to: {end}, cells: {cells}, ratio: {ratio})");
        let sectors = self.sectors(cells);
        let (mesh, shape, motion, supports, far) = if self.is_ball {
            let rays = Rays::new(sectors).supports();
            (
                format!("Ring(radii: {radii}, sectors: {sectors}, angles: (0, 90))"),
                format!("Ring(inner: 1, outer: {end})"),
                format!("Expand(anchor: {end}, driven: 1, displacement: 1)"),
                format!("(name: \"floor\", region: Plane(axis: Z, at: 0), fix: [Z]), {rays}"),
                format!("(name: \"far\", region: Circle(radius: {end}), fix: [R, Z])"),
            )
        } else {
            (
                format!("Box(axes: [{radii}, Uniform(from: 0, to: {HEIGHT}, cells: 1)])"),
                format!("Box(from: (1, 0), to: ({end}, {HEIGHT}))"),
                format!("Stretch([(axis: R, anchor: {end}, driven: 1, displacement: 1)])"),
                "(name: \"plates\", region: Everywhere, fix: [Z]), \
                 (name: \"inner\", region: Plane(axis: R, at: 1), follow_mesh: [R]), "
                    .into(),
                format!("(name: \"far\", region: Plane(axis: R, at: {end}), fix: [R])"),
            )
        };
        let (far, initial) = if self.is_unbounded {
            (String::new(), "")
        } else {
            (far, ", initial: Stress(xx: -100, yy: -100, zz: -100)")
        };
        let (law, mean) = (&self.law, self.mean);
        Ok(Scene::from_ron(&format!(
            r#"Axisymmetric(
                mesh: {mesh}, motion: {motion}, basis: Cpdi1, materials: {{ "ground": {law} }},
                bodies: [(name: "ground", material: "ground", shape: {shape}, points_per_cell: 2,
                    mean_dilatation: {mean}{initial})],
                supports: [{supports}{far}],
                schedule: (steps: 100), output: (fields: []),
            )"#
        ))?)
    }

    fn sectors(&self, cells: u32) -> u32 {
        cells / if self.is_unbounded { 6 } else { 2 }
    }

    fn press(&self, cells: u32) -> Result<Pressed, Broken> {
        let history = run(&self.scene(cells)?)?.completed()?;
        let forces = if self.is_ball {
            Rays::new(self.sectors(cells)).force(&history)
        } else {
            history.series("reaction/inner", 0)
        };
        let pressure =
            |radius: f64, force: f64| force / (TAU * radius * if self.is_ball { radius } else { HEIGHT });
        let radii = history.rows().iter().map(|row| 1.0 + row.fraction);
        let path = radii.zip(forces).map(|(radius, force)| (radius, pressure(radius, force))).collect();
        Ok(Pressed { path, history })
    }
}

/// Height of the row of cells of a cylinder.
const HEIGHT: f64 = 0.25;

/// Radii of von Mises' law that are Tresca's strength 1: in a ball, and in a cylinder that keeps its volume.
const BALL: f64 = 2.0 * 0.816_496_580_927_726;
const CYLINDER: f64 = SQRT_2;

fn under_pressure() -> Vec<Cavity> {
    let cavity = |name, is_ball, reference, allowed| Cavity {
        name,
        is_ball,
        law: "MohrCoulomb(young: 1e4, poisson: 0.2, cohesion: 1, friction: 30, dilation: 10)".into(),
        mean: "Points",
        is_unbounded: false,
        reference,
        allowed,
    };
    vec![
        cavity("cylinder, Mohr–Coulomb", false, cavity::SAND, 1.2),
        cavity("ball, Mohr–Coulomb", true, SAND, 6.0),
    ]
}

fn unbounded() -> Vec<Cavity> {
    const STIFFNESS: &str = "young: 299.9, poisson: 0.4995";
    let cylinder = |a: f64| 1.0 + 100.0_f64.ln() + (1.0 - 1.0 / (a * a)).ln() + 1.0 / 400.0;
    let ball = |a: f64| 4.0 / 3.0 * (1.0 + 100.0_f64.ln() + (1.0 - 1.0 / (a * a * a)).ln()) + 1.0 / 300.0;
    let tresca = format!("Tresca({STIFFNESS}, undrained_strength: 1)");
    let mises = |radius: f64| format!("VonMises({STIFFNESS}, yield_radius: {radius})");
    let cavity = |name, is_ball, law, reference, allowed| Cavity {
        name,
        is_ball,
        law,
        mean: "Cell",
        is_unbounded: true,
        reference,
        allowed,
    };
    vec![
        cavity("unbounded cylinder, Tresca", false, tresca.clone(), RADII.map(cylinder), 10.0),
        cavity("unbounded cylinder, von Mises", false, mises(CYLINDER), RADII.map(cylinder), 10.0),
        cavity("unbounded ball, Tresca", true, tresca, RADII.map(ball), 16.0),
        cavity("unbounded ball, von Mises", true, mises(BALL), RADII.map(ball), 16.0),
    ]
}

fn cavities(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    for (cavities, meshes) in [
        (under_pressure(), extent.pick(&[16, 32][..], &[16, 32, 64])),
        (unbounded(), extent.pick(&[24, 48], &[24, 48, 96])),
    ] {
        let jobs: Vec<(&Cavity, u32)> =
            cavities.iter().flat_map(|it| meshes.iter().map(move |&cells| (it, cells))).collect();
        let runs = sweep(&jobs, |(cavity, cells)| cavity.press(*cells))?;
        for (it, runs) in cavities.iter().zip(runs.chunks(meshes.len())) {
            findings.tables.push(cavity::table(it.name, &it.reference, meshes, runs));
            for (&cells, run) in meshes.iter().zip(runs) {
                let worst = largest(run.errors(&it.reference).iter().map(|error| error.abs()));
                let what =
                    format!("{}, {cells} cells: pressure, worst of {} radii (relative)", it.name, RADII.len());
                let tolerance = it.allowed / f64::from(cells * cells);
                findings.checks.push(Check::new(what, worst, tolerance));
            }
        }
    }
    Ok(findings)
}
