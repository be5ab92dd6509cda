//! Benchmarks: programs that measure, print tables, and write JSON and pictures.
//!
//! Each set is a module with a `run` that returns a [`report::Report`]; `main.rs` chooses. See the
//! README beside the manifest for what each measures and what was found last.

pub mod blocks;
pub mod counts;
pub mod first_to;
pub mod growth;
pub mod kernels;
pub mod laws;
pub mod machine;
pub mod phases;
pub mod program;
pub mod ranks;
pub mod report;
pub mod skewed;
pub mod small;
pub mod solver;
pub mod space;
pub mod threads;
pub mod throughput;
pub mod time_against_error;

/// Why a set could not be carried out.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
