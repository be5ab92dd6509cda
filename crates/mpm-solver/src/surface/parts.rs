//! From what a surface encloses in each piece of the mesh's cells to the material points of a body.
//!
//! A piece that is full stands for itself. One that is filled in part becomes a box along the axes with the
//! volume, the centre and the mean squares of what it holds; one that holds less than a tenth of a piece
//! goes to a neighbour, so that no cell has a sliver alone.

use super::moments::{self, Moments};
use super::{Round, Surface};
use crate::fill::line_at;
use crate::room::Room;
use mpm_grid::{Axis, Block, Vector};
use nalgebra::Vector3;

/// Pieces at most, full or not, so that none is looked at in vain for hours.
const MOST_PIECES: f64 = 4e9;

/// What a piece that holds something takes, as such, as a part, and in the list of places `[bytes]`.
pub(super) const BYTES_OF_PIECE: usize =
    size_of::<Held>() + size_of::<Part<3>>() + size_of::<([usize; 3], usize)>();

/// Coordinates so close to a line of the grid count as on it [pieces].
const SNAP: f64 = 1e-6;

/// What numbers of files that have single precision are off by [coordinates].
const SINGLE: f64 = f32::EPSILON as f64;

/// The same of numbers of scenes.
const DOUBLE: f64 = 8.0 * f64::EPSILON;

/// A piece is full, or empty, up to so much of its volume.
const ROUNDING: f64 = 1e-9;

/// A piece that holds less of its volume goes to a neighbour.
const SLIVER: f64 = 0.1;

/// How far the sides of a round body's polygon may stand off its circle [pieces].
const ROUNDNESS: f64 = 1e-3;

/// A part of a body: a parallelepiped that points are seeded from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part<const D: usize> {
    pub centre: Vector<D>,
    /// Its columns lead from the centre to the middles of the sides `[L]`.
    pub half_vectors: Block<D>,
    /// What the part holds, its own volume or not `[L^D]`.
    pub volume: f64,
}

/// The parts of a body, and of its faces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts<const D: usize> {
    pub parts: Vec<Part<D>>,
    /// For each face asked for, the parts that carry it with their areas of it.
    pub faces: Vec<Vec<Share<D>>>,
    /// What the parts hold together if nothing is lost, where that is known otherwise `[L^D]`.
    pub volume: Option<f64>,
}

/// What a part carries of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Share<const D: usize> {
    pub part: usize,
    /// `[L^(D-1)]`.
    pub area: f64,
    pub centre: Vector<D>,
}

/// A part of a plane across an axis, see [`crate::fill::Face`].
type Bounds<const D: usize> = (usize, f64, Option<([f64; D], [f64; D])>);

/// What is enclosed.
pub(crate) enum Solid<'a> {
    Surface(&'a Surface),
    Round(Round),
}

impl Solid<'_> {
    fn volume(&self) -> f64 {
        match self {
            Solid::Surface(surface) => surface.volume(),
            Solid::Round(round) => round.volume(),
        }
    }

    /// What its coordinates are off by [coordinates].
    fn precision(&self) -> f64 {
        match self {
            Solid::Surface(_) => SINGLE,
            Solid::Round(_) => DOUBLE,
        }
    }

    fn ends(&self, d: usize) -> (f64, f64) {
        match self {
            Solid::Surface(surface) => {
                let (low, high) = surface.bounds();
                (low[d], high[d])
            }
            Solid::Round(round) if round.axis == d => round.ends,
            Solid::Round(round) => {
                let middle = round.centre[usize::from(round.across()[1] == d)];
                (middle - round.outer, middle + round.outer)
            }
        }
    }
}

