//! Supports, walls and loads of a scene in the plane as symbols.

use crate::drawn::Drawn;
use crate::error::PictureError;
use crate::seen::Points;
use mpm_grid::{Layout, LoadFraction, MeshMotion};
use mpm_io::FolderFiles;
use mpm_plot::Symbol;
use mpm_scene::{Acting, ActingOn, Along, DrawnLoad, DrawnSide, acting};
use mpm_solver::{Prescribed, Support};

/// Places of a side at most that are followed.
const MOST: usize = 200;
/// Size of a picture `[pixels]`, and how far apart symbols of supports and of loads stand at least `[pixels]`.
const PICTURE: f64 = 800.0;
const APART: f64 = 20.0;
const ARROWS: f64 = 14.0;

/// A place, and a direction there.
type Pointed = ((f64, f64), (f64, f64));

/// Supports, walls and loads of a scene.
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

impl Around<'_> {
    fn middle(&self) -> [f64; 2] {
        self.room.map(|(from, to)| 0.5 * (from + to))
    }

    /// Length of a pixel, about `[L]`.
    fn pixel(&self) -> f64 {
        self.room.iter().map(|(from, to)| to - from).fold(0.0, f64::max) / PICTURE
    }

    fn is_inside(&self, x: (f64, f64)) -> bool {
        let ends = |d: usize, x: f64| self.room[d].0 <= x && x <= self.room[d].1;
        ends(0, x.0) && ends(1, x.1)
    }
}

