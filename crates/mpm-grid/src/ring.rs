//! Rings of nodes as placed by a motion: radii and tables of angles instead of positions.

use std::array::from_fn;
use std::f64::consts::{PI, TAU};

use crate::axis::{SNAP, snap};
use crate::cell::{LinearCell, inverse};
use crate::index::{to_usize, whole};
use crate::layout::{Layout, Span};
use crate::location::{Place, outside};
use crate::motion::Reindexing;
use crate::placed::{PlacedMotion, cos_sin, reduce, rotate};
use crate::splines::{HighestDerivatives, Line, NodeLine};
use crate::{Axis, Block, Lattice, Vector};

/// Node (i, j[, k]) stands at radius r_j and angle θ_i + α_j about the centre, at height z_k.
///
/// Everything happens in the plane; the third direction is a separate axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedRing {
    centre: [f64; 2],
    radii: Axis,
    sectors: u32,
    span: Span,
    height: Option<Axis>,
    /// (cos, sin) of θ_i at rest.
    lines: Vec<[f64; 2]>,
    /// α_j and its (cos, sin).
    turns: Vec<(f64, [f64; 2])>,
}

/// Angles of rings, from the innermost on, less whole sectors.
fn reindexed(mut angles: Vec<f64>, sector: f64, by: Reindexing) -> Vec<f64> {
    match by {
        Reindexing::Off => {}
        Reindexing::WholeCells => angles.iter_mut().for_each(|angle| *angle = reduce(*angle, sector)),
        Reindexing::Neighbours => {
            let mut outside: Option<(f64, f64)> = None;
            for angle in angles.iter_mut().rev() {
                let now = match outside {
                    None => reduce(*angle, sector),
                    Some((before, now)) => now + reduce(*angle - before, sector),
                };
                outside = Some((*angle, now));
                *angle = now;
            }
        }
    }
    angles
}

impl PlacedRing {
    /// The ring of a layout under a motion; `None` for a layout or a motion of boxes, and where
    /// the motion folds cells.
    pub(crate) fn new<const D: usize>(
        layout: &Layout<D>,
        motion: &PlacedMotion<D>,
        reindexing: Reindexing,
    ) -> Option<Self> {
        let Layout::Ring { centre, radii, sectors, span, height, .. } = layout else {
            return None;
        };
        let step = span.step(*sectors);
        let angle = |radius: f64| match motion {
            PlacedMotion::Rest | PlacedMotion::Expand { .. } => Some(0.0),
            PlacedMotion::Rotation { angle, .. } => Some(*angle),
            PlacedMotion::Twist { profile, .. } => Some(profile.angle(radius)),
            _ => None,
        };
        let angles: Option<Vec<f64>> = (0..=radii.cells()).map(|j| angle(radii.node(j))).collect();
        let angles = reindexed(angles?, step, reindexing);
        let centre = match motion {
            PlacedMotion::Rotation { centre: about, cos_sin, .. } => {
                let moved = rotate(&Vector::<2>::from(*centre), about, *cos_sin);
                [moved[0], moved[1]]
            }
            _ => *centre,
        };
        let along = match motion {
            PlacedMotion::Twist { along, .. } => *along,
            _ => None,
        };
        let height = match (height, along) {
            (Some(axis), Some(along)) => Some(along.respaced(axis)?),
            (axis, _) => axis.clone(),
        };
        let radii_now = match motion {
            PlacedMotion::Expand { squares, .. } => squares.axis(radii)?,
            _ => radii.clone(),
        };
        let n_lines = if span.is_full() { *sectors } else { *sectors + 1 };
        let line = |i: u32| cos_sin(span.start() + f64::from(i) * step);
        let ring = Self {
            centre,
            radii: radii_now,
            sectors: *sectors,
            span: *span,
            height,
            lines: (0..n_lines).map(line).collect(),
            turns: angles.into_iter().map(|a| (a, cos_sin(a))).collect(),
        };
        // Cells between the same two rings of nodes are congruent: one of each is enough.
        let valid = (0..radii.cells()).all(|j| ring.plane_cell(0, j).is_valid(layout.hand()));
        valid.then_some(ring)
    }

    /// The section of a ring with a height.
    pub(crate) fn without_height(&self) -> Self {
        Self { height: None, ..self.clone() }
    }

    /// Position `[L]` of the node at a multi-index.
    #[inline]
    pub(crate) fn position<const D: usize>(&self, index: &[u32; D]) -> Vector<D> {
        let plane = self.plane_position(index[0], index[1]);
        Vector::from_fn(|d, _| match d {
            0 | 1 => plane[d],
            _ => self.height.as_ref().map_or(0.0, |z| z.node(index[d])),
        })
    }

    #[inline]
    fn plane_position(&self, line: u32, ring: u32) -> Vector<2> {
        let r = self.radii.node(ring);
        let [c, s] = self.lines[to_usize(line)];
        let (_, [ca, sa]) = self.turns[to_usize(ring)];
        let (x, y) = (c * ca - s * sa, s * ca + c * sa);
        Vector::<2>::new(self.centre[0] + r * x, self.centre[1] + r * y)
    }

