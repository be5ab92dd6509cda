//! The body at a recorded step: its domains or points coloured by a field, and the mesh.

use crate::acting::{Around, Symbols};
use crate::colour::Colour;
use crate::drawn::Drawn;
use crate::error::PictureError;
use crate::seen::{Piece, Points};
use crate::tools::Tools;
use crate::view::BodyView;
use mpm_grid::six_digits;
use mpm_grid::{Layout, LoadFraction, MeshMotion};
use mpm_plot::{ColourBar, Patch, Shapes, Symbol};
use mpm_scene::{Scene, in_plane, mesh_of};
use std::ops::Range;

/// Margin round the body, relative to its size.
const ROOM: f64 = 0.06;

/// How far a picture goes along tools beyond the body, relative to its size.
const TOOLS: f64 = 0.25;

/// Shade of a body that no field colours [part of the colour bar].
const PLAIN: f64 = 0.3;

/// Bodies of a results file, ready to be drawn.
pub(crate) struct Bodies<'a> {
    file: &'a Drawn,
    view: &'a BodyView,
    /// What colours the body; nothing where no field is recorded.
    colour: Option<Colour>,
    /// The mesh of the scene, if it is to be drawn.
    mesh: Option<(Layout<2>, MeshMotion<2>)>,
    tools: Tools,
    points: Points<'a>,
    acting: Symbols,
}

/// What all pictures of a sequence share.
pub(crate) struct Scales {
    room: [(f64, f64); 2],
    colours: (f64, f64),
}

impl<'a> Bodies<'a> {
    pub(crate) fn of(file: &'a Drawn, view: &'a BodyView) -> Result<Self, PictureError> {
        let solid = matches!(file.scene, Scene::Solid(_));
        if !solid && view.slice.is_some() {
            return Err(PictureError::of("slice", "for results in three dimensions; these are in the plane"));
        }
        if !solid && view.cut.is_some() {
            return Err(PictureError::of("cut", "for results in three dimensions; these are in the plane"));
        }
        if solid && view.domains {
            return Err(PictureError::of("domains", "for results in the plane; these are in three dimensions"));
        }
        if view.mirror && !matches!(file.scene, Scene::Axisymmetric(_)) {
            return Err(PictureError::of("mirror", "for results of `Axisymmetric` scenes"));
        }
        let mesh = match &file.scene {
            _ if !view.mesh => None,
            Scene::PlaneStrain(scene) => Some(mesh_of(scene)),
            Scene::Axisymmetric(scene) => Some(in_plane(scene).and_then(|scene| mesh_of(&scene))),
            Scene::Solid(_) => None,
        };
        let mesh = mesh.transpose().map_err(|error| {
            PictureError::new(format!("the scene of the results gives no mesh: {error}; leave the mesh out"))
        })?;
        let colour = Colour::of(file, view.field.as_deref())?;
        let tools = if view.tools { Tools::of(file)? } else { Tools::default() };
        let points = Points::of(file, view)?;
        let acting = if mesh.is_some() { Symbols::of(file)? } else { Symbols::default() };
        Ok(Self { file, view, colour, mesh, tools, points, acting })
    }

    /// The recorded steps up to the one that is wanted, without the others before it.
    pub(crate) fn steps(&self, wanted: Option<usize>) -> Result<Range<usize>, PictureError> {
        let n = self.file.results.fractions().len();
        let step = wanted.unwrap_or(n - 1);
        if step >= n {
            let most = n - 1;
            return Err(PictureError::of(
                "step",
                format!("expected a recorded step from 0 to {most}, got {step}"),
            ));
        }
        Ok(step..step + 1)
    }

