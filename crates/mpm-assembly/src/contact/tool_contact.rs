//! A rigid tool as a contribution to force and tangent.

use super::corners::{At, Contact, Dense, NearCorner, Search};
use super::memory::{Memory, Touch};
use super::summary::Summary;
use crate::contribution::{
    Begun, Contribution, ContributionEnergy, Inadmissible, Recorded, Refused, StepStart, SystemSums, Trial,
};
use crate::unknowns::{CoupledPlaces, Couplings, UnknownId, Unknowns};
use mpm_basis::parallel::each_point;
use mpm_contact::{Bounds, Interface, Pose, Sample, Tangent, Tool, ToolMotion};
use mpm_grid::{LoadFraction, Vector, six_digits};
use mpm_linear::Symmetry;

/// Part of the tool's thinnest part by which it may move in a step, so that no corner is carried through it.
const MOST_MOVED: f64 = 0.5;

/// Gap over the width of a domain at which augmentation ends.
const CLOSED: f64 = 1e-4;

/// A rigid tool: what it is, how it moves, and what holds between it and bodies.
#[derive(Debug)]
pub struct RigidTool<const D: usize> {
    /// Its parts in its own frame, which at rest is that of space.
    pub tool: Tool<D>,
    /// How it moves.
    pub motion: ToolMotion<D>,
    /// What holds between its surface and the bodies.
    pub interface: Interface,
    /// Whether Coulomb friction has its exact tangent, which is not symmetric.
    pub exact_friction: bool,
    /// Names of the bodies that meet it; all if empty.
    pub bodies: Vec<String>,
    /// Point of the tool about which moments are recorded `[L]`.
    pub moment_about: Vector<D>,
}

/// Contact of bodies with a rigid tool, see the [module](crate::contact).
#[derive(Debug)]
pub struct ToolContact<const D: usize> {
    name: String,
    rigid: RigidTool<D>,
    /// Poses at the start and the planned end of the step.
    start: Pose<D>,
    /// The corners that may be touched in this step.
    corners: Vec<NearCorner<D>>,
    present: Memory<D>,
    prepared: Memory<D>,
    /// Of the last committed step, and of the step that has been prepared.
    summary: Summary<D>,
    prepared_summary: Summary<D>,
    /// Samples of a tool of finite size, with their spacing.
    samples: Option<(f64, Vec<Vec<Sample<D>>>)>,
    /// The tool couples what bodies couple.
    couplings: CoupledPlaces,
}

impl<const D: usize> ToolContact<D> {
    /// Contact with a tool that has touched nothing yet. The history of the run has `tool/<name>/…`.
    pub fn new(name: impl Into<String>, rigid: RigidTool<D>) -> Self {
        let start = rigid.motion.pose(LoadFraction::START);
        let summary = Summary::untouched(&start, &rigid.moment_about, 0.0);
        Self {
            name: name.into(),
            rigid,
            start,
            corners: Vec::new(),
            present: Memory::default(),
            prepared: Memory::default(),
            prepared_summary: summary.clone(),
            summary,
            samples: None,
            couplings: CoupledPlaces::default(),
        }
    }

    /// What the tool is.
    pub fn rigid(&self) -> &RigidTool<D> {
        &self.rigid
    }

    /// Whether a body of this name meets the tool.
    pub fn meets(&self, body: &str) -> bool {
        self.rigid.bodies.is_empty() || self.rigid.bodies.iter().any(|name| name == body)
    }

    /// Which tangent the tool has.
    fn tangent(&self) -> Tangent {
        if self.symmetry() == Symmetry::Symmetric { Tangent::Symmetric } else { Tangent::Exact }
    }

    /// The pose at the end of a trial.
    fn pose(&self, trial: &Trial<'_, D>) -> Pose<D> {
        self.rigid.motion.pose(trial.end)
    }

    /// What happens at every corner.
    fn contacts(&self, trial: &Trial<'_, D>, pose: &Pose<D>) -> Vec<Vec<Contact<D>>> {
        let (tool, increment) = (&self.rigid.tool, &trial.increment.nodes[..]);
        let at = At { tool, start: &self.start, pose, increment, is_first: trial.is_first };
        each_point(self.corners.len(), &|k| self.corners[k].contacts(&at))
    }

