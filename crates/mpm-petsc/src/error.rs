//! Errors of PETSc.

use crate::ffi;
use std::ffi::{CStr, c_char};
use std::ptr::null_mut;

/// A call that PETSc refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("PETSc's {call} failed: {reason} (code {code})")]
pub struct PetscError {
    /// The function.
    pub call: &'static str,
    /// PETSc's code.
    pub code: i32,
    /// What PETSc says of it.
    pub reason: String,
}

impl PetscError {
    /// An error where `code` is one.
    pub(crate) fn check(call: &'static str, code: ffi::PetscErrorCode) -> Result<(), Self> {
        let code = code as i32;
        if code == 0 {
            return Ok(());
        }
        let mut text: *const c_char = std::ptr::null();
        // SAFETY: PETSc sets the pointer to a text of its own that is never freed, or to null.
        let reason = unsafe {
            ffi::PetscErrorMessage(code, &mut text, null_mut());
            if text.is_null() {
                "unknown error".into()
            } else {
                CStr::from_ptr(text).to_string_lossy().into_owned()
            }
        };
        Err(Self { call, code, reason: reason.trim().to_owned() })
    }

    /// Whether memory did not suffice.
    pub(crate) fn is_memory(&self) -> bool {
        self.code == ffi::PETSC_ERR_MEM as i32
    }
}

/// Calls a function of PETSc; its code becomes a `Result`.
macro_rules! call {
    ($name:ident($($argument:expr),* $(,)?)) => {
        $crate::error::PetscError::check(
            stringify!($name),
            // SAFETY: handles are alive while their wrapper is; what else is passed is explained at the call.
            unsafe { $crate::ffi::$name($($argument),*) },
        )
    };
}
pub(crate) use call;
