//! Shapes cut into pieces along themselves, about as large as the cells of a box mesh.

use super::mesh::{check_ring, plane_point};
use crate::disc::{Disc, SQUARE};
use crate::language::{Direction, PlanePoint, ShapeInput};
use crate::pieces::Shape;
use mpm_geometry::MemoryLimit;
use mpm_grid::{Axis, Layout, LoadFraction, Mesh, MeshMotion, Ramp, Span};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What shapes can be cut along themselves.
pub(super) const SUITED: &str = "`tiling: Shape` is for a `Ring`, a `Box`, a `Polygon` of four corners, or a `Cylinder` or `Tube` along `Z` in a box mesh";

/// Part of a mesh's length within which a ring's centre is at an end of it.
const AT_END: f64 = 1e-9;

/// Volume of a ring or of a sector of one, per thickness in the plane `[L^D]`.
pub(super) fn ring_volume((inner, outer): (f64, f64), angle: f64, (from, to): (f64, f64)) -> f64 {
    0.5 * angle * (outer - inner) * (outer + inner) * (to - from)
}

/// Whether a shape can be cut along itself.
pub(super) fn suits<const D: usize>(shape: &ShapeInput<D>) -> bool {
    match shape {
        ShapeInput::Ring { .. } | ShapeInput::Box { .. } => true,
        ShapeInput::Cylinder { axis, .. } | ShapeInput::Tube { axis, .. } => *axis == Direction::Z,
        ShapeInput::Polygon { vertices, holes, .. } => D == 2 && vertices.len() == 4 && holes.is_empty(),
        _ => false,
    }
}

/// A point of the plane turned by an angle `[rad]` about another.
pub(super) fn turned([x, y]: [f64; 2], [cx, cy]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    let (dx, dy) = (x - cx, y - cy);
    [cx + cosine * dx - sine * dy, cy + sine * dx + cosine * dy]
}

/// A ring of pieces: cut from polygons with the ring's volume in all, or, where it is tiled, with their corners on circles and
/// the volumes of their own polygons; then only what is on the mesh's side of its `open` ends through the centre. In space it
/// is as high as the mesh, if no ends are given.
pub(super) fn ring<'a, const D: usize>(
    (axes, is_tiled): (&[Axis; D], bool),
    centre: &PlanePoint,
    ((inner, outer), ends): ((f64, f64), Option<(f64, f64)>),
    open: [bool; D],
    memory: MemoryLimit,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let h = cell(axes);
    let radii = Axis::uniform(inner, outer, pieces("ring", outer - inner, h)?).map_err(|it| it.to_string())?;
    let mut sectors = pieces("ring", PI * (inner + outer), h)?.max(8);
    let quarters = quarters(axes, plane_point(centre), open)?;
    if quarters != [0, 4] {
        sectors = sectors.div_ceil(4).saturating_mul(4);
    }
    check_ring(&radii, sectors, memory)?;
    let height = match (axes.get(2), ends) {
        (Some(axis), Some((from, to))) => {
            let layers = pieces("tube", to - from, mean_cell(axis))?;
            Some(Axis::uniform(from, to, layers).map_err(|it| it.to_string())?)
        }
        (axis, _) => axis.cloned(),
    };
    let ends = height.as_ref().map_or((0.0, 1.0), |axis| (axis.first(), axis.last()));
    let ring = Layout::ring(plane_point(centre), radii, sectors, Span::Full, height);
    // The cells of a ring with splines lie between circles.
    let ring = ring.and_then(|it| if is_tiled { it.with_splines(2) } else { Ok(it) });
    let ring = ring.map_err(|it| it.to_string())?;
    let (mut low, mut high) = ([0; D], ring.lattice().cells());
    if quarters != [0, 4] {
        [low[0], high[0]] = quarters.map(|quarter| quarter * (sectors / 4));
    }
    let angle = TAU * f64::from(quarters[1] - quarters[0]) / 4.0;
    let volume = ring_volume((inner, outer), angle, ends);
    Ok((Shape::Cells { low, high, volume, is_exact: !is_tiled }, Mesh::at_rest(&ring)))
}

