//! What a results file is to hold.

use std::thread;
use std::time::Duration;

use mpm_scene::language::{ComponentsInput, OutputInput, PrecisionInput};
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

/// Components of the point fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Components {
    /// Three of vectors, nine of tensors, as VTK has them.
    #[default]
    All,
    /// Those that plane strain leaves: x and y of the displacement; xx, xy, yy, zz of stress and elastic strain; these and
    /// yx of the deformation gradient. Only bodies in plane strain have no others.
    InPlane,
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
    /// Components of the fields.
    pub components: Components,
    /// Load steps that end within so long of the last write are written together; a run that is killed loses those
    /// that are not written. Zero writes each at once.
    pub keep_back: Duration,
    /// Whether many points are written by a thread of its own while the run goes on (default where there is more than one
    /// core). Each write waits for the one before, so that at most two are in memory.
    pub beside: bool,
}

impl Options {
    /// What a scene asks for, whose fields are these.
    pub fn of(output: &OutputInput, fields: Vec<Field>) -> Self {
        Self {
            fields,
            every: output.every.0 as usize,
            precision: match output.precision {
                PrecisionInput::Double => Precision::Double,
                PrecisionInput::Single => Precision::Single,
            },
            components: match output.components {
                ComponentsInput::All => Components::All,
                ComponentsInput::InPlane => Components::InPlane,
            },
            ..Self::default()
        }
    }
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
            components: Components::All,
            keep_back: Duration::from_secs(1),
            beside: thread::available_parallelism().is_ok_and(|cores| cores.get() > 1),
        }
    }
}
