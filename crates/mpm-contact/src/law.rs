//! The law of the interface between a corner of a point's domain and a part of a tool: pure functions of a committed
//! state and a trial.
//!
//! With the gap `g = φ - g⁰`, the anchor A in the tool's frame and the tool's motion X at the end of the step:
//!
//! ```text
//! F_N = max(0, λ - k g)                    dT = (I - n⊗n)(x - X(A)),  t = -k_T dT,  L = μ F_N + a
//! T   = t where |t| ≤ L, else L t/|t|      F  = F_N n + T
//! ```

use crate::error::ContactError;
use crate::pose::{Pose, cross};
use crate::shape::Near;
use mpm_grid::{Block, Vector};
use nalgebra::Vector3;

/// Gaps of less than this share of a domain's width count as none in the first tangent of a step.
const TOUCH: f64 = 1e-9;

/// What holds between a tool and a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Coulomb's coefficient μ `[-]`.
    pub friction: f64,
    /// Shear strength of the interface without pressure `[F/L²]`.
    pub adhesion: f64,
    /// α: such a strength as a part of the undrained shear strength of the body at the surface `[-]`.
    pub adhesion_factor: f64,
    /// Penetration per width of a domain is the pressure over `stiffness` times Young's modulus `[-]`.
    pub stiffness: f64,
    /// Stiffness along the surface over that across it, `k_T/k` `[-]`.
    pub shear_stiffness: f64,
    /// Whether what touched at the start may come off.
    pub separates: bool,
    /// Augmentations per load step at most.
    pub augment: u32,
}

impl Default for Interface {
    /// Smooth, of stiffness 20, separable, not augmented.
    fn default() -> Self {
        Self {
            friction: 0.0,
            adhesion: 0.0,
            adhesion_factor: 0.0,
            stiffness: 20.0,
            shear_stiffness: 1.0,
            separates: true,
            augment: 0,
        }
    }
}

impl Interface {
    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// `friction`, `adhesion`: negative or not finite; `adhesion_factor`: not between 0 and 1; `stiffness`: below 1, with which
    /// a body would be passed through rather than pressed, or not finite; `shear_stiffness`: not positive, or above 1.
    pub fn check(&self) -> Result<(), ContactError> {
        ContactError::unless_not_negative("friction", self.friction)?;
        ContactError::unless_not_negative("adhesion", self.adhesion)?;
        let is_part = (0.0..=1.0).contains(&self.adhesion_factor);
        let expected = "between 0 and 1: the body yields where the interface is stronger than it";
        ContactError::unless(is_part, "adhesion_factor", self.adhesion_factor, expected)?;
        let is_stiff = self.stiffness >= 1.0 && self.stiffness.is_finite();
        ContactError::unless(is_stiff, "stiffness", self.stiffness, "a finite number of at least 1")?;
        let expected = "more than 0 and at most 1";
        let is_part = self.shear_stiffness > 0.0 && self.shear_stiffness <= 1.0;
        ContactError::unless(is_part, "shear_stiffness", self.shear_stiffness, expected)?;
        Ok(())
    }
}

/// The interface's numbers at one corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerLaw {
    /// k `[F/L]`.
    pub stiffness: f64,
    /// `k_T/k` `[-]`.
    pub shear: f64,
    /// μ `[-]`.
    pub friction: f64,
    /// a: what adhesion holds, its strength times the corner's share of the surface `[F]`; more than zero for members of the interface only.
    pub adhesion: f64,
    /// w: width of the point's domain at rest, `(V⁰)^(1/D)` `[L]`.
    pub width: f64,
}

impl CornerLaw {
    /// `k = s E w^(D-2) / 2^(D-1)` for Young's modulus E `[F/L²]`, the width w `[L]` and the `dimension` D; `adhesion`
    /// `[F]` is what the corner's share of the surface holds.
    pub fn new(interface: &Interface, young: f64, width: f64, dimension: u8, adhesion: f64) -> Self {
        let d = i32::from(dimension);
        let stiffness = interface.stiffness * young * width.powi(d - 2) / f64::powi(2.0, d - 1);
        let Interface { friction, shear_stiffness: shear, .. } = *interface;
        Self { stiffness, shear, friction, adhesion, width }
    }

    /// `k_T` `[F/L]`.
    pub fn shear_stiffness(&self) -> f64 {
        self.shear * self.stiffness
    }
}