impl Symbols {
    /// Of a results file; none in space.
    pub(crate) fn of(file: &Drawn) -> Result<Self, PictureError> {
        acting(&file.scene, &FolderFiles::beside(&file.path)).map(Self).map_err(|error| {
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
        let Acting { nodes, supports, loads, walls } = &self.0;
        let (mut held, mut arrows) = (Vec::new(), Vec::new());
        for support in supports.iter().filter(|support| support.acts_in(at.stage())) {
            let places = nodes.iter().flat_map(|nodes| {
                support.nodes.iter().map(|&node| {
                    let x = nodes.position(&mesh, node);
                    (x[0], x[1])
                })
            });
            let places: Vec<(f64, f64)> = places.filter(|x| around.is_inside(*x)).collect();
            held.extend(holds(support, &places, around));
            let driven = support.components.each_ref().map(|it| match it {
                Some(Prescribed::Driven(ramp)) => ramp.value(at),
                _ => 0.0,
            });
            if driven != [0.0; 2] {
                let middle = around.middle();
                let driven = places.iter().map(|&at| arrow(at, (driven[0], driven[1]), middle));
                arrows.extend(spaced(driven.collect(), around));
            }
        }
        for (side, slides) in walls {
            for (at, outward) in facets(side, around)? {
                let into = (-outward.0, -outward.1);
                held.push(Symbol::Held { at, into, slides: *slides });
            }
        }
        for load in loads {
            let part = load.ramp.value(at);
            if part == 0.0 {
                continue;
            }
            arrows.extend(spaced(pulling(load, part, around)?, around));
        }
        let mut symbols = apart(held, APART * around.pixel());
        symbols.extend(arrows);
        Ok(symbols)
    }
}

/// Symbols of what a support holds at places.
fn holds(support: &Support<2>, places: &[(f64, f64)], around: &Around<'_>) -> Vec<Symbol> {
    let is_held = support.components.each_ref().map(|it| !matches!(it, None | Some(Prescribed::Driven(_))));
    let middle = around.middle();
    let symbol = |at: (f64, f64), d: usize, slides: bool| {
        let into = if d == 0 { (sign(middle[0] - at.0), 0.0) } else { (0.0, sign(middle[1] - at.1)) };
        Symbol::Held { at, into, slides }
    };
    // What holds both stands across the line of its nodes.
    let reach = |of: fn(&(f64, f64)) -> f64| {
        let (from, to) =
            places.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        to - from
    };
    let across = usize::from(reach(|at| at.0) >= reach(|at| at.1));
    let symbols = places.iter().map(|&at| match is_held {
        [true, true] => Some(symbol(at, across, false)),
        [true, false] => Some(symbol(at, 0, true)),
        [false, true] => Some(symbol(at, 1, true)),
        [false, false] => None,
    });
    symbols.flatten().collect()
}

/// 1 or -1.
fn sign(x: f64) -> f64 {
    1_f64.copysign(x)
}

/// The symbols that stand this far apart; those that hold both directions first, because others that slide say less.
fn apart(held: Vec<Symbol>, least: f64) -> Vec<Symbol> {
    let mut kept: Vec<(Symbol, (f64, f64))> = Vec::new();
    for round in [false, true] {
        for symbol in &held {
            let Symbol::Held { at, slides, .. } = *symbol else { continue };
            let is_near = |(_, there): &(Symbol, (f64, f64))| (there.0 - at.0).hypot(there.1 - at.1) < least;
            if slides == round && !kept.iter().any(is_near) {
                kept.push((*symbol, at));
            }
        }
    }
    kept.into_iter().map(|it| it.0).collect()
}

/// The arrows of a load at a part of it.
fn pulling(load: &DrawnLoad, part: f64, around: &Around<'_>) -> Result<Vec<Symbol>, PictureError> {
    let times = |[x, y]: [f64; 2]| (part * x, part * y);
    if let ActingOn::Side(side) = &load.on {
        let arrow = |(at, outward): Pointed| {
            let along = match load.along {
                Along::Fixed(along) => times(along),
                Along::Inwards(by) => times([-by * outward.0, -by * outward.1]),
            };
            Symbol::Arrow { at, along, pulls: along.0 * outward.0 + along.1 * outward.1 > 0.0 }
        };
        return Ok(facets(side, around)?.into_iter().map(arrow).collect());
    }
    let Along::Fixed(along) = load.along else { return Ok(Vec::new()) };
    let middle = around.middle();
    Ok(places(&load.on, around)?.into_iter().map(|at| arrow(at, times(along), middle)).collect())
}

/// Middles of the parts of a side, and outward normals of any length.
fn facets(side: &DrawnSide, around: &Around<'_>) -> Result<Vec<Pointed>, PictureError> {
    let every = side.facets.len().div_ceil(MOST).max(1);
    let ends: Vec<[f64; 2]> = side.facets.iter().step_by(every).flatten().copied().collect();
    let ends = around.points.carried(around.step, &side.body, &ends)?;
    let facet = |ends: &[(f64, f64)]| {
        let (from, to) = (ends[0], ends[1]);
        ((0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1)), (to.1 - from.1, from.0 - to.0))
    };
    Ok(ends.chunks_exact(2).map(facet).filter(|(at, _)| around.is_inside(*at)).collect())
}

/// Where a load acts that is not on a side by its name.
fn places(on: &ActingOn, around: &Around<'_>) -> Result<Vec<(f64, f64)>, PictureError> {
    match on {
        // Inside the picture, at its upper right corner.
        ActingOn::All => {
            let [x, y] = around.room.map(|(from, to)| from + 0.9 * (to - from));
            Ok(vec![(x, y)])
        }
        ActingOn::Side(_) => Ok(Vec::new()),
        ActingOn::Position { body, near } => {
            Ok(around.points.nearest(around.step, body, *near)?.into_iter().collect())
        }
        ActingOn::Boundary { body, axis, at, within } => {
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * (around.room[*axis].1 - around.room[*axis].0);
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

/// An arrow that pulls at what is on its way out of the picture, and pushes what is on its way in.
fn arrow(at: (f64, f64), along: (f64, f64), middle: [f64; 2]) -> Symbol {
    let pulls = (at.0 - middle[0]) * along.0 + (at.1 - middle[1]) * along.1 > 0.0;
    Symbol::Arrow { at, along, pulls }
}

/// The arrows inside the picture, so many that they do not cover each other.
fn spaced(arrows: Vec<Symbol>, around: &Around<'_>) -> Vec<Symbol> {
    let least = ARROWS * around.pixel();
    let mut kept: Vec<(Symbol, (f64, f64))> = Vec::new();
    for arrow in arrows {
        let Symbol::Arrow { at, .. } = arrow else { continue };
        let is_near = |(_, there): &(Symbol, (f64, f64))| (there.0 - at.0).hypot(there.1 - at.1) < least;
        if around.is_inside(at) && !kept.iter().any(is_near) {
            kept.push((arrow, at));
        }
    }
    kept.into_iter().map(|it| it.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_do_not_cover_each_other() {
        let row: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 0.0)).collect();
        let held = |at, slides| Symbol::Held { at, into: (0.0, 1.0), slides };
        let symbols = row.iter().map(|&at| held(at, true)).chain([held((45.0, 0.0), false)]).collect();
        let kept = apart(symbols, 10.0);
        let Symbol::Held { at, slides, .. } = kept[0] else { panic!("held") };
        assert!(!slides && at == (45.0, 0.0), "what holds most is drawn where it stands");
        assert_eq!(kept.len(), 10, "and rollers only beside it");
    }
}
