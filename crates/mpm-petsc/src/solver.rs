//! The linear solver of ranks that share a system.

use crate::error::PetscError;
use crate::ffi::PetscInt;
use crate::owners::Owners;
use crate::session::Session;
use crate::system::{Outcome, System};
use mpm_cluster::Wire;
use mpm_linear::{
    Analysis, Cause, Choice, Factored, Hints, Inertia, LinearSolver, Matrix, Method, OutOfMemory, Pattern,
    Singular, Solved,
};
use std::rc::Rc;

/// Name of the factorisation.
const FACTORISED: Method = Method::Other("MUMPS");

/// Entries of a factor for which an iteration that fails is helped by a factorisation: 8 GB on each rank.
const MOST_ENTRIES_AS_HELP: f64 = 1e9;

/// Coarse matrices are renewed when a solution took more than this times the iterations of the first with them.
const SLOWER: f64 = 1.3;

/// Linear systems of all ranks by PETSc: conjugate gradients, or GMRES where the matrix is not symmetric, with multigrid on the
/// lattice; what they do not solve is factorised by MUMPS, if the factor is small enough. The user's options choose otherwise
/// (`-pc_type gamg`, `-pc_type hypre`, …); those of the factorisation begin with `-direct_`.
///
/// Every rank hands over the matrix that it has summed: K is the sum over the ranks. Right-hand sides are complete on every
/// rank that has a node, and so are solutions. All ranks call the same methods in the same order.
pub struct Petsc {
    session: Rc<Session>,
    wire: Rc<dyn Wire>,
    owners: Rc<dyn Owners>,
    choice: Choice,
    system: Option<System>,
    /// Why no system can be solved, where that is so.
    refused: Option<Cause>,
    /// Whether another rank says why no system can be solved.
    is_refused_elsewhere: bool,
    /// Whether the matrix at hand is factorised.
    is_factorised: bool,
    /// Whether a matrix has been left to the factorisation since the last restart; the next ones then are, too.
    has_given_up: bool,
    coarse: Coarse,
}

/// What the coarse matrices at hand are of, as in `mpm-linear`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Coarse {
    Old,
    /// Iterations for each factor of e that the first solution with them has taken off its residual.
    Kept {
        is_of_this: bool,
        first: Option<f64>,
    },
}

impl Coarse {
    fn after(self, iterations: u32, residual: f64) -> Self {
        let Self::Kept { is_of_this, first } = self else { return self };
        let taken_off = -residual.ln();
        if !(taken_off > 0.0 && taken_off.is_finite()) {
            return self;
        }
        let iterations = f64::from(iterations);
        match first {
            Some(first) if iterations > (SLOWER * first * taken_off).max(first * taken_off + 1.0) => Self::Old,
            Some(_) => self,
            None => Self::Kept { is_of_this, first: Some(iterations / taken_off) },
        }
    }
}

impl Petsc {
    /// A solver that has not seen a pattern yet.
    pub fn new(session: Rc<Session>, wire: Rc<dyn Wire>, owners: Rc<dyn Owners>, choice: Choice) -> Self {
        Self {
            session,
            wire,
            owners,
            choice,
            system: None,
            refused: None,
            is_refused_elsewhere: false,
            is_factorised: false,
            has_given_up: false,
            coarse: Coarse::Old,
        }
    }

    /// Whether it is so on any rank.
    fn any(&self, here: bool) -> bool {
        let mut all = vec![0.0; self.wire.size()];
        self.wire.gather(&[f64::from(u8::from(here))], &mut all);
        all.iter().any(|it| *it > 0.0)
    }

    fn system(&mut self) -> &mut System {
        self.system.as_mut().expect("a pattern is analysed before its matrices")
    }

    fn refuse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Option<Cause> {
        let lacks_places = hints.lattice.is_none_or(|it| it.index.len() != pattern.blocks);
        let reason = if self.any(!pattern.has_whole_blocks()) {
            "PETSc is given displacements of nodes only"
        } else if self.any(lacks_places) {
            "on several ranks nodes must stand on a lattice"
        } else if self.any(PetscInt::try_from(2 * pattern.n_entries()).is_err()) {
            "a rank has 2³⁰ entries of the matrix or more; take more ranks"
        } else {
            return None;
        };
        Some(Cause::Unsuitable(reason))
    }

    fn is_direct(&self) -> bool {
        self.choice == Choice::Direct
    }

    /// Factorises the matrix at hand because the iteration cannot solve it.
    fn help(&mut self) -> Result<Factored, Singular> {
        self.has_given_up = true;
        let entries = self.system().factor_entries;
        if !self.is_direct() && entries > MOST_ENTRIES_AS_HELP * self.wire.size() as f64 {
            return Err(singular(Cause::TooLargeToFactorise { entries }));
        }
        let factored = self.system().factorise().map_err(failed)?;
        let inertia = factored.map_err(|lacks_memory| {
            let cause = if lacks_memory { Cause::NoMemory { entries } } else { Cause::NoPivot };
            singular(cause)
        })?;
        self.is_factorised = true;
        let inertia = inertia.map(|[negative, _, positive]| Inertia { positive, negative });
        Ok(Factored { inertia, ..Factored::by(FACTORISED) })
    }

