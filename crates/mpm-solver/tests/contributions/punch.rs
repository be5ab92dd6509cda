//! A rigid punch with three unknowns of its own, on springs.

use super::setup::{History, square};
use mpm_assembly::{
    Begun, Block, Contribution, ContributionEnergy, CoupledPlaces, Couplings, Inadmissible, Recorded, Refused,
    Scale, StepStart, SystemSums, Trial, UnknownId, Unknowns,
};
use mpm_grid::{LoadFraction, NodeId, Ramp, Region, Vector};
use mpm_linear::Symmetry;
use mpm_solver::run;

/// Springs of stiffness κ `[F/L]` between the nodes of the top and a rigid punch, whose pose is (x, y, angle) about the
/// middle of the top.
struct Punch {
    nodes: Vec<NodeId>,
    stiffness: f64,
    drive: Drive,
    span: [LoadFraction; 2],
    block: Option<Block>,
    places: CoupledPlaces,
    numbers: Vec<usize>,
    present: State,
    prepared: State,
}

/// What moves the punch.
enum Drive {
    /// Force and moment at full load; the pose is unknown.
    Force([f64; 3]),
    /// The pose against the load fraction.
    Pose([Ramp; 3]),
}

/// The pose, the stretch of every spring, and the force that the punch exerts.
#[derive(Clone)]
struct State {
    pose: [f64; 3],
    stretch: Vec<Vector<2>>,
    force: [f64; 3],
}

/// Displacement of the punch at a node, its derivatives by the pose, and the second one by the angle.
struct Moved {
    by: Vector<2>,
    first: [Vector<2>; 3],
    second: Vector<2>,
}

impl Punch {
    fn new(nodes: Vec<NodeId>, drive: Drive) -> Self {
        let present = State { pose: [0.0; 3], stretch: vec![Vector::zeros(); nodes.len()], force: [0.0; 3] };
        let (span, places) = ([LoadFraction::START; 2], CoupledPlaces::default());
        let prepared = present.clone();
        Self { nodes, stiffness: 1e4, drive, span, block: None, places, numbers: Vec::new(), present, prepared }
    }

    /// Change of the pose in the step.
    fn change(&self, trial: &Trial<'_, 2>) -> [f64; 3] {
        match (&self.drive, self.block) {
            (Drive::Force(_), Some(block)) => block.of(&trial.increment.own).try_into().unwrap(),
            (Drive::Pose(ramps), _) => {
                std::array::from_fn(|k| ramps[k].value(trial.end) - ramps[k].value(self.span[0]))
            }
            _ => unreachable!("a punch under forces has unknowns"),
        }
    }

    fn moved(&self, k: usize, q: &[f64; 3]) -> Moved {
        let arm = |angle: f64| {
            let arm = k as f64 / (self.nodes.len() - 1) as f64 - 0.5;
            Vector::<2>::new(angle.cos() * arm, angle.sin() * arm)
        };
        let turned = arm(self.present.pose[2] + q[2]);
        let across = Vector::<2>::new(-turned[1], turned[0]);
        let by = Vector::<2>::new(q[0], q[1]) + turned - arm(self.present.pose[2]);
        Moved { by, first: [Vector::<2>::new(1.0, 0.0), Vector::<2>::new(0.0, 1.0), across], second: -turned }
    }

    fn stretch(&self, k: usize, q: &[f64; 3], trial: &Trial<'_, 2>) -> Vector<2> {
        self.present.stretch[k] + trial.increment.nodes[self.numbers[k]] - self.moved(k, q).by
    }
}

