//! Named sets of nodes, by the geometry of the layout at rest.

use std::array::from_fn;
use std::ops::Range;

use crate::layout::Layout;
use crate::mesh::Mesh;
use crate::node_space::NodeSpace;
use crate::splines::{NodeKind, NodeLine};
use crate::{Lattice, NodeId, Vector};

/// Nodes are in a region up to this share of the smallest cell edge beside them.
const TOLERANCE: f64 = 1e-9;

/// A set of nodes, described by where they stand at rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Region<const D: usize> {
    /// All nodes.
    Everywhere,
    /// Nodes with one coordinate given; empty for a direction that space does not have.
    Plane {
        /// Direction, from 0.
        axis: usize,
        /// Coordinate `[L]`.
        at: f64,
    },
    /// Nodes between two opposite corners, boundary included; infinite corners leave it open.
    Box {
        /// Lower corner `[L]`.
        from: Vector<D>,
        /// Upper corner `[L]`.
        to: Vector<D>,
    },
    /// The node that stands at a position `[L]`.
    Point(Vector<D>),
    /// Nodes at a distance from a centre; in three dimensions on a cylinder along the third axis.
    Circle {
        /// Centre `[L]`, in the plane of the first two coordinates.
        centre: [f64; 2],
        /// Distance `[L]` from it.
        radius: f64,
    },
    /// Nodes between two distances from a centre, both included; in three dimensions between two
    /// cylinders along the third axis.
    Annulus {
        /// Centre `[L]`, in the plane of the first two coordinates.
        centre: [f64; 2],
        /// Smallest distance `[L]`.
        inner: f64,
        /// Largest distance `[L]`.
        outer: f64,
    },
    /// Nodes on a half line from a centre, itself included; in three dimensions on a half plane that ends
    /// in the line through the centre along the third axis.
    Ray {
        /// Centre `[L]`, in the plane of the first two coordinates.
        centre: [f64; 2],
        /// Direction in which it goes, unit length.
        along: [f64; 2],
    },
    /// Nodes in all of several regions; everywhere where there are none.
    All(Vec<Region<D>>),
}

impl<const D: usize> Region<D> {
    /// The nodes of a space on this layout that stand in the region at rest, ascending.
    ///
    /// In a box the search is confined to the part of the lattice that can belong to the region.
    pub fn nodes(&self, space: &NodeSpace<D>, layout: &Layout<D>) -> Vec<NodeId> {
        match layout {
            Layout::Box { axes, .. } => self.nodes_of_box(space.lattice(), &space.axis_lines(axes)),
            Layout::Ring { .. } => self.nodes_of_ring(space, layout),
        }
    }

    /// Nodes among which [`Self::nodes`] seeks: its cost, and at least as many as it finds.
    pub fn candidates(&self, space: &NodeSpace<D>, layout: &Layout<D>) -> f64 {
        match layout {
            Layout::Box { axes, .. } => {
                self.ranges(&space.axis_lines(axes)).iter().map(|range| range.len() as f64).product()
            }
            Layout::Ring { .. } => space.lattice().n_nodes() as f64,
        }
    }

