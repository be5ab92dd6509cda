//! What others see of a material point.

use mpm_grid::{Block, Vector};
use mpm_material::SymmetricTensor;

/// Committed state of one material point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointView<const D: usize> {
    /// `x_p` `[L]`.
    pub position: Vector<D>,
    /// Position at rest, where it is kept `[L]`.
    pub reference_position: Option<Vector<D>>,
    /// `V⁰_p` `[L^D]`.
    pub reference_volume: f64,
    /// F `[-]`.
    pub deformation_gradient: Block<D>,
    /// `J = det F` `[-]`.
    pub volume_ratio: f64,
    /// `b_e - I` `[-]`.
    pub elastic_excess: SymmetricTensor,
    /// Elastic energy per reference volume `[F/L²]`.
    pub stored_energy: f64,
    /// Kirchhoff stress τ `[F/L²]`; not a number where the law finds none for the committed state.
    pub kirchhoff: SymmetricTensor,
    /// Whether the last load step was plastic.
    pub plastic: bool,
}
