//! What a wall adds to force and tangent, remembers, and tells.

use super::held::Held;
use super::moving::check_saved;
use super::summary::Summary;
use super::wall::WallContact;
use crate::contact::ToolLoad;
use crate::contact::loaded::Standing;
use crate::contribution::{
    Begun, Contribution, ContributionEnergy, Inadmissible, Recorded, Refused, StepStart,
};
use crate::sharing::{Scale, Sharing};
use crate::trial::{SystemSums, Trial};
use crate::unknowns::{CoupledPlaces, Couplings, UnknownId, Unknowns};
use mpm_grid::{Mesh, NodeId, Ramp, Vector, six_digits};
use mpm_linear::Symmetry;

/// Gap over the length of a cell at which a step is not balanced again, and above which none is accepted, where a wall holds
/// exactly. In between lie gaps of markers that stand closer than the functions of the mesh can follow them.
const CLOSED: f64 = 1e-11;
const OPEN: f64 = 1e-4;

/// How often a step is balanced again at most.
const ROUNDS: u32 = 30;

/// Roundings of a position.
const ROUNDINGS: f64 = 4.0;

/// Part of the gap of the round before above which more rounds bring little.
const NO_LESS: f64 = 0.5;

impl<const D: usize> WallContact<D> {
    /// The places that the wall couples: the nodes of each marker, with the unknowns of a wall that has some.
    fn couple(&mut self) -> Begun {
        let mut couplings = CoupledPlaces::default();
        let own = self.block.map(|block| block.place(0));
        for carriers in self.markers.own.iter().map(|&marker| &self.markers.carriers[marker]) {
            couplings.push(carriers.iter().map(|&(node, _)| node).chain(own));
        }
        if let Some(own) = own {
            couplings.push([own]);
        }
        let before = std::mem::replace(&mut self.couplings, couplings);
        if before == self.couplings { Begun::AsBefore } else { Begun::Anew }
    }

    /// The markers under a trial, and where they stand.
    fn under(&self, trial: &Trial<'_, D>) -> Result<(Vec<Vector<D>>, Vec<Held<D>>), Inadmissible> {
        let positions = self.markers.moved(&trial.increment.nodes);
        let held = self.holds(&positions, &self.pose(trial))?;
        Ok((positions, held))
    }

    /// Largest gap over the length of its cell.
    fn widest(&self, held: &[Held<D>]) -> f64 {
        held.iter().map(|held| held.gap / self.width[held.marker]).fold(0.0, f64::max)
    }

    /// Forces on all markers, nothing on those of others.
    fn forces(&self, held: &[Held<D>]) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::zeros(); self.markers.position.len()];
        held.iter().for_each(|held| forces[held.marker] = held.force);
        forces
    }

    /// q of all markers, 0 of those of others.
    fn pulls(&self, held: &[Held<D>]) -> Vec<f64> {
        let mut pulls = vec![0.0; self.carried.len()];
        let width = pulls.len() / self.markers.position.len();
        for held in held {
            pulls[width * held.marker..width * (held.marker + 1)].copy_from_slice(&held.q);
        }
        pulls
    }
}

impl<const D: usize> Contribution<D> for WallContact<D> {
    fn begin(&mut self, step: &StepStart<'_, D>, unknowns: &mut Unknowns<D>) -> Result<Begun, Refused> {
        self.from = step.from;
        self.adds_load = step.sharing.leads();
        self.held.clone_from(&self.carried);
        self.gap_before = f64::INFINITY;
        if self.wall.load.is_none() {
            let pose = self.wall.motion.pose(step.from);
            self.standing = Standing { pose, angle: self.wall.motion.angle(step.from) };
        }
        self.block = self.wall.load.as_ref().map(|load| unknowns.push(1, load.free.len()));
        self.markers.begin(step)?;
        self.stiffen(step)?;
        Ok(self.couple())
    }

