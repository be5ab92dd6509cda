//! Shapes of bodies: what is to be filled, and by the cells of which mesh.

use super::mesh::plane_point;
use super::tiling;
use crate::files::SceneFiles;
use crate::language::{
    BodyInput, Direction, Finite, PlanePoint, ShapeInput, TilingInput, ToolInput, ToolPartInput,
};
use crate::pieces::Shape;
use mpm_geometry::{Ball, MemoryLimit, Prism, PrismError, Round, Solid, Surface};
use mpm_grid::{Layout, Mesh};

/// Why a shape has no place in a ring mesh.
const NEEDS_BOX: &str =
    "such a body can only be filled in a box mesh; a ring mesh takes `Ring`, `Tube` and `Points`";

/// A shape with the surface that it names, if it names one.
pub(super) struct WithSurface<'a, const D: usize> {
    pub shape: &'a ShapeInput<D>,
    pub surface: Option<Surface>,
    /// The polygon that it is, if it is one; a box that is cut out of another one is one, too.
    pub prism: Option<Prism>,
    /// Directions along which what is outside the mesh is left out.
    pub open: [bool; D],
}

impl<'a, const D: usize> WithSurface<'a, D> {
    pub(super) fn of(
        body: &'a BodyInput<D>,
        layout: &Layout<D>,
        files: &dyn SceneFiles,
    ) -> Result<Self, String> {
        let open = std::array::from_fn(|d| body.symmetry.iter().any(|it| it.index() == d));
        Self::placed(&body.shape, open, layout, files)
    }

    /// The shapes that are cut out of a body and are no bodies.
    pub(super) fn cutouts(
        body: &'a BodyInput<D>,
        layout: &Layout<D>,
        files: &dyn SceneFiles,
    ) -> Result<Vec<Self>, String> {
        let cutout = |(k, shape): (usize, &'a ShapeInput<D>)| {
            let wrong = |reason: String| format!("`cutouts[{k}]`: {reason}");
            let mut made = Self::placed(shape, [false; D], layout, files).map_err(wrong)?;
            if let ShapeInput::Box { from, to, without, cutouts, turned } = shape {
                if !without.is_empty() || !cutouts.is_empty() || turned.0 != 0.0 {
                    return Err(wrong("a box that is cut out is whole and not turned".into()));
                }
                made.prism = Some(box_as_prism(&from.0, &to.0).map_err(|it| wrong(it.to_string()))?);
            }
            Ok(made)
        };
        body.shape.cutouts().iter().enumerate().map(cutout).collect()
    }

    /// A shape with its surface.
    pub(super) fn placed(
        shape: &'a ShapeInput<D>,
        open: [bool; D],
        layout: &Layout<D>,
        files: &dyn SceneFiles,
    ) -> Result<Self, String> {
        let (mut surface, mut prism) = (None, None);
        match shape {
            ShapeInput::Surface { file, scale, shift } => {
                let &[x, y, z] = &shift.0[..] else {
                    return Err("a surface encloses a body in three dimensions only".into());
                };
                surface = Some(files.surface(file)?.placed(scale.0, &[x, y, z]));
            }
            ShapeInput::Polygon { vertices, holes, axis, extent } => {
                let corners = |of: &Vec<PlanePoint>| of.iter().map(plane_point).collect::<Vec<_>>();
                let holes: Vec<_> = holes.iter().map(corners).collect();
                let ends = ends_along(layout, *axis, *extent, "a polygon of the plane")?;
                let made = Prism::new(&corners(vertices), &holes, axis.index(), ends);
                prism = Some(made.map_err(|it| it.to_string())?);
            }
            ShapeInput::Box { from, to, turned, .. } if turned.0 != 0.0 => {
                let made = turned_box(&from.0, &to.0, turned.0.to_radians());
                prism = Some(made.map_err(|it| it.to_string())?);
            }
            _ => {}
        }
        Ok(Self { shape, surface, prism, open })
    }

