//! Prescribed motions of tools: pure functions of the load fraction, always from rest.

use crate::error::ContactError;
use crate::pose::Pose;
use mpm_grid::{LoadFraction, Ramp, Vector};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// How a tool moves with the load.
///
/// At load fraction 0 every motion is at rest, and at the start of a later stage where the stage before has left it, whatever
/// its ramps say there, as mesh motions are.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolMotion<const D: usize> {
    displacement: Option<[Ramp; D]>,
    turn: Option<Turn<D>>,
}

/// A rotation about an axis, with a shift along it.
#[derive(Clone, Debug, PartialEq)]
struct Turn<const D: usize> {
    through: Vector<D>,
    /// Unit vector; upright in the plane.
    axis: Vector3<f64>,
    /// `[rad]`, right-handed about the axis.
    angle: Ramp,
    /// Along the axis `[L]`.
    advance: Option<Ramp>,
}

impl<const D: usize> ToolMotion<D> {
    /// The tool stands.
    pub fn rest() -> Self {
        Self { displacement: None, turn: None }
    }

    /// The tool moves by `displacement` `[L]` without turning.
    ///
    /// # Errors
    /// `by`: a knot of a ramp is not finite.
    pub fn shifted(displacement: [Ramp; D]) -> Result<Self, ContactError> {
        displacement.iter().try_for_each(|ramp| finite("by", ramp))?;
        Ok(Self { displacement: Some(displacement), turn: None })
    }

    /// The tool turns by `angle` `[rad]` about an axis through `through` `[L]`, which moves by `displacement` `[L]`.
    /// In the plane the axis stands upright, and only the third component of `axis` counts.
    ///
    /// # Errors
    /// `by`, `angle`, `through`, `axis`: a number is not finite, or the axis has no length.
    pub fn turning(
        displacement: [Ramp; D],
        through: Vector<D>,
        axis: Vector3<f64>,
        angle: Ramp,
    ) -> Result<Self, ContactError> {
        let turn = Turn::new(through, axis, angle, None)?;
        Ok(Self { turn: Some(turn), ..Self::shifted(displacement)? })
    }

    /// The tool turns by `angle` `[rad]` about an axis through `through` `[L]` and moves along it by `advance` `[L]`.
    ///
    /// # Errors
    /// As of [`Self::turning`], and `advance`.
    pub fn screw(
        through: Vector<D>,
        axis: Vector3<f64>,
        angle: Ramp,
        advance: Ramp,
    ) -> Result<Self, ContactError> {
        finite("advance", &advance)?;
        Ok(Self { displacement: None, turn: Some(Turn::new(through, axis, angle, Some(advance))?) })
    }

    /// Displacement without a turn, where it is moved by one `[L]`.
    pub fn displacement(&self) -> Option<&[Ramp; D]> {
        self.displacement.as_ref()
    }

    /// The pose at a load fraction: `x = c + R(angle) (X - c) + shift`.
    pub fn pose(&self, at: LoadFraction) -> Pose<D> {
        let mut shift = match &self.displacement {
            Some(ramps) => Vector::from_fn(|d, _| ramps[d].from_rest(at)),
            None => Vector::zeros(),
        };
        let Some(turn) = &self.turn else {
            return if self.displacement.is_some() {
                Pose::new(*Pose::identity().rotation(), shift)
            } else {
                Pose::identity()
            };
        };
        if let Some(advance) = &turn.advance {
            shift += Vector::from_fn(|d, _| turn.axis[d]) * advance.from_rest(at);
        }
        // Whole turns are taken off, so that they leave nothing but the shift behind.
        let angle = turn.angle.from_rest(at);
        let rest = angle - TAU * (angle / TAU).round();
        Pose::turned(&turn.through, &(turn.axis * rest), &shift)
    }

    /// The angle by which the tool has turned about its axis `[rad]`, whole turns included.
    pub fn angle(&self, at: LoadFraction) -> f64 {
        self.turn.as_ref().map_or(0.0, |turn| turn.angle.from_rest(at))
    }

    /// Whether the tool stands at every load fraction.
    pub fn is_rest(&self) -> bool {
        self.displacement.is_none() && self.turn.is_none()
    }

    /// Its ramps.
    pub fn ramps(&self) -> Vec<&Ramp> {
        let turn = self.turn.iter().flat_map(|turn| [Some(&turn.angle), turn.advance.as_ref()]).flatten();
        self.displacement.iter().flatten().chain(turn).collect()
    }
}

impl<const D: usize> Turn<D> {
    fn new(
        through: Vector<D>,
        axis: Vector3<f64>,
        angle: Ramp,
        advance: Option<Ramp>,
    ) -> Result<Self, ContactError> {
        ContactError::unless_finite("through", through.as_slice())?;
        ContactError::unless_finite("axis", axis.as_slice())?;
        finite("angle", &angle)?;
        let axis = if D == 2 { Vector3::new(0.0, 0.0, axis[2]) } else { axis };
        let length = ContactError::unless_positive("axis", axis.norm())?;
        Ok(Self { through, axis: axis / length, angle, advance })
    }
}

fn finite(name: &'static str, ramp: &Ramp) -> Result<(), ContactError> {
    ramp.knots().try_for_each(|(_, value)| ContactError::unless_finite(name, &[value]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn at(fraction: f64) -> LoadFraction {
        LoadFraction::new(fraction).unwrap()
    }

    #[test]
    fn a_screw_advances_as_it_turns() {
        let through = Vector::<3>::new(1.0, 2.0, 0.0);
        let screw = ToolMotion::screw(through, Vector3::z() * 3.0, Ramp::linear(-4.0 * PI), Ramp::linear(-0.4))
            .unwrap();
        let x = Vector::<3>::new(1.5, 2.0, 0.0);
        assert_eq!(screw.pose(LoadFraction::START), Pose::identity());
        let quarter = screw.pose(at(0.125)).place(&x);
        assert!((quarter - Vector::<3>::new(1.0, 1.5, -0.05)).norm() < 1e-15);
        let end = screw.pose(LoadFraction::END).place(&x);
        assert_eq!(end, Vector::<3>::new(1.5, 2.0, -0.4));
        assert_eq!(screw.angle(LoadFraction::END), -4.0 * PI);
    }

    #[test]
    fn a_tool_turns_about_a_point_that_moves() {
        let by = [Ramp::linear(1.0), Ramp::constant(0.0)];
        let motion =
            ToolMotion::turning(by, Vector::<2>::new(0.0, 1.0), Vector3::z(), Ramp::linear(PI)).unwrap();
        let x = motion.pose(LoadFraction::END).place(&Vector::<2>::new(0.0, 2.0));
        assert!((x - Vector::<2>::new(1.0, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn bad_axes_are_refused() {
        let axis = |axis| ToolMotion::<3>::screw(Vector::zeros(), axis, Ramp::linear(1.0), Ramp::linear(1.0));
        assert_eq!(axis(Vector3::zeros()).unwrap_err().name, "axis");
        assert_eq!(axis(Vector3::new(f64::NAN, 0.0, 1.0)).unwrap_err().name, "axis");
    }
}
