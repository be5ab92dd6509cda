//! Shapes cut into pieces, cell by cell, from which material points are made.

use mpm_basis::Piece;
use mpm_geometry::{Parts, Solid};
use mpm_grid::{Axis, Mesh, Vector};

/// Points of one body at most; their numbers have 32 bits.
pub(crate) const MOST_POINTS: f64 = 4e9;

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

/// Number of pieces that [`for_each_piece`] makes of a shape.
pub(crate) fn count_pieces<const D: usize>(
    mesh: &Mesh<D>,
    shape: &Shape<'_, D>,
    per_cell: u32,
) -> Result<f64, String> {
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
pub(crate) fn for_each_piece<const D: usize>(
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

pub(crate) fn box_piece<const D: usize>(low: &Vector<D>, high: &Vector<D>) -> Piece<D> {
    Piece::new(std::array::from_fn(|corner| {
        Vector::from_fn(|d, _| if corner >> d & 1 == 1 { high[d] } else { low[d] })
    }))
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
