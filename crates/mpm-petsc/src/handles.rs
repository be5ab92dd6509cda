//! PETSc's objects, which are given back when dropped. Each holds the [`Session`], which ends after them.

use crate::error::{PetscError, call};
use crate::ffi;
use crate::rows::{Parts, Rows};
use crate::session::Session;
use std::ptr::{null, null_mut};
use std::rc::Rc;

/// A number of rows or columns as PETSc counts them.
pub(crate) fn int(n: usize) -> ffi::PetscInt {
    ffi::PetscInt::try_from(n).expect("sizes are checked before they are handed over")
}

/// All ranks.
pub(crate) fn world() -> ffi::MPI_Comm {
    // SAFETY: PETSc sets it at its start, and nothing afterwards.
    unsafe { ffi::PETSC_COMM_WORLD }
}

/// A sparse matrix whose rows are parted among the ranks.
pub(crate) struct Mat {
    pub(crate) raw: ffi::Mat,
    pub(crate) session: Rc<Session>,
    /// Lists that PETSc uses, given back after the matrix.
    _arrays: Option<[Arrays; 2]>,
}

/// Where the entries of every row begin, their columns, and their values.
#[derive(Default)]
pub(crate) struct Arrays {
    pub(crate) start: Vec<ffi::PetscInt>,
    pub(crate) column: Vec<ffi::PetscInt>,
    pub(crate) value: Vec<f64>,
}

impl Arrays {
    fn pointers(&mut self) -> (*mut ffi::PetscInt, *mut ffi::PetscInt, *mut f64) {
        (self.start.as_mut_ptr(), self.column.as_mut_ptr(), self.value.as_mut_ptr())
    }
}

impl Mat {
    /// A square matrix of `own` rows on this rank in blocks of nodes, with these entries of own columns and of others'.
    pub(crate) fn of_arrays(
        session: &Rc<Session>,
        (own, block): (usize, usize),
        mut arrays: [Arrays; 2],
    ) -> Result<Self, PetscError> {
        let (mut raw, n, whole) = (null_mut(), int(own), ffi::PETSC_DETERMINE);
        let [here, there] = &mut arrays;
        let (start, column, value) = here.pointers();
        // PETSc takes the lists as they are, and reads and writes them until the matrix is destroyed; nothing else does, and they
        // are given back afterwards.
        if session.size() == 1 {
            call!(MatCreateSeqAIJWithArrays(world(), n, n, start, column, value, &mut raw))?;
        } else {
            let others = there.pointers();
            call!(MatCreateMPIAIJWithSplitArrays(
                world(),
                n,
                n,
                whole,
                whole,
                start,
                column,
                value,
                others.0,
                others.1,
                others.2,
                &mut raw
            ))?;
        }
        let it = Self { raw, session: session.clone(), _arrays: Some(arrays) };
        call!(MatSetBlockSize(raw, int(block)))?;
        Ok(it)
    }

