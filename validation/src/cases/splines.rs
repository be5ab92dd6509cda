//! Problems on splines: the column, a ring of circles, the patch test.

use super::column::solid_column;
use super::{largest, relative, scientific, sweep};
use crate::history::History;
use crate::probe::{Probe, plane as model_of};
use crate::problems::column::{HEIGHT, Load, column, stress_error};
use crate::problems::doughnut::torque;
use crate::problems::held_circles::HeldCircles;
use crate::problems::vortex::{Errors, errors, exact, vortex};
use crate::reference::Reference;
use crate::scenes::{compiled, load_own, run};
use crate::variants::{CPDI1, CPDI2Q, Method, plane, refined};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_grid::{Block, LoadFraction, Vector};
use mpm_material::SymmetricTensor;
use mpm_scene::Compiled;
use mpm_scene::language::{
    Count, Finite, FunctionsInput, MaterialInput, MeshInput, Positive, RegionInput, Scene, SceneIn, ShapeInput,
    SolidBasis, StabilisationInput, TilingInput,
};
use mpm_solver::BodyForce;
use mpm_solver::observe::Field;
use std::f64::consts::PI;
use std::sync::Arc;

pub(super) const COLUMN: Case = Case {
    name: "self-weight column on splines",
    goal: "Splines sampled at the corners of domains are those of an independent implementation, digit for digit, and stress is of second order.",
    setup: "The self-weight column on splines of degree 1, 2 and 3, 2 and 3 points a cell and direction, residual 10⁻¹²; CPDI1, CPDI2q, and in space CPDI1 and hexahedra. Columns of degree 3 with 2 points a cell are two cells wide. Then with the body force ρ0 g (1 + 0.8 cos(3πY/50)).",
    reference: "Errors of the stress and positions of `reference/splines_column.csv`; a difference of 10⁻¹³ of the load is allowed on top of 10⁻⁸ of the error. With the varying force σ_yy = −ρ0 g (50 − Y − 40/(3π) sin(3πY/50)).",
    run: columns,
};

pub(super) const RING: Case = Case {
    name: "ring of splines",
    goal: "Trigonometric splines make a circle exact: the inner circle of a ring turns in a mesh that stays, and a stressed ring turns as a whole.",
    setup: "The elastic doughnut on 5 × 32 and 10 × 64 (20 × 128 in the full run) cells between circles, 2² points a cell, 20 load steps. A ring, unevenly strained, is then turned by 360° in increments of 30°.",
    reference: "Torque of the one-dimensional solution, 6.764337140e7, and its relative error in an independent implementation, where points have the volumes of sectors; those of their polygons are smaller by sin(π/n)/(π/n). The stress before, turned.",
    run: rings,
};

pub(super) const PATCH: Case = Case {
    name: "patch test on splines",
    goal: "A deformation that is the same everywhere is found exactly on control points that move.",
    setup: "A block of graded cells in a mesh whose corners move by a linear field with stretch, shear and rotation in three load steps; its faces follow. Elastic and von Mises; CPDI1 and CPDI2q; degrees 2 and 3.",
    reference: "The deformation gradient of the linear field at every point; the same stress at every point.",
    run: patches,
};

pub(super) const VORTEX: Case = Case {
    name: "generalised vortex on splines",
    goal: "Large shear and rotation on splines in a mesh that stays: stress is of second order.",
    setup: "The generalised vortex, a quarter of a radian in 20 load steps, on splines of degree 2 on [-1.5, 1.5]², 24² and 48² cells (CPDI2q in the full run also 96²); domains are polar tiles half a cell wide. Corners on the edges of the ring are held by springs of 10 E/h per length: nothing moves there in the exact solution, and no traction acts. CPDI2q, and CPDI1 with ghost faces.",
    reference: "The exact motion and its stress; relative mean-square errors of an independent implementation, whose tiles are 1 % wider, turned by a part of a tile, and have the volumes of sectors.",
    run: vortices,
};

/// The scene with splines and so many points a cell and direction.
fn on_splines<const D: usize, B>(scene: &mut SceneIn<D, B>, degree: u32, points_per_cell: u32) {
    let (MeshInput::Box { functions, .. } | MeshInput::Ring { functions, .. }) = &mut scene.mesh;
    *functions = FunctionsInput::Splines { degree: Count(degree) };
    for body in &mut scene.bodies {
        body.points_per_cell = Some(Count(points_per_cell));
    }
    scene.tolerance.residual = Positive(1e-12);
}

