//! How deep rigid tools have entered bodies, and when that is worth a word.

use crate::observe::{Column, Entry};
use mpm_grid::six_digits;

/// Penetration over the width of a point from which on it shows in what is computed.
const DEEP: f64 = 0.1;

/// The largest depth to which each tool has entered bodies, as the history tells it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolDepths {
    /// Number of the column, name of the tool, largest depth over the width of a point.
    tools: Vec<(usize, String, f64)>,
}

impl ToolDepths {
    /// Follows the tools of a history with these columns.
    pub fn of(columns: &[Column]) -> Self {
        let tool = |(at, column): (usize, &Column)| Some((at, tool_of(&column.name)?.to_owned(), 0.0));
        Self { tools: columns.iter().enumerate().filter_map(tool).collect() }
    }

    /// Takes a row of the history into account.
    pub fn see(&mut self, row: &[Entry]) {
        for (at, _, deepest) in &mut self.tools {
            if let Some(Entry::Real(values)) = row.get(*at) {
                *deepest = values[0].max(*deepest);
            }
        }
    }

    /// What is said of the tools that have entered bodies deeply.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        self.tools.iter().filter_map(|(_, tool, deepest)| note(tool, *deepest))
    }

    /// What is said where a column of the history tells how deep a tool has entered bodies, and its largest value is this.
    pub fn note(column: &str, largest: f64) -> Option<String> {
        note(tool_of(column)?, largest)
    }
}

fn tool_of(column: &str) -> Option<&str> {
    column.strip_prefix("tool/")?.strip_suffix("/deepest")
}

fn note(tool: &str, deepest: f64) -> Option<String> {
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
    use crate::observe::ColumnKind;

    #[test]
    fn only_depth_is_told_of() {
        assert_eq!(ToolDepths::note("tool/blade/force", 1.0), None);
        assert_eq!(ToolDepths::note("tool/blade/deepest", 0.1), None);
        let column = |name: &str| Column { name: name.into(), kind: ColumnKind::Real, width: 1 };
        let mut depths = ToolDepths::of(&[column("residual"), column("tool/blade/deepest")]);
        for deepest in [0.05, 0.25, 0.2] {
            depths.see(&[Entry::Real(vec![9.0]), Entry::Real(vec![deepest])]);
        }
        let notes: Vec<String> = depths.notes().collect();
        assert!(notes.len() == 1 && notes[0].contains("`blade` has entered a body by 0.25 of"), "{notes:?}");
    }
}
