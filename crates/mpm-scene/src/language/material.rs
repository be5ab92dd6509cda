//! Laws.

use super::number::{Finite, Poisson, Positive};
use super::quantity::Quantity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A law. Strains are elastic, logarithmic and principal, stresses Kirchhoff's; tension is positive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum MaterialInput {
    /// Hencky elasticity, `τ = λ tr(ε_e) I + 2G ε_e`.
    Hencky {
        /// Young's modulus E `[F/L²]`.
        young: Quantity<Positive>,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
    /// Compressible neo-Hookean elasticity, `τ = G (b - I) + λ ln J I`: for large shear.
    NeoHooke {
        /// Young's modulus E of small strains `[F/L²]`.
        young: Quantity<Positive>,
        /// Poisson's ratio ν of small strains, 0 ≤ ν < 0.5 `[-]`.
        poisson: Poisson,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
    /// Hencky elasticity with von Mises plasticity. Its strength is either `yield_radius` or `undrained_strength`.
    VonMises {
        /// Young's modulus E `[F/L²]`.
        young: Quantity<Positive>,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// ρ_y = √(2 J₂) of the Kirchhoff stress at yield, √(2/3) times the uniaxial yield stress `[F/L²]`.
        #[serde(default)]
        yield_radius: Option<Quantity<Positive>>,
        /// Undrained shear strength s_u = ρ_y/√2 `[F/L²]`.
        #[serde(default)]
        undrained_strength: Option<Quantity<Positive>>,
        /// How the undrained strength changes; it stays if left out.
        #[serde(default)]
        softening: Option<SofteningInput>,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
    /// Hencky elasticity with Tresca plasticity, `τ₁ - τ₃ ≤ 2 s_u`.
    Tresca {
        /// Young's modulus E `[F/L²]`.
        young: Quantity<Positive>,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// Undrained shear strength s_u `[F/L²]`.
        undrained_strength: Quantity<Positive>,
        /// How it changes; it stays if left out.
        #[serde(default)]
        softening: Option<SofteningInput>,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
    /// Hencky elasticity with perfect Mohr–Coulomb plasticity.
    MohrCoulomb {
        /// Young's modulus E `[F/L²]`.
        young: Quantity<Positive>,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// Cohesion c `[F/L²]`.
        cohesion: Quantity<Finite>,
        /// Angle of friction φ, 0 ≤ φ < 90 `[degrees]`.
        friction: Quantity<Finite>,
        /// Angle of dilation ψ, 0 ≤ ψ ≤ φ `[degrees]`.
        dilation: Quantity<Finite>,
        /// Tension that a stress can reach; up to the apex `c cot φ` if left out `[F/L²]`.
        #[serde(default)]
        tensile_strength: Option<Quantity<Finite>>,
        /// Part of the elastic moduli that the tangent alone has where the law has no stiffness, from 0 to 1 `[-]`.
        #[serde(default = "super::number::zero")]
        apex_stiffness: Finite,
        /// Whether a point that came apart at the apex has to close again before it bears anything.
        #[serde(default)]
        volume_correction: bool,
        /// Bulk modulus of pore fluid that cannot leave; no fluid if left out `[F/L²]`.
        #[serde(default)]
        fluid_bulk: Option<Quantity<Positive>>,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
    /// Hencky elasticity with perfect Drucker–Prager plasticity, `q - η p ≤ k`.
    DruckerPrager {
        /// Young's modulus E `[F/L²]`.
        young: Quantity<Positive>,
        /// Poisson's ratio ν, -1 < ν < 0.5 `[-]`.
        poisson: Poisson,
        /// The cone.
        cone: ConeInput,
        /// Mean tension that the stress can reach; up to the apex `k/η` if left out `[F/L²]`.
        #[serde(default)]
        tension: Option<Quantity<Finite>>,
        /// Part of the elastic moduli that the tangent alone has where the law has no stiffness, from 0 to 1 `[-]`.
        #[serde(default = "super::number::zero")]
        apex_stiffness: Finite,
        /// Whether a point that came apart at the apex has to close again before it bears anything.
        #[serde(default)]
        volume_correction: bool,
        /// Bulk modulus of pore fluid that cannot leave; no fluid if left out `[F/L²]`.
        #[serde(default)]
        fluid_bulk: Option<Quantity<Positive>>,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
    /// Modified Cam-Clay, hyperelastic; without elastic strain it is under the pressure `reference_pressure`.
    CamClay {
        /// M, q/p at the critical state `[-]`.
        critical_ratio: Quantity<Positive>,
        /// λ, slope of ln J against ln p in first compression, p Kirchhoff's `[-]`.
        compression: Quantity<Positive>,
        /// κ, the same in unloading, κ < λ `[-]`.
        swelling: Quantity<Positive>,
        /// G₀ in the shear modulus G₀ + g p `[F/L²]`.
        #[serde(default = "no_stiffness")]
        shear: Quantity<Finite>,
        /// g in the shear modulus G₀ + g p `[-]`.
        #[serde(default = "no_stiffness")]
        shear_ratio: Quantity<Finite>,
        /// p_r, pressure at zero elastic strain `[F/L²]`.
        reference_pressure: Positive,
        /// p_c at the start, Kirchhoff's `[F/L²]`.
        preconsolidation: Quantity<Positive>,
        /// Bulk modulus of pore fluid that cannot leave; no fluid if left out `[F/L²]`.
        #[serde(default)]
        fluid_bulk: Option<Quantity<Positive>>,
        /// A nodal field that keeps softening from depending on the mesh; none if left out.
        #[serde(default)]
        gradient: Option<GradientInput>,
        /// Mass per reference volume; needed where a body force acts `[M/L³]`.
        #[serde(default)]
        density: Option<Quantity<Positive>>,
    },
}

/// A nodal field k that follows a measure d of the strain: `½ h (d - k)² + ½ h l² |Grad k|²` is stored besides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradientInput {
    /// What it follows.
    #[serde(default)]
    pub driver: DriverInput,
    /// h, several times as large as the slope with which the strength falls `[F/L²]`.
    pub modulus: Positive,
    /// l, with which the width of shear bands grows `[L]`.
    pub length: Positive,
}

/// What a nodal field follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DriverInput {
    /// The accumulated plastic strain, of `VonMises` and `Tresca`: against softening of the material.
    #[default]
    PlasticStrain,
    /// A measure of the total shear, of all laws: against softening by large elastic strains. It stiffens elasticity.
    Strain,
}

/// Undrained strength s_u as a function of the accumulated plastic shear ξ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum SofteningInput {
    /// s_u = max(s_u0 + H ξ, s_res).
    Linear {
        /// H, negative for softening `[F/L²]`.
        modulus: Finite,
        /// s_res `[F/L²]`.
        residual: Finite,
    },
    /// s_u = s_u0 [δ + (1 - δ) exp(-3 ξ/ξ₉₅)].
    Remoulding {
        /// δ, 1/sensitivity `[-]`.
        remoulded: Positive,
        /// ξ₉₅ `[-]`.
        shear_95: Positive,
    },
}

/// The cone of Drucker–Prager plasticity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ConeInput {
    /// By its own numbers.
    Slopes {
        /// η `[-]`.
        slope: Quantity<Finite>,
        /// η̄, the slope that the flow is normal to `[-]`.
        flow_slope: Quantity<Finite>,
        /// k `[F/L²]`.
        strength: Quantity<Finite>,
    },
    /// By those of the Mohr–Coulomb surface that it meets.
    Matched {
        /// Where it does.
        at: ConeMatchInput,
        /// Cohesion c `[F/L²]`.
        cohesion: Quantity<Finite>,
        /// Angle of friction φ `[degrees]`.
        friction: Quantity<Finite>,
        /// Angle of dilation ψ `[degrees]`.
        dilation: Quantity<Finite>,
    },
}

/// Where a Drucker–Prager cone meets a Mohr–Coulomb surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ConeMatchInput {
    /// In triaxial compression.
    Compression,
    /// In triaxial extension.
    Extension,
    /// At collapse in plane strain with associated flow.
    PlaneStrain,
    /// At collapse in plane strain with flow that keeps volume.
    IsochoricPlaneStrain,
}