/// Cuts what is enclosed into the pieces of the mesh's cells, `n` per cell and direction. In the plane the
/// third direction goes from 0 to 1.
///
/// # Errors
/// A sentence that says what is wrong with the body or the number of points.
pub(crate) fn parts<const D: usize>(
    solid: &Solid<'_>,
    axes: &[Axis; D],
    n: u32,
    faces: &[Bounds<D>],
    room: Room,
) -> Result<Parts<D>, String> {
    let grid = Grid::around(axes, std::array::from_fn(|d| solid.ends(d)), solid.precision(), n, room)?;
    let surface = grid.surface(solid);
    let mut held = grid.held(&surface, room)?;
    let slivers = grid.merge_slivers(&mut held);
    let made = grid.parts(&mut held)?;
    let mut place: Vec<([usize; 3], usize)> = held.iter().enumerate().map(|(k, it)| (it.piece, k)).collect();
    place.sort_unstable();
    let taken = slivers.iter().filter_map(|(from, to)| Some((*from, found(&place, to)?)));
    let taken: Vec<_> = taken.collect();
    place.extend(taken);
    place.sort_unstable();
    let faces = faces.iter().map(|face| grid.face(&surface, face, &place)).collect();
    Ok(Parts { parts: made, faces, volume: Some(solid.volume()) })
}

/// As [`parts`], of what is left of a box whose ends lie on mesh lines once others are cut out of it.
pub(crate) fn rest<const D: usize>(
    (from, to): (&[f64; D], &[f64; D]),
    without: &[Solid<'_>],
    axes: &[Axis; D],
    n: u32,
    room: Room,
) -> Result<Parts<D>, String> {
    for d in 0..D {
        if from[d] >= to[d] {
            return Err(format!("the box is empty: from {} to {}", from[d], to[d]));
        }
        if let Some(end) = [from[d], to[d]].into_iter().find(|&end| line_at(&axes[d], end).is_none()) {
            return Err(format!("a box without other bodies has its ends on mesh lines, got {end}"));
        }
    }
    let grid = Grid::around(
        axes,
        std::array::from_fn(|d| if d < D { (from[d], to[d]) } else { (0.0, 1.0) }),
        DOUBLE,
        n,
        room,
    )?;
    let [nx, ny, nz] = [0, 1, 2].map(|d| grid.lines[d].len() - 1);
    check_pieces(nx as f64 * ny as f64 * nz as f64, room)?;
    let mut held = Vec::with_capacity(nx * ny * nz);
    for piece in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k]))) {
        let (half, volume) = (grid.half(&piece), grid.volume(&piece));
        let second = half.component_mul(&half) * (volume / 3.0);
        held.push(Held { piece, moments: Moments { volume, first: Vector3::zeros(), second }, full: true });
    }
    for solid in without {
        let own = Grid::around(axes, std::array::from_fn(|d| solid.ends(d)), solid.precision(), n, room)?;
        // Pieces of one cell are numbered alike in both grids.
        let offset =
            [0, 1, 2].map(|d| (i64::from(own.cells[d][0]) - i64::from(grid.cells[d][0])) * i64::from(n));
        let offset = if D == 2 { [offset[0], offset[1], 0] } else { offset };
        for cut in own.held(&own.surface(solid), room)? {
            let at = [0, 1, 2].map(|d| usize::try_from(cut.piece[d] as i64 + offset[d]).unwrap_or(usize::MAX));
            if at[0] >= nx || at[1] >= ny || at[2] >= nz {
                continue;
            }
            let left = &mut held[(at[2] * ny + at[1]) * nx + at[0]];
            left.full = false;
            left.moments.volume -= cut.moments.volume;
            left.moments.first -= cut.moments.first;
            left.moments.second -= cut.moments.second;
        }
    }
    let share = |held: &Held| held.moments.volume / grid.volume(&held.piece);
    if let Some(twice) = held.iter().find(|it| share(it) < -1e-6) {
        let x = grid.centre(&twice.piece);
        return Err(format!("the bodies cut out of the box overlap near ({}, {}, {})", x.x, x.y, x.z));
    }
    held.retain(|it| share(it) > ROUNDING);
    grid.merge_slivers(&mut held);
    Ok(Parts { parts: grid.parts(&mut held)?, ..Parts::default() })
}

