//! What a rigid tool adds to force and tangent, remembers, and tells.

use super::by_point::saved_by_point;
use super::corners::{Acting, At, Contact, NearCorner};
use super::fields::{FIELDS, FORCE, GAP, SLIP, gaps, of_touched, touched};
use super::loaded::{Standing, ToolLoad};
use super::memory::Memory;
use super::search::{Search, WITHIN, WITHIN_OF_STAIRS};
use super::summary::Summary;
use super::tool_contact::{RigidTool, ToolContact};
use crate::body::{Body, Space};
use crate::contribution::{
    Begun, Contribution, ContributionEnergy, Inadmissible, PointField, Recorded, Refused, StepStart,
};
use crate::sharing::{SavedByPoint, Scale, Sharing};
use crate::trial::{SystemSums, Trial};
use crate::unknowns::{Couplings, Unknowns};
use mpm_grid::{Mesh, Ramp, Vector};
use mpm_linear::Symmetry;

/// Gap over the width of a domain at which augmentation ends.
const CLOSED: f64 = 1e-12;

impl<const D: usize> Contribution<D> for ToolContact<D> {
    fn begin(&mut self, step: &StepStart<'_, D>, unknowns: &mut Unknowns<D>) -> Result<Begun, Refused> {
        self.from = step.from;
        self.adds_load = step.sharing.leads();
        let end = match &self.rigid.load {
            None => {
                self.start = self.rigid.motion.pose(step.from);
                self.rigid.motion.pose(step.to)
            }
            Some(load) => {
                self.start = self.standing.pose;
                let increment = load.increment(&[], &self.prescribed_shift(step.to));
                self.start.moved(&self.rigid.moment_about, &increment)
            }
        };
        self.check_motion(&end)?;
        self.corners = Vec::new();
        let never_parts = !self.rigid.interface.separates;
        let member_within = |name| if never_parts || self.is_cut(name) { WITHIN_OF_STAIRS } else { WITHIN };
        let reaches: Vec<Option<f64>> =
            step.bodies.iter().map(|body| self.meets(body.name).then(|| member_within(body.name))).collect();
        let RigidTool { tool, interface, .. } = &self.rigid;
        let space = step.bodies.first().map_or(Space::default(), |it| it.body.space());
        let search = Search { tool, interface, memory: &self.present, space, start: self.start, end };
        self.corners = search.corners(step, &reaches, &mut self.samples)?;
        self.block = self.rigid.load.as_ref().map(|load| unknowns.push(1, load.free.len()));
        Ok(self.block.map_or(Begun::AsBefore, |block| self.couple(block)))
    }

