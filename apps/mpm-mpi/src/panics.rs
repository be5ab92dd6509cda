//! A rank that has panicked would let the others wait for ever.

use mpm_petsc::Session;
use std::panic;

/// Exit code of a panic.
const PANIC: i32 = 101;

/// From now on a panic, once it has been said, ends all ranks.
pub(crate) fn end_all_ranks() {
    let says = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        says(panic);
        Session::abort(PANIC);
        std::process::exit(PANIC);
    }));
}
