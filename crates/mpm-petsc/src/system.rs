//! One system of equations: its parts of all ranks, and what solves it.

use crate::assembly::{Assembly, for_each_pair};
use crate::cycle::{LARGEST_BLOCK, cycle};
use crate::error::PetscError;
use crate::ffi::PetscInt;
use crate::handles::{Field, Mat};
use crate::ksp::Ksp;
use crate::lattices::{Coarser, coarser_lattices};
use crate::numbering::Numbering;
use crate::owners::Owners;
use crate::session::Session;
use mpm_cluster::Wire;
use mpm_linear::{Hints, Matrix, Method, Pattern, SystemSize};
use std::rc::Rc;

/// Iterations after which one is given up.
const MOST_ITERATIONS: u32 = 1000;

/// Vectors of GMRES before it begins anew.
const RESTART: u32 = 100;

/// Residual by which a solution may miss what was asked for, because an iteration looks at one that it carries along.
const MISSED: f64 = 10.0;

/// A solution by factorisation is good enough with a residual of this size, whatever was asked for.
const GOOD_ENOUGH: f64 = 1e-9;

/// So is one with a residual of this size beside that of the matrix times that of the solution: of a matrix that is nearly singular,
/// as at a limit point, the solution is so large that rounding alone leaves more of the right-hand side.
const BACKWARD_ERROR: f64 = 1e-12;

/// And which leaves this part of the right-hand side at most: a matrix that is singular leaves what lies outside its range.
const MOST_LEFT: f64 = 1e-6;

/// Steps of refinement after a factorisation, at most.
const REFINEMENTS: usize = 3;

/// A system whose pattern has been analysed.
pub(crate) struct System {
    fingerprint: u64,
    pub(crate) method: Method,
    /// Entries of its factor, about.
    pub(crate) factor_entries: f64,
    wire: Rc<dyn Wire>,
    numbering: Numbering,
    /// Of every own node its place in the caller's numbering.
    place: Vec<usize>,
    block: usize,
    /// Whether each of the caller's equations is held.
    held: Vec<bool>,
    assembly: Assembly,
    matrix: Mat,
    x: Field,
    b: Field,
    /// For residuals and corrections.
    spare: [Field; 2],
    iteration: Ksp,
    factorisation: Option<Ksp>,
}

/// How a solution went.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    pub(crate) is_solved: bool,
    pub(crate) iterations: u32,
    pub(crate) refinements: usize,
    /// `|b − A x| / |b|`.
    pub(crate) residual: f64,
}

impl System {
    /// Of all that a system depends on but what is held.
    pub(crate) fn fingerprint(pattern: Pattern<'_>, hints: &Hints<'_>, owners: &dyn Owners) -> u64 {
        // FNV-1a by whole numbers: quicker than what resists attacks.
        let join = |hash: u64, number: u64| (hash ^ number).wrapping_mul(0x0100_0000_01b3);
        let shape = [pattern.block as u64, u64::from(pattern.is_symmetric())];
        let of_shape = shape.into_iter().fold(0xcbf2_9ce4_8422_2325, join);
        let numbers = pattern.column_start.iter().chain(pattern.row).map(|&it| it as u64);
        let of_pattern = numbers.fold(of_shape, join);
        hints.lattice.iter().flat_map(|it| it.index).fold(of_pattern, |hash, &index| {
            let of_index = index.into_iter().fold(hash, |hash, it| join(hash, it.into()));
            join(of_index, owners.owner(index) as u64)
        })
    }

    /// Whether this is the system of a fingerprint, with the same equations held.
    pub(crate) fn is_of(&self, fingerprint: u64, pattern: Pattern<'_>, hints: &Hints<'_>) -> bool {
        self.fingerprint == fingerprint && self.held == held(pattern, hints)
    }

