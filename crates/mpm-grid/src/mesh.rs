//! The mesh of one load step: positions of the lattice's nodes, location of points, shape functions.

mod locating;

use std::array::from_fn;

use crate::cell::{LinearCell, halves, local_gradient, product};
use crate::lattice::corner;
use crate::layout::Layout;
use crate::location::Place;
use crate::motion::{MeshMotion, MotionError, Reindexing};
use crate::placed::{PlacedMotion, turn};
use crate::ramp::LoadFraction;
use crate::ring::PlacedRing;
use crate::splines::{HighestDerivatives, Line, NodeKind, NodeLine, SplineProduct, Splines};
use crate::{Axis, Block, CellId, Lattice, NodeId, Vector};

/// Background mesh of one load step: a lattice of linear cells with straight edges, whose functions are those of its
/// vertices or B-splines. A ring with splines has cells between circles.
///
/// It holds axes and, for a ring, a table of angles, never a list of nodes: its cost does not
/// depend on how much larger than the body it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<const D: usize> {
    lattice: Lattice<D>,
    shape: Shape<D>,
    /// Its functions, where they are not those of the vertices.
    splines: Option<Splines<D>>,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape<const D: usize> {
    Rectilinear([Axis; D]),
    Bent { axes: [Axis; D], motion: PlacedMotion<D> },
    Ring(PlacedRing),
}

impl Mesh<3> {
    /// The mesh of the plane whose layer this is; `flat` is the motion of a bent box in the plane.
    pub(crate) fn section_by(&self, flat: impl Fn(&PlacedMotion<3>) -> PlacedMotion<2>) -> Mesh<2> {
        let first_two = |axes: &[Axis; 3]| [axes[0].clone(), axes[1].clone()];
        let ([n, m, _], [closed, other, _]) = (self.lattice.cells(), self.lattice.periodic());
        Mesh {
            lattice: Lattice::new([n, m], [closed, other]).expect("a part of a lattice is one"),
            shape: match &self.shape {
                Shape::Rectilinear(axes) => Shape::Rectilinear(first_two(axes)),
                Shape::Bent { axes, motion } => Shape::Bent { axes: first_two(axes), motion: flat(motion) },
                Shape::Ring(ring) => Shape::Ring(ring.without_height()),
            },
            splines: None,
        }
    }
}

impl<const D: usize> Mesh<D> {
    /// The mesh of a layout without any motion.
    pub fn at_rest(layout: &Layout<D>) -> Self {
        MeshMotion::Fixed
            .mesh_at(layout, LoadFraction::START)
            .expect("every layout suits the fixed mesh, and its cells are valid")
    }

    /// The mesh under a motion that suits the layout; `None` where its cells fold.
    pub(crate) fn new(layout: &Layout<D>, motion: PlacedMotion<D>, reindexing: Reindexing) -> Option<Self> {
        let lattice = layout.lattice();
        let shape = match (layout, motion) {
            (Layout::Box { axes, .. }, PlacedMotion::Rest) => Shape::Rectilinear(axes.clone()),
            (Layout::Box { axes, .. }, PlacedMotion::Stretch(planes)) => {
                let mut stretched = axes.clone();
                for (axis, plane) in stretched.iter_mut().zip(planes) {
                    if let Some(plane) = plane {
                        *axis = plane.respaced(axis)?;
                    }
                }
                Shape::Rectilinear(stretched)
            }
            (Layout::Box { axes, .. }, motion) => {
                if let PlacedMotion::Corners { image, .. } = &motion
                    && !image.is_valid(layout.hand())
                {
                    return None;
                }
                Shape::Bent { axes: axes.clone(), motion }
            }
            (Layout::Ring { .. }, motion) => Shape::Ring(PlacedRing::new(layout, &motion, reindexing)?),
        };
        let splines = match layout.functions() {
            NodeKind::Vertices => None,
            NodeKind::ControlPoints { degree } => Some(Splines::on(&lattice, degree).ok()?),
        };
        Some(Self { lattice, shape, splines })
    }

    /// The nodes on which its functions live.
    #[inline]
    pub fn functions(&self) -> NodeKind {
        self.splines.as_ref().map_or(NodeKind::Vertices, Splines::kind)
    }