/// The column on splines; two cells wide where one would have fewer columns of corners than splines.
fn spline_column(
    load: Load,
    method: &Method,
    cells: u32,
    (degree, points_per_cell): (u32, u32),
) -> Result<Scene, Broken> {
    let mut scene = plane(column(load, method, cells)?)?;
    on_splines(&mut scene, degree, points_per_cell);
    if points_per_cell < degree {
        let width = 2.0 * HEIGHT / f64::from(cells);
        if let MeshInput::Box { axes, .. } = &mut scene.mesh {
            crate::problems::column::narrow(&mut axes[..1], width, 2);
        }
        if let ShapeInput::Box { to, .. } = &mut scene.bodies[0].shape {
            to.0[0] = width;
        }
        for support in scene.supports.iter_mut().filter(|it| it.name == "right") {
            if let RegionInput::Plane { at, .. } = &mut support.region {
                *at = Finite(width);
            }
        }
    }
    Ok(Scene::PlaneStrain(scene))
}

/// One line of the table of columns.
struct Line {
    load: Load,
    degree: u32,
    points_per_cell: u32,
    cells: u32,
    error: f64,
    highest: f64,
}

fn lines(most: u32) -> Result<Vec<Line>, Broken> {
    let table = Reference::read("splines_column")?;
    let [steps, degree, points, cells] =
        ["steps", "degree", "points_per_cell", "cells"].map(|name| table.column(name));
    let (steps, degree, points, cells) = (steps?, degree?, points?, cells?);
    let (error, highest) = (table.column("error")?, table.column("highest_point")?);
    let line = |k: usize| Line {
        load: if steps[k] > 30.0 { Load::Hard } else { Load::Mild },
        degree: degree[k] as u32,
        points_per_cell: points[k] as u32,
        cells: cells[k] as u32,
        error: error[k],
        highest: highest[k],
    };
    Ok((0..steps.len()).map(line).filter(|line| line.cells <= most).collect())
}

fn columns(extent: Extent) -> Result<Findings, Broken> {
    let lines = lines(extent.pick(8, 64))?;
    let mut findings = Findings::default();
    for method in [CPDI1, CPDI2Q] {
        let found = sweep(&lines, |line| {
            let scene = spline_column(line.load, &method, line.cells, (line.degree, line.points_per_cell))?;
            let history = run(&scene)?.completed()?;
            let top = largest(history.last().positions.chunks_exact(3).map(|x| x[1]));
            Ok((stress_error(&history), top))
        })?;
        for degree in 1..=3 {
            let of_degree = || lines.iter().zip(&found).filter(|(line, _)| line.degree == degree);
            let apart =
                |(line, (error, _)): (&Line, &(f64, f64))| (error - line.error).abs() / (line.error + 1e-5);
            let name = format!("{}, degree {degree}", method.name);
            findings.checks.push(Check::new(
                format!("{name}: errors of the stress against the reference"),
                largest(of_degree().map(apart)),
                1e-8,
            ));
            let apart = |(line, (_, top)): (&Line, &(f64, f64))| (top / line.highest - 1.0).abs();
            let what = format!("{name}: highest point against the reference (relative)");
            findings.checks.push(Check::new(what, largest(of_degree().map(apart)), 1e-10));
        }
        if method == CPDI1 {
            findings.tables.push(table(&lines, &found));
        }
    }
    findings.checks.extend(in_space()?);
    findings.checks.extend(varying(extent)?);
    Ok(findings)
}

fn table(lines: &[Line], found: &[(f64, f64)]) -> Table {
    let mut meshes: Vec<u32> = lines.iter().map(|line| line.cells).collect();
    meshes.sort_unstable();
    meshes.dedup();
    let heads: Vec<String> =
        ["degree, points".into()].into_iter().chain(meshes.iter().map(|n| format!("{n} cells"))).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = Table::new("Error of the stress, hard, CPDI1:".to_owned(), &heads);
    for (degree, points) in [(1, 2), (2, 2), (2, 3), (3, 2), (3, 3)] {
        let cell = |n: &u32| {
            let is_this = |line: &Line| {
                line.load == Load::Hard
                    && (line.degree, line.points_per_cell, line.cells) == (degree, points, *n)
            };
            let at = lines.iter().position(is_this);
            at.map_or(String::new(), |k| scientific(found[k].0, 4))
        };
        table.push([format!("{degree}, {points}")].into_iter().chain(meshes.iter().map(cell)));
    }
    table
}

