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
    /// `V⁰_p` `[L^D]`; of a body of revolution that of the ring `[L³]`.
    pub reference_volume: f64,
    /// Size of what it stands for at rest: `V⁰_p`, of a body of revolution the area of its cross section `[L^D]`.
    pub reference_size: f64,
    /// F `[-]`; in plane strain and of a body of revolution without twist its in-plane part.
    pub deformation_gradient: Block<D>,
    /// `F_θθ` of a body of revolution without twist `[-]`; with twist it belongs to F.
    pub hoop_stretch: Option<f64>,
    /// By how much it has turned about the axis of its body of revolution, where it may `[rad]`.
    pub angle: Option<f64>,
    /// `J = det F` `[-]`.
    pub volume_ratio: f64,
    /// `b_e - I` `[-]`; the hoop of a body of revolution is the component zz, of all tensors.
    pub elastic_excess: SymmetricTensor,
    /// Whether the last load step was plastic.
    pub plastic: bool,
}
