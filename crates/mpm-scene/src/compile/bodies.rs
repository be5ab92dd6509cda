//! Bodies: what their points fill.

use super::basis::FillBody;
use super::gradient;
use super::initial::{self, Beginning};
use super::law::Refusal;
use super::mesh::component;
use super::overlap::overlap;
use super::shapes::{WithSurface, cut_out, shape, solid_part};
use super::symmetry::{Sides, cut_sides};
use super::tools::{ToolParts, tool};
use crate::boundary::Boundary;
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::fill::Plan;
use crate::language::{
    BodyInput, FieldInput, LoadInput, MaterialInput, MeanDilatationInput, SceneIn, ShapeInput, TilingInput,
    TurnedInput,
};
use crate::limits::Room;
use crate::pieces::Shape;
use crate::places::{FaceShare, Place};
use mpm_assembly::{MeanDilatation, Space};
use mpm_contact::{Pose, Tool};
use mpm_geometry::Face;
use mpm_grid::{Layout, Mesh, Vector};
use mpm_solver::NamedBody;
use nalgebra::Vector3;

/// For every body the points next to the faces of its tractions, in the order of the loads.
type Faces<const D: usize> = Vec<Vec<Vec<FaceShare<D>>>>;

/// What is made of the bodies of a scene, each in their order.
#[derive(Default)]
pub(super) struct Bodies<const D: usize> {
    pub bodies: Vec<NamedBody<D>>,
    /// The points at their faces.
    pub faces: Faces<D>,
    /// The sides of their pieces, of those that need them.
    pub boundaries: Vec<Boundary<D>>,
    /// The sides on which they are cut by symmetry.
    pub cuts: Vec<Sides<D>>,
    /// The places of all their points.
    pub places: Vec<Vec<Place<D>>>,
    /// Numbers among these of the points that are made, where they are not all.
    pub numbers: Vec<Option<Vec<u64>>>,
}

/// Fills the bodies.
pub(super) fn bodies<const D: usize, B: FillBody<D> + ToolParts<D>>(
    scene: &SceneIn<D, B>,
    (layout, start, space): (&Layout<D>, &Mesh<D>, Space),
    files: &dyn SceneFiles,
    Room { memory, share }: Room,
) -> Result<Bodies<D>, SceneError> {
    let mesh = &Mesh::at_rest(layout);
    if scene.bodies.is_empty() {
        return Err(SceneError::new("bodies", "expected at least one body"));
    }
    check_outline(scene)?;
    let of_tools: Vec<_> = scene.tools.iter().map(|tool| (&tool.name[..], solid_part(tool))).collect();
    let of_tools = tool_shapes(&of_tools, layout, files)?;
    let mut made = Bodies::default();
    let mut shapes: Vec<WithSurface<'_, D>> = Vec::new();
    for (b, input) in scene.bodies.iter().enumerate() {
        let path = format!("bodies[{b}]");
        let others = &scene.bodies[..b];
        if others.iter().any(|other| other.name == input.name) {
            let reason = format!("a second body named `{}`", input.name);
            return Err(SceneError::new(format!("{path}.name"), reason));
        }
        let refuse = |it| SceneError::new(format!("{path}.shape"), it);
        shapes.push(WithSurface::of(input, layout, files).map_err(refuse)?);
        let cutouts = WithSurface::cutouts(input, layout, files).map_err(refuse)?;
        let Some((own, before)) = shapes.split_last() else { continue };
        let cut = cut_out(input, (others, before), &of_tools, &cutouts).map_err(refuse)?;
        let overlapped = others.iter().zip(before).find(|&other| overlap(other, (input, own)));
        if let Some((other, _)) = overlapped {
            let way_out = way_out(input, other);
            return Err(refuse(format!("body `{}` overlaps body `{}`{way_out}", input.name, other.name)));
        }
        made.cuts.push(cut_sides(input, own, (layout, space), &path)?);
        let (law, needs_mass) = law(scene, input, &path)?;
        let averages = input.mean_dilatation.is_some();
        gradient::check(law, &input.material, (space, averages))?;
        let (shape, shape_mesh) =
            shape(own, &cut, (layout, mesh), input.tiling, (files, memory)).map_err(refuse)?;
        let points_per_cell = points_per_cell(input, &shape, &path)?;
        super::splines::check_rank(start, &shape, points_per_cell, space.axes())
            .map_err(|it| SceneError::new(format!("{path}.points_per_cell"), it))?;
        let plan = Plan {
            start,
            space,
            points_per_cell,
            shape,
            shape_mesh: &shape_mesh,
            pose: pose(input, &path)?,
            needs_mass,
            keep_reference_positions: scene.output.fields.contains(&FieldInput::Displacement)
                || scene.loads.iter().any(|load| matches!(load, LoadInput::Vortex { .. })),
            faces: faces(scene, input)?,
            needs_sides: super::sides::are_named(scene, &input.name),
            memory,
            mean_dilatation: input.mean_dilatation.map(mean_dilatation),
            tools: tools_inside(scene, input, layout, files)?,
            share,
        };
        if let Some(initial) = &input.initial {
            initial::check(initial, law, D, &path)?;
        }
        let beginning = Beginning { law, initial: input.initial.as_ref(), files };
        let filled = scene.basis.fill(&scene.domains, &beginning, &plan).map_err(|refusal| match refusal {
            Refusal::Shape(reason) => refuse(reason),
            Refusal::Initial(reason) => SceneError::new(format!("{path}.initial"), reason),
            Refusal::Law(refused) => refused.of(&input.material),
        })?;
        made.bodies.push(NamedBody {
            name: input.name.clone(),
            body: filled.body,
            shape_volume: filled.shape_volume,
            density: filled.density,
        });
        made.faces.push(filled.faces);
        made.boundaries.push(filled.boundary);
        made.places.push(filled.places);
        made.numbers.push(filled.numbers);
    }
    Ok(made)
}