    /// Scales that hold all of these steps.
    pub(crate) fn scales(&self, steps: Range<usize>) -> Result<Scales, PictureError> {
        let mut room = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let mut colours = (f64::INFINITY, f64::NEG_INFINITY);
        let mut rigid: Vec<(f64, f64)> = Vec::new();
        let include = |ends: &mut (f64, f64), x: f64| *ends = (ends.0.min(x), ends.1.max(x));
        for step in steps {
            let tools = self.tools.at(self.file.results.fractions()[step]);
            let seen = self.points.seen(step, Vec::new())?;
            let values = self.values(step)?;
            let mut colour = |point: usize| {
                if let Some(value) = values.as_ref().map(|values| values[point]).filter(|it| it.is_finite()) {
                    include(&mut colours, value);
                }
            };
            for Piece { point, corners, .. } in &seen.pieces {
                point.iter().for_each(|point| colour(*point));
                for corner in corners {
                    include(&mut room[0], corner.0);
                    include(&mut room[1], corner.1);
                }
            }
            for &(point, at) in &seen.discs {
                colour(point);
                for reach in [-seen.radius, seen.radius] {
                    include(&mut room[0], at.0 + reach);
                    include(&mut room[1], at.1 + reach);
                }
            }
            let placed = tools.iter().flatten().map(|x| self.points.place(x).0);
            rigid.extend(placed);
        }
        if !room.iter().all(|ends| ends.0 <= ends.1) {
            return Err(PictureError::new("no material point to draw: none is in the slice or the file"));
        }
        // Of tools that reach beyond the body a part is enough.
        let most = TOOLS * (room[0].1 - room[0].0).max(room[1].1 - room[1].0);
        let ends = room;
        for at in rigid {
            for (d, x) in [at.0, at.1].into_iter().enumerate() {
                include(&mut room[d], x.clamp(ends[d].0 - most, ends[d].1 + most));
            }
        }
        if self.view.mirror {
            room[0].1 = room[0].1.max(-room[0].0);
            room[0].0 = -room[0].1;
        }
        let more = ROOM * (room[0].1 - room[0].0).max(room[1].1 - room[1].0).max(f64::MIN_POSITIVE);
        let room = room.map(|(from, to)| (from - more, to + more));
        if let Some((from, to)) = self.view.range {
            // Comparisons with NaN are false, so that NaN is refused, too.
            if !(from < to && (to - from).is_finite()) {
                return Err(PictureError::of(
                    "range",
                    format!("expected two numbers that rise, got {from} {to}"),
                ));
            }
            colours = (from, to);
        } else if colours.0 > colours.1 {
            colours = (0.0, 1.0);
        } else if colours.1 - colours.0 <= 1e-12 * colours.0.abs().max(colours.1.abs()) {
            // A constant field gets the colour in the middle of the bar.
            let half = 0.5 * colours.0.abs().max(f64::from(u8::from(colours.0 == 0.0)));
            colours = (colours.0 - half, colours.1 + half);
        }
        Ok(Scales { room, colours })
    }

    /// The picture of a recorded step.
    pub(crate) fn panel(&self, step: usize, scales: &Scales) -> Result<Shapes, PictureError> {
        let tools = self.tools.at(self.file.results.fractions()[step]);
        let segment = |facet: &Vec<[f64; 3]>| [0, 1].map(|k| (facet[k][0], facet[k][1]));
        let outlines = tools.iter().filter(|facet| facet.len() == 2).map(segment).collect();
        let seen = self.points.seen(step, tools)?;
        let values = self.values(step)?;
        let (from, to) = scales.colours;
        let shade = |point: usize| values.as_ref().map_or(PLAIN, |values| (values[point] - from) / (to - from));
        let fraction = self.file.results.fractions()[step];
        let title = match self.file.scene.title() {
            "" => format!("load fraction {}", six_digits(fraction)),
            title => format!("{title}, load fraction {}", six_digits(fraction)),
        };
        let patch = |piece: Piece| {
            // Tools are grey.
            let value = piece.point.map_or(f64::NAN, shade);
            Patch { corners: piece.corners, value, light: piece.light }
        };
        let patches = seen.pieces.into_iter().map(patch).collect();
        let mut shapes = Shapes {
            title,
            range: scales.room,
            axes: self.points.axes(),
            triad: self.points.triad(),
            patches,
            discs: seen.discs.iter().map(|&(point, at)| (at, shade(point))).collect(),
            radius: seen.radius,
            lines: self.mesh(fraction)?,
            outlines,
            symbols: self.symbols(step, fraction, scales)?,
            bar: self.colour.as_ref().map(|it| ColourBar { label: it.label.clone(), range: scales.colours }),
            ..Shapes::default()
        };
        if self.view.mirror {
            mirror(&mut shapes);
        }
        Ok(shapes)
    }

