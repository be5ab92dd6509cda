//! The corners that a tool may touch in a load step, and the forces on them under a trial.

use super::areas::{Member, sampling, shares};
use super::memory::{Key, Memory, Sought, Touch};
use crate::body::{Body, PointExtent, Space};
use crate::contribution::{Refused, StepStart};
use mpm_basis::Corner;
use mpm_basis::parallel::each_point;
use mpm_contact::{
    Bounds, CornerLaw, CornerState, Interface, Near, Pose, Response, Sample, Tangent, Tool, Trial, respond,
    tangent,
};
use mpm_grid::{Block, Mesh, Position, Vector};
use std::array::from_fn;
use std::f64::consts::TAU;

/// Widths of a domain, beyond what the tool moves, within which corners are looked for.
const MARGIN: f64 = 2.0;

/// Part of a domain's extent across the surface within which its corners belong to the interface: corners of a second row
/// of domains are just out.
const MEMBERS: f64 = 0.9;

/// Part of a domain's width by which a corner that is clear of a part stays away from it.
const CLEAR: f64 = 1e-6;

/// Cosine between normals in the tool's frame above which two places of a part are the same one.
const SAME_PLACE: f64 = 0.866_025_403_784_438_6;

/// A corner near a part of the tool; frozen through a load step.
#[derive(Clone, Debug)]
pub(super) struct NearCorner<const D: usize> {
    pub key: Key,
    /// `x_c` at the start of the step `[L]`.
    pub position: Vector<D>,
    /// Where it was at the end of the step before, to which its states belong `[L]`.
    pub left: Vector<D>,
    /// Active numbers of the nodes that carry it, and `W_cv`.
    pub carriers: Vec<(u32, f64)>,
    /// Its share of the tool's surface `[L^(D-1)]`.
    pub area: f64,
    /// Shear strength of the interface without pressure, at the start of the step `[F/L²]`.
    pub adhesion: f64,
    pub law: CornerLaw,
    /// What it remembers of places that it has touched.
    pub states: Vec<CornerState<D>>,
    /// Radius at the start of the step, of bodies that turn about their axis: what an angle is an arc of `[L]`.
    arc: Option<f64>,
    /// Distance within which places of the surface count `[L]`.
    reach: f64,
    /// How far the part was at the start of the step, at most `reach` `[L]`.
    clearance: f64,
}

/// A place of the tool's surface near a corner under a trial, and what happens there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact<const D: usize> {
    /// Where the corner is `[L]`.
    pub position: Vector<D>,
    pub near: Near<D>,
    pub law: CornerLaw,
    pub state: CornerState<D>,
    /// Which of the corner's states it is; none where the place was not touched before.
    pub remembered: Option<usize>,
    /// Force and gap in space.
    pub response: Response<D>,
    /// As of its corner.
    arc: Option<f64>,
}

/// A vector whose third component is an angle, with the arc in its place.
fn in_space<const D: usize>(mut x: Vector<D>, arc: Option<f64>) -> Vector<D> {
    if let Some(radius) = arc {
        x[D - 1] *= radius;
    }
    x
}

/// The pose of a tool whose shift has an angle, with the arc in its place.
fn pose_in_space<const D: usize>(pose: &Pose<D>, arc: Option<f64>) -> Pose<D> {
    if arc.is_none() { *pose } else { Pose::new(*pose.rotation(), in_space(*pose.shift(), arc)) }
}

/// How far a tool carries what stands at `x` from one pose to another, as far as it goes to another place `[L]`.
pub(super) fn travel<const D: usize>(x: &Vector<D>, [start, end]: [&Pose<D>; 2], space: Space) -> Vector<D> {
    let mut moved = end.place(&start.recall(x)) - x;
    if space.turns::<D>() {
        moved[D - 1] = 0.0;
    }
    moved
}

/// Where corners are and how the tool stands.
#[derive(Clone, Copy)]
pub(super) struct At<'a, const D: usize> {
    pub tool: &'a Tool<D>,
    /// Where the tool stood at the start of the step.
    pub start: &'a Pose<D>,
    pub pose: &'a Pose<D>,
    /// `Δu_v` of the active nodes `[L]`.
    pub increment: &'a [Vector<D>],
    pub is_first: bool,
}

