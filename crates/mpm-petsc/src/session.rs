//! MPI and PETSc, from the start of a program to its end.

use crate::error::{PetscError, call};
use crate::ffi;
use mpi::environment::Universe;
use mpi::topology::{Communicator, SimpleCommunicator};
use std::ffi::{CStr, CString, c_char};
use std::ptr::{null, null_mut};
use std::rc::Rc;

/// Options that hold unless the user's say otherwise.
///
/// Signals are the program's. The factorisation counts the signs of its pivots only where the last front is not parallel, and 20 % more room
/// than predicted is too little for the pivots of indefinite matrices. Small pivots are not taken for zeros: bodies that barely reach a node make such,
/// and what was lost shows in the residual.
const DEFAULTS: [(&CStr, &CStr); 5] = [
    (c"-no_signal_handler", c"true"),
    (c"-direct_mat_mumps_icntl_13", c"1"),
    (c"-direct_mat_mumps_icntl_14", c"50"),
    (c"-direct_mat_mumps_icntl_24", c"1"),
    (c"-direct_mat_mumps_cntl_3", c"1e-30"),
];

/// The same on three ranks and more, for PETSc's own multigrid: its Galerkin products add what comes from other ranks in a fixed order
/// only in this variant, which matrices of one rank do not have.
const OF_SEVERAL: [(&CStr, &CStr); 2] =
    [(c"-matptap_via", c"allatonce"), (c"-mat_product_algorithm", c"allatonce")];

/// The same on two ranks, where what comes has one order: a third of the time.
const OF_TWO: [(&CStr, &CStr); 2] =
    [(c"-matptap_via", c"nonscalable"), (c"-mat_product_algorithm", c"nonscalable")];

/// MPI and PETSc between their start and their end. Everything of this crate is used on the thread that started it.
pub struct Session {
    // Dropped after PETSc has ended.
    universe: Universe,
}

impl Session {
    /// Starts MPI and PETSc, once in the life of a process, with options of PETSc as `-ksp_rtol`, `1e-6`.
    ///
    /// # Errors
    /// What MPI or PETSc does not do.
    pub fn start(options: &[String]) -> Result<Rc<Self>, PetscError> {
        let (universe, _) = mpi::initialize_with_threading(mpi::Threading::Funneled).ok_or(PetscError {
            call: "MPI_Init_thread",
            code: 0,
            reason: "MPI was started before".into(),
        })?;
        let of_several = match universe.world().size() {
            1 => &[][..],
            2 => &OF_TWO,
            _ => &OF_SEVERAL,
        };
        for (name, value) in DEFAULTS.iter().chain(of_several) {
            // SAFETY: texts that end in NUL; this function may be called before the others.
            call!(PetscOptionsSetValue(null_mut(), name.as_ptr(), value.as_ptr()))?;
        }
        let texts = ["mpm-mpi"].into_iter().chain(options.iter().map(String::as_str));
        let texts: Vec<CString> =
            texts.map(|it| CString::new(it).expect("arguments of a program have no NUL")).collect();
        let mut list: Vec<*mut c_char> =
            texts.iter().map(|it| it.as_ptr().cast_mut()).chain([null_mut()]).collect();
        let (mut count, mut values) = (texts.len() as i32, list.as_mut_ptr());
        // SAFETY: `count` texts and a null pointer behind them, as `main` in C has them; PETSc copies what it keeps.
        call!(PetscInitialize(&mut count, &mut values, null(), null()))?;
        // Errors come back as codes, without PETSc's own report of where they were.
        // SAFETY: a handler of PETSc itself, which asks for no context.
        call!(PetscPushErrorHandler(Some(ffi::PetscReturnErrorHandler), null_mut()))?;
        Ok(Rc::new(Self { universe }))
    }

    /// Number of this rank.
    pub fn rank(&self) -> usize {
        self.universe.world().rank() as usize
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        self.universe.world().size() as usize
    }

    /// A communicator of all ranks, for one use.
    pub(crate) fn communicator(&self) -> SimpleCommunicator {
        self.universe.world().duplicate()
    }

    /// Ends all ranks at once, without any of them taking part. Returns where MPI does not run.
    pub fn abort(code: i32) {
        // SAFETY: MPI may be asked at any time whether it has been started and ended.
        let is_on = unsafe {
            let (mut started, mut ended) = (0, 0);
            mpi::ffi::MPI_Initialized(&mut started);
            mpi::ffi::MPI_Finalized(&mut ended);
            started != 0 && ended == 0
        };
        if is_on {
            // SAFETY: the communicator of all ranks, which lives while MPI does.
            unsafe { mpi::ffi::MPI_Abort(mpi::ffi::RSMPI_COMM_WORLD, code) };
        }
    }

    /// The user's options that nothing has asked for.
    ///
    /// # Errors
    /// PETSc's.
    pub fn unused_options(&self) -> Result<Vec<String>, PetscError> {
        let (mut count, mut names, mut values) = (0, null_mut(), null_mut());
        // SAFETY: PETSc sets the pointers to lists of `count` texts, which live until they are given back.
        call!(PetscOptionsLeftGet(null_mut(), &mut count, &mut names, &mut values))?;
        // SAFETY: as above.
        let unused = (0..count as usize)
            .map(|k| unsafe { CStr::from_ptr(*names.add(k)) }.to_string_lossy().into_owned())
            .filter(|name| {
                !DEFAULTS.iter().chain(&OF_SEVERAL).any(|it| it.0.to_bytes()[1..] == *name.as_bytes())
            })
            .collect();
        // SAFETY: the lists of above, which are not used any more.
        call!(PetscOptionsLeftRestore(null_mut(), &mut count, &mut names, &mut values))?;
        Ok(unused)
    }

    /// The value of an option that the user has given.
    pub fn option(&self, name: &CStr) -> Option<String> {
        let mut text = [0 as c_char; 256];
        let mut is_set = ffi::PETSC_FALSE;
        // SAFETY: room for as many letters as are said.
        let asked = call!(PetscOptionsGetString(
            null_mut(),
            null(),
            name.as_ptr(),
            text.as_mut_ptr(),
            text.len() as _,
            &mut is_set
        ));
        if asked.is_err() || is_set == ffi::PETSC_FALSE {
            return None;
        }
        // SAFETY: PETSc ends what it writes with NUL.
        Some(unsafe { CStr::from_ptr(text.as_ptr()) }.to_string_lossy().into_owned())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // SAFETY: PETSc is on, and every object of it has been given back: each holds the session.
        let _ = call!(PetscFinalize());
    }
}
