//! Rigid tools: their outlines, and the forces on them.

use crate::drawn::{Drawn, complain};
use crate::error::PictureError;
use mpm_io::{FolderFiles, Table};
use mpm_plot::{Curve, Curves, Legend, Panel, Stroke};
use mpm_scene::{Scene, ToolSurface, tool_surfaces};

/// Tools and where they stand at every row of the history.
#[derive(Default)]
pub(crate) struct Tools {
    /// Load fractions of the rows.
    fractions: Vec<f64>,
    /// Whether they turn in what is drawn, and not about an axis in it.
    turns: bool,
    /// Surface, position of its reference point, and angle, in space rotation.
    tools: Vec<(ToolSurface, Table, Table)>,
}

impl Tools {
    /// The tools of a results file; in space none where a file that one of them names is not there, or an older program has not
    /// recorded how they turn.
    pub(crate) fn of(file: &Drawn) -> Result<Self, PictureError> {
        let fractions = column(file, "load_fraction")?.values().to_vec();
        let in_space = matches!(file.scene, Scene::Solid(_));
        let turns = !matches!(file.scene, Scene::Axisymmetric(_));
        match Self::placed(file, if in_space { "rotation" } else { "angle" }) {
            Err(_) if in_space => Ok(Self { fractions, turns, tools: Vec::new() }),
            tools => Ok(Self { fractions, turns, tools: tools? }),
        }
    }

    fn placed(file: &Drawn, turned: &str) -> Result<Vec<(ToolSurface, Table, Table)>, PictureError> {
        let surfaces = tool_surfaces(&file.scene, &FolderFiles::beside(&file.path))
            .map_err(|error| PictureError::new(format!("the scene of the results gives no tools: {error}")))?;
        let placed = |surface: ToolSurface| {
            let column = |what: &str| column(file, &format!("tool/{}/{what}", surface.name));
            let (position, turned) = (column("position")?, column(turned)?);
            Ok((surface, position, turned))
        };
        surfaces.into_iter().map(placed).collect()
    }

    /// Facets of all tools at a load fraction: segments in the plane, triangles in space.
    pub(crate) fn at(&self, fraction: f64) -> Vec<Vec<[f64; 3]>> {
        let Some(row) = self.fractions.iter().position(|at| *at == fraction) else {
            return Vec::new();
        };
        let mut facets = Vec::new();
        for (surface, position, turned) in &self.tools {
            let turned = if self.turns { turned.row(row) } else { &[0.0] };
            let vertices = surface.placed(position.row(row), turned);
            let corners = |facet: &Vec<u32>| facet.iter().map(|&vertex| vertices[vertex as usize]).collect();
            facets.extend(surface.facets.iter().map(corners));
        }
        facets
    }
}

/// Forces on tools against the way of their reference points; against the load fraction where none moves.
pub(crate) fn forces(file: &Drawn) -> Result<Option<Panel>, PictureError> {
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

fn column(file: &Drawn, name: &str) -> Result<Table, PictureError> {
    file.results.column(name).map_err(complain)
}
