//! What of the history of a run is worth a word at its end.

use crate::observe::{Column, Entry};
use crate::record::columns::STEP_STRAIN;
use mpm_grid::six_digits;

/// Penetration over the width of a point from which on it shows in what is computed.
const DEEP: f64 = 0.1;

/// Strain of a load step from which on the stress of points that yield is to be doubted: in simple shear of Tresca or von Mises clay
/// a step of this strain turns the stress by about as much, and leaves 2 per cent less of the shear stress.
const LONG: f64 = 0.2;

/// The largest entries of the columns that are worth a word.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HistoryNotes {
    /// Number of the column, its name, its largest entry so far.
    columns: Vec<(usize, String, f64)>,
}

impl HistoryNotes {
    /// Follows a history with these columns.
    pub fn of(columns: &[Column]) -> Self {
        let followed = columns.iter().enumerate().filter(|(_, column)| is_followed(&column.name));
        Self { columns: followed.map(|(at, column)| (at, column.name.clone(), 0.0)).collect() }
    }

    /// Takes a row of the history into account.
    pub fn see(&mut self, row: &[Entry]) {
        for (at, _, largest) in &mut self.columns {
            if let Some(Entry::Real(values)) = row.get(*at) {
                *largest = values[0].max(*largest);
            }
        }
    }

    /// What is said at the end.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        self.columns.iter().filter_map(|(_, column, largest)| Self::note(column, *largest))
    }

    /// What is said of a column whose largest entry is this.
    pub fn note(column: &str, largest: f64) -> Option<String> {
        if column == STEP_STRAIN {
            return long_step(largest);
        }
        deep_tool(tool_of(column)?, largest)
    }
}

fn is_followed(column: &str) -> bool {
    column == STEP_STRAIN || tool_of(column).is_some()
}

fn tool_of(column: &str) -> Option<&str> {
    column.strip_prefix("tool/")?.strip_suffix("/deepest")
}

fn deep_tool(tool: &str, deepest: f64) -> Option<String> {
    (deepest > DEEP).then(|| {
        format!(
            "tool `{tool}` has entered a body by {} of a point's width, more than {DEEP}: the body is displaced by so much less; \
             the tool's interface can have a larger `stiffness`, or `augment`",
            six_digits(deepest)
        )
    })
}

fn long_step(strain: f64) -> Option<String> {
    (strain > LONG).then(|| {
        format!(
            "a point that yields was strained by {} in one load step, more than {LONG}: its stress is turned by about so many \
             radians; more load steps make it right",
            six_digits(strain)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::ColumnKind;

    #[test]
    fn only_what_is_doubtful_is_told_of() {
        assert_eq!(HistoryNotes::note("tool/blade/force", 1.0), None);
        assert_eq!(HistoryNotes::note("tool/blade/deepest", 0.1), None);
        assert_eq!(HistoryNotes::note(STEP_STRAIN, 0.2), None);
        assert_eq!(HistoryNotes::note("residual", 9.0), None);
        let column = |name: &str| Column { name: name.into(), kind: ColumnKind::Real, width: 1 };
        let columns = ["residual", "tool/blade/deepest", STEP_STRAIN].map(column);
        let mut notes = HistoryNotes::of(&columns);
        for (deepest, strain) in [(0.05, 0.3), (0.25, 0.7), (0.2, 0.1)] {
            notes.see(&[9.0, deepest, strain].map(|value| Entry::Real(vec![value])));
        }
        let notes: Vec<String> = notes.notes().collect();
        assert_eq!(notes.len(), 2, "{notes:?}");
        assert!(notes[0].contains("`blade` has entered a body by 0.25 of"), "{notes:?}");
        assert!(notes[1].contains("strained by 0.7 in one load step"), "{notes:?}");
    }
}