impl Contribution<2> for Punch {
    fn begin(&mut self, step: &StepStart<'_, 2>, unknowns: &mut Unknowns<2>) -> Result<Begun, Refused> {
        self.span = [step.from, step.to];
        self.block = matches!(self.drive, Drive::Force(_)).then(|| unknowns.push(1, 3));
        self.numbers = self.nodes.iter().map(|&node| step.active.number(node).unwrap()).collect();
        self.places = CoupledPlaces::default();
        let own = self.block.map(|block| block.place(0));
        self.places.push(self.numbers.iter().map(|&it| it as u32).chain(own));
        Ok(Begun::Anew)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.places
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn moves_with_load(&self) -> bool {
        true
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        let (q, numbering, kappa) = (self.change(trial), trial.pattern.unknowns(), self.stiffness);
        for (k, &number) in self.numbers.iter().enumerate() {
            let (stretch, moved) = (self.stretch(k, &q, trial), self.moved(k, &q));
            let mut unknowns: Vec<UnknownId> = [0, 1].map(|i| numbering.displacement(number, i)).into();
            // Derivatives of the stretch by the unknowns.
            let mut by = vec![Vector::<2>::new(1.0, 0.0), Vector::<2>::new(0.0, 1.0)];
            if let Some(block) = self.block {
                unknowns.extend((0..3).map(|i| block.unknown(0, i)));
                by.extend(moved.first.map(|first| -first));
            }
            let force: Vec<f64> = by.iter().map(|by| kappa * stretch.dot(by)).collect();
            let mut stiffness: Vec<f64> = by.iter().flat_map(|a| by.iter().map(|b| kappa * a.dot(b))).collect();
            if let (Some(last), Some(_)) = (stiffness.last_mut(), self.block) {
                *last -= kappa * stretch.dot(&moved.second);
            }
            sums.add(trial, &unknowns, &force, &stiffness);
        }
        if let (Some(block), Drive::Force(load)) = (self.block, &self.drive) {
            let unknowns: [UnknownId; 3] = std::array::from_fn(|i| block.unknown(0, i));
            sums.add(trial, &unknowns, &load.map(|load| -load * trial.end.get()), &[0.0; 9]);
        }
        Ok(())
    }

    fn scale(&self, trial: &Trial<'_, 2>) -> Scale<2> {
        let q = self.change(trial);
        let force = |k: usize| self.stiffness * self.stretch(k, &q, trial).norm();
        (0..self.nodes.len()).map(force).sum::<f64>().into()
    }

    fn own_scale(&self, trial: &Trial<'_, 2>) -> Vec<f64> {
        match &self.drive {
            Drive::Force(load) => vec![load.iter().map(|load| load.abs()).sum::<f64>() * trial.end.get()],
            Drive::Pose(_) => Vec::new(),
        }
    }

    fn energy(&self, trial: &Trial<'_, 2>) -> ContributionEnergy {
        let q = self.change(trial);
        let stored = |k: usize| 0.5 * self.stiffness * self.stretch(k, &q, trial).norm_squared();
        let mean = 0.5 * (trial.end.get() + self.span[0].get());
        let work = match &self.drive {
            Drive::Force(load) => load.iter().zip(&q).map(|(load, q)| mean * load * q).sum(),
            Drive::Pose(_) => 0.0,
        };
        ContributionEnergy { stored: (0..self.nodes.len()).map(stored).sum(), dissipated: 0.0, work }
    }

    fn prepare(&mut self, trial: &Trial<'_, 2>) -> Result<(), Inadmissible> {
        let q = self.change(trial);
        let stretch: Vec<Vector<2>> = (0..self.nodes.len()).map(|k| self.stretch(k, &q, trial)).collect();
        let mut force = [0.0; 3];
        for (k, stretch) in stretch.iter().enumerate() {
            for (force, first) in force.iter_mut().zip(self.moved(k, &q).first) {
                *force -= self.stiffness * stretch.dot(&first);
            }
        }
        let pose = std::array::from_fn(|i| self.present.pose[i] + q[i]);
        self.prepared = State { pose, stretch, force };
        Ok(())
    }

    fn commit(&mut self) {
        self.present.clone_from(&self.prepared);
    }

    fn history(&self) -> Vec<Recorded> {
        let State { pose, force, .. } = &self.present;
        vec![Recorded::real("punch/pose", *pose), Recorded::real("punch/force", *force)]
    }
}

const LOAD: [f64; 3] = [0.5, -4.0, 0.6];
const STEPS: u32 = 4;

fn run_with(drive: Drive) -> History {
    let mut model = square(4);
    let top = Region::<2>::Plane { axis: 1, at: 1.0 };
    let top = top.nodes(&model.nodes, &model.layout);
    model.add_contribution("punch", Box::new(Punch::new(top, drive)));
    (model.stages[0].steps, model.energies) = (STEPS, true);
    let mut history = History::default();
    run(&mut model, &mut history).unwrap();
    history
}

#[test]
fn a_punch_under_forces_takes_the_poses_that_need_these_forces() {
    let loaded = run_with(Drive::Force(LOAD));
    let pose: Vec<[f64; 3]> = loaded.columns["punch/pose"].as_chunks().0.to_vec();
    assert!(pose[4][1] < -1e-3 && pose[4][2] > 1e-3, "the punch sinks and turns: {pose:?}");
    let forces = loaded.columns["punch/force"].as_chunks::<3>().0;
    for (step, force) in forces.iter().enumerate().skip(1) {
        for (force, load) in force.iter().zip(LOAD) {
            let expected = load * step as f64 / f64::from(STEPS);
            assert!((force - expected).abs() < 4e-9, "step {step}: {force} for {expected}");
        }
    }
    let ramp = |k: usize| {
        let knots = pose.iter().enumerate().map(|(step, pose)| (step as f64 / f64::from(STEPS), pose[k]));
        Ramp::new(knots.collect()).unwrap()
    };
    let driven = run_with(Drive::Pose([ramp(0), ramp(1), ramp(2)]));
    for (a, b) in loaded.columns["punch/force"].iter().zip(&driven.columns["punch/force"]) {
        assert!((a - b).abs() < 4e-9, "{a} under forces, {b} at the same poses");
    }
    for history in [&loaded, &driven] {
        for residuals in &history.residuals[1..] {
            assert!(
                residuals.len() <= 5 && residuals.last().is_some_and(|last| *last < 1e-11),
                "{residuals:?}"
            );
        }
    }
    // The work of the forces is stored in the body and in the springs, but for the trapezium of each step.
    let last = |name: &str| loaded.columns[name].last().copied().unwrap();
    let (work, unbalanced) = (last("energy/external_work"), last("energy/unbalanced"));
    assert!(work > 0.0 && unbalanced.abs() < 2e-2 * work, "{unbalanced:e} of {work:e}");
}
