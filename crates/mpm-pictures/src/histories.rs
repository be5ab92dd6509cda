//! Curves of the history.

use crate::drawn::{Drawn, complain};
use crate::error::PictureError;
use mpm_grid::{LoadFraction, MeshMotion, Ramp};
use mpm_io::Table;
use mpm_plot::{Curve, Curves, Legend, Panel, Stroke};
use mpm_scene::language::{MotionInput, Scene, SceneIn};
use mpm_scene::mesh_of;

/// Most curves of Newton's method in a panel.
const MOST_STEPS: usize = 8;
/// Numbers below this part of the largest are rounding.
pub(crate) const ROUNDING: f64 = 1e-9;

/// Reactions against displacements of supports that move; where none does, against the load fraction.
pub(crate) fn reactions(file: &Drawn) -> Result<Option<Panel>, PictureError> {
    let mut names = named(file, "reaction/");
    // The sum of all has no displacement.
    names.retain(|name| name != "total");
    if names.is_empty() {
        return Ok(None);
    }
    let fractions = column(file, "load_fraction")?;
    // The reactions round a ring add up to zero but have a moment.
    let mut moment = 0.0_f64;
    for name in named(file, "reaction_moment/") {
        moment = column(file, &format!("reaction_moment/{name}"))?
            .values()
            .iter()
            .fold(moment, |a, x| a.max(x.abs()));
    }
    let mut driven: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let mut held = Vec::new();
    let along =
        |table: &Table, c: usize| (0..table.len()).map(|row| table.row(row)[c].abs()).fold(0.0, f64::max);
    let mut moves = Vec::new();
    for name in &names {
        let moved = column(file, &format!("displacement/{name}"))?;
        moves.push((0..moved.width()).map(|c| along(&moved, c)).collect::<Vec<f64>>());
    }
    let most = moves.iter().flatten().copied().fold(0.0, f64::max);
    for (name, moves) in names.iter().zip(&moves) {
        let reaction = column(file, &format!("reaction/{name}"))?;
        let moved = column(file, &format!("displacement/{name}"))?;
        let rows = 0..reaction.len();
        for (c, _) in moves.iter().enumerate().filter(|(_, moved)| **moved > ROUNDING * most) {
            let at = |row: usize| (moved.row(row)[c], reaction.row(row)[c]);
            // A free component has no reaction.
            if along(&reaction, c) > 0.0 {
                let axis = file.results.space().letters()[c.min(2)];
                driven.push((format!("{name}, {axis}"), rows.clone().map(at).collect()));
            }
        }
        let size = |row: usize| reaction.row(row).iter().map(|x| x * x).sum::<f64>().sqrt();
        held.push((name.clone(), rows.map(|row| (fractions.values()[row], size(row))).collect()));
    }
    let largest =
        held.iter().flat_map(|line: &(String, Vec<(f64, f64)>)| &line.1).map(|at| at.1).fold(0.0, f64::max);
    if largest <= ROUNDING * moment {
        return Ok(None);
    }
    // What is rounding beside the others is no curve.
    let is_more = |line: &(String, Vec<(f64, f64)>)| line.1.iter().any(|at| at.1.abs() > ROUNDING * largest);
    held.retain(is_more);
    driven.retain(is_more);
    let is_driven = most > 1e-12 && !driven.is_empty();
    Ok(Some(match is_driven {
        true => curves("Reactions", ["displacement [L]", "reaction [F]"], driven),
        false => curves("Reactions", ["load fraction", "size of the reaction [F]"], held),
    }))
}

/// Moments of reactions against the angle by which the mesh has turned; else against the load fraction.
pub(crate) fn moments(file: &Drawn) -> Result<Option<Panel>, PictureError> {
    let names = named(file, "reaction_moment/");
    if names.is_empty() {
        return Ok(None);
    }
    let fractions = column(file, "load_fraction")?;
    let angle = angle(&file.scene);
    let (axis, x): (&str, Vec<f64>) = match angle {
        Some(angle) => ("angle of the mesh [degrees]", fractions.values().iter().map(|x| angle(*x)).collect()),
        None => ("load fraction", fractions.values().to_vec()),
    };
    let mut lines = Vec::new();
    for name in names {
        let moment = column(file, &format!("reaction_moment/{name}"))?;
        let most = moment.values().iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        for c in 0..moment.width() {
            let values = (0..moment.len()).map(|row| moment.row(row)[c]);
            let is_rounding = values.clone().all(|x| x.abs() <= ROUNDING * most);
            if moment.width() == 1 || !is_rounding {
                let axis = if moment.width() == 1 { "" } else { [", x", ", y", ", z"][c.min(2)] };
                lines.push((format!("{name}{axis}"), x.iter().copied().zip(values).collect()));
            }
        }
    }
    Ok(Some(curves("Moments of reactions", [axis, "moment [F L]"], lines)))
}

