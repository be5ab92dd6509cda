//! Shapes cut into pieces, cell by cell, from which material points are made.

use crate::disc::Disc;
use mpm_geometry::{Parts, Solid};
use mpm_grid::{Axis, LinearCell, Mesh, Vector};
use std::ops::Range;

/// Points of one body at most; their numbers have 32 bits.
pub(crate) const MOST_POINTS: f64 = 4e9;

/// What is filled.
pub(crate) enum Shape<'a, const D: usize> {
    /// A box in a rectilinear mesh, by its corners `[L]`.
    Box { from: [f64; D], to: [f64; D] },
    /// Whole cells of polygons, from the multi-index `low` up to but without `high`.
    Cells {
        low: [u32; D],
        high: [u32; D],
        /// Volume of the round shape that they stand for `[L^D]`.
        volume: f64,
        /// Whether the points have that volume in all; else the polygons'.
        is_exact: bool,
    },
    /// A disc in tiles of its own.
    Disc(Disc),
    /// What a surface encloses, in a rectilinear mesh; what is outside the mesh along open directions is left out.
    Solid { solid: Solid<'a>, open: [bool; D] },
    /// A box with its ends on mesh lines, without what others enclose.
    Rest { from: [f64; D], to: [f64; D], without: Vec<Solid<'a>> },
    /// Parts that are given.
    Parts(Parts<D>),
}

/// Number of [pieces](Pieces) of a shape; `names` are those of the directions.
pub(crate) fn count_pieces<const D: usize>(
    mesh: &Mesh<D>,
    shape: &Shape<'_, D>,
    per_cell: u32,
    names: [&str; 3],
) -> Result<f64, String> {
    match shape {
        Shape::Box { from, to } => Ok(pieces_of_box(mesh, (from, to), per_cell, names)?.iter().product()),
        Shape::Cells { low, high, .. } => {
            Ok((0..D).map(|d| f64::from(high[d] - low[d]) * f64::from(per_cell)).product())
        }
        Shape::Disc(disc) => Ok(disc.count::<D>(per_cell)),
        Shape::Solid { .. } | Shape::Rest { .. } | Shape::Parts(_) => Ok(0.0),
    }
}

/// Number of pieces of a box along each direction.
pub(crate) fn pieces_of_box<const D: usize>(
    mesh: &Mesh<D>,
    (from, to): (&[f64; D], &[f64; D]),
    per_cell: u32,
    names: [&str; 3],
) -> Result<[f64; D], String> {
    let axes = mesh.rectilinear().ok_or("a box can only be filled in a box mesh")?;
    let mut pieces = [0.0; D];
    for d in 0..D {
        pieces[d] = Cut::of(&axes[d], names[d], (from[d], to[d]), per_cell)?.pieces(&axes[d]);
    }
    Ok(pieces)
}

impl<const D: usize> Shape<'_, D> {
    /// Its volume, where it is known without filling it `[L^D]`.
    pub(crate) fn volume(&self) -> Option<f64> {
        match self {
            Shape::Box { from, to } => Some((0..D).map(|d| to[d] - from[d]).product()),
            Shape::Cells { volume, .. } => Some(*volume),
            Shape::Disc(disc) => Some(disc.volume()),
            Shape::Solid { .. } | Shape::Rest { .. } | Shape::Parts(_) => None,
        }
    }
}

/// Which sides of a piece, low and high in every direction, are sides of the body.
pub(crate) type Outer<const D: usize> = [[bool; 2]; D];

/// How shapes are cut into pieces, cell by cell and piece by piece inside a cell, so that points that share nodes stay together; layer
/// by layer of cells along the last direction.
pub(crate) enum Pieces<'a, const D: usize> {
    /// Pieces of every cell along each direction.
    Box([Vec<CellRow>; D]),
    Cells {
        mesh: &'a Mesh<D>,
        low: [u32; D],
        extent: [usize; D],
        per_cell: u32,
    },
    Disc(&'a Disc, u32),
    /// Of shapes that are made of parts.
    None,
}

impl<'a, const D: usize> Pieces<'a, D> {
    /// Of a shape; `names` are those of the directions.
    pub(crate) fn of(
        mesh: &'a Mesh<D>,
        shape: &'a Shape<'_, D>,
        (per_cell, names): (u32, [&str; 3]),
    ) -> Result<Self, String> {
        Ok(match shape {
            Shape::Box { from, to } => {
                let axes = mesh.rectilinear().ok_or("a box can only be filled in a box mesh")?;
                let mut rows = std::array::from_fn(|_| Vec::new());
                for (d, rows) in rows.iter_mut().enumerate() {
                    let cut = Cut::of(&axes[d], names[d], (from[d], to[d]), per_cell)?;
                    *rows = by_cell(&axes[d], &cut.lines(&axes[d]));
                }
                Self::Box(rows)
            }
            Shape::Cells { low, high, .. } => {
                let extent = std::array::from_fn(|d| (high[d] - low[d]) as usize);
                Self::Cells { mesh, low: *low, extent, per_cell }
            }
            Shape::Disc(disc) => Self::Disc(disc, per_cell),
            Shape::Solid { .. } | Shape::Rest { .. } | Shape::Parts(_) => Self::None,
        })
    }