/// At which ends the mesh cuts a ring with this centre in half, low and high in every direction.
pub(super) fn cut<const D: usize>(
    axes: &[Axis; D],
    centre: [f64; 2],
    open: [bool; D],
) -> Result<[[bool; 2]; D], String> {
    let mut cut = [[false; 2]; D];
    for d in (0..D).filter(|&d| open[d]) {
        let (first, last) = (axes[d].first(), axes[d].last());
        let is_at = |end: f64| d < 2 && (end - centre[d]).abs() <= AT_END * (last - first);
        cut[d] = [is_at(first), is_at(last)];
        if cut[d] == [false; 2] {
            return Err(
                "a `Ring` with `symmetry` has its centre at an end of the mesh in that direction".into()
            );
        }
    }
    Ok(cut)
}

/// The first quarter of a ring, anticlockwise from the x axis, and the one after the last that lies in the mesh.
fn quarters<const D: usize>(axes: &[Axis; D], centre: [f64; 2], open: [bool; D]) -> Result<[u32; 2], String> {
    let cut = cut(axes, centre, open)?;
    Ok(match (cut[0], cut[1]) {
        ([false, false], [false, false]) => [0, 4],
        ([true, _], [false, false]) => [3, 5],
        ([false, true], [false, false]) => [1, 3],
        ([false, false], [true, _]) => [0, 2],
        ([false, false], [false, true]) => [2, 4],
        ([true, _], [true, _]) => [0, 1],
        ([false, true], [true, _]) => [1, 2],
        ([false, true], [false, true]) => [2, 3],
        ([true, _], [false, true]) => [3, 4],
    })
}

/// A box along its edges, turned by an angle `[rad]` about its corner `from`, in space about the line along z through that.
pub(super) fn boxed<'a, const D: usize>(
    layout: &Layout<D>,
    (from, to): (&[f64; D], &[f64; D]),
    angle: f64,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    if let Some(d) = (0..D).find(|&d| from[d] >= to[d]) {
        return Err(format!("the box is empty along direction {}: from {} to {}", d + 1, from[d], to[d]));
    }
    let corner = |c: usize| {
        let rest: [f64; D] = std::array::from_fn(|d| if c >> d & 1 == 1 { to[d] } else { from[d] });
        let [x, y] = turned([rest[0], rest[1]], [from[0], from[1]], angle);
        std::array::from_fn(|d| [x, y].get(d).copied().unwrap_or(rest[d]))
    };
    let lengths = std::array::from_fn(|d| to[d] - from[d]);
    tiles(layout, (0..1 << D).map(corner).collect(), lengths, lengths.iter().product())
}

/// A convex polygon of four corners between points that part opposite edges equally.
pub(super) fn quadrilateral<'a, const D: usize>(
    layout: &Layout<D>,
    vertices: &[PlanePoint],
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let (corners, _) = anticlockwise(vertices);
    let at = |k: usize| corners[k % 4];
    let length = |k: usize| (at(k + 1)[0] - at(k)[0]).hypot(at(k + 1)[1] - at(k)[1]);
    let turn = |k: usize| {
        let [a, b, c] = [at(k), at(k + 1), at(k + 2)];
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    };
    if (0..4).any(|k| turn(k) <= 0.0) {
        return Err("a polygon with `tiling: Shape` is convex".into());
    }
    let across = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let volume = 0.5 * (0..4).map(|k| across(at(k), at(k + 1))).sum::<f64>();
    let lengths = std::array::from_fn(|d| length(d).max(length(d + 2)));
    let lexicographic = [0, 1, 3, 2].map(|k| std::array::from_fn(|d| at(k)[d]));
    tiles(layout, lexicographic.to_vec(), lengths, volume)
}

