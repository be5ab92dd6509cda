//! The V-cycle of multigrid: PETSc's matrices on every level, and sweeps of our own.

use crate::error::PetscError;
use crate::handles::{Field, Mat, Others};
use crate::ksp::{Ksp, Precondition};
use crate::lattices::Coarser;
use crate::product::Product;
use crate::sweeps::{Sweeps, power_of_two_near};
use mpm_cluster::Wire;
use std::rc::Rc;

/// A cycle for matrices of blocks that have this size, with these coarser lattices, the finest first.
pub(crate) fn cycle(
    wire: &Rc<dyn Wire>,
    lattices: Vec<Coarser>,
    block: usize,
) -> Result<Box<dyn Precondition>, PetscError> {
    Ok(match block {
        1 => Box::new(Cycle::<1, 1>::of(wire, lattices)?),
        2 => Box::new(Cycle::<2, 2>::of(wire, lattices)?),
        _ => Box::new(Cycle::<3, 4>::of(wire, lattices)?),
    })
}

/// Largest size of blocks that a cycle is made for.
pub(crate) const LARGEST_BLOCK: usize = 3;

/// One level but the coarsest.
struct Level<const D: usize, const L: usize> {
    interpolation: Mat,
    /// Made with the first values.
    sweeps: Option<Sweeps<D, L>>,
    others: Option<Others>,
    product: Product,
    /// The matrix of the next coarser level.
    coarser: Mat,
    /// Right-hand side and solution of the next coarser level.
    below: [Field; 2],
    /// For residuals and corrections of this level.
    spare: Field,
}

/// Levels from the finest on, and who solves the coarsest.
struct Cycle<const D: usize, const L: usize> {
    wire: Rc<dyn Wire>,
    levels: Vec<Level<D, L>>,
    coarsest: Option<Ksp>,
}

impl<const D: usize, const L: usize> Cycle<D, L> {
    fn of(wire: &Rc<dyn Wire>, lattices: Vec<Coarser>) -> Result<Self, PetscError> {
        let level = |Coarser { interpolation, product, others }: Coarser| {
            // What an interpolation is multiplied by, and what comes out.
            let (coarse, spare) = interpolation.vectors()?;
            let below = [coarse.alike()?, coarse];
            let (product, coarser) = product.expect("lattices of a cycle have products");
            Ok(Level { interpolation, sweeps: None, others, product, coarser, below, spare })
        };
        let levels = lattices.into_iter().map(level).collect::<Result<_, PetscError>>()?;
        Ok(Self { wire: wire.clone(), levels, coarsest: None })
    }
}

impl<const D: usize, const L: usize> Precondition for Cycle<D, L> {
    fn take(&mut self, finest: &Mat) -> Result<bool, PetscError> {
        let mut is_well = true;
        for k in 0..self.levels.len() {
            let (finer, rest) = self.levels.split_at_mut(k);
            let matrix = finer.last().map_or(finest, |it| &it.coarser);
            let level = &mut rest[0];
            let mut outcome = Ok(());
            matrix.with_parts(|parts| {
                let sweeps = level.sweeps.get_or_insert_with(|| Sweeps::of(&parts));
                is_well &= sweeps.take(&parts);
                outcome = level.product.take::<D>(&*self.wire, &parts, &level.coarser);
            })?;
            outcome?;
        }
        let coarsest = self.levels.last().map_or(finest, |it| &it.coarser);
        if self.coarsest.is_none() {
            let solver = Ksp::of(coarsest, Some(c"mg_coarse_"))?;
            solver.method(c"preonly")?;
            solver.precondition(c"redundant")?;
            solver.read_options()?;
            self.coarsest = Some(solver);
        }
        let solver = self.coarsest.as_ref().expect("made above");
        Ok(solver.set_up(coarsest, false)? && is_well)
    }

    fn apply(&mut self, b: &mut Field, x: &mut Field) -> Result<(), PetscError> {
        let coarsest = self.coarsest.as_ref().expect("values are taken before");
        // The right-hand side is brought near 1 before it is rounded.
        let up = power_of_two_near(b.size()?.recip());
        go(&mut self.levels, coarsest, (b, x), up)
    }
}

/// The cycle from a level on; right-hand sides are multiplied by `up` before they are rounded.
fn go<const D: usize, const L: usize>(
    levels: &mut [Level<D, L>],
    coarsest: &Ksp,
    (b, x): (&mut Field, &mut Field),
    up: f64,
) -> Result<(), PetscError> {
    let Some((here, coarser)) = levels.split_first_mut() else { return coarsest.apply(b, x) };
    let Level { interpolation, sweeps, others, below: [b_below, x_below], spare, .. } = here;
    let sweeps = sweeps.as_mut().expect("values are taken before");
    b.with(|b| sweeps.take_rhs(b, up))?;
    sweeps.sweep_from_zero();
    tell_others(sweeps, others, x, up)?;
    spare.with(|r| sweeps.residual_after_sweep(r, up))?;
    interpolation.transposed_times(spare, b_below)?;
    go(coarser, coarsest, (b_below, x_below), up)?;
    interpolation.times(x_below, spare)?;
    spare.with(|correction| sweeps.correct(correction, up))?;
    tell_others(sweeps, others, x, up)?;
    sweeps.sweep_back();
    x.with(|x| sweeps.give(x, up))
}

/// Tells other ranks what was found for equations that they are coupled with, and hears of theirs.
fn tell_others<const D: usize, const L: usize>(
    sweeps: &mut Sweeps<D, L>,
    others: &mut Option<Others>,
    x: &mut Field,
    up: f64,
) -> Result<(), PetscError> {
    let Some(others) = others else { return Ok(()) };
    x.with(|x| sweeps.give(x, up))?;
    others.hear(x, |theirs| sweeps.take_others(theirs, up))
}
