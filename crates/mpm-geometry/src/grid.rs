//! The pieces of the mesh's cells around a body, and what each of them holds of it.

use crate::memory::MemoryLimit;
use crate::moments::{self, Moments};
use crate::part::Part;
use crate::solid::Solid;
use crate::triangles::Triangles;
use mpm_grid::Axis;
use nalgebra::Vector3;

/// Pieces at most, full or not, so that none is looked at in vain for hours.
const MOST_PIECES: f64 = 4e9;

/// What a piece that holds something takes, as such, as a part, and in the list of places `[bytes]`.
pub(crate) const BYTES_OF_PIECE: usize =
    size_of::<Held>() + size_of::<Part<3>>() + size_of::<([usize; 3], usize)>();

/// Coordinates so close to a line of the grid count as on it [pieces].
pub(crate) const SNAP: f64 = 1e-6;

/// A piece is full, or empty, up to so much of its volume.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A piece that holds less of its volume goes to a neighbour.
const SLIVER: f64 = 0.1;

/// How far the sides of a round body's polygon may stand off its circle [pieces].
const ROUNDNESS: f64 = 1e-3;

/// Lines of the pieces around the body.
#[derive(Default)]
pub(crate) struct Grid {
    pub(crate) lines: [Vec<f64>; 3],
    /// Cell of the mesh of each piece.
    pub(crate) cells: [Vec<u32>; 3],
    /// What coordinates of the body are off by [coordinates].
    pub(crate) precision: f64,
    /// Whether the body goes on beyond the first and the last line, and is cut off there.
    pub(crate) cut: [[bool; 2]; 3],
}

/// What a piece holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    pub(crate) piece: [usize; 3],
    pub(crate) moments: Moments,
    /// Whether it is the whole piece.
    pub(crate) full: bool,
}

