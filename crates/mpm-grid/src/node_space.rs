//! The nodes on which functions live: vertices of the lattice, or control points of B-splines.
//!
//! Splines of degree p on the cells of an axis with open knots (the end knots repeated p + 1 times)
//! have n + p functions for n cells. The control point of function i stands at the Greville abscissa
//!
//! ```text
//! ξ_i = (t_{i+1} + … + t_{i+p}) / p
//! ```
//!
//! of the knots t, so that `Σ N_i = 1` and `Σ ξ_i N_i = x`. The control points of degree 1 are the vertices.

use crate::axis::Axis;
use crate::layout::Layout;
use crate::mesh::Mesh;
use crate::motion::{MeshMotion, MotionError};
use crate::placed::{PlacedMotion, turn};
use crate::splines::{NodeKind, NodeLine, Splines};
use crate::{Lattice, LatticeError, LoadFraction, NodeId, Vector};

/// Why a mesh has no nodes of a kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NodeSpaceError {
    /// Splines of degree 0.
    #[error("control points need a degree of at least 1")]
    Degree,
    /// Control points that the functions of a ring do not have.
    #[error("{kind} need a box, or a ring whose functions live on them: this ring has {functions}")]
    Ring {
        /// The kind asked for.
        kind: NodeKind,
        /// The nodes of the ring's functions.
        functions: NodeKind,
    },
    /// More nodes than can be numbered.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

/// The nodes of one kind of a mesh, numbered lexicographically, the first direction fastest.
///
/// Numbers and indices do not depend on the motion of the mesh.
///
/// ```
/// use mpm_grid::{Axis, Layout, Mesh, NodeKind, NodeSpace};
///
/// let axis = Axis::uniform(0.0, 4.0, 4)?;
/// let mesh = Mesh::at_rest(&Layout::on_axes([axis.clone(), axis])?);
/// let nodes = NodeSpace::of(NodeKind::ControlPoints { degree: 2 }, &mesh)?;
/// assert_eq!(nodes.lattice().nodes(), [6, 6]);
/// let node = nodes.lattice().node([1, 5]);
/// assert_eq!(nodes.position(&mesh, node).as_slice(), [0.5, 4.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeSpace<const D: usize> {
    kind: NodeKind,
    lattice: Lattice<D>,
}

impl<const D: usize> NodeSpace<D> {
    /// The vertices of a lattice.
    pub fn vertices(lattice: Lattice<D>) -> Self {
        Self { kind: NodeKind::Vertices, lattice }
    }

    /// The nodes of a kind of a mesh.
    ///
    /// # Errors
    /// Why the mesh has no such nodes.
    pub fn of(kind: NodeKind, mesh: &Mesh<D>) -> Result<Self, NodeSpaceError> {
        let degree = match kind {
            NodeKind::Vertices => return Ok(Self::vertices(mesh.lattice().clone())),
            NodeKind::ControlPoints { degree: 0 } => return Err(NodeSpaceError::Degree),
            NodeKind::ControlPoints { .. } if !mesh.is_box() && mesh.functions() != kind => {
                return Err(NodeSpaceError::Ring { kind, functions: mesh.functions() });
            }
            NodeKind::ControlPoints { degree } => degree,
        };
        Ok(Self { kind, lattice: Splines::on(mesh.lattice(), degree)?.nodes })
    }

    /// The kind of its nodes.
    pub fn kind(&self) -> NodeKind {
        self.kind
    }

    /// Degree of the splines along each direction; 1 of vertices. Round a ring splines are trigonometric, of degree 2.
    pub fn degrees(&self) -> [u32; D] {
        let is_trigonometric = |is_periodic| is_periodic && self.kind != NodeKind::Vertices;
        self.lattice.periodic().map(|it| if is_trigonometric(it) { 2 } else { self.degree() })
    }

    /// The arrangement of the nodes: their indices, numbers and neighbours. Its cells lie between
    /// neighbouring nodes; they are cells of the mesh only where the nodes are vertices.
    #[inline]
    pub fn lattice(&self) -> &Lattice<D> {
        &self.lattice
    }

