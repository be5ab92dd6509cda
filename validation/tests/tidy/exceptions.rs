//! What the rules of the sources are not kept in, and why. These lists may only shrink.

/// Files above 450 lines, and why.
pub const LONG_FILES: &[(&str, &str)] = &[];
/// Functions above 80 lines.
pub const LONG_FUNCTIONS: &[(&str, &str)] = &[];
/// Functions with more than six arguments.
pub const MANY_ARGUMENTS: &[(&str, &str)] = &[];
/// Circles.
pub const CIRCLES: &[(&str, &str)] = &[];
