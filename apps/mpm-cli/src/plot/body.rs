//! The body at a recorded step: its domains or points coloured by a field, and the mesh.

use super::arguments::{BodyArguments, View};
use super::drawn::{Drawn, complain};
use super::tools::Tools;
use crate::complaint::Complaint;
use mpm_grid::six_digits;
use mpm_grid::{Layout, LoadFraction, MeshMotion};
use mpm_io::{Table, component_name};
use mpm_plot::{ColourBar, Shapes};
use mpm_scene::{Scene, in_plane, mesh_of};
use mpm_solver::observe::{Field, Space};
use std::ops::Range;

/// Margin round the body, relative to its size.
const ROOM: f64 = 0.06;

/// Shade of a body that no field colours [part of the colour bar].
const PLAIN: f64 = 0.3;

/// Bodies of a results file, ready to be drawn.
pub struct Bodies<'a> {
    file: &'a Drawn,
    arguments: &'a BodyArguments,
    /// What colours the body; nothing where no field is recorded.
    colour: Option<Colour>,
    /// The mesh of the scene, if it is to be drawn.
    mesh: Option<(Layout<2>, MeshMotion<2>)>,
    tools: Tools,
    solid: bool,
}

/// What colours the body.
struct Colour {
    field: String,
    component: Component,
    /// Name and unit.
    label: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    /// One of the numbers.
    Number(usize),
    /// Root of the sum of squares.
    Norm,
    /// A third of the trace.
    Mean,
    /// Norm of the deviator.
    Deviator,
}

/// What all pictures of a sequence share.
pub struct Scales {
    room: [(f64, f64); 2],
    colours: (f64, f64),
}

/// Points and domains as they are seen.
struct Seen {
    /// Centre and depth of every point that is shown, by number.
    points: Vec<(usize, (f64, f64), f64)>,
    domains: Option<Table>,
    radius: f64,
}

impl<'a> Bodies<'a> {
    pub fn of(file: &'a Drawn, arguments: &'a BodyArguments) -> Result<Self, Complaint> {
        let solid = matches!(file.scene, Scene::Solid(_));
        if !solid && arguments.slice.is_some() {
            return Err(Complaint::input(
                "--slice is for results in three dimensions; these are in the plane".into(),
            ));
        }
        if arguments.mirror && !matches!(file.scene, Scene::Axisymmetric(_)) {
            return Err(Complaint::input("--mirror is for results of `Axisymmetric` scenes".into()));
        }
        let mesh = match &file.scene {
            _ if arguments.no_mesh => None,
            Scene::PlaneStrain(scene) => Some(mesh_of(scene)),
            Scene::Axisymmetric(scene) => Some(in_plane(scene).and_then(|scene| mesh_of(&scene))),
            Scene::Solid(_) => None,
        };
        let mesh = mesh.transpose().map_err(|error| {
            Complaint::input(format!(
                "the scene of the results gives no mesh: {error}; leave it out by --no-mesh"
            ))
        })?;
        let colour = Colour::of(file, arguments.field.as_deref())?;
        Ok(Self { file, arguments, colour, mesh, tools: Tools::of(file)?, solid })
    }

    /// The recorded steps up to the one that is wanted, without the others before it.
    pub fn steps(&self, wanted: Option<usize>) -> Result<Range<usize>, Complaint> {
        let n = self.file.results.fractions().len();
        let step = wanted.unwrap_or(n - 1);
        if step >= n {
            let most = n - 1;
            return Err(Complaint::input(format!(
                "--step: expected a recorded step from 0 to {most}, got {step}"
            )));
        }
        Ok(step..step + 1)
    }