    /// Prepares the iteration for the matrix at hand, with coarse matrices of its own or those that are kept.
    fn take(&mut self) -> Result<bool, PetscError> {
        let keeps = matches!(self.coarse, Coarse::Kept { .. });
        let is_ready = self.system().prepare_iteration(keeps)?;
        let is_ready = !self.any(!is_ready);
        self.coarse = match self.coarse {
            _ if !is_ready => Coarse::Old,
            Coarse::Kept { first, .. } => Coarse::Kept { is_of_this: false, first },
            Coarse::Old => Coarse::Kept { is_of_this: true, first: None },
        };
        Ok(is_ready)
    }

    /// Iterates; where kept coarse matrices do not serve, once more with new ones.
    fn iterate(&mut self, tolerance: f64) -> Result<Outcome, PetscError> {
        let mut outcome = self.system().iterate(tolerance)?;
        if !outcome.is_solved && matches!(self.coarse, Coarse::Kept { is_of_this: false, .. }) {
            self.coarse = Coarse::Old;
            if self.take()? {
                let again = self.system().iterate(tolerance)?;
                outcome = Outcome { iterations: outcome.iterations + again.iterations, ..again };
            }
        }
        self.coarse = if outcome.is_solved {
            self.coarse.after(outcome.iterations, outcome.residual)
        } else {
            Coarse::Old
        };
        Ok(outcome)
    }
}

impl LinearSolver for Petsc {
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        self.is_factorised = false;
        self.restart();
        self.refused = self.refuse(pattern, hints);
        self.is_refused_elsewhere = false;
        if self.refused.is_some() {
            self.system = None;
            return Ok(Analysis::New);
        }
        let fingerprint = System::fingerprint(pattern, hints, &*self.owners);
        let is_new = self.system.as_ref().is_none_or(|it| !it.is_of(fingerprint, pattern, hints));
        if !self.any(is_new) {
            return Ok(Analysis::Reused);
        }
        // The memory of the former system is free before the next one is made.
        self.system = None;
        let made = System::of(&self.session, (&self.wire, &*self.owners), (pattern, hints), fingerprint);
        let has_failed = self.any(made.is_err());
        match made {
            Ok(system) if !has_failed => self.system = Some(system),
            Ok(_) => self.is_refused_elsewhere = true,
            Err(error) if error.is_memory() => {
                return Err(OutOfMemory { equations: pattern.n_equations(), factor_entries: 0 });
            }
            Err(error) => self.refused = Some(unsuitable(&error)),
        }
        Ok(Analysis::New)
    }

    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        if let Some(cause) = self.refused {
            return Err(singular(cause));
        }
        if self.is_refused_elsewhere {
            return Ok(Factored::by(self.first_method()));
        }
        self.is_factorised = false;
        let infinite = matrix.first_not_finite();
        if self.any(infinite.is_some()) {
            // The ranks that have none hear of it.
            let Some(equation) = infinite else { return Ok(Factored::by(self.first_method())) };
            return Err(Singular { equation, ..singular(Cause::MatrixNotFinite) });
        }
        self.system().take_values(matrix).map_err(failed)?;
        if self.is_direct() || self.has_given_up {
            return self.help();
        }
        if self.take().map_err(failed)? {
            return Ok(Factored::by(self.system().method));
        }
        self.help()
    }

    fn solve(&mut self, _: Matrix<'_>, rhs: &mut [f64], tolerance: f64) -> Result<Solved, Singular> {
        let infinite = rhs.iter().position(|it| !it.is_finite());
        if self.any(infinite.is_some()) {
            let nothing = Outcome { is_solved: false, iterations: 0, refinements: 0, residual: f64::NAN };
            let Some(equation) = infinite else { return Ok(solved(self.first_method(), &nothing, None)) };
            return Err(Singular { equation, ..singular(Cause::RightHandSideNotFinite) });
        }
        self.system().take_rhs(rhs).map_err(failed)?;
        let (mut iterations, mut taken_over) = (0, None);
        if !self.is_factorised {
            let outcome = self.iterate(tolerance).map_err(failed)?;
            if outcome.is_solved {
                let system = self.system();
                system.give(rhs).map_err(failed)?;
                return Ok(solved(system.method, &outcome, None));
            }
            iterations = outcome.iterations;
            taken_over = Some(self.help()?);
        }
        let outcome = self.system().substitute(tolerance).map_err(failed)?;
        if !outcome.is_solved {
            return Err(singular(Cause::Inaccurate { backward_error: outcome.residual }));
        }
        self.system().give(rhs).map_err(failed)?;
        Ok(solved(FACTORISED, &Outcome { iterations, ..outcome }, taken_over))
    }

    fn first_method(&self) -> Method {
        match &self.system {
            Some(system) if !self.is_direct() => system.method,
            None if !self.is_direct() => Method::ConjugateGradients,
            _ => FACTORISED,
        }
    }

    fn restart(&mut self) {
        self.has_given_up = false;
        self.coarse = Coarse::Old;
    }
}

fn solved(method: Method, outcome: &Outcome, taken_over: Option<Factored>) -> Solved {
    Solved {
        method,
        backward_error: None,
        residual: Some(outcome.residual),
        refinements: outcome.refinements,
        iterations: outcome.iterations,
        taken_over,
    }
}

fn singular(cause: Cause) -> Singular {
    Singular { equation: 0, pivot: None, cause }
}

fn failed(error: PetscError) -> Singular {
    if error.is_memory() {
        return singular(Cause::NoMemory { entries: f64::NAN });
    }
    singular(unsuitable(&error))
}

/// An error that ends the run: its text lives as long as the program.
fn unsuitable(error: &PetscError) -> Cause {
    Cause::Unsuitable(Box::leak(error.to_string().into_boxed_str()))
}