/// What a corner did in the last accepted step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// It did not touch.
    Open,
    /// It stuck.
    Stuck,
    /// It slipped, or touched what is smooth.
    Slipping,
}

/// What one corner remembers of one part of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerState<const D: usize> {
    /// A: where it would stand without tangential force, in the tool's frame `[L]`.
    pub anchor: Vector<D>,
    /// The normal at which it touched last, in the tool's frame: by it a corner that touches two faces knows which
    /// state is whose.
    pub normal: Vector<D>,
    /// λ: the normal force carried over from an augmentation `[F]`.
    pub multiplier: f64,
    /// g⁰ `[L]`: how deep it stood inside when nothing pressed, at most 0; of a held corner, its distance at the start.
    pub offset: f64,
    /// What it did in the last step.
    pub mode: Mode,
    /// Whether it may not come off.
    pub held: bool,
}

impl<const D: usize> CornerState<D> {
    /// A corner at `x` `[L]` that no force has acted on, with the tool at `pose`.
    pub fn at_rest(pose: &Pose<D>, x: &Vector<D>, near: &Near<D>) -> Self {
        Self {
            anchor: pose.recall(x),
            normal: pose.turn_back(&near.normal),
            multiplier: 0.0,
            offset: near.distance.min(0.0),
            mode: Mode::Open,
            held: false,
        }
    }

    /// The same, held both ways for good.
    pub fn held(pose: &Pose<D>, x: &Vector<D>, near: &Near<D>) -> Self {
        Self { offset: near.distance, held: true, ..Self::at_rest(pose, x, near) }
    }

    /// After an augmentation: the normal force of `response` becomes the multiplier.
    #[must_use]
    pub fn augmented(&self, response: &Response<D>) -> Self {
        Self { multiplier: response.normal_force, ..*self }
    }

    /// After an accepted step. The anchor keeps the elastic part of the slip only, and turns with the tool; the offset
    /// only shrinks; the multiplier is dropped where the corner opens.
    #[must_use]
    pub fn committed(&self, law: &CornerLaw, trial: &Trial<'_, D>, response: &Response<D>) -> Self {
        let elastic = response.tangential / law.shear_stiffness();
        Self {
            anchor: trial.pose.recall(&(trial.position + elastic)),
            normal: trial.pose.turn_back(&trial.near.normal),
            multiplier: if response.closed { self.multiplier } else { 0.0 },
            offset: if self.held { self.offset } else { self.offset.max(trial.near.distance.min(0.0)) },
            mode: response.mode,
            held: self.held,
        }
    }
}

/// Where a corner is tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a, const D: usize> {
    /// x `[L]`.
    pub position: Vector<D>,
    /// What is near there, in space, with the tool at its pose.
    pub near: &'a Near<D>,
    /// The tool's pose at the end of the step.
    pub pose: &'a Pose<D>,
    /// Whether this is the first evaluation of a step: what stuck in the last step, and what touches without pressing,
    /// is predicted to stick.
    pub first: bool,
}

/// Force of a tool on a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response<const D: usize> {
    /// F on the body `[F]`; -F acts on the tool.
    pub force: Vector<D>,
    /// F_N `[F]`; negative only where a held corner is pulled.
    pub normal_force: f64,
    /// T `[F]`.
    pub tangential: Vector<D>,
    /// g `[L]`.
    pub gap: f64,
    /// Whether the normal force follows the gap.
    pub closed: bool,
    /// What the corner does.
    pub mode: Mode,
}

impl<const D: usize> Response<D> {
    /// Stored in the springs, `F_N²/2k + T²/2k_T` `[F L]`.
    pub fn stored(&self, law: &CornerLaw) -> f64 {
        let tangential = self.tangential.norm_squared() / law.shear;
        (self.normal_force * self.normal_force + tangential) / (2.0 * law.stiffness)
    }
}

/// Which tangent is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tangent {
    /// The derivative of the force; not symmetric where a corner slips with friction or the surface curves.
    Exact,
    /// Its symmetric part without Coulomb's `μ k τ⊗n`; exact for flat surfaces without friction.
    Symmetric,
}

/// t `[F]`, the limit L `[F]`, and whether the corner sticks.
struct Shear<const D: usize> {
    elastic: Vector<D>,
    limit: f64,
    sticks: bool,
}

