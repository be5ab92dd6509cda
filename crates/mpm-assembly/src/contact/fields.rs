//! What results can show of contact at material points.

use super::corners::{Contact, NearCorner};
use super::memory::{Memory, TouchedPoint};
use crate::body::Body;
use crate::contribution::{Joined, PointField};
use mpm_basis::parallel::each_point;
use mpm_contact::{Pose, Tool};
use mpm_grid::Vector;
use mpm_material::FieldInfo;

/// Force of tools on the point `[F]`, three components.
pub(super) const FORCE: &str = "contact_force";

/// Least signed distance of a corner of the point's domain to a tool `[L]`; of its position, where it has no domain.
pub(super) const GAP: &str = "contact_gap";

/// How far the point has slipped along tools so far `[L]`: in every step as far as that of its corners which slips most.
pub(super) const SLIP: &str = "contact_slip";

/// All fields of contact.
pub(super) const FIELDS: &[PointField] = &[
    PointField { info: FieldInfo { name: FORCE, components: 3, unit: "F" }, joined: Joined::Sum },
    PointField { info: FieldInfo { name: GAP, components: 1, unit: "L" }, joined: Joined::Least },
    PointField { info: FieldInfo { name: SLIP, components: 1, unit: "L" }, joined: Joined::Sum },
];

/// What points that touch a tool at `pose` tell of a step.
pub(super) fn touched<const D: usize>(
    corners: &[NearCorner<D>],
    contacts: &[Vec<Contact<D>>],
    pose: &Pose<D>,
) -> Vec<TouchedPoint<D>> {
    let place = |corner: &NearCorner<D>| [corner.key.body, corner.key.point];
    let mut points: Vec<TouchedPoint<D>> = Vec::new();
    for (corner, contacts) in corners.iter().zip(contacts) {
        for contact in contacts.iter().filter(|it| it.response.closed || it.law.adhesion > 0.0) {
            let (force, slip) = (contact.response.force, contact.slip(pose).norm());
            match points.last_mut().filter(|last| last.place == place(corner)) {
                Some(last) => (last.force, last.slip) = (last.force + force, last.slip.max(slip)),
                None => points.push(TouchedPoint { place: place(corner), force, slip }),
            }
        }
    }
    points
}

/// What the points that have touched a tool tell, for all points: `width` numbers of each.
pub(super) fn of_touched<const D: usize>(
    memory: &Memory<D>,
    bodies: &[&dyn Body<D>],
    width: usize,
    tell: impl Fn(&TouchedPoint<D>, &mut [f64]),
) -> Vec<f64> {
    let mut values = Vec::with_capacity(bodies.len());
    for (body, points) in bodies.iter().enumerate() {
        let first = values.len();
        values.resize(first + points.n_points() * width, 0.0);
        for touched in memory.points.iter().filter(|it| it.place[0] as usize == body) {
            let own = values[first..].chunks_exact_mut(width).nth(touched.place[1] as usize);
            own.into_iter().for_each(|to| tell(touched, to));
        }
    }
    values
}

/// Gaps of all points to a tool at `pose`, whether or not their bodies meet it.
pub(super) fn gaps<const D: usize>(tool: &Tool<D>, pose: &Pose<D>, bodies: &[&dyn Body<D>]) -> Vec<f64> {
    let gap = |body: &dyn Body<D>, point: usize| {
        let corners = body.outline(point);
        let distance = |x: &Vector<D>| tool.distance(&pose.recall(x));
        match corners.is_empty() {
            true => distance(&body.point(point).position),
            false => corners.iter().map(distance).fold(f64::INFINITY, f64::min),
        }
    };
    bodies.iter().flat_map(|&body| each_point(body.n_points(), &|point| gap(body, point))).collect()
}
