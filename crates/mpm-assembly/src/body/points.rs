//! Committed state of the material points of one body: one column per quantity.

use mpm_grid::{Block, Vector};
use mpm_material::SymmetricTensor;

/// Committed state of all material points of a body, but for what its law and its basis keep of them; every column
/// has one entry per point, or none at all where the scene does not need it. Written at the end of a converged load
/// step only.
#[derive(Clone, Default)]
pub(crate) struct Points<const D: usize> {
    /// `x_p` `[L]`.
    pub position: Vec<Vector<D>>,
    /// Position at rest, kept where displacements are asked for `[L]`.
    pub reference_position: Vec<Vector<D>>,
    /// `V⁰_p` `[L^D]`.
    pub reference_volume: Vec<f64>,
    /// `m_p`, kept where a body force acts `[M]`.
    pub mass: Vec<f64>,
    /// `F_n` `[-]`; in plane strain its in-plane part.
    pub deformation_gradient: Vec<Block<D>>,
    /// `b_e,n - I` `[-]`.
    pub elastic_excess: Vec<SymmetricTensor>,
    /// Whether the last load step was plastic; empty for laws that never are.
    pub plastic: Vec<bool>,
}

/// A position as laws know it: in the plane its third component is zero `[L]`.
pub(crate) fn at_rest<const D: usize>(position: &Vector<D>) -> Vector<3> {
    let mut at_rest = Vector::<3>::zeros();
    at_rest.as_mut_slice()[..D].copy_from_slice(position.as_slice());
    at_rest
}

impl<const D: usize> Points<D> {
    /// Adds a point of volume `volume` `[L^D]` that rests at `position` `[L]`, free of stress; its law can yield or not.
    pub fn push(&mut self, position: Vector<D>, volume: f64, can_yield: bool) {
        self.position.push(position);
        self.reference_volume.push(volume);
        self.deformation_gradient.push(Block::identity());
        self.elastic_excess.push(SymmetricTensor::ZERO);
        if can_yield {
            self.plastic.push(false);
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }
}
