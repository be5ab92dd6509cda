//! The search for corners that a tool may touch in a load step.

use super::areas::{Member, Samples, sampling, shares};
use super::corners::{NearCorner, travel};
use super::members::Members;
use super::memory::{Key, Memory, Sought};
use crate::body::{Body, PointExtent, Space};
use crate::contribution::{Refused, StepStart};
use mpm_basis::parallel::each_point;
use mpm_basis::{ActiveNodes, Corner};
use mpm_contact::{CornerLaw, CornerState, Interface, Near, Pose, Sample, Tool};
use mpm_grid::{Mesh, Position, Vector};
use std::f64::consts::TAU;

/// Widths of a domain, beyond what the tool moves, within which corners are looked for.
const MARGIN: f64 = 2.0;

/// Part of a domain's extent across the surface within which its corners belong to the interface, and adhesion acts on them.
/// Corners of domains that follow a curved surface stand off it by a part of this.
pub(super) const WITHIN: f64 = 0.25;

/// The same of a body that is cut along the tool and ends in stairs, of one that never parts from it, and of points that have touched:
/// corners of a second row of domains are just out.
pub(super) const WITHIN_OF_STAIRS: f64 = 0.9;

/// What a search for corners knows.
pub(super) struct Search<'a, const D: usize> {
    pub tool: &'a Tool<D>,
    pub interface: &'a Interface,
    pub memory: &'a Memory<D>,
    /// Space of the bodies.
    pub space: Space,
    /// Poses at the start and at the end of the step.
    pub start: Pose<D>,
    pub end: Pose<D>,
}

/// Points whose corners are sought at a time: their lists are joined to one, and given back, before the next.
const POINTS: usize = 4096;

/// The corners that were found.
struct Found<const D: usize> {
    corners: Vec<NearCorner<D>>,
    /// Those that belong to the interface.
    members: Vec<FoundMember<D>>,
}

/// A corner that belongs to the interface.
struct FoundMember<const D: usize> {
    /// Its number among those that were found.
    corner: usize,
    /// The part of the tool that it is next to.
    part: u32,
    member: Member<D>,
}