/// The column in space is that in the plane.
fn in_space() -> Result<Vec<Check>, Broken> {
    let mut checks = Vec::new();
    for (basis, name) in [(SolidBasis::Cpdi1, "CPDI1"), (SolidBasis::Cpdi2Hexahedron, "CPDI2 hexahedra")] {
        let Scene::Solid(mut scene) = solid_column(basis, 8, 1)? else {
            return Err("expected a scene in three dimensions".into());
        };
        // With 2 points a body one cell wide and deep has as many corners as splines across, and a mode without stiffness.
        on_splines(&mut scene, 2, 3);
        let error = stress_error(&run(&Scene::Solid(scene))?.completed()?);
        let expected = lines(8)?.into_iter().find(|it| (it.degree, it.points_per_cell, it.cells) == (2, 3, 8));
        let expected = expected.map_or(f64::NAN, |line| line.error);
        let what =
            format!("{name} in space, degree 2, 3 points, 8 cells: error against the reference (relative)");
        checks.push(Check::new(what, (error / expected - 1.0).abs(), 1e-8));
    }
    Ok(checks)
}

/// The weight of the column, uneven along its height: its mean over domains of this length `[L]`.
#[derive(Debug)]
struct Uneven {
    length: f64,
}

/// ρ0 g `[F/L³]`.
const WEIGHT: f64 = 800.0;

impl BodyForce<2> for Uneven {
    fn force(&self, rest: &Vector<2>, at: LoadFraction) -> Vector<2> {
        let wave = 3.0 * PI / HEIGHT;
        let half = 0.5 * wave * self.length;
        let part = 1.0 + 0.8 * (wave * rest.y).cos() * half.sin() / half;
        Vector::<2>::new(0.0, -WEIGHT * part * at.total())
    }
}

/// Error of the stress under the uneven weight, as in [`stress_error`].
fn uneven_error(history: &History) -> f64 {
    let last = history.rows().len() - 1;
    let stress = history.field(Field::CAUCHY_STRESS, last).chunks_exact(9).map(|it| it[4]);
    let rest = history.rows()[0].positions.chunks_exact(3).map(|x| x[1]);
    let exact = |y: f64| -WEIGHT * (HEIGHT - y - 0.8 * HEIGHT / (3.0 * PI) * (3.0 * PI * y / HEIGHT).sin());
    let errors: Vec<f64> = stress.zip(rest).map(|(stress, y)| (stress - exact(y)).abs()).collect();
    errors.iter().sum::<f64>() / (errors.len() as f64 * WEIGHT * HEIGHT)
}

/// Errors of an independent implementation under the uneven weight, for 16, 32, 64 and 128 cells.
const UNEVEN: [(u32, [f64; 4]); 2] =
    [(2, [6.10e-4, 1.47e-4, 3.72e-5, 9.30e-6]), (3, [5.80e-4, 1.46e-4, 3.66e-5, 9.16e-6])];

fn varying(extent: Extent) -> Result<Vec<Check>, Broken> {
    let meshes: &[u32] = extent.pick(&[16, 32], &[16, 32, 64, 128]);
    let mut checks = Vec::new();
    for (degree, expected) in UNEVEN {
        let errors = sweep(meshes, |&cells| {
            let scene = spline_column(Load::Hard, &CPDI1, cells, (degree, 2))?;
            let Compiled::Plane(mut model) = compiled(&scene)? else {
                return Err("expected a scene in plane strain".into());
            };
            model.loads.body_forces.clear();
            let length = 0.5 * HEIGHT / f64::from(cells);
            model.loads.fields.push((0, Arc::new(Uneven { length })));
            let mut history = History::of(&[Field::CAUCHY_STRESS]);
            mpm_solver::run(&mut model, &mut history)?;
            Ok(uneven_error(&history))
        })?;
        for ((cells, error), expected) in meshes.iter().zip(&errors).zip(expected) {
            let what = format!(
                "varying force, degree {degree}, {cells} cells: error against the reference (relative)"
            );
            checks.push(Check::new(what, (error / expected - 1.0).abs(), 0.01).remark(scientific(*error, 3)));
        }
        let order = (errors[errors.len() - 2] / errors[errors.len() - 1]).log2();
        let what = format!("varying force, degree {degree}: order between the finest meshes, off 2");
        checks.push(Check::new(what, (order - 2.0).abs(), 0.1).remark(format!("order {order:.2}")));
    }
    Ok(checks)
}