    /// Position `[L]` of a node in a mesh; that of a control point is its Greville abscissa on the moved
    /// axes of a stretched box, the image of its position at rest in a bent one, and outside the arc of its sector in a ring.
    #[inline]
    pub fn position(&self, mesh: &Mesh<D>, node: NodeId) -> Vector<D> {
        match self.kind {
            NodeKind::Vertices => mesh.position(node),
            NodeKind::ControlPoints { degree } => mesh.control_position(degree, &self.lattice.node_index(node)),
        }
    }

    /// Displacement `[L]` of a node with the mesh from load fraction `start` to `end`; `mesh` is the mesh at `start`.
    /// Vertices move as [`MeshMotion::displacement`] says.
    ///
    /// # Errors
    /// The motion does not suit the layout, or folds the mesh.
    pub fn displacement(
        &self,
        (motion, layout): (&MeshMotion<D>, &Layout<D>),
        node: NodeId,
        mesh: &Mesh<D>,
        (start, end): (LoadFraction, LoadFraction),
    ) -> Result<Vector<D>, MotionError> {
        match self.kind {
            NodeKind::Vertices => motion.displacement(layout, node, mesh, start, end),
            // The motion of an average of knots is the average of their motions.
            NodeKind::ControlPoints { .. } => {
                let x = self.position(mesh, node);
                match (motion.placed(layout, start)?, motion.placed(layout, end)?) {
                    (
                        PlacedMotion::Rotation { centre, angle, .. },
                        PlacedMotion::Rotation { angle: later, .. },
                    ) => Ok(turn(&x, &centre, later - angle)),
                    _ => Ok(self.position(&motion.mesh_at(layout, end)?, node) - x),
                }
            }
        }
    }

    /// Where the lines of nodes of each direction stand at rest `[L]`, as [`Layout::lines`].
    pub fn lines(&self, layout: &Layout<D>) -> [Vec<f64>; D] {
        let NodeKind::ControlPoints { degree } = self.kind else { return layout.lines() };
        let greville = |axis| {
            let line = NodeLine { axis, degree };
            (0..line.len()).map(|i| line.at(i)).collect::<Vec<f64>>()
        };
        match layout {
            Layout::Box { axes, .. } => axes.each_ref().map(greville),
            Layout::Ring { radii, height, .. } => {
                let mut lines = layout.lines();
                for (d, line) in lines.iter_mut().enumerate().skip(1) {
                    match (d, height) {
                        (1, _) => *line = greville(radii),
                        (_, Some(axis)) => *line = greville(axis),
                        _ => {}
                    }
                }
                lines
            }
        }
    }

    /// Whether a prescribed value of the node is a value of the field on the mesh: always for vertices, and for the
    /// control points on the faces of the mesh, where all other functions vanish. Control points inside belong to no
    /// place.
    pub fn interpolates_at(&self, node: NodeId) -> bool {
        let (index, nodes) = (self.lattice.node_index(node), self.lattice.nodes());
        let periodic = self.lattice.periodic();
        let is_end = |d: usize| !periodic[d] && (index[d] == 0 || index[d] + 1 == nodes[d]);
        self.kind == NodeKind::Vertices || (0..D).any(is_end)
    }

    /// p, 1 for vertices.
    pub(crate) fn degree(&self) -> u32 {
        match self.kind {
            NodeKind::Vertices => 1,
            NodeKind::ControlPoints { degree } => degree,
        }
    }

