//! Filling a shape with material points.

use mpm_assembly::{Body, MaterialBody, MeanDilatation};
use mpm_basis::{Basis, Piece, Seed};
use mpm_geometry::{Face, MemoryLimit, Part, Parts, Solid, parts, rest};
use mpm_grid::{Axis, Block, Mesh, Vector};
use mpm_material::{Material, SymmetricTensor};
use std::ops::Range;

/// Points of one body at most; their numbers have 32 bits.
const MOST_POINTS: f64 = 4e9;

/// What a body is to be filled with.
pub(crate) struct Plan<'a, const D: usize> {
    /// The mesh of the first load step.
    pub start: &'a Mesh<D>,
    pub shape: Shape<'a, D>,
    /// The mesh whose cells the shape is filled by: the background mesh, or the shape's own.
    pub shape_mesh: &'a Mesh<D>,
    /// Material points per cell and direction; of no use for points that are given.
    pub points_per_cell: u32,
    /// Given where a body force acts `[M/L^D]`.
    pub density: Option<f64>,
    /// Whether positions at rest must be kept.
    pub keep_reference_positions: bool,
    /// Parts of the boundary that carry tractions.
    pub faces: Vec<Face<D>>,
    /// Memory that there is.
    pub memory: MemoryLimit,
    /// What the volume change of a cell is, where points take it.
    pub mean_dilatation: Option<MeanDilatation>,
}