    /// How many layers there are.
    pub(crate) fn layers(&self) -> usize {
        match self {
            Self::Box(rows) => rows[D - 1].len(),
            Self::Cells { extent, .. } => extent[D - 1],
            Self::Disc(disc, per_tile) => disc.layers::<D>(*per_tile),
            Self::None => 0,
        }
    }

    /// Number of pieces below a layer.
    pub(crate) fn below(&self, layer: usize) -> usize {
        match self {
            Self::Box(rows) => {
                let pieces = |rows: &[CellRow]| rows.iter().map(|row| row.len() - 1).sum::<usize>();
                rows[..D - 1].iter().map(|rows| pieces(rows)).product::<usize>() * pieces(&rows[D - 1][..layer])
            }
            Self::Cells { extent, per_cell, .. } => {
                extent[..D - 1].iter().product::<usize>() * layer * (*per_cell as usize).pow(D as u32)
            }
            Self::Disc(disc, per_tile) => {
                let all = disc.count::<D>(*per_tile) as usize;
                all / disc.layers::<D>(*per_tile) * layer
            }
            Self::None => 0,
        }
    }

    /// Calls `each` with the pieces of some layers.
    pub(crate) fn for_each(&self, layers: Range<usize>, mut each: impl FnMut(&LinearCell<D>, &Outer<D>)) {
        match self {
            Self::Box(rows) => {
                for_each(within(rows.each_ref().map(Vec::len), layers), |cell: [usize; D]| {
                    let row: [&CellRow; D] = std::array::from_fn(|d| &rows[d][cell[d]]);
                    for_each(row.map(|row| 0..row.len() - 1), |piece: [usize; D]| {
                        let low = Vector::from_fn(|d, _| row[d][piece[d]]);
                        let high = Vector::from_fn(|d, _| row[d][piece[d] + 1]);
                        let outer = std::array::from_fn(|d| {
                            let (first_row, last_row) = (cell[d] == 0, cell[d] + 1 == rows[d].len());
                            [first_row && piece[d] == 0, last_row && piece[d] + 2 == row[d].len()]
                        });
                        each(&box_piece(&low, &high), &outer);
                    });
                });
            }
            Self::Cells { mesh, low, extent, per_cell } => {
                let closed = mesh.lattice().periodic();
                let local = |k: usize| 2.0 * k as f64 / f64::from(*per_cell) - 1.0;
                for_each(within(*extent, layers), |offset: [usize; D]| {
                    let cell = std::array::from_fn(|d| low[d] + offset[d] as u32);
                    for_each([(); D].map(|()| 0..*per_cell as usize), |piece: [usize; D]| {
                        let from = Vector::from_fn(|d, _| local(piece[d]));
                        let to = Vector::from_fn(|d, _| local(piece[d] + 1));
                        let outer = std::array::from_fn(|d| {
                            let (first, last) = (offset[d] == 0, offset[d] + 1 == extent[d]);
                            let ends = [piece[d] == 0, piece[d] + 1 == *per_cell as usize];
                            [!closed[d] && first && ends[0], !closed[d] && last && ends[1]]
                        });
                        each(&mesh.piece(cell, &from, &to), &outer);
                    });
                });
            }
            Self::Disc(disc, per_tile) => disc.for_each_piece(*per_tile, layers, each),
            Self::None => {}
        }
    }
}

/// All of an extent but along the last direction.
fn within<const D: usize>(extent: [usize; D], layers: Range<usize>) -> [Range<usize>; D] {
    let mut within = extent.map(|n| 0..n);
    within[D - 1] = layers;
    within
}

/// Coordinates of the pieces of one cell along one direction, ends included.
pub(crate) type CellRow = Vec<f64>;

/// How a length is cut into pieces.
///
/// Where both ends lie on mesh lines every cell is cut into `n`. Else the length is cut evenly into pieces no longer
/// than a cell over `n` where cells are equal, and cell by cell where they are not: what an end leaves of a cell
/// is cut into pieces no longer than the cell over `n`.
enum Cut {
    /// The cells from `first` up to but without `last`, each into `n`.
    Cells { first: u32, last: u32, n: u32 },
    /// All of it into `count`.
    Evenly { from: f64, to: f64, count: u32 },
    /// Cell by cell, each into pieces no longer than the cell over `n`.
    ByCell { from: f64, to: f64, n: u32 },
}

/// What an end leaves of a cell goes to the neighbour where it is shorter [pieces].
const LEAST: f64 = 0.1;