impl Grid {
    /// The pieces of all cells between some ends; in the plane the third direction goes from 0 to 1. Ends may lie
    /// outside the mesh along directions that are `open`.
    pub(crate) fn around<const D: usize>(
        axes: &[Axis; D],
        ends: [(f64, f64); 3],
        open: [bool; D],
        precision: f64,
        n: u32,
        memory: MemoryLimit,
    ) -> Result<Self, String> {
        let mut grid = Self { precision, ..Self::default() };
        for (d, axis) in axes.iter().enumerate() {
            let (mut from, mut to) = ends[d];
            if open[d] {
                grid.cut[d] = [from < axis.first(), to > axis.last()];
                (from, to) = (from.max(axis.first()), to.min(axis.last()));
                if from >= to {
                    return Err("the body is too small for the mesh: no piece of a cell holds any of it".into());
                }
            }
            grid.span(d, axis, (from, to), n, memory)?;
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
    pub(crate) fn surface(&self, solid: &Solid<'_>) -> Triangles {
        match solid {
            Solid::Surface(surface) => self.snapped(surface.triangles()),
            Solid::Prism(prism) => self.snapped(&prism.surface()),
            Solid::Round(round) => round.surface(ROUNDNESS * self.smallest(&round.across())),
            Solid::Ball(ball) => ball.surface(ROUNDNESS * self.smallest(&[0, 1, 2])),
        }
    }

    /// The smallest piece along some directions `[L]`.
    fn smallest(&self, directions: &[usize]) -> f64 {
        let sizes = directions.iter().flat_map(|&d| self.lines[d].windows(2)).map(|ends| ends[1] - ends[0]);
        sizes.fold(f64::INFINITY, f64::min)
    }

    /// The lines, with one more around what is cut off of a surface, and the number of those before the first.
    fn with_margins(&self, surface: &Triangles) -> ([Vec<f64>; 3], [usize; 3]) {
        let (low, high) = surface.bounds();
        let (mut lines, mut before) = (self.lines.clone(), [0; 3]);
        for d in 0..3 {
            let [first, last] = [0, self.lines[d].len() - 1].map(|k| self.lines[d][k]);
            if self.cut[d][1] && high[d] > last {
                lines[d].push(high[d]);
            }
            if self.cut[d][0] && low[d] < first {
                lines[d].insert(0, low[d]);
                before[d] = 1;
            }
        }
        (lines, before)
    }

    /// The number of a piece among the grid's own; `None` for one that is cut off. The direction `but` is left alone.
    fn inside(&self, piece: [usize; 3], before: [usize; 3], but: Option<usize>) -> Option<[usize; 3]> {
        let mut own = piece;
        for d in (0..3).filter(|&d| Some(d) != but) {
            own[d] = piece[d].checked_sub(before[d]).filter(|&k| k + 1 < self.lines[d].len())?;
        }
        Some(own)
    }

    /// What the surface of a body encloses of the grid, where some of it is cut off `[L³]`.
    pub(crate) fn volume_left(&self, surface: &Triangles) -> Option<f64> {
        if !self.cut.iter().flatten().any(|&cut| cut) {
            return None;
        }
        let (low, high) = surface.bounds();
        let end = |d: usize, side: usize| match (side, self.cut[d][side]) {
            (0, true) => self.lines[d][0],
            (0, false) => low[d],
            (_, true) => self.lines[d][self.lines[d].len() - 1],
            (_, false) => high[d],
        };
        Some(moments::volume_in(surface, &[0, 1, 2].map(|d| end(d, 0)), &[0, 1, 2].map(|d| end(d, 1))))
    }

    /// Calls `each` with the parts of the facets in a plane, by the pieces across it, as
    /// [`moments::for_each_on_plane`] does.
    pub(crate) fn for_each_on_plane(
        &self,
        surface: &Triangles,
        plane: (usize, f64, f64),
        mut each: impl FnMut([usize; 3], f64, Vector3<f64>, bool),
    ) {
        let (lines, before) = self.with_margins(surface);
        moments::for_each_on_plane(surface, &lines, plane, |piece, area, centre, up| {
            if let Some(piece) = self.inside(piece, before, Some(plane.0)) {
                each(piece, area, centre, up);
            }
        });
    }

    /// Lines along one direction, of all cells that the body reaches into.
    fn span(
        &mut self,
        d: usize,
        axis: &Axis,
        (from, to): (f64, f64),
        n: u32,
        memory: MemoryLimit,
    ) -> Result<(), String> {
        let cell = |x: f64| axis.locate(x.clamp(axis.first(), axis.last())).0;
        let (precision, along) = (self.precision, ["x", "y", "z"][d]);
        let near = |x: f64| SNAP * axis.size(cell(x)) / f64::from(n) + precision * x.abs();
        if from < axis.first() - near(from) || to > axis.last() + near(to) {
            return Err(format!(
                "the body reaches from {from} to {to} along {along}, outside the mesh from {} to {}",
                axis.first(),
                axis.last()
            ));
        }
        let inner = from + near(from);
        let (first, last) = (cell(inner), cell((to - near(to)).max(inner)));
        let count = f64::from(last + 1 - first) * f64::from(n);
        if count > MOST_PIECES {
            return Err(format!("{count:e} material points along {along} are too many"));
        }
        let what = format_args!("{count:e} material points along {along}");
        memory.check(what, count, size_of::<f64>() + size_of::<u32>())?;
        self.lines[d] = vec![axis.node(first)];
        for cell in first..=last {
            let (low, high) = (axis.node(cell), axis.node(cell + 1));
            self.lines[d].extend((1..n).map(|k| low + (high - low) * f64::from(k) / f64::from(n)));
            self.lines[d].push(high);
            self.cells[d].extend((0..n).map(|_| cell));
        }
        Ok(())
    }

    fn snapped(&self, surface: &Triangles) -> Triangles {
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

    pub(crate) fn centre(&self, piece: &[usize; 3]) -> Vector3<f64> {
        Vector3::from_fn(|d, _| 0.5 * (self.lines[d][piece[d]] + self.lines[d][piece[d] + 1]))
    }

    pub(crate) fn half(&self, piece: &[usize; 3]) -> Vector3<f64> {
        Vector3::from_fn(|d, _| 0.5 * (self.lines[d][piece[d] + 1] - self.lines[d][piece[d]]))
    }

    pub(crate) fn volume(&self, piece: &[usize; 3]) -> f64 {
        8.0 * self.half(piece).product()
    }

    /// What every piece holds, z slowest and x fastest.
    pub(crate) fn held(&self, surface: &Triangles, memory: MemoryLimit) -> Result<Vec<Held>, String> {
        let [nx, ny, _] = [0, 1, 2].map(|d| (self.lines[d].len() - 1) as f64);
        memory.check("a layer of pieces around the body", nx * ny, moments::BYTES_IN_LAYER)?;
        // No piece holds more than the largest of them.
        let longest = |lines: &Vec<f64>| lines.windows(2).map(|ends| ends[1] - ends[0]).fold(0.0, f64::max);
        let volume = self.volume_left(surface).unwrap_or_else(|| surface.volume());
        let least = volume / self.lines.iter().map(longest).product::<f64>();
        check_pieces((least * (1.0 - ROUNDING)).floor(), memory)?;
        let most = memory.most(BYTES_OF_PIECE);
        let mut held = Vec::new();
        let mut more = 0_usize;
        let mut wrong = None;
        let (lines, before) = self.with_margins(surface);
        moments::for_each(surface, &lines, |piece, moments| {
            let Some(piece) = self.inside(piece, before, None) else { return };
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
            None => check_pieces((held.len() + more) as f64, memory).map(|()| held),
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
    pub(crate) fn merge_slivers(&self, held: &mut Vec<Held>) -> Vec<([usize; 3], [usize; 3])> {
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
}

/// Refuses more pieces of a body than there is room for.
pub(crate) fn check_pieces(count: f64, memory: MemoryLimit) -> Result<(), String> {
    memory.check(format_args!("{count:.3e} pieces of the body"), count, BYTES_OF_PIECE)
}
