//! Rigid tools: their outlines, and the forces on them.

use super::drawn::{Drawn, complain};
use crate::complaint::Complaint;
use mpm_io::Table;
use mpm_plot::{Curve, Curves, Legend, Panel, Stroke};
use mpm_scene::{Scene, ToolOutline, in_plane, tool_outlines};

/// Tools in the plane and where they stand at every row of the history.
pub struct Tools {
    fractions: Table,
    /// Whether they turn in the plane that is drawn, and not about an axis in it.
    turns: bool,
    tools: Vec<(ToolOutline, Table, Table)>,
}

impl Tools {
    /// The tools of a results file; none in space.
    pub fn of(file: &Drawn) -> Result<Self, Complaint> {
        let outlines = match &file.scene {
            Scene::PlaneStrain(scene) => tool_outlines(scene),
            Scene::Axisymmetric(scene) => in_plane(scene).and_then(|scene| tool_outlines(&scene)),
            Scene::Solid(_) => Ok(Vec::new()),
        };
        let outlines = outlines
            .map_err(|error| Complaint::input(format!("the scene of the results gives no tools: {error}")))?;
        let placed = |outline: ToolOutline| {
            let column = |what: &str| column(file, &format!("tool/{}/{what}", outline.name));
            let (position, angle) = (column("position")?, column("angle")?);
            Ok((outline, position, angle))
        };
        let tools = outlines.into_iter().map(placed).collect::<Result<_, Complaint>>()?;
        let turns = !matches!(file.scene, Scene::Axisymmetric(_));
        Ok(Self { fractions: column(file, "load_fraction")?, turns, tools })
    }

    /// Segments of all tools at a load fraction.
    pub fn at(&self, fraction: f64) -> Vec<[(f64, f64); 2]> {
        let Some(row) = self.fractions.values().iter().position(|at| *at == fraction) else {
            return Vec::new();
        };
        let turns = f64::from(u8::from(self.turns));
        let of_tool = |(outline, position, angle): &(ToolOutline, Table, Table)| {
            let (to, about) = (position.row(row).to_vec(), outline.moment_about);
            let (sine, cosine) = (turns * angle.row(row)[0]).to_radians().sin_cos();
            let place = move |x: [f64; 2]| {
                let arm = [x[0] - about[0], x[1] - about[1]];
                (to[0] + cosine * arm[0] - sine * arm[1], to[1] + sine * arm[0] + cosine * arm[1])
            };
            outline.segments.iter().map(move |segment| segment.map(&place)).collect::<Vec<_>>()
        };
        self.tools.iter().flat_map(of_tool).collect()
    }
}

/// Forces on tools against the way of their reference points; against the load fraction where none moves.
pub fn forces(file: &Drawn) -> Result<Option<Panel>, Complaint> {
    let ends = ("tool/", "/force");
    let columns = file.results.columns().iter().map(|column| column.name.as_str());
    let names: Vec<&str> = columns.filter_map(|name| name.strip_prefix(ends.0)?.strip_suffix(ends.1)).collect();
    if names.is_empty() {
        return Ok(None);
    }
    let fractions = column(file, "load_fraction")?;
    let mut tools = Vec::new();
    for name in names {
        let force = column(file, &format!("tool/{name}/force"))?;
        let position = column(file, &format!("tool/{name}/position"))?;
        tools.push((name, force, way(&position)));
    }
    let moves = tools.iter().any(|(_, _, way)| way.last().is_some_and(|last| *last > 0.0));
    let mut curves = Vec::new();
    for (name, force, way) in &tools {
        let along = if moves { &way[..] } else { fractions.values() };
        for (c, axis) in file.results.space().letters().iter().enumerate().take(force.width()) {
            let points: Vec<(f64, f64)> =
                along.iter().enumerate().map(|(row, x)| (*x, force.row(row)[c])).collect();
            if points.iter().any(|(_, force)| *force != 0.0) {
                curves.push(Curve {
                    name: format!("{name}, {axis}"),
                    colour: curves.len(),
                    stroke: Stroke::Line,
                    points,
                });
            }
        }
    }
    let axis = if moves { "way of the tool [L]" } else { "load fraction" };
    let ends = |of: fn(&(f64, f64)) -> f64| {
        let all = curves.iter().flat_map(|curve| &curve.points).map(of);
        all.fold((0.0_f64, f64::MIN_POSITIVE), |(low, high), x| (low.min(x), high.max(x)))
    };
    Ok(Some(Panel::Curves(Curves {
        title: "Forces on tools".into(),
        axes: [axis.to_owned(), "force [F]".to_owned()],
        range: [ends(|at| at.0), ends(|at| at.1)],
        logarithmic: [false; 2],
        legend: Legend::UpperLeft,
        curves,
    })))
}

/// Length of the way up to every row.
fn way(position: &Table) -> Vec<f64> {
    let mut way = 0.0;
    let step = |row: usize| {
        if row > 0 {
            let apart = position.row(row).iter().zip(position.row(row - 1)).map(|(a, b)| (a - b).powi(2));
            way += apart.sum::<f64>().sqrt();
        }
        way
    };
    (0..position.len()).map(step).collect()
}

fn column(file: &Drawn, name: &str) -> Result<Table, Complaint> {
    file.results.column(name).map_err(complain)
}