    /// The nodes along an axis.
    pub(crate) fn line_on<'a>(&self, axis: &'a Axis) -> NodeLine<'a> {
        NodeLine { axis, degree: self.degree() }
    }

    /// The nodes along each axis of a box.
    pub(crate) fn axis_lines<'a>(&self, axes: &'a [Axis; D]) -> [NodeLine<'a>; D] {
        axes.each_ref().map(|axis| self.line_on(axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DrivenPlane, Ramp};

    fn quadratic() -> NodeKind {
        NodeKind::ControlPoints { degree: 2 }
    }

    fn graded() -> Layout<2> {
        let x = Axis::graded(vec![-1.0, 0.0, 0.5, 2.0]).unwrap();
        Layout::on_axes([x, Axis::uniform(0.1, 0.7, 2).unwrap()]).unwrap()
    }

    #[test]
    fn control_points_stand_at_means_of_knots() {
        let layout = graded();
        let mesh = Mesh::at_rest(&layout);
        let nodes = NodeSpace::of(quadratic(), &mesh).unwrap();
        let [x, y] = nodes.lines(&layout);
        assert_eq!(x, [-1.0, -0.5, 0.25, 1.25, 2.0]);
        assert_eq!((y.len(), y[0], y[3]), (4, 0.1, 0.7));
        for number in 0..nodes.lattice().n_nodes() {
            let node = NodeId::from_index(number).unwrap();
            let [i, j] = nodes.lattice().node_index(node);
            assert_eq!(nodes.position(&mesh, node), Vector::<2>::new(x[i as usize], y[j as usize]));
            assert_eq!(nodes.interpolates_at(node), [0, 4].contains(&i) || [0, 3].contains(&j));
        }
        let cubic = NodeSpace::of(NodeKind::ControlPoints { degree: 3 }, &mesh).unwrap();
        // The mean of three times 0.1 is not 0.1.
        let [x, y] = cubic.lines(&layout);
        assert_eq!((x.len(), y.len(), y[0], y[4]), (6, 5, 0.1, 0.7));
        assert!((x[2] - -0.5 / 3.0).abs() < 1e-16 && x.is_sorted() && y.is_sorted());
    }

    #[test]
    fn control_points_of_degree_one_are_vertices() {
        let layout = graded();
        let mesh = Mesh::at_rest(&layout);
        let linear = NodeSpace::of(NodeKind::ControlPoints { degree: 1 }, &mesh).unwrap();
        assert_eq!(linear.lattice(), mesh.lattice());
        assert_eq!(linear.lines(&layout), layout.lines());
    }

    #[test]
    fn control_points_move_with_their_mesh() {
        let layout = graded();
        let (start, end) = (LoadFraction::START, LoadFraction::END);
        let mesh = Mesh::at_rest(&layout);
        let nodes = NodeSpace::of(quadratic(), &mesh).unwrap();
        let node = nodes.lattice().node([2, 1]);
        // The driven plane is the knot at 0.5: 0 moves by 1/3 of it, 0.5 by all of it.
        let driven = DrivenPlane { anchor: -1.0, driven: 0.5, displacement: Ramp::linear(0.3) };
        let stretch = MeshMotion::stretch([Some(driven), None]).unwrap();
        let moved = nodes.displacement((&stretch, &layout), node, &mesh, (start, end)).unwrap();
        assert!((moved - Vector::<2>::new(0.25, 0.0)).norm() < 1e-15, "{moved}");
        let turn = MeshMotion::rotate([0.0, 0.0], Ramp::linear(std::f64::consts::FRAC_PI_2)).unwrap();
        let turned = turn.mesh_at(&layout, end).unwrap();
        let x = nodes.position(&mesh, node);
        assert!((nodes.position(&turned, node) - Vector::<2>::new(-x.y, x.x)).norm() < 1e-15);
    }

    #[test]
    fn impossible_spaces_are_refused() {
        let mesh = Mesh::at_rest(&graded());
        let of = |degree| NodeSpace::of(NodeKind::ControlPoints { degree }, &mesh);
        assert_eq!(of(0), Err(NodeSpaceError::Degree));
        assert_eq!(of(u32::MAX), Err(LatticeError::TooLarge.into()));
        assert_eq!(of(1 << 31), Err(LatticeError::TooLarge.into()));
        let radii = Axis::uniform(1.0, 2.0, 2).unwrap();
        let ring = Layout::<2>::ring([0.0; 2], radii, 8, crate::Span::Full, None).unwrap();
        let refused = NodeSpace::of(quadratic(), &Mesh::at_rest(&ring)).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "control points of degree 2 need a box, or a ring whose functions live on them: this ring has vertices"
        );
        assert!(NodeSpace::of(NodeKind::Vertices, &Mesh::at_rest(&ring)).is_ok());
    }
}