impl<const D: usize> Search<'_, D> {
    /// All corners of the bodies that meet the tool, in the order of points, parts and corners. `member_within` says of each
    /// body within which part of a domain its corners belong to the interface; nothing of those that do not meet it.
    ///
    /// # Errors
    /// A point stands inside the tool at the start of the run.
    pub fn corners(
        &self,
        step: &StepStart<'_, D>,
        member_within: &[Option<f64>],
        samples: &mut Samples<D>,
    ) -> Result<Vec<NearCorner<D>>, Refused> {
        let found = self.found(step, member_within);
        // All who share the tool's surface share it out, whether or not they have failed.
        let of_one = |found: &Found<D>| found.members.iter().map(|it| (it.part, it.member)).collect();
        let members = Members::of_all(found.as_ref().map(of_one).unwrap_or_default(), step.sharing);
        let mut found = found?;
        self.share_surface(&mut found, &members, step.mesh, samples);
        Ok(found.corners)
    }

    /// The corners, with the places of the surface next to those that belong to the interface.
    fn found(&self, step: &StepStart<'_, D>, member_within: &[Option<f64>]) -> Result<Found<D>, Refused> {
        let mut found = Found { corners: Vec::new(), members: Vec::new() };
        let nodes = (step.mesh, step.active);
        for (index, at_start) in step.bodies.iter().enumerate() {
            let Some(within) = member_within[index] else { continue };
            let body = at_start.body;
            let (young, n) = (body.young(), body.n_points());
            for first in (0..n).step_by(POINTS) {
                let of_point = |k: usize| self.of_point(nodes, (index, body, within), young, first + k);
                for of_point in each_point(POINTS.min(n - first), &of_point) {
                    let in_body = |reason| Refused::here(format!("in body `{}` {reason}", at_start.name));
                    for (corner, member) in of_point.map_err(in_body)? {
                        let (number, part) = (found.corners.len(), corner.key.part);
                        found.members.extend(member.map(|member| FoundMember { corner: number, part, member }));
                        found.corners.push(corner);
                    }
                }
            }
        }
        found.corners.shrink_to_fit();
        Ok(found)
    }

    /// Corners of one point.
    fn of_point(
        &self,
        (mesh, active): (&Mesh<D>, &ActiveNodes<D>),
        (index, body, within): (usize, &dyn Body<D>, f64),
        young: f64,
        point: usize,
    ) -> Result<Vec<(NearCorner<D>, Option<Member<D>>)>, String> {
        let PointExtent { position, width, radius } = body.extent(point);
        let adhesion = self.adhesion(body, point);
        let moved = travel(&position, [&self.start, &self.end], self.space).norm();
        let (mut corners, mut near, mut found) = (Vec::new(), Vec::new(), Vec::new());
        for part in 0..self.tool.n_parts() {
            near.clear();
            self.tool.near(part, &self.start, &position, radius + moved + MARGIN * width, &mut near);
            let Some(nearest) = near.first() else { continue };
            if !self.memory.has_begun && nearest.distance < 0.0 {
                return Err(format!(
                    "material point {point} at {} stands inside it at the start",
                    Position(&position)
                ));
            }
            if corners.is_empty() {
                body.corners(mesh, point, &mut corners).map_err(|it| it.to_string())?;
            }
            found.reserve_exact(corners.len());
            // What has touched is let go later: its corners turn away and others come, as it is sheared.
            let within = if self.memory.has_touched(index, point, part) { WITHIN_OF_STAIRS } else { within };
            for (number, corner) in corners.iter().enumerate() {
                let key =
                    Key { body: index as u32, point: point as u32, part: part as u32, corner: number as u32 };
                let dimensions = self.space.coordinates::<D>() as u8;
                let mut law = CornerLaw::new(self.interface, young, width, dimensions, 0.0);
                if body.space().is_axisymmetric() {
                    // By the corner's part of the ring: then a flat tool presses a uniform stress evenly.
                    law.stiffness *= TAU * position[0] * corners.len() as f64 * corner.share;
                }
                let mut made = NearCorner {
                    key,
                    position: corner.position,
                    left: corner.position,
                    // A node that is not active carries next to nothing.
                    carriers: corner
                        .weights()
                        .filter_map(|(node, weight)| Some((active.number(node)? as u32, weight)))
                        .collect(),
                    area: 0.0,
                    adhesion,
                    law,
                    states: Vec::new(),
                    arc: self.space.turns::<D>().then(|| corner.position[0].abs()),
                    reach: moved + (1.0 + MARGIN) * (width + radius),
                    clearance: moved + (1.0 + MARGIN) * (width + radius),
                };
                let member = self.take_up(&mut made, corner, (&corners, within), &mut near);
                found.push((made, member));
            }
        }
        Ok(found)
    }

    /// Shear strength of the interface at a point: by its own strength at the start of the step, so that the tangent is
    /// exact without the law's. A body whose law has none does not stick.
    fn adhesion(&self, body: &dyn Body<D>, point: usize) -> f64 {
        let Interface { adhesion, adhesion_factor, .. } = *self.interface;
        if adhesion_factor == 0.0 {
            return adhesion;
        }
        adhesion + adhesion_factor * body.undrained_strength(point).unwrap_or(0.0)
    }

    /// Gives a corner what it remembers; its foot on the surface, if it belongs to the interface.
    fn take_up(
        &self,
        made: &mut NearCorner<D>,
        corner: &Corner<D>,
        (corners, within): (&[Corner<D>], f64),
        near: &mut Vec<Near<D>>,
    ) -> Option<Member<D>> {
        near.clear();
        self.tool.near(made.key.part as usize, &self.start, &corner.position, made.reach, near);
        let nearest = *near.first()?;
        made.clearance = nearest.distance;
        let (width, n) = (made.law.width, nearest.normal);
        let across = corners.iter().map(|it| it.position.dot(&n));
        let (low, high) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let is_member = corner.area.dot(&n) < 0.0 && nearest.distance < within * (high - low);
        if self.memory.has_begun {
            let (key, position, distance) = (made.key, corner.position, nearest.distance);
            let recalled = self.memory.recall(&Sought { key, position, width, distance, pose: &self.start });
            (made.states, made.left) = (recalled.states, recalled.left);
        } else if is_member && !self.interface.separates {
            made.states = vec![CornerState::held(&self.start, &corner.position, &nearest)];
        } else {
            let inside = near.iter().filter(|near| near.distance < 0.0);
            made.states =
                inside.map(|near| CornerState::at_rest(&self.start, &corner.position, near)).collect();
        }
        let recall = |x: &Vector<D>| {
            let mut place = self.start.recall(x);
            if self.space.turns::<D>() {
                // The surface is the same at any angle, and its samples stand at 0.
                place[D - 1] = 0.0;
            }
            place
        };
        is_member.then(|| {
            let foot = recall(&(corner.position - n * nearest.distance));
            let corners = corners.iter().map(|corner| recall(&corner.position));
            Member::new(foot, &self.start.turn_back(&n), width, corners)
        })
    }

    /// Shares the tool's surface among the corners that belong to the interface. What lies outside the mesh is no part of it:
    /// the mesh of a half or a quarter ends at its planes of symmetry, and so do the bodies.
    fn share_surface(
        &self,
        found: &mut Found<D>,
        members: &Members<D>,
        mesh: &Mesh<D>,
        samples: &mut Samples<D>,
    ) {
        let Some((spacing, within)) = sampling(members.all()) else { return };
        let area = |sample: &Sample<D>| {
            // Whole rings of bodies of revolution; the tool's section is on both sides of the axis.
            let around = if self.space.is_axisymmetric() { TAU * sample.position[0].max(0.0) } else { 1.0 };
            let is_inside = mesh.locate(&self.start.place(&sample.position), 0.0).is_ok();
            is_inside.then_some(sample.area * around)
        };
        for (part, samples) in samples.of(self.tool, spacing, &within).iter().enumerate() {
            let (members, own) = members.of_part(part as u32);
            let of_part = found.members.iter().filter(|it| it.part as usize == part);
            for (it, area) in of_part.zip(&shares(&members, samples, area)[own]) {
                let corner = &mut found.corners[it.corner];
                corner.area = *area;
                corner.law.adhesion = corner.adhesion * area;
            }
        }
    }
}