    /// Numbers the nodes of all ranks, and prepares for matrices of the pattern.
    pub(crate) fn of(
        session: &Rc<Session>,
        (wire, owners): (&Rc<dyn Wire>, &dyn Owners),
        (pattern, hints): (Pattern<'_>, &Hints<'_>),
        fingerprint: u64,
    ) -> Result<Self, PetscError> {
        let places = hints.lattice.expect("patterns without places are refused");
        let block = pattern.block;
        let numbering = Numbering::of(&**wire, places.index, |it| owners.owner(it));
        if PetscInt::try_from(numbering.total * block).is_err() {
            let reason = format!("{} equations are too many for 32 bits", numbering.total * block);
            return Err(PetscError { call: "MatCreate", code: 0, reason });
        }
        let place = numbering.places_of_own(places.index.len());
        assert!(!place.contains(&usize::MAX), "an owner has all of its nodes");
        let owner_of: Vec<u32> = places.index.iter().map(|&it| owners.owner(it) as u32).collect();
        let (assembly, matrix) = Assembly::of((session, &**wire), block, (&numbering, &owner_of), |see| {
            for_each_pair(pattern, see)
        })?;
        let is_symmetric = pattern.is_symmetric();
        matrix.say(is_symmetric, is_symmetric)?;
        let (x, mut b) = matrix.vectors()?;
        if let Some(position) = hints.position {
            b.with(|numbers| {
                for (to, &place) in numbers.chunks_exact_mut(block).zip(&place) {
                    to.copy_from_slice(&position(place)[..block]);
                }
            })?;
            matrix.move_rigidly(&b, block)?;
            (b.with(|numbers| numbers.fill(0.0)))?;
        }
        let held = held(pattern, hints);
        let masks: Vec<u8> = place
            .iter()
            .map(|place| (0..block).fold(0, |mask, i| mask | u8::from(held[place * block + i]) << i))
            .collect();
        let mut iteration = Ksp::of(&matrix, None)?;
        // Whoever asks for PETSc's multigrid has its smoothers and products.
        let asked = session.option(c"-pc_type");
        let is_ours = asked.is_none() && block <= LARGEST_BLOCK;
        let coarser = match asked.as_deref() {
            None | Some("mg") => coarser_lattices(
                (session, &**wire, owners),
                places,
                (&numbering, &matrix),
                (&masks, block, is_symmetric),
                is_ours,
            )?,
            Some(_) => Vec::new(),
        };
        let is_small = coarser.is_empty() && numbering.total <= crate::lattices::COARSEST;
        let ours = is_ours.then_some(wire).filter(|_| !coarser.is_empty());
        configure(session, &mut iteration, (is_symmetric, block), (coarser, is_small), ours)?;
        let size = SystemSize::of(pattern, places).summed(|numbers| {
            let mut all = vec![0.0; numbers.len() * wire.size()];
            wire.gather(numbers, &mut all);
            all
        });
        Ok(Self {
            fingerprint,
            method: if is_symmetric { Method::ConjugateGradients } else { Method::Gmres },
            factor_entries: size.predict().factor_entries,
            wire: wire.clone(),
            spare: [b.alike()?, b.alike()?],
            assembly,
            numbering,
            place,
            block,
            held,
            matrix,
            x,
            b,
            iteration,
            factorisation: None,
        })
    }

    /// Takes the values of a matrix of the pattern.
    pub(crate) fn take_values(&mut self, matrix: Matrix<'_>) -> Result<(), PetscError> {
        self.assembly.take(&*self.wire, matrix, &self.matrix)
    }

    /// Takes a right-hand side, complete on every rank that has the node.
    pub(crate) fn take_rhs(&mut self, rhs: &[f64]) -> Result<(), PetscError> {
        let Self { place, block, b, .. } = self;
        b.with(|numbers| {
            for (to, &place) in numbers.chunks_exact_mut(*block).zip(&*place) {
                to.copy_from_slice(&rhs[place * *block..(place + 1) * *block]);
            }
        })
    }

    /// Hands out the solution, complete on every rank that has the node; held components are zero, which algebraic
    /// interpolation may have moved: they couple with nothing.
    pub(crate) fn give(&mut self, solution: &mut [f64]) -> Result<(), PetscError> {
        let Self { place, block, x, held, numbering, wire, .. } = self;
        x.with(|numbers| {
            for (from, &place) in numbers.chunks_exact_mut(*block).zip(&*place) {
                for (i, value) in from.iter_mut().enumerate().filter(|it| held[place * *block + it.0]) {
                    debug_assert!(i < *block);
                    *value = 0.0;
                }
            }
            let (numbers, block) = (&*numbers, *block);
            numbering.spread(
                &**wire,
                block,
                |k, i| numbers[k * block + i],
                |place, i, value| solution[place * block + i] = value,
            );
        })
    }

    /// Prepares the iteration for the values at hand, or keeps what is prepared. False where that failed.
    pub(crate) fn prepare_iteration(&mut self, keeps: bool) -> Result<bool, PetscError> {
        let is_symmetric = self.method == Method::ConjugateGradients;
        self.matrix.say(is_symmetric, is_symmetric)?;
        self.iteration.set_up(&self.matrix, keeps)
    }