    /// What it encloses in a box mesh.
    fn solid(&self, layout: &Layout<D>) -> Result<Solid<'_>, String> {
        if let Some(prism) = &self.prism {
            return Ok(Solid::Prism(prism));
        }
        match (self.shape, &self.surface) {
            (_, Some(surface)) => Ok(Solid::Surface(surface)),
            (ShapeInput::Cylinder { axis, centre, radius, extent }, _) => {
                round(layout, *axis, centre, (0.0, radius.0), *extent).map(Solid::Round)
            }
            (ShapeInput::Tube { axis, centre, inner, outer, extent, .. }, _) => {
                round(layout, *axis, centre, (inner.0, outer.0), *extent).map(Solid::Round)
            }
            (ShapeInput::Sphere { centre, radius }, _) => {
                let &[x, y, z] = &centre.0[..] else {
                    return Err("a sphere is a body in three dimensions only; a disc is a `Cylinder`".into());
                };
                Ok(Solid::Ball(Ball { centre: [x, y, z], radius: radius.0 }))
            }
            _ => {
                Err("what is cut out of a box: expected a `Cylinder`, `Tube`, `Sphere`, `Polygon` or `Surface`"
                    .into())
            }
        }
    }

    /// Whether it is filled by what a surface encloses, in a box mesh.
    pub(super) fn is_solid(&self) -> bool {
        matches!(
            self.shape,
            ShapeInput::Cylinder { .. }
                | ShapeInput::Tube { .. }
                | ShapeInput::Sphere { .. }
                | ShapeInput::Polygon { .. }
                | ShapeInput::Surface { .. }
        )
    }

    /// On which sides the mesh ends within the body, low and high in every direction.
    pub(super) fn cut(&self, layout: &Layout<D>) -> Result<[[bool; 2]; D], String> {
        let (Layout::Box { axes, .. }, true) = (layout, self.open.contains(&true)) else {
            return Ok([[false; 2]; D]);
        };
        if let ShapeInput::Ring { centre, .. } = self.shape {
            return tiling::cut(axes, plane_point(centre), self.open);
        }
        if !self.is_solid() {
            return Ok([[false; 2]; D]);
        }
        let solid = self.solid(layout)?;
        Ok(std::array::from_fn(|d| {
            let (from, to) = solid.ends(d);
            [self.open[d] && from < axes[d].first(), self.open[d] && to > axes[d].last()]
        }))
    }
}

/// The first part of a tool that can be cut out of a box exactly, as a shape of bodies.
pub(super) fn solid_part<const D: usize>(tool: &ToolInput<D>) -> Option<ShapeInput<D>> {
    tool.parts.iter().find_map(|part| match part {
        ToolPartInput::Cylinder { axis, centre, radius, extent } => {
            let (axis, centre, radius) = (*axis, *centre, *radius);
            Some(ShapeInput::Cylinder { axis, centre, radius, extent: Some(*extent) })
        }
        ToolPartInput::Disc { centre, radius } => Some(match &centre.0[..] {
            &[x, y] => {
                let centre = PlanePoint((Finite(x), Finite(y)));
                ShapeInput::Cylinder { axis: Direction::Z, centre, radius: *radius, extent: None }
            }
            _ => ShapeInput::Sphere { centre: *centre, radius: *radius },
        }),
        ToolPartInput::Surface { file, scale, shift } => {
            Some(ShapeInput::Surface { file: file.clone(), scale: *scale, shift: *shift })
        }
        _ => None,
    })
}