impl<const D: usize> NearCorner<D> {
    /// Nodes that carry the corner, with their weights.
    pub fn weights(&self) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        self.carriers.iter().map(|&(node, weight)| (node as usize, weight))
    }

    /// The contacts that can have a force: those of [`Self::contacts`], or none where the corner stays clear of the part,
    /// which spares most corners the search for its nearest places.
    pub fn forces(&self, at: &At<'_, D>) -> Vec<Contact<D>> {
        let position = self.moved(at.increment);
        let stays_clear = self.clearance - self.shift(&position, at) > CLEAR * self.law.width;
        if stays_clear && self.law.adhesion == 0.0 && !self.may_pull() {
            return Vec::new();
        }
        self.contacts_at(position, at)
    }

    /// Whether the corner can have a force where it does not touch, beside adhesion.
    fn may_pull(&self) -> bool {
        self.states.iter().any(|state| state.held || state.multiplier != 0.0)
    }

    /// How far a place `[L]` is from that of the corner at the start of the step, as the tool sees it. Distances to its parts
    /// change by no more.
    fn shift(&self, position: &Vector<D>, at: &At<'_, D>) -> f64 {
        (at.pose.recall(position) - at.start.recall(&self.position)).norm()
    }

    /// Where the corner is after an increment `[L]`.
    fn moved(&self, increment: &[Vector<D>]) -> Vector<D> {
        self.weights().fold(self.position, |position, (node, weight)| position + increment[node] * weight)
    }

    /// What happens at the places of its part that are near, the nearest first.
    pub fn contacts(&self, at: &At<'_, D>) -> Vec<Contact<D>> {
        self.contacts_at(self.moved(at.increment), at)
    }

    /// What happens at the places of its part that are near to `position` `[L]`, the nearest first. Of the others only those
    /// matter that press or pull, so that what cannot press is not searched for.
    pub fn contacts_at(&self, position: Vector<D>, at: &At<'_, D>) -> Vec<Contact<D>> {
        let nearest = self.clearance.max(0.0) + self.shift(&position, at) + CLEAR * self.law.width;
        let reach = if self.may_pull() { self.reach } else { self.reach.min(nearest) };
        let mut near = Vec::new();
        at.tool.near(self.key.part as usize, at.pose, &position, reach, &mut near);
        let remembered = self.of_places(at.pose, &near);
        let contacts = near.into_iter().zip(remembered).enumerate().map(|(rank, (near, remembered))| {
            let state = remembered.map_or_else(|| self.untouched(at.start, &near), |k| self.states[k]);
            // Adhesion acts on the nearest place: the corner has one share of the surface.
            let law = if rank == 0 { self.law } else { CornerLaw { adhesion: 0.0, ..self.law } };
            let pose = pose_in_space(at.pose, self.arc);
            let trial =
                Trial { position: in_space(position, self.arc), near: &near, pose: &pose, first: at.is_first };
            let response = respond(&law, &state_in_space(&state, self.arc), &trial);
            Contact { position, near, law, state, remembered, response, arc: self.arc }
        });
        contacts.collect()
    }

    /// Appends what the corner remembers of each place of the surface after a step; where it is nothing, that.
    pub fn remember(&self, contacts: &[Contact<D>], pose: &Pose<D>, to: &mut Vec<Touch<D>>) {
        let from = to.len();
        for contact in contacts {
            let state = contact.committed(pose);
            if contact.response.closed || contact.law.adhesion > 0.0 || state.offset < 0.0 {
                let (position, distance) = (contact.position, contact.near.distance);
                to.push(Touch { key: self.key, position, distance, state: Some(state) });
            }
        }
        if let Some(nearest) = contacts.first().filter(|_| to.len() == from) {
            let (position, distance) = (nearest.position, nearest.near.distance);
            to.push(Touch { key: self.key, position, distance, state: None });
        }
    }

    /// For each place the state whose normal in the tool's frame is nearest; no state is that of two places.
    fn of_places(&self, pose: &Pose<D>, near: &[Near<D>]) -> Vec<Option<usize>> {
        let alike = |k: usize, place: usize| self.states[k].normal.dot(&pose.turn_back(&near[place].normal));
        let best = |place: usize| {
            let best = (0..self.states.len()).max_by(|&a, &b| alike(a, place).total_cmp(&alike(b, place)))?;
            // One place of a smooth surface may turn far in a step.
            (self.states.len() == 1 || alike(best, place) > SAME_PLACE).then_some(best)
        };
        let mut found: Vec<Option<usize>> = (0..near.len()).map(best).collect();
        for place in 1..found.len() {
            let Some(k) = found[place] else { continue };
            let Some(other) = (0..place).find(|&other| found[other] == Some(k)) else { continue };
            let farther = if alike(k, place) > alike(k, other) { other } else { place };
            found[farther] = None;
        }
        found
    }

    /// The state at a place that was not touched before: the anchor is where the corner stood at the start of the step.
    fn untouched(&self, start: &Pose<D>, near: &Near<D>) -> CornerState<D> {
        CornerState { offset: 0.0, ..CornerState::at_rest(start, &self.position, near) }
    }
}

