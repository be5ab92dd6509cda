//! From text to scene: what cannot be read is reported where it stands, in words of the scene.

use super::position::Position;
use ron::error::{Error, SpannedError};
use serde::de::DeserializeOwned;
use std::ops::Range;

/// A text that is not a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}:{}: {reason}", start.line, start.column)]
pub struct ReadError {
    /// What was found and what was expected.
    pub reason: String,
    /// Where the offending text begins.
    pub start: Position,
    /// Where it ends.
    pub end: Position,
}

/// Reads what a text in the language of scenes says.
pub(super) fn read<T: DeserializeOwned>(text: &str) -> Result<T, ReadError> {
    if let Some(at) = text.find('\0') {
        let [start, end] = [at, at + 1].map(|at| Position::of(text, at));
        return Err(ReadError { reason: "a NUL character is part of no scene".into(), start, end });
    }
    let options = ron::Options::default()
        .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
        .with_default_extension(ron::extensions::Extensions::UNWRAP_VARIANT_NEWTYPES);
    options.from_str(text).map_err(|error| ReadError::new(text, &error))
}

impl ReadError {
    fn new(text: &str, error: &SpannedError) -> Self {
        let place = place(text, error);
        let reason = reason(&error.code, text, &place);
        Self { reason, start: Position::of(text, place.start), end: Position::of(text, place.end) }
    }
}

/// The offending text.
///
/// The reader gives the piece it read last: that is the culprit where a value or name was refused,
/// but stops short of it where the next piece is not what it should be.
fn place(text: &str, error: &SpannedError) -> Range<usize> {
    let offset = |at: ron::error::Position| Position { line: at.line, column: at.col }.offset(text);
    let (start, end) = (offset(error.span.start), offset(error.span.end));
    match error.code {
        Error::InvalidEscape(_) => end.saturating_sub(2)..end,
        Error::UnclosedBlockComment => start.saturating_sub(2)..start,
        Error::Message(_)
        | Error::NoSuchEnumVariant { .. }
        | Error::NoSuchStructField { .. }
        | Error::DuplicateStructField { .. }
        | Error::InvalidValueForType { .. }
        | Error::IntegerOutOfBounds
            if start < end =>
        {
            // The reader takes a sign, and the opening quote of a text, by themselves.
            let split = text[..start].ends_with(['-', '+', '"']);
            start - usize::from(split)..end
        }
        Error::ExpectedComma | Error::InvalidIntegerDigit { .. } => {
            fraction_at(text, end).unwrap_or_else(|| token(text, end))
        }
        _ => token(text, end),
    }
}

/// The number with a point or exponent whose first digits, as a whole number, end at `at`.
fn fraction_at(text: &str, at: usize) -> Option<Range<usize>> {
    let number = text[..at].trim_end_matches(is_word).len()..token(text, at).end;
    let digits = text[number.clone()].trim_start_matches(['-', '+']);
    let is_fraction = digits.starts_with(|c: char| c.is_ascii_digit()) && digits.contains(['.', 'e', 'E']);
    is_fraction.then_some(number)
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || "_.+-".contains(c)
}

/// The word, number, quoted text or sign at `at`; empty at the end of the text.
fn token(text: &str, at: usize) -> Range<usize> {
    let rest = &text[at..];
    let quoted = rest.strip_prefix('"').and_then(|inside| inside.find(['"', '\n'])).map(|length| length + 2);
    let word = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
    let sign = rest.chars().next().map_or(0, char::len_utf8);
    at..at + quoted.unwrap_or(if word > 0 { word } else { sign })
}

/// An error without a place, of a part that was read by itself.
pub(super) fn in_words(error: &Error) -> String {
    reason(error, "", &(0..0))
}

fn reason(error: &Error, text: &str, place: &Range<usize>) -> String {
    let found = match text[place.clone()].trim() {
        "" if place.start == text.len() => "the end of the text".to_string(),
        found => format!("`{found}`"),
    };
    let expected = |what: &str| format!("expected {what}, got {found}");
    let of = |outer: &Option<String>| outer.as_ref().map_or(String::new(), |outer| format!(" of `{outer}`"));
    match error {
        Error::Message(message) => message.clone(),
        Error::Eof => "the text ends before the scene does".into(),
        Error::ExpectedFloat => expected("a number"),
        Error::ExpectedInteger => expected("a whole number"),
        Error::ExpectedBoolean => expected("`true` or `false`"),
        Error::ExpectedString => expected("text in double quotes"),
        Error::ExpectedArray => expected("a list in brackets, `[ … ]`"),
        Error::ExpectedMap => expected("named entries in braces, `{ … }`"),
        Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_) => expected("`( … )`"),
        Error::ExpectedIdentifier | Error::InvalidIdentifier(_) | Error::SuggestRawIdentifier(_) => {
            expected("a name")
        }
        Error::InvalidEscape(_) => expected("an escape such as `\\n` or `\\\\` in the text"),
        Error::ExpectedMapColon => expected("`:`"),
        Error::ExpectedArrayEnd => expected("`]`"),
        Error::ExpectedMapEnd => expected("`}`"),
        Error::ExpectedStructLikeEnd | Error::ExpectedOptionEnd => expected("`)`"),
        Error::InvalidIntegerDigit { .. } => expected("a whole number"),
        Error::ExpectedComma if fraction_at(text, place.start) == Some(place.clone()) => {
            expected("a whole number")
        }
        Error::ExpectedComma => expected("`,` or a closing bracket"),
        Error::TrailingCharacters => expected("the end of the scene"),
        Error::IntegerOutOfBounds => expected("a whole number of at most 64 bits"),
        Error::UnclosedBlockComment => "this comment is not closed".into(),
        Error::InvalidValueForType { expected, found } => format!("expected {expected}, got {found}"),
        Error::ExpectedDifferentLength { expected, found } => format!("expected {expected}, got {found}"),
        Error::NoSuchEnumVariant { expected, found, outer } => {
            format!("unknown name `{found}`{}; expected {}", of(outer), one_of(expected))
        }
        Error::NoSuchStructField { expected, found, outer } => {
            format!("unknown field `{found}`{}; expected {}", of(outer), one_of(expected))
        }
        Error::MissingStructField { field, outer } => format!("missing field `{field}`{}", of(outer)),
        Error::DuplicateStructField { field, outer } => format!("field `{field}`{} is given twice", of(outer)),
        other => {
            let message = other.to_string();
            let first = message.chars().next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
            first + message.chars().as_str().get(1..).unwrap_or_default()
        }
    }
}

fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        None => "nothing".into(),
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
    }
}