/// What is filled.
pub(crate) enum Shape<'a, const D: usize> {
    /// A box in a rectilinear mesh, by its corners `[L]`.
    Box { from: [f64; D], to: [f64; D] },
    /// Whole cells, from the multi-index `low` up to but without `high`.
    Cells { low: [u32; D], high: [u32; D] },
    /// What a surface encloses, in a rectilinear mesh.
    Solid(Solid<'a>),
    /// A box with its ends on mesh lines, without what others enclose.
    Rest { from: [f64; D], to: [f64; D], without: Vec<Solid<'a>> },
    /// Parts that are given.
    Parts(Parts<D>),
}

/// A body, and for every face of the plan the points next to it with their areas of it.
pub(crate) struct Filled<const D: usize> {
    pub body: Box<dyn Body<D>>,
    pub faces: Vec<Vec<(usize, f64)>>,
    /// The shape's own volume, where the points' may differ from it `[L^D]`.
    pub shape_volume: Option<f64>,
}

/// Fills a box with points of one basis and law.
///
/// # Errors
/// A sentence that says what is wrong with the box or the number of points.
pub(crate) fn fill<const D: usize, B, M>(basis: B, law: M, plan: &Plan<'_, D>) -> Result<Filled<D>, String>
where
    B: Basis<D> + 'static,
    M: Material + 'static,
{
    let Seeded { seeds, faces, shape_volume } = seeds(&basis, plan, bytes_of_point::<D, B, M>())?;
    let mut body = MaterialBody::new(basis, law, seeds).with_mean_dilatation(plan.mean_dilatation);
    if let Some(density) = plan.density {
        body = body.with_density(density);
    }
    if plan.keep_reference_positions {
        body = body.with_reference_positions();
    }
    Ok(Filled { body: Box::new(body), faces, shape_volume })
}

/// A point of a basis at rest.
type SeedOf<const D: usize, B> = Seed<D, <B as Basis<D>>::Domain>;

/// The points of a body at rest; the rest as in [`Filled`].
struct Seeded<S> {
    seeds: Vec<S>,
    faces: Vec<Vec<(usize, f64)>>,
    shape_volume: Option<f64>,
}

/// Places the points that fill a shape; each takes up at least `bytes_per_point`.
fn seeds<const D: usize, B: Basis<D>>(
    basis: &B,
    plan: &Plan<'_, D>,
    bytes_per_point: usize,
) -> Result<Seeded<SeedOf<D, B>>, String> {
    basis.suits(plan.start)?;
    let mut seeds = Vec::new();
    let mut faces = vec![Vec::new(); plan.faces.len()];
    let made = made_parts(basis, plan)?;
    let pieces = match &made {
        Some(parts) => parts.parts.len() as f64,
        None => count_pieces(plan.shape_mesh, &plan.shape, basis.pieces_per_cell(plan.points_per_cell)?)?,
    };
    let mut points_per_piece = 0.0;
    basis.seed(&box_piece(&Vector::zeros(), &Vector::repeat(1.0)), &mut |_| points_per_piece += 1.0);
    let count = pieces * points_per_piece;
    if count > MOST_POINTS {
        return Err(format!(
            "{count:e} material points are more than the {MOST_POINTS:e} that a body can have"
        ));
    }
    plan.memory.check(format_args!("{count:e} material points"), count, bytes_per_point)?;
    let mut flat = None;
    if let Some(parts) = &made {
        let is_solid = |part: &&Part<D>| {
            let sides = part.half_vectors.column_iter().map(|side| side.norm());
            let volumes = [part.volume, parallelepiped(part).volume()];
            sides.chain(volumes).all(|it| it > 0.0 && it.is_finite())
        };
        flat = parts.parts.iter().find(|part| !is_solid(part)).map(|part| part.centre);
    }
    if let Some(parts) = made.as_ref().filter(|_| flat.is_none()) {
        seed_parts(basis, parts, &mut seeds, &mut faces);
    } else if made.is_none() {
        let pieces_per_cell = basis.pieces_per_cell(plan.points_per_cell)?;
        for_each_piece(plan.shape_mesh, &plan.shape, pieces_per_cell, |piece| {
            // Ends can be so close together, or so far apart, that their numbers do not tell how far.
            if !(piece.volume() > 0.0 && piece.volume().is_finite()) {
                flat = Some(piece.corners()[0]);
            }
            if flat.is_some() {
                return;
            }
            let first = seeds.len();
            basis.seed(piece, &mut |seed| seeds.push(seed));
            for (face, shares) in plan.faces.iter().zip(&mut faces) {
                if let Some((area, centre)) = area_on(face, piece) {
                    shares.extend(nearest(&seeds, first..seeds.len(), &centre).map(|point| (point, area)));
                }
            }
        })?;
    }
    if let Some(corner) = flat {
        let at = corner.as_slice();
        return Err(format!(
            "the part of a cell at {at:?} that a point stands for has no volume that can be computed"
        ));
    }
    for shares in &mut faces {
        shares.sort_by_key(|&(point, _)| point);
    }
    Ok(Seeded { seeds, faces, shape_volume: made.and_then(|parts| parts.volume) })
}

/// The parts of shapes that are not filled piece by piece.
fn made_parts<const D: usize, B: Basis<D>>(basis: &B, plan: &Plan<'_, D>) -> Result<Option<Parts<D>>, String> {
    let axes = || plan.shape_mesh.rectilinear().ok_or("a body of parts can only be filled in a box mesh");
    match &plan.shape {
        Shape::Box { .. } | Shape::Cells { .. } => Ok(None),
        Shape::Solid(solid) => {
            parts(solid, axes()?, basis.pieces_per_cell(plan.points_per_cell)?, &plan.faces, plan.memory)
                .map(Some)
        }
        Shape::Rest { from, to, without } => {
            if !plan.faces.is_empty() {
                return Err("a box without other bodies can carry no traction".into());
            }
            rest((from, to), without, axes()?, basis.pieces_per_cell(plan.points_per_cell)?, plan.memory)
                .map(Some)
        }
        Shape::Parts(parts) => Ok(Some(parts.clone())),
    }
}

/// The one of some points that is nearest to a position.
fn nearest<const D: usize, Domain>(
    seeds: &[Seed<D, Domain>],
    of: Range<usize>,
    x: &Vector<D>,
) -> Option<usize> {
    let distance = |p: usize| (seeds[p].position - x).norm_squared();
    of.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}

/// Points of given parts, and those that carry faces.
fn seed_parts<const D: usize, B: Basis<D>>(
    basis: &B,
    parts: &Parts<D>,
    seeds: &mut Vec<SeedOf<D, B>>,
    faces: &mut [Vec<(usize, f64)>],
) {
    // Number of the first point of every part.
    let mut starts = Vec::with_capacity(parts.parts.len() + 1);
    for part in &parts.parts {
        let first = seeds.len();
        starts.push(first);
        basis.seed(&parallelepiped(part), &mut |seed| seeds.push(seed));
        // A part may hold more or less than its domain.
        let seeded: f64 = seeds[first..].iter().map(|seed| seed.volume).sum();
        seeds[first..].iter_mut().for_each(|seed| seed.volume *= part.volume / seeded);
    }
    starts.push(seeds.len());
    for (shares, face) in faces.iter_mut().zip(&parts.faces) {
        for share in face {
            let point = nearest(seeds, starts[share.part]..starts[share.part + 1], &share.centre);
            shares.extend(point.map(|point| (point, share.area)));
        }
    }
}

fn parallelepiped<const D: usize>(part: &Part<D>) -> Piece<D> {
    Piece::new(std::array::from_fn(|corner| {
        let signs = Vector::from_fn(|d, _| if corner >> d & 1 == 1 { 1.0 } else { -1.0 });
        part.centre + part.half_vectors * signs
    }))
}

/// Bytes that a point takes at least: its state, the next one, and its influence on the nodes of a cell.
fn bytes_of_point<const D: usize, B: Basis<D>, M: Material>() -> usize {
    let state = size_of::<Vector<D>>()
        + size_of::<f64>()
        + size_of::<B::Domain>()
        + size_of::<Block<D>>()
        + size_of::<SymmetricTensor>()
        + size_of::<M::History>();
    2 * state + (size_of::<Vector<D>>() + size_of::<f64>()) * (1 << D)
}

/// Number of pieces that [`for_each_piece`] makes of a shape.
fn count_pieces<const D: usize>(mesh: &Mesh<D>, shape: &Shape<'_, D>, per_cell: u32) -> Result<f64, String> {
    match shape {
        Shape::Box { from, to } => {
            let axes = mesh.rectilinear().ok_or("a box can only be filled in a box mesh")?;
            (0..D).try_fold(1.0, |count, d| Ok(count * Cut::of(&axes[d], from[d], to[d], per_cell)?.pieces()))
        }
        Shape::Cells { low, high } => {
            Ok((0..D).map(|d| f64::from(high[d] - low[d]) * f64::from(per_cell)).product())
        }
        Shape::Solid(_) | Shape::Rest { .. } | Shape::Parts(_) => Ok(0.0),
    }
}

/// Cuts a shape into pieces, cell by cell and piece by piece inside a cell: points that share nodes
/// stay together.
fn for_each_piece<const D: usize>(
    mesh: &Mesh<D>,
    shape: &Shape<'_, D>,
    pieces_per_cell: u32,
    mut each: impl FnMut(&Piece<D>),
) -> Result<(), String> {
    match shape {
        Shape::Box { from, to } => {
            let axes = mesh.rectilinear().ok_or("a box can only be filled in a box mesh")?;
            let mut rows: Vec<Vec<CellRow>> = Vec::with_capacity(D);
            for d in 0..D {
                let cut = Cut::of(&axes[d], from[d], to[d], pieces_per_cell)?;
                rows.push(by_cell(&axes[d], &cut.lines(&axes[d])));
            }
            for_each(std::array::from_fn(|d| rows[d].len()), |cell: [usize; D]| {
                let row: [&CellRow; D] = std::array::from_fn(|d| &rows[d][cell[d]]);
                for_each(row.map(|row| row.len() - 1), |piece: [usize; D]| {
                    let low = Vector::from_fn(|d, _| row[d][piece[d]]);
                    let high = Vector::from_fn(|d, _| row[d][piece[d] + 1]);
                    each(&box_piece(&low, &high));
                });
            });
        }
        Shape::Cells { low, high } => {
            let extent: [usize; D] = std::array::from_fn(|d| (high[d] - low[d]) as usize);
            let local = |k: usize| 2.0 * k as f64 / f64::from(pieces_per_cell) - 1.0;
            for_each(extent, |offset: [usize; D]| {
                let cell = std::array::from_fn(|d| low[d] + offset[d] as u32);
                for_each([pieces_per_cell as usize; D], |piece: [usize; D]| {
                    let from = Vector::from_fn(|d, _| local(piece[d]));
                    let to = Vector::from_fn(|d, _| local(piece[d] + 1));
                    each(&mesh.piece(cell, &from, &to));
                });
            });
        }
        Shape::Solid(_) | Shape::Rest { .. } | Shape::Parts(_) => {}
    }
    Ok(())
}

/// Coordinates of the pieces of one cell along one direction, ends included.
type CellRow = Vec<f64>;

/// How a length is cut into pieces.
///
/// Where both ends lie on mesh lines every cell is cut into `n`; else the length is cut evenly into
/// pieces no longer than the mean of its cells over `n`.
enum Cut {
    /// The cells from `first` up to but without `last`, each into `n`.
    Cells { first: u32, last: u32, n: u32 },
    /// All of it into `count`.
    Evenly { from: f64, to: f64, count: u32 },
}

impl Cut {
    /// Of `from..to` along an axis.
    fn of(axis: &Axis, from: f64, to: f64, n: u32) -> Result<Self, String> {
        let empty = || Err(format!("the box is empty: from {from} to {to}"));
        if from >= to {
            return empty();
        }
        let span = axis.last() - axis.first();
        if from < axis.first() - 1e-9 * span || to > axis.last() + 1e-9 * span {
            return Err(format!(
                "the box reaches from {from} to {to}, outside the mesh from {} to {}",
                axis.first(),
                axis.last()
            ));
        }
        if let (Some(first), Some(last)) = (axis.line_at(from), axis.line_at(to)) {
            // Ends that differ by less than lines of the mesh are told apart by.
            if first == last {
                return empty();
            }
            return Ok(Self::Cells { first, last, n });
        }
        let (first, last) = (axis.locate(from).0, axis.locate(to).0);
        let mean_cell = (axis.node(last + 1) - axis.node(first)) / f64::from(last + 1 - first);
        let count = ((to - from) / mean_cell * f64::from(n) - 1e-9).ceil().max(1.0);
        if count > MOST_POINTS {
            return Err(format!("{count:e} material points along one direction are too many"));
        }
        Ok(Self::Evenly { from, to, count: count as u32 })
    }

    /// Number of pieces.
    fn pieces(&self) -> f64 {
        match *self {
            Self::Cells { first, last, n } => f64::from(last - first) * f64::from(n),
            Self::Evenly { count, .. } => f64::from(count),
        }
    }

    /// Coordinates of the ends of all pieces `[L]`.
    fn lines(&self, axis: &Axis) -> Vec<f64> {
        match *self {
            Self::Cells { first, last, n } => {
                let mut lines = vec![axis.node(first)];
                for cell in first..last {
                    let (low, high) = (axis.node(cell), axis.node(cell + 1));
                    for k in 1..n {
                        lines.push(low + (high - low) * f64::from(k) / f64::from(n));
                    }
                    lines.push(high);
                }
                lines
            }
            Self::Evenly { from, to, count } => {
                (0..=count).map(|k| from + (to - from) * f64::from(k) / f64::from(count)).collect()
            }
        }
    }
}

/// Gathers consecutive pieces whose centres lie in the same cell.
fn by_cell(axis: &Axis, lines: &[f64]) -> Vec<CellRow> {
    let mut rows: Vec<CellRow> = Vec::new();
    let mut cell_before = None;
    for ends in lines.windows(2) {
        let (cell, _) = axis.locate(0.5 * (ends[0] + ends[1]));
        match rows.last_mut() {
            Some(row) if cell_before == Some(cell) => row.push(ends[1]),
            _ => rows.push(ends.to_vec()),
        }
        cell_before = Some(cell);
    }
    rows
}

/// Calls `each` for every multi-index below `extent`, the first direction fastest.
fn for_each<const D: usize>(extent: [usize; D], mut each: impl FnMut([usize; D])) {
    if extent.contains(&0) {
        return;
    }
    let mut index = [0; D];
    loop {
        each(index);
        let Some(d) = (0..D).find(|&d| index[d] + 1 < extent[d]) else { return };
        index[d] += 1;
        index[..d].fill(0);
    }
}

fn box_piece<const D: usize>(low: &Vector<D>, high: &Vector<D>) -> Piece<D> {
    Piece::new(std::array::from_fn(|corner| {
        Vector::from_fn(|d, _| if corner >> d & 1 == 1 { high[d] } else { low[d] })
    }))
}

/// Area and centre of the side of a piece that lies on a face, if one does.
fn area_on<const D: usize>(face: &Face<D>, piece: &Piece<D>) -> Option<(f64, Vector<D>)> {
    let corners = &piece.corners()[..1 << D];
    let size = (corners[0] - corners[corners.len() - 1]).norm();
    for (direction, bit) in (0..D).flat_map(|d| [(d, 0), (d, 1)]) {
        let mut side = corners.iter().enumerate().filter(|(c, _)| c >> direction & 1 == bit).map(|(_, x)| x);
        if !side.clone().all(|x| (x[face.axis] - face.at).abs() <= 1e-9 * size) {
            continue;
        }
        let count = side.clone().count() as f64;
        let centre = side.clone().sum::<Vector<D>>() / count;
        if let Some((from, to)) = &face.within
            && (0..D).any(|d| d != face.axis && !(from[d]..=to[d]).contains(&centre[d]))
        {
            return None;
        }
        let mut next = || *side.next().expect("a side has 2^(D-1) corners");
        let area = match D {
            2 => (next() - next()).norm(),
            _ => {
                let (a, b, c, d) = (next(), next(), next(), next());
                triangle_area(&(b - a), &(c - a)) + triangle_area(&(b - d), &(c - d))
            }
        };
        return Some((area, centre));
    }
    None
}

fn triangle_area<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    0.5 * (a.norm_squared() * b.norm_squared() - a.dot(b).powi(2)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aligned_ends_are_cut_cell_by_cell_and_others_evenly() {
        let axis = Axis::graded(vec![0.0, 1.0, 3.0, 4.0]).unwrap();
        let lines = |from, to, n| {
            let cut = Cut::of(&axis, from, to, n)?;
            let lines = cut.lines(&axis);
            assert_eq!(cut.pieces(), (lines.len() - 1) as f64);
            Ok::<_, String>(lines)
        };
        assert_eq!(lines(0.0, 3.0, 2).unwrap(), [0.0, 0.5, 1.0, 2.0, 3.0]);
        // 0.5..3.5 touches cells of mean length 4/3; 3 / (4/3) * 2 = 4.5 pieces, so 5.
        let even = lines(0.5, 3.5, 2).unwrap();
        assert_eq!(even.len(), 6);
        assert!((even[1] - 1.1).abs() < 1e-15);
        assert!(lines(3.0, 3.0, 2).is_err());
        assert!(lines(0.0, 4.1, 2).is_err());
    }

    #[test]
    fn rows_follow_the_cells() {
        let axis = Axis::uniform(0.0, 2.0, 2).unwrap();
        let rows = by_cell(&axis, &[0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(rows, [vec![0.0, 0.5, 1.0], vec![1.0, 1.5, 2.0]]);
    }
}
