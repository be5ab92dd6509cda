//! A column that leans in its mesh, between walls.

use super::super::{largest, scientific, sweep};
use super::{axis, functions};
use crate::history::History;
use crate::reference::Reference;
use crate::scenes::{changed, own_text, run, text};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_solver::observe::Field;

pub(in crate::cases) const COLUMN: Case = Case {
    name: "inclined column",
    goal: "A body that no line of nodes follows is held by walls as exactly as an upright one by nodes, at any angle.",
    setup: "The hard self-weight column, 12.5 wide, turned in a square mesh, between three walls on which it slides; tiles half a cell wide, CPDI2q, ghost faces. Degrees 1 to 3 at several angles, and degree 2 with eight cells at angles in steps of 7°.",
    reference: "Errors of the stress along the column, largest gaps and stresses across it of an independent implementation, `reference/inclined_column.csv`.",
    run: columns,
};

/// Weight of the column over its base, ρ₀ g H `[F/L²]`, and its height and width `[L]`.
const PRESSURE: f64 = 80.0 * 10.0 * HEIGHT;
const HEIGHT: f64 = 50.0;
const WIDTH: f64 = 12.5;

/// Across and along a column.
type Directions = [[f64; 2]; 2];

/// A column in its mesh.
#[derive(Clone, Copy)]
pub(super) struct Column {
    pub degree: u32,
    pub cells: u32,
    pub angle: f64,
    /// From the mesh's corner to that of the box round the column, in cells.
    pub offset: [f64; 2],
    pub points_per_cell: u32,
}

impl Column {
    /// Where its foot stands, and the directions across and along it.
    fn place(&self) -> ([f64; 2], Directions) {
        let (sine, cosine) = self.angle.to_radians().sin_cos();
        let h = HEIGHT / f64::from(self.cells);
        let foot = [self.offset[0] * h + HEIGHT * sine, self.offset[1] * h];
        (foot, [[cosine, sine], [-sine, cosine]])
    }

    /// What is changed in the scene, in space of one that is a cell deep.
    fn changes(&self, is_in_space: bool) -> Vec<(&'static str, String)> {
        let Self { degree, cells, offset, points_per_cell, .. } = *self;
        let ([x, y], [across, along]) = self.place();
        let ([cosine, sine], h) = (across, HEIGHT / f64::from(cells));
        let mesh = |extent: f64, offset: f64| {
            let n = (extent / h + offset).ceil() + 3.0;
            axis(0.0, n * h, n)
        };
        let vector = |[x, y]: [f64; 2], z: f64| match is_in_space {
            true => format!("({x:?}, {y:?}, {z:?})"),
            false => format!("({x:?}, {y:?})"),
        };
        let plane = |at: f64, normal: [f64; 2]| {
            let through = vector([x + at * cosine, y + at * sine], 0.0);
            format!("Plane(through: {through}, normal: {})", vector(normal, 0.0))
        };
        let [from, to] = [vector([x, y], 0.0), vector([x + WIDTH, y + HEIGHT], h)];
        let mut changes = vec![
            ("mesh.axes[0]", mesh(HEIGHT * sine + WIDTH * cosine, offset[0])),
            ("mesh.axes[1]", mesh(HEIGHT * cosine + WIDTH * sine, offset[1])),
            ("mesh.functions", functions(degree)),
            ("bodies[0].shape", format!("Box(from: {from}, to: {to}, turned: {:?})", self.angle)),
            ("bodies[0].points_per_cell", points_per_cell.to_string()),
            ("walls[0].surface", plane(0.0, along)),
            ("walls[1].surface", plane(0.0, across)),
            ("walls[2].surface", plane(WIDTH, across.map(|part| -part))),
            ("loads[0].acceleration", vector([10.0 * sine, -10.0 * cosine], 0.0)),
        ];
        if is_in_space {
            changes.push(("mesh.axes[2]", axis(0.0, h, 1.0)));
            changes.push(("supports[1].region.at", format!("{h:?}")));
        }
        changes
    }

    /// Mean error of the stress along the column over ρ₀ g H, the largest gap, and the largest stress across it over ρ₀ g H.
    pub(super) fn errors(&self, basis: &str) -> Result<[f64; 3], Broken> {
        let mut changes = self.changes(false);
        changes.push(("basis", basis.into()));
        self.errors_of(&run(&changed(text("inclined_column")?, &changes)?)?.completed()?)
    }

