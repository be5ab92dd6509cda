//! Settings of glibc's allocator.

pub(crate) fn keep_freed_memory() {
    // Blocks up to 2 GiB are taken from memory that is kept, and none of it is given back.
    set(libc::M_MMAP_THRESHOLD, libc::c_int::MAX);
    set(libc::M_TRIM_THRESHOLD, libc::c_int::MAX);
    // What one thread frees serves the others.
    set(libc::M_ARENA_MAX, 1);
}

/// Sets a parameter; the allocator refuses values that it does not know.
#[allow(unsafe_code)]
fn set(parameter: libc::c_int, value: libc::c_int) {
    // SAFETY: mallopt takes any two numbers and any state of the allocator; it locks the arena that it changes.
    unsafe { libc::mallopt(parameter, value) };
}
