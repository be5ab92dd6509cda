//! A column under its own weight (Coombs & Augarde 2020, AMPLE).

use super::{fixed, largest, scientific, sweep};
use crate::history::History;
use crate::picture::{Curve, Curves, Legend, Panel, Picture, Stroke};
use crate::problems::column::{HEIGHT, Load, column, narrow, stress_error};
use crate::scenes::{Run, load, run};
use crate::variants::{CPDI1, CPDI2Q, GIMP, Method, SMPM};
use crate::{Broken, Case, Check, Extent, Findings, Table};
use mpm_scene::language::{MeshInput, RegionInput, Scene, ShapeInput, SolidBasis};

pub(super) const CASE: Case = Case {
    name: "self-weight column",
    goal: "Order of convergence of the stress under large compression, where points cross cells.",
    setup: "A column 50 high, one cell wide, 2² points a cell, ν = 0, ρ0 = 80, g = 10, on rollers. Hard: E = 10⁴, 40 load steps, compressed to 0.30 at the base. Mild: E = 10⁶, 20 steps. Error: Σ |σ_yy + ρ0 g (50 − Y)| V0 / (ρ0 g 50 ΣV0).",
    reference: "σ_yy = −ρ0 g (50 − Y), Y the height at rest; errors and Newton iterations of AMPLE (GIMP) on the same meshes. Standard MPM does not converge here: the stress of points in half-empty and just entered cells jumps, at every mesh.",
    run: columns,
};

pub(super) const SOLID: Case = Case {
    name: "self-weight column in space",
    goal: "Three dimensions give what two do.",
    setup: "The hard column as a solid one cell wide and deep, 2³ points a cell, 8 cells (16 in the full run); a cube of 4³ cells (8³ in the full run) between smooth walls.",
    reference: "The error of the same basis in plane strain (ν = 0, so that both are the same problem); hexahedra stand beside quadrilaterals. Tetrahedra have no counterpart: their error must stay below that of the coarser mesh in the plane.",
    run: solid,
};

/// Mesh and error that AMPLE reaches with GIMP, hard.
const AMPLE: [(u32, f64); 7] = [
    (4, 4.1333e-2),
    (8, 1.2941e-2),
    (16, 3.6589e-3),
    (32, 1.0487e-3),
    (64, 4.3572e-4),
    (128, 2.0276e-4),
    (256, 1.0291e-4),
];
/// The same with standard MPM.
const AMPLE_SMPM: [(u32, f64); 7] =
    [(4, 6.33e-2), (8, 9.70e-2), (16, 8.67e-2), (32, 8.01e-2), (64, 8.29e-2), (128, 9.53e-2), (256, 8.95e-2)];

fn columns(extent: Extent) -> Result<Findings, Broken> {
    let meshes: &[u32] = extent.pick(&[4, 8, 16, 32, 64], &[4, 8, 16, 32, 64, 128, 256, 512]);
    let methods = [SMPM, GIMP, CPDI1, CPDI2Q];
    let mut findings = Findings::default();
    let mut panels = Vec::new();
    for (load_case, name) in [(Load::Hard, "hard"), (Load::Mild, "mild")] {
        let jobs: Vec<(&Method, u32)> =
            methods.iter().flat_map(|method| meshes.iter().map(move |&cells| (method, cells))).collect();
        let runs = sweep(&jobs, |(method, cells)| run(&column(load_case, method, *cells)?))?;
        let error = |run: &Run| if run.outcome.is_ok() { stress_error(&run.history) } else { f64::NAN };
        let errors: Vec<Vec<f64>> =
            runs.chunks_exact(meshes.len()).map(|runs| runs.iter().map(error).collect()).collect();

        findings.tables.push(table(name, meshes, &methods, &errors, &runs));
        findings.checks.extend(convergence(name, meshes, &methods, &errors));
        if load_case == Load::Hard {
            findings.checks.extend(ample(meshes, &errors[1]));
            findings.checks.extend(sixteen_cells(&runs[meshes.len() + 2].history));
        }
        panels.push(panel(name, load_case, meshes, &methods, &errors));
    }
    if extent == Extent::Full {
        findings.pictures.push(Picture {
            file: "column_convergence.svg",
            caption: "Self-weight column: error of the stress against the number of cells (lines: ours, marks: AMPLE).".into(),
            panels,
        });
    }
    Ok(findings)
}