    /// The section of the cells between lines `line`, `line + 1` and rings `ring`, `ring + 1`.
    #[inline]
    fn plane_cell(&self, line: u32, ring: u32) -> LinearCell<2> {
        let next = if to_usize(line) + 1 == self.lines.len() { 0 } else { line + 1 };
        let mut corners = [Vector::zeros(); 8];
        corners[0] = self.plane_position(line, ring);
        corners[1] = self.plane_position(next, ring);
        corners[2] = self.plane_position(line, ring + 1);
        corners[3] = self.plane_position(next, ring + 1);
        LinearCell::new(corners)
    }

    /// (∂ξ/∂x)ᵀ at a place.
    #[inline]
    pub(crate) fn push_gradients<const D: usize>(&self, place: &Place<D>) -> Block<D> {
        let [line, ring] = [place.cell[0], place.cell[1]];
        let local = Vector::<2>::new(place.local[0], place.local[1]);
        let plane = inverse(&self.plane_cell(line, ring).jacobian(&local));
        let mut push = Block::zeros();
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            push[(i, j)] = plane[(j, i)];
        }
        if let Some(z) = &self.height {
            push[(D - 1, D - 1)] = 2.0 * z.per_size(place.cell[D - 1]);
        }
        push
    }

    /// The place of `x`, found by inverting the map of one cell after another from `start` on,
    /// across `most` of them, going where the local coordinate points.
    ///
    /// Local coordinates are continued outside the mesh. If no cell's map reaches `x`, the error
    /// is an estimate of the distance in cells.
    pub(crate) fn walk<const D: usize>(
        &self,
        lattice: &Lattice<D>,
        x: &Vector<D>,
        start: [u32; D],
        most: usize,
    ) -> Result<Place<D>, f64> {
        let section = Vector::<2>::new(x[0], x[1]);
        let mut cell = start;
        let mut distance = f64::INFINITY;
        for _ in 0..most {
            let map = self.plane_cell(cell[0], cell[1]);
            let exact = map.local(&section);
            let local = exact.unwrap_or_else(|| map.estimate(&section));
            distance = outside(&local);
            if let Some(next) = next_cell(lattice, &cell, &local) {
                cell = next;
            } else if exact.is_some() {
                return Ok(self.settle(lattice, x, cell, local));
            } else {
                break;
            }
        }
        Err(distance)
    }

    /// Snaps local coordinates and hands a position on a lower face to the lower cell; cells
    /// share the map of their common face. The third coordinate is read off its axis.
    fn settle<const D: usize>(
        &self,
        lattice: &Lattice<D>,
        x: &Vector<D>,
        mut cell: [u32; D],
        plane: Vector<2>,
    ) -> Place<D> {
        let mut local = Vector::zeros();
        for d in 0..2 {
            local[d] = snap(plane[d]);
            if local[d] == -1.0
                && let Some(lower) = lattice.below(cell, d)
            {
                cell = lower;
                local[d] = 1.0;
            }
        }
        if let Some(z) = &self.height {
            (cell[D - 1], local[D - 1]) = z.locate(x[D - 1]);
        }
        Place { cell, local }
    }

    /// A cell at or near `x`: exact, up to rounding, in an untwisted ring.
    pub(crate) fn guess<const D: usize>(&self, x: &Vector<D>) -> [u32; D] {
        let (dx, dy) = (x[0] - self.centre[0], x[1] - self.centre[1]);
        let (r, theta) = ((dx * dx + dy * dy).sqrt(), dy.atan2(dx));
        let step = self.span.step(self.sectors);
        let (mut rho, mut line, mut ring) = (r, 0, 0);
        for _ in 0..2 {
            let local;
            (ring, local) = self.radii.locate(rho);
            let t = (0.5 * (local + 1.0)).clamp(0.0, 1.0);
            let [below, above] = [ring, ring + 1].map(|j| self.turns[to_usize(j)].0);
            let sector = self.sector(theta - (below * (1.0 - t) + above * t));
            line = whole(sector, self.sectors);
            // Straight edges: of a chord, the distance from the centre is that of its middle.
            let from_middle = (sector - f64::from(line) - 0.5).clamp(-0.5, 0.5) * step;
            rho = r * from_middle.cos() / (0.5 * step).cos();
        }
        from_fn(|d| match d {
            0 => line,
            1 => ring,
            _ => 0,
        })
    }

    /// Angle at rest in units of sectors from the first line; in [0, n) for a full ring, and for
    /// an open one as close to its middle as whole turns permit.
    fn sector(&self, theta: f64) -> f64 {
        let step = self.span.step(self.sectors);
        let n = f64::from(self.sectors);
        let angle = theta - self.span.start();
        if self.span.is_full() {
            (angle / step).rem_euclid(n)
        } else {
            let middle = 0.5 * n * step;
            (middle - PI + (angle - middle + PI).rem_euclid(TAU)) / step
        }
    }
}