    /// Refuses a step in which a corner could be carried through the tool.
    fn check_motion(&self, end: &Pose<D>) -> Result<(), Refused> {
        let thickness = self.rigid.tool.thickness();
        if thickness == f64::INFINITY || *end == self.start {
            return Ok(());
        }
        let moved = self.rigid.tool.bounds().farthest(&self.start, end);
        if moved < MOST_MOVED * thickness {
            return Ok(());
        }
        Err(Refused::step_too_long(format!(
            "moves by {} in a step, expected less than half its thickness, which is {}: bodies could pass through it",
            six_digits(moved),
            six_digits(thickness)
        )))
    }
}

/// Samples of the tool's surface; those of a tool of finite size are kept for the next step.
fn samples_of<const D: usize>(
    tool: &Tool<D>,
    kept: &mut Option<(f64, Vec<Vec<Sample<D>>>)>,
    spacing: f64,
    within: &Bounds<D>,
) -> Vec<Vec<Sample<D>>> {
    let bounds = tool.bounds();
    if !bounds.is_finite() {
        return tool.samples(spacing, within);
    }
    if let Some((made_for, samples)) = kept
        && *made_for == spacing
    {
        return samples.clone();
    }
    let samples = tool.samples(spacing, &bounds.grown(spacing));
    *kept = Some((spacing, samples.clone()));
    samples
}

impl<const D: usize> Contribution<D> for ToolContact<D> {
    fn begin(&mut self, step: &StepStart<'_, D>, _unknowns: &mut Unknowns<D>) -> Result<Begun, Refused> {
        self.start = self.rigid.motion.pose(step.from);
        let end = self.rigid.motion.pose(step.to);
        self.check_motion(&end)?;
        let names: Vec<bool> = step.bodies.iter().map(|body| self.meets(body.name)).collect();
        let RigidTool { tool, interface, .. } = &self.rigid;
        let search = Search { tool, interface, memory: &self.present, start: self.start, end };
        let kept = &mut self.samples;
        let mut samples = |spacing: f64, within: &Bounds<D>| samples_of(tool, kept, spacing, within);
        self.corners = search.corners(step, &|index| names[index], &mut samples)?;
        Ok(Begun::AsBefore)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.couplings
    }

    fn symmetry(&self) -> Symmetry {
        let is_exact = self.rigid.interface.friction > 0.0 && self.rigid.exact_friction;
        if is_exact { Symmetry::Unsymmetric } else { Symmetry::Symmetric }
    }

    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible> {
        let (pose, kind, numbering) = (self.pose(trial), self.tangent(), trial.pattern.unknowns());
        let contacts = self.contacts(trial, &pose);
        let wants_tangent = sums.wants_tangent();
        let dense: Vec<Option<Dense<D>>> = each_point(contacts.len(), &|k| {
            let of_corner = &contacts[k];
            let acts = |it: &Contact<D>| it.response.closed || it.response.tangential != Vector::<D>::zeros();
            if !of_corner.iter().any(acts) {
                return None;
            }
            let force: Vector<D> = of_corner.iter().map(|it| it.response.force).sum();
            let stiffness = || of_corner.iter().map(|it| it.stiffness(&pose, trial.is_first, kind)).sum();
            Some(Dense::of(&self.corners[k], &force, wants_tangent.then(stiffness).as_ref()))
        });
        let mut unknowns: Vec<UnknownId> = Vec::new();
        for (corner, dense) in self.corners.iter().zip(dense) {
            let Some(Dense { force, stiffness }) = dense else { continue };
            unknowns.clear();
            let nodes = corner.weights();
            unknowns.extend(nodes.flat_map(|(node, _)| (0..D).map(move |i| numbering.displacement(node, i))));
            sums.add(trial, &unknowns, &force, &stiffness);
        }
        Ok(())
    }