/// Energies against the load fraction.
pub(crate) fn energies(file: &Drawn) -> Result<Option<Panel>, PictureError> {
    let names = named(file, "energy/");
    if names.is_empty() {
        return Ok(None);
    }
    let fractions = column(file, "load_fraction")?;
    let mut lines = Vec::new();
    for name in names {
        let energy = column(file, &format!("energy/{name}"))?;
        lines.push((name, fractions.values().iter().copied().zip(energy.values().iter().copied()).collect()));
    }
    let size = |line: &(String, Vec<(f64, f64)>)| line.1.iter().fold(0.0_f64, |size, at| size.max(at.1.abs()));
    let largest = lines.iter().map(size).fold(0.0, f64::max);
    lines.retain(|line| size(line) > ROUNDING * largest);
    Ok(Some(curves("Energies", ["load fraction", "energy [F L]"], lines)))
}

/// Residuals of the iterates of some load steps.
pub(crate) fn convergence(file: &Drawn) -> Result<Option<Panel>, PictureError> {
    let results = &file.results;
    let mut steps = Vec::new();
    for row in 0..results.rows() {
        let residuals = results.residuals(row).map_err(complain)?;
        // A residual of zero has no logarithm.
        let of = residuals.iter().enumerate().filter(|(_, residual)| **residual > 0.0);
        let points: Vec<(f64, f64)> = of.map(|(k, residual)| ((k + 1) as f64, *residual)).collect();
        if !points.is_empty() {
            steps.push((results.first_row() + row, points));
        }
    }
    let (Some(last), n) = (steps.len().checked_sub(1), steps.len().min(MOST_STEPS)) else { return Ok(None) };
    let shown = (0..n).map(|k| if n > 1 { k * last / (n - 1) } else { 0 });
    let lines: Vec<(String, Vec<(f64, f64)>)> =
        shown.map(|k| (format!("load step {}", steps[k].0), steps[k].1.clone())).collect();
    let all = || lines.iter().flat_map(|line| &line.1);
    let most = all().map(|at| at.0).fold(4.0, f64::max);
    let decade = |x: f64, round: fn(f64) -> f64| 10_f64.powf(round(x.log10()));
    let low = decade(all().map(|at| at.1).fold(f64::INFINITY, f64::min), f64::floor);
    let high = decade(all().map(|at| at.1).fold(0.0, f64::max), f64::ceil).max(10.0 * low);
    Ok(Some(Panel::Curves(Curves {
        title: "Newton's method".into(),
        axes: ["iteration", "out-of-balance force, relative"].map(String::from),
        range: [(1.0, most), (low, high)],
        logarithmic: [false, true],
        legend: Legend::UpperRight,
        curves: lined(lines, Stroke::MarkedLine),
    })))
}

fn lined(lines: Vec<(String, Vec<(f64, f64)>)>, stroke: Stroke) -> Vec<Curve> {
    let lines = lines.into_iter().enumerate();
    lines.map(|(k, (name, points))| Curve { name, colour: k + 1, stroke, points }).collect()
}

/// Lines over linear axes that just hold them.
pub(crate) fn curves(title: &str, axes: [&str; 2], lines: Vec<(String, Vec<(f64, f64)>)>) -> Panel {
    let ends = |of: fn(&(f64, f64)) -> f64| {
        let values = lines.iter().flat_map(|line| &line.1).map(of).filter(|x| x.is_finite());
        let (from, to) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        if from < to {
            let more = 0.04 * (to - from);
            (from - more, to + more)
        } else if from == to {
            (from - 1.0, to + 1.0)
        } else {
            (0.0, 1.0)
        }
    };
    let range = [ends(|at| at.0), ends(|at| at.1)];
    // Where the curves are rarest at the left, the legend is out of the way.
    let middle = |(from, to): (f64, f64)| 0.5 * (from + to);
    let early = lines.iter().flat_map(|line| &line.1).filter(|at| at.0 < middle(range[0]));
    let (above, below) = early.fold((0, 0), |(above, below), at| match at.1 > middle(range[1]) {
        true => (above + 1, below),
        false => (above, below + 1),
    });
    Panel::Curves(Curves {
        title: title.into(),
        axes: axes.map(String::from),
        range,
        logarithmic: [false; 2],
        legend: if above <= below { Legend::UpperLeft } else { Legend::LowerLeft },
        curves: lined(lines, Stroke::Line),
    })
}

/// Names of the columns with this beginning, without it.
fn named(file: &Drawn, prefix: &str) -> Vec<String> {
    file.results
        .columns()
        .iter()
        .filter_map(|column| column.name.strip_prefix(prefix).map(String::from))
        .collect()
}

fn column(file: &Drawn, name: &str) -> Result<Table, PictureError> {
    file.results.column(name).map_err(complain)
}

/// Angle of the mesh (of its inner edge, where it is twisted) at a load fraction `[degrees]`.
fn angle(scene: &Scene) -> Option<impl Fn(f64) -> f64 + use<>> {
    fn turned<const D: usize, B>(scene: &SceneIn<D, B>) -> Option<Ramp> {
        if !matches!(scene.motion, MotionInput::Rotate { .. } | MotionInput::Twist { .. }) {
            return None;
        }
        match mesh_of(scene).ok()?.1 {
            MeshMotion::Rotate { angle, .. } => Some(angle),
            MeshMotion::Twist { inner, .. } => Some(inner.1),
            _ => None,
        }
    }
    let ramp = match scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => turned(scene),
        Scene::Solid(scene) => turned(scene),
    }?;
    Some(move |total: f64| LoadFraction::of_total(total).map_or(f64::NAN, |at| ramp.value(at).to_degrees()))
}
