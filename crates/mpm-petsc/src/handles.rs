//! PETSc's objects, which are given back when dropped. Each holds the [`Session`], which ends after them.

use crate::error::{PetscError, call};
use crate::ffi;
use crate::session::Session;
use std::ffi::CStr;
use std::ptr::null_mut;
use std::rc::Rc;

/// A number of rows or columns as PETSc counts them.
pub(crate) fn int(n: usize) -> ffi::PetscInt {
    ffi::PetscInt::try_from(n).expect("sizes are checked before they are handed over")
}

/// All ranks.
fn world() -> ffi::MPI_Comm {
    // SAFETY: PETSc sets it at its start, and nothing afterwards.
    unsafe { ffi::PETSC_COMM_WORLD }
}

/// A sparse matrix whose rows are parted among the ranks.
pub(crate) struct Mat {
    raw: ffi::Mat,
    session: Rc<Session>,
}

impl Mat {
    /// A square matrix of `own` rows on this rank; this rank adds entries at `row[k]`, `column[k]` (numbers among all rows), whoever
    /// owns them. Values come by [`Self::set`].
    pub(crate) fn of_entries(
        session: &Rc<Session>,
        (own, block): (usize, usize),
        row: &mut [ffi::PetscInt],
        column: &mut [ffi::PetscInt],
    ) -> Result<Self, PetscError> {
        assert_eq!(row.len(), column.len());
        let mut raw = null_mut();
        call!(MatCreate(world(), &mut raw))?;
        let it = Self { raw, session: session.clone() };
        call!(MatSetSizes(raw, int(own), int(own), ffi::PETSC_DETERMINE, ffi::PETSC_DETERMINE))?;
        call!(MatSetBlockSize(raw, int(block)))?;
        call!(MatSetType(raw, c"aij".as_ptr()))?;
        call!(MatSetFromOptions(raw))?;
        // As many numbers in both lists as are said; PETSc may change them.
        call!(MatSetPreallocationCOO(raw, row.len() as _, row.as_mut_ptr(), column.as_mut_ptr()))?;
        Ok(it)
    }

    /// An empty matrix with so many own rows and columns, and at most `per_row` entries in a row.
    pub(crate) fn rectangular(
        session: &Rc<Session>,
        [rows, columns]: [usize; 2],
        per_row: usize,
        block: usize,
    ) -> Result<Self, PetscError> {
        let (mut raw, whole, most) = (null_mut(), ffi::PETSC_DETERMINE, int(per_row));
        let sizes = (int(rows), int(columns));
        // No lists of entries row by row: null pointers.
        call!(MatCreateAIJ(
            world(),
            sizes.0,
            sizes.1,
            whole,
            whole,
            most,
            null_mut(),
            most,
            null_mut(),
            &mut raw
        ))?;
        let it = Self { raw, session: session.clone() };
        call!(MatSetBlockSizes(raw, int(block), int(block)))?;
        Ok(it)
    }

    /// Sets one entry of an own row.
    pub(crate) fn put(&self, row: usize, column: usize, value: f64) -> Result<(), PetscError> {
        let (row, column) = (int(row), int(column));
        // One row, one column, one value.
        call!(MatSetValues(self.raw, 1, &row, 1, &column, &value, ffi::INSERT_VALUES))
    }

    /// Ends the entries by [`Self::put`].
    pub(crate) fn assemble(&self) -> Result<(), PetscError> {
        call!(MatAssemblyBegin(self.raw, ffi::MAT_FINAL_ASSEMBLY))?;
        call!(MatAssemblyEnd(self.raw, ffi::MAT_FINAL_ASSEMBLY))
    }

    /// Takes the values of the entries that were told at the start; those at one place are added.
    pub(crate) fn set(&self, values: &[f64]) -> Result<(), PetscError> {
        // As many values as entries.
        call!(MatSetValuesCOO(self.raw, values.as_ptr(), ffi::INSERT_VALUES))
    }

    /// Says whether it is symmetric, and whether positive definite.
    pub(crate) fn say(&self, is_symmetric: bool, is_definite: bool) -> Result<(), PetscError> {
        let flag = |is: bool| if is { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE };
        // A matrix that is said to be definite counts as symmetric: what follows takes nothing of it back.
        call!(MatSetOption(self.raw, ffi::MAT_SPD, flag(is_definite)))?;
        call!(MatSetOption(self.raw, ffi::MAT_SYMMETRIC, flag(is_symmetric)))
    }

