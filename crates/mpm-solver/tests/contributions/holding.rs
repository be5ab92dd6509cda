//! Bodies that no support holds: what contributions add is asked, whatever they are.

use super::setup::{self, History, square};
use mpm_assembly::{
    Begun, Contribution, CoupledPlaces, Couplings, Inadmissible, MaterialBody, Refused, Scale, StepStart,
    SystemSums, Trial, UnknownId, Unknowns,
};
use mpm_basis::Smpm;
use mpm_grid::{NodeId, Ramp, Region, Vector};
use mpm_linear::{Choice, Symmetry};
use mpm_solver::{Error, Model, PointLoad, Prescribed, Share, StepFailure, UnheldMotion, run};

/// Springs between nodes and the ground.
struct Springs {
    nodes: Vec<NodeId>,
    /// Of each component `[F/L]`.
    stiffness: [f64; 2],
    numbers: Vec<usize>,
    places: CoupledPlaces,
}

impl Springs {
    fn on(model: &Model<2>, region: &Region<2>, stiffness: [f64; 2]) -> Box<Self> {
        let nodes = region.nodes(&model.nodes, &model.layout);
        Box::new(Self { nodes, stiffness, numbers: Vec::new(), places: CoupledPlaces::default() })
    }
}

impl Contribution<2> for Springs {
    fn begin(&mut self, step: &StepStart<'_, 2>, _: &mut Unknowns<2>) -> Result<Begun, Refused> {
        self.numbers = self.nodes.iter().filter_map(|&node| step.active.number(node)).collect();
        self.places = CoupledPlaces::default();
        self.numbers.iter().for_each(|&it| self.places.push([it as u32]));
        Ok(Begun::Anew)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.places
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        for &node in &self.numbers {
            let unknowns: [UnknownId; 2] =
                std::array::from_fn(|i| trial.pattern.unknowns().displacement(node, i));
            let u: Vector<2> = trial.increment.nodes[node];
            let force = [self.stiffness[0] * u[0], self.stiffness[1] * u[1]];
            sums.add(trial, &unknowns, &force, &[self.stiffness[0], 0.0, 0.0, self.stiffness[1]]);
        }
        Ok(())
    }

    fn scale(&self, trial: &Trial<'_, 2>) -> Scale<2> {
        let stiffness: Vector<2> = self.stiffness.into();
        let force = |&node: &usize| trial.increment.nodes[node].component_mul(&stiffness).norm();
        self.numbers.iter().map(force).sum::<f64>().into()
    }
}

/// A square that hangs on springs alone; what nothing holds.
fn hung(springs: &[(Region<2>, [f64; 2])], solver: Choice) -> Result<(), String> {
    let mut model = square(3);
    model.supports.clear();
    model.solver = solver.into();
    for (k, (region, stiffness)) in springs.iter().enumerate() {
        let springs = Springs::on(&model, region, *stiffness);
        model.add_contribution(format!("springs {k}"), springs);
    }
    match run(&mut model, &mut History::default()) {
        Ok(_) => Ok(()),
        Err(Error::Step { reason: StepFailure::Unheld { motion }, .. }) => Err(motion),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn springs_hold_what_they_resist() {
    let base = || Region::<2>::Plane { axis: 1, at: 0.0 };
    let corner = |x: f64| Region::<2>::Point([x, 0.0].into());
    for solver in [Choice::Direct, Choice::Iterative] {
        let hung = |springs: &[(Region<2>, [f64; 2])]| hung(springs, solver);
        assert_eq!(hung(&[(base(), [1.0, 1.0])]), Ok(()));
        // They are soft, and they hold.
        assert_eq!(hung(&[(base(), [1e-6, 1e-6])]), Ok(()));
        assert_eq!(hung(&[(base(), [0.0, 1.0])]), Err("body `square` along x".into()));
        let turns = |x: f64| Err(format!("body `square` in rotation about the point ({x}, 0)"));
        assert_eq!(hung(&[(corner(0.0), [1.0, 1.0])]), turns(0.0));
        assert_eq!(hung(&[(corner(1.0), [1.0, 1.0])]), turns(1.0));
        assert_eq!(hung(&[(corner(0.0), [1.0, 1.0]), (corner(1.0), [0.0, 1e-3])]), Ok(()));
        let all = "body `square` along x, along y and in rotation";
        assert_eq!(hung(&[]), Err(all.into()));
    }
}

#[test]
fn loads_may_act_along_what_springs_hold_and_nothing_else() {
    // A square between springs along y, and a force along x or y.
    let outcome = |force: [f64; 2]| {
        let mut model = square(3);
        model.supports.clear();
        model.unheld_motion = UnheldMotion::Zero;
        let springs = Springs::on(&model, &Region::<2>::Plane { axis: 1, at: 0.0 }, [0.0, 10.0]);
        model.add_contribution("springs", springs);
        let share = |point| Share { point, part: 1.0 / 36.0, arm: Vector::zeros() };
        let shares = (0..36).map(share).collect();
        let ramp = Ramp::linear(1.0);
        model.loads.point_loads.push(PointLoad { body: 0, shares, force: force.into(), ramp });
        run(&mut model, &mut History::default())
    };
    assert!(outcome([0.0, 1.0]).is_ok());
    let outcome = outcome([1.0, 0.0]);
    let is_named = matches!(&outcome, Err(Error::Step { reason: StepFailure::UnheldLoaded { .. }, .. }));
    assert!(is_named, "{:?}", outcome.err());
}

#[test]
fn parts_of_a_body_are_told_by_their_points_and_place() {
    let mut model = square(5);
    // The middle column of cells is empty: two parts, which share no node.
    let seeds = setup::seeds(5, |i, _| i != 2);
    model.bodies.clear();
    model.add_body("square", Box::new(MaterialBody::new(Smpm, setup::law(), seeds)));
    model.supports.clear();
    let left = Region::<2>::Box { from: [0.0, 0.0].into(), to: [0.4, 0.0].into() };
    model.add_support("left", &left, [Some(Prescribed::Held), Some(Prescribed::Held)]);
    let outcome = run(&mut model, &mut History::default());
    let Err(Error::Step { reason: StepFailure::Unheld { motion }, .. }) = outcome else { panic!("held") };
    let part = "a part of body `square` (40 of 80 points around (0.8, 0.5))";
    assert_eq!(motion, format!("{part} along x, along y and in rotation"));
    // Cells of one colour of a chessboard are hinged at their corners; those at the corners of the square turn.
    let chessboard: fn(u32, u32) -> bool = |i, j| (i + j) % 2 == 0;
    let debris: fn(u32, u32) -> bool = |i, j| i % 2 == 0 && j % 2 == 0;
    let mut told = |has_material: fn(u32, u32) -> bool| {
        model.bodies.clear();
        let seeds = setup::seeds(5, has_material);
        model.add_body("square", Box::new(MaterialBody::new(Smpm, setup::law(), seeds)));
        match run(&mut model, &mut History::default()) {
            Err(Error::Step { reason: StepFailure::Unheld { motion }, .. }) => motion,
            _ => panic!("held"),
        }
    };
    let corner = |x: f64, y: f64, at: &str| {
        format!("a part of body `square` (4 of 52 points around ({x}, {y})) in rotation about the point {at}")
    };
    let corners =
        [corner(0.9, 0.1, "(0.8, 0.2)"), corner(0.1, 0.9, "(0.2, 0.8)"), corner(0.9, 0.9, "(0.8, 0.8)")];
    assert_eq!(told(chessboard), corners.join("; nor "));
    assert!(told(debris).ends_with("; nor 5 more parts"), "{}", told(debris));
}