/// Refuses more pieces of a body than there is room for.
fn check_pieces(count: f64, room: Room) -> Result<(), String> {
    room.check(format_args!("{count:.3e} pieces of the body"), count, BYTES_OF_PIECE)
}

/// The part that a piece belongs to; `place` ascends.
fn found(place: &[([usize; 3], usize)], piece: &[usize; 3]) -> Option<usize> {
    place.binary_search_by_key(piece, |(piece, _)| *piece).ok().map(|at| place[at].1)
}

/// Lines of the pieces around the body.
#[derive(Default)]
struct Grid {
    lines: [Vec<f64>; 3],
    /// Cell of the mesh of each piece.
    cells: [Vec<u32>; 3],
    /// What coordinates of the body are off by [coordinates].
    precision: f64,
}

/// What a piece holds.
#[derive(Clone, Copy, Debug)]
struct Held {
    piece: [usize; 3],
    moments: Moments,
    /// Whether it is the whole piece.
    full: bool,
}

impl Grid {
    /// The pieces of all cells between some ends; in the plane the third direction goes from 0 to 1.
    fn around<const D: usize>(
        axes: &[Axis; D],
        ends: [(f64, f64); 3],
        precision: f64,
        n: u32,
        room: Room,
    ) -> Result<Self, String> {
        let mut grid = Self { precision, ..Self::default() };
        for (d, axis) in axes.iter().enumerate() {
            grid.span(d, axis, ends[d], n, room)?;
        }
        if D == 2 {
            grid.lines[2] = vec![0.0, 1.0];
            grid.cells[2] = vec![0];
        }
        let pieces: f64 = grid.lines.iter().map(|lines| (lines.len() - 1) as f64).product();
        if pieces > MOST_PIECES {
            return Err(format!(
                "{pieces:e} pieces around the body are more than the {MOST_PIECES:e} there can be"
            ));
        }
        Ok(grid)
    }

    /// The surface of a body, its coordinates moved onto lines that they all but lie on.
    fn surface(&self, solid: &Solid<'_>) -> Surface {
        match solid {
            Solid::Surface(surface) => self.snapped(surface),
            Solid::Round(round) => {
                let lines = round.across().map(|d| &self.lines[d]);
                let sizes = lines.iter().flat_map(|lines| lines.windows(2)).map(|ends| ends[1] - ends[0]);
                round.surface(ROUNDNESS * sizes.fold(f64::INFINITY, f64::min))
            }
        }
    }

    /// What the pieces hold as parts, in the order of their cells, in which `held` then is.
    fn parts<const D: usize>(&self, held: &mut [Held]) -> Result<Vec<Part<D>>, String> {
        if held.is_empty() {
            return Err("the body is too small for the mesh: no piece of a cell holds any of it".into());
        }
        // Points that share nodes stay together.
        let cell = |piece: &[usize; 3]| [2, 1, 0].map(|d| self.cells[d][piece[d]]);
        held.sort_by_key(|held| (cell(&held.piece), [2, 1, 0].map(|d| held.piece[d])));
        held.iter().map(|held| self.part(held)).collect()
    }

    /// Lines along one direction, of all cells that the body reaches into.
    fn span(
        &mut self,
        d: usize,
        axis: &Axis,
        (from, to): (f64, f64),
        n: u32,
        room: Room,
    ) -> Result<(), String> {
        let cell = |x: f64| axis.locate(x.clamp(axis.first(), axis.last())).0;
        let precision = self.precision;
        let near = |x: f64| SNAP * axis.size(cell(x)) / f64::from(n) + precision * x.abs();
        if from < axis.first() - near(from) || to > axis.last() + near(to) {
            return Err(format!(
                "the body reaches from {from} to {to} along {}, outside the mesh from {} to {}",
                ["x", "y", "z"][d],
                axis.first(),
                axis.last()
            ));
        }
        let inner = from + near(from);
        let (first, last) = (cell(inner), cell((to - near(to)).max(inner)));
        let count = f64::from(last + 1 - first) * f64::from(n);
        if count > MOST_PIECES {
            return Err(format!("{count:e} material points along one direction are too many"));
        }
        let what = format_args!("{count:e} material points along one direction");
        room.check(what, count, size_of::<f64>() + size_of::<u32>())?;
        self.lines[d] = vec![axis.node(first)];
        for cell in first..=last {
            let (low, high) = (axis.node(cell), axis.node(cell + 1));
            self.lines[d].extend((1..n).map(|k| low + (high - low) * f64::from(k) / f64::from(n)));
            self.lines[d].push(high);
            self.cells[d].extend((0..n).map(|_| cell));
        }
        Ok(())
    }

