//! Committed state of the material points of one body: one column per quantity.

use mpm_basis::{Basis, Seed};
use mpm_grid::{Block, Vector};
use mpm_material::{Material, SymmetricTensor};

/// Committed state of all material points of a body; every column has one entry per point, or none
/// at all where the scene does not need it. Written at the end of a converged load step only.
pub struct Points<const D: usize, B: Basis<D>, M: Material> {
    /// `x_p` `[L]`.
    pub position: Vec<Vector<D>>,
    /// Position at rest, kept where displacements are asked for `[L]`.
    pub reference_position: Vec<Vector<D>>,
    /// `V⁰_p` `[L^D]`.
    pub reference_volume: Vec<f64>,
    /// `m_p`, kept where a body force acts `[M]`.
    pub mass: Vec<f64>,
    /// Domain of the basis; zero bytes for standard MPM.
    pub domain: Vec<B::Domain>,
    /// `F_n` `[-]`; in plane strain its in-plane part.
    pub deformation_gradient: Vec<Block<D>>,
    /// `b_e,n - I` `[-]`.
    pub elastic_excess: Vec<SymmetricTensor>,
    /// What the law remembers; zero bytes for elasticity.
    pub history: Vec<M::History>,
    /// Whether the last load step was plastic; empty for laws that never are.
    pub plastic: Vec<bool>,
}

// Derived `Clone` would ask for `B: Clone` and `M: Clone`.
impl<const D: usize, B: Basis<D>, M: Material> Clone for Points<D, B, M> {
    fn clone(&self) -> Self {
        Self {
            position: self.position.clone(),
            reference_position: self.reference_position.clone(),
            reference_volume: self.reference_volume.clone(),
            mass: self.mass.clone(),
            domain: self.domain.clone(),
            deformation_gradient: self.deformation_gradient.clone(),
            elastic_excess: self.elastic_excess.clone(),
            history: self.history.clone(),
            plastic: self.plastic.clone(),
        }
    }
}

impl<const D: usize, B: Basis<D>, M: Material> Default for Points<D, B, M> {
    fn default() -> Self {
        Self {
            position: Vec::new(),
            reference_position: Vec::new(),
            reference_volume: Vec::new(),
            mass: Vec::new(),
            domain: Vec::new(),
            deformation_gradient: Vec::new(),
            elastic_excess: Vec::new(),
            history: Vec::new(),
            plastic: Vec::new(),
        }
    }
}

impl<const D: usize, B: Basis<D>, M: Material> Points<D, B, M> {
    /// Adds a point at rest, free of stress.
    pub fn push(&mut self, seed: Seed<D, B::Domain>) {
        self.position.push(seed.position);
        self.reference_volume.push(seed.volume);
        self.domain.push(seed.domain);
        self.deformation_gradient.push(Block::identity());
        self.elastic_excess.push(SymmetricTensor::ZERO);
        self.history.push(M::History::default());
        if M::PLASTIC {
            self.plastic.push(false);
        }
    }

    /// Remembers the present positions as those at rest.
    pub fn keep_reference_positions(&mut self) {
        self.reference_position = self.position.clone();
    }

    /// Gives every point the mass `density · V⁰`.
    pub fn weigh(&mut self, density: f64) {
        self.mass = self.reference_volume.iter().map(|volume| density * volume).collect();
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}