    fn describe_unknown(&self, k: usize, axes: [&'static str; 3]) -> String {
        self.wall.load.as_ref().map_or_else(String::new, |load| load.describe(k, axes))
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.couplings
    }

    fn symmetry(&self) -> Symmetry {
        self.wall.load.as_ref().map_or(Symmetry::Symmetric, ToolLoad::symmetry)
    }

    fn add(&self, trial: &Trial<'_, D>, sums: &mut SystemSums<'_, D>) -> Result<(), Inadmissible> {
        let (_, held) = self.under(trial)?;
        self.markers.spread(1.0, &self.forces(&held), &mut sums.force.nodes);
        if sums.wants_tangent() {
            let numbering = trial.pattern.unknowns();
            let mut dense = Vec::new();
            for held in &held {
                let carriers = &self.markers.carriers[held.marker];
                let of_node =
                    |&(node, _): &(u32, f64)| (0..D).map(move |i| numbering.displacement(node as usize, i));
                let unknowns: Vec<UnknownId> = carriers.iter().flat_map(of_node).collect();
                dense.clear();
                for (j, of_w) in carriers.iter().flat_map(|it| (0..D).map(move |j| (j, it.1))) {
                    let column = carriers.iter().flat_map(|it| (0..D).map(move |i| (i, it.1)));
                    dense.extend(column.map(|(i, of_v)| of_v * of_w * held.stiffness[(i, j)]));
                }
                sums.add(trial, &unknowns, &vec![0.0; unknowns.len()], &dense);
            }
        }
        if let Some(driven) = self.driven(trial) {
            self.add_frame((trial, &driven), &held, sums);
        }
        Ok(())
    }

    fn scale(&self, trial: &Trial<'_, D>) -> Scale<D> {
        let Ok((_, held)) = self.under(trial) else { return Scale::Size(0.0) };
        self.markers.of_nodes(&self.forces(&held), trial.increment.nodes.len())
    }

    /// Gaps are differences of positions, each of which is a sum.
    fn round_off(&self, sizes: &mut [f64]) {
        for &marker in &self.markers.own {
            let size = ROUNDINGS * self.beta[marker] * self.markers.measure[marker];
            let size = size * self.markers.position[marker].norm();
            self.markers.carriers[marker]
                .iter()
                .for_each(|&(node, value)| sizes[node as usize] += size * value.abs());
        }
    }

    /// The load, and what the markers do in each unknown: norms of both.
    fn own_scale(&self, trial: &Trial<'_, D>) -> Vec<f64> {
        let (Some(driven), Ok((_, held))) = (self.driven(trial), self.under(trial)) else { return Vec::new() };
        let part = if self.adds_load { 1.0 } else { 0.0 };
        let mut sizes: Vec<f64> = driven.loads(trial.end).iter().map(|load| part * load.abs()).collect();
        for held in held {
            let work = driven.work(&held.foot, &held.force);
            sizes.iter_mut().zip(work).for_each(|(size, work)| *size += work.abs());
        }
        sizes
    }

    fn own_round_off(&self, trial: &Trial<'_, D>) -> Vec<f64> {
        let Some(driven) = self.driven(trial) else { return Vec::new() };
        let mut sizes = vec![0.0; driven.load.free.len()];
        for &marker in &self.markers.own {
            let (x, beta) = (&self.markers.position[marker], self.beta[marker]);
            let measure = self.markers.measure[marker];
            let rounded = Vector::repeat(ROUNDINGS * f64::EPSILON * beta * measure * x.norm());
            let work = driven.work(x, &rounded);
            sizes.iter_mut().zip(work).for_each(|(size, work)| *size += work.abs());
        }
        sizes
    }

    fn moves_with_load(&self) -> bool {
        !self.wall.motion.is_rest() || self.wall.load.is_some()
    }

    fn ramps(&self) -> Vec<&Ramp> {
        let load = self.wall.load.iter().map(|load| &load.ramp);
        self.wall.motion.ramps().into_iter().chain(load).collect()
    }

    fn needs_functions_of_mesh(&self) -> bool {
        true
    }

    fn can_be_shared(&self) -> bool {
        true
    }

    fn nodes(&self, mesh: &Mesh<D>, sharing: &dyn Sharing<D>) -> Vec<NodeId> {
        self.markers.nodes(mesh, sharing)
    }

    fn hear(&mut self, sharing: &dyn Sharing<D>) {
        let width = self.carried.len() / self.markers.position.len();
        self.markers.hear((&mut self.carried, width), sharing);
    }

    /// The work of forces that change linearly through the step: that on the wall where it moves, and the rest of that on the
    /// body, which gaps take.
    fn energy(&self, trial: &Trial<'_, D>) -> ContributionEnergy {
        let start = self.holds(&self.markers.position, &self.standing.pose);
        let (Ok(start), Ok((positions, end))) = (start, self.under(trial)) else {
            return ContributionEnergy::default();
        };
        let (mut energy, pose) = (ContributionEnergy::default(), self.pose(trial));
        for (start, end) in start.iter().zip(&end) {
            let marker = start.marker;
            let moved = positions[marker] - self.markers.position[marker];
            // Between steps the wall pulls with what it carries.
            let before = start.pull(self.of_marker(&self.carried, marker)) * self.markers.measure[marker];
            let mean = (before + end.force) * -0.5;
            let of_wall = pose.place(&self.standing.pose.recall(&start.foot)) - start.foot;
            energy.work += mean.dot(&of_wall);
            energy.dissipated += mean.dot(&(of_wall - moved));
        }
        energy
    }

    fn augment(&mut self, trial: &Trial<'_, D>, round: u32, sharing: &dyn Sharing<D>) -> bool {
        if !self.wall.exact || round >= ROUNDS {
            return false;
        }
        let under = self.under(trial);
        let of_own = under.as_ref().map_or([f64::NAN; 2], |(positions, held)| {
            let own = self.markers.own.iter();
            let rounding =
                own.map(|&marker| 8.0 * f64::EPSILON * positions[marker].amax() / self.width[marker]);
            [self.widest(held), rounding.fold(CLOSED, f64::max)]
        });
        let of_all = sharing.gathered(of_own.to_vec()).0;
        let Ok((_, held)) = under else { return false };
        if of_all.iter().any(|it| it.is_nan()) {
            return false;
        }
        let largest = |k: usize| of_all.iter().skip(k).step_by(2).copied().fold(0.0, f64::max);
        let (gap, least) = (largest(0), largest(1));
        if gap <= least || gap > NO_LESS * self.gap_before {
            return false;
        }
        self.gap_before = gap;
        self.held = self.pulls(&held);
        true
    }

    fn prepare(&mut self, trial: &Trial<'_, D>) -> Result<(), Inadmissible> {
        let (positions, held) = self.under(trial)?;
        let gap = self.widest(&held);
        if self.wall.exact && gap > OPEN {
            return Err(Inadmissible::Contribution(format!(
                "has a gap of {} cells after rounds of balance, expected none: its `stiffness` is too small, or something else \
                 holds a place of the side elsewhere",
                six_digits(gap)
            )));
        }
        let pose = self.pose(trial);
        let angle = match self.driven(trial) {
            None => self.wall.motion.angle(trial.end),
            Some(driven) => self.standing.angle + driven.increment.turn.z,
        };
        self.prepared_summary = Summary::at(pose.place(&self.wall.moment_about), angle);
        self.prepared_summary.add(&held, &positions);
        self.prepared = self.pulls(&held);
        self.prepared_standing = Standing { pose, angle };
        self.markers.prepare(&trial.increment.nodes);
        Ok(())
    }

    fn commit(&mut self) {
        self.markers.commit();
        std::mem::swap(&mut self.carried, &mut self.prepared);
        self.standing = self.prepared_standing;
        self.summary.clone_from(&self.prepared_summary);
    }

    fn save(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.standing.save(&mut numbers);
        numbers.extend(&self.carried);
        self.markers.save(&mut numbers);
        numbers
    }

    fn restore(&mut self, saved: &[f64]) -> Result<(), String> {
        let (standing, carried) = (Standing::<D>::NUMBERS, self.carried.len());
        check_saved(saved, standing + carried + self.markers.n_saved())?;
        self.standing = Standing::restore(&saved[..standing])?;
        self.carried.copy_from_slice(&saved[standing..standing + carried]);
        self.markers.restore(&saved[standing + carried..]);
        Ok(())
    }

    fn history(&self) -> Vec<Recorded> {
        self.summary.columns(&self.name)
    }
}