    /// Supports and loads, drawn with the mesh.
    fn symbols(&self, step: usize, fraction: f64, scales: &Scales) -> Result<Vec<Symbol>, PictureError> {
        let Some(mesh) = &self.mesh else { return Ok(Vec::new()) };
        self.acting.at(fraction, &Around { mesh, points: &self.points, step, room: scales.room })
    }

    /// What colours each point.
    fn values(&self, step: usize) -> Result<Option<Vec<f64>>, PictureError> {
        self.colour.as_ref().map(|colour| colour.values(self.file, step)).transpose()
    }

    /// Edges of the mesh at a load fraction.
    fn mesh(&self, fraction: f64) -> Result<Vec<[(f64, f64); 2]>, PictureError> {
        let Some((layout, motion)) = &self.mesh else { return Ok(Vec::new()) };
        let no_mesh = |reason: String| {
            PictureError::new(format!("no mesh at load fraction {fraction}: {reason}; leave the mesh out"))
        };
        let at = LoadFraction::of_total(fraction).map_err(|error| no_mesh(error.to_string()))?;
        let mesh = motion.mesh_at(layout, at).map_err(|error| no_mesh(error.to_string()))?;
        let place = |node| {
            let x = mesh.position(node);
            (x[0], x[1])
        };
        Ok(mesh.lattice().edges().map(|edge| edge.map(place)).collect())
    }
}

/// Adds what is on the other side of the axis.
fn mirror(shapes: &mut Shapes) {
    let other = |(r, z): (f64, f64)| (-r, z);
    let discs: Vec<_> = shapes.discs.iter().map(|(at, shade)| (other(*at), *shade)).collect();
    shapes.discs.extend(discs);
    let of_patch = |patch: &Patch| Patch {
        corners: patch.corners.iter().map(|corner| other(*corner)).collect(),
        ..patch.clone()
    };
    let patches: Vec<_> = shapes.patches.iter().map(of_patch).collect();
    shapes.patches.extend(patches);
    for lines in [&mut shapes.lines, &mut shapes.outlines] {
        let others: Vec<_> = lines.iter().map(|line| line.map(other)).collect();
        lines.extend(others);
    }
    // On the axis a body of revolution is held along r by itself.
    let near_axis = 1e-6 * (shapes.range[0].1 - shapes.range[0].0);
    let is_beside = |symbol: &Symbol| match symbol {
        Symbol::Held { at, into, .. } => at.0.abs() > near_axis || into.0 == 0.0,
        Symbol::Arrow { .. } => true,
    };
    shapes.symbols.retain(is_beside);
    let of_symbol = |symbol: &Symbol| match *symbol {
        Symbol::Held { at, into, slides } => Symbol::Held { at: other(at), into: other(into), slides },
        Symbol::Arrow { at, along, pulls } => Symbol::Arrow { at: other(at), along: other(along), pulls },
    };
    let is_at_axis = |symbol: &&Symbol| match symbol {
        Symbol::Held { at, .. } | Symbol::Arrow { at, .. } => at.0.abs() <= near_axis,
    };
    let symbols: Vec<_> = shapes.symbols.iter().filter(|it| !is_at_axis(it)).map(of_symbol).collect();
    shapes.symbols.extend(symbols);
}

/// Size of a picture that shows this alone `[pixels]`.
pub(crate) fn size(shapes: &Shapes) -> (u32, u32) {
    const WIDTH: u32 = 960;
    let [x, y] = shapes.range;
    // Margins, labels, title and colour bar.
    let height = f64::from(WIDTH - 210) * (y.1 - y.0) / (x.1 - x.0) + 95.0;
    (WIDTH, height.clamp(260.0, 960.0) as u32)
}
