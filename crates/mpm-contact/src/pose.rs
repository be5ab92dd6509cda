//! Where a tool stands: a rotation and a translation, and small changes of them that a balance of forces decides.

use mpm_grid::{Block, Vector};
use nalgebra::Vector3;

/// `x = R X + s`: where a tool's point `X` `[L]` in its own frame stands in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<const D: usize> {
    rotation: Block<D>,
    shift: Vector<D>,
}

impl<const D: usize> Default for Pose<D> {
    fn default() -> Self {
        Self::identity()
    }
}

impl<const D: usize> Pose<D> {
    /// The tool's frame is the one of space.
    pub fn identity() -> Self {
        Self { rotation: Block::identity(), shift: Vector::zeros() }
    }

    /// A rotation matrix and a shift `[L]`, as [`Self::rotation`] and [`Self::shift`] have told them.
    pub fn new(rotation: Block<D>, shift: Vector<D>) -> Self {
        Self { rotation, shift }
    }

    /// Turned by the rotation vector `turn` `[rad]` about `centre` `[L]`, then moved by `shift` `[L]`.
    pub fn turned(centre: &Vector<D>, turn: &Vector3<f64>, shift: &Vector<D>) -> Self {
        let rotation = rotation(turn);
        Self { rotation, shift: centre + shift - rotation * centre }
    }

    /// R `[-]`.
    pub fn rotation(&self) -> &Block<D> {
        &self.rotation
    }

    /// s `[L]`.
    pub fn shift(&self) -> &Vector<D> {
        &self.shift
    }

    /// Where the tool's point `rest` `[L]` stands.
    #[inline]
    pub fn place(&self, rest: &Vector<D>) -> Vector<D> {
        self.rotation * rest + self.shift
    }

    /// Which of the tool's points stands at `x` `[L]`: the inverse of [`Self::place`].
    #[inline]
    pub fn recall(&self, x: &Vector<D>) -> Vector<D> {
        self.rotation.tr_mul(&(x - self.shift))
    }

    /// A direction of the tool's frame in space.
    #[inline]
    pub fn turn(&self, direction: &Vector<D>) -> Vector<D> {
        self.rotation * direction
    }

    /// A direction in space in the tool's frame.
    #[inline]
    pub fn turn_back(&self, direction: &Vector<D>) -> Vector<D> {
        self.rotation.tr_mul(direction)
    }

    /// The pose after an increment: the tool's point `about` `[L]`, in its own frame, moves by `increment.shift`, and
    /// the tool turns about it.
    #[must_use]
    pub fn moved(&self, about: &Vector<D>, increment: &Increment<D>) -> Self {
        let target = self.place(about) + increment.shift;
        let product = rotation::<D>(&increment.turn) * self.rotation;
        // One step of Newton's method for the nearest rotation: products of many steps stay rotations.
        let rotation = product * (Block::identity() * 1.5 - product.tr_mul(&product) * 0.5);
        Self { rotation, shift: target - rotation * about }
    }
}

/// A small rigid motion: the shift of a reference point and a rotation vector, in the plane its third component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment<const D: usize> {
    /// Of the reference point `[L]`.
    pub shift: Vector<D>,
    /// Rotation vector `[rad]`, in space.
    pub turn: Vector3<f64>,
}

impl<const D: usize> Default for Increment<D> {
    fn default() -> Self {
        Self { shift: Vector::zeros(), turn: Vector3::zeros() }
    }
}

impl<const D: usize> Increment<D> {
    /// Components of a rigid motion: D shifts, then one turn in the plane, three in space.
    pub const COMPONENTS: usize = D + D * (D - 1) / 2;

    /// The increment with these [`Self::COMPONENTS`] values.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn from_slice(q: &[f64]) -> Self {
        let mut increment = Self::default();
        for (k, value) in q.iter().enumerate().take(Self::COMPONENTS) {
            match Self::turn_axis(k) {
                None => increment.shift[k] = *value,
                Some(axis) => increment.turn[axis] = *value,
            }
        }
        assert!(q.len() >= Self::COMPONENTS, "a rigid motion has {} components", Self::COMPONENTS);
        increment
    }

    /// Its value of component `k`.
    pub fn component(&self, k: usize) -> f64 {
        Self::turn_axis(k).map_or_else(|| self.shift[k], |axis| self.turn[axis])
    }

    /// The axis that component `k` turns about; `None` for a shift.
    pub fn turn_axis(k: usize) -> Option<usize> {
        k.checked_sub(D).map(|turn| if D == 2 { 2 } else { turn })
    }

    /// ω: the tool turns by `ω dq` `[-]` where component `k` changes by dq; zero for a shift.
    pub fn spin(&self, k: usize) -> Vector3<f64> {
        Self::turn_axis(k).map_or_else(Vector3::zeros, |axis| left_jacobian(&self.turn, axis))
    }

    /// `∂x/∂q_k` of the tool's point that stands at `arm` `[L]` from the reference point, both at the end of the
    /// increment.
    pub fn velocity(&self, k: usize, arm: &Vector<D>) -> Vector<D> {
        match Self::turn_axis(k) {
            None => Vector::from_fn(|d, _| if d == k { 1.0 } else { 0.0 }),
            Some(_) => cross(&self.spin(k), arm),
        }
    }
}

