//! PETSc's solvers, and preconditioners of our own that they call.

use crate::error::{PetscError, call};
use crate::ffi;
use crate::handles::{Field, Mat, int, world};
use crate::session::Session;
use std::cell::RefCell;
use std::ffi::CStr;
use std::ptr::null_mut;
use std::rc::Rc;

/// A preconditioner that PETSc's iterations call.
pub(crate) trait Precondition {
    /// Prepares for the values that a matrix has now. False where that failed on this rank.
    fn take(&mut self, finest: &Mat) -> Result<bool, PetscError>;

    /// `x ≈ A⁻¹ b`.
    fn apply(&mut self, b: &mut Field, x: &mut Field) -> Result<(), PetscError>;
}

/// A preconditioner of our own, for a solver that calls it.
pub(crate) struct Preconditioner {
    cell: RefCell<Box<dyn Precondition>>,
    session: Rc<Session>,
}

impl Preconditioner {
    /// A vector that PETSc lends.
    pub(crate) fn lent(&self, raw: ffi::Vec) -> Field {
        Field { raw, session: self.session.clone(), is_lent: true }
    }
}

/// A solver for one matrix.
pub(crate) struct Ksp {
    raw: ffi::KSP,
    /// Of our own, if it calls one. It lives at one place, which PETSc knows.
    preconditioner: Option<Rc<Preconditioner>>,
    session: Rc<Session>,
}

/// How a solution ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ended {
    pub(crate) iterations: u32,
    /// Above 0 where it converged.
    pub(crate) reason: i32,
}

impl Ksp {
    /// A solver whose options begin with `prefix`.
    pub(crate) fn of(matrix: &Mat, prefix: Option<&CStr>) -> Result<Self, PetscError> {
        let mut raw = null_mut();
        call!(KSPCreate(world(), &mut raw))?;
        let it = Self { raw, preconditioner: None, session: matrix.session.clone() };
        if let Some(prefix) = prefix {
            call!(KSPSetOptionsPrefix(raw, prefix.as_ptr()))?;
        }
        call!(KSPSetOperators(raw, matrix.raw, matrix.raw))?;
        Ok(it)
    }

    /// The method.
    pub(crate) fn method(&self, name: &CStr) -> Result<(), PetscError> {
        call!(KSPSetType(self.raw, name.as_ptr()))
    }

    /// Iterations look at `|b − A x|` itself; GMRES needs its preconditioner on the right for that.
    pub(crate) fn look_at_residual(&self, restart: Option<u32>) -> Result<(), PetscError> {
        if let Some(restart) = restart {
            call!(KSPSetPCSide(self.raw, ffi::PC_RIGHT))?;
            call!(KSPGMRESSetRestart(self.raw, restart as _))?;
        }
        call!(KSPSetNormType(self.raw, ffi::KSP_NORM_UNPRECONDITIONED))
    }

    fn pc(&self) -> Result<ffi::PC, PetscError> {
        let mut pc = null_mut();
        call!(KSPGetPC(self.raw, &mut pc))?;
        Ok(pc)
    }

    /// The preconditioner.
    pub(crate) fn precondition(&self, name: &CStr) -> Result<(), PetscError> {
        call!(PCSetType(self.pc()?, name.as_ptr()))
    }

    /// A preconditioner of our own.
    pub(crate) fn precondition_by(&mut self, by: Box<dyn Precondition>) -> Result<(), PetscError> {
        let (pc, session) = (self.pc()?, self.session.clone());
        let by = Rc::new(Preconditioner { cell: RefCell::new(by), session });
        call!(PCSetType(pc, c"shell".as_ptr()))?;
        // The context is given back after the solver that calls with it.
        call!(PCShellSetContext(pc, Rc::as_ptr(&by).cast_mut().cast()))?;
        call!(PCShellSetApply(pc, Some(apply)))?;
        call!(PCShellSetName(pc, c"lattices".as_ptr()))?;
        self.preconditioner = Some(by);
        Ok(())
    }

    /// `x ≈ A⁻¹ b` as often as the options say, once without any.
    pub(crate) fn apply(&self, b: &Field, x: &mut Field) -> Result<(), PetscError> {
        call!(KSPSolve(self.raw, b.raw, x.raw))
    }

    /// Who factorises.
    pub(crate) fn factorise_by(&self, name: &CStr) -> Result<(), PetscError> {
        call!(PCFactorSetMatSolverType(self.pc()?, name.as_ptr()))
    }

