//! What a program frees is kept for its next allocation, where the C library is glibc.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn main() {
    const BYTES: usize = 64 << 20;
    // Resident pages, the second number of the file.
    let resident = || -> usize {
        let text = std::fs::read_to_string("/proc/self/statm").expect("the system tells");
        text.split_whitespace().nth(1).and_then(|it| it.parse().ok()).expect("a number of pages")
    };
    let take = || drop(std::hint::black_box(vec![1_u8; BYTES]));
    let before = resident();
    take();
    assert!(
        resident() < before + BYTES / 4096 / 8,
        "as the allocator is set, freed memory goes back to the system"
    );
    mpm_heap::keep_freed_memory();
    take();
    let once = resident();
    assert!(once > before + BYTES / 4096 / 8, "it is kept");
    take();
    // A thread takes from the same memory.
    std::thread::spawn(take).join().expect("the thread ends");
    assert!(resident() < once + BYTES / 4096 / 8, "and taken again");
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn main() {
    mpm_heap::keep_freed_memory();
}
