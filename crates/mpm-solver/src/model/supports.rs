//! Displacements that are prescribed on nodes of the mesh.

use mpm_grid::{LoadFraction, Mesh, NodeId, Ramp, Vector};

/// Prescribed displacements of a set of nodes.
#[derive(Clone, Debug)]
pub struct Support<const D: usize> {
    /// Its name in the results.
    pub name: String,
    /// Its nodes, ascending; those that carry no material are ignored.
    pub nodes: Vec<NodeId>,
    /// What is prescribed of each component, if anything.
    pub components: [Option<Prescribed>; D],
    /// Point about which the moment of the reaction is recorded, if it is; the third coordinate is 0 in the plane `[L]`.
    pub moment_about: Option<[f64; 3]>,
    /// When it acts.
    pub active: Active,
}

impl<const D: usize> Support<D> {
    /// Whether it acts in a stage.
    pub fn acts_in(&self, stage: u32) -> bool {
        let Active { from, until, .. } = self.active;
        stage >= from && until.is_none_or(|until| stage < until)
    }

    /// Whether it ends in a stage, over which what it carries is released.
    pub(crate) fn is_released_in(&self, stage: u32) -> bool {
        self.active.until == Some(stage) && self.active.release == Release::Linear
    }

    /// Whether it moves its nodes.
    pub(crate) fn drives(&self) -> bool {
        self.components.iter().flatten().any(|it| *it != Prescribed::Held)
    }
}

/// In which stages of the schedule a support acts. It takes hold of its nodes where they then are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Active {
    /// The stage with which it begins, from 0.
    pub from: u32,
    /// The stage in which it ends, if it does: its nodes are free from the start of that stage on.
    pub until: Option<u32>,
    /// What becomes of the force that it carries at its end.
    pub release: Release,
}

/// How the force that a support carries goes, once the support has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Release {
    /// It acts on the nodes as a force from outside and falls to 0 linearly over the stage in which the support ends.
    #[default]
    Linear,
    /// It is out of balance in the first load step of that stage.
    AtOnce,
}

/// How a component of displacement is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub enum Prescribed {
    /// Zero.
    Held,
    /// A displacement against the load fraction, from rest on: a ramp that is not 0 at fraction 0, or in a later stage not
    /// where the stage before has left it, jumps in the first load step `[L]`.
    Driven(Ramp),
    /// The motion of the mesh.
    FollowMesh,
    /// A rotation, of which this is a component across the axis.
    Turned(Turn),
}

/// The two directions across an axis, in their order.
pub fn across(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

impl Prescribed {
    /// The ramp that it follows, if it has one of its own.
    pub fn ramp(&self) -> Option<&Ramp> {
        match self {
            Self::Driven(ramp) => Some(ramp),
            Self::Turned(turn) => Some(&turn.angle),
            Self::Held | Self::FollowMesh => None,
        }
    }

    /// Whether it is a part of a rotation.
    pub fn is_turn(&self) -> bool {
        matches!(self, Self::Turned(_))
    }

    /// Whether it jumps in the first load step of a stage.
    pub fn jumps_in(&self, stage: u32) -> bool {
        self.ramp().is_some_and(|ramp| ramp.jumps_in(stage))
    }
}

/// A rotation about an axis along a direction of space.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Direction of the axis, from 0; 2 in the plane.
    pub axis: usize,
    /// Where the axis passes, by the coordinates across it in their order `[L]`.
    pub centre: [f64; 2],
    /// Angle against the load fraction, right-handed about the axis `[rad]`.
    pub angle: Ramp,
}

impl Turn {
    /// The two directions across the axis, in their order.
    pub fn across(&self) -> [usize; 2] {
        across(self.axis)
    }

    /// Whether a position lies on the axis, up to rounding of coordinates as large as those of a mesh.
    pub fn is_at_axis<const D: usize>(&self, x: &Vector<D>, mesh: &Mesh<D>) -> bool {
        let corner = mesh.position(NodeId::from_index(0).expect("a mesh has nodes"));
        let size = (x - corner).amax().max(corner.amax());
        let [d, e] = self.across();
        (x[d] - self.centre[0]).hypot(x[e] - self.centre[1]) <= 1e-12 * size
    }

    /// `(R(Δα) - I)(x - c)` of what stands at `x` at the start of a load step `[L]`.
    pub fn displacement<const D: usize>(
        &self,
        x: &Vector<D>,
        start: LoadFraction,
        end: LoadFraction,
    ) -> Vector<D> {
        let angle = self.angle.from_rest(end) - self.angle.from_rest(start);
        // x, z, y is left-handed.
        let sine = if self.axis == 1 { -angle.sin() } else { angle.sin() };
        // cos - 1 without the difference.
        let less = -2.0 * (0.5 * angle).sin().powi(2);
        let [d, e] = self.across();
        let (a, b) = (x[d] - self.centre[0], x[e] - self.centre[1]);
        Vector::from_fn(|i, _| match i {
            i if i == d => less * a - sine * b,
            i if i == e => sine * a + less * b,
            _ => 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_right_handed_about_its_axis() {
        let quarter = |axis: usize, x: [f64; 3]| {
            let angle = Ramp::linear(std::f64::consts::FRAC_PI_2);
            let turn = Turn { axis, centre: [0.0, 0.0], angle };
            let x = Vector::<3>::from(x);
            x + turn.displacement(&x, LoadFraction::START, LoadFraction::END)
        };
        let near = |found: Vector<3>, expected: [f64; 3]| {
            assert!((found - Vector::<3>::from(expected)).norm() < 1e-15)
        };
        near(quarter(2, [1.0, 0.0, 5.0]), [0.0, 1.0, 5.0]);
        near(quarter(0, [5.0, 1.0, 0.0]), [5.0, 0.0, 1.0]);
        near(quarter(1, [0.0, 5.0, 1.0]), [1.0, 5.0, 0.0]);
        // About another centre, which stays; the distance from it is kept.
        let turn = Turn { axis: 1, centre: [2.0, 3.0], angle: Ramp::linear(0.7) };
        let at = |x: [f64; 3]| turn.displacement(&Vector::<3>::from(x), LoadFraction::START, LoadFraction::END);
        assert_eq!(at([2.0, 9.0, 3.0]).norm(), 0.0);
        let moved = Vector::<3>::new(1.5, 0.0, -0.5) + at([3.5, 9.0, 2.5]);
        assert!((moved.norm() - 1.5_f64.hypot(0.5)).abs() < 1e-15);
    }
}
