//! The check of a contribution against differences finds what is wrong.

use mpm_assembly::{
    Block, Constraints, Contribution, CoupledPlaces, Couplings, Inadmissible, SparsityPattern, SystemSums,
    Trial, UnknownVector, Unknowns, stiffness_error,
};
use mpm_grid::LoadFraction;
use mpm_linear::Symmetry;

/// Ties the x-displacement u of a node to an unknown q of its own, with the energy `½ q² + ¼ (u - q)⁴`.
struct Tie {
    block: Block,
    places: CoupledPlaces,
    /// The entry of the tangent that is wrong, if any.
    wrong: Option<usize>,
}

impl Contribution<2> for Tie {
    fn couplings(&self) -> &dyn Couplings {
        &self.places
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::Symmetric
    }

    fn add(&self, trial: &Trial<'_, 2>, sums: &mut SystemSums<'_, 2>) -> Result<(), Inadmissible> {
        let (u, q) = (trial.increment.nodes[1][0], self.block.of(&trial.increment.own)[0]);
        let (force, stiffness) = ((u - q).powi(3), 3.0 * (u - q).powi(2));
        let mut tangent = [stiffness, -stiffness, -stiffness, 1.0 + stiffness];
        self.wrong.into_iter().for_each(|entry| tangent[entry] *= 1.01);
        let unknowns = [trial.pattern.unknowns().displacement(1, 0), self.block.unknown(0, 0)];
        sums.add(trial, &unknowns, &[force, q - force], &tangent);
        Ok(())
    }
}

#[test]
fn a_wrong_entry_is_found() -> Result<(), Box<dyn std::error::Error>> {
    let mut unknowns = Unknowns::<2>::of_nodes(2);
    let block = unknowns.push(1, 1);
    let mut places = CoupledPlaces::default();
    places.push([unknowns.place(1), block.place(0)]);
    let pattern = SparsityPattern::reusing(None, &unknowns, Symmetry::Symmetric, &[&places]);
    let mut increment = UnknownVector::zeros(&unknowns);
    increment.read_equations(&[0.0, 0.0, 0.7, 0.0, -0.2]);
    let constraints = Constraints::none(2);
    let trial = Trial {
        pattern: &pattern,
        constraints: &constraints,
        increment: &increment,
        end: LoadFraction::END,
        is_first: false,
    };
    let mut tie = Tie { block, places, wrong: None };
    let right = stiffness_error(&tie, &trial)?;
    assert!(right < 1e-9, "{right:e}");
    // The entry above the diagonal is not stored.
    for wrong in [0, 1, 3] {
        tie.wrong = Some(wrong);
        let error = stiffness_error(&tie, &trial)?;
        assert!(error > 1e-4, "entry {wrong}: {error:e}");
    }
    Ok(())
}