/// Rings of circles, which splines describe exactly: cells between two angles and two radii, all turned alike.
impl PlacedRing {
    fn step(&self) -> f64 {
        self.span.step(self.sectors)
    }

    /// Angle, and (cos, sin) of it, and radius at a place.
    #[inline]
    fn polar<const D: usize>(&self, place: &Place<D>) -> ([f64; 2], f64) {
        let [line, ring] = [place.cell[0], place.cell[1]];
        let share = place.local.map(|it| 0.5 * (1.0 + it));
        let angle = self.turns[0].0 + self.span.start() + (f64::from(line) + share[0]) * self.step();
        let (low, high) = (self.radii.node(ring), self.radii.node(ring + 1));
        (cos_sin(angle), low + (high - low) * share[1])
    }

    /// The place of `x` by its angle and radius.
    #[inline]
    pub(crate) fn place_round<const D: usize>(&self, lattice: &Lattice<D>, x: &Vector<D>) -> Place<D> {
        let (dx, dy) = (x[0] - self.centre[0], x[1] - self.centre[1]);
        let sector = self.sector(dy.atan2(dx) - self.turns[0].0);
        let line = whole(sector, self.sectors);
        let (ring, radial) = self.radii.locate((dx * dx + dy * dy).sqrt());
        let cell = from_fn(|d| [line, ring, 0][d]);
        let plane = Vector::<2>::new(2.0 * (sector - f64::from(line)) - 1.0, radial);
        self.settle(lattice, x, cell, plane)
    }

    /// Position `[L]` of a place.
    pub(crate) fn round_position<const D: usize>(&self, place: &Place<D>) -> Vector<D> {
        let ([cos, sin], radius) = self.polar(place);
        Vector::from_fn(|d, _| match d {
            0 => self.centre[0] + radius * cos,
            1 => self.centre[1] + radius * sin,
            _ => self.height.as_ref().map_or(0.0, |z| {
                let (low, high) = (z.node(place.cell[d]), z.node(place.cell[d] + 1));
                low + (high - low) * (0.5 * (1.0 + place.local[d]))
            }),
        })
    }

    /// Position `[L]` of a control point: half a sector before its line, outside the circle of its Greville radius, so that
    /// the splines reproduce circles.
    #[inline]
    pub(crate) fn control_position<const D: usize>(&self, degree: u32, index: &[u32; D]) -> Vector<D> {
        let half = 0.5 * self.step();
        let angle = self.turns[0].0 + self.span.start() + f64::from(index[0]) * self.step() - half;
        let [cos, sin] = cos_sin(angle);
        let radius = NodeLine { axis: &self.radii, degree }.at(index[1]) / half.cos();
        Vector::from_fn(|d, _| match d {
            0 => self.centre[0] + radius * cos,
            1 => self.centre[1] + radius * sin,
            _ => self.height.as_ref().map_or(0.0, |axis| NodeLine { axis, degree }.at(index[d])),
        })
    }

    /// The splines of a direction at a place.
    #[inline]
    pub(crate) fn line<const D: usize>(&self, degree: u32, direction: usize, place: &Place<D>) -> Line {
        let (cell, local) = (place.cell[direction], place.local[direction]);
        match (direction, &self.height) {
            (0, _) => Line::round_ring(self.step(), local),
            (2, Some(height)) => Line::on_axis(degree, height, cell, local),
            _ => Line::on_axis(degree, &self.radii, cell, local),
        }
    }

    /// What turns derivatives by angle, radius and height at a place into gradients.
    pub(crate) fn round_push<const D: usize>(&self, place: &Place<D>) -> Block<D> {
        let ([cos, sin], radius) = self.polar(place);
        Block::from_fn(|i, j| match (i, j) {
            (0, 0) => -sin / radius,
            (1, 0) => cos / radius,
            (0, 1) => cos,
            (1, 1) => sin,
            _ => f64::from(u8::from(i == j)),
        })
    }

    pub(crate) fn highest_derivatives(
        &self,
        degree: u32,
        direction: usize,
        cell: u32,
        at_end: bool,
    ) -> HighestDerivatives {
        match (direction, &self.height) {
            (0, _) => HighestDerivatives::round_ring(self.step(), at_end),
            (2, Some(height)) => HighestDerivatives::on_axis(degree, height, cell),
            _ => HighestDerivatives::on_axis(degree, &self.radii, cell),
        }
    }
}

/// The neighbour in the plane across the face that `local` lies farthest beyond, if there is one.
fn next_cell<const D: usize>(lattice: &Lattice<D>, cell: &[u32; D], local: &Vector<2>) -> Option<[u32; D]> {
    let (mut farthest, mut next) = (SNAP, None);
    for d in 0..2 {
        let over = local[d].abs() - 1.0;
        if over > farthest {
            let neighbour = if local[d] > 0.0 { lattice.above(*cell, d) } else { lattice.below(*cell, d) };
            if neighbour.is_some() {
                (farthest, next) = (over, neighbour);
            }
        }
    }
    next
}
