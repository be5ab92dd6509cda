//! How wide lines are where people read them.

use console::Term;
use std::fmt::Write;

/// Columns of the names before the values.
const NAMES: usize = 18;
/// Values are not wrapped to fewer columns.
const NARROWEST: usize = 20;

/// Columns of the terminal that standard output leads to, if it is one.
pub fn output_width() -> Option<usize> {
    Term::stdout().size_checked().map(|(_, columns)| usize::from(columns))
}

/// Columns of the terminal that standard error leads to, if it is one.
pub fn error_width() -> Option<usize> {
    Term::stderr().size_checked().map(|(_, columns)| usize::from(columns))
}

/// Names and values, one below the other; wrapped where standard output is a terminal.
pub struct Lines {
    text: String,
    width: Option<usize>,
}

impl Lines {
    /// None yet.
    pub fn new() -> Self {
        Self { text: String::new(), width: output_width() }
    }

    /// Adds a value with its name.
    pub fn add(&mut self, name: &str, value: impl AsRef<str>) {
        let value = value.as_ref();
        let width = self.width.map_or(usize::MAX, |width| width.saturating_sub(NAMES).max(NARROWEST));
        let mut name = name;
        for line in wrapped(value, width) {
            // Writing to a string cannot fail.
            let _ = writeln!(self.text, "{}", format!("{name:<NAMES$}{line}").trim_end());
            name = "";
        }
    }

    /// All of them.
    pub fn into_text(self) -> String {
        self.text
    }
}

/// Lines of at most so many characters, parted at spaces; a longer word has a line of its own.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    if text.chars().count() <= width {
        return vec![text.to_string()];
    }
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is one");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= width {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_string());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_wrapped_below_each_other() {
        let mut lines = Lines { text: String::new(), width: Some(40) };
        lines.add("memory", "about 29.5 MB: points 22.5 kB, connectivity 18 kB");
        lines.add("scene", "short");
        let expected = "memory            about 29.5 MB: points
                  22.5 kB, connectivity
                  18 kB
scene             short
";
        assert_eq!(lines.into_text(), expected);
        let mut lines = Lines { text: String::new(), width: None };
        lines.add("a", "b ".repeat(100));
        assert_eq!(lines.into_text().lines().count(), 1);
    }
}
