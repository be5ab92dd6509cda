//! Where the nodes of a lattice sit at rest: in a box, or on rings.

use std::f64::consts::{PI, TAU};

use crate::cell::LinearCell;
use crate::index::NodeId;
use crate::lattice::{Lattice, LatticeError};
use crate::splines::{HIGHEST, NodeKind, Splines};
use crate::{Axis, Vector};

/// Fewest sectors of a ring with splines.
const FEWEST_SECTORS: u32 = 4;

/// Positions of lattice nodes before any motion.
///
/// Only the checked constructors make one, so that every layout has a lattice.
#[derive(Clone, Debug, PartialEq)]
pub enum Layout<const D: usize> {
    /// A rectilinear grid, graded or uniform; lattice directions are the axes.
    #[non_exhaustive]
    Box {
        /// Node coordinates per direction.
        axes: [Axis; D],
        /// The nodes on which its functions live.
        functions: NodeKind,
    },
    /// Concentric rings of nodes joined by straight edges (so a polygon); lattice directions
    /// are (θ, r) or (θ, r, z), θ fastest and anticlockwise. This is a left-handed order: the
    /// Jacobian determinants of its cells are negative.
    #[non_exhaustive]
    Ring {
        /// Centre of the rings `[L]`, in the plane of the first two coordinates.
        centre: [f64; 2],
        /// Radii of the rings of nodes `[L]`.
        radii: Axis,
        /// Number of cells along θ.
        sectors: u32,
        /// The angles covered.
        span: Span,
        /// Node coordinates along the third direction; present exactly where D = 3.
        height: Option<Axis>,
        /// The nodes on which its functions live; with splines the ring is one of circles, not of polygons.
        functions: NodeKind,
    },
}

/// The angles that a ring covers, from the first coordinate direction, anticlockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// All of them, the first line of nodes at angle 0; θ is a periodic direction.
    Full,
    /// From one angle to a larger one `[rad]`, less than a full turn.
    Sector {
        /// Angle of the first line of nodes.
        from: f64,
        /// Angle of the last line of nodes.
        to: f64,
    },
}

/// What a layout cannot be made of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// The lattice itself is impossible.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A ring whose innermost nodes would coincide.
    #[error("the inner radius of a ring must be positive, not {radius}")]
    InnerRadius {
        /// The offending radius.
        radius: f64,
    },
    /// A layer of a mesh whose functions are splines.
    #[error("a layer has the functions of vertices, not splines")]
    LayerOfSplines,
    /// A ring centre that is not finite.
    #[error("the centre of a ring must be finite, not {centre:?}")]
    Centre {
        /// The offending centre.
        centre: [f64; 2],
    },
    /// An angular sector that is empty, exceeds a turn, or has cells of half a turn or more.
    #[error(
        "a sector of {sectors} cells cannot span the angles from {} to {} degrees, expected more than 0 and less than \
         180 degrees a cell, and less than a turn in all",
        from.to_degrees(), to.to_degrees()
    )]
    Sector {
        /// Angle of the first line of nodes `[rad]`.
        from: f64,
        /// Angle of the last line of nodes `[rad]`.
        to: f64,
        /// Number of cells along θ.
        sectors: u32,
    },
    /// Numbers so large, small or close together that cells have no volume.
    #[error(
        "the cells of a ring with radii {inner} to {outer} about {centre:?} have no volume that can be computed"
    )]
    Flat {
        /// Radius of the innermost nodes.
        inner: f64,
        /// Radius of the outermost nodes.
        outer: f64,
        /// Centre.
        centre: [f64; 2],
    },
    /// Splines of a degree that there is not.
    #[error("expected a degree from 1 to {HIGHEST}, got {degree}")]
    Degree {
        /// The degree asked for.
        degree: u32,
    },
    /// Splines on a sector of a ring.
    #[error("splines need a full ring: there are none on a sector")]
    SplinesOnSector,
    /// Splines on a ring of few sectors.
    #[error("splines need a ring of at least {least} sectors, got {sectors}")]
    SplineSectors {
        /// Sectors of the ring.
        sectors: u32,
        /// Fewest possible.
        least: u32,
    },
    /// A height axis in two dimensions, or none in three, or a ring on a line.
    #[error("a ring in {dimensions} dimensions {}", height_rule(*.dimensions))]
    Height {
        /// D.
        dimensions: usize,
    },
}

