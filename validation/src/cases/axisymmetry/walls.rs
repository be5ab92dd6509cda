//! Thick walls against closed forms.

use super::Rays;
use crate::cases::{fixed, scientific, sweep};
use crate::scenes::run;
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::Scene;
use std::f64::consts::TAU;

pub(in crate::cases) const CASE: Case = Case {
    name: "thick walls of revolution",
    goal: "In the half plane (r, z) the pressure in a cylinder and in a sphere converges to that of the closed forms, elastic and plastic, for every basis with domains.",
    setup: "A cylinder 1 < r < 3 between plates, its outside held, its inside driven by 0.3 in 6 load steps while the mesh follows, 8, 16 and 32 cells; a quarter ring 1 < R < 3 of 6², 12² and 24² cells, whose rotation is a hollow sphere with a free outside, its inside driven by 0.01 while the mesh follows, elastic in 1 load step and with ρ_y = 4 in 20. The same ball at finite strain, with mean dilatation: driven by 0.3 in 6 load steps, elastic, its outside held or free, and by 0.2 in 40, with ρ_y = √(2/3) 10 and √(2/3) 2, its outside free; free outsides move into cells beyond R = 3, with ghost faces. E = 10³, ν = 0.3, 2² points a cell.",
    reference: "Equilibrium in logarithmic strains, integrated to eleven digits: 321.750314652756 in the cylinder; 14.2795847801202 and, plastic to R = 2.02, 7.07869109172407 in the sphere; at finite strain 407.482644535429 and 289.977335210174, and, plastic throughout, 18.5690234684744 and 3.70329587662559.",
    run: walls,
};

/// Pressure inside the cylinder.
const CYLINDER: f64 = 321.750_314_652_756;

/// A hollow sphere, 1 < R < 3, that is driven open.
#[derive(Clone, Copy)]
struct Sphere {
    basis: &'static str,
    averages: bool,
    /// ρ_y; none of an elastic one.
    yields: Option<f64>,
    by: f64,
    steps: u32,
    outside: Outside,
    /// Pressure inside.
    exact: f64,
}

/// What the outside of a sphere does.
#[derive(Clone, Copy, PartialEq)]
enum Outside {
    /// It is free, and moves by so little that the mesh can end there.
    Still,
    Free,
    Held,
}

fn cylinder(basis: &str, cells: u32) -> Result<f64, Broken> {
    let height = 2.0 / f64::from(cells);
    let history = run(&Scene::from_ron(&format!(
        r#"Axisymmetric(
            mesh: Box(axes: [Uniform(from: 1, to: 3, cells: {cells}), Uniform(from: 0, to: {height}, cells: 1)]),
            motion: Stretch([(axis: R, anchor: 3, driven: 1, displacement: 0.3)]),
            basis: {basis}, materials: {{ "m": Hencky(young: 1000, poisson: 0.3) }},
            bodies: [(name: "wall", material: "m", shape: Box(from: (1, 0), to: (3, {height})), points_per_cell: 2)],
            supports: [
                (name: "plates", region: Everywhere, fix: [Z]),
                (name: "inner", region: Plane(axis: R, at: 1), follow_mesh: [R]),
                (name: "outer", region: Plane(axis: R, at: 3), fix: [R]),
            ],
            schedule: (steps: 6), output: (fields: []),
        )"#
    ))?)?
    .completed()?;
    let force = history.series("reaction/inner", 0).last().copied().unwrap_or(f64::NAN);
    Ok(force / (TAU * 1.3 * height))
}

impl Sphere {
    fn pressure(self, cells: u32) -> Result<f64, Broken> {
        let Self { basis, by, steps, outside, .. } = self;
        let law = match self.yields {
            Some(radius) => format!("VonMises(young: 1000, poisson: 0.3, yield_radius: {radius:?})"),
            None => "Hencky(young: 1000, poisson: 0.3)".into(),
        };
        let mean = if self.averages { ", mean_dilatation: Points" } else { "" };
        let rays = Rays::new(cells);
        let supports = rays.supports();
        let beyond = if outside == Outside::Free { cells / 6 } else { 0 };
        let (end, lines) = (3.0 + 2.0 * f64::from(beyond) / f64::from(cells), cells + beyond);
        let (ghost, held) = match outside {
            Outside::Still => ("", ""),
            Outside::Free => ("stabilisation: Ghost(factor: 0.001),", ""),
            Outside::Held => ("", "(name: \"outside\", region: Circle(radius: 3), fix: [R, Z])"),
        };
        let history = run(&Scene::from_ron(&format!(
            r#"Axisymmetric(
                mesh: Ring(radii: Uniform(from: 1, to: {end:?}, cells: {lines}), sectors: {cells}, angles: (0, 90)),
                motion: Expand(anchor: {end:?}, driven: 1, displacement: {by}),
                basis: {basis}, {ghost} materials: {{ "m": {law} }},
                bodies: [(name: "ball", material: "m", shape: Ring(inner: 1, outer: 3), points_per_cell: 2{mean})],
                supports: [(name: "floor", region: Plane(axis: Z, at: 0), fix: [Z]), {supports} {held}],
                schedule: (steps: {steps}), output: (fields: []),
            )"#
        ))?)?
        .completed()?;
        let force = rays.force(&history).last().copied().unwrap_or(f64::NAN);
        Ok(force / (TAU * (1.0 + by) * (1.0 + by)))
    }

    fn name(self) -> String {
        let law = if self.yields.is_some() { "plastic" } else { "elastic" };
        let mean = if self.averages { ", mean dilatation" } else { "" };
        let outside = match (self.outside, self.yields) {
            (Outside::Still, _) => String::new(),
            (Outside::Held, _) => format!(", by {}, outside held", self.by),
            (Outside::Free, None) => format!(", by {}, outside free", self.by),
            (Outside::Free, Some(radius)) => {
                format!(", ρ_y = {}, by {}, outside free", fixed(radius, 3), self.by)
            }
        };
        format!("sphere, {}, {law}{mean}{outside}", self.basis)
    }
}

