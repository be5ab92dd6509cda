//! Bodies: what their points fill.

use super::basis::FillBody;
use super::mesh::{check_ring, component, plane_point};
use super::overlap::overlap;
use crate::error::SceneError;
use crate::files::SceneFiles;
use crate::fill::{Plan, Shape};
use crate::model::NamedBody;
use crate::observe::Field;
use crate::scene::{
    BodyInput, Direction, Finite, LoadInput, MaterialInput, MeanDilatationInput, PlanePoint, SceneIn,
    ShapeInput,
};
use mpm_assembly::MeanDilatation;
use mpm_geometry::{Face, MemoryLimit, Round, Solid, Surface};
use mpm_grid::{Axis, Layout, Mesh, Span};

/// Why a shape has no place in a ring mesh.
const NEEDS_BOX: &str =
    "such a body can only be filled in a box mesh; a ring mesh takes `Ring`, `Tube` and `Points`";

type BodiesAndFaces<const D: usize> = (Vec<NamedBody<D>>, Vec<Vec<Vec<(usize, f64)>>>);

/// The bodies, and for each of them the points next to the faces of its tractions, in the order of
/// the loads.
pub(super) fn bodies<const D: usize, B: FillBody<D>>(
    scene: &SceneIn<D, B>,
    layout: &Layout<D>,
    start: &Mesh<D>,
    files: &dyn SceneFiles,
    memory: MemoryLimit,
) -> Result<BodiesAndFaces<D>, SceneError> {
    let mesh = &Mesh::at_rest(layout);
    if scene.bodies.is_empty() {
        return Err(SceneError::new("bodies", "expected at least one body"));
    }
    if let Some(k) = scene.output.fields.iter().position(|field| *field == Field::Outline).filter(|_| D != 2) {
        return Err(SceneError::new(
            format!("output.fields[{k}]"),
            format!("`Outline` is recorded in the plane only, and the scene has {D} dimensions"),
        ));
    }
    let heavy = scene.loads.iter().any(|load| matches!(load, LoadInput::BodyForce { .. }));
    let (mut bodies, mut all_faces): BodiesAndFaces<D> = (Vec::new(), Vec::new());
    let mut shapes: Vec<WithSurface<'_, D>> = Vec::new();
    for (b, input) in scene.bodies.iter().enumerate() {
        let path = format!("bodies[{b}]");
        if scene.bodies[..b].iter().any(|other| other.name == input.name) {
            return Err(SceneError::new(
                format!("{path}.name"),
                format!("a second body named `{}`", input.name),
            ));
        }
        let refuse = |it| SceneError::new(format!("{path}.shape"), it);
        shapes.push(WithSurface::of(&input.shape, files).map_err(refuse)?);
        let Some((own, before)) = shapes.split_last() else { continue };
        let others = &scene.bodies[..b];
        let cut = cut_out(input, others, before).map_err(refuse)?;
        let overlapped = others.iter().zip(before).find(|&other| overlap(other, (input, own)));
        if let Some((other, _)) = overlapped {
            let way_out = way_out(input, other);
            return Err(refuse(format!("body `{}` overlaps body `{}`{way_out}", input.name, other.name)));
        }
        let law = scene.materials.get(&input.material).ok_or_else(|| {
            let known: Vec<&str> = scene.materials.keys().map(String::as_str).collect();
            SceneError::new(
                format!("{path}.material"),
                format!("no material named `{}`; the scene has: {}", input.material, known.join(", ")),
            )
        })?;
        let (MaterialInput::Hencky { density, .. } | MaterialInput::VonMises { density, .. }) = law;
        if heavy && density.is_none() {
            return Err(SceneError::new(
                format!("materials.{}", input.material),
                "a body force acts, so a `density` is needed",
            ));
        }
        let faces = scene.loads.iter().enumerate().filter_map(|(k, load)| match load {
            LoadInput::Traction { body, axis, at, within, .. } if *body == input.name => {
                let axis = component::<D>(*axis, &format!("loads[{k}].axis"));
                Some(axis.map(|axis| Face {
                    axis,
                    at: at.0,
                    within: within.as_ref().map(|bounds| (bounds.from.0, bounds.to.0)),
                }))
            }
            _ => None,
        });
        let (shape, shape_mesh) = shape(own, &cut, layout, mesh, files, memory).map_err(refuse)?;
        let points_per_cell = match (&input.points_per_cell, &shape) {
            (None, Shape::Parts(_)) => 1,
            (Some(_), Shape::Parts(_)) => {
                let reason = "points that are given have no number per cell";
                return Err(SceneError::new(format!("{path}.points_per_cell"), reason));
            }
            (Some(count), _) => count.0,
            (None, _) => return Err(SceneError::new(path, "expected `points_per_cell`")),
        };
        let plan = Plan {
            start,
            shape,
            shape_mesh: &shape_mesh,
            points_per_cell,
            density: density.filter(|_| heavy).map(|density| density.0),
            keep_reference_positions: scene.output.fields.contains(&Field::Displacement)
                || scene.loads.iter().any(|load| matches!(load, LoadInput::Vortex { .. })),
            faces: faces.collect::<Result<_, _>>()?,
            memory,
            mean_dilatation: input.mean_dilatation.map(|mean| match mean {
                MeanDilatationInput::Points => MeanDilatation::Points,
                MeanDilatationInput::Cell => MeanDilatation::Cell,
            }),
        };
        let filled = scene.basis.fill(&scene.domains, law, &plan).map_err(refuse)?;
        bodies.push(NamedBody {
            name: input.name.clone(),
            body: filled.body,
            shape_volume: filled.shape_volume,
        });
        all_faces.push(filled.faces);
    }
    Ok((bodies, all_faces))
}