/// `ω × v`; in the plane ω stands upright.
#[inline]
pub fn cross<const D: usize>(spin: &Vector3<f64>, v: &Vector<D>) -> Vector<D> {
    let at = |d: usize| if d < D { v[d] } else { 0.0 };
    let turned = spin.cross(&Vector3::new(at(0), at(1), at(2)));
    Vector::from_fn(|d, _| turned[d])
}

/// `arm × force` `[F L]`; in the plane its third component alone.
#[inline]
pub fn moment<const D: usize>(arm: &Vector<D>, force: &Vector<D>) -> Vector3<f64> {
    let whole = |v: &Vector<D>| Vector3::from_fn(|d, _| if d < D { v[d] } else { 0.0 });
    whole(arm).cross(&whole(force))
}

/// R = exp([θ]×) by Rodrigues' formula; in the plane a rotation about the third axis.
fn rotation<const D: usize>(turn: &Vector3<f64>) -> Block<D> {
    let (a, b, _) = coefficients(turn.norm());
    let cross = turn.cross_matrix();
    let square = cross * cross;
    Block::from_fn(|i, j| {
        let identity = if i == j { 1.0 } else { 0.0 };
        identity + a * cross[(i, j)] + b * square[(i, j)]
    })
}

/// Column `axis` of the left Jacobian `J = I + b [θ]× + c [θ]×²`: `d exp(θ) = [J dθ]× exp(θ)`.
fn left_jacobian(turn: &Vector3<f64>, axis: usize) -> Vector3<f64> {
    let (_, b, c) = coefficients(turn.norm());
    let unit = Vector3::ith(axis, 1.0);
    let once = turn.cross(&unit);
    unit + once * b + turn.cross(&once) * c
}

/// `sin θ/θ`, `(1 - cos θ)/θ²`, `(θ - sin θ)/θ³`.
fn coefficients(angle: f64) -> (f64, f64, f64) {
    let square = angle * angle;
    let half = if angle == 0.0 { 1.0 } else { (0.5 * angle).sin() / (0.5 * angle) };
    let sine = if angle == 0.0 { 1.0 } else { angle.sin() / angle };
    // The series of the last: its closed form loses digits to cancellation.
    let third = if square < 0.25 {
        (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0)))) / 6.0
    } else {
        (1.0 - sine) / square
    };
    (sine, 0.5 * half * half, third)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_undone() {
        let turn = Vector3::new(0.3, -1.2, 2.0);
        let pose = Pose::turned(&Vector::<3>::new(1.0, 2.0, 3.0), &turn, &Vector::<3>::new(0.1, 0.2, -0.5));
        let x = Vector::<3>::new(-0.7, 0.4, 5.0);
        assert!((pose.recall(&pose.place(&x)) - x).norm() < 1e-14);
        assert!((pose.rotation().tr_mul(pose.rotation()) - Block::<3>::identity()).norm() < 1e-14);
        assert!((pose.turn_back(&pose.turn(&x)) - x).norm() < 1e-14);
    }

    #[test]
    fn velocities_agree_with_finite_differences() {
        let base =
            Pose::turned(&Vector::<3>::zeros(), &Vector3::new(0.2, 0.1, -0.4), &Vector::<3>::repeat(0.3));
        let about = Vector::<3>::new(0.5, -0.2, 0.1);
        let rest = Vector::<3>::new(1.5, 0.7, -1.1);
        for size in [0.0, 1e-5, 0.3, 1.7] {
            let q = [0.1, -0.2, 0.3, 0.5 * size, -0.7 * size, 0.4 * size];
            let at = |q: &[f64]| base.moved(&about, &Increment::from_slice(q));
            let pose = at(&q);
            let increment = Increment::<3>::from_slice(&q);
            let arm = pose.place(&rest) - pose.place(&about);
            for k in 0..Increment::<3>::COMPONENTS {
                let step = 1e-6;
                let moved = |by: f64| {
                    let mut other = q;
                    other[k] += by;
                    at(&other).place(&rest)
                };
                let difference = (moved(step) - moved(-step)) / (2.0 * step);
                assert!((difference - increment.velocity(k, &arm)).norm() < 1e-9, "{k} at {size}");
            }
        }
    }

    #[test]
    fn the_plane_turns_about_its_upright() {
        let q = [0.0, 0.0, std::f64::consts::FRAC_PI_2];
        let pose = Pose::<2>::identity().moved(&Vector::<2>::new(1.0, 0.0), &Increment::from_slice(&q));
        assert!((pose.place(&Vector::<2>::new(2.0, 0.0)) - Vector::<2>::new(1.0, 1.0)).norm() < 1e-15);
        assert_eq!(Increment::<2>::COMPONENTS, 3);
        assert_eq!(Increment::<2>::turn_axis(2), Some(2));
    }

    #[test]
    fn many_increments_stay_rigid() {
        let increment = Increment::<3>::from_slice(&[0.0, 0.0, 0.0, 0.01, 0.02, -0.015]);
        let about = Vector::<3>::new(0.1, 0.0, 0.0);
        let pose = (0..10_000).fold(Pose::identity(), |pose, _| pose.moved(&about, &increment));
        assert!((pose.rotation().tr_mul(pose.rotation()) - Block::<3>::identity()).norm() < 1e-14);
    }
}
