//! Walls and pressures in space.

use super::super::{largest, scientific};
use super::column::Column;
use super::cylinder::{inner_radius, stress_error, stress_error_about};
use super::{axis, functions};
use crate::history::History;
use crate::scenes::{changed, own_text, run, text};
use crate::{Broken, Case, Check, Extent, Findings};
use nalgebra::{Rotation3, Unit, Vector3};

pub(in crate::cases) const SPACE: Case = Case {
    name: "boundaries in space",
    goal: "Walls hold and pressures follow sides in space, where these cut the mesh, as they do in the plane.",
    setup: "The inclined column, turned by 30° about z, with 3 points a cell and direction, and a quarter of the cylinder under pressure, with 2, both on splines of degree 2 one cell deep, smooth in front and behind; CPDI1 and CPDI2 hexahedra; and the whole cylinder, 4 long, between smooth walls, its axis along no line of the mesh, on splines of degree 2, hexahedra; coarse meshes, and twice, about the whole cylinder 1.5 times, as many cells in the full run.",
    reference: "The same in the plane, with as many points a cell: CPDI1 for CPDI1, CPDI2q for hexahedra; ghost faces, which are integrated along z and not summed over corners, keep the two apart by a thousandth of the error (without them the cylinders agree to 8e-15). The stress of the cylinder in one dimension.",
    run: in_space,
};

/// Bases in space and their counterparts in the plane.
const BASES: [(&str, &str, &str); 2] =
    [("Cpdi1", "Cpdi1", "CPDI1"), ("Cpdi2Hexahedron", "Cpdi2q", "CPDI2 hexahedra")];

fn in_space(extent: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    for &cells in extent.pick(&[4][..], &[4, 8]) {
        let column = Column { degree: 2, cells, angle: 30.0, offset: [2.137, 2.291], points_per_cell: 3 };
        for (solid, flat, name) in BASES {
            let (found, expected) = (column.errors_in_space(solid)?, column.errors(flat)?);
            for (what, k) in [("error of the stress", 0), ("largest gap", 1)] {
                let what = format!("column, {name}, {cells} cells: {what} against the plane (relative)");
                let apart = (found[k] / expected[k] - 1.0).abs();
                checks.push(Check::new(what, apart, 2e-3).remark(scientific(found[k], 3)));
            }
        }
    }
    let inner = inner_radius()?;
    for &cells in extent.pick(&[12_u32][..], &[12, 24]) {
        for (solid, flat, name) in BASES {
            let (found, expected) = (cylinder_in_space(solid, cells)?, cylinder(flat, cells)?);
            let what = format!(
                "cylinder, {name}, {cells}² cells: points against the plane, over the change of the radius"
            );
            checks.push(Check::new(what, apart(&found, &expected) / (inner - 5.0), 1e-5));
            let error = stress_error(&found, inner);
            let what = format!("cylinder, {name}, {cells}² cells: error of the stress");
            let most = if cells == 12 { 8e-3 } else { 2e-3 };
            checks.push(Check::new(what, error, most).remark(scientific(error, 2)));
        }
    }
    askew(extent, &mut checks)?;
    Ok(checks.into())
}

/// Cells of the box around the whole cylinder, coarse; about 1.5 long.
const AROUND: [(f64, f64, f64); 3] = [(-11.3, 11.7, 16.0), (-9.8, 10.2, 14.0), (-10.1, 10.4, 14.0)];

/// The whole cylinder with an axis along no line of the mesh.
fn askew(extent: Extent, checks: &mut Vec<Check>) -> Result<(), Broken> {
    let inner = inner_radius()?;
    let axis_of_turn = Unit::new_normalize(Vector3::new(-2.0, 1.0, 0.0));
    let frame = Rotation3::from_axis_angle(&axis_of_turn, 50.0_f64.to_radians()).into_inner();
    let mut found: Vec<f64> = Vec::new();
    for &factor in extent.pick(&[1.0][..], &[1.0, FINER]) {
        let steps = extent.pick(2, 5).to_string();
        let mut changes = vec![("mesh.functions", functions(2)), ("schedule.steps", steps)];
        let paths = ["mesh.axes[0]", "mesh.axes[1]", "mesh.axes[2]"];
        changes.extend(
            paths
                .into_iter()
                .zip(AROUND)
                .map(|(path, (from, to, cells))| (path, axis(from, to, factor * cells))),
        );
        let history = run(&changed(own_text("tube_pressure_turned")?, &changes)?)?.completed()?;
        let error = stress_error_about(&history, inner, &frame);
        let what = format!("cylinder askew, cells {} wide: error of the stress", 1.5 / factor);
        checks.push(Check::new(what, error, 1.5e-2 / (factor * factor)).remark(scientific(error, 2)));
        found.push(error);
    }
    if let [coarse, fine] = found[..] {
        let order = (coarse / fine).ln() / FINER.ln();
        let what = "cylinder askew: order of the stress below 1.9";
        checks.push(Check::new(what, (1.9 - order).max(0.0), 0.0).remark(format!("{order:.2}")));
    }
    Ok(())
}

/// How many times as many cells the finer mesh around the whole cylinder has.
const FINER: f64 = 1.5;

fn cylinder(basis: &str, cells: u32) -> Result<History, Broken> {
    let mut changes = on_cells(basis, cells);
    changes.push(("mesh.functions", functions(2)));
    run(&changed(text("cylinder_pressure")?, &changes)?)?.completed()
}

fn cylinder_in_space(basis: &str, cells: u32) -> Result<History, Broken> {
    let (mut changes, deep) = (on_cells(basis, cells), 12.0 / f64::from(cells));
    changes.push(("mesh.axes[2]", axis(0.0, deep, 1.0)));
    changes.push(("supports[3].region.at", format!("{deep:?}")));
    run(&changed(own_text("cylinder_pressure_solid")?, &changes)?)?.completed()
}

fn on_cells(basis: &str, cells: u32) -> Vec<(&'static str, String)> {
    let cells = axis(0.0, 12.0, f64::from(cells));
    vec![("basis", basis.into()), ("mesh.axes[0]", cells.clone()), ("mesh.axes[1]", cells)]
}

/// How far points in space stand from those in the plane at most, seen along z: each cell has four in front of four `[L]`.
fn apart(space: &History, plane: &History) -> f64 {
    let cells = space.last().positions.chunks_exact(24).zip(plane.last().positions.chunks_exact(12));
    largest(cells.flat_map(|(space, plane)| {
        let pairs = space.chunks_exact(3).zip(plane.chunks_exact(3).cycle());
        pairs.map(|(x, y)| (x[0] - y[0]).hypot(x[1] - y[1])).collect::<Vec<_>>()
    }))
}