/// What can be done about bodies that overlap.
fn way_out<const D: usize>(a: &BodyInput<D>, b: &BodyInput<D>) -> &'static str {
    let [a, b] = [a, b].map(|body| matches!(body.shape, ShapeInput::Box { .. }));
    if a == b {
        ""
    } else {
        "; a box can leave out a `Cylinder`, `Tube` or `Surface` that stands before it: `without`"
    }
}

/// A shape with the surface that it names, if it names one.
pub(super) struct WithSurface<'a, const D: usize> {
    pub shape: &'a ShapeInput<D>,
    pub surface: Option<Surface>,
}

impl<'a, const D: usize> WithSurface<'a, D> {
    fn of(shape: &'a ShapeInput<D>, files: &dyn SceneFiles) -> Result<Self, String> {
        let ShapeInput::Surface { file, scale, shift } = shape else {
            return Ok(Self { shape, surface: None });
        };
        let &[x, y, z] = &shift.0[..] else {
            return Err("a surface encloses a body in three dimensions only".into());
        };
        Ok(Self { shape, surface: Some(files.surface(file)?.placed(scale.0, &[x, y, z])) })
    }

    /// What it encloses in a box mesh.
    fn solid(&self, layout: &Layout<D>) -> Result<Solid<'_>, String> {
        match (self.shape, &self.surface) {
            (_, Some(surface)) => Ok(Solid::Surface(surface)),
            (ShapeInput::Cylinder { axis, centre, radius, extent }, _) => {
                round(layout, *axis, centre, (0.0, radius.0), *extent).map(Solid::Round)
            }
            (ShapeInput::Tube { axis, centre, inner, outer, extent }, _) => {
                round(layout, *axis, centre, (inner.0, outer.0), *extent).map(Solid::Round)
            }
            _ => Err("`without`: expected bodies whose shapes are `Cylinder`, `Tube` or `Surface`".into()),
        }
    }
}

/// The shapes that are cut out of a body.
fn cut_out<'a, const D: usize>(
    body: &BodyInput<D>,
    before: &[BodyInput<D>],
    shapes: &'a [WithSurface<'a, D>],
) -> Result<Vec<&'a WithSurface<'a, D>>, String> {
    let ShapeInput::Box { without, .. } = &body.shape else { return Ok(Vec::new()) };
    let of = |name: &String| {
        let other = before.iter().zip(shapes).find(|other| other.0.name == *name);
        let (other, shape) =
            other.ok_or_else(|| format!("`without`: no body named `{name}` stands before this one"))?;
        if other.points_per_cell != body.points_per_cell {
            return Err(format!("`without`: body `{name}` has another number of points per cell"));
        }
        Ok(shape)
    };
    without.iter().map(of).collect()
}

/// What is to be filled, and the mesh whose cells it is filled by.
fn shape<'a, const D: usize>(
    own: &'a WithSurface<'a, D>,
    cut: &[&'a WithSurface<'a, D>],
    layout: &Layout<D>,
    mesh: &Mesh<D>,
    files: &dyn SceneFiles,
    memory: MemoryLimit,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let in_box = |shape| match layout {
        Layout::Box { .. } => Ok((shape, mesh.clone())),
        Layout::Ring { .. } => Err(NEEDS_BOX.into()),
    };
    match own.shape {
        ShapeInput::Box { from, to, .. } if cut.is_empty() => in_box(Shape::Box { from: from.0, to: to.0 }),
        ShapeInput::Box { from, to, .. } => {
            let without = cut.iter().map(|it| it.solid(layout)).collect::<Result<_, _>>()?;
            in_box(Shape::Rest { from: from.0, to: to.0, without })
        }
        ShapeInput::Points { file } => Ok((Shape::Parts(files.points(file, D)?.parts(mesh)?), mesh.clone())),
        ShapeInput::Cylinder { .. } | ShapeInput::Surface { .. } => in_box(Shape::Solid(own.solid(layout)?)),
        ShapeInput::Ring { inner, outer, .. } if inner.0 <= 0.0 || inner.0 >= outer.0 => {
            Err(format!("expected radii 0 < inner < outer, got {} and {}", inner.0, outer.0))
        }
        ShapeInput::Tube { inner, outer, .. } if inner.0 >= outer.0 => {
            Err(format!("expected radii 0 < inner < outer, got {} and {}", inner.0, outer.0))
        }
        ShapeInput::Ring { inner, outer, centre } => match layout {
            Layout::Ring { .. } => ring_cells(layout, mesh, centre, (inner.0, outer.0), None),
            Layout::Box { axes, .. } => ring_of_its_own(axes, centre, (inner.0, outer.0), memory),
        },
        ShapeInput::Tube { axis, centre, inner, outer, extent } => match layout {
            Layout::Box { .. } => in_box(Shape::Solid(own.solid(layout)?)),
            Layout::Ring { .. } if *axis != Direction::Z => {
                Err("a tube in a ring mesh has its axis along `Z`".into())
            }
            Layout::Ring { .. } => ring_cells(layout, mesh, centre, (inner.0, outer.0), *extent),
        },
    }
}

