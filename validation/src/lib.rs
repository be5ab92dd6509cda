//! Validation: what the code computes, against what it should.
//!
//! A [`Case`] says what it is to show, what is run, and what the outcome is compared with; running
//! it yields [`Findings`]: [`Check`]s, each an error and the tolerance it has to keep, [`Table`]s of
//! what was measured, and [`Picture`]s. [`CASES`] lists them all. The program `mpm-validation` prints
//! them (and `stress` those of [`STRESS`], which try to break the code). The tests run the same functions to a smaller
//! [`Extent`]. [`pages`] writes a page per case and the table of all of them.
//!
//! A new case is one function in `cases/`, one entry of [`CASES`], and one line in `tests/cases.rs`; the program then writes
//! its page.

pub mod analytic;
pub mod bits;
mod cases;
pub mod fuzz;
pub mod history;
mod html;
pub mod pages;
pub mod picture;
pub mod probe;
pub mod problems;
mod quasi_random;
pub mod reference;
mod report;
pub mod scenes;
mod stress;
pub mod variants;

pub use cases::CASES;
pub use picture::Picture;
pub use report::program;
pub use stress::STRESS;

use std::error::Error;

/// Why a case could not be carried out at all.
pub type Broken = Box<dyn Error + Send + Sync>;

/// One case of the validation.
pub struct Case {
    /// Its name in the table and on its page.
    pub name: &'static str,
    /// What it is to show.
    pub goal: &'static str,
    /// What is run.
    pub setup: &'static str,
    /// What the outcome is compared with.
    pub reference: &'static str,
    /// Runs it.
    pub run: fn(Extent) -> Result<Findings, Broken>,
}

/// How much of a case is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// What a test has time for.
    Tests,
    /// Everything.
    Full,
}

impl Extent {
    /// One of two: the first for the tests, the second for everything.
    pub fn pick<T>(self, tests: T, full: T) -> T {
        match self {
            Extent::Tests => tests,
            Extent::Full => full,
        }
    }
}

/// What a case found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Comparisons.
    pub checks: Vec<Check>,
    /// Measurements without a verdict.
    pub tables: Vec<Table>,
    /// Pictures, drawn on request.
    pub pictures: Vec<Picture>,
}

impl From<Vec<Check>> for Findings {
    fn from(checks: Vec<Check>) -> Self {
        Self { checks, ..Self::default() }
    }
}

/// Measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What is measured, and what to make of it.
    pub text: String,
    /// Heads of the columns.
    pub heads: Vec<String>,
    /// As many words as there are heads.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(text: impl Into<String>, heads: &[&str]) -> Self {
        Self { text: text.into(), heads: heads.iter().map(|&it| it.into()).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If it does not have a word for each column.
    pub fn push(&mut self, row: impl IntoIterator<Item = String>) {
        let row: Vec<String> = row.into_iter().collect();
        assert_eq!(row.len(), self.heads.len(), "{row:?} under {:?}", self.heads);
        self.rows.push(row);
    }
}

/// One comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What is compared, and with what.
    pub what: String,
    /// How far they are apart.
    pub error: f64,
    /// How far they may be.
    pub tolerance: f64,
    /// What else was seen, if anything.
    pub remark: String,
}

impl Check {
    /// A comparison without a remark.
    pub fn new(what: impl Into<String>, error: f64, tolerance: f64) -> Self {
        Self { what: what.into(), error, tolerance, remark: String::new() }
    }

    /// Something that must be so: the error counts the exceptions.
    pub fn none(what: impl Into<String>, exceptions: usize) -> Self {
        Self::new(what, exceptions as f64, 0.0)
    }

    /// Adds a remark.
    pub fn remark(self, remark: impl Into<String>) -> Self {
        Self { remark: remark.into(), ..self }
    }

    /// Whether the error keeps its tolerance; one that is not a number does not.
    pub fn passes(&self) -> bool {
        self.error <= self.tolerance
    }
}

/// The case of a name, if there is one.
pub fn case(name: &str) -> Option<&'static Case> {
    CASES.iter().find(|case| case.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_passes_up_to_its_tolerance_and_never_without_a_number() {
        assert!(Check::new("", 1e-8, 1e-8).passes());
        assert!(!Check::new("", 1.1e-8, 1e-8).passes());
        assert!(!Check::new("", f64::NAN, 1e-8).passes());
        assert!(Check::none("", 0).passes() && !Check::none("", 1).passes());
    }

    #[test]
    fn names_are_unique() {
        for (k, case) in CASES.iter().enumerate() {
            assert!(CASES[..k].iter().all(|other| other.name != case.name), "{}", case.name);
        }
    }
}
