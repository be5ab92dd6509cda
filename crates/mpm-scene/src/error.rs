//! What is wrong with a scene as a whole.

/// Something in a scene that only the whole scene can show to be wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct SceneError {
    /// Where in the scene, for example `supports[1].region`; see [`crate::language::position_of`].
    pub path: String,
    /// What was found and what was expected.
    pub reason: String,
}

impl SceneError {
    /// An error at `path`.
    pub fn new(path: impl Into<String>, reason: impl ToString) -> Self {
        Self { path: path.into(), reason: reason.to_string() }
    }
}