fn height_rule(dimensions: usize) -> &'static str {
    match dimensions {
        1 => "does not exist",
        2 => "has no height axis",
        _ => "needs a height axis",
    }
}

impl Span {
    /// Angle of the first line of nodes `[rad]`.
    pub fn start(self) -> f64 {
        match self {
            Self::Full => 0.0,
            Self::Sector { from, .. } => from,
        }
    }

    /// Angle `[rad]` between neighbouring lines of nodes.
    pub fn step(self, sectors: u32) -> f64 {
        let angle = match self {
            Self::Full => TAU,
            Self::Sector { from, to } => to - from,
        };
        angle / f64::from(sectors)
    }

    /// Whether the span closes on itself.
    pub fn is_full(self) -> bool {
        self == Self::Full
    }
}

impl<const D: usize> Layout<D> {
    /// A rectilinear grid on the given axes.
    pub fn on_axes(axes: [Axis; D]) -> Result<Self, LayoutError> {
        Lattice::new(axes.each_ref().map(Axis::cells), [false; D])?;
        Ok(Self::Box { axes, functions: NodeKind::Vertices })
    }

    /// Rings of nodes at the given radii.
    pub fn ring(
        centre: [f64; 2],
        radii: Axis,
        sectors: u32,
        span: Span,
        height: Option<Axis>,
    ) -> Result<Self, LayoutError> {
        if D == 1 || height.is_some() != (D == 3) {
            return Err(LayoutError::Height { dimensions: D });
        }
        if !centre.iter().all(|c| c.is_finite()) {
            return Err(LayoutError::Centre { centre });
        }
        if radii.first() <= 0.0 {
            return Err(LayoutError::InnerRadius { radius: radii.first() });
        }
        if let Span::Sector { from, to } = span {
            let turn = to - from;
            let possible = turn > 0.0 && turn < TAU && turn < PI * f64::from(sectors);
            if !(possible && from.is_finite()) {
                return Err(LayoutError::Sector { from, to, sectors });
            }
        }
        ring_lattice::<D>(&radii, sectors, span, height.as_ref())?;
        let (inner, outer) = (radii.first(), radii.last());
        let layout = Self::Ring { centre, radii, sectors, span, height, functions: NodeKind::Vertices };
        if layout.has_valid_cells() { Ok(layout) } else { Err(LayoutError::Flat { inner, outer, centre }) }
    }

    /// The same grid with B-splines of a degree from 1 to 3 as its functions; those of degree 1 are the linear functions
    /// of the vertices, except for a ring, which stays one of polygons then.
    ///
    /// # Errors
    /// Another degree, splines on a sector or on fewer than four sectors, or more control points than can be numbered.
    pub fn with_splines(mut self, degree: u32) -> Result<Self, LayoutError> {
        if !(1..=HIGHEST).contains(&degree) {
            return Err(LayoutError::Degree { degree });
        }
        if degree == 1 {
            return Ok(self);
        }
        if let Self::Ring { sectors, span, .. } = &self {
            if !span.is_full() {
                return Err(LayoutError::SplinesOnSector);
            }
            if *sectors < FEWEST_SECTORS {
                return Err(LayoutError::SplineSectors { sectors: *sectors, least: FEWEST_SECTORS });
            }
        }
        let splines = Splines::on(&self.lattice(), degree)?;
        match &mut self {
            Self::Box { functions, .. } | Self::Ring { functions, .. } => *functions = splines.kind(),
        }
        Ok(self)
    }

