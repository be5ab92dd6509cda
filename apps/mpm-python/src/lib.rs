//! The extension module of the Python package `implicit-mpm`: one more front beside the command line, over the same crates.
//!
//! What is plain Python lies in `python/implicit_mpm`; this module hands it scenes, runs, results and pictures. A run has a thread of its
//! own (`worker.rs`): it shows each load step and waits until Python asks for the next. Only laws and loads in Python (`foreign.rs`)
//! take Python's lock while it computes.

mod arrays;
mod drive;
mod errors;
mod foreign;
mod link;
mod outputs;
mod picture;
mod results;
mod run;
mod scene;
mod step;
mod worker;

use pyo3::prelude::*;

/// Scenes, runs, and results of the implicit Material Point Method.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::drive::{drive, drive_schema};
    #[pymodule_export]
    use crate::picture::{Picture, compared, picture};
    #[pymodule_export]
    use crate::results::Results;
    #[pymodule_export]
    use crate::run::{Run, resume, run};
    #[pymodule_export]
    use crate::scene::{Scene, read_text, schema};
    #[pymodule_export]
    use crate::step::Step;

    #[pymodule_init]
    fn init(module: &super::Bound<'_, super::PyModule>) -> super::PyResult<()> {
        super::add_version(module)
    }
}

fn add_version(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
