//! How deep rigid tools have entered bodies, and when that is worth a word.

use mpm_grid::six_digits;

/// Penetration over the width of a point from which on it shows in what is computed.
const DEEP: f64 = 0.1;

/// The tool of which a column of the history tells how deep it has entered bodies.
pub fn tool_of(column: &str) -> Option<&str> {
    column.strip_prefix("tool/")?.strip_suffix("/deepest")
}

/// What is said of a tool that has entered a body by `deepest` of a point's width `[-]`.
pub fn note(tool: &str, deepest: f64) -> Option<String> {
    (deepest > DEEP).then(|| {
        format!(
            "tool `{tool}` has entered a body by {} of a point's width, more than {DEEP}: the body is displaced by so much less; \
             the tool's interface can have a larger `stiffness`, or `augment`",
            six_digits(deepest)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_depth_is_told_of() {
        assert_eq!(tool_of("tool/blade/deepest"), Some("blade"));
        assert_eq!(tool_of("tool/blade/force"), None);
        assert_eq!(note("blade", 0.1), None);
        assert!(note("blade", 0.25).is_some_and(|note| note.contains("`blade` has entered a body by 0.25 of")));
    }
}
