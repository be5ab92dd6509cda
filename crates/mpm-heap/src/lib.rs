//! How a program holds memory that it has freed.
//!
//! A load step frees lists and matrices of many megabytes and makes others of the same size. As glibc's allocator is set, such
//! blocks come from the system one by one and go back to it, and the system clears every page that it gives out. In a
//! million points in the plane over two load steps that took a tenth of the processor time (`benchmarks/README.md`).

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod glibc;

/// Lets the allocator keep what is freed until the process ends, and lets all threads take from the same memory.
///
/// It is for a process that computes on one thread: several would wait for each other at every allocation. A program calls it
/// before that thread starts; a library does not, for it is a setting of the whole process. The memory that a process
/// holds is then the most that it has needed at one time. It does nothing where the C library is not glibc.
pub fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    glibc::keep_freed_memory();
}
