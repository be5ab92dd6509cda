//! A rigid tool as a contribution to force and tangent.

use super::areas::Samples;
use super::corners::{Acting, At, Contact, NearCorner};
use super::loaded::{Dense, Driven, Standing, ToolLoad};
use super::memory::Memory;
use super::summary::Summary;
use crate::contribution::{Begun, Refused};
use crate::sharing::Scale;
use crate::trial::{SystemSums, Trial};
use crate::unknowns::{Block, CoupledPlaces, UnknownId};
use mpm_basis::parallel::{each_point, some_points};
use mpm_contact::{Interface, Pose, Tangent, Tool, ToolMotion};
use mpm_grid::{LoadFraction, Vector, six_digits};

/// Part of the tool's thinnest part by which it may move in a step, so that no corner is carried through it.
const MOST_MOVED: f64 = 0.5;

/// A rigid tool: what it is, how it moves, and what holds between it and bodies.
#[derive(Debug)]
pub struct RigidTool<const D: usize> {
    /// Its parts in its own frame, which at rest is that of space.
    pub tool: Tool<D>,
    /// How it moves.
    pub motion: ToolMotion<D>,
    /// What else moves it: a load, in the components of its motion that are free.
    pub load: Option<ToolLoad<D>>,
    /// What holds between its surface and the bodies.
    pub interface: Interface,
    /// Whether Coulomb friction has its exact tangent, which is not symmetric.
    pub exact_friction: bool,
    /// Names of the bodies that meet it; all if empty.
    pub bodies: Vec<String>,
    /// Names of the bodies that are cut out along a shape, as a tool that is wished in place needs it: they end in stairs of
    /// domains, and what lies behind the first step sticks to the tool, too.
    pub cut_bodies: Vec<String>,
    /// Whether it stands in the layer of bodies that turn about their axis: then its parts are
    /// [figures of revolution](mpm_contact::InLayer), the third component of its motion is an angle, and that of its load a
    /// torque.
    pub turns: bool,
    /// Reference point of the tool, about which moments act and are recorded `[L]`.
    pub moment_about: Vector<D>,
}

/// Contact of bodies with a rigid tool, see the [module](crate::contact).
#[derive(Debug)]
pub struct ToolContact<const D: usize> {
    pub(super) name: String,
    pub(super) rigid: RigidTool<D>,
    /// Where the tool stands: present, and at the end of the step that has been balanced.
    pub(super) standing: Standing<D>,
    pub(super) prepared_standing: Standing<D>,
    /// Load fraction and pose at the start of the step.
    pub(super) from: LoadFraction,
    pub(super) start: Pose<D>,
    /// Unknowns of a loaded tool in this step, and whether its load is added here.
    pub(super) block: Option<Block>,
    pub(super) adds_load: bool,
    /// The corners that may be touched in this step.
    pub(super) corners: Vec<NearCorner<D>>,
    pub(super) present: Memory<D>,
    pub(super) prepared: Memory<D>,
    /// Of the last committed step, and of the step that has been prepared.
    pub(super) summary: Summary<D>,
    pub(super) prepared_summary: Summary<D>,
    /// Of its surface.
    pub(super) samples: Samples<D>,
    /// Without a load the tool couples what bodies couple.
    pub(super) couplings: CoupledPlaces,
}