/// The force on a corner.
pub fn respond<const D: usize>(law: &CornerLaw, state: &CornerState<D>, trial: &Trial<'_, D>) -> Response<D> {
    let gap = trial.near.distance - state.offset;
    let pressed = state.multiplier - law.stiffness * gap;
    let closed = state.held || pressed > 0.0 || (trial.first && touches(law, pressed));
    let normal_force = if state.held { pressed } else { pressed.max(0.0) };
    let Shear { elastic, limit, sticks } = shear(law, state, trial, normal_force, closed);
    let tangential = if sticks { elastic } else { slip_force(&elastic, limit) };
    let mode = match (sticks, closed || law.adhesion > 0.0) {
        (true, _) => Mode::Stuck,
        (false, true) => Mode::Slipping,
        (false, false) => Mode::Open,
    };
    let force = trial.near.normal * normal_force + tangential;
    Response { force, normal_force, tangential, gap, closed, mode }
}

/// Whether a corner neither presses nor stands apart.
fn touches(law: &CornerLaw, pressed: f64) -> bool {
    pressed.abs() <= TOUCH * law.stiffness * law.width
}

fn shear<const D: usize>(
    law: &CornerLaw,
    state: &CornerState<D>,
    trial: &Trial<'_, D>,
    normal_force: f64,
    closed: bool,
) -> Shear<D> {
    let n = trial.near.normal;
    let d = trial.position - trial.pose.place(&state.anchor);
    let elastic = (d - n * n.dot(&d)) * -law.shear_stiffness();
    let limit = law.friction * normal_force.max(0.0) + law.adhesion;
    let can_hold = law.adhesion > 0.0 || (law.friction > 0.0 && closed);
    // What the tool has run over in this step has not stuck yet.
    let fresh = state.mode == Mode::Open && normal_force <= TOUCH * law.stiffness * law.width;
    let predicted = trial.first && (state.mode == Mode::Stuck || fresh);
    let sticks = can_hold && (predicted || (limit > 0.0 && elastic.norm() <= limit));
    Shear { elastic, limit, sticks }
}

fn slip_force<const D: usize>(elastic: &Vector<D>, limit: f64) -> Vector<D> {
    if limit > 0.0 { elastic * (limit / elastic.norm()) } else { Vector::zeros() }
}

/// `-∂F/∂x` `[F/L]` of the force that [`respond`] has given for the same arguments.
pub fn tangent<const D: usize>(
    law: &CornerLaw,
    state: &CornerState<D>,
    trial: &Trial<'_, D>,
    response: &Response<D>,
    kind: Tangent,
) -> Block<D> {
    let (n, hessian, k) = (trial.near.normal, trial.near.hessian, law.stiffness);
    let mut block = Block::zeros();
    if response.closed {
        block += n * n.transpose() * k - hessian * response.normal_force;
    }
    let Shear { elastic, limit, sticks } = shear(law, state, trial, response.normal_force, response.closed);
    if sticks || limit > 0.0 {
        let d = trial.position - trial.pose.place(&state.anchor);
        // -∂t/∂x = k_T ∂dT/∂x.
        let spring =
            (Block::identity() - n * n.transpose() - n * (hessian * d).transpose() - hessian * n.dot(&d))
                * law.shear_stiffness();
        if sticks {
            block += spring;
        } else {
            let size = elastic.norm();
            let tau = elastic / size;
            block += (spring - tau * (tau.transpose() * spring)) * (limit / size);
            if kind == Tangent::Exact && response.closed && response.normal_force > 0.0 {
                block += tau * n.transpose() * (law.friction * k);
            }
        }
    }
    match kind {
        Tangent::Exact => block,
        Tangent::Symmetric => (block + block.transpose()) * 0.5,
    }
}

/// `dF` `[F]` of a corner that stays, where the tool moves there by `velocity` and turns by `spin` `[-]`:
/// `K velocity + spin × F` with the exact tangent K and the force F of the corner. [`crate::Increment`] tells both.
pub fn force_by_motion<const D: usize>(
    tangent: &Block<D>,
    force: &Vector<D>,
    velocity: &Vector<D>,
    spin: &Vector3<f64>,
) -> Vector<D> {
    tangent * velocity + cross(spin, force)
}
