//! Where the rules of the sources are not kept yet, and why. These lists may only shrink.

/// Files that are too long: path and reason.
pub const LONG_FILES: &[(&str, &str)] = &[];

/// Functions that are too long: path, name, and the reason.
pub const LONG_FUNCTIONS: &[(&str, &str)] = &[];

/// Functions with too many arguments: path, name, and the reason.
pub const MANY_ARGUMENTS: &[(&str, &str)] = &[];

/// Crates with circles of modules, and the reason.
pub const CIRCLES: &[(&str, &str)] = &[];