    /// Scales that hold all of these steps.
    pub fn scales(&self, steps: Range<usize>) -> Result<Scales, Complaint> {
        let mut room = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let mut colours = (f64::INFINITY, f64::NEG_INFINITY);
        let include = |ends: &mut (f64, f64), x: f64| *ends = (ends.0.min(x), ends.1.max(x));
        for step in steps {
            let seen = self.seen(step)?;
            let values = self.values(step)?;
            for &(point, at, _) in &seen.points {
                let radius = if seen.domains.is_some() { 0.0 } else { seen.radius };
                for sign in [-1.0, 1.0] {
                    include(&mut room[0], at.0 + sign * radius);
                    include(&mut room[1], at.1 + sign * radius);
                }
                let corners = seen.domains.iter().flat_map(|table| table.row(point).chunks_exact(2));
                for corner in corners {
                    include(&mut room[0], corner[0]);
                    include(&mut room[1], corner[1]);
                }
                if let Some(value) = values.as_ref().map(|values| values[point]).filter(|it| it.is_finite()) {
                    include(&mut colours, value);
                }
            }
        }
        if !room.iter().all(|ends| ends.0 <= ends.1) {
            return Err(Complaint::input("no material point to draw: none is in the slice or the file".into()));
        }
        if self.arguments.mirror {
            room[0].1 = room[0].1.max(-room[0].0);
            room[0].0 = -room[0].1;
        }
        let more = ROOM * (room[0].1 - room[0].0).max(room[1].1 - room[1].0).max(f64::MIN_POSITIVE);
        let room = room.map(|(from, to)| (from - more, to + more));
        if let Some(range) = &self.arguments.range {
            let (from, to) = (range[0], range[1]);
            // Comparisons with NaN are false, so that NaN is refused, too.
            if !(from < to && (to - from).is_finite()) {
                return Err(Complaint::input(format!(
                    "--range: expected two numbers that rise, got {from} {to}"
                )));
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
    pub fn panel(&self, step: usize, scales: &Scales) -> Result<Shapes, Complaint> {
        let seen = self.seen(step)?;
        let values = self.values(step)?;
        let (from, to) = scales.colours;
        let shade = |point: usize| values.as_ref().map_or(PLAIN, |values| (values[point] - from) / (to - from));
        let fraction = self.file.results.fractions()[step];
        let title = match self.file.scene.title() {
            "" => format!("load fraction {}", six_digits(fraction)),
            title => format!("{title}, load fraction {}", six_digits(fraction)),
        };
        let mut shapes = Shapes {
            title,
            range: scales.room,
            radius: seen.radius,
            lines: self.mesh(fraction)?,
            outlines: self.tools.at(fraction),
            bar: self.colour.as_ref().map(|it| ColourBar { label: it.label.clone(), range: scales.colours }),
            ..Shapes::default()
        };
        for &(point, at, _) in &seen.points {
            let corners = seen.domains.as_ref().map(|table| table.row(point));
            let corners: Vec<(f64, f64)> =
                corners.iter().flat_map(|row| row.chunks_exact(2)).map(|x| (x[0], x[1])).collect();
            // Points without a domain record their position as all of its corners.
            match corners.iter().all(|corner| *corner == at) {
                true => shapes.discs.push((at, shade(point))),
                false => shapes.domains.push((corners, shade(point))),
            }
        }
        if self.arguments.mirror {
            mirror(&mut shapes);
        }
        Ok(shapes)
    }

    /// What colours each point.
    fn values(&self, step: usize) -> Result<Option<Vec<f64>>, Complaint> {
        let Some(Colour { field, component, .. }) = &self.colour else { return Ok(None) };
        let table = self.file.results.field(field, step).map_err(complain)?;
        Ok(Some((0..table.len()).map(|point| component.of(table.row(point))).collect()))
    }

    /// The points of a step from behind to in front.
    fn seen(&self, step: usize) -> Result<Seen, Complaint> {
        let results = &self.file.results;
        let positions = results.points(step).map_err(complain)?;
        let outline = Field::OUTLINE.name();
        let is_recorded = results.fields().map_err(complain)?.iter().any(|name| name == outline);
        let domains = (is_recorded && !self.solid).then(|| results.field(outline, step)).transpose();
        let domains = domains.map_err(complain)?;
        if let Some(table) = domains.as_ref().filter(|table| table.width() != Field::OUTLINE.components()) {
            return Err(Complaint::input(format!(
                "field outline has {} numbers per point, expected 8",
                table.width()
            )));
        }
        let all = (0..positions.len()).map(|point| positions.row(point));
        let spacing = spacing(all.clone(), if self.solid { 3 } else { 2 });
        let mut points = Vec::new();
        for (point, x) in all.enumerate() {
            // More than half: a plane of the mesh lies halfway between points.
            let hidden = self.arguments.slice.is_some_and(|(axis, at)| (x[axis] - at).abs() > 0.75 * spacing);
            if !hidden {
                let (at, depth) = self.place(x);
                points.push((point, at, depth));
            }
        }
        if self.solid {
            points.sort_by(|a, b| a.2.total_cmp(&b.2));
        }
        Ok(Seen { points, domains, radius: 0.5 * spacing })
    }

    /// Where a point appears, and how near it is.
    fn place(&self, x: &[f64]) -> ((f64, f64), f64) {
        if !self.solid {
            return ((x[0], x[1]), 0.0);
        }
        // A slice is seen along its normal.
        let view = match self.arguments.slice {
            Some((0, _)) => View::X,
            Some((1, _)) => View::Y,
            Some(_) => View::Z,
            None => self.arguments.view,
        };
        match view {
            View::X => ((x[1], x[2]), x[0]),
            View::Y => ((x[0], x[2]), -x[1]),
            View::Z => ((x[0], x[1]), x[2]),
            View::Corner => {
                // Isometric, from (1, -1, 1).
                let (right, up) = (f64::sqrt(0.5) * (x[0] + x[1]), (2.0 * x[2] - x[0] + x[1]) / f64::sqrt(6.0));
                ((right, up), x[0] - x[1] + x[2])
            }
        }
    }

    /// Edges of the mesh at a load fraction.
    fn mesh(&self, fraction: f64) -> Result<Vec<[(f64, f64); 2]>, Complaint> {
        let Some((layout, motion)) = &self.mesh else { return Ok(Vec::new()) };
        let no_mesh = |reason: String| {
            Complaint::input(format!(
                "no mesh at load fraction {fraction}: {reason}; leave it out by --no-mesh"
            ))
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
    let of_domain = |(corners, shade): &(Vec<(f64, f64)>, f64)| {
        (corners.iter().map(|corner| other(*corner)).collect(), *shade)
    };
    let domains: Vec<_> = shapes.domains.iter().map(of_domain).collect();
    shapes.domains.extend(domains);
    for lines in [&mut shapes.lines, &mut shapes.outlines] {
        let others: Vec<_> = lines.iter().map(|line| line.map(other)).collect();
        lines.extend(others);
    }
}

/// Distance between neighbours if the points filled their cloud evenly: from occupied squares or cubes of a
/// coarse grid.
fn spacing<'a>(points: impl Iterator<Item = &'a [f64]> + Clone, dimensions: usize) -> f64 {
    let mut ends = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    let mut n = 0;
    for x in points.clone() {
        n += 1;
        for (end, x) in ends.iter_mut().zip(x) {
            *end = (end.0.min(*x), end.1.max(*x));
        }
    }
    let longest = ends[..dimensions].iter().map(|end| end.1 - end.0).fold(0.0, f64::max);
    if n < 2 || longest <= 0.0 {
        return 1.0;
    }
    // About eight points to a box, if the cloud were full.
    let volume: f64 = ends[..dimensions].iter().map(|end| (end.1 - end.0).max(1e-3 * longest)).product();
    let side = (8.0 * volume / f64::from(n)).powf(1.0 / dimensions as f64);
    let mut boxes: Vec<[i64; 3]> = points
        .map(|x| {
            std::array::from_fn(|d| if d < dimensions { ((x[d] - ends[d].0) / side).floor() as i64 } else { 0 })
        })
        .collect();
    boxes.sort_unstable();
    boxes.dedup();
    (boxes.len() as f64 / f64::from(n)).powf(1.0 / dimensions as f64) * side
}

impl Component {
    fn of(self, x: &[f64]) -> f64 {
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mean = || (x[0] + x[4] + x[8]) / 3.0;
        match self {
            Component::Number(c) => x[c],
            Component::Norm => norm(x),
            Component::Mean => mean(),
            Component::Deviator => {
                let mut deviator = [0.0; 9];
                deviator.copy_from_slice(x);
                [0, 4, 8].into_iter().for_each(|i| deviator[i] -= mean());
                norm(&deviator)
            }
        }
    }

    /// Components of a field of so many numbers, by name; the first is that of the field's bare name.
    fn all(space: Space, width: usize, is_gradient: bool) -> Vec<(String, Self)> {
        let numbers = (0..width).map(|c| (component_name(space, width, c), Component::Number(c)));
        let named = |name: &str, it| (format!(".{name}"), it);
        let first = match width {
            1 => Vec::new(),
            9 if is_gradient => vec![named("norm", Component::Norm), named("mean", Component::Mean)],
            9 => vec![
                named("deviator", Component::Deviator),
                named("mean", Component::Mean),
                named("norm", Component::Norm),
            ],
            _ => vec![named("norm", Component::Norm)],
        };
        first.into_iter().chain(numbers).collect()
    }
}

impl Colour {
    /// The field that is wanted, or the most telling one of those that are recorded.
    fn of(file: &Drawn, wanted: Option<&str>) -> Result<Option<Self>, Complaint> {
        let mut names = file.results.fields().map_err(complain)?;
        names.retain(|name| name != Field::OUTLINE.name());
        // The default is the first of these that is recorded.
        let telling = [Field::RHO, Field::CAUCHY_STRESS, Field::DISPLACEMENT];
        names
            .sort_by_key(|name| telling.iter().position(|field| field.name() == name).unwrap_or(telling.len()));
        let Some(wanted) = wanted.or(names.first().map(String::as_str)) else { return Ok(None) };
        let (field, of) = wanted.split_at(wanted.find(['.', '[']).unwrap_or(wanted.len()));
        if !names.iter().any(|name| name == field) {
            let recorded = if names.is_empty() { "none".into() } else { names.join(", ") };
            let message = format!("--field: no field `{field}` is recorded; there are {recorded}");
            return Err(Complaint::input(message));
        }
        let width = file.results.field(field, 0).map_err(complain)?.width();
        let is_gradient = field == Field::DEFORMATION_GRADIENT.name();
        let components = Component::all(file.results.space(), width, is_gradient);
        let found = if of.is_empty() { components.first() } else { components.iter().find(|it| it.0 == of) };
        let Some((name, component)) = found else {
            let names: Vec<&str> = components.iter().map(|it| it.0.as_str()).collect();
            let message = format!("--field: `{field}` has no component `{of}`; there are {}", names.join(", "));
            return Err(Complaint::input(message));
        };
        let unit = file.results.unit(field).map_err(complain)?;
        let label = format!("{field}{name} [{unit}]");
        Ok(Some(Self { field: field.to_string(), component: *component, label }))
    }
}

/// Size of a picture that shows this alone `[pixels]`.
pub fn size(shapes: &Shapes) -> (u32, u32) {
    const WIDTH: u32 = 960;
    let [x, y] = shapes.range;
    // Margins, title and colour bar.
    let height = f64::from(WIDTH - 124) * (y.1 - y.0) / (x.1 - x.0) + 50.0;
    (WIDTH, height.clamp(260.0, 960.0) as u32)
}
