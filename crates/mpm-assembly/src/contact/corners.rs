//! The corners that a tool may touch in a load step, and the forces on them under a trial.

use super::memory::{Key, Touch};
use crate::body::Space;
use mpm_contact::{CornerLaw, CornerState, Near, Pose, Response, Tangent, Tool, Trial, respond, tangent};
use mpm_grid::{Block, Vector};

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
    pub arc: Option<f64>,
    /// Distance within which places of the surface count `[L]`.
    pub reach: f64,
    /// How far the part was at the start of the step, at most `reach` `[L]`.
    pub clearance: f64,
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
    pub arc: Option<f64>,
}

/// What acts on a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Acting<const D: usize> {
    /// Where the corner is `[L]`.
    pub position: Vector<D>,
    /// F `[F]`.
    pub force: Vector<D>,
    /// `-∂F/∂x`, where it is wanted `[F/L]`.
    pub stiffness: Option<Block<D>>,
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
    /// The largest of their norms: no corner moves farther `[L]`.
    pub most_moved: f64,
    pub is_first: bool,
}

impl<const D: usize> NearCorner<D> {
    /// Memory that it takes at the peak of a load step, with what happens at the places of its part and what is remembered of
    /// them before and after; these only of corners that touch, every fourth one (measured on a pile) `[bytes]`.
    pub fn bytes(&self) -> usize {
        let of_touching = size_of::<Contact<D>>() + size_of::<CornerState<D>>() + 2 * size_of::<Touch<D>>();
        let carriers = self.carriers.len() * size_of::<(u32, f64)>();
        size_of::<Self>() + carriers + size_of::<Vec<Contact<D>>>() + of_touching / 4
    }

    /// Nodes that carry the corner, with their weights.
    pub fn weights(&self) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        self.carriers.iter().map(|&(node, weight)| (node as usize, weight))
    }

    /// The contacts that can have a force: those of [`Self::contacts`], or none where the corner stays clear of the part,
    /// which spares most corners the search for its nearest places.
    pub fn forces(&self, at: &At<'_, D>) -> Vec<Contact<D>> {
        match self.moved_near(at, !self.may_pull()) {
            Some(position) => self.contacts_at(position, at),
            None => Vec::new(),
        }
    }

    /// The contacts that can have a force, or had one before.
    pub fn contacts_of_both_ends(&self, at: &At<'_, D>) -> Vec<Contact<D>> {
        match self.moved_near(at, self.states.is_empty()) {
            Some(position) => self.contacts_at(position, at),
            None => Vec::new(),
        }
    }

    /// Where the corner is, or nothing where it stays clear of the part and this counts. Most corners are told apart by how far
    /// any node moves, without a look at their own.
    fn moved_near(&self, at: &At<'_, D>, clear_counts: bool) -> Option<Vector<D>> {
        let counts = clear_counts && self.law.adhesion == 0.0;
        let is_clear = |shift: f64| counts && self.clearance - shift > CLEAR * self.law.width;
        if is_clear(at.most_moved + self.shift(&self.position, at)) {
            return None;
        }
        let position = self.moved(at.increment);
        (!is_clear(self.shift(&position, at))).then_some(position)
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
            if contact.is_remembered(pose) {
                let (position, distance) = (contact.position, contact.near.distance);
                to.push(Touch { key: self.key, position, distance, state: Some(contact.committed(pose)) });
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

    /// Whether the next step has to know of it.
    pub fn is_remembered(&self, pose: &Pose<D>) -> bool {
        self.response.closed || self.law.adhesion > 0.0 || self.committed(pose).offset < 0.0
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

    /// Energy dissipated by the slip of the step, `-½ (T₀ + T)·s` with `s = d + T/k_T`: d is what the corner is away from its
    /// anchor along the surface, and T₀ the force at the end of the step before, where the corner was `left`; it turns with
    /// the tool. The force is taken to change linearly, as in the work of the tool `[F L]`.
    pub fn dissipated(&self, left: &Vector<D>, start: &Pose<D>, pose: &Pose<D>) -> f64 {
        let before = match self.remembered {
            Some(_) => {
                self.along(pose.rotation() * (start.recall(left) - self.state.anchor))
                    * -self.law.shear_stiffness()
            }
            None => Vector::zeros(),
        };
        -0.5 * (before + self.response.tangential).dot(&self.slip(pose))
    }

    /// How far the corner has slipped in the step, along the surface: `d + T/k_T` `[L]`.
    pub fn slip(&self, pose: &Pose<D>) -> Vector<D> {
        let away = self.position - pose.place(&self.state.anchor);
        self.along(away) + self.response.tangential / self.law.shear_stiffness()
    }

    /// The part of a shift along the surface; an angle is an arc there.
    fn along(&self, x: Vector<D>) -> Vector<D> {
        let x = in_space(x, self.arc);
        x - self.near.normal * self.near.normal.dot(&x)
    }
}