    /// The arrangement of vertices and cells.
    #[inline]
    pub fn lattice(&self) -> &Lattice<D> {
        &self.lattice
    }

    /// Position `[L]` of a vertex.
    #[inline]
    pub fn position(&self, node: NodeId) -> Vector<D> {
        self.position_at(&self.lattice.node_index(node))
    }

    #[inline]
    fn position_at(&self, index: &[u32; D]) -> Vector<D> {
        match &self.shape {
            Shape::Rectilinear(axes) => Vector::from_fn(|d, _| axes[d].node(index[d])),
            Shape::Bent { axes, motion } => motion.place(&Vector::from_fn(|d, _| axes[d].node(index[d]))),
            Shape::Ring(ring) => ring.position(index),
        }
    }

    /// Hands out the nodes on the edges of the mesh, corners more than once.
    fn for_edges(&self, mut take: impl FnMut([u32; D])) {
        let nodes = self.lattice.nodes();
        for (direction, &along) in nodes.iter().enumerate() {
            for corner in (0..1_usize << D).filter(|corner| corner >> direction & 1 == 0) {
                for k in 0..along {
                    let mut index = from_fn(|d| if corner >> d & 1 == 0 { 0 } else { nodes[d] - 1 });
                    index[direction] = k;
                    take(index);
                }
            }
        }
    }

    /// Lowest and highest coordinates of the edges of the mesh `[L]`.
    pub fn bounds(&self) -> (Vector<D>, Vector<D>) {
        let (mut low, mut high) = (self.position_at(&[0; D]), self.position_at(&[0; D]));
        self.for_edges(|index| {
            let position = self.position_at(&index);
            (low, high) = (low.inf(&position), high.sup(&position));
        });
        (low, high)
    }

    /// Distance from the axis r = 0 of the node that has gone the farthest from it, of those at the edges that lay on it in
    /// `before`, a mesh of the same lattice in the half plane (r, z) `[L]`.
    pub fn distance_from_axis(&self, before: &Self) -> f64 {
        let (mut farthest, width) = (0.0_f64, before.axis_width());
        self.for_edges(|index| {
            if before.position_at(&index)[0] <= width {
                farthest = farthest.max(self.position_at(&index)[0].abs());
            }
        });
        farthest
    }