/// The shapes that are cut out of a body: those of bodies before it, those of tools, and those that are neither.
pub(super) fn cut_out<'a, const D: usize>(
    body: &BodyInput<D>,
    (before, shapes): (&[BodyInput<D>], &'a [WithSurface<'a, D>]),
    tools: &'a [(&str, Option<WithSurface<'a, D>>)],
    cutouts: &'a [WithSurface<'a, D>],
) -> Result<Vec<&'a WithSurface<'a, D>>, String> {
    let mut cut: Vec<&WithSurface<'_, D>> = cutouts.iter().collect();
    for name in body.shape.without() {
        let of_tool = tools.iter().find(|tool| tool.0 == *name);
        let is_box = matches!(body.shape, ShapeInput::Box { .. });
        let other = before.iter().zip(shapes).find(|other| other.0.name == *name).filter(|_| is_box);
        match (other, of_tool) {
            (Some((other, _)), _) if other.points_per_cell != body.points_per_cell => {
                return Err(format!("`without`: body `{name}` has another number of points per cell"));
            }
            (Some((other, _)), _) if other.turned.is_some() => {
                return Err(format!(
                    "`without`: body `{name}` is `turned`, expected one that stands as its shape says"
                ));
            }
            (Some((_, shape)), _) => cut.push(shape),
            (None, Some((_, shape))) => cut.extend(shape.iter().filter(|_| is_box)),
            (None, None) if is_box => {
                return Err(format!(
                    "`without`: no body named `{name}` stands before this one, and no tool has this name"
                ));
            }
            (None, None) => return Err(format!("`without`: no tool is named `{name}`")),
        }
    }
    Ok(cut)
}

