//! What a results file is to hold.

use std::time::Duration;

use mpm_solver::observe::Field;

/// Number format of the point fields; positions are always `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 8 bytes: what the solver computed.
    #[default]
    Double,
    /// 4 bytes: enough to look at.
    Single,
}

/// What to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// The scene as it was read, kept in the file.
    pub scene: String,
    /// The scene of the results so far, where a run goes on with another to which stages have been added. Columns that they do
    /// not have hold zeros up to there.
    pub earlier_scene: Option<String>,
    /// Name and version of the program, for example `mpm 0.1.0`.
    pub program: String,
    /// Fields of the material points.
    pub fields: Vec<Field>,
    /// Points are recorded at every n-th load step that is counted, see [`mpm_solver::observe::Counted`] (0 counts as 1), and always at the first and last.
    pub every: usize,
    /// 0: plain (default). 1 to 9: gzip with shuffle; level 1 halves smooth fields and takes four
    /// times as long, higher levels only take longer.
    pub compression: u8,
    /// Number format of the fields.
    pub precision: Precision,
    /// Load steps that end within so long of the last write are written together; a run that is killed loses those
    /// that are not written. Zero writes each at once.
    pub keep_back: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scene: String::new(),
            earlier_scene: None,
            program: String::new(),
            fields: Vec::new(),
            every: 1,
            compression: 0,
            precision: Precision::Double,
            keep_back: Duration::from_secs(1),
        }
    }
}