    /// Diagonal of the box around the edges of the mesh `[L]`.
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        (high - low).norm()
    }

    /// Distance from the axis r = 0 below which a node of a mesh in the half plane (r, z) lies on it: rounding `[L]`.
    pub fn axis_width(&self) -> f64 {
        1e-12 * self.diagonal()
    }

    /// The axes of an unbent box, along which the shape functions separate; `None` for other meshes.
    #[inline]
    pub fn rectilinear(&self) -> Option<&[Axis; D]> {
        match &self.shape {
            Shape::Rectilinear(axes) => Some(axes),
            _ => None,
        }
    }

    /// Whether its cells come from a box.
    pub(crate) fn is_box(&self) -> bool {
        !matches!(self.shape, Shape::Ring(_))
    }

    /// Position `[L]` of the control point of splines of a degree at a multi-index: on an axis its Greville abscissa (of
    /// the box at rest, where it is bent).
    #[inline]
    pub(crate) fn control_position(&self, degree: u32, index: &[u32; D]) -> Vector<D> {
        let on = |axes: &[Axis; D]| Vector::from_fn(|d, _| NodeLine { axis: &axes[d], degree }.at(index[d]));
        match &self.shape {
            Shape::Rectilinear(axes) => on(axes),
            Shape::Bent { axes, motion } => motion.place(&on(axes)),
            Shape::Ring(ring) => ring.control_position(degree, index),
        }
    }

    /// Positions `[L]` of the corners of a cell: the first 2^D entries, lexicographic.
    #[inline]
    pub fn corner_positions(&self, cell: [u32; D]) -> [Vector<D>; 8] {
        from_fn(|c| match c < 1 << D {
            true => self.position_at(&self.lattice.corner_index(&cell, c)),
            false => Vector::zeros(),
        })
    }

    /// Indices of all cells, the first direction fastest.
    pub fn cells(&self) -> impl Iterator<Item = [u32; D]> + '_ {
        (0..self.lattice.n_cells()).filter_map(CellId::from_index).map(|cell| self.lattice.cell_index(cell))
    }

    /// A cell as a map from local coordinates to positions.
    #[inline]
    pub fn linear_cell(&self, cell: [u32; D]) -> LinearCell<D> {
        LinearCell::new(self.corner_positions(cell))
    }

    /// The part of a cell between two local positions; between circles the linear cell with its corners.
    pub fn piece(&self, cell: [u32; D], from: &Vector<D>, to: &Vector<D>) -> LinearCell<D> {
        let Some(ring) = self.circles() else { return self.linear_cell(cell).piece(from, to) };
        LinearCell::new(from_fn(|c| {
            let pick = |d: usize| if c >> d & 1 == 0 { from[d] } else { to[d] };
            ring.round_position(&Place { cell, local: Vector::from_fn(|d, _| pick(d)) })
        }))
    }

    /// The ring, where its cells lie between circles.
    fn circles(&self) -> Option<&PlacedRing> {
        match &self.shape {
            Shape::Ring(ring) if self.splines.is_some() => Some(ring),
            _ => None,
        }
    }

    /// Calls `each` with node and N_v for the functions of the cell (of its 2^D corners, or splines), lexicographic (so
    /// ascending in node, but for the seam of a ring), also where N_v is zero.
    #[inline]
    pub fn values(&self, place: &Place<D>, mut each: impl FnMut(NodeId, f64)) {
        if let Some(splines) = &self.splines {
            let lines = self.lines(splines.degree, place);
            return splines.product(&place.cell, &lines, |node, value, _| each(node, value));
        }
        let sides = self.lattice.sides(&place.cell);
        let half = halves(&place.local);
        for c in 0..1 << D {
            each(corner(&sides, c), product(&half, c, D));
        }
    }

    /// As [`Self::values`], with the gradient ∂N_v/∂x `[1/L]` as third argument.
    #[inline]
    pub fn values_and_gradients(&self, place: &Place<D>, mut each: impl FnMut(NodeId, f64, Vector<D>)) {
        if let Some(splines) = &self.splines {
            return self.spline_gradients(splines, place, each);
        }
        let sides = self.lattice.sides(&place.cell);
        let half = halves(&place.local);
        let along = |axes: &[Axis; D]| Vector::<D>::from_fn(|d, _| 2.0 * axes[d].per_size(place.cell[d]));
        // ∂N/∂x = (∂ξ/∂x)ᵀ ∂N/∂ξ, diagonal in an unbent box.
        let push = match &self.shape {
            Shape::Rectilinear(axes) => {
                let along = along(axes);
                for c in 0..1 << D {
                    let gradient = local_gradient(&half, c).component_mul(&along);
                    each(corner(&sides, c), product(&half, c, D), gradient);
                }
                return;
            }
            Shape::Bent { axes, motion } => {
                let rest = Vector::from_fn(|d, _| {
                    let i = place.cell[d];
                    half[d][0] * axes[d].node(i) + half[d][1] * axes[d].node(i + 1)
                });
                motion.push_gradients(&rest) * Block::from_diagonal(&along(axes))
            }
            Shape::Ring(ring) => ring.push_gradients(place),
        };
        for c in 0..1 << D {
            let gradient = push * local_gradient(&half, c);
            each(corner(&sides, c), product(&half, c, D), gradient);
        }
    }
}

/// What there is where the functions are splines.
impl<const D: usize> Mesh<D> {
    /// The splines of every direction at a place.
    #[inline]
    fn lines(&self, degree: u32, place: &Place<D>) -> [Line; D] {
        from_fn(|d| match &self.shape {
            Shape::Rectilinear(axes) | Shape::Bent { axes, .. } => {
                Line::on_axis(degree, &axes[d], place.cell[d], place.local[d])
            }
            Shape::Ring(ring) => ring.line(degree, d, place),
        })
    }