/// Torque of the one-dimensional solution at 20° `[F L]`.
const TORQUE: f64 = 6.764_337_140e7;

/// Basis, degree, and relative errors of the torque on 5 × 32, 10 × 64 and 20 × 128 cells with points of sectors.
const TORQUES: [(Method, u32, &[f64]); 4] = [
    (CPDI2Q, 2, &[1.070e-3, 2.831e-4, 7.243e-5]),
    (CPDI2Q, 3, &[1.031e-3, 2.815e-4, 7.238e-5]),
    (CPDI1, 2, &[-1.473e-4, 2.735e-6, 7.387e-6]),
    (CPDI1, 3, &[-5.368e-4, -6.188e-5]),
];

fn rings(extent: Extent) -> Result<Findings, Broken> {
    let factors: &[u32] = extent.pick(&[1, 2], &[1, 2, 4]);
    let mut checks = Vec::new();
    for (method, degree, expected) in TORQUES {
        for (factor, expected) in factors.iter().zip(expected) {
            let mut scene = refined(method.of(plane(load_own("ring_splines")?)?), *factor);
            if let MeshInput::Ring { functions, .. } = &mut scene.mesh {
                *functions = FunctionsInput::Splines { degree: Count(degree) };
            }
            let history = run(&Scene::PlaneStrain(scene))?.completed()?;
            let found = *torque(&history).last().ok_or("no load step")?;
            // Points of polygons.
            let half = PI / f64::from(32 * factor);
            let error = found / TORQUE * (half / half.sin()) - 1.0;
            let name = format!("{}, degree {degree}, {} × {} cells", method.name, 5 * factor, 32 * factor);
            let what = format!("{name}: error of the torque against the reference's");
            // The digits of the reference end at 5e-4 of an error, and of the exact torque at 1e-9.
            let allowed = 1e-2 * expected.abs() + 2e-8;
            checks.push(Check::new(what, (error - expected).abs() / allowed, 1.0).remark(scientific(error, 4)));
            let of_outer = history.series("reaction_moment/outer", 0).last().copied().unwrap_or(f64::NAN);
            let what = format!("{name}: moments of both circles, sum over one of them");
            checks.push(Check::new(what, (of_outer + found).abs() / found.abs(), 1e-12));
        }
    }
    checks.push(turned()?);
    Ok(checks.into())
}

/// A ring that is unevenly strained, then turned once around.
fn turned() -> Result<Check, Broken> {
    let mut probe = Probe::of(model_of(&load_own("ring_splines")?)?)?;
    probe.advance(&probe.field(|x| Vector::<2>::new((0.3 * x.y).sin(), (0.2 * x.x).cos()) * 0.3))?;
    let before = probe.stresses();
    let size = largest(before.iter().map(|tau| tau.norm()));
    let rotation = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Block::<2>::new(cos, -sin, sin, cos)
    };
    let mut worst = 0.0;
    for k in 1..=12 {
        let step = rotation(30.0) - Block::identity();
        probe.advance(&probe.field(|x| step * x))?;
        let turn = rotation(30.0 * f64::from(k));
        let apart = probe.stresses().into_iter().zip(&before).map(|(now, before)| {
            let plane = |tau: &SymmetricTensor| Block::<2>::new(tau.xx, tau.xy, tau.xy, tau.yy);
            (plane(&now) - turn * plane(before) * turn.transpose()).norm() / size
        });
        worst = largest(apart.chain([worst]));
    }
    Ok(Check::new("stress of a strained ring, turned by 360° in increments of 30°", worst, 1e-11))
}

