//! Bodies in box meshes whose sides lie across the cells, and points from a table.

use super::{fixed, largest, scientific, sweep};
use crate::history::{History, Row};
use crate::scenes::{Run, compiled, load, run};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{Coordinates, Count, DomainsInput, Finite, Scene, ShapeInput, SolidBasis};
use mpm_solver::observe::Field;
use std::f64::consts::PI;

pub(super) const CASE: Case = Case {
    name: "cylinder, tube, points from a table",
    goal: "Round bodies in a box mesh are as accurate as boxes, and points from a table are those of the body that they were taken from.",
    setup: "The self-weight column (hard, 16 cells, GIMP) with a round cross-section of radius 5.5 in cells of 3.125; a tube of radii 0.6 and 1.3 in cells of 0.5, E = 10³, ν = 0.3, pulled to 1.5 times its length in 10 load steps; an elasto-plastic block of 32 CPDI1 points that leans under its own weight, its points from a CSV file.",
    reference: "Heights and stresses of the column in plane strain (ν = 0: every plumb line is a column of its own, on which points stand as in the plane); force E A ln λ / λ with A = π (r_o² − r_i²); the same block as a box, bit for bit.",
    run: shapes,
};

const BASES: [(SolidBasis, &str); 5] = [
    (SolidBasis::Smpm, "sMPM"),
    (SolidBasis::Gimp, "GIMP"),
    (SolidBasis::Cpdi1, "CPDI1"),
    (SolidBasis::Cpdi2Hexahedron, "CPDI2 hexahedra"),
    (SolidBasis::Cpdi2Tetrahedron, "CPDI2 tetrahedra"),
];

fn shapes(_: Extent) -> Result<Findings, Broken> {
    let mut findings = Findings::default();
    cylinder(&mut findings)?;
    tube(&mut findings)?;
    points(&mut findings)?;
    Ok(findings)
}

/// Height at rest, height at the end, and vertical stress there, of every point.
fn plumb(scene: &Scene) -> Result<Vec<[f64; 3]>, Broken> {
    let history = run(scene)?.completed()?;
    let (first, last) = (&history.rows()[0], history.last());
    let stress = history.field(Field::CAUCHY_STRESS, history.rows().len() - 1);
    let heights = first.positions.chunks(3).zip(last.positions.chunks(3));
    Ok(heights.zip(stress.chunks(9)).map(|((rest, end), stress)| [rest[1], end[1], stress[4]]).collect())
}

fn cylinder(findings: &mut Findings) -> Result<(), Broken> {
    let (column, cylinder) = (plumb(&load("column")?)?, plumb(&load("cylinder")?)?);
    let (mut heights, mut stresses) = (Vec::new(), Vec::new());
    for [rest, end, stress] in &cylinder {
        let same = column.iter().find(|it| (it[0] - rest).abs() < 1e-9);
        let [_, height, expected] = same.ok_or_else(|| format!("no point of the column is at {rest}"))?;
        heights.push((end - height).abs() / 50.0);
        stresses.push((stress - expected).abs() / 4e4);
    }
    findings.checks.extend([
        Check::new("cylinder: heights against the column's (over 50)", largest(heights), 1e-12)
            .remark(format!("{} points", cylinder.len())),
        Check::new("cylinder: stresses against the column's (over ρ0 g 50)", largest(stresses), 1e-11),
    ]);
    Ok(())
}

fn tube(findings: &mut Findings) -> Result<(), Broken> {
    let area = PI * (1.3 * 1.3 - 0.6 * 0.6);
    let volume = &compiled(&solid("tube_pulled", SolidBasis::Cpdi1)?)?.estimate()?.volumes[0];
    findings.checks.push(Check::new(
        "tube: volume of its points against 3 A (relative)",
        (volume.points / (3.0 * area) - 1.0).abs(),
        1e-9,
    ));
    pulled("tube, ", "tube_pulled", area, 1e-9, findings).map(drop)
}

/// A scene in space with another basis.
pub(super) fn solid(name: &str, basis: SolidBasis) -> Result<Scene, Broken> {
    let Scene::Solid(mut scene) = load(name)? else {
        return Err("expected a scene in three dimensions".into());
    };
    scene.basis = basis;
    scene.domains = DomainsInput::default();
    Ok(Scene::Solid(scene))
}

/// Pulls a bar of cross-section `area` and E = 10³ to 1.5 times its length under every basis: force against E A ln λ / λ.
pub(super) fn pulled(
    what: &str,
    scene: &str,
    area: f64,
    tolerance: f64,
    findings: &mut Findings,
) -> Result<Vec<Run>, Broken> {
    let runs = sweep(&BASES, |(basis, _)| run(&solid(scene, *basis)?))?;
    let mut table = Table::new(
        "Force at the end, and the largest error of any load step over the force there:",
        &["basis", "points", "force", "error"],
    );
    for ((_, name), run) in BASES.iter().zip(&runs) {
        let reason = run.outcome.as_ref().err().map_or(String::new(), ToString::to_string);
        let forces = run.history.series("reaction/pulled", 2);
        let rows = run.history.rows()[1..].iter().zip(&forces[1..]);
        let error = largest(rows.map(|(row, force)| {
            let stretch = 1.0 + 0.5 * row.fraction;
            (force / (1e3 * area * stretch.ln() / stretch) - 1.0).abs()
        }));
        let error = if run.outcome.is_ok() { error } else { f64::NAN };
        let compared = format!("{what}{name}: force against E A ln λ / λ (relative, every load step)");
        findings.checks.push(Check::new(compared, error, tolerance).remark(reason));
        let points = run.history.rows().first().map_or(0, |row| row.positions.len() / 3);
        table.push([
            (*name).to_owned(),
            points.to_string(),
            fixed(forces[forces.len() - 1], 6),
            scientific(error, 2),
        ]);
    }
    findings.tables.push(table);
    Ok(runs)
}

fn points(findings: &mut Findings) -> Result<(), Broken> {
    let from_table = load("points")?;
    let Scene::PlaneStrain(mut scene) = load("points")? else {
        return Err("expected a scene in the plane".into());
    };
    scene.bodies[0].shape = ShapeInput::Box {
        from: Coordinates([0.0; 2]),
        to: Coordinates([1.0, 2.0]),
        without: Vec::new(),
        cutouts: Vec::new(),
        turned: Finite(0.0),
    };
    scene.bodies[0].points_per_cell = Some(Count(2));
    let [a, b] = [run(&from_table)?.completed()?, run(&Scene::PlaneStrain(scene))?.completed()?];
    let bits = |it: &History| it.reproducible().iter().flat_map(Row::bits).collect::<Vec<u64>>();
    let plastic = a.field(Field::PLASTIC, a.rows().len() - 1).iter().sum::<f64>();
    let (a, b) = (bits(&a), bits(&b));
    let differ = a.iter().zip(&b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len());
    findings.checks.push(
        Check::new("points from a table: numbers that differ from the box's", differ as f64, 0.0)
            .remark(format!("{plastic} points are plastic at the end")),
    );
    Ok(())
}