    fn snapped(&self, surface: &Surface) -> Surface {
        let mut snapped = surface.clone();
        for x in &mut snapped.vertices {
            for d in 0..3 {
                let lines = &self.lines[d];
                let above = lines.partition_point(|&line| line < x[d]).clamp(1, lines.len() - 1);
                let near = SNAP * (lines[above] - lines[above - 1]) + self.precision * x[d].abs();
                if let Some(&line) = lines[above - 1..=above].iter().find(|line| (*line - x[d]).abs() <= near) {
                    x[d] = line;
                }
            }
        }
        snapped
    }

    fn centre(&self, piece: &[usize; 3]) -> Vector3<f64> {
        Vector3::from_fn(|d, _| 0.5 * (self.lines[d][piece[d]] + self.lines[d][piece[d] + 1]))
    }

    fn half(&self, piece: &[usize; 3]) -> Vector3<f64> {
        Vector3::from_fn(|d, _| 0.5 * (self.lines[d][piece[d] + 1] - self.lines[d][piece[d]]))
    }

    fn volume(&self, piece: &[usize; 3]) -> f64 {
        8.0 * self.half(piece).product()
    }

    /// What every piece holds, z slowest and x fastest.
    fn held(&self, surface: &Surface, room: Room) -> Result<Vec<Held>, String> {
        let [nx, ny, _] = [0, 1, 2].map(|d| (self.lines[d].len() - 1) as f64);
        room.check("a layer of pieces around the body", nx * ny, moments::BYTES_IN_LAYER)?;
        // No piece holds more than the largest of them.
        let longest = |lines: &Vec<f64>| lines.windows(2).map(|ends| ends[1] - ends[0]).fold(0.0, f64::max);
        let least = surface.volume() / self.lines.iter().map(longest).product::<f64>();
        check_pieces((least * (1.0 - ROUNDING)).floor(), room)?;
        let most = room.most(BYTES_OF_PIECE);
        let mut held = Vec::new();
        let mut more = 0_usize;
        let mut wrong = None;
        moments::for_each(surface, &self.lines, |piece, moments| {
            let share = moments.volume / self.volume(&piece);
            if !(-1e-6..=1.0 + 1e-6).contains(&share) && wrong.is_none() {
                wrong = Some((piece, share));
            } else if share > ROUNDING && held.len() == most {
                more += 1;
            } else if share > ROUNDING {
                held.push(Held { piece, moments: *moments, full: share > 1.0 - ROUNDING });
            }
        });
        match wrong {
            None => check_pieces((held.len() + more) as f64, room).map(|()| held),
            Some((piece, share)) => {
                let x = self.centre(&piece);
                let how = if share < 0.0 { "outside in" } else { "more than once" };
                Err(format!(
                    "the surface encloses the surroundings of ({}, {}, {}) {how}: one of its shells faces the wrong way",
                    x.x, x.y, x.z
                ))
            }
        }
    }