fn no_stiffness() -> Quantity<Finite> {
    Finite(0.0).into()
}

impl MaterialInput {
    /// Mass per reference volume, if it is given `[M/L³]`.
    pub fn density(&self) -> Option<&Quantity<Positive>> {
        match self {
            Self::Hencky { density, .. }
            | Self::NeoHooke { density, .. }
            | Self::VonMises { density, .. }
            | Self::Tresca { density, .. }
            | Self::MohrCoulomb { density, .. }
            | Self::DruckerPrager { density, .. }
            | Self::CamClay { density, .. } => density.as_ref(),
        }
    }

    /// The nodal field that regularises it, if one does.
    pub fn gradient(&self) -> Option<&GradientInput> {
        match self {
            Self::Hencky { gradient, .. }
            | Self::NeoHooke { gradient, .. }
            | Self::VonMises { gradient, .. }
            | Self::Tresca { gradient, .. }
            | Self::MohrCoulomb { gradient, .. }
            | Self::DruckerPrager { gradient, .. }
            | Self::CamClay { gradient, .. } => gradient.as_ref(),
        }
    }

    /// Whether points that came apart have to close before they bear anything.
    pub(crate) fn corrects_volume(&self) -> bool {
        match self {
            Self::MohrCoulomb { volume_correction, .. } | Self::DruckerPrager { volume_correction, .. } => {
                *volume_correction
            }
            _ => false,
        }
    }

    /// Bulk modulus of pore fluid, where there is any `[F/L²]`.
    pub fn fluid_bulk(&self) -> Option<&Quantity<Positive>> {
        match self {
            Self::MohrCoulomb { fluid_bulk, .. }
            | Self::DruckerPrager { fluid_bulk, .. }
            | Self::CamClay { fluid_bulk, .. } => fluid_bulk.as_ref(),
            _ => None,
        }
    }
}