    /// Vectors that fit it, x and b.
    pub(crate) fn vectors(&self) -> Result<(Field, Field), PetscError> {
        let (mut x, mut b) = (null_mut(), null_mut());
        call!(MatCreateVecs(self.raw, &mut x, &mut b))?;
        let session = &self.session;
        Ok((Field { raw: x, session: session.clone() }, Field { raw: b, session: session.clone() }))
    }

    /// Rigid motions of nodes at these positions, one after the other, as what coarse spaces must hold.
    pub(crate) fn move_rigidly(&self, positions: &Field, block: usize) -> Result<(), PetscError> {
        let mut space = null_mut();
        call!(VecSetBlockSize(positions.raw, int(block)))?;
        call!(MatNullSpaceCreateRigidBody(positions.raw, &mut space))?;
        let set = call!(MatSetNearNullSpace(self.raw, space));
        call!(MatNullSpaceDestroy(&mut space))?;
        set
    }

    /// `out = b − A x`, and its size.
    pub(crate) fn residual(&self, b: &Field, x: &Field, out: &mut Field) -> Result<f64, PetscError> {
        call!(MatMult(self.raw, x.raw, out.raw))?;
        call!(VecAYPX(out.raw, -1.0, b.raw))?;
        out.size()
    }
}

impl Drop for Mat {
    fn drop(&mut self) {
        let _ = call!(MatDestroy(&mut self.raw));
    }
}

/// A vector that is parted as the rows of a matrix.
pub(crate) struct Field {
    raw: ffi::Vec,
    session: Rc<Session>,
}

impl Field {
    /// Another one of the same length.
    pub(crate) fn alike(&self) -> Result<Self, PetscError> {
        let mut raw = null_mut();
        call!(VecDuplicate(self.raw, &mut raw))?;
        Ok(Self { raw, session: self.session.clone() })
    }

    /// Lets `see` read and write the numbers of this rank.
    pub(crate) fn with(&mut self, see: impl FnOnce(&mut [f64])) -> Result<(), PetscError> {
        let (mut array, mut length) = (null_mut(), 0);
        call!(VecGetLocalSize(self.raw, &mut length))?;
        call!(VecGetArray(self.raw, &mut array))?;
        if length > 0 {
            // SAFETY: PETSc's array of so many numbers, which nobody else uses until it is handed back.
            see(unsafe { std::slice::from_raw_parts_mut(array, length as usize) });
        } else {
            see(&mut []);
        }
        call!(VecRestoreArray(self.raw, &mut array))
    }

    /// Euclidean norm.
    pub(crate) fn size(&self) -> Result<f64, PetscError> {
        let mut size = 0.0;
        call!(VecNorm(self.raw, ffi::NORM_2, &mut size))?;
        Ok(size)
    }

    /// Adds another one.
    pub(crate) fn add(&mut self, other: &Field) -> Result<(), PetscError> {
        call!(VecAXPY(self.raw, 1.0, other.raw))
    }
}

impl Drop for Field {
    fn drop(&mut self) {
        let _ = call!(VecDestroy(&mut self.raw));
    }
}

/// A solver for one matrix.
pub(crate) struct Ksp {
    raw: ffi::KSP,
    _session: Rc<Session>,
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
        let it = Self { raw, _session: matrix.session.clone() };
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

    /// Who factorises.
    pub(crate) fn factorise_by(&self, name: &CStr) -> Result<(), PetscError> {
        call!(PCFactorSetMatSolverType(self.pc()?, name.as_ptr()))
    }

    /// Multigrid with these interpolations, the finest first, and coarse matrices `Pᵀ A P`.
    pub(crate) fn multigrid(&self, interpolations: &[Mat], is_symmetric: bool) -> Result<(), PetscError> {
        let (pc, levels) = (self.pc()?, interpolations.len() + 1);
        call!(PCSetType(pc, c"mg".as_ptr()))?;
        call!(PCMGSetLevels(pc, int(levels), null_mut()))?;
        call!(PCMGSetGalerkin(pc, ffi::PC_MG_GALERKIN_BOTH))?;
        for (k, interpolation) in interpolations.iter().enumerate() {
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

    /// Prepares for the values that the matrix has now, or keeps what was prepared for earlier ones. False where that failed.
    pub(crate) fn set_up(&self, matrix: &Mat, keeps: bool) -> Result<bool, PetscError> {
        call!(KSPSetReusePreconditioner(self.raw, if keeps { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE }))?;
        call!(KSPSetOperators(self.raw, matrix.raw, matrix.raw))?;
        call!(KSPSetUp(self.raw))?;
        let mut failed = ffi::PC_NOERROR;
        call!(PCGetFailedReason(self.pc()?, &mut failed))?;
        Ok(failed == ffi::PC_NOERROR)
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
