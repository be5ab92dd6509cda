//! Forces on the bodies.

use mpm_assembly::{Body, PointForce, SideForce, views};
use mpm_grid::{LoadFraction, Ramp, Vector};
use std::fmt;
use std::sync::Arc;

/// A force per volume on the points of a body, for example that of a manufactured solution.
///
/// It must be a pure function, so that a load step that is cut, or a run that is resumed, meets the same force.
pub trait BodyForce<const D: usize>: fmt::Debug + Send + Sync {
    /// Force per volume at rest on the point that was at `rest` `[L]`, at a load fraction `[F/L^D]`.
    fn force(&self, rest: &Vector<D>, at: LoadFraction) -> Vector<D>;

    /// Ramps that it follows; a load step ends at each of their knots.
    fn ramps(&self) -> Vec<&Ramp> {
        Vec::new()
    }
}

/// Forces on the bodies.
#[derive(Clone, Debug, Default)]
pub struct Loads<const D: usize> {
    /// Body forces: force per mass at full load `[L/T²]` and its ramp. Bodies need masses, see
    /// [`mpm_assembly::MaterialBody::with_density`].
    pub body_forces: Vec<(Vector<D>, Ramp)>,
    /// Forces on single points.
    pub point_loads: Vec<PointLoad<D>>,
    /// Forces on sides of bodies of revolution.
    pub side_loads: Vec<SideLoad<D>>,
    /// Forces per volume on single bodies: the body's index, and the force. The body keeps positions at rest.
    pub fields: Vec<(usize, Arc<dyn BodyForce<D>>)>,
}

/// One load carried by points of one body.
#[derive(Clone, Debug)]
pub struct PointLoad<const D: usize> {
    /// Index of the body.
    pub body: usize,
    /// Points and what each carries, ascending in point; the parts sum to 1.
    pub shares: Vec<Share<D>>,
    /// The whole force at full load `[F]`.
    pub force: Vector<D>,
    /// Part of it against the load fraction.
    pub ramp: Ramp,
}

/// One load carried by sides of the domains of one body of revolution.
#[derive(Clone, Debug)]
pub struct SideLoad<const D: usize> {
    /// Index of the body.
    pub body: usize,
    /// The sides, with the parts of the whole force at their ends.
    pub sides: Vec<Side<D>>,
    /// The whole force on all rings at full load; of a traction along r, the area of the rings times the traction `[F]`.
    pub force: Vector<D>,
    /// Part of it against the load fraction.
    pub ramp: Ramp,
}

/// A straight side of a point's section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side<const D: usize> {
    /// The point.
    pub point: usize,
    /// From the point to the ends of the side, at rest `[L]`.
    pub arms: [Vector<D>; 2],
    /// Parts of the whole force that belong to the ends `[-]`.
    pub parts: [f64; 2],
}

/// A point's part of a load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share<const D: usize> {
    /// The point.
    pub point: usize,
    /// Part of the force that it carries `[-]`.
    pub part: f64,
    /// From the point to where its part acts, at rest `[L]`.
    pub arm: Vector<D>,
}

impl<const D: usize> Loads<D> {
    /// Body force per mass at a load fraction, if any acts at all `[L/T²]`.
    pub fn acceleration(&self, at: LoadFraction) -> Option<Vector<D>> {
        if self.body_forces.is_empty() {
            return None;
        }
        Some(self.body_forces.iter().fold(Vector::zeros(), |sum, (force, ramp)| sum + force * ramp.value(at)))
    }

    /// Forces on sides of one body at a load fraction `[F]`.
    pub fn side_forces(&self, body: usize, at: LoadFraction) -> Vec<SideForce<D>> {
        let of_load = |load: &SideLoad<D>| {
            let force = load.force * load.ramp.value(at);
            let side = |side: &Side<D>| {
                let part = side.parts[0] + side.parts[1];
                let parts = side.parts.map(|it| it / part);
                SideForce { point: side.point, force: force * part, arms: side.arms, parts }
            };
            load.sides.iter().map(side).collect::<Vec<_>>()
        };
        self.side_loads.iter().filter(|load| load.body == body).flat_map(of_load).collect()
    }

    /// Forces on the points of one body at a load fraction, ascending in point `[F]`.
    pub fn point_forces(&self, body: usize, points: &dyn Body<D>, at: LoadFraction) -> Vec<PointForce<D>> {
        let mut forces: Vec<PointForce<D>> = Vec::new();
        for load in self.point_loads.iter().filter(|load| load.body == body) {
            let force = load.force * load.ramp.value(at);
            forces.extend(load.shares.iter().map(|&Share { point, part, arm }| PointForce {
                point,
                force: force * part,
                arm,
            }));
        }
        for (_, field) in self.fields.iter().filter(|(index, _)| *index == body) {
            forces.extend(views(points).enumerate().map(|(point, view)| {
                let rest =
                    view.reference_position.expect("a body under a force per volume keeps positions at rest");
                let force = field.force(&rest, at) * view.reference_volume;
                PointForce { point, force, arm: Vector::zeros() }
            }));
        }
        forces.sort_by_key(|it| it.point);
        forces
    }
}