/// Where a turn moves a body to.
fn pose<const D: usize>(input: &BodyInput<D>, path: &str) -> Result<Option<Pose<D>>, SceneError> {
    let Some(TurnedInput { axis, about, angle }) = &input.turned else { return Ok(None) };
    let refuse = |reason: &str| Err(SceneError::new(format!("{path}.turned"), reason));
    let along = Vector3::from_fn(|d, _| axis.0.get(d).copied().unwrap_or(0.0));
    if D != 3 {
        return refuse("turns bodies in space; in the plane a `Box` has its own angle, `turned`");
    }
    if input.tiling != TilingInput::Shape {
        return refuse("does not follow the cells: expected `tiling: Shape`");
    }
    if !input.symmetry.is_empty() {
        return refuse("stands beside `symmetry`, whose planes are ends of the mesh: expected no turn");
    }
    match along.try_normalize(0.0) {
        None => Err(SceneError::new(format!("{path}.turned.axis"), "expected a direction, got no length")),
        Some(along) => {
            let turn = along * angle.0.to_radians();
            Ok(Some(Pose::turned(&Vector::from(about.0), &turn, &Vector::zeros())))
        }
    }
}

fn mean_dilatation(input: MeanDilatationInput) -> MeanDilatation {
    match input {
        MeanDilatationInput::Points => MeanDilatation::Points,
        MeanDilatationInput::Cell => MeanDilatation::Cell,
    }
}

/// Refuses outlines of points in space.
fn check_outline<const D: usize, B>(scene: &SceneIn<D, B>) -> Result<(), SceneError> {
    if let Some(k) =
        scene.output.fields.iter().position(|field| *field == FieldInput::Outline).filter(|_| D != 2)
    {
        return Err(SceneError::new(
            format!("output.fields[{k}]"),
            format!("`Outline` is recorded in the plane only, and the scene has {D} dimensions"),
        ));
    }
    Ok(())
}

/// What of tools can be cut out of boxes, with the surfaces that it names.
fn tool_shapes<'a, const D: usize>(
    tools: &'a [(&'a str, Option<ShapeInput<D>>)],
    layout: &Layout<D>,
    files: &dyn SceneFiles,
) -> Result<Vec<(&'a str, Option<WithSurface<'a, D>>)>, SceneError> {
    let placed = |(k, (name, shape)): (usize, &'a (&'a str, Option<ShapeInput<D>>))| {
        let shape =
            shape.as_ref().map(|shape| WithSurface::placed(shape, [false; D], layout, files)).transpose();
        Ok((*name, shape.map_err(|it| SceneError::new(format!("tools[{k}].parts"), it))?))
    };
    tools.iter().enumerate().map(placed).collect()
}

