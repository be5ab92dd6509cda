//! States of points at the end of a load step, four points at a time.

use crate::body::batch::{BATCH, Gathered};
use crate::body::batch_law::{AdvancingLaw, Returned};
use crate::body::batch_steps::Steps;
use crate::body::batch_trial::Asked;
use crate::body::kinematics::{LargestStrain, StepGradient};
use crate::body::points::Points;
use crate::body::trial::{InadmissiblePoint, StepOf, step_of};
use mpm_basis::Group;
use mpm_grid::{Block, Vector};
use mpm_material::SymmetricTensor;
use mpm_material::lanes::{Lanes, Number, Work, vectorised};

/// The columns that are written at the end of a load step, for a run of points.
pub(crate) struct StateColumns<'a, const D: usize> {
    pub deformation_gradient: &'a mut [Block<D>],
    /// Empty where there is no hoop.
    pub hoop_stretch: &'a mut [f64],
    /// Empty where nothing turns.
    pub angle: &'a mut [f64],
    pub elastic_excess: &'a mut [SymmetricTensor],
    /// Empty where nothing yields.
    pub plastic: &'a mut [bool],
}

impl<const D: usize> StateColumns<'_, D> {
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (deformation_gradient, deformation_gradient_rest) = self.deformation_gradient.split_at_mut(at);
        let (hoop_stretch, hoop_stretch_rest) = self.hoop_stretch.split_at_mut(at.min(self.hoop_stretch.len()));
        let (angle, angle_rest) = self.angle.split_at_mut(at.min(self.angle.len()));
        let (elastic_excess, elastic_excess_rest) = self.elastic_excess.split_at_mut(at);
        let (plastic, plastic_rest) = self.plastic.split_at_mut(at.min(self.plastic.len()));
        (
            Self { deformation_gradient, hoop_stretch, angle, elastic_excess, plastic },
            Self {
                deformation_gradient: deformation_gradient_rest,
                hoop_stretch: hoop_stretch_rest,
                angle: angle_rest,
                elastic_excess: elastic_excess_rest,
                plastic: plastic_rest,
            },
        )
    }
}

/// What the states of a run of points come from.
pub(crate) struct Advanced<'a, const D: usize, const HOOP: bool> {
    pub points: &'a Points<D>,
    /// `Δu_v` of every active node.
    pub increment: &'a [Vector<D>],
    /// `ΔF - I` of every point where volume changes are averaged, else empty.
    pub dilated: &'a [StepGradient<D>],
}

impl<'a, const D: usize, const HOOP: bool> Advanced<'a, D, HOOP> {
    /// Writes the states of the points of some groups, which follow one another; the largest strain of those that yield.
    ///
    /// # Errors
    /// The first point (in order) that has no admissible state.
    pub fn write(
        &self,
        groups: impl Iterator<Item = Group<'a, D>>,
        law: &mut dyn AdvancingLaw,
        columns: &mut StateColumns<'_, D>,
    ) -> Result<LargestStrain, InadmissiblePoint> {
        if !law.is_asked() {
            self.keep_trials(groups, columns)?;
            return Ok(LargestStrain::default());
        }
        let mut largest = LargestStrain::default();
        let (mut gathered, mut memory) = (Gathered::new(), Memory::new());
        let mut at = 0;
        let mut written = |gathered: &Gathered<'_, D>| {
            let (law, columns) = (&mut *law, &mut *columns);
            let part =
                Part { of: self, gathered, memory: &mut memory, law, columns, at, largest: &mut largest };
            at += gathered.points().len();
            part.advance()
        };
        for group in groups {
            let mut from = 0;
            while from < group.points {
                from = gathered.push((0, group), from, (false, false));
                if gathered.is_full() {
                    written(&gathered)?;
                    gathered.clear();
                }
            }
        }
        written(&gathered)?;
        Ok(largest)
    }

    /// As [`Self::write`] where every trial state is the state at the end, which needs no principal axes.
    fn keep_trials(
        &self,
        groups: impl Iterator<Item = Group<'a, D>>,
        columns: &mut StateColumns<'_, D>,
    ) -> Result<(), InadmissiblePoint> {
        let Self { points, increment, dilated } = *self;
        let mut du = Vec::new();
        let mut at = 0;
        for group in groups {
            du.clear();
            du.extend(group.nodes.iter().map(|&node| increment[node as usize]));
            for k in 0..group.points {
                let p = group.first_point + k;
                let influences = group.point(k);
                let measured = || StepGradient::of::<HOOP>(&du, influences, points.position[p][0]);
                let gradient = dilated.get(p).copied().unwrap_or_else(measured);
                let StepOf { step, hoop, .. } = step_of::<D, HOOP>(p, &gradient)?;
                columns.elastic_excess[at] = gradient.trial_excess::<HOOP>(&points.elastic_excess[p]);
                columns.deformation_gradient[at] = step * points.deformation_gradient[p];
                if HOOP && D == 2 {
                    columns.hoop_stretch[at] = hoop * points.hoop_stretch[p];
                }
                if HOOP && D == 3 {
                    columns.angle[at] = points.angle[p] + turned(&group, k, increment);
                }
                at += 1;
            }
        }
        Ok(())
    }
}

