//! What bindgen has read in PETSc's headers. Its `Vec` is no vector of Rust: it is named in full wherever it is used.

#![allow(
    clippy::all,
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    unsafe_op_in_unsafe_fn,
    unused,
    unnecessary_transmutes
)]

include!(concat!(env!("OUT_DIR"), "/petsc.rs"));