fn table(name: &str, meshes: &[u32], methods: &[Method], errors: &[Vec<f64>], runs: &[Run]) -> Table {
    let heads: Vec<String> =
        ["basis".into()].into_iter().chain(meshes.iter().map(|n| format!("{n} cells"))).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = Table::new(
        format!(
            "Error of the stress, {name}; in parentheses the order between two meshes, then Newton iterations:"
        ),
        &heads,
    );
    for (m, method) in methods.iter().enumerate() {
        let cell = |k: usize| {
            let history = &runs[m * meshes.len() + k].history;
            let solves: f64 = history.series("newton_iterations", 0).iter().sum();
            if errors[m][k].is_nan() {
                return format!("ends at {} of the load", fixed(history.last().fraction, 3));
            }
            let order = if k > 0 {
                format!(" ({})", fixed((errors[m][k - 1] / errors[m][k]).log2(), 2))
            } else {
                String::new()
            };
            format!("{}{order}, {solves}", scientific(errors[m][k], 4))
        };
        table.push([method.name.to_owned()].into_iter().chain((0..meshes.len()).map(cell)));
    }
    if name == "hard" {
        for (label, values) in [("AMPLE, GIMP", AMPLE), ("AMPLE, sMPM", AMPLE_SMPM)] {
            let cell =
                |n: &u32| values.iter().find(|(m, _)| m == n).map_or(String::new(), |(_, e)| scientific(*e, 4));
            table.push([label.to_owned()].into_iter().chain(meshes.iter().map(cell)));
        }
    }
    table
}

/// Bases with domains converge; standard MPM does not, and that is a finding, too.
fn convergence(name: &str, meshes: &[u32], methods: &[Method], errors: &[Vec<f64>]) -> Vec<Check> {
    let (first, last) = (1, meshes.iter().position(|&n| n == 64).expect("64 cells are always run"));
    let mut checks = Vec::new();
    for (method, errors) in methods.iter().zip(errors) {
        let halvings = (last - first) as f64;
        let order = (errors[first] / errors[last]).log2() / halvings;
        if *method == SMPM {
            let converges = errors[last] < 0.5 * errors[first];
            checks.push(Check::none(
                format!("{name}, sMPM: converges from 8 to 64 cells (it should not)"),
                usize::from(converges),
            ));
        } else {
            let what = format!("{name}, {}: order from 8 to 64 cells, lack below 1.4", method.name);
            checks.push(
                Check::new(what, (1.4 - order).max(0.0) + 0.0 * order, 0.0).remark(format!("order {order:.2}")),
            );
        }
    }
    checks
}

fn ample(meshes: &[u32], gimp: &[f64]) -> Vec<Check> {
    let found = AMPLE.iter().filter_map(|&(n, expected)| {
        let k = meshes.iter().position(|&it| it == n)?;
        let what = format!("hard, GIMP, {n} cells: error against AMPLE's (relative)");
        Some(Check::new(what, (gimp[k] / expected - 1.0).abs(), 0.01).remark(scientific(gimp[k], 4)))
    });
    found.collect()
}

fn sixteen_cells(history: &History) -> Vec<Check> {
    let heights: Vec<f64> = history.last().positions.chunks_exact(3).map(|x| x[1]).collect();
    let (top, sum) = (largest(heights.iter().copied()), heights.iter().sum::<f64>());
    let solves: f64 = history.series("newton_iterations", 0).iter().sum();
    vec![
        Check::new(
            "hard, GIMP, 16 cells: highest point against 23.2216228596",
            (top - 23.221_622_859_6).abs(),
            1e-6,
        ),
        Check::new(
            "hard, GIMP, 16 cells: sum of heights against 626.9613169076",
            (sum - 626.961_316_907_6).abs(),
            1e-4,
        ),
        Check::new(
            "hard, GIMP, 16 cells: Newton iterations beyond AMPLE's 126",
            (solves - 126.0).max(0.0),
            0.0,
        )
        .remark(format!("{solves} in 40 load steps")),
    ]
}