    /// Multigrid with these interpolations, the finest first, and coarse matrices `Pᵀ A P`.
    pub(crate) fn multigrid<'a>(
        &self,
        interpolations: impl ExactSizeIterator<Item = &'a Mat>,
        is_symmetric: bool,
    ) -> Result<(), PetscError> {
        let (pc, levels) = (self.pc()?, interpolations.len() + 1);
        call!(PCSetType(pc, c"mg".as_ptr()))?;
        call!(PCMGSetLevels(pc, int(levels), null_mut()))?;
        call!(PCMGSetGalerkin(pc, ffi::PC_MG_GALERKIN_BOTH))?;
        for (k, interpolation) in interpolations.enumerate() {
            let level = int(levels - 1 - k);
            call!(PCMGSetInterpolation(pc, level, interpolation.raw))?;
            if !is_symmetric {
                // Chebyshev polynomials are made for real eigenvalues.
                let mut smoother = null_mut();
                call!(PCMGGetSmoother(pc, level, &mut smoother))?;
                call!(KSPSetType(smoother, c"richardson".as_ptr()))?;
            }
        }
        Ok(())
    }

    /// Reads the user's options, after all that is set before.
    pub(crate) fn read_options(&self) -> Result<(), PetscError> {
        call!(KSPSetFromOptions(self.raw))
    }

    /// Prepares for the values that the matrix has now, or keeps what was prepared for earlier ones. False where that failed
    /// on this rank.
    pub(crate) fn set_up(&self, matrix: &Mat, keeps: bool) -> Result<bool, PetscError> {
        call!(KSPSetReusePreconditioner(self.raw, if keeps { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE }))?;
        call!(KSPSetOperators(self.raw, matrix.raw, matrix.raw))?;
        let own = self.preconditioner.as_ref().filter(|_| !keeps);
        let is_taken = own.map_or(Ok(true), |own| own.cell.borrow_mut().take(matrix))?;
        call!(KSPSetUp(self.raw))?;
        let mut failed = ffi::PC_NOERROR;
        call!(PCGetFailedReason(self.pc()?, &mut failed))?;
        Ok(is_taken && failed == ffi::PC_NOERROR)
    }

    /// Whether the factorisation lacked memory.
    pub(crate) fn lacks_memory(&self) -> Result<bool, PetscError> {
        let mut failed = ffi::PC_NOERROR;
        call!(PCGetFailedReason(self.pc()?, &mut failed))?;
        Ok(failed == ffi::PC_FACTOR_OUTMEMORY)
    }

    /// Numbers of negative, zero and positive pivots of the factor.
    pub(crate) fn inertia(&self) -> Result<[usize; 3], PetscError> {
        let mut factor = null_mut();
        call!(PCFactorGetMatrix(self.pc()?, &mut factor))?;
        let mut counts: [ffi::PetscInt; 3] = [0; 3];
        let [negative, zero, positive] = &mut counts;
        call!(MatGetInertia(factor, negative, zero, positive))?;
        Ok(counts.map(|it| it.max(0) as usize))
    }

    /// Solves `A x = b` up to `|b − A x| ≤ tolerance · |b|`.
    pub(crate) fn solve(
        &self,
        (b, x): (&Field, &mut Field),
        tolerance: f64,
        most: u32,
    ) -> Result<Ended, PetscError> {
        // The size of b is no part of when an iteration ends, however small; it diverges where the residual grows so much.
        const LEAST: f64 = 1e-300;
        const GROWN: f64 = 1e10;
        call!(KSPSetTolerances(self.raw, tolerance, LEAST, GROWN, most as _))?;
        call!(KSPSolve(self.raw, b.raw, x.raw))?;
        let (mut iterations, mut reason) = (0, ffi::KSP_CONVERGED_ITERATING);
        call!(KSPGetIterationNumber(self.raw, &mut iterations))?;
        call!(KSPGetConvergedReason(self.raw, &mut reason))?;
        Ok(Ended { iterations: iterations as u32, reason: reason as i32 })
    }
}

impl Drop for Ksp {
    fn drop(&mut self) {
        let _ = call!(KSPDestroy(&mut self.raw));
    }
}

/// What PETSc calls with the preconditioner in the context of `pc`: see [`Ksp::precondition_by`].
unsafe extern "C" fn apply(pc: ffi::PC, b: ffi::Vec, x: ffi::Vec) -> ffi::PetscErrorCode {
    let mut context: *mut Preconditioner = null_mut();
    if let Err(error) = call!(PCShellGetContext(pc, (&raw mut context).cast())) {
        return error.code as _;
    }
    // SAFETY: the context is the cell that lives as long as its solver; nobody has borrowed it while PETSc iterates.
    let preconditioner = unsafe { &*context };
    let (mut b, mut x) = (preconditioner.lent(b), preconditioner.lent(x));
    let done = preconditioner.cell.borrow_mut().apply(&mut b, &mut x);
    done.map_or_else(|error| error.code as _, |()| 0 as _)
}