    /// The same layout with the lines between its outer ones moved by a part of a cell, above 0 and below 1, but for those along
    /// the radii of a ring: domains that fill cells reach over the lines then, as they do once bodies have moved.
    #[must_use]
    pub fn with_lines_moved(&self, part: f64) -> Self {
        let mut moved = self.clone();
        match &mut moved {
            Self::Box { axes, .. } => *axes = axes.each_ref().map(|axis| axis.with_lines_moved(part)),
            Self::Ring { radii, height, .. } => {
                *radii = radii.with_lines_moved(part);
                *height = height.as_ref().map(|height| height.with_lines_moved(part));
            }
        }
        if moved.has_valid_cells() { moved } else { self.clone() }
    }

    /// The nodes on which its functions live: vertices, or the control points of splines.
    pub fn functions(&self) -> NodeKind {
        match self {
            Self::Box { functions, .. } | Self::Ring { functions, .. } => *functions,
        }
    }

    /// The arrangement of vertices and cells.
    pub fn lattice(&self) -> Lattice<D> {
        let lattice = match self {
            Self::Box { axes, .. } => Lattice::new(axes.each_ref().map(Axis::cells), [false; D]),
            Self::Ring { radii, sectors, span, height, .. } => {
                ring_lattice(radii, *sectors, *span, height.as_ref())
            }
        };
        lattice.expect("the constructors of a layout have built this lattice before")
    }

    /// Position `[L]` of a vertex at rest.
    pub fn position(&self, node: NodeId) -> Vector<D> {
        let index = self.lattice().node_index(node);
        match self {
            Self::Box { axes, .. } => Vector::from_fn(|d, _| axes[d].node(index[d])),
            Self::Ring { centre, radii, sectors, span, height, .. } => {
                let r = radii.node(index[1]);
                let angle = span.start() + f64::from(index[0]) * span.step(*sectors);
                Vector::from_fn(|d, _| match d {
                    0 => centre[0] + r * angle.cos(),
                    1 => centre[1] + r * angle.sin(),
                    _ => height.as_ref().map_or(0.0, |z| z.node(index[d])),
                })
            }
        }
    }

    /// Where the lattice lines of each direction stand at rest `[L]`: along an axis, or as lengths of the arc
    /// halfway between the inner and the outer radius.
    pub fn lines(&self) -> [Vec<f64>; D] {
        let along = |axis: &Axis| (0..=axis.cells()).map(|i| axis.node(i)).collect();
        let nodes = self.lattice().nodes();
        std::array::from_fn(|d| match self {
            Self::Box { axes, .. } => along(&axes[d]),
            Self::Ring { radii, .. } if d == 1 => along(radii),
            Self::Ring { radii, sectors, span, .. } if d == 0 => {
                let arc = span.step(*sectors) * 0.5 * (radii.first() + radii.last());
                (0..nodes[0]).map(|i| f64::from(i) * arc).collect()
            }
            Self::Ring { height, .. } => height.as_ref().map_or_else(Vec::new, along),
        })
    }

    /// Sign of the Jacobian determinants of the cells: 1 in a box, -1 in a ring.
    pub fn hand(&self) -> f64 {
        match self {
            Self::Box { .. } => 1.0,
            Self::Ring { .. } => -1.0,
        }
    }

    /// Whether the cells have areas that can be computed. In a ring, cells between the same two rings of nodes
    /// are congruent: one of each is enough.
    fn has_valid_cells(&self) -> bool {
        let Self::Ring { centre, radii, sectors, span, .. } = self else { return true };
        let corner = |line: u32, ring: u32| {
            let (radius, angle) = (radii.node(ring), span.start() + f64::from(line) * span.step(*sectors));
            Vector::<2>::new(centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin())
        };
        (0..radii.cells()).all(|ring| {
            let mut corners = [Vector::zeros(); 8];
            let quadrilateral = [(0, ring), (1, ring), (0, ring + 1), (1, ring + 1)];
            for (position, (line, ring)) in corners.iter_mut().zip(quadrilateral) {
                *position = corner(line, ring);
            }
            LinearCell::new(corners).is_valid(self.hand())
        })
    }
}

