//! Points of the plane in a layer of cells in space, see `mpm_grid`: their influences there, and back.

use crate::connectivity::Connectivity;
use crate::corner::{Carriers, Corner, CornerPoint};
use crate::influence::Stencil;
use crate::stencils::{Chunk, Influences, Stencils, UnconnectedPoint};
use mpm_grid::{OutsideMesh, Vector, flattened, flattened_block, raised};

impl Stencils<2> {
    /// The same influences on the nodes of the layer; gradients have a third component of 0.
    pub fn in_layer(self) -> Stencils<3> {
        let chunk = |chunk: Chunk<2>| {
            let Chunk { runs, nodes, strong, bounds: (low, high), faint, influences } = chunk;
            let index = |[i, j]: [u32; 2]| [i, j, 0];
            Chunk {
                runs,
                bounds: (index(low), index(high)),
                nodes,
                strong,
                faint,
                influences: Influences {
                    value: influences.value,
                    gradient: influences.gradient.iter().map(raised).collect(),
                    mass: influences.mass,
                },
            }
        };
        Stencils { chunks: self.chunks.into_iter().map(chunk).collect() }
    }
}

impl Connectivity<3> {
    /// The connectivity in the plane of points that are connected to the nodes of its layer.
    pub fn section(&self) -> Connectivity<2> {
        self.with_gradients(flattened)
    }
}

impl Stencil<2> {
    /// Adds the values to the same nodes of the layer.
    pub fn add_to_layer(&self, layer: &mut Stencil<3>) {
        for it in self.entries() {
            layer.add(it.node, it.value, raised(&it.gradient));
        }
    }
}

impl CornerPoint<3> {
    /// The point in the plane.
    pub fn section(&self) -> CornerPoint<2> {
        let Self { position, reference_size, volume, is_ring, deformation_gradient } = self;
        CornerPoint {
            position: flattened(position),
            reference_size: *reference_size,
            volume: *volume,
            is_ring: *is_ring,
            deformation_gradient: flattened_block(deformation_gradient),
        }
    }
}

impl Corner<2> {
    /// The same corner, carried by the nodes of the layer.
    ///
    /// # Panics
    /// The corner is carried by splines, which a [layer](mpm_grid::Layout::as_layer) does not have.
    pub fn in_layer(&self) -> Corner<3> {
        let Carriers::Vertices(mut nodes) = self.carriers else { panic!("layers have no splines") };
        // The plane has four; weights of zero are passed over.
        nodes[4..].iter_mut().for_each(|node| node.1 = 0.0);
        let (position, area) = (raised(&self.position), raised(&self.area));
        Corner { position, area, share: self.share, carriers: Carriers::Vertices(nodes) }
    }
}

/// A position of the plane outside of the mesh as one of the layer.
pub fn outside_of_layer(it: &OutsideMesh<2>) -> OutsideMesh<3> {
    OutsideMesh { position: raised(&it.position), distance: it.distance }
}

impl UnconnectedPoint<2> {
    /// The same point of the layer.
    pub fn in_layer(&self) -> UnconnectedPoint<3> {
        let Self { point, reason, position } = self;
        let position: Vector<3> = raised(position);
        UnconnectedPoint { point: *point, reason: outside_of_layer(reason), position }
    }
}