    /// Lets `see` change the values of own columns and of others' in own rows.
    pub(crate) fn with_values(&self, see: impl FnOnce(&mut [f64], &mut [f64])) -> Result<(), PetscError> {
        let (mut own, mut others, mut names) = (self.raw, null_mut(), null());
        if self.session.size() == 1 {
            return with_values(own, |own| see(own, &mut []));
        }
        call!(MatMPIAIJGetSeqAIJ(self.raw, &mut own, &mut others, &mut names))?;
        let mut outcome = Ok(());
        with_values(own, |own| outcome = with_values(others, |others| see(own, others)))?;
        outcome?;
        // Whoever keeps what was prepared for a matrix sees that its values are others.
        self.assemble()
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
        let it = Self { raw, session: session.clone(), _arrays: None };
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
        Ok((
            Field { raw: x, session: session.clone(), is_lent: false },
            Field { raw: b, session: session.clone(), is_lent: false },
        ))
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

    /// Shows the entries of own rows.
    pub(crate) fn with_parts(&self, see: impl FnOnce(Parts<'_>)) -> Result<(), PetscError> {
        let (mut own, mut others, mut names) = (self.raw, null_mut(), null());
        if self.session.size() > 1 {
            call!(MatMPIAIJGetSeqAIJ(self.raw, &mut own, &mut others, &mut names))?;
        }
        let mut outcome = Ok(());
        with_rows(own, |own| {
            if others.is_null() {
                see(Parts { own, others: None });
            } else {
                outcome = with_rows(others, |others| see(Parts { own, others: Some(others) }));
            }
        })?;
        outcome
    }

    /// Who tells the numbers of other ranks that own rows are coupled with; none on one rank.
    pub(crate) fn others(&self) -> Result<Option<Others>, PetscError> {
        if self.session.size() == 1 {
            return Ok(None);
        }
        let (mut own, mut others, mut names) = (null_mut(), null_mut(), null());
        call!(MatMPIAIJGetSeqAIJ(self.raw, &mut own, &mut others, &mut names))?;
        let (mut rows, mut n) = (0, 0);
        call!(MatGetSize(others, &mut rows, &mut n))?;
        let (mut theirs, mut places, mut scatter) = (null_mut(), null_mut(), null_mut());
        // The communicator of this rank alone.
        let mut alone = world();
        call!(PetscObjectGetComm(others.cast(), &mut alone))?;
        call!(VecCreateSeq(alone, n, &mut theirs))?;
        let theirs = Field { raw: theirs, session: self.session.clone(), is_lent: false };
        // As many numbers of columns as there are of other ranks; they are copied.
        call!(ISCreateGeneral(alone, n, names, ffi::PETSC_COPY_VALUES, &mut places))?;
        let (all, _) = self.vectors()?;
        let made = call!(VecScatterCreate(all.raw, places, theirs.raw, null_mut(), &mut scatter));
        call!(ISDestroy(&mut places))?;
        made?;
        Ok(Some(Others { theirs, scatter }))
    }

    /// `out = A x`.
    pub(crate) fn times(&self, x: &Field, out: &mut Field) -> Result<(), PetscError> {
        call!(MatMult(self.raw, x.raw, out.raw))
    }

    /// `out = Aᵀ x`.
    pub(crate) fn transposed_times(&self, x: &Field, out: &mut Field) -> Result<(), PetscError> {
        call!(MatMultTranspose(self.raw, x.raw, out.raw))
    }

    /// `out = b − A x`, and its size.
    pub(crate) fn residual(&self, b: &Field, x: &Field, out: &mut Field) -> Result<f64, PetscError> {
        call!(MatMult(self.raw, x.raw, out.raw))?;
        call!(VecAYPX(out.raw, -1.0, b.raw))?;
        out.size()
    }

    /// The largest sum of sizes in a row.
    pub(crate) fn norm(&self) -> Result<f64, PetscError> {
        let mut norm = 0.0;
        call!(MatNorm(self.raw, ffi::NORM_INFINITY, &mut norm))?;
        Ok(norm)
    }
}

impl Drop for Mat {
    fn drop(&mut self) {
        let _ = call!(MatDestroy(&mut self.raw));
    }
}

/// Shows the rows of a matrix of one rank.
fn with_rows(raw: ffi::Mat, see: impl FnOnce(Rows<'_>)) -> Result<(), PetscError> {
    let (mut n, mut start, mut column, mut is_done) = (0, null(), null(), ffi::PETSC_FALSE);
    let (no, mut value) = (ffi::PETSC_FALSE, null());
    call!(MatGetRowIJ(raw, 0, no, no, &mut n, &mut start, &mut column, &mut is_done))?;
    call!(MatSeqAIJGetArrayRead(raw, &mut value))?;
    let rows = n as usize;
    if is_done == ffi::PETSC_TRUE && rows > 0 {
        // SAFETY: PETSc's lists, which stay as they are until they are handed back: a beginning for each row and the end, and as
        // many columns and values as that says.
        let (start, column, value) = unsafe {
            let start = std::slice::from_raw_parts(start, rows + 1);
            let entries = start[rows] as usize;
            let of = |n: usize| {
                if n == 0 {
                    (&[][..], &[][..])
                } else {
                    (std::slice::from_raw_parts(column, n), std::slice::from_raw_parts(value, n))
                }
            };
            let (column, value) = of(entries);
            (start, column, value)
        };
        see(Rows { start, column, value });
    } else {
        see(Rows { start: &[0], column: &[], value: &[] });
    }
    call!(MatSeqAIJRestoreArrayRead(raw, &mut value))?;
    call!(MatRestoreRowIJ(raw, 0, no, no, &mut n, &mut start, &mut column, &mut is_done))
}

/// Lets `see` change the values of a matrix of one rank.
fn with_values(raw: ffi::Mat, see: impl FnOnce(&mut [f64])) -> Result<(), PetscError> {
    let (mut n, mut start, mut column, mut is_done) = (0, null(), null(), ffi::PETSC_FALSE);
    let (no, mut value) = (ffi::PETSC_FALSE, null_mut());
    call!(MatGetRowIJ(raw, 0, no, no, &mut n, &mut start, &mut column, &mut is_done))?;
    call!(MatSeqAIJGetArray(raw, &mut value))?;
    // SAFETY: PETSc's lists: a beginning for each row and the end, and as many values as that says, which nobody else uses until
    // they are handed back.
    let entries = if n > 0 { unsafe { *start.add(n as usize) as usize } } else { 0 };
    if entries > 0 {
        see(unsafe { std::slice::from_raw_parts_mut(value, entries) });
    } else {
        see(&mut []);
    }
    call!(MatSeqAIJRestoreArray(raw, &mut value))?;
    call!(MatRestoreRowIJ(raw, 0, no, no, &mut n, &mut start, &mut column, &mut is_done))
}

/// Who tells the numbers of other ranks that the rows of a matrix are coupled with.
pub(crate) struct Others {
    theirs: Field,
    scatter: ffi::VecScatter,
}

impl Drop for Others {
    fn drop(&mut self) {
        let _ = call!(VecScatterDestroy(&mut self.scatter));
    }
}

impl Others {
    /// Tells what other ranks have in a vector.
    pub(crate) fn hear(&mut self, x: &Field, see: impl FnOnce(&[f64])) -> Result<(), PetscError> {
        let (scatter, theirs) = (self.scatter, self.theirs.raw);
        let (insert, forward) = (ffi::INSERT_VALUES, ffi::SCATTER_FORWARD);
        call!(VecScatterBegin(scatter, x.raw, theirs, insert, forward))?;
        call!(VecScatterEnd(scatter, x.raw, theirs, insert, forward))?;
        self.theirs.with(|theirs| see(theirs))
    }
}

/// A vector that is parted as the rows of a matrix.
pub(crate) struct Field {
    pub(crate) raw: ffi::Vec,
    pub(crate) session: Rc<Session>,
    /// Whether somebody else gives it back.
    pub(crate) is_lent: bool,
}

impl Field {
    /// Another one of the same length.
    pub(crate) fn alike(&self) -> Result<Self, PetscError> {
        let mut raw = null_mut();
        call!(VecDuplicate(self.raw, &mut raw))?;
        Ok(Self { raw, session: self.session.clone(), is_lent: false })
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
        if !self.is_lent {
            let _ = call!(VecDestroy(&mut self.raw));
        }
    }
}