    #[inline(never)]
    fn spline_gradients(
        &self,
        splines: &Splines<D>,
        place: &Place<D>,
        mut each: impl FnMut(NodeId, f64, Vector<D>),
    ) {
        let push = match &self.shape {
            Shape::Rectilinear(_) => Block::identity(),
            Shape::Bent { axes, motion } => motion.push_gradients(&Vector::from_fn(|d, _| {
                let i = place.cell[d];
                let share = 0.5 * (1.0 + place.local[d]);
                axes[d].node(i) + (axes[d].node(i + 1) - axes[d].node(i)) * share
            })),
            Shape::Ring(ring) => ring.round_push(place),
        };
        let lines = self.lines(splines.degree, place);
        splines.product(&place.cell, &lines, |node, value, slope| each(node, value, push * slope));
    }

    /// The values of the splines at a place as products; `None` where the functions are those of the vertices.
    #[inline]
    pub fn spline_product(&self, place: &Place<D>) -> Option<SplineProduct<D>> {
        let splines = self.splines.as_ref()?;
        Some(SplineProduct::new(splines, &place.cell, &self.lines(splines.degree, place)))
    }

    /// The control point at a multi-index, which may have passed the seam of a ring; `None` where the functions are
    /// those of the vertices.
    #[inline]
    pub fn control_point(&self, index: [u32; D]) -> Option<NodeId> {
        self.splines.as_ref().map(|splines| splines.node(index))
    }

    /// The highest derivatives of the splines of a cell along a direction, which jump at the face to the next cell, at its
    /// end or its start; `None` where the functions are those of the vertices.
    pub fn highest_derivatives(
        &self,
        cell: [u32; D],
        direction: usize,
        at_end: bool,
    ) -> Option<HighestDerivatives> {
        let degree = self.splines.as_ref()?.degree;
        Some(match &self.shape {
            Shape::Rectilinear(axes) | Shape::Bent { axes, .. } => {
                HighestDerivatives::on_axis(degree, &axes[direction], cell[direction])
            }
            Shape::Ring(ring) => ring.highest_derivatives(degree, direction, cell[direction], at_end),
        })
    }
}

impl<const D: usize> MeshMotion<D> {
    /// The mesh at a load fraction.
    pub fn mesh_at(&self, layout: &Layout<D>, at: LoadFraction) -> Result<Mesh<D>, MotionError> {
        let reindexing = match self {
            Self::Twist { reindexing, .. } => *reindexing,
            _ => Reindexing::Off,
        };
        let motion = self.placed(layout, at)?;
        Mesh::new(layout, motion, reindexing).ok_or(MotionError::Folded { fraction: at.total() })
    }

    /// Displacement `[L]` that the motion prescribes from fraction `start` to `end` for the
    /// material at a node of `mesh`, the mesh at `start`.
    ///
    /// Re-indexing is not a motion of material: under rotations and twists the displacement is
    /// (R(Δα) - I)(x - centre) with the angle increment Δα at the radius of the node.
    pub fn displacement(
        &self,
        layout: &Layout<D>,
        node: NodeId,
        mesh: &Mesh<D>,
        start: LoadFraction,
        end: LoadFraction,
    ) -> Result<Vector<D>, MotionError> {
        let x = mesh.position(node);
        match (self.placed(layout, start)?, self.placed(layout, end)?) {
            (PlacedMotion::Rest, _) => Ok(Vector::zeros()),
            (PlacedMotion::Rotation { centre, angle, .. }, PlacedMotion::Rotation { angle: later, .. }) => {
                Ok(turn(&x, &centre, later - angle))
            }
            (
                PlacedMotion::Twist { centre, profile, .. },
                PlacedMotion::Twist { profile: later, along, .. },
            ) => {
                let Layout::Ring { radii, height, .. } = layout else {
                    return Err(MotionError::NeedsRing);
                };
                let index = layout.lattice().node_index(node);
                let radius = radii.node(index[1]);
                let mut moved = turn(&x, &centre, later.angle(radius) - profile.angle(radius));
                if let (Some(along), Some(height)) = (along, height) {
                    moved[D - 1] = along.place(height.node(index[D - 1])) - x[D - 1];
                }
                Ok(moved)
            }
            (_, later) => Ok(later.place(&layout.position(node)) - x),
        }
    }
}
