//! From what a surface encloses in each piece of the mesh's cells to the material points of a body.
//!
//! A piece that is full stands for itself. One that is filled in part becomes a box along the axes with the
//! volume, the centre and the mean squares of what it holds; one that holds less than a tenth of a piece
//! goes to a neighbour, so that no cell has a sliver alone.

use crate::grid::{Grid, Held, ROUNDING, SNAP, check_pieces};
use crate::memory::MemoryLimit;
use crate::moments::Moments;
use crate::part::{Face, Part, Parts, Share};
use crate::solid::{DOUBLE, Solid};
use crate::triangles::Triangles;
use mpm_grid::{Axis, Block, Vector};
use nalgebra::Vector3;

/// Cuts what is enclosed into the pieces of the mesh's cells, `n` per cell and direction. In the plane the
/// third direction goes from 0 to 1. What reaches beyond the mesh along directions that are `open` is left out.
///
/// # Errors
/// A sentence that says what is wrong with the body or the number of points.
pub fn parts<const D: usize>(
    solid: &Solid<'_>,
    open: [bool; D],
    axes: &[Axis; D],
    n: u32,
    faces: &[Face<D>],
    memory: MemoryLimit,
) -> Result<Parts<D>, String> {
    let ends = std::array::from_fn(|d| solid.ends(d));
    let grid = Grid::around(axes, ends, open, solid.precision(), n, memory)?;
    let surface = grid.surface(solid);
    let mut held = grid.held(&surface, memory)?;
    let slivers = grid.merge_slivers(&mut held);
    let made = grid.parts(&mut held)?;
    let mut place: Vec<([usize; 3], usize)> = held.iter().enumerate().map(|(k, it)| (it.piece, k)).collect();
    place.sort_unstable();
    let taken = slivers.iter().filter_map(|(from, to)| Some((*from, found(&place, to)?)));
    let taken: Vec<_> = taken.collect();
    place.extend(taken);
    place.sort_unstable();
    let faces = faces.iter().map(|face| grid.face(&surface, face, &place)).collect();
    let volume = grid.volume_left(&surface).unwrap_or_else(|| solid.volume());
    Ok(Parts { parts: made, faces, volume: Some(volume) })
}

/// As [`parts`], of what is left of a box whose ends lie on mesh lines once others are cut out of it, as far as they
/// reach into it.
///
/// # Errors
/// As [`parts`]; where the box is empty, has an end between mesh lines, or the others overlap.
pub fn rest<const D: usize>(
    (from, to): (&[f64; D], &[f64; D]),
    without: &[Solid<'_>],
    axes: &[Axis; D],
    n: u32,
    memory: MemoryLimit,
) -> Result<Parts<D>, String> {
    for d in 0..D {
        if from[d] >= to[d] {
            return Err(format!(
                "the box is empty along {}: from {} to {}",
                ["x", "y", "z"][d],
                from[d],
                to[d]
            ));
        }
        if let Some(end) = [from[d], to[d]].into_iter().find(|&end| axes[d].line_at(end).is_none()) {
            return Err(format!("a box without other bodies has its ends on mesh lines, got {end}"));
        }
    }
    let grid = Grid::around(
        axes,
        std::array::from_fn(|d| if d < D { (from[d], to[d]) } else { (0.0, 1.0) }),
        [false; D],
        DOUBLE,
        n,
        memory,
    )?;
    let [nx, ny, nz] = [0, 1, 2].map(|d| grid.lines[d].len() - 1);
    check_pieces(nx as f64 * ny as f64 * nz as f64, memory)?;
    let mut held = Vec::with_capacity(nx * ny * nz);
    for piece in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k]))) {
        let (half, volume) = (grid.half(&piece), grid.volume(&piece));
        let second = half.component_mul(&half) * (volume / 3.0);
        held.push(Held { piece, moments: Moments { volume, first: Vector3::zeros(), second }, full: true });
    }
    for solid in without {
        let ends = std::array::from_fn(|d| solid.ends(d));
        let own = Grid::around(axes, ends, [true; D], solid.precision(), n, memory)?;
        // Pieces of one cell are numbered alike in both grids.
        let offset =
            [0, 1, 2].map(|d| (i64::from(own.cells[d][0]) - i64::from(grid.cells[d][0])) * i64::from(n));
        let offset = if D == 2 { [offset[0], offset[1], 0] } else { offset };
        for cut in own.held(&own.surface(solid), memory)? {
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

/// The part that a piece belongs to; `place` ascends.
fn found(place: &[([usize; 3], usize)], piece: &[usize; 3]) -> Option<usize> {
    place.binary_search_by_key(piece, |(piece, _)| *piece).ok().map(|at| place[at].1)
}

impl Grid {
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
            // Nothing of the body lies beyond a plane that cuts it, so neither does the box.
            for d in 0..D {
                let [first, last] = [0, self.lines[d].len() - 1].map(|k| self.lines[d][k]);
                let room = [centre[d] - first, last - centre[d]];
                for side in (0..2).filter(|&side| self.cut[d][side]) {
                    half[d] = half[d].min(room[side]);
                }
            }
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
        surface: &Triangles,
        Face { axis, at, within }: &Face<D>,
        place: &[([usize; 3], usize)],
    ) -> Vec<Share<D>> {
        let lines = &self.lines[*axis];
        let last = lines.len() - 2;
        let mut shares: Vec<Share<D>> = Vec::new();
        let above = lines.partition_point(|line| line < at).clamp(1, last + 1);
        let near = SNAP * (lines[above] - lines[above - 1]) + self.precision * at.abs();
        self.for_each_on_plane(surface, (*axis, *at, near), |mut piece, area, centre, up| {
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
