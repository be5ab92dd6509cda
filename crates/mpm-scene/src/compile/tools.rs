//! Rigid tools.

use super::names::{A_NAME, is_name};
use super::stages::Stages;
use super::tool_motion::{load, motion, on_axis};
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::language::{Coordinates, PlaneBasis, SceneIn, ShapeInput, SolidBasis, ToolInput, ToolPartInput};
use mpm_assembly::{RigidTool, ToolContact};
use mpm_contact::{
    Bounds, ContactError, Helix, HelixSize, Interface, Plane, Polygon, Revolution, Shape, Sphere, Surface, Tool,
};
use mpm_grid::{Axis, Layout, LoadFraction, Position, Span, Vector, six_digits};
use mpm_solver::{Model, NamedBody};
use nalgebra::Vector3;

/// Part of the smallest edge of a cell by which tools are rounded where the scene does not say.
const ROUNDING: f64 = 0.25;

/// Widths of a domain that a tool is thick at least: a corner in a thinner one could be nearer to its far side.
const LEAST_WIDTHS: f64 = 2.0;

/// Squares of the width of a domain (lengths, in the plane) that a tool's surface has at most, for memory's sake.
const MOST_WIDTHS: f64 = 1e6;

/// Part of a width by which rounding may make a tool thinner.
const ROUNDING_ERROR: f64 = 1e-9;

/// Load fractions, from 0 to 1, at which a tool is looked for in the mesh.
const LOOKS: u32 = 16;

/// A shape as a part of a tool.
type Part<const D: usize> = Box<dyn Shape<D>>;

/// The parts of tools in one space.
pub(super) trait ToolParts<const D: usize> {
    /// A part with edges of this radius of rounding `[L]`.
    ///
    /// # Errors
    /// The part does not exist in this space, or a number is none of such a shape.
    fn part(input: &ToolPartInput<D>, rounding: f64, files: &dyn SceneFiles) -> Result<Part<D>, String>;
}

impl ToolParts<2> for PlaneBasis {
    fn part(input: &ToolPartInput<2>, rounding: f64, _: &dyn SceneFiles) -> Result<Part<2>, String> {
        Ok(match input {
            ToolPartInput::Plane { through, normal } => Box::new(plane(through, normal)?),
            ToolPartInput::Disc { centre, radius } => Box::new(disc(centre, radius.0)?),
            ToolPartInput::Polygon { vertices } => {
                let vertices = vertices.iter().map(|it| Vector::<2>::new(it.0.0.0, it.0.1.0)).collect();
                Box::new(Polygon::new(vertices, rounding).map_err(told)?)
            }
            ToolPartInput::Cylinder { .. }
            | ToolPartInput::Cone { .. }
            | ToolPartInput::Helix { .. }
            | ToolPartInput::Surface { .. } => {
                return Err("in the plane the parts of tools are `Plane`, `Disc` and `Polygon`".into());
            }
        })
    }
}

impl ToolParts<3> for SolidBasis {
    fn part(input: &ToolPartInput<3>, rounding: f64, files: &dyn SceneFiles) -> Result<Part<3>, String> {
        Ok(match input {
            ToolPartInput::Plane { through, normal } => Box::new(plane(through, normal)?),
            ToolPartInput::Disc { centre, radius } => Box::new(disc(centre, radius.0)?),
            ToolPartInput::Polygon { .. } => {
                return Err("a polygon is a part of tools in the plane only".into());
            }
            ToolPartInput::Cylinder { axis, centre, radius, extent: (from, to) } => {
                let at = |along: f64| on_axis(*axis, centre, along);
                Box::new(Revolution::cylinder(at(from.0), at(to.0), radius.0, rounding).map_err(told)?)
            }
            ToolPartInput::Cone { axis, tip, radius, tip_radius, length } => {
                let tip = Vector::from(tip.0);
                let base = tip + Vector3::ith(axis.index(), length.0);
                Box::new(Revolution::cone(tip, base, [tip_radius.0, radius.0], rounding).map_err(told)?)
            }
            ToolPartInput::Helix { axis, start, radii, pitch, turns, thickness } => {
                let (along, from) =
                    (Vector3::ith(axis.index(), 1.0), Vector3::ith((axis.index() + 1) % 3, 1.0));
                let size = HelixSize {
                    radii: [radii.0.0, radii.1.0],
                    pitch: pitch.0,
                    turns: turns.0,
                    thickness: thickness.0,
                };
                Box::new(Helix::new(Vector::from(start.0), along, from, &size).map_err(told)?)
            }
            ToolPartInput::Surface { file, scale, shift } => {
                let surface = files.surface(file)?.placed(scale.0, &shift.0);
                let (vertices, facets) = (surface.vertices().to_vec(), surface.facets().to_vec());
                Box::new(Surface::new(vertices, facets, rounding).map_err(told)?)
            }
        })
    }
}