fn panel(name: &str, load_case: Load, meshes: &[u32], methods: &[Method], errors: &[Vec<f64>]) -> Panel {
    let mut curves: Vec<Curve> = methods
        .iter()
        .zip(errors)
        .enumerate()
        .map(|(colour, (method, errors))| Curve {
            name: method.name.into(),
            colour,
            // CPDI1 and CPDI2q are the same here.
            stroke: if *method == CPDI2Q { Stroke::Dashes } else { Stroke::Line },
            points: meshes
                .iter()
                .zip(errors)
                .filter(|(_, e)| !e.is_nan())
                .map(|(&n, &e)| (f64::from(n), e))
                .collect(),
        })
        .collect();
    if load_case == Load::Hard {
        let marks = |values: [(u32, f64); 7]| values.map(|(n, e)| (f64::from(n), e)).to_vec();
        let series = [("AMPLE, GIMP", 1, AMPLE), ("AMPLE, sMPM", 0, AMPLE_SMPM)];
        curves.extend(series.map(|(name, colour, values)| Curve {
            name: name.into(),
            colour,
            stroke: Stroke::Marks,
            points: marks(values),
        }));
    }
    Panel::Curves(Curves {
        title: format!("Self-weight column, {name}"),
        axes: ["cells", "error of the stress"].map(String::from),
        range: [(3.0, 700.0), (1e-5, 1.0)],
        logarithmic: [true; 2],
        legend: Legend::LowerLeft,
        curves,
    })
}

fn solid(extent: Extent) -> Result<Findings, Broken> {
    let mut checks = Vec::new();
    for &cells in extent.pick(&[8_u32][..], &[8, 16]) {
        let pairs = [
            (SolidBasis::Gimp, "GIMP", GIMP),
            (SolidBasis::Cpdi1, "CPDI1", CPDI1),
            (SolidBasis::Cpdi2Hexahedron, "CPDI2 hexahedra", CPDI2Q),
        ];
        for (basis, name, counterpart) in pairs {
            let space = stress_error(&run(&solid_column(basis, cells, 1)?)?.completed()?);
            let flat = stress_error(&run(&column(Load::Hard, &counterpart, cells)?)?.completed()?);
            let what = format!("{name}, {cells} cells: error against that in the plane (relative)");
            checks.push(Check::new(what, (space / flat - 1.0).abs(), 1e-6).remark(scientific(space, 4)));
        }
        let space = stress_error(&run(&solid_column(SolidBasis::Cpdi2Tetrahedron, cells, 1)?)?.completed()?);
        let coarser = stress_error(&run(&column(Load::Hard, &CPDI2Q, cells / 2)?)?.completed()?);
        checks.push(
            Check::new(
                format!("CPDI2 tetrahedra, {cells} cells: error over that of {} cells in the plane", cells / 2),
                space / coarser,
                1.0,
            )
            .remark(scientific(space, 4)),
        );
    }
    for &cells in extent.pick(&[4_u32][..], &[4, 8]) {
        let cube = stress_error(&run(&solid_column(SolidBasis::Gimp, cells, cells)?)?.completed()?);
        let flat = stress_error(&run(&column(Load::Hard, &GIMP, cells)?)?.completed()?);
        let what = format!("GIMP, cube of {cells}³ cells: error against that in the plane (relative)");
        checks.push(Check::new(what, (cube / flat - 1.0).abs(), 1e-6).remark(scientific(cube, 4)));
    }
    Ok(checks.into())
}

/// The column of so many cells, `wide` of them wide and deep.
pub(super) fn solid_column(basis: SolidBasis, cells: u32, wide: u32) -> Result<Scene, Broken> {
    let Scene::Solid(mut scene) = load("column_solid")? else {
        return Err("expected a scene in three dimensions".into());
    };
    let width = HEIGHT / f64::from(cells) * f64::from(wide);
    scene.basis = basis;
    if let MeshInput::Box { axes, .. } = &mut scene.mesh {
        narrow(axes, width, wide);
        narrow(&mut axes[1..2], HEIGHT, cells);
    }
    if let ShapeInput::Box { to, .. } = &mut scene.bodies[0].shape {
        (to.0[0], to.0[2]) = (width, width);
    }
    for support in scene.supports.iter_mut().filter(|it| it.name == "right" || it.name == "back") {
        if let RegionInput::Plane { at, .. } = &mut support.region {
            at.0 = width;
        }
    }
    Ok(Scene::Solid(scene))
}