/// A state with the arc of its anchor.
fn state_in_space<const D: usize>(state: &CornerState<D>, arc: Option<f64>) -> CornerState<D> {
    CornerState { anchor: in_space(state.anchor, arc), ..*state }
}

impl<const D: usize> Contact<D> {
    /// F `[F]`; of bodies that turn about their axis its third component is a torque.
    pub fn force(&self) -> Vector<D> {
        in_space(self.response.force, self.arc)
    }

    /// `-∂F/∂x` `[F/L]`.
    pub fn stiffness(&self, pose: &Pose<D>, is_first: bool, kind: Tangent) -> Block<D> {
        let (pose, position) = (pose_in_space(pose, self.arc), in_space(self.position, self.arc));
        let trial = Trial { position, near: &self.near, pose: &pose, first: is_first };
        let state = state_in_space(&self.state, self.arc);
        let mut stiffness = tangent(&self.law, &state, &trial, &self.response, kind);
        if let Some(radius) = self.arc {
            stiffness.row_mut(D - 1).scale_mut(radius);
            stiffness.column_mut(D - 1).scale_mut(radius);
        }
        stiffness
    }

    /// The state at the end of the step.
    pub fn committed(&self, pose: &Pose<D>) -> CornerState<D> {
        let (at, position) = (pose_in_space(pose, self.arc), in_space(self.position, self.arc));
        let trial = Trial { position, near: &self.near, pose: &at, first: false };
        let mut state = state_in_space(&self.state, self.arc).committed(&self.law, &trial, &self.response);
        if let Some(radius) = self.arc {
            // On the axis there is no arc, and nothing slips along it.
            let angle = state.anchor[D - 1] / radius;
            state.anchor[D - 1] = if radius > 0.0 { angle } else { pose.recall(&self.position)[D - 1] };
        }
        state
    }

    /// Energy dissipated by the slip of the step, `-½ (T₀ + T)·s` with `s = d + T/k`: d is what the corner is away from its
    /// anchor along the surface, and T₀ the force at the end of the step before, where the corner was `left`; it turns with
    /// the tool. The force is taken to change linearly, as in the work of the tool `[F L]`.
    pub fn dissipated(&self, left: &Vector<D>, start: &Pose<D>, pose: &Pose<D>) -> f64 {
        let before = match self.remembered {
            Some(_) => {
                self.along(pose.rotation() * (start.recall(left) - self.state.anchor)) * -self.law.stiffness
            }
            None => Vector::zeros(),
        };
        -0.5 * (before + self.response.tangential).dot(&self.slip(pose))
    }

    /// How far the corner has slipped in the step, along the surface: `d + T/k` `[L]`.
    pub fn slip(&self, pose: &Pose<D>) -> Vector<D> {
        let away = self.position - pose.place(&self.state.anchor);
        self.along(away) + self.response.tangential / self.law.stiffness
    }

    /// The part of a shift along the surface; an angle is an arc there.
    fn along(&self, x: Vector<D>) -> Vector<D> {
        let x = in_space(x, self.arc);
        x - self.near.normal * self.near.normal.dot(&x)
    }
}

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

/// A corner that was found, and the place of the surface next to it if it belongs to the interface.
type Found<const D: usize> = (NearCorner<D>, Option<Member<D>>);