fn patches(_: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    let gradient = [1.2, 0.3, 0.0, -0.1, 0.85, 0.0, 0.0, 0.0, 1.0];
    for method in [CPDI1, CPDI2Q] {
        for degree in [2, 3] {
            for elastic in [true, false] {
                let mut scene = method.of(plane(load_own("patch_splines")?)?);
                on_splines(&mut scene, degree, 2);
                for law in scene.materials.values_mut() {
                    if let (true, MaterialInput::VonMises { young, poisson, density, .. }) =
                        (elastic, law.clone())
                    {
                        *law = MaterialInput::Hencky { young, poisson, gradient: None, density };
                    }
                }
                let history = run(&Scene::PlaneStrain(scene))?.completed()?;
                let last = history.rows().len() - 1;
                let kind = if elastic { "elastic" } else { "plastic" };
                let name = format!("{}, degree {degree}, {kind}", method.name);
                let f = history.field(Field::DEFORMATION_GRADIENT, last).chunks_exact(9);
                let error = largest(f.map(|f| relative(f, &gradient)));
                checks.push(Check::new(format!("{name}: deformation gradient"), error, 1e-13));
                let stress = history.field(Field::CAUCHY_STRESS, last);
                let spread = largest(stress.chunks_exact(9).map(|it| relative(it, &stress[..9])));
                checks.push(Check::new(format!("{name}: spread of the stress"), spread, 1e-12));
                let yielding = history.field(Field::PLASTIC, last).iter().filter(|&&it| it == 1.0).count();
                let what = format!("{name}: points that do not yield as they should");
                let wrong =
                    if elastic { yielding } else { history.field(Field::PLASTIC, last).len() - yielding };
                checks.push(Check::none(what, wrong));
            }
        }
    }
    Ok(checks.into())
}

/// Basis, and errors of displacement and stress of an independent implementation on 24², 48² and, where there are any, 96² cells.
const VORTICES: [(Method, &[[f64; 2]]); 2] = [
    (CPDI2Q, &[[9.1461e-2, 1.1748e-1], [2.1419e-2, 3.3514e-2], [5.21e-3, 8.47e-3]]),
    (CPDI1, &[[9.3209e-2, 1.1767e-1], [1.9371e-2, 3.4822e-2]]),
];

fn vortices(extent: Extent) -> Result<Findings, Broken> {
    let factors: &[u32] = extent.pick(&[1, 2], &[1, 2, 4]);
    let mut checks = Vec::new();
    for (method, expected) in VORTICES {
        let factors = &factors[..factors.len().min(expected.len())];
        let found = sweep(factors, |&factor| held_vortex(&method, factor))?;
        for ((factor, found), expected) in factors.iter().zip(&found).zip(expected) {
            let name = format!("{}, {} cells", method.name, 24 * factor);
            for (what, found, expected) in
                [("displacement", found.displacement, expected[0]), ("stress", found.stress, expected[1])]
            {
                let what = format!("{name}: error of the {what} against the reference's (relative)");
                checks
                    .push(Check::new(what, (found / expected - 1.0).abs(), 0.04).remark(scientific(found, 4)));
            }
        }
        let mut order = |(coarse, fine): (usize, usize), least: f64| {
            let orders = [
                (found[coarse].displacement / found[fine].displacement).log2(),
                (found[coarse].stress / found[fine].stress).log2(),
            ]
            .map(|it| it / (fine - coarse) as f64);
            let [from, to] = [coarse, fine].map(|k| 24 * factors[k]);
            let what = format!("{}: orders from {from}² to {to}² cells, lack below {least}", method.name);
            let lack = orders.iter().map(|order| least - order).fold(0.0, f64::max);
            let remark = format!("displacement {:.2}, stress {:.2}", orders[0], orders[1]);
            checks.push(Check::new(what, lack, 0.0).remark(remark));
        };
        order((0, 1), 1.7);
        if factors.len() > 2 {
            order((0, 2), 1.8);
        }
    }
    Ok(checks.into())
}

fn held_vortex(method: &Method, factor: u32) -> Result<Errors, Broken> {
    let mut scene = vortex(method, factor)?;
    if let MeshInput::Box { functions, .. } = &mut scene.mesh {
        *functions = FunctionsInput::Splines { degree: Count(2) };
    }
    scene.supports.clear();
    scene.bodies.iter_mut().for_each(|body| body.tiling = TilingInput::Shape);
    if *method == CPDI1 {
        scene.stabilisation = Some(StabilisationInput::Ghost { factor: None });
    }
    let field = exact(&scene)?;
    let Compiled::Plane(mut model) = compiled(&Scene::PlaneStrain(scene))? else {
        return Err("expected a scene in plane strain".into());
    };
    let cell = 3.0 / f64::from(24 * factor);
    model.add_contribution("edges", Box::new(HeldCircles::new(&[0.75, 1.25], 10.0 * 1e3 / cell)));
    let mut history = History::of(&[Field::CAUCHY_STRESS, Field::DISPLACEMENT]);
    mpm_solver::run(&mut model, &mut history)?;
    errors(&history, &field)
}
