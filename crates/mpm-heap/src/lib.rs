//! How a program holds memory that it has freed.
//!
//! A load step frees lists and matrices of many megabytes and makes others of the same size. As glibc's allocator is set, such
//! blocks come from the system one by one and go back to it, and the system clears every page that it gives out. In a
//! million points in the plane over two load steps that took a tenth of the processor time (`benchmarks/README.md`).

/// Lets the allocator keep what is freed until the process ends, and lets all threads take from the same memory.
///
/// It is for a process that computes on one thread: several would wait for each other at every allocation. A program calls it
/// before that thread starts; a library does not, for it is a setting of the whole process. The memory that a process
/// holds is then the most that it has needed at one time. It does nothing where the C library is not glibc.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // Blocks up to 2 GiB are taken from memory that is kept, and none of it is given back.
        set(libc::M_MMAP_THRESHOLD, libc::c_int::MAX);
        set(libc::M_TRIM_THRESHOLD, libc::c_int::MAX);
        // What one thread frees serves the others.
        set(libc::M_ARENA_MAX, 1);
    }
}

/// Sets a parameter of glibc's allocator, which refuses values that it does not know.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code)]
fn set(parameter: libc::c_int, value: libc::c_int) {
    // SAFETY: mallopt takes any two numbers and any state of the allocator; it locks the arena that it changes.
    unsafe { libc::mallopt(parameter, value) };
}
