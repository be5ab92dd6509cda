#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Finite-strain constitutive laws: what stress, and what stiffness, a material point answers
//! to a trial deformation.
//!
//! A law is isotropic, so it is a function of three principal strains and nothing else: a
//! [`Material`] maps the elastic trial strains εᵗʳ (logarithmic, principal) to the Kirchhoff
//! stresses τ, and to the derivative ∂τ_a/∂ε_bᵗʳ. It knows neither the space dimension nor the
//! axes. [`respond`] supplies both ends: it finds the principal axes of the trial state, asks the
//! law, and returns tensors; [`Modes::spatial_tangent`] turns the principal derivative into the
//! moduli that a stiffness matrix is built from, in the plane or in space.
//!
//! States enter and leave as the *excess* c = b_e − I of the elastic left Cauchy–Green tensor.
//! Near the undeformed state b_e = I + O(ε), and storing b_e itself would round every strain to
//! 1e-16 absolutely; the excess keeps sixteen digits of strains of any size.
//!
//! The laws are [`Hencky`] (elastic) and [`VonMises`] (perfectly plastic).

mod elasticity;
mod hencky;
mod spectral;
mod tangent;
mod tensor;
mod von_mises;

use nalgebra::{Matrix3, Vector3};

pub use elasticity::{Elasticity, ParameterError};
pub use hencky::Hencky;
pub use tangent::Modes;
pub use tensor::SymmetricTensor;
pub use von_mises::{PlasticStrain, VonMises};

use spectral::{Frame, Spectrum};

/// An isotropic law in principal logarithmic space, always three-dimensional.
///
/// The three principal directions have equal rights: a law must not read anything into their
/// order, which is fixed by the data but not sorted.
pub trait Material: Send + Sync {
    /// What a point remembers besides b_e; `()` where there is nothing.
    type History: Copy + Default + Send + Sync + StoredHistory;

    /// Whether the algorithmic tangent is symmetric, and with it the stiffness matrix.
    const SYMMETRIC: bool;

    /// Whether the law can yield.
    const PLASTIC: bool;

    /// Answers principal elastic trial strains `trial` [-] with stress, tangent and the elastic
    /// strain that is left. Non-finite strains give non-finite stresses.
    fn update(&self, trial: &Vector3<f64>, history: &Self::History) -> Update<Self::History>;

    /// P-wave modulus of the undeformed material [F/L²]: the size of the tangent's entries,
    /// against which round-off is judged.
    fn stiffness(&self) -> f64;

    /// Young's modulus of the undeformed material [F/L²].
    fn young(&self) -> f64;
}

/// What a point remembers, as `NUMBERS` numbers for a file from which a run goes on.
pub trait StoredHistory: Sized {
    /// Numbers per point.
    const NUMBERS: usize;

    /// Appends exactly `NUMBERS` numbers.
    fn store(&self, to: &mut Vec<f64>);

    /// The history that `NUMBERS` finite numbers are, bit for bit.
    ///
    /// # Errors
    /// What no history of this kind can be.
    fn recall(from: &[f64]) -> Result<Self, String>;
}

impl StoredHistory for () {
    const NUMBERS: usize = 0;

    fn store(&self, _to: &mut Vec<f64>) {}

    fn recall(_from: &[f64]) -> Result<Self, String> {
        Ok(())
    }
}

/// Answer of a [`Material`] in principal axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Update<H> {
    /// Elastic strains ε_e after the update [-].
    pub elastic_strain: Vector3<f64>,
    /// Kirchhoff stresses τ [F/L²].
    pub kirchhoff: Vector3<f64>,
    /// Algorithmic tangent ∂τ_a/∂ε_bᵗʳ [F/L²], `[(a, b)]`.
    pub tangent: Matrix3<f64>,
    /// Secants (τ_a − τ_b)/(ε_aᵗʳ − ε_bᵗʳ) of the pairs (0,1), (1,2), (2,0) [F/L²], each with its
    /// limit where the strains are equal. A law gives them in closed form: the quotient of
    /// differences would lose all digits as two strains approach each other.
    pub secant: Vector3<f64>,
    /// Whether the point yielded in this update.
    pub plastic: bool,
    /// What the point remembers from here on.
    pub history: H,
}

/// Answer of a point to a trial elastic state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Response<H> {
    /// Kirchhoff stress τ = J σ [F/L²].
    pub kirchhoff: SymmetricTensor,
    /// Elastic excess b_e − I after the update [-].
    pub elastic_excess: SymmetricTensor,
    /// Whether the point yielded.
    pub plastic: bool,
    /// What the point remembers from here on.
    pub history: H,
    /// Principal axes and moduli, from which the spatial tangent is made when it is wanted.
    pub modes: Modes,
}

/// Answers the trial elastic state b_eᵗʳ = ΔF b_e ΔFᵀ, given by its excess
/// `trial_excess` = b_eᵗʳ − I.
///
/// The principal values c_a of the excess give εᵗʳ_a = ½ ln(1 + c_a); what yields is returned to
/// b_e = exp(2 ε_e) in the axes of the trial state. An elastic point keeps its trial excess, bit
/// for bit. States with `yz == zx == 0` take a closed-form path about ten times faster than the
/// general one.
///
/// Where b_eᵗʳ is not positive definite, or not finite, every component of the stress is NaN (but
/// for yz and zx of a plane state, always zero). The caller, who knows det ΔF, should refuse such
/// a state before asking.
// Always inlined: a pass that wants stresses only then pays for nothing that `modes` holds.
#[inline(always)]
pub fn respond<M: Material>(
    law: &M,
    trial_excess: &SymmetricTensor,
    history: &M::History,
) -> Response<M::History> {
    let Spectrum { values, frame } = Spectrum::of(trial_excess);
    let strain = log_strains(&values);
    let update = law.update(&strain, history);

    let elastic_excess = if update.plastic {
        frame.compose(&update.elastic_strain.map(|eps| (2.0 * eps).exp_m1()))
    } else {
        *trial_excess
    };
    Response {
        kirchhoff: frame.compose(&update.kirchhoff),
        elastic_excess,
        plastic: update.plastic,
        history: update.history,
        modes: Modes {
            frame,
            excess: values,
            strain,
            kirchhoff: update.kirchhoff,
            tangent: update.tangent,
            secant: update.secant,
        },
    }
}

/// Elastic logarithmic strain ε_e = ½ ln b_e [-] from the excess b_e − I; NaN where b_e is not
/// positive definite.
#[inline]
pub fn log_strain(excess: &SymmetricTensor) -> SymmetricTensor {
    let Spectrum { values, frame } = Spectrum::of(excess);
    frame.compose(&log_strains(&values))
}

/// ε_a = ½ ln(1 + c_a).
#[inline]
fn log_strains(excess: &Vector3<f64>) -> Vector3<f64> {
    // One bad value spoils all three: a stress must not look healthy in some components only.
    if excess.iter().all(|&c| c > -1.0 && c < f64::INFINITY) {
        excess.map(|c| 0.5 * c.ln_1p())
    } else {
        Vector3::repeat(f64::NAN)
    }
}
