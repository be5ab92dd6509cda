//! A residual that is not a number is never passed over.

use super::setup::{History, square};
use mpm_assembly::{
    Begun, Block, Contribution, CoupledPlaces, Couplings, Inadmissible, Refused, StepStart, SystemSums, Trial,
    Unknowns,
};
use mpm_linear::Symmetry;
use mpm_solver::{Error, StepFailure, run};

/// An unknown on a spring, pulled by a force of 1; its residual is compared with `scale`.
struct Spring {
    scale: f64,
    block: Option<Block>,
    places: CoupledPlaces,
}

impl Spring {
    fn with(scale: f64) -> Box<Self> {
        Box::new(Self { scale, block: None, places: CoupledPlaces::default() })
    }
}

impl Contribution<2> for Spring {
    fn begin(&mut self, _: &StepStart<'_, 2>, unknowns: &mut Unknowns<2>) -> Result<Begun, Refused> {
        let block = unknowns.push(1, 1);
        self.places = CoupledPlaces::default();
        self.places.push([block.place(0)]);
        self.block = Some(block);
        Ok(Begun::Anew)
    }

    fn couplings(&self) -> &dyn Couplings {
        &self.places
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        let block = self.block.expect("the step has begun");
        let x = block.of(&trial.increment.own)[0];
        // A cubic spring: some iterations leave a residual.
        sums.add(trial, &[block.unknown(0, 0)], &[x + x.powi(3) - 1.0], &[1.0 + 3.0 * x * x]);
        Ok(())
    }

    fn own_scale(&self, _: &Trial<'_, 2>) -> Vec<f64> {
        vec![self.scale]
    }
}

#[test]
fn a_step_with_a_residual_that_is_not_a_number_has_not_converged() {
    let outcome = |scales: &[f64]| {
        let mut model = square(2);
        for (k, &scale) in scales.iter().enumerate() {
            model.add_contribution(format!("spring {k}"), Spring::with(scale));
        }
        run(&mut model, &mut History::default())
    };
    assert!(outcome(&[1.0, 1.0]).is_ok());
    // Wherever it stands among others.
    for scales in [[f64::NAN, 1.0], [1.0, f64::NAN]] {
        let outcome = outcome(&scales);
        let is_told = matches!(&outcome, Err(Error::Step { reason: StepFailure::NotConverged { .. }, .. }));
        assert!(is_told, "{scales:?}: {:?}", outcome.err());
    }
}