impl<const D: usize> Search<'_, D> {
    /// All corners of the bodies that `meets` names by their number, in the order of points, parts and corners.
    ///
    /// # Errors
    /// A point stands inside the tool at the start of the run.
    pub fn corners(
        &self,
        step: &StepStart<'_, D>,
        meets: &dyn Fn(usize) -> bool,
        samples: &mut dyn FnMut(f64, &Bounds<D>) -> Vec<Vec<Sample<D>>>,
    ) -> Result<Vec<NearCorner<D>>, Refused> {
        let mut found: Vec<Found<D>> = Vec::new();
        for (index, at_start) in step.bodies.iter().enumerate().filter(|(index, _)| meets(*index)) {
            let body = at_start.body;
            let young = body.young();
            let of_points =
                each_point(body.n_points(), &|point| self.of_point(step, (index, body), young, point));
            for of_point in of_points {
                found.extend(
                    of_point
                        .map_err(|reason| Refused::here(format!("in body `{}` {reason}", at_start.name)))?,
                );
            }
        }
        self.share_surface(&mut found, step.mesh, samples);
        Ok(found.into_iter().map(|(corner, _)| corner).collect())
    }

    /// Corners of one point.
    fn of_point(
        &self,
        step: &StepStart<'_, D>,
        (index, body): (usize, &dyn Body<D>),
        young: f64,
        point: usize,
    ) -> Result<Vec<Found<D>>, String> {
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
                body.corners(step.mesh, point, &mut corners).map_err(|it| it.to_string())?;
            }
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
                        .filter_map(|(node, weight)| Some((step.active.number(node)? as u32, weight)))
                        .collect(),
                    area: 0.0,
                    adhesion,
                    law,
                    states: Vec::new(),
                    arc: self.space.turns::<D>().then(|| corner.position[0].abs()),
                    reach: moved + (1.0 + MARGIN) * (width + radius),
                    clearance: moved + (1.0 + MARGIN) * (width + radius),
                };
                let member = self.take_up(&mut made, corner, &corners, &mut near);
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
        corners: &[Corner<D>],
        near: &mut Vec<Near<D>>,
    ) -> Option<Member<D>> {
        near.clear();
        self.tool.near(made.key.part as usize, &self.start, &corner.position, made.reach, near);
        let nearest = *near.first()?;
        made.clearance = nearest.distance;
        let (width, n) = (made.law.width, nearest.normal);
        let across = corners.iter().map(|it| it.position.dot(&n));
        let (low, high) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let is_member = corner.area.dot(&n) < 0.0 && nearest.distance < MEMBERS * (high - low);
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
        found: &mut [Found<D>],
        mesh: &Mesh<D>,
        samples: &mut dyn FnMut(f64, &Bounds<D>) -> Vec<Vec<Sample<D>>>,
    ) {
        let members = found.iter().filter_map(|(_, member)| member.as_ref());
        let Some((spacing, within)) = sampling(members) else { return };
        let mut samples = samples(spacing, &within);
        if self.space.is_axisymmetric() {
            // Whole rings; the tool's section is on both sides of the axis.
            let all = samples.iter_mut().flatten();
            all.for_each(|sample| sample.area *= TAU * sample.position[0].max(0.0));
        }
        for (part, samples) in samples.iter_mut().enumerate() {
            samples.retain(|sample| mesh.locate(&self.start.place(&sample.position), 0.0).is_ok());
            let of_part = |it: &Found<D>| it.1.filter(|_| it.0.key.part as usize == part);
            let (places, members): (Vec<usize>, Vec<Member<D>>) =
                found.iter().enumerate().filter_map(|(k, it)| Some((k, of_part(it)?))).unzip();
            for (place, area) in places.into_iter().zip(shares(&members, samples)) {
                let corner = &mut found[place].0;
                corner.area = area;
                corner.law.adhesion = corner.adhesion * area;
            }
        }
    }
}

/// Unknowns of the displacement of a corner's nodes: the force on each component, and the dense stiffness column by column.
pub(super) struct Dense<const D: usize> {
    pub force: Vec<f64>,
    pub stiffness: Vec<f64>,
}

impl<const D: usize> Dense<D> {
    /// `-Σ W_v F` and `W_v W_w k` of a corner, with the force F on it and `k = -∂F/∂x`.
    pub fn of(corner: &NearCorner<D>, force: &Vector<D>, block: Option<&Block<D>>) -> Self {
        let nodes: Vec<f64> = corner.weights().map(|(_, weight)| weight).collect();
        let n = nodes.len() * D;
        let nodal = nodes.iter().flat_map(|weight| (0..D).map(move |i| -force[i] * weight)).collect();
        let mut stiffness = Vec::new();
        if let Some(block) = block {
            stiffness.reserve(n * n);
            for w in &nodes {
                for j in 0..D {
                    stiffness
                        .extend(nodes.iter().flat_map(|v| -> [f64; D] { from_fn(|i| v * w * block[(i, j)]) }));
                }
            }
        }
        Self { force: nodal, stiffness }
    }
}