/// What is to be filled, and the mesh whose cells it is filled by.
pub(super) fn shape<'a, const D: usize>(
    own: &'a WithSurface<'a, D>,
    cut: &[&'a WithSurface<'a, D>],
    (layout, mesh): (&Layout<D>, &Mesh<D>),
    tiling: TilingInput,
    (files, memory): (&dyn SceneFiles, MemoryLimit),
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let in_a_box = matches!(layout, Layout::Box { .. });
    let is_tiled = tiling == TilingInput::Shape;
    if is_tiled && !(in_a_box && tiling::suits(own.shape)) {
        return Err(tiling::SUITED.into());
    }
    let is_whole = own.shape.without().is_empty() && own.shape.cutouts().is_empty();
    if is_tiled && !is_whole {
        return Err("`tiling: Shape` is for whole shapes, expected no `without` and no `cutouts`".into());
    }
    let in_box = |shape| match layout {
        Layout::Box { .. } => Ok((shape, mesh.clone())),
        Layout::Ring { .. } => Err(NEEDS_BOX.into()),
    };
    let solid = || Ok::<_, String>(Shape::Solid { solid: own.solid(layout)?, open: own.open });
    let can_be_cut = match is_tiled {
        true => matches!(own.shape, ShapeInput::Ring { .. }),
        false => own.is_solid() && in_a_box,
    };
    if own.open.contains(&true) && !can_be_cut {
        return Err("`symmetry` is for a `Cylinder`, `Tube`, `Sphere`, `Polygon` or `Surface` in a box mesh, and for a \
                    `Ring` with `tiling: Shape`"
            .into());
    }
    match own.shape {
        ShapeInput::Box { turned, .. } if turned.0 != 0.0 && !is_tiled => {
            Err("a box that is `turned` does not follow the cells: expected `tiling: Shape`".into())
        }
        ShapeInput::Box { from, to, turned, .. } if is_tiled => {
            tiling::boxed(layout, (&from.0, &to.0), turned.0.to_radians())
        }
        ShapeInput::Polygon { vertices, .. } if is_tiled => tiling::quadrilateral(layout, vertices),
        ShapeInput::Cylinder { axis, centre, radius, extent } if is_tiled => {
            let ends = ends_along(layout, *axis, *extent, "a disc of the plane")?;
            Ok((tiling::disc(layout, (plane_point(centre), radius.0), ends)?, mesh.clone()))
        }
        ShapeInput::Box { from, to, .. } if cut.is_empty() => in_box(Shape::Box { from: from.0, to: to.0 }),
        ShapeInput::Box { from, to, .. } => {
            let without = cut.iter().map(|it| it.solid(layout)).collect::<Result<_, _>>()?;
            in_box(Shape::Rest { from: from.0, to: to.0, without })
        }
        ShapeInput::Points { file } => Ok((Shape::Parts(files.points(file, D)?.parts(mesh)?), mesh.clone())),
        ShapeInput::Cylinder { .. }
        | ShapeInput::Sphere { .. }
        | ShapeInput::Polygon { .. }
        | ShapeInput::Surface { .. } => in_box(solid()?),
        ShapeInput::Ring { inner, outer, .. } if inner.0 <= 0.0 || inner.0 >= outer.0 => {
            Err(format!("expected radii 0 < inner < outer, got {} and {}", inner.0, outer.0))
        }
        ShapeInput::Tube { inner, outer, .. } if inner.0 >= outer.0 => {
            Err(format!("expected radii 0 < inner < outer, got {} and {}", inner.0, outer.0))
        }
        ShapeInput::Ring { inner, outer, centre, .. } => match layout {
            Layout::Ring { .. } => ring_cells(layout, mesh, centre, (inner.0, outer.0), None),
            Layout::Box { axes, .. } => {
                tiling::ring((axes, is_tiled), centre, ((inner.0, outer.0), None), own.open, memory)
            }
        },
        ShapeInput::Tube { axis, centre, inner, outer, extent, .. } => match layout {
            Layout::Box { axes, .. } if is_tiled => {
                let ends = extent.is_some().then(|| ends_along(layout, *axis, *extent, "a disc of the plane"));
                let of_tube = ((inner.0, outer.0), ends.transpose()?);
                tiling::ring((axes, true), centre, of_tube, own.open, memory)
            }
            Layout::Box { .. } => in_box(solid()?),
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
    let Layout::Ring { radii, centre: mesh_centre, height, sectors, span, .. } = layout else {
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
    let angle = span.step(*sectors) * f64::from(*sectors);
    let ends = height
        .as_ref()
        .map_or((0.0, 1.0), |axis| extent.map_or((axis.first(), axis.last()), |(from, to)| (from.0, to.0)));
    let volume = tiling::ring_volume((inner, outer), angle, ends);
    Ok((Shape::Cells { low, high, volume, is_exact: false }, mesh.clone()))
}

/// A cylinder or tube; in the plane of thickness 1.
fn round<const D: usize>(
    layout: &Layout<D>,
    axis: Direction,
    centre: &PlanePoint,
    (inner, outer): (f64, f64),
    extent: Option<(Finite, Finite)>,
) -> Result<Round, String> {
    let ends = ends_along(layout, axis, extent, "a disc of the plane")?;
    Ok(Round { axis: axis.index(), centre: plane_point(centre), inner, outer, ends })
}

/// Ends of what is drawn out along an axis; in the plane of thickness 1.
fn ends_along<const D: usize>(
    layout: &Layout<D>,
    axis: Direction,
    extent: Option<(Finite, Finite)>,
    flat: &str,
) -> Result<(f64, f64), String> {
    let Layout::Box { axes, .. } = layout else {
        return Err(NEEDS_BOX.into());
    };
    match (D, extent) {
        (2, _) if axis != Direction::Z => Err(format!("{flat} has its axis along `Z`")),
        (2, Some(_)) => Err("`extent` is for three dimensions".into()),
        (2, None) => Ok((0.0, 1.0)),
        (_, Some((from, to))) if from.0 >= to.0 => {
            Err(format!("expected `extent` to ascend, got {} and {}", from.0, to.0))
        }
        (_, Some((from, to))) => Ok((from.0, to.0)),
        (_, None) => Ok((axes[axis.index()].first(), axes[axis.index()].last())),
    }
}

/// A box as a polygon drawn out along z; in the plane of thickness 1.
fn box_as_prism<const D: usize>(from: &[f64; D], to: &[f64; D]) -> Result<Prism, PrismError> {
    turned_box(from, to, 0.0)
}

/// The same of a box that is turned by an angle `[rad]` about its corner `from`.
fn turned_box<const D: usize>(from: &[f64; D], to: &[f64; D], angle: f64) -> Result<Prism, PrismError> {
    let corners = [[from[0], from[1]], [to[0], from[1]], [to[0], to[1]], [from[0], to[1]]];
    let corners = corners.map(|corner| tiling::turned(corner, [from[0], from[1]], angle));
    let ends = if D == 2 { (0.0, 1.0) } else { (from[D - 1], to[D - 1]) };
    Prism::new(&corners, &[], 2, ends)
}