    /// Iterates for the right-hand side at hand.
    pub(crate) fn iterate(&mut self, tolerance: f64) -> Result<Outcome, PetscError> {
        let Self { matrix, x, b, spare: [left, _], iteration, .. } = self;
        let ended = iteration.solve((b, x), tolerance, MOST_ITERATIONS)?;
        let size = b.size()?;
        let left = matrix.residual(b, x, left)?;
        let residual = if size > 0.0 { left / size } else { 0.0 };
        let is_solved = ended.reason > 0 && residual <= (MISSED * tolerance).max(GOOD_ENOUGH);
        Ok(Outcome { is_solved, iterations: ended.iterations, refinements: 0, residual })
    }

    /// Factorises the matrix at hand: numbers of negative, zero and positive pivots where it is symmetric; else whether memory
    /// was the reason.
    pub(crate) fn factorise(&mut self) -> Result<Result<Option<[usize; 3]>, bool>, PetscError> {
        let is_symmetric = self.method == Method::ConjugateGradients;
        // A definite matrix would be factorised without pivots that may be negative.
        self.matrix.say(is_symmetric, false)?;
        if self.factorisation.is_none() {
            let solver = Ksp::of(&self.matrix, Some(c"direct_"))?;
            solver.method(c"preonly")?;
            solver.precondition(if is_symmetric { c"cholesky" } else { c"lu" })?;
            solver.factorise_by(c"mumps")?;
            solver.read_options()?;
            self.factorisation = Some(solver);
        }
        let solver = self.factorisation.as_ref().expect("made above");
        if !solver.set_up(&self.matrix, false)? {
            return Ok(Err(solver.lacks_memory()?));
        }
        let inertia = is_symmetric.then(|| solver.inertia()).transpose()?;
        match inertia {
            Some([_, zero, _]) if zero > 0 => Ok(Err(false)),
            inertia => Ok(Ok(inertia)),
        }
    }

    /// Solves with the factors at hand, and refines where that is not accurate enough.
    pub(crate) fn substitute(&mut self, tolerance: f64) -> Result<Outcome, PetscError> {
        let Self { matrix, x, b, spare: [left, correction], factorisation, .. } = self;
        let solver = factorisation.as_ref().expect("factorised before");
        let wanted = tolerance.min(GOOD_ENOUGH);
        let size = b.size()?;
        let mut ended = solver.solve((b, x), wanted, 1)?;
        let mut residual = matrix.residual(b, x, left)?;
        let mut refinements = 0;
        while residual > wanted * size && refinements < REFINEMENTS && ended.reason > 0 {
            ended = solver.solve((left, correction), wanted, 1)?;
            x.add(correction)?;
            let before = std::mem::replace(&mut residual, matrix.residual(b, x, left)?);
            refinements += 1;
            if residual > 0.5 * before {
                break;
            }
        }
        let is_small = residual <= tolerance.max(GOOD_ENOUGH) * size;
        let is_rounding = || Ok(residual <= BACKWARD_ERROR * matrix.norm()? * x.size()?);
        let is_solved = ended.reason > 0 && (is_small || (residual <= MOST_LEFT * size && is_rounding()?));
        let residual = if size > 0.0 { residual / size } else { 0.0 };
        Ok(Outcome { is_solved, iterations: 0, refinements, residual })
    }
}

/// Chooses what the user's options do not, then reads them; with `ours` the cycle of this crate.
fn configure(
    session: &Session,
    iteration: &mut Ksp,
    (is_symmetric, block): (bool, usize),
    (coarser, is_small): (Vec<Coarser>, bool),
    ours: Option<&Rc<dyn Wire>>,
) -> Result<(), PetscError> {
    iteration.method(match (is_symmetric, ours.is_some()) {
        (true, _) => c"cg",
        // A cycle in single precision is no linear map: its results are kept, not found again from their sum.
        (false, true) => c"fgmres",
        (false, false) => c"gmres",
    })?;
    if session.option(c"-ksp_type").is_none_or(|it| it != "preonly") {
        iteration.look_at_residual((!is_symmetric).then_some(RESTART))?;
    }
    match (ours, coarser.is_empty(), is_small) {
        (Some(wire), ..) => iteration.precondition_by(cycle(wire, coarser, block)?)?,
        (None, false, _) => iteration.multigrid(coarser.iter().map(|it| &it.interpolation), is_symmetric)?,
        (None, true, true) => iteration.precondition(c"redundant")?,
        (None, true, false) => iteration.precondition(c"gamg")?,
    }
    iteration.read_options()
}

fn held(pattern: Pattern<'_>, hints: &Hints<'_>) -> Vec<bool> {
    let is_held = |equation| hints.is_held.is_some_and(|is_held| is_held(equation));
    (0..pattern.n_equations()).map(is_held).collect()
}