    /// Indices of the nodes of a box that can belong to the region.
    fn ranges(&self, lines: &[NodeLine<'_>; D]) -> [Range<u32>; D] {
        let mut ranges = from_fn(|d| 0..lines[d].len());
        self.confine(lines, &mut ranges);
        ranges
    }

    fn nodes_of_box(&self, lattice: &Lattice<D>, lines: &[NodeLine<'_>; D]) -> Vec<NodeId> {
        let ranges = self.ranges(lines);
        if ranges.iter().any(Range::is_empty) {
            return Vec::new();
        }
        let mut nodes = Vec::new();
        let mut index: [u32; D] = from_fn(|d| ranges[d].start);
        loop {
            let x = Vector::from_fn(|d, _| lines[d].at(index[d]));
            let edges = (0..D).map(|d| lines[d].finest_at(index[d]));
            // The ranges decide all but circles and rays, which see the tolerance of their cell.
            if self.on_oblique(&x, TOLERANCE * edges.fold(f64::INFINITY, f64::min)) {
                nodes.push(lattice.node(index));
            }
            let Some(d) = (0..D).find(|&d| index[d] + 1 < ranges[d].end) else {
                return nodes;
            };
            index[d] += 1;
            for lower in 0..d {
                index[lower] = ranges[lower].start;
            }
        }
    }

    /// Control points of splines count as if they stood on the circles of their radii: those of the innermost and the
    /// outermost circle hold these circles.
    fn nodes_of_ring(&self, space: &NodeSpace<D>, layout: &Layout<D>) -> Vec<NodeId> {
        let Layout::Ring { centre, radii, sectors, span, height, .. } = layout else {
            return Vec::new();
        };
        let (mesh, lattice) = (Mesh::at_rest(layout), space.lattice());
        let (radii, height) = (space.line_on(radii), height.as_ref().map(|it| space.line_on(it)));
        let half = 0.5 * span.step(*sectors);
        let chord = 2.0 * half.sin();
        let all = (0..lattice.n_nodes()).filter_map(NodeId::from_index);
        all.filter(|&node| {
            let index = lattice.node_index(node);
            let edge = radii.finest_at(index[1]).min(radii.at(index[1]) * chord);
            let layer = height.map_or(edge, |z| z.finest_at(index[D - 1]));
            let mut x = space.position(&mesh, node);
            if space.kind() != NodeKind::Vertices {
                (0..2).for_each(|d| x[d] = centre[d] + (x[d] - centre[d]) * half.cos());
            }
            self.contains(&x, TOLERANCE * edge.min(layer))
        })
        .collect()
    }

    /// Narrows ranges of node indices to those that can belong to the region.
    fn confine(&self, lines: &[NodeLine<'_>; D], ranges: &mut [Range<u32>; D]) {
        let mut to = |d: usize, low: f64, high: f64| {
            let allowed = lines[d].within(low, high, TOLERANCE);
            ranges[d] = ranges[d].start.max(allowed.start)..ranges[d].end.min(allowed.end);
        };
        match self {
            Self::Everywhere => {}
            Self::Plane { axis, at } if *axis < D => to(*axis, *at, *at),
            Self::Plane { .. } => ranges[0] = 0..0,
            Self::Box { from, to: upper } => (0..D).for_each(|d| to(d, from[d], upper[d])),
            Self::Point(x) => (0..D).for_each(|d| to(d, x[d], x[d])),
            Self::Circle { centre, radius } => {
                (0..D.min(2)).for_each(|d| to(d, centre[d] - radius, centre[d] + radius));
            }
            Self::Annulus { centre, outer, .. } => {
                (0..D.min(2)).for_each(|d| to(d, centre[d] - outer, centre[d] + outer));
            }
            Self::Ray { centre, along } => (0..D.min(2)).for_each(|d| {
                // Towards where it goes, however slowly.
                let low = if along[d] < 0.0 { f64::NEG_INFINITY } else { centre[d] };
                let high = if along[d] > 0.0 { f64::INFINITY } else { centre[d] };
                to(d, low, high);
            }),
            Self::All(regions) => regions.iter().for_each(|r| r.confine(lines, ranges)),
        }
    }

    fn on_oblique(&self, x: &Vector<D>, tolerance: f64) -> bool {
        match self {
            Self::Circle { .. } | Self::Annulus { .. } | Self::Ray { .. } => self.contains(x, tolerance),
            Self::All(regions) => regions.iter().all(|r| r.on_oblique(x, tolerance)),
            _ => true,
        }
    }

    /// Whether a position is in the region, up to a tolerance `[L]`.
    fn contains(&self, x: &Vector<D>, tolerance: f64) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Plane { axis, at } => *axis < D && (x[*axis] - at).abs() <= tolerance,
            Self::Box { from, to } => (0..D).all(|d| x[d] >= from[d] - tolerance && x[d] <= to[d] + tolerance),
            Self::Point(point) => (0..D).all(|d| (x[d] - point[d]).abs() <= tolerance),
            Self::Circle { centre, radius } => (distance(x, centre) - radius).abs() <= tolerance,
            Self::Annulus { centre, inner, outer } => {
                let distance = distance(x, centre);
                distance >= inner - tolerance && distance <= outer + tolerance
            }
            Self::Ray { centre, along } => {
                let [dx, dy] = from_centre(x, centre);
                let across = along[0] * dy - along[1] * dx;
                across.abs() <= tolerance && along[0] * dx + along[1] * dy >= -tolerance
            }
            Self::All(regions) => regions.iter().all(|r| r.contains(x, tolerance)),
        }
    }
}

/// Distance from a centre in the plane of the first two coordinates.
fn distance<const D: usize>(x: &Vector<D>, centre: &[f64; 2]) -> f64 {
    let [dx, dy] = from_centre(x, centre);
    dx.hypot(dy)
}

fn from_centre<const D: usize>(x: &Vector<D>, centre: &[f64; 2]) -> [f64; 2] {
    [x[0] - centre[0], if D == 1 { 0.0 } else { x[1] - centre[1] }]
}