/// Spheres at small strains, then at finite ones.
fn spheres() -> Vec<Sphere> {
    let of = |basis| {
        let small = |averages, yields, steps, exact| Sphere {
            basis,
            averages,
            yields,
            by: 0.01,
            steps,
            outside: Outside::Still,
            exact,
        };
        let finite = |yields: Option<f64>, (by, steps), outside, exact| Sphere {
            basis,
            averages: true,
            yields: yields.map(|stress| (2.0_f64 / 3.0).sqrt() * stress),
            by,
            steps,
            outside,
            exact,
        };
        [
            small(false, None, 1, 14.279_584_780_120_2),
            small(true, None, 1, 14.279_584_780_120_2),
            small(true, Some(4.0), 20, 7.078_691_091_724_07),
            finite(None, (0.3, 6), Outside::Held, 407.482_644_535_429),
            finite(None, (0.3, 6), Outside::Free, 289.977_335_210_174),
            finite(Some(10.0), (0.2, 40), Outside::Free, 18.569_023_468_474_4),
            finite(Some(2.0), (0.2, 40), Outside::Free, 3.703_295_876_625_59),
        ]
    };
    ["Cpdi1", "Cpdi2q"].into_iter().flat_map(of).collect()
}

/// Errors on the meshes and the order of the last two.
fn converge(
    what: &str,
    errors: &[f64],
    (cells, finest, order): (&[u32], f64, f64),
    table: &mut Table,
    findings: &mut Findings,
) {
    for (k, (cells, error)) in cells.iter().zip(errors).enumerate() {
        let shown = if k == 0 { "".into() } else { fixed((errors[k - 1] / error).abs().log2(), 2) };
        table.push([what.to_owned(), cells.to_string(), scientific(*error, 3), shown]);
    }
    // The same cells in both extents.
    let (coarse, fine) = (errors[0].abs(), errors[1].abs());
    findings.checks.push(Check::new(format!("{what}, {} cells: pressure (relative)", cells[1]), fine, finest));
    let lack = (order - (coarse / fine).log2()).max(0.0);
    findings.checks.push(Check::new(
        format!("{what}: order from {} and {} cells, lack below {order}", cells[0], cells[1]),
        lack,
        0.0,
    ));
}

fn walls(extent: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    let heads = ["what", "cells", "error of the pressure", "order"];
    let mut table = Table::new("Pressures inside against the closed forms:", &heads);
    let bases = ["Gimp", "Cpdi1", "Cpdi2q", "Cpdi2t"];
    let cells = extent.pick(&[8, 16][..], &[8, 16, 32]);
    let jobs: Vec<(&str, u32)> =
        bases.iter().flat_map(|basis| cells.iter().map(move |&cells| (*basis, cells))).collect();
    let runs = sweep(&jobs, |(basis, cells)| cylinder(basis, *cells))?;
    for (basis, runs) in bases.iter().zip(runs.chunks(cells.len())) {
        let errors: Vec<f64> = runs.iter().map(|pressure| pressure / CYLINDER - 1.0).collect();
        // GIMP's boxes do not follow the shape of the points at the inside as parallelograms do.
        converge(&format!("cylinder, {basis}"), &errors, (cells, 1e-3, 1.8), &mut table, &mut findings);
    }
    let spheres = spheres();
    let cells = extent.pick(&[6, 12][..], &[6, 12, 24]);
    let jobs: Vec<(Sphere, u32)> =
        spheres.iter().flat_map(|it| cells.iter().map(move |&cells| (*it, cells))).collect();
    let runs = sweep(&jobs, |(sphere, cells)| sphere.pressure(*cells))?;
    for (it, runs) in spheres.iter().zip(runs.chunks(cells.len())) {
        let errors: Vec<f64> = runs.iter().map(|pressure| pressure / it.exact - 1.0).collect();
        converge(&it.name(), &errors, (cells, 0.01, 1.4), &mut table, &mut findings);
    }
    findings.tables.push(table);
    Ok(findings)
}
