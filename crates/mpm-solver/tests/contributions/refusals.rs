//! Models that a run refuses before it begins.

use super::setup::{law, seeds, square};
use mpm_assembly::{
    Contribution, CoupledPlaces, Couplings, Inadmissible, MaterialBody, Recorded, SystemSums, Trial,
};
use mpm_basis::Smpm;
use mpm_grid::{LoadFraction, Ramp, Vector};
use mpm_solver::{BodyForce, ModelError, Stage, run};
use std::sync::Arc;

/// Does nothing, and says so in one column.
struct Nothing(&'static str, CoupledPlaces);

impl Nothing {
    fn with(column: &'static str) -> Box<Self> {
        Box::new(Self(column, CoupledPlaces::default()))
    }
}

impl Contribution<2> for Nothing {
    fn couplings(&self) -> &dyn Couplings {
        &self.1
    }

    fn add(&self, _: &Trial<'_, 2>, _: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        Ok(())
    }

    fn history(&self) -> Vec<Recorded> {
        vec![Recorded::real(self.0, [0.0])]
    }
}

#[test]
fn names_are_given_once() {
    let refused = |contributions: [(&str, &'static str); 2]| {
        let mut model = square(1);
        for (name, column) in contributions {
            model.add_contribution(name, Nothing::with(column));
        }
        run(&mut model, &mut ()).err().map(|error| error.to_string())
    };
    assert_eq!(refused([("a", "a/x"), ("b", "b/x")]), None);
    let name = refused([("a", "a/x"), ("a", "b/x")]).expect("refused");
    assert!(name.contains("two contributions of the name `a`"), "{name}");
    for (column, contributions) in
        [("a/x", [("a", "a/x"), ("b", "a/x")]), ("residual", [("a", "a/x"), ("b", "residual")])]
    {
        let reason = refused(contributions).expect("refused");
        assert!(reason.contains(&format!("contribution `b` has a column `{column}`")), "{reason}");
    }
}

#[derive(Debug)]
struct Push;

impl BodyForce<2> for Push {
    fn force(&self, _: &Vector<2>, _: LoadFraction) -> Vector<2> {
        Vector::zeros()
    }

    fn ramps(&self) -> Vec<&Ramp> {
        Vec::new()
    }
}

#[test]
fn forces_on_points_that_lack_what_they_need_are_refused() {
    let mut model = square(1);
    model.loads.body_forces.push((Vector::<2>::new(0.0, -1.0), Ramp::linear(1.0)));
    assert_eq!(model.check(), Err(ModelError::NoMasses { body: "square".into() }));
    assert!(run(&mut model, &mut ()).is_err_and(|error| error.to_string().contains("have no masses")));
    model.bodies[0].body = Box::new(MaterialBody::new(Smpm, law(), seeds(1, |_, _| true)).with_density(1.0));
    assert_eq!(model.check(), Ok(()));
    model.loads.fields.push((0, Arc::new(Push)));
    assert_eq!(model.check(), Err(ModelError::NoRest { body: "square".into() }));
}

#[test]
fn stages_that_cannot_be_run_are_refused() {
    let mut model = square(1);
    model.stages.clear();
    assert_eq!(model.check(), Err(ModelError::NoStages));
    assert!(run(&mut model, &mut ()).is_err_and(|error| error.to_string().contains("no load steps")));
    model.stages.push(Stage { name: "late".into(), resets_displacements: true, ..Stage::equal(1) });
    assert_eq!(model.check(), Ok(()));
    let body = MaterialBody::new(Smpm, law(), seeds(1, |_, _| true)).with_reference_positions();
    model.bodies[0].body = Box::new(body);
    model.loads.fields.push((0, Arc::new(Push)));
    assert_eq!(model.check(), Err(ModelError::NoRestAfterReset { stage: "late".into() }));
}