    /// The norm of the tool's forces on the nodes.
    fn scale(&self, trial: &Trial<'_, D>) -> f64 {
        let contacts = self.contacts(trial, &self.pose(trial));
        let mut nodal = vec![Vector::<D>::zeros(); trial.increment.nodes.len()];
        for (corner, contacts) in self.corners.iter().zip(&contacts) {
            let force: Vector<D> = contacts.iter().map(|it| it.response.force).sum();
            for (node, weight) in corner.weights() {
                nodal[node] += force * weight;
            }
        }
        nodal.iter().map(|force| force.norm_squared()).sum::<f64>().sqrt()
    }

    fn moves_with_load(&self) -> bool {
        !self.rigid.motion.is_rest()
    }

    /// Stored in the springs of contact, dissipated by slip, and done by the tool, whose force is taken to change
    /// linearly through the step.
    fn energy(&self, trial: &Trial<'_, D>) -> ContributionEnergy {
        let pose = self.pose(trial);
        let still = vec![Vector::zeros(); trial.increment.nodes.len()];
        let at = At { tool: &self.rigid.tool, start: &self.start, pose: &self.start, increment: &still, is_first: false };
        let mut energy = ContributionEnergy::default();
        for (corner, contacts) in self.corners.iter().zip(&self.contacts(trial, &pose)) {
            for contact in contacts {
                let carried = contact.state.multiplier.powi(2) / (2.0 * contact.law.stiffness);
                energy.stored += contact.response.stored(&contact.law) - if contact.response.closed { carried } else { 0.0 };
                energy.dissipated += contact.dissipated(&pose);
            }
            let sum = |contacts: &[Contact<D>]| contacts.iter().map(|it| it.response.force).sum::<Vector<D>>();
            let Some(first) = contacts.first() else { continue };
            let (before, after) = (sum(&corner.contacts(&at)), sum(contacts));
            let moved = first.position - self.start.place(&pose.recall(&first.position));
            energy.work += 0.5 * (before + after).dot(&moved);
        }
        energy
    }

    fn augment(&mut self, trial: &Trial<'_, D>, round: u32) -> bool {
        if round >= self.rigid.interface.augment {
            return false;
        }
        let contacts = self.contacts(trial, &self.pose(trial));
        let is_open = |it: &Contact<D>| it.response.closed && it.response.gap.abs() > CLOSED * it.law.width;
        if !contacts.iter().flatten().any(is_open) {
            return false;
        }
        for (corner, contacts) in self.corners.iter_mut().zip(contacts) {
            for contact in contacts {
                let state = contact.state.augmented(&contact.response);
                match contact.remembered {
                    Some(k) => corner.states[k] = state,
                    None if contact.response.closed => corner.states.push(state),
                    None => {}
                }
            }
        }
        true
    }

    fn divide(&mut self, body: usize, parts: &[(usize, f64)]) {
        self.present.divide(body as u32, parts);
    }

    fn prepare(&mut self, trial: &Trial<'_, D>) {
        let pose = self.pose(trial);
        let contacts = self.contacts(trial, &pose);
        let angle = self.rigid.motion.angle(trial.end);
        let mut summary = Summary::untouched(&pose, &self.rigid.moment_about, angle);
        let mut touches = Vec::new();
        for (corner, contacts) in self.corners.iter().zip(&contacts) {
            summary.add(corner, contacts);
            for contact in contacts {
                let state = contact.committed(&pose);
                let holds = contact.response.closed || contact.law.adhesion > 0.0;
                if holds || state.offset < 0.0 {
                    let (key, position, distance) = (corner.key, contact.position, contact.near.distance);
                    touches.push(Touch { key, position, distance, state });
                }
            }
        }
        self.prepared = Memory { has_begun: true, touches };
        self.prepared_summary = summary;
    }

    fn commit(&mut self) {
        std::mem::swap(&mut self.present, &mut self.prepared);
        self.summary.clone_from(&self.prepared_summary);
    }

    fn save(&self) -> Vec<f64> {
        self.present.save()
    }

    fn restore(&mut self, saved: &[f64]) -> Result<(), String> {
        self.present = Memory::restore(saved)?;
        Ok(())
    }

    fn history(&self) -> Vec<Recorded> {
        self.summary.columns(&self.name)
    }
}