/// A disc, in space a cylinder along z, in tiles of about the size of the mesh's cells.
pub(super) fn disc<'a, const D: usize>(
    layout: &Layout<D>,
    (centre, radius): ([f64; 2], f64),
    ends: (f64, f64),
) -> Result<Shape<'a, D>, String> {
    let Layout::Box { axes, .. } = layout else { return Err(SUITED.into()) };
    let height = axes.get(2).map_or(1.0, mean_cell);
    let along = |length: f64, size: f64| pieces("disc", length, size);
    // The square's edge and a quarter of the circle have as many.
    let around = along(0.5 * (2.0 * SQUARE + FRAC_PI_2) * radius, cell(axes))?;
    let outwards = along((1.0 - SQUARE) * radius, cell(axes))?;
    let tiles = [around, outwards, along(ends.1 - ends.0, height)?];
    Ok(Shape::Disc(Disc { centre, radius, tiles, ends }))
}

/// The corners of a polygon in the plane anticlockwise from its first one, and whether they were given so.
pub(super) fn anticlockwise(vertices: &[PlanePoint]) -> (Vec<[f64; 2]>, bool) {
    let mut corners: Vec<[f64; 2]> = vertices.iter().map(plane_point).collect();
    let next = corners.iter().cycle().skip(1);
    let area: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    let is_anticlockwise = area > 0.0;
    if !is_anticlockwise {
        corners[1..].reverse();
    }
    (corners, is_anticlockwise)
}

/// The multilinear image of a box with these corners, lexicographic, in cells of about the size of the mesh's, where its
/// edges are about `lengths` long `[L]`.
fn tiles<'a, const D: usize>(
    layout: &Layout<D>,
    corners: Vec<[f64; D]>,
    lengths: [f64; D],
    volume: f64,
) -> Result<(Shape<'a, D>, Mesh<D>), String> {
    let Layout::Box { axes, .. } = layout else { return Err(SUITED.into()) };
    let told = |it: &dyn std::fmt::Display| it.to_string();
    let mut own: Vec<Axis> = Vec::with_capacity(D);
    for d in 0..D {
        let h = if d < 2 { cell(axes) } else { mean_cell(&axes[d]) };
        let along = Axis::uniform(0.0, lengths[d], pieces("shape", lengths[d], h)?);
        own.push(along.map_err(|it| told(&it))?);
    }
    let own: [Axis; D] = own.try_into().map_err(|_| SUITED)?;
    let rest = |c: usize, d: usize| if c >> d & 1 == 1 { lengths[d] } else { 0.0 };
    let moved = corners
        .iter()
        .enumerate()
        .map(|(c, corner)| -> [Ramp; D] { std::array::from_fn(|d| Ramp::linear(corner[d] - rest(c, d))) });
    let image = MeshMotion::corners(moved.collect()).map_err(|it| told(&it))?;
    let own = Layout::on_axes(own).map_err(|it| told(&it))?;
    let mesh = image.mesh_at(&own, LoadFraction::END).map_err(|it| told(&it))?;
    Ok((Shape::Cells { low: [0; D], high: own.lattice().cells(), volume, is_exact: false }, mesh))
}

/// Number of pieces of about a size `h` `[L]` along a length of something.
fn pieces(what: &str, length: f64, h: f64) -> Result<u32, String> {
    match (length / h - 1e-9).ceil().max(1.0) {
        pieces if pieces < f64::from(u32::MAX) => Ok(pieces as u32),
        pieces => Err(format!("the {what} would have {pieces:e} cells along one direction")),
    }
}

/// Mean length of the cells in the plane of the first two directions `[L]`.
pub(super) fn cell<const D: usize>(axes: &[Axis; D]) -> f64 {
    0.5 * (mean_cell(&axes[0]) + mean_cell(&axes[1]))
}

fn mean_cell(axis: &Axis) -> f64 {
    (axis.last() - axis.first()) / f64::from(axis.cells())
}