fn told(it: ContactError) -> String {
    it.to_string()
}

fn plane<const D: usize>(through: &Coordinates<D>, normal: &Coordinates<D>) -> Result<Plane<D>, String> {
    Plane::new(Vector::from(through.0), Vector::from(normal.0)).map_err(told)
}

fn disc<const D: usize>(centre: &Coordinates<D>, radius: f64) -> Result<Sphere<D>, String> {
    Sphere::new(Vector::from(centre.0), radius).map_err(told)
}

/// The tools of a scene, whose bodies are made.
pub(super) fn tools<const D: usize, B: ToolParts<D>>(
    scene: &SceneIn<D, B>,
    model: &Model<D>,
    files: &dyn SceneFiles,
) -> Result<Vec<ToolContact<D>>, SceneError> {
    let mut tools = Vec::with_capacity(scene.tools.len());
    let stages = Stages::of(&scene.schedule);
    for (k, input) in scene.tools.iter().enumerate() {
        let path = format!("tools[{k}]");
        let is_taken = scene.tools[..k].iter().any(|before| before.name == input.name);
        if !is_name(&input.name) || is_taken {
            let reason = format!("expected {A_NAME}, got {:?}", input.name);
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        let mut rigid = rigid::<D, B>(input, &path, &model.layout, (stages, files))?;
        rigid.cut_bodies = cut_bodies(scene, &input.name);
        check_bodies(input, &path, &model.bodies)?;
        refuse_along_a_path(input, &rigid, &path, model)?;
        let contact = ToolContact::new(&input.name, rigid);
        check_place(&contact, &path, model)?;
        tools.push(contact);
    }
    Ok(tools)
}

/// Path control begins at rest, and cannot balance a step again.
fn refuse_along_a_path<const D: usize>(
    input: &ToolInput<D>,
    rigid: &RigidTool<D>,
    path: &str,
    model: &Model<D>,
) -> Result<(), SceneError> {
    let paths = model.stages.iter().enumerate().filter(|(_, stage)| stage.path.is_some());
    for (number, _) in paths {
        if input.interface.augment > 0 {
            let reason = "is above 0, expected 0 under path control, which cannot balance a step again";
            return Err(SceneError::new(format!("{path}.interface.augment"), reason));
        }
        if rigid.motion.ramps().iter().any(|ramp| ramp.jumps_in(number as u32)) {
            let reason = "the ramp begins elsewhere than where the tool is, and path control begins there";
            return Err(SceneError::new(format!("{path}.motion"), reason));
        }
    }
    Ok(())
}

/// The parts of a tool in its own frame.
pub(super) fn tool<const D: usize, B: ToolParts<D>>(
    input: &ToolInput<D>,
    path: &str,
    layout: &Layout<D>,
    files: &dyn SceneFiles,
) -> Result<Tool<D>, SceneError> {
    if let Some(rounding) = input.rounding.filter(|rounding| rounding.0 < 0.0) {
        let reason = format!("is {}, expected at least 0", rounding.0);
        return Err(SceneError::new(format!("{path}.rounding"), reason));
    }
    let rounding = input.rounding.map_or_else(|| ROUNDING * smallest_edge(layout), |it| it.0);
    let part = |(k, part)| {
        B::part(part, rounding, files).map_err(|it| SceneError::new(format!("{path}.parts[{k}]"), it))
    };
    let parts = input.parts.iter().enumerate().map(part).collect::<Result<_, _>>()?;
    Tool::new(parts).map_err(|_| SceneError::new(format!("{path}.parts"), "expected at least one part"))
}

fn rigid<const D: usize, B: ToolParts<D>>(
    input: &ToolInput<D>,
    path: &str,
    layout: &Layout<D>,
    (stages, files): (Stages<'_>, &dyn SceneFiles),
) -> Result<RigidTool<D>, SceneError> {
    let tool = tool::<D, B>(input, path, layout, files)?;
    let from = &input.interface;
    let interface = Interface {
        friction: from.friction.0,
        adhesion: from.adhesion.0,
        adhesion_factor: from.adhesion_factor.0,
        stiffness: from.stiffness.0,
        shear_stiffness: from.shear_stiffness.0,
        separates: from.separates,
        augment: u32::from(from.augment),
    };
    interface.check().map_err(|it| SceneError::new(format!("{path}.interface"), it.to_string()))?;
    if interface.adhesion > 0.0 && interface.adhesion_factor > 0.0 {
        let reason = "stands beside an adhesion, expected one of the two";
        return Err(SceneError::new(format!("{path}.interface.adhesion_factor"), reason));
    }
    Ok(RigidTool {
        tool,
        motion: motion(&input.motion, stages, &format!("{path}.motion"))?,
        load: load(&input.motion, stages, &format!("{path}.motion"))?,
        interface,
        exact_friction: from.exact_friction,
        bodies: input.bodies.clone(),
        cut_bodies: Vec::new(),
        turns: false,
        moment_about: Vector::from(input.moment_about.0),
    })
}

/// Names of the bodies that are cut out along the tool, or along a shape that is none.
fn cut_bodies<const D: usize, B: ToolParts<D>>(scene: &SceneIn<D, B>, tool: &str) -> Vec<String> {
    let is_cut =
        |shape: &ShapeInput<D>| shape.without().iter().any(|it| it == tool) || !shape.cutouts().is_empty();
    scene.bodies.iter().filter(|body| is_cut(&body.shape)).map(|body| body.name.clone()).collect()
}

/// The bodies that meet a tool exist, and have corners.
fn check_bodies<const D: usize>(
    input: &ToolInput<D>,
    path: &str,
    bodies: &[NamedBody<D>],
) -> Result<(), SceneError> {
    for (k, name) in input.bodies.iter().enumerate() {
        let at = format!("{path}.bodies[{k}]");
        if input.bodies[..k].contains(name) {
            return Err(SceneError::new(at, format!("body `{name}` is named twice")));
        }
        if !bodies.iter().any(|named| named.name == *name) {
            return Err(SceneError::new(at, format!("no body is named `{name}`")));
        }
    }
    if input.interface.adhesion_factor.0 > 0.0 {
        let meets = |named: &&NamedBody<D>| input.bodies.is_empty() || input.bodies.contains(&named.name);
        let has_none = |named: &&NamedBody<D>| named.body.undrained_strength(0).is_none();
        if let Some(named) = bodies.iter().filter(meets).find(has_none) {
            let reason = format!(
                "the law of body `{}` has no undrained strength of which this could be a part: expected `VonMises` or \
                 `Tresca`, or `adhesion` in its place",
                named.name
            );
            return Err(SceneError::new(format!("{path}.interface.adhesion_factor"), reason));
        }
    }
    Ok(())
}

/// The tool is thick enough for the domains that meet it, no point stands inside it, and it stays in the mesh.
fn check_place<const D: usize>(
    contact: &ToolContact<D>,
    path: &str,
    model: &Model<D>,
) -> Result<(), SceneError> {
    let RigidTool { tool, motion, .. } = contact.rigid();
    let meeting = || model.bodies.iter().filter(|named| contact.meets(&named.name));
    let extents = || meeting().flat_map(|named| (0..named.body.n_points()).map(|p| named.body.extent(p)));
    let width = extents().map(|extent| extent.width).fold(f64::INFINITY, f64::min);
    // A rank that makes no points says nothing of them.
    let is_known = model.share.is_none() || width.is_finite();
    let thickness = tool.thickness();
    if is_known && thickness < (1.0 - ROUNDING_ERROR) * LEAST_WIDTHS * width {
        let reason = format!(
            "the tool is {} thick, expected at least {}: twice the width of the smallest point's domain",
            six_digits(thickness),
            six_digits(LEAST_WIDTHS * width)
        );
        return Err(SceneError::new(format!("{path}.parts"), reason));
    }
    let bounds = tool.bounds();
    let across = (bounds.to - bounds.from).norm() / width;
    if is_known && bounds.is_finite() && across.powi(D as i32 - 1) > MOST_WIDTHS {
        let reason = format!(
            "the tool is {} widths of the smallest point's domain long, expected at most {}: its surface is sampled",
            six_digits(across),
            six_digits(MOST_WIDTHS.powf(1.0 / (D as f64 - 1.0)))
        );
        return Err(SceneError::new(format!("{path}.parts"), reason));
    }
    let start = motion.pose(LoadFraction::START);
    for (body, named) in model.bodies.iter().enumerate().filter(|(_, it)| contact.meets(&it.name)) {
        let inside = (0..named.body.n_points())
            .map(|point| (point, named.body.point(point).position))
            .find(|(_, position)| tool.contains(&start.recall(position)));
        if let Some((point, position)) = inside {
            let point = model.share.as_ref().map_or(point, |numbers| numbers[body][point] as usize);
            let reason = format!(
                "material point {point} of body `{}` at {} stands inside the tool at the start",
                named.name,
                Position(&position)
            );
            return Err(SceneError::new(path, reason));
        }
    }
    let mesh = mesh_bounds(&model.layout);
    let looks = (0..model.stages.len() as u32)
        .flat_map(|stage| (0..=LOOKS).map(move |look| (stage, f64::from(look) / f64::from(LOOKS))));
    let leaves = looks
        .map(|(stage, value)| LoadFraction::start_of(stage).with_value(value))
        .find(|at| !tool.bounds().placed(&motion.pose(*at)).meets(&mesh));
    match leaves {
        None => Ok(()),
        Some(at) => {
            let reason = format!("the tool is outside the mesh at load fraction {}", at.total());
            Err(SceneError::new(format!("{path}.motion"), reason))
        }
    }
}

/// A box around the mesh at rest.
pub(super) fn mesh_bounds<const D: usize>(layout: &Layout<D>) -> Bounds<D> {
    match layout {
        Layout::Box { axes, .. } => {
            Bounds { from: Vector::from_fn(|d, _| axes[d].first()), to: Vector::from_fn(|d, _| axes[d].last()) }
        }
        Layout::Ring { centre, radii, height, .. } => {
            let side = |d: usize, sign: f64| match height {
                Some(height) if d == 2 && sign < 0.0 => height.first(),
                Some(height) if d == 2 => height.last(),
                _ => centre[d] + sign * radii.last(),
            };
            Bounds { from: Vector::from_fn(|d, _| side(d, -1.0)), to: Vector::from_fn(|d, _| side(d, 1.0)) }
        }
    }
}

/// The smallest edge of a cell at rest `[L]`.
pub(super) fn smallest_edge<const D: usize>(layout: &Layout<D>) -> f64 {
    let least =
        |axis: &Axis| (0..axis.cells()).map(|k| axis.node(k + 1) - axis.node(k)).fold(f64::INFINITY, f64::min);
    match layout {
        Layout::Box { axes, .. } => axes.iter().map(least).fold(f64::INFINITY, f64::min),
        Layout::Ring { radii, sectors, span, height, .. } => {
            let angle = match span {
                Span::Full => std::f64::consts::TAU,
                Span::Sector { from, to } => (to - from).abs(),
            };
            let around = 2.0 * radii.first() * (0.5 * angle / f64::from(*sectors)).sin();
            height.iter().map(least).fold(least(radii).min(around), f64::min)
        }
    }
}