/// The cells of a ring mesh between two of its rings of nodes, and between two heights.
fn ring_cells<'a, const D: usize>(
    layout: &Layout<D>,
    mesh: &Mesh<D>,
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    extent: Option<(Finite, Finite)>,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let Layout::Ring { radii, centre: mesh_centre, height, .. } = layout else {
        return Err("expected a ring mesh".into());
    };
    if plane_point(centre) != *mesh_centre {
        let [found, expected] = [plane_point(centre), *mesh_centre];
        return Err(format!("a ring in a ring mesh has the mesh's centre {expected:?}, got {found:?}"));
    }
    let ring = |radius: f64| {
        radii.line_at(radius).ok_or_else(|| format!("the mesh has no ring of nodes at radius {radius}"))
    };
    let (mut low, mut high) = ([0; D], layout.lattice().cells());
    (low[1], high[1]) = (ring(inner)?, ring(outer)?);
    if let Some((from, to)) = extent {
        let axis = height.as_ref().ok_or("`extent` is for three dimensions")?;
        let layer =
            |z: f64| axis.line_at(z).ok_or_else(|| format!("the mesh has no layer of nodes at height {z}"));
        (low[D - 1], high[D - 1]) = (layer(from.0)?, layer(to.0)?);
        if from.0 >= to.0 {
            return Err(format!("expected `extent` to ascend, got {} and {}", from.0, to.0));
        }
    }
    Ok((Shape::Cells { low, high }, mesh.clone()))
}

/// A ring of pieces about as large as the cells of a box mesh.
fn ring_of_its_own<'a, const D: usize>(
    axes: &[Axis; D],
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    memory: MemoryLimit,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let h = 0.5 * (mean_cell(&axes[0]) + mean_cell(&axes[1]));
    let pieces = |length: f64| match (length / h - 1e-9).ceil().max(1.0) {
        pieces if pieces < f64::from(u32::MAX) => Ok(pieces as u32),
        pieces => Err(format!("the ring would have {pieces:e} cells along one direction")),
    };
    let radii = Axis::uniform(inner, outer, pieces(outer - inner)?).map_err(|it| it.to_string())?;
    let sectors = pieces(std::f64::consts::PI * (inner + outer))?.max(8);
    check_ring(&radii, sectors, memory)?;
    let height = axes.get(2).cloned();
    let ring = Layout::ring(plane_point(centre), radii, sectors, Span::Full, height);
    let ring = ring.map_err(|it| it.to_string())?;
    let cells = ring.lattice().cells();
    Ok((Shape::Cells { low: [0; D], high: cells }, Mesh::at_rest(&ring)))
}

/// A cylinder or tube; in the plane of thickness 1.
fn round<const D: usize>(
    layout: &Layout<D>,
    axis: Direction,
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    extent: Option<(Finite, Finite)>,
) -> Result<Round, String> {
    let Layout::Box { axes, .. } = layout else {
        return Err(NEEDS_BOX.into());
    };
    let ends = match (D, extent) {
        (2, _) if axis != Direction::Z => return Err("a disc of the plane has its axis along `Z`".into()),
        (2, Some(_)) => return Err("`extent` is for three dimensions".into()),
        (2, None) => (0.0, 1.0),
        (_, Some((from, to))) if from.0 >= to.0 => {
            return Err(format!("expected `extent` to ascend, got {} and {}", from.0, to.0));
        }
        (_, Some((from, to))) => (from.0, to.0),
        (_, None) => (axes[axis.index()].first(), axes[axis.index()].last()),
    };
    Ok(Round { axis: axis.index(), centre: plane_point(centre), inner, outer, ends })
}

fn mean_cell(axis: &Axis) -> f64 {
    (axis.last() - axis.first()) / f64::from(axis.cells())
}
