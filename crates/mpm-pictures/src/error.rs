//! Why a picture could not be made.

/// Why a picture of results could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// An argument asks for what the results do not have.
    #[error("{argument}: {reason}")]
    Argument {
        /// Name of the argument: `field`, `step`, `range`, `body`, `mirror`, `slice` or `cut`.
        argument: &'static str,
        /// What was expected.
        reason: String,
    },
    /// The results, or the scene in them, cannot be drawn.
    #[error("{0}")]
    Results(String),
    /// The picture cannot be drawn or written.
    #[error(transparent)]
    Plot(#[from] mpm_plot::PlotError),
}

impl PictureError {
    pub(crate) fn new(reason: impl Into<String>) -> Self {
        Self::Results(reason.into())
    }

    pub(crate) fn of(argument: &'static str, reason: impl Into<String>) -> Self {
        Self::Argument { argument, reason: reason.into() }
    }
}
