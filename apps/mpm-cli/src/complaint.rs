//! Messages on standard error, each printed once, in colour only on a terminal.

use crate::terminal::error_width;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, MietteError, MietteSpanContents,
    Report, SourceCode, SourceSpan, SpanContents,
};
use mpm_grid::rounded;
use std::io::{IsTerminal, Write};
use std::ops::Range;
use std::path::Path;
use std::process::ExitCode;

/// Columns where nobody sees a terminal: lines are not wrapped.
const UNBROKEN: usize = 200;

/// Columns up to which a line is shown beside what is wrong in it.
const WIDEST: usize = 2000;

/// Why the program ends early: a message and an exit code.
pub struct Complaint {
    /// `None` where another process prints the message.
    report: Option<Report>,
    code: u8,
}

impl Complaint {
    /// The simulation could not finish.
    pub fn unfinished(message: String) -> Self {
        Self { report: Some(Report::new(MietteDiagnostic::new(rounded(&message)))), code: 1 }
    }

    /// The input is wrong as a whole.
    pub fn input(message: String) -> Self {
        Self { report: Some(Report::new(MietteDiagnostic::new(rounded(&message)))), code: 2 }
    }

    /// Another process prints the message.
    pub fn told(code: u8) -> Self {
        Self { report: None, code }
    }

    /// The input is wrong at one place (in bytes) of its text.
    pub fn at(file: &Path, text: &str, place: Range<usize>, label: Option<String>, message: String) -> Self {
        let before = &text[..place.start];
        let column = before.rfind('\n').map_or(before, |end| &before[end + 1..]).chars().count() + 1;
        if column > WIDEST {
            // A line that is too long to show the place in it is left out.
            let line = before.matches('\n').count() + 1;
            let label = label.map_or(String::new(), |it| format!("{it}: "));
            return Self::input(format!("{}:{line}:{column}: {label}{message}", file.display()));
        }
        // A place that spans several lines is marked on its first line only.
        let length = text[place.clone()].find('\n').unwrap_or(place.len());
        let label = LabeledSpan::new_primary_with_span(label, (place.start, length));
        let diagnostic = MietteDiagnostic::new(rounded(&message)).with_label(label);
        let source = Source { name: file.display().to_string(), text: text.to_string() };
        Self { report: Some(Report::new(diagnostic).with_source_code(source)), code: 2 }
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        self.code
    }

    /// Prints the message to standard error.
    pub fn deliver(&self) -> ExitCode {
        let Some(report) = &self.report else { return ExitCode::from(self.code) };
        let terminal = std::io::stderr().is_terminal();
        let colour = std::env::var_os("NO_COLOR").is_none_or(|it| it.is_empty());
        let theme = match (terminal, colour) {
            (true, true) => GraphicalTheme::unicode(),
            (true, false) => GraphicalTheme::unicode_nocolor(),
            (false, _) => GraphicalTheme::none(),
        };
        let handler = GraphicalReportHandler::new_themed(theme)
            .with_wrap_lines(terminal)
            .with_context_lines(1)
            .with_links(false)
            .without_syntax_highlighting();
        let handler = handler.with_width(error_width().unwrap_or(UNBROKEN));
        let mut text = String::new();
        if handler.render_report(&mut text, report.as_ref()).is_err() {
            text = format!("{report}\n");
        }
        // If standard error is closed, there is nowhere to report it.
        let _ = std::io::stderr().write_all(text.as_bytes());
        ExitCode::from(self.code)
    }
}

/// The message alone.
impl std::fmt::Display for Complaint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.report.as_ref().map_or(Ok(()), |report| write!(f, "{report}"))
    }
}

/// A named text whose columns are counted in characters (miette's own are bytes).
#[derive(Debug)]
struct Source {
    name: String,
    text: String,
}

impl SourceCode for Source {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let found = self.text.read_span(span, lines_before, lines_after)?;
        let start = found.span().offset();
        let column = self.text[start - found.column()..start].chars().count();
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            found.data(),
            *found.span(),
            found.line(),
            column,
            found.line_count(),
        )))
    }
}