impl<const D: usize> ToolContact<D> {
    /// Contact with a tool that has touched nothing yet. The history of the run has `tool/<name>/…`.
    pub fn new(name: impl Into<String>, rigid: RigidTool<D>) -> Self {
        let start = rigid.motion.pose(LoadFraction::START);
        let summary = Summary::untouched(&start, &rigid.moment_about, 0.0);
        let standing = Standing { pose: start, angle: 0.0 };
        Self {
            standing,
            prepared_standing: standing,
            from: LoadFraction::START,
            block: None,
            adds_load: true,
            name: name.into(),
            rigid,
            start,
            corners: Vec::new(),
            present: Memory::default(),
            prepared: Memory::default(),
            prepared_summary: summary.clone(),
            summary,
            samples: Samples::default(),
            couplings: CoupledPlaces::default(),
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the tool is, and its name.
    pub fn into_rigid(self) -> (String, RigidTool<D>) {
        (self.name, self.rigid)
    }

    /// What the tool is.
    pub fn rigid(&self) -> &RigidTool<D> {
        &self.rigid
    }

    /// Whether a body of this name meets the tool.
    pub fn meets(&self, body: &str) -> bool {
        self.rigid.bodies.is_empty() || self.rigid.bodies.iter().any(|name| name == body)
    }

    /// Whether a body of this name is cut out along a shape.
    pub(super) fn is_cut(&self, body: &str) -> bool {
        self.rigid.cut_bodies.iter().any(|name| name == body)
    }

    /// Whether the tangent has the term of friction that is not symmetric.
    pub(super) fn is_exact(&self) -> bool {
        self.rigid.interface.friction > 0.0 && self.rigid.exact_friction
    }

    /// Which tangent the tool has.
    pub(super) fn tangent(&self) -> Tangent {
        match self.is_exact() {
            true => Tangent::Exact,
            false => Tangent::Symmetric,
        }
    }

    /// The pose at the end of a trial.
    pub(super) fn pose(&self, trial: &Trial<'_, D>) -> Pose<D> {
        self.driven(trial).map_or_else(|| self.rigid.motion.pose(trial.end), |driven| driven.pose)
    }

    /// A tool with a load under a trial.
    pub(super) fn driven(&self, trial: &Trial<'_, D>) -> Option<Driven<'_, D>> {
        let RigidTool { load: Some(load), moment_about: about, .. } = &self.rigid else { return None };
        let unknowns = self.block.map_or(&[][..], |block| block.of(&trial.increment.own));
        let increment = load.increment(unknowns, &self.prescribed_shift(trial.end));
        let pose = self.start.moved(about, &increment);
        Some(Driven { load, increment, pose, centre: pose.place(about) })
    }

    /// What is prescribed of the reference point's motion in the step `[L]`.
    pub(super) fn prescribed_shift(&self, end: LoadFraction) -> Vector<D> {
        let at = |fraction| self.rigid.motion.pose(fraction).place(&self.rigid.moment_about);
        at(end) - at(self.from)
    }

    /// The places that a loaded tool couples: the nodes of each corner with its unknowns.
    pub(super) fn couple(&mut self, block: Block) -> Begun {
        let mut couplings = CoupledPlaces::default();
        for corner in &self.corners {
            let nodes = corner.weights().map(|(node, _)| node as u32);
            couplings.push(nodes.chain([block.place(0)]));
        }
        couplings.push([block.place(0)]);
        let before = std::mem::replace(&mut self.couplings, couplings);
        if before == self.couplings { Begun::AsBefore } else { Begun::Anew }
    }

    /// The load of a loaded tool as a force on its unknowns.
    pub(super) fn add_load(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) {
        let (Some(driven), Some(block)) = (self.driven(trial), self.block) else { return };
        if !self.adds_load {
            return;
        }
        let force: Vec<f64> = driven.loads(trial.end).iter().map(|load| -load).collect();
        let unknowns: Vec<UnknownId> = (0..force.len()).map(|k| block.unknown(0, k)).collect();
        sums.add(trial, &unknowns, &force, &driven.load_stiffness(trial.end));
    }

    /// What acts on the corners that touch, with their numbers.
    pub(super) fn acting(
        &self,
        trial: &Trial<'_, D>,
        pose: &Pose<D>,
        wants_tangent: bool,
    ) -> Vec<(usize, Acting<D>)> {
        let at = self.at(trial, pose);
        let kind = self.tangent();
        some_points(self.corners.len(), &|k| {
            let contacts = self.corners[k].forces(&at);
            let acts = |it: &Contact<D>| it.response.closed || it.response.tangential != Vector::<D>::zeros();
            if !contacts.iter().any(acts) {
                return None;
            }
            let stiffness = || contacts.iter().map(|it| it.stiffness(pose, trial.is_first, kind)).sum();
            Some(Acting {
                position: contacts[0].position,
                force: contacts.iter().map(Contact::force).sum(),
                stiffness: wants_tangent.then(stiffness),
            })
        })
    }

    /// The forces on the nodes, from those on all corners in turn: their norm is the tool's scale.
    pub(super) fn nodal_forces(&self, acting: &[(usize, Acting<D>)], trial: &Trial<'_, D>) -> Scale<D> {
        let mut nodal = vec![Vector::<D>::zeros(); trial.increment.nodes.len()];
        for (k, Acting { force, .. }) in acting {
            for (node, weight) in self.corners[*k].weights() {
                nodal[node] += force * weight;
            }
        }
        Scale::OfNodes(nodal)
    }

    /// Adds what acts on corners to the nodes and to the unknowns of a loaded tool.
    pub(super) fn add_driven(
        &self,
        driven: &Driven<'_, D>,
        acting: &[(usize, Acting<D>)],
        trial: &Trial<'_, D>,
        sums: &mut SystemSums<'_, D>,
    ) {
        let Some(block) = self.block else { return };
        let numbering = trial.pattern.unknowns();
        let mut unknowns: Vec<UnknownId> = Vec::new();
        for (k, acting) in acting {
            let corner = &self.corners[*k];
            let Dense { force, stiffness } = driven.dense(corner, acting);
            unknowns.clear();
            let nodes = corner.weights();
            unknowns.extend(nodes.flat_map(|(node, _)| (0..D).map(move |i| numbering.displacement(node, i))));
            unknowns.extend((0..driven.load.free.len()).map(|k| block.unknown(0, k)));
            sums.add(trial, &unknowns, &force, &stiffness);
        }
    }

    /// The contacts of every corner that can have a force.
    pub(super) fn forces(&self, trial: &Trial<'_, D>, pose: &Pose<D>) -> Vec<Vec<Contact<D>>> {
        let at = self.at(trial, pose);
        each_point(self.corners.len(), &|k| self.corners[k].forces(&at))
    }

    /// What happens at every corner that can have a force or had one in the step before.
    pub(super) fn contacts(&self, trial: &Trial<'_, D>, pose: &Pose<D>) -> Vec<Vec<Contact<D>>> {
        let at = self.at(trial, pose);
        each_point(self.corners.len(), &|k| self.corners[k].contacts_of_both_ends(&at))
    }

    /// Where corners are and how the tool stands under a trial.
    pub(super) fn at<'a>(&'a self, trial: &'a Trial<'_, D>, pose: &'a Pose<D>) -> At<'a, D> {
        let increment = &trial.increment.nodes[..];
        let most_moved = increment.iter().map(|moved| moved.norm_squared()).fold(0.0, f64::max).sqrt();
        At { tool: &self.rigid.tool, start: &self.start, pose, increment, most_moved, is_first: trial.is_first }
    }

    /// Refuses a step in which a corner could be carried through the tool.
    pub(super) fn check_motion(&self, end: &Pose<D>) -> Result<(), Refused> {
        if *end == self.start {
            return Ok(());
        }
        let in_section = |pose: &Pose<D>| {
            let mut shift = *pose.shift();
            if self.rigid.turns {
                // A turn about the axis carries no corner through the tool.
                shift[D - 1] = 0.0;
            }
            Pose::new(*pose.rotation(), shift)
        };
        let carried = self.rigid.tool.carried(&in_section(&self.start), &in_section(end));
        let Some((moved, thickness)) = carried.filter(|(moved, thickness)| *moved >= MOST_MOVED * thickness)
        else {
            return Ok(());
        };
        Err(Refused::step_too_long(format!(
            "moves by {} in a step, expected less than half its thickness, which is {}: bodies could pass through it",
            six_digits(moved),
            six_digits(thickness)
        )))
    }
}