    fn describe_unknown(&self, k: usize, axes: [&'static str; 3]) -> String {
        match &self.rigid.load {
            Some(load) if self.rigid.turns && load.free[k] == D - 1 => "the turn about the axis".into(),
            Some(load) => load.describe(k, axes),
            None => String::new(),
        }
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.couplings
    }

    fn symmetry(&self) -> Symmetry {
        match &self.rigid.load {
            _ if self.is_exact() => Symmetry::Unsymmetric,
            load => load.as_ref().map_or(Symmetry::Symmetric, ToolLoad::symmetry),
        }
    }

    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible> {
        let pose = self.pose(trial);
        let acting = self.acting(trial, &pose, sums.wants_tangent());
        sums.scale = Some(self.nodal_forces(&acting, trial));
        match self.driven(trial) {
            None => {
                for (k, Acting { force, stiffness, .. }) in &acting {
                    sums.add_carried(trial, &self.corners[*k].carriers, force, stiffness.as_ref());
                }
            }
            Some(driven) => self.add_driven(&driven, &acting, trial, sums),
        }
        self.add_load(trial, sums);
        Ok(())
    }

    fn scale(&self, trial: &Trial<'_, D>) -> Scale<D> {
        self.nodal_forces(&self.acting(trial, &self.pose(trial), false), trial)
    }

    /// Gaps are differences of positions.
    fn round_off(&self, sizes: &mut [f64]) {
        for corner in &self.corners {
            let size = corner.law.stiffness * corner.position.norm();
            corner.weights().for_each(|(node, weight)| sizes[node] += size * weight.abs());
        }
    }

    /// The load, and what the contact forces do in each unknown: norms of both.
    fn own_scale(&self, trial: &Trial<'_, D>) -> Vec<f64> {
        let Some(driven) = self.driven(trial) else { return Vec::new() };
        let part = if self.adds_load { 1.0 } else { 0.0 };
        let mut sizes: Vec<f64> = driven.loads(trial.end).iter().map(|load| part * load.abs()).collect();
        for contact in self.forces(trial, &driven.pose).iter().flatten() {
            let work = driven.work(&contact.position, &contact.force());
            sizes.iter_mut().zip(work).for_each(|(size, work)| *size += work.abs());
        }
        sizes
    }

    fn can_be_shared(&self) -> bool {
        true
    }

    fn moves_with_load(&self) -> bool {
        !self.rigid.motion.is_rest() || self.rigid.load.is_some()
    }

    fn ramps(&self) -> Vec<&Ramp> {
        let load = self.rigid.load.iter().map(|load| &load.ramp);
        self.rigid.motion.ramps().into_iter().chain(load).collect()
    }

    fn remarks(&self, mesh: &Mesh<D>, bodies: &[(&str, &dyn Body<D>)]) -> Vec<String> {
        self.remark_on_thickness(mesh).into_iter().chain(self.remark_on_facets(bodies)).collect()
    }

    fn bytes(&self) -> usize {
        self.corners.iter().map(NearCorner::bytes).sum()
    }

    fn size(&self, bodies: &[(&str, &dyn Body<D>)]) -> Option<String> {
        Some(self.describe_size(bodies))
    }

    /// Stored in the springs of contact, dissipated by slip, and done by the tool, whose force is taken to change linearly
    /// from that at the end of the step before. Where corners of domains are then taken anew, they jump, and springs change
    /// for which nothing has worked: this energy is left over in the balance, as that of the mesh that is replaced.
    fn energy(&self, trial: &Trial<'_, D>) -> ContributionEnergy {
        let pose = self.pose(trial);
        let (tool, start) = (&self.rigid.tool, &self.start);
        let at = At { tool, start, pose: start, increment: &[], most_moved: 0.0, is_first: false };
        let mut energy = ContributionEnergy::default();
        for (corner, contacts) in self.corners.iter().zip(&self.contacts(trial, &pose)) {
            for contact in contacts {
                let carried = contact.state.multiplier.powi(2) / (2.0 * contact.law.stiffness);
                energy.stored +=
                    contact.response.stored(&contact.law) - if contact.response.closed { carried } else { 0.0 };
                energy.dissipated += contact.dissipated(&corner.left, &self.start, &pose);
            }
            let sum = |contacts: &[Contact<D>]| contacts.iter().map(Contact::force).sum::<Vector<D>>();
            let Some(first) = contacts.first() else { continue };
            let (before, after) = (sum(&corner.contacts_at(corner.left, &at)), sum(contacts));
            let moved = first.position - self.start.place(&pose.recall(&first.position));
            energy.work += 0.5 * (before + after).dot(&moved);
        }
        energy
    }

    fn augment(&mut self, trial: &Trial<'_, D>, round: u32, sharing: &dyn Sharing<D>) -> bool {
        if round >= self.rigid.interface.augment {
            return false;
        }
        let contacts = self.contacts(trial, &self.pose(trial));
        let is_open = |it: &Contact<D>| it.response.closed && it.response.gap.abs() > CLOSED * it.law.width;
        let open = f64::from(u8::from(contacts.iter().flatten().any(is_open)));
        if sharing.gathered(vec![open]).0.iter().all(|open| *open == 0.0) {
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

    fn prepare(&mut self, trial: &Trial<'_, D>) -> Result<(), Inadmissible> {
        let pose = self.pose(trial);
        let contacts = self.contacts(trial, &pose);
        let angle = match self.driven(trial) {
            None => self.rigid.motion.angle(trial.end),
            Some(driven) => self.standing.angle + driven.increment.turn.z,
        };
        let mut summary = Summary::untouched(&pose, &self.rigid.moment_about, angle);
        let (at, mut touches) = (self.at(trial, &pose), Vec::new());
        let of_a_point = |a: &usize, b: &usize| self.corners[*a].key.is_beside(&self.corners[*b].key);
        let numbers: Vec<usize> = (0..self.corners.len()).collect();
        for numbers in numbers.chunk_by(of_a_point) {
            numbers.iter().for_each(|&number| summary.add(&self.corners[number], &contacts[number]));
            // Only points that touch are remembered.
            if !numbers.iter().any(|&number| contacts[number].iter().any(|it| it.is_remembered(&pose))) {
                continue;
            }
            for &number in numbers {
                match (&self.corners[number], &contacts[number]) {
                    (corner, none) if none.is_empty() => {
                        corner.remember(&corner.contacts(&at), &pose, &mut touches);
                    }
                    (corner, contacts) => corner.remember(contacts, &pose, &mut touches),
                }
            }
        }
        summary.check_depth()?;
        let points = self.present.points_after(touched(&self.corners, &contacts, &pose));
        self.prepared = Memory { has_begun: true, touches, points };
        self.prepared_standing = Standing { pose, angle };
        self.prepared_summary = summary;
        Ok(())
    }

    fn commit(&mut self) {
        std::mem::swap(&mut self.present, &mut self.prepared);
        self.standing = self.prepared_standing;
        self.summary.clone_from(&self.prepared_summary);
    }

    fn save(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.standing.save(&mut numbers);
        self.present.save(&mut numbers);
        numbers
    }

    fn restore(&mut self, saved: &[f64]) -> Result<(), String> {
        let width = Standing::<D>::NUMBERS;
        let (standing, memory) = saved
            .split_at_checked(width)
            .ok_or_else(|| format!("has {} numbers, expected {width} for its pose", saved.len()))?;
        let present = Memory::restore(memory)?;
        self.standing = Standing::restore(standing)?;
        self.present = present;
        Ok(())
    }

    fn saved_by_point(&self) -> Option<SavedByPoint> {
        Some(saved_by_point::<D>())
    }

    fn history(&self) -> Vec<Recorded> {
        self.summary.columns(&self.name, self.rigid.turns)
    }

    fn point_fields(&self) -> &'static [PointField] {
        FIELDS
    }

    fn point_field(&self, name: &str, bodies: &[&dyn Body<D>]) -> Vec<f64> {
        match name {
            FORCE => {
                of_touched(&self.present, bodies, 3, |it, to| to[..D].copy_from_slice(it.force.as_slice()))
            }
            SLIP => of_touched(&self.present, bodies, 1, |it, to| to[0] = it.slip),
            GAP => gaps(&self.rigid.tool, &self.standing.pose, bodies),
            _ => Vec::new(),
        }
    }
}