    /// The same of the column in space.
    pub(super) fn errors_in_space(&self, basis: &str) -> Result<[f64; 3], Broken> {
        let mut changes = self.changes(true);
        changes.push(("basis", basis.into()));
        self.errors_of(&run(&changed(own_text("inclined_column_solid")?, &changes)?)?.completed()?)
    }

    fn errors_of(&self, history: &History) -> Result<[f64; 3], Broken> {
        let ([x, y], [across, along]) = self.place();
        let last = history.rows().len() - 1;
        let stress = |[a, b]: [f64; 2]| {
            let all = history.field(Field::CAUCHY_STRESS, last).chunks_exact(9);
            all.map(move |s| a * a * s[0] + 2.0 * a * b * s[1] + b * b * s[4])
        };
        let rest = history.rows()[0].positions.chunks_exact(3);
        let heights = rest.map(|at| (at[0] - x) * along[0] + (at[1] - y) * along[1]);
        let errors: Vec<f64> = stress(along)
            .zip(heights)
            .map(|(s, height)| (s + PRESSURE * (1.0 - height / HEIGHT)).abs())
            .collect();
        let gap = |wall: &str| history.series(&format!("wall/{wall}/gap"), 0)[last];
        Ok([
            errors.iter().sum::<f64>() / (errors.len() as f64 * PRESSURE),
            largest(["base", "left", "right"].map(gap)),
            largest(stress(across).map(f64::abs)) / PRESSURE,
        ])
    }
}

fn columns(extent: Extent) -> Result<Findings, Broken> {
    let table = Reference::read("inclined_column")?;
    let column = |name: &str| table.column(name);
    let (degree, cells, angle) = (column("degree")?, column("cells_along")?, column("angle_deg")?);
    let offsets = [column("offset_x")?, column("offset_y")?];
    let expected = [column("error")?, column("largest_gap")?, column("largest_lateral_stress")?];
    let most = extent.pick(8.0, 32.0);
    let rows: Vec<usize> = (0..degree.len()).filter(|&k| cells[k] <= most).collect();
    let of_row = |k: usize| Column {
        degree: degree[k] as u32,
        cells: cells[k] as u32,
        angle: angle[k],
        offset: [offsets[0][k], offsets[1][k]],
        points_per_cell: 2,
    };
    let found = sweep(&rows, |&k| of_row(k).errors("Cpdi2q"))?;
    let mut findings = Findings::default();
    let heads = ["degree", "cells", "angle", "error", "of the reference", "gap", "stress across"];
    let mut errors = Table::new("Errors of the stress along the column over ρ₀ g H.", &heads);
    for (&k, [error, gap, lateral]) in rows.iter().zip(&found) {
        let Column { degree, cells, angle, .. } = of_row(k);
        let words = [degree.to_string(), cells.to_string(), format!("{angle}°")];
        let numbers = [*error, expected[0][k], *gap, *lateral].map(|it| scientific(it, 3));
        errors.push(words.into_iter().chain(numbers));
    }
    let worst = |of: usize| {
        largest(rows.iter().zip(&found).map(|(&k, found)| found[of] / expected[of][k] - 1.0)).max(0.0)
    };
    findings.checks.push(Check::new("errors of the stress, beyond the reference's", worst(0), 0.05));
    findings.checks.push(Check::new("largest gaps, beyond the reference's", worst(1), 0.01));
    findings.checks.push(Check::new("largest stresses across, beyond the reference's", worst(2), 0.05));
    let of = |degree: u32, cells: u32| {
        let row = rows.iter().position(|&k| {
            let it = of_row(k);
            (it.degree, it.cells, it.angle) == (degree, cells, 30.0)
        });
        row.map_or(f64::NAN, |row| found[row][0])
    };
    if extent.pick(false, true) {
        let order = 0.5 * (of(2, 8) / of(2, 32)).log2();
        let what = "degree 2, 30°: order from 8 to 32 cells below 2.4";
        findings.checks.push(Check::new(what, (2.4 - order).max(0.0), 0.0).remark(format!("{order:.2}")));
    }
    findings.tables.push(errors);
    let angles: Vec<f64> = (0..13).map(|k| 7.0 * f64::from(k)).collect();
    let turned = sweep(&angles, |&angle| {
        Column { degree: 2, cells: 8, angle, offset: [2.137, 2.291], points_per_cell: 2 }.errors("Cpdi2q")
    })?;
    let errors = || turned.iter().map(|it| it[0]);
    findings.checks.push(
        Check::new("degree 2, 8 cells, angles in steps of 7°: largest error", largest(errors()), 6e-4)
            .remark(errors().map(|it| scientific(it, 1)).collect::<Vec<_>>().join(", ")),
    );
    Ok(findings)
}
