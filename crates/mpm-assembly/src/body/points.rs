//! Committed state of the material points of one body: one column per quantity.

use mpm_grid::{Block, Vector};
use mpm_material::{Material, PointParameters, SymmetricTensor};

/// Committed state of all material points of a body, but for the domains of its basis; every column has one entry
/// per point, or none at all where the scene does not need it. Written at the end of a converged load step only.
pub(crate) struct Points<const D: usize, M: Material> {
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
    /// What the law remembers; zero bytes for elasticity.
    pub history: Vec<M::History>,
    /// Whether the last load step was plastic; empty for laws that never are.
    pub plastic: Vec<bool>,
}

// Derived `Clone` would ask for `M: Clone`.
impl<const D: usize, M: Material> Clone for Points<D, M> {
    fn clone(&self) -> Self {
        Self {
            position: self.position.clone(),
            reference_position: self.reference_position.clone(),
            reference_volume: self.reference_volume.clone(),
            mass: self.mass.clone(),
            deformation_gradient: self.deformation_gradient.clone(),
            elastic_excess: self.elastic_excess.clone(),
            history: self.history.clone(),
            plastic: self.plastic.clone(),
        }
    }
}

impl<const D: usize, M: Material> Default for Points<D, M> {
    fn default() -> Self {
        Self {
            position: Vec::new(),
            reference_position: Vec::new(),
            reference_volume: Vec::new(),
            mass: Vec::new(),
            deformation_gradient: Vec::new(),
            elastic_excess: Vec::new(),
            history: Vec::new(),
            plastic: Vec::new(),
        }
    }
}

/// A position as laws know it: in the plane its third component is zero `[L]`.
pub(crate) fn at_rest<const D: usize>(position: &Vector<D>) -> Vector<3> {
    let mut at_rest = Vector::<3>::zeros();
    at_rest.as_mut_slice()[..D].copy_from_slice(position.as_slice());
    at_rest
}

impl<const D: usize, M: Material> Points<D, M> {
    /// Adds a point of volume `volume` `[L^D]` that rests at `position` `[L]`, free of stress.
    pub fn push(&mut self, law: &M, position: Vector<D>, volume: f64) {
        self.history.push(law.initial(&PointParameters::at(at_rest(&position))));
        self.position.push(position);
        self.reference_volume.push(volume);
        self.deformation_gradient.push(Block::identity());
        self.elastic_excess.push(SymmetricTensor::ZERO);
        if M::PLASTIC {
            self.plastic.push(false);
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }
}
