//! Names under which supports and probes are recorded.

/// What names of supports and probes are.
pub(super) const A_NAME: &str =
    "a name of its own, not empty, not `.` or `..`, without `/` and control characters";

/// Whether a name can be that of a dataset.
pub(super) fn is_name(name: &str) -> bool {
    !(name.is_empty() || [".", ".."].contains(&name) || name.contains('/') || name.contains(char::is_control))
}