impl Cut {
    /// Of `from..to` along an axis of this name.
    fn of(axis: &Axis, along: &str, (from, to): (f64, f64), n: u32) -> Result<Self, String> {
        let empty = || Err(format!("the box is empty along {along}: from {from} to {to}"));
        if from >= to {
            return empty();
        }
        let span = axis.last() - axis.first();
        if from < axis.first() - 1e-9 * span || to > axis.last() + 1e-9 * span {
            return Err(format!(
                "the box reaches from {from} to {to} along {along}, outside the mesh from {} to {}",
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
        if !axis.is_uniform() {
            return Ok(Self::ByCell { from, to, n });
        }
        let mean_cell = (axis.node(last + 1) - axis.node(first)) / f64::from(last + 1 - first);
        let count = ((to - from) / mean_cell * f64::from(n) - 1e-9).ceil().max(1.0);
        if count > MOST_POINTS {
            return Err(format!("{count:e} material points along {along} are too many"));
        }
        Ok(Self::Evenly { from, to, count: count as u32 })
    }

    /// Number of pieces.
    fn pieces(&self, axis: &Axis) -> f64 {
        match self {
            Self::Cells { first, last, n } => f64::from(last - first) * f64::from(*n),
            Self::Evenly { count, .. } => f64::from(*count),
            Self::ByCell { from, to, n } => stretches(axis, (*from, *to), *n).iter().map(|it| it.pieces).sum(),
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
            Self::ByCell { from, to, n } => {
                let mut lines = vec![from];
                for Stretch { begin, end, pieces } in stretches(axis, (from, to), n) {
                    lines.extend((1..pieces as u32).map(|k| begin + (end - begin) * f64::from(k) / pieces));
                    lines.push(end);
                }
                lines
            }
            Self::Evenly { from, to, count } => {
                (0..=count).map(|k| from + (to - from) * f64::from(k) / f64::from(count)).collect()
            }
        }
    }
}

/// A part of a length that lies in one cell, slivers of its neighbours included, and its number of pieces.
struct Stretch {
    begin: f64,
    end: f64,
    pieces: f64,
}

/// A length cut at the lines of the mesh.
fn stretches(axis: &Axis, (from, to): (f64, f64), n: u32) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let (first, last) = (axis.locate(from).0, axis.locate(to).0);
    let mut begin = from;
    for cell in first..=last {
        let end = if cell == last { to } else { axis.node(cell + 1) };
        let pieces = (end - begin) / axis.size(cell) * f64::from(n);
        // A sliver at the beginning goes to the next cell, one at the end to the cell before.
        if pieces < LEAST && cell < last {
            continue;
        }
        if let Some(before) = stretches.last_mut().filter(|_| pieces < LEAST) {
            before.end = to;
            continue;
        }
        stretches.push(Stretch { begin, end, pieces: (pieces - LEAST).ceil().max(1.0) });
        begin = end;
    }
    stretches
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

/// Calls `each` for every multi-index within, the first direction fastest.
fn for_each<const D: usize>(within: [Range<usize>; D], mut each: impl FnMut([usize; D])) {
    if within.iter().any(Range::is_empty) {
        return;
    }
    let first = within.each_ref().map(|it| it.start);
    let mut index = first;
    loop {
        each(index);
        let Some(d) = (0..D).find(|&d| index[d] + 1 < within[d].end) else { return };
        index[d] += 1;
        index[..d].copy_from_slice(&first[..d]);
    }
}

pub(crate) fn box_piece<const D: usize>(low: &Vector<D>, high: &Vector<D>) -> LinearCell<D> {
    LinearCell::new(std::array::from_fn(|corner| {
        Vector::from_fn(|d, _| if corner >> d & 1 == 1 { high[d] } else { low[d] })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_cells_are_cut_evenly_between_ends_off_their_lines() {
        let axis = Axis::uniform(0.0, 4.0, 4).unwrap();
        let even = Cut::of(&axis, "x", (0.5, 3.3), 2).unwrap().lines(&axis);
        assert_eq!(even.len(), 7);
        assert!((even[1] - 0.5 - 2.8 / 6.0).abs() < 1e-15);
        // Far from the origin an end on a line is one up to rounding.
        let far = Axis::uniform(1e6, 1e6 + 1e-3, 10).unwrap();
        assert_eq!(far.line_at(1e6 + 3e-4), Some(3));
    }

    #[test]
    fn aligned_ends_are_cut_cell_by_cell_and_others_at_the_end() {
        let axis = Axis::graded(vec![0.0, 1.0, 3.0, 4.0]).unwrap();
        let lines = |from, to, n| {
            let cut = Cut::of(&axis, "x", (from, to), n)?;
            let lines = cut.lines(&axis);
            assert_eq!(cut.pieces(&axis), (lines.len() - 1) as f64);
            Ok::<_, String>(lines)
        };
        assert_eq!(lines(0.0, 3.0, 2).unwrap(), [0.0, 0.5, 1.0, 2.0, 3.0]);
        // Cells that are not equal are cut one by one; the ends leave half a cell, one piece of two.
        assert_eq!(lines(0.5, 3.5, 2).unwrap(), [0.5, 1.0, 2.0, 3.0, 3.5]);
        // Slivers go to their neighbours.
        let slivers = lines(0.99, 3.01, 2).unwrap();
        assert!(slivers.len() == 3 && (slivers[1] - 2.0).abs() < 1e-15);
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
