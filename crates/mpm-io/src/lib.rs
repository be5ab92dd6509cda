#![doc = include_str!("../README.md")]
//!
//! # In more detail
//!
//! Results of a run on disk: one HDF5 file that h5py, VTK and ParaView open as it is.
//!
//! [`ResultsWriter`] observes a run and writes while it goes; [`Results`] reads the file back.
//! [`Results::write_csv`] and [`Results::write_vtu`] hand it on to programs that read neither.
//! Everything that can go wrong is a [`ResultsError`]. [`FolderFiles`] reads what a scene names: surfaces (STL)
//! and tables of points (CSV, HDF5). This is the only crate that links HDF5.
//!
//! The file (`format = "mpm-results"`, `version = 1`):
//!
//! | where | what |
//! |---|---|
//! | root attributes | `format`, `version`, `scene` (its text), `program`, `status`: `running`, `completed` or `failed: <reason>`; `space`: `axisymmetric`, of bodies of revolution only |
//! | `/history/<column>` | one row per converged load step, row 0 the initial state: `[rows]`, or `[rows, width]`; the attribute `rows` of the group counts the complete ones |
//! | `/newton/residual` | relative out-of-balance force of every iterate of every load step, one after the other |
//! | `/newton/offset` | `[rows]`: the residuals of row k ≥ 1 are `residual[offset[k-1]..offset[k]]` |
//! | `/timings/{phase,seconds,count}` | time spent per phase since the start of the run |
//! | `/VTKHDF` | the material points at the recorded load steps, by VTK's file specification 2.0 |
//!
//! Of bodies of revolution, positions and vectors are (r, z, t) and tensors rr, rz, rt, zr, zz, zt, tr, tz, tt, with t the
//! direction of the hoop, θ; forces are those of the whole ring. [`component_name`] names the components of either space.
//!
//! A small XDMF file beside it shows the same datasets to programs without temporal VTKHDF.
//! What a killed run leaves behind is said at [`ResultsWriter`].

mod calls;
mod check_sum;
mod checkpoint;
mod contents;
mod earlier;
mod error;
mod export;
mod in_plane;
mod keeper;
mod names;
mod options;
mod pending;
mod places;
mod reader;
mod replace;
mod revolve;
mod rows;
mod run_file;
mod scene_files;
mod snapshot;
mod source;
mod spaces;
mod vtkhdf;
mod writer;
mod xdmf;

pub use calls::Calls;
pub use checkpoint::{Checkpoint, CheckpointHead, CheckpointInterval};
pub use contents::{Item, Values};
pub use error::{CheckpointError, ResultsError};
pub use export::{component_name, shortest};
pub use keeper::Keeper;
pub use options::{Components, Options, Precision};
pub use places::{Survives, check_places, is_same, reason_to_keep_results, unfinished_results};
pub use reader::{PhaseTime, Results, Table};
pub use replace::is_being_written;
pub use revolve::Revolution;
pub use scene_files::{ArrayFiles, FolderFiles};
pub use writer::ResultsWriter;
