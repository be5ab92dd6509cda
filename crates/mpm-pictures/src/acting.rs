//! Supports and loads of a scene in the plane as symbols.

use crate::drawn::Drawn;
use crate::error::PictureError;
use crate::seen::Points;
use mpm_grid::{Layout, LoadFraction, MeshMotion};
use mpm_plot::Symbol;
use mpm_scene::{Acting, ActingOn, acting};
use mpm_solver::Prescribed;

/// Most symbols of a support or a load.
const MOST: usize = 24;

/// Supports and loads of a scene.
#[derive(Default)]
pub(crate) struct Symbols(Acting);

/// Where symbols are drawn.
pub(crate) struct Around<'a> {
    pub(crate) mesh: &'a (Layout<2>, MeshMotion<2>),
    pub(crate) points: &'a Points<'a>,
    /// Recorded step.
    pub(crate) step: usize,
    /// Ends of the picture.
    pub(crate) room: [(f64, f64); 2],
}

impl Symbols {
    /// Of a results file; none in space.
    pub(crate) fn of(file: &Drawn) -> Result<Self, PictureError> {
        acting(&file.scene).map(Self).map_err(|error| {
            PictureError::new(format!("the scene of the results gives no supports and loads: {error}"))
        })
    }

    /// The symbols of what acts at a load fraction.
    pub(crate) fn at(&self, fraction: f64, around: &Around<'_>) -> Result<Vec<Symbol>, PictureError> {
        let wrong =
            |reason: String| PictureError::new(format!("no mesh at load fraction {fraction}: {reason}"));
        let at = LoadFraction::of_total(fraction).map_err(|error| wrong(error.to_string()))?;
        let (layout, motion) = around.mesh;
        let mesh = motion.mesh_at(layout, at).map_err(|error| wrong(error.to_string()))?;
        let middle = around.room.map(|(from, to)| 0.5 * (from + to));
        let inside = |x: (f64, f64)| {
            let ends = |d: usize, x: f64| around.room[d].0 <= x && x <= around.room[d].1;
            ends(0, x.0) && ends(1, x.1)
        };
        let mut symbols = Vec::new();
        let Acting { nodes, supports, loads } = &self.0;
        for support in supports.iter().filter(|support| support.acts_in(at.stage())) {
            let along =
                support.components.each_ref().map(|it| !matches!(it, None | Some(Prescribed::Driven(_))));
            let places = nodes.iter().flat_map(|nodes| {
                support.nodes.iter().map(|&node| {
                    let x = nodes.position(&mesh, node);
                    (x[0], x[1])
                })
            });
            let places: Vec<(f64, f64)> = places.filter(|x| inside(*x)).collect();
            for at in thinned(&places) {
                let from = [at.0 - middle[0], at.1 - middle[1]].map(f64::signum);
                if along.contains(&true) {
                    symbols.push(Symbol::Held { at, along, from });
                }
            }
            let driven = support.components.each_ref().map(|it| match it {
                Some(Prescribed::Driven(ramp)) => ramp.value(at),
                _ => 0.0,
            });
            if driven != [0.0; 2] {
                symbols.extend(thinned(&places).map(|at| arrow(at, (driven[0], driven[1]), middle)));
            }
        }
        for load in loads {
            let part = load.ramp.value(at);
            if part == 0.0 {
                continue;
            }
            let along = (part * load.along[0], part * load.along[1]);
            symbols.extend(thinned(&self.places(&load.on, around)?).map(|at| arrow(at, along, middle)));
        }
        Ok(symbols)
    }

    /// Where a load acts.
    fn places(&self, on: &ActingOn, around: &Around<'_>) -> Result<Vec<(f64, f64)>, PictureError> {
        match on {
            // Inside the picture, at its upper right corner.
            ActingOn::All => Ok(vec![around.room]
                .into_iter()
                .map(|[x, y]| {
                    let part = |(from, to): (f64, f64)| from + 0.9 * (to - from);
                    (part(x), part(y))
                })
                .collect()),
            ActingOn::Position { body, near } => {
                Ok(around.points.nearest(around.step, body, *near)?.into_iter().collect())
            }
            ActingOn::Boundary { body, axis, at, within } => {
                let near =
                    |a: f64, b: f64| (a - b).abs() <= 1e-6 * (around.room[*axis].1 - around.room[*axis].0);
                let is_on = |x: &[f64; 3]| {
                    let inside = |(from, to): &([f64; 2], [f64; 2])| {
                        (0..2).all(|d| d == *axis || from[d] <= x[d] || near(from[d], x[d]))
                            && (0..2).all(|d| d == *axis || x[d] <= to[d] || near(to[d], x[d]))
                    };
                    near(x[*axis], *at) && within.as_ref().is_none_or(inside)
                };
                around.points.on_boundary(around.step, body, is_on)
            }
        }
    }
}

/// An arrow that pulls at what is on its way out of the picture, and pushes what is on its way in.
fn arrow(at: (f64, f64), along: (f64, f64), middle: [f64; 2]) -> Symbol {
    let pulls = (at.0 - middle[0]) * along.0 + (at.1 - middle[1]) * along.1 > 0.0;
    Symbol::Arrow { at, along, pulls }
}

/// So many places that symbols do not cover each other.
fn thinned(places: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    places.iter().copied().step_by(places.len().div_ceil(MOST).max(1))
}
