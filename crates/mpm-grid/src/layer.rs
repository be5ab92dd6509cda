//! A mesh of the plane as the one layer of cells of a mesh in space, and back.
//!
//! A field of the plane with a third component lives on the nodes of the lower side of such a layer: nodes and cells have
//! the numbers that they have in the plane, positions a third coordinate of 0. The layer is 1 thick.

use std::array::from_fn;

use crate::axis::Axis;
use crate::cell::LinearCell;
use crate::layout::{Layout, LayoutError};
use crate::mesh::Mesh;
use crate::motion::MeshMotion;
use crate::node_space::{NodeSpace, NodeSpaceError};
use crate::placed::PlacedMotion;
use crate::ramp::Ramp;
use crate::splines::NodeKind;
use crate::{Block, Vector};

/// A vector of the plane with a third component of 0.
pub fn raised(x: &Vector<2>) -> Vector<3> {
    Vector::<3>::new(x[0], x[1], 0.0)
}

/// The components in the plane of a layer.
pub fn flattened(x: &Vector<3>) -> Vector<2> {
    Vector::<2>::new(x[0], x[1])
}

/// The part of a tensor in the plane of a layer.
pub fn flattened_block(f: &Block<3>) -> Block<2> {
    f.fixed_view::<2, 2>(0, 0).into_owned()
}

impl Layout<2> {
    /// The layout as a layer.
    ///
    /// # Errors
    /// There are more nodes than can be numbered, or its functions are splines.
    pub fn as_layer(&self) -> Result<Layout<3>, LayoutError> {
        if self.functions() != NodeKind::Vertices {
            return Err(LayoutError::LayerOfSplines);
        }
        let thickness = Axis::uniform(0.0, 1.0, 1).expect("one cell of length 1 is an axis");
        match self {
            Self::Box { axes: [first, second], .. } => {
                Layout::on_axes([first.clone(), second.clone(), thickness])
            }
            Self::Ring { centre, radii, sectors, span, .. } => {
                Layout::ring(*centre, radii.clone(), *sectors, *span, Some(thickness))
            }
        }
    }
}

impl MeshMotion<2> {
    /// The motion of the layer of a layout that has this one; none of a motion that someone else has written.
    pub fn as_layer(&self) -> Option<MeshMotion<3>> {
        Some(match self {
            Self::Fixed => MeshMotion::Fixed,
            Self::Stretch { axes: [first, second] } => {
                MeshMotion::Stretch { axes: [first.clone(), second.clone(), None] }
            }
            Self::Corners { path } => {
                let corner = |[x, y]: &[Ramp; 2]| [x.clone(), y.clone(), Ramp::constant(0.0)];
                MeshMotion::Corners { path: path.iter().chain(path).map(corner).collect() }
            }
            Self::Rotate { centre, angle } => MeshMotion::Rotate { centre: *centre, angle: angle.clone() },
            Self::Twist { centre, inner, outer, reindexing, .. } => MeshMotion::Twist {
                centre: *centre,
                inner: inner.clone(),
                outer: outer.clone(),
                reindexing: *reindexing,
                stretch: None,
            },
            Self::Expand { radii } => MeshMotion::Expand { radii: radii.clone() },
            Self::Affine { .. } => return None,
        })
    }
}

impl PlacedMotion<3> {
    /// The same motion of the plane; none of what would move the layer out of it.
    fn section(&self) -> Option<PlacedMotion<2>> {
        Some(match self {
            Self::Rest => PlacedMotion::Rest,
            Self::Stretch([first, second, _]) => PlacedMotion::Stretch([*first, *second]),
            Self::Corners { from, to, image } => PlacedMotion::Corners {
                from: flattened(from),
                to: flattened(to),
                image: LinearCell::new(from_fn(|c| match c < 4 {
                    true => flattened(&image.corners()[c]),
                    false => Vector::zeros(),
                })),
            },
            Self::Rotation { centre, angle, cos_sin } => {
                PlacedMotion::Rotation { centre: *centre, angle: *angle, cos_sin: *cos_sin }
            }
            Self::Twist { centre, profile, .. } => {
                PlacedMotion::Twist { centre: *centre, profile: *profile, along: None }
            }
            Self::Expand { centre, squares } => PlacedMotion::Expand { centre: *centre, squares: *squares },
            Self::Affine(_) => return None,
        })
    }
}

impl Mesh<3> {
    /// The mesh of the plane whose layer this is.
    ///
    /// # Panics
    /// The mesh moves by an affine map, which no layer of [`MeshMotion::as_layer`] does.
    pub fn section(&self) -> Mesh<2> {
        self.section_by(|motion| motion.section().expect("no layer moves by an affine map"))
    }
}

impl NodeSpace<3> {
    /// The nodes of the plane whose layer these are; `section` is that of their mesh.
    ///
    /// # Errors
    /// As [`NodeSpace::of`].
    pub fn section(&self, section: &Mesh<2>) -> Result<NodeSpace<2>, NodeSpaceError> {
        NodeSpace::of(self.kind(), section)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DrivenPlane, LoadFraction, NodeKind, Span};

    /// Nodes, cells and positions are those of the plane at any load fraction.
    fn check(layout: &Layout<2>, motion: &MeshMotion<2>) {
        let (layer, moving) = (layout.as_layer().unwrap(), motion.as_layer().unwrap());
        for fraction in [LoadFraction::START, LoadFraction::new(0.6).unwrap()] {
            let plane = motion.mesh_at(layout, fraction).unwrap();
            let space = moving.mesh_at(&layer, fraction).unwrap();
            assert_eq!(space.section(), plane);
            assert_eq!(space.lattice().cells()[..2], plane.lattice().cells());
            for number in 0..plane.lattice().n_nodes() {
                let node = crate::NodeId::from_index(number).unwrap();
                assert_eq!(flattened(&space.position(node)), plane.position(node));
                assert_eq!(space.position(node)[2], 0.0);
            }
            let nodes = NodeSpace::of(NodeKind::Vertices, &space).unwrap();
            assert_eq!(nodes.section(&plane).unwrap(), NodeSpace::of(NodeKind::Vertices, &plane).unwrap());
        }
    }

    #[test]
    fn layers_have_the_nodes_of_the_plane() {
        let axis = |cells| Axis::geometric(0.0, 2.0, cells, 1.3).unwrap();
        let layout = Layout::<2>::on_axes([axis(3), axis(4)]).unwrap();
        let plane = DrivenPlane { anchor: 0.0, driven: 1.5, displacement: Ramp::linear(-0.4) };
        let corner = |k: f64| [Ramp::linear(0.1 * k), Ramp::linear(-0.05 * k)];
        for motion in [
            MeshMotion::Fixed,
            MeshMotion::stretch([None, Some(plane.clone())]).unwrap(),
            MeshMotion::corners([0.0, 1.0, 2.0, 1.5].map(corner).to_vec()).unwrap(),
            MeshMotion::rotate([0.5, 0.0], Ramp::linear(0.7)).unwrap(),
        ] {
            check(&layout, &motion);
        }
        let radii = Axis::uniform(1.0, 2.0, 3).unwrap();
        let span = Span::Sector { from: 0.0, to: 1.5 };
        let ring = Layout::<2>::ring([0.0, 0.5], radii, 4, span, None).unwrap();
        let expand = DrivenPlane { anchor: 2.0, driven: 1.0, displacement: Ramp::linear(0.2) };
        check(&ring, &MeshMotion::expand(expand).unwrap());
    }
}