fn ring_lattice<const D: usize>(
    radii: &Axis,
    sectors: u32,
    span: Span,
    height: Option<&Axis>,
) -> Result<Lattice<D>, LatticeError> {
    let cells = std::array::from_fn(|d| match d {
        0 => sectors,
        1 => radii.cells(),
        _ => height.map_or(1, Axis::cells),
    });
    Lattice::new(cells, std::array::from_fn(|d| d == 0 && span.is_full()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inner_lines_move_by_a_part_of_a_cell() {
        let axes = || [Axis::uniform(0.0, 2.0, 2).unwrap(), Axis::graded(vec![0.0, 1.0, 3.0, 4.0]).unwrap()];
        let moved = Layout::<2>::on_axes(axes()).unwrap().with_lines_moved(0.25);
        assert_eq!(moved.lines(), [vec![0.0, 1.25, 2.0], vec![0.0, 1.5, 3.25, 4.0]]);
        let [_, height] = axes();
        let radii = Axis::uniform(1.0, 2.0, 2).unwrap();
        let ring = Layout::<3>::ring([0.0; 2], radii, 8, Span::Full, Some(height)).unwrap();
        let moved = ring.with_lines_moved(0.25).lines();
        assert_eq!(moved[1..], [vec![1.0, 1.625, 2.0], vec![0.0, 1.5, 3.25, 4.0]]);
        assert_eq!(moved[0].len(), ring.lines()[0].len());
    }

    #[test]
    fn impossible_rings_are_refused() {
        let radii = || Axis::uniform(1.0, 2.0, 2).unwrap();
        let ring = |radii, sectors, span| Layout::<2>::ring([0.0; 2], radii, sectors, span, None);
        assert!(ring(radii(), 8, Span::Full).is_ok());
        assert!(ring(Axis::uniform(0.0, 2.0, 2).unwrap(), 8, Span::Full).is_err());
        assert!(ring(radii(), 2, Span::Full).is_err());
        for (from, to, sectors) in [(1.0, 1.0, 4), (0.0, 6.3, 8), (0.0, 3.2, 1), (0.0, f64::NAN, 4)] {
            let error = ring(radii(), sectors, Span::Sector { from, to }).unwrap_err();
            assert!(matches!(error, LayoutError::Sector { .. }), "{error}");
        }
        for scale in [1e-200, 1e200] {
            let error = ring(Axis::uniform(scale, 2.0 * scale, 2).unwrap(), 8, Span::Full).unwrap_err();
            assert!(matches!(error, LayoutError::Flat { .. }), "{error}");
        }
        assert!(ring(radii(), 1, Span::Sector { from: 0.0, to: 1.0 }).is_ok());
        let flat = Layout::<3>::ring([0.0; 2], radii(), 8, Span::Full, None).unwrap_err();
        assert_eq!(flat, LayoutError::Height { dimensions: 3 });
        assert_eq!(flat.to_string(), "a ring in 3 dimensions needs a height axis");
    }

    #[test]
    fn theta_is_the_fastest_direction() {
        let radii = Axis::uniform(1.0, 2.0, 1).unwrap();
        let layout = Layout::<2>::ring([3.0, 0.0], radii, 4, Span::Full, None).unwrap();
        let at = |i| layout.position(NodeId::from_index(i).unwrap());
        for (i, x, y) in [(0, 4.0, 0.0), (1, 3.0, 1.0), (2, 2.0, 0.0), (4, 5.0, 0.0), (7, 3.0, -2.0)] {
            assert!((at(i) - Vector::<2>::new(x, y)).norm() < 1e-15);
        }
    }
}