/// The tools that a body is without.
fn tools_inside<const D: usize, B: ToolParts<D>>(
    scene: &SceneIn<D, B>,
    input: &BodyInput<D>,
    layout: &Layout<D>,
    files: &dyn SceneFiles,
) -> Result<Vec<Tool<D>>, SceneError> {
    let named = scene.tools.iter().enumerate().filter(|(_, it)| input.shape.without().contains(&it.name));
    named.map(|(k, it)| tool::<D, B>(it, &format!("tools[{k}]"), layout, files)).collect()
}

/// The law of a body, and whether a body force acts, so that its points need masses.
fn law<'a, const D: usize, B>(
    scene: &'a SceneIn<D, B>,
    input: &BodyInput<D>,
    path: &str,
) -> Result<(&'a MaterialInput, bool), SceneError> {
    let law = scene.materials.get(&input.material).ok_or_else(|| {
        let known: Vec<&str> = scene.materials.keys().map(String::as_str).collect();
        SceneError::new(
            format!("{path}.material"),
            format!("no material named `{}`; the scene has: {}", input.material, known.join(", ")),
        )
    })?;
    super::parameters::check(law, &input.material)?;
    let needs_mass = scene.loads.iter().any(|load| matches!(load, LoadInput::BodyForce { .. }));
    if needs_mass && law.density().is_none() {
        return Err(SceneError::new(
            format!("materials.{}", input.material),
            "a body force acts, so a `density` is needed",
        ));
    }
    Ok((law, needs_mass))
}

/// The faces of a body that carry tractions, in the order of the loads.
fn faces<const D: usize, B>(scene: &SceneIn<D, B>, input: &BodyInput<D>) -> Result<Vec<Face<D>>, SceneError> {
    let faces = scene.loads.iter().enumerate().filter_map(|(k, load)| match load {
        LoadInput::Traction { body, axis, at, side: None, within, .. } if *body == input.name => {
            let path = format!("loads[{k}]");
            let (Some(axis), Some(at)) = (axis, at) else {
                let reason = "expected `axis` and `at`, the plane on which it acts, or `side`";
                return Some(Err(SceneError::new(path, reason)));
            };
            let within = within.as_ref().map(|bounds| (bounds.from.0, bounds.to.0));
            let axis = component::<D>(*axis, &format!("{path}.axis"));
            Some(axis.and_then(|axis| match within {
                Some((from, to)) if !(from[axis]..=to[axis]).contains(&at.0) => {
                    let reason = format!(
                        "reaches from {} to {} across the plane at {}, expected bounds around it",
                        from[axis], to[axis], at.0
                    );
                    Err(SceneError::new(format!("{path}.within"), reason))
                }
                within => Ok(Face { axis, at: at.0, within }),
            }))
        }
        LoadInput::Traction { body, axis, at, side: Some(_), within, .. } if *body == input.name => {
            let beside = axis.is_some() || at.is_some() || within.is_some();
            let reason = "stands beside `axis`, `at` or `within`, expected the side or the plane";
            beside.then(|| Err(SceneError::new(format!("loads[{k}].side"), reason)))
        }
        _ => None,
    });
    faces.collect()
}

fn points_per_cell<const D: usize>(
    input: &BodyInput<D>,
    shape: &Shape<'_, D>,
    path: &str,
) -> Result<u32, SceneError> {
    match (&input.points_per_cell, shape) {
        (None, Shape::Parts(_)) => Ok(1),
        (Some(_), Shape::Parts(_)) => {
            let reason = "points that are given have no number per cell";
            Err(SceneError::new(format!("{path}.points_per_cell"), reason))
        }
        (Some(count), _) => Ok(count.0),
        (None, _) => Err(SceneError::new(path, "expected `points_per_cell`")),
    }
}

/// What can be done about bodies that overlap.
fn way_out<const D: usize>(a: &BodyInput<D>, b: &BodyInput<D>) -> &'static str {
    let [a, b] = [a, b].map(|body| matches!(body.shape, ShapeInput::Box { .. }));
    if a == b {
        ""
    } else {
        "; a box can leave out a `Cylinder`, `Tube`, `Sphere` or `Surface` that stands before it: `without`"
    }
}