/// The angle by which point k of a group turns in a load step.
fn turned<const D: usize>(group: &Group<'_, D>, k: usize, increment: &[Vector<D>]) -> f64 {
    group.point(k).0.iter().zip(group.nodes).map(|(value, &node)| value * increment[node as usize][D - 1]).sum()
}

/// What is known of the points of a batch.
struct Memory<const D: usize> {
    steps: Steps<D>,
    asked: Asked<D>,
    returned: [Returned; BATCH],
}

impl<const D: usize> Memory<D> {
    fn new() -> Self {
        let steps = Steps::new(const { 3_usize.pow(D as u32) });
        Self { steps, asked: Asked::new(), returned: [Returned::NONE; BATCH] }
    }
}

/// The points of a batch.
struct Part<'a, 'b, 'c, const D: usize, const HOOP: bool> {
    of: &'a Advanced<'b, D, HOOP>,
    gathered: &'a Gathered<'a, D>,
    memory: &'a mut Memory<D>,
    law: &'a mut dyn AdvancingLaw,
    columns: &'a mut StateColumns<'c, D>,
    /// Place of the first one in the columns.
    at: usize,
    largest: &'a mut LargestStrain,
}

impl<const D: usize, const HOOP: bool> Part<'_, '_, '_, D, HOOP> {
    fn advance(mut self) -> Result<(), InadmissiblePoint> {
        let Advanced { points, increment, dilated } = *self.of;
        let numbers = self.gathered.points();
        let Memory { steps, asked, returned } = &mut *self.memory;
        if dilated.is_empty() {
            steps.measure::<HOOP>(self.gathered, increment, &points.position);
        } else {
            for (place, &p) in numbers.iter().enumerate() {
                steps.set(place, &dilated[p]);
            }
        }
        let collected = asked.collect::<HOOP>(steps, points, numbers);
        // A point that its law refuses may stand before one that has no step.
        let n = asked.strained().len();
        self.law.advance(asked.strained(), &mut returned[..n])?;
        collected?;
        vectorised(Writing(&mut self));
        if HOOP && D == 3 {
            self.turn();
        }
        Ok(())
    }

    /// Writes the states of the k-th points whose law has been asked.
    #[inline(always)]
    fn write(&mut self, k: usize) {
        let Memory { steps, asked, returned } = &*self.memory;
        let (strained, four, returned) = (&asked.strained()[k], &asked.fours()[k], &returned[k]);
        let (points, plastic) = (self.of.points, returned.plastic);
        // What does not yield keeps its trial state.
        let trial_state = &four.tried.excess;
        let any = Lanes::any(plastic);
        let after = if any { four.trial.elastic_excess(&returned.elastic_strain) } else { *trial_state };
        for lane in 0..strained.count {
            let place = four.place + lane;
            let (at, p) = (self.at + place, strained.numbers[lane]);
            let kept = if plastic.get(lane) { &after } else { trial_state };
            let SymmetricTensor { xx, yy, zz, xy, yz, zx } = kept;
            let [xx, yy, zz, xy, yz, zx] = [xx, yy, zz, xy, yz, zx].map(|lanes| lanes.0[lane]);
            self.columns.elastic_excess[at] = SymmetricTensor { xx, yy, zz, xy, yz, zx };
            let step = Block::identity() + steps.step(place).block;
            self.columns.deformation_gradient[at] = step * points.deformation_gradient[p];
            let stretch = four.tried.stretch.0[lane];
            if HOOP && D == 2 {
                self.columns.hoop_stretch[at] = stretch * points.hoop_stretch[p];
            }
            if let Some(is_plastic) = self.columns.plastic.get_mut(at) {
                *is_plastic = plastic.get(lane);
            }
            if plastic.get(lane) {
                self.largest.see::<D, HOOP>(&step, stretch);
            }
        }
    }

    /// Writes the angles of a body that turns.
    fn turn(&mut self) {
        let mut at = self.at;
        for segment in self.gathered.segments() {
            let group = &segment.group;
            for k in segment.from..segment.to {
                let turned = turned(group, k, self.of.increment);
                self.columns.angle[at] = self.of.points.angle[group.first_point + k] + turned;
                at += 1;
            }
        }
    }
}

/// Writes the states of all points whose law has been asked.
struct Writing<'w, 'a, 'b, 'c, const D: usize, const HOOP: bool>(&'w mut Part<'a, 'b, 'c, D, HOOP>);

impl<const D: usize, const HOOP: bool> Work for Writing<'_, '_, '_, '_, D, HOOP> {
    type Output = ();

    #[inline(always)]
    fn run<const VECTORS: bool>(self) {
        for k in 0..self.0.memory.asked.strained().len() {
            self.0.write(k);
        }
    }
}