    /// Gives what is less than a tenth of a piece to the neighbour across a face that holds most. Returns
    /// which piece went to which.
    fn merge_slivers(&self, held: &mut Vec<Held>) -> Vec<([usize; 3], [usize; 3])> {
        let share = |held: &Held| held.moments.volume / self.volume(&held.piece);
        let find = |piece: [usize; 3]| {
            let key = |piece: &[usize; 3]| [piece[2], piece[1], piece[0]];
            held.binary_search_by_key(&key(&piece), |it| key(&it.piece)).ok()
        };
        let mut given = Vec::new();
        for (k, sliver) in held.iter().enumerate().filter(|(_, it)| share(it) < SLIVER) {
            let neighbours = (0..3).flat_map(|d| {
                let mut low = sliver.piece;
                low[d] = low[d].wrapping_sub(1);
                let mut high = sliver.piece;
                high[d] += 1;
                [low, high]
            });
            let large = neighbours.filter_map(find).filter(|&k| share(&held[k]) >= SLIVER);
            let most = large.reduce(|a, b| if held[b].moments.volume > held[a].moments.volume { b } else { a });
            given.extend(most.map(|to| (k, to)));
        }
        let pieces = given.iter().map(|&(from, to)| (held[from].piece, held[to].piece)).collect();
        for &(from, to) in &given {
            let offset = self.centre(&held[from].piece) - self.centre(&held[to].piece);
            let Moments { volume, first, second } = held[from].moments;
            let taker = &mut held[to];
            taker.full = false;
            taker.moments.volume += volume;
            taker.moments.second +=
                second + 2.0 * first.component_mul(&offset) + offset.component_mul(&offset) * volume;
            taker.moments.first += first + offset * volume;
            held[from].moments.volume = 0.0;
        }
        held.retain(|it| it.moments.volume > 0.0);
        pieces
    }

    fn part<const D: usize>(&self, held: &Held) -> Result<Part<D>, String> {
        let (mut centre, mut half) = (self.centre(&held.piece), self.half(&held.piece));
        let Moments { volume, first, second } = held.moments;
        if !held.full {
            let mean = first / volume;
            let square = second / volume - mean.component_mul(&mean);
            let thin = (0..D).find(|&d| square[d] <= 1e-12 * half[d] * half[d]);
            if let Some(d) = thin {
                return Err(format!(
                    "at ({}, {}, {}) the body is a film across {}, too thin for a material point",
                    centre.x,
                    centre.y,
                    centre.z,
                    ["x", "y", "z"][d]
                ));
            }
            centre += mean;
            half = square.map(|it| (3.0 * it).sqrt());
        }
        let volume = if held.full { self.volume(&held.piece) } else { volume };
        Ok(Part {
            centre: Vector::from_fn(|d, _| centre[d]),
            half_vectors: Block::from_fn(|i, j| if i == j { half[i] } else { 0.0 }),
            volume,
        })
    }

    /// Areas of a face by part; `place` tells the parts of pieces, ascending.
    fn face<const D: usize>(
        &self,
        surface: &Surface,
        (axis, at, within): &Bounds<D>,
        place: &[([usize; 3], usize)],
    ) -> Vec<Share<D>> {
        let lines = &self.lines[*axis];
        let last = lines.len() - 2;
        let mut shares: Vec<Share<D>> = Vec::new();
        let above = lines.partition_point(|line| line < at).clamp(1, last + 1);
        let near = SNAP * (lines[above] - lines[above - 1]) + self.precision * at.abs();
        moments::for_each_on_plane(surface, &self.lines, (*axis, *at, near), |mut piece, area, centre, up| {
            let outside = |(from, to): &([f64; D], [f64; D])| {
                (0..D).any(|d| d != *axis && !(from[d]..=to[d]).contains(&centre[d]))
            };
            if within.as_ref().is_some_and(outside) {
                return;
            }
            // The piece behind the face, which may lie on a line.
            let inward = if up { at - near } else { at + near };
            piece[*axis] = lines.partition_point(|&line| line <= inward).saturating_sub(1).min(last);
            let centre = Vector::from_fn(|d, _| centre[d]);
            shares.extend(found(place, &piece).map(|part| Share { part, area, centre }));
        });
        shares.sort_by_key(|it| it.part);
        let parts = shares.chunk_by(|a, b| a.part == b.part).map(|same| {
            let area = same.iter().map(|it| it.area).sum();
            let centre = same.iter().map(|it| it.centre * it.area).sum::<Vector<D>>() / area;
            Share { part: same[0].part, area, centre }
        });
        parts.collect()
    }
}
