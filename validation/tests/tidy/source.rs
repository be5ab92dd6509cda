//! Sources as text without comments and literals, and the functions in them.

use std::fs;
use std::path::{Path, PathBuf};

/// A source file of the workspace.
pub struct Source {
    /// Its path below the workspace.
    pub name: String,
    pub text: String,
}

/// A function with a body.
#[derive(Debug, PartialEq, Eq)]
pub struct Function {
    pub name: String,
    /// Lines from its first to its last, both counted.
    pub lines: usize,
    /// Arguments, `self` not counted.
    pub arguments: usize,
}

/// The workspace's folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All source files below a folder of the workspace, in the order of their names.
pub fn below(folder: &str) -> Vec<Source> {
    let mut found = Vec::new();
    visit(&root().join(folder), &mut found);
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

fn visit(folder: &Path, found: &mut Vec<Source>) {
    for entry in fs::read_dir(folder).expect("the workspace has this folder") {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() && !path.ends_with("target") {
            visit(&path, found);
        } else if path.extension().is_some_and(|it| it == "rs") {
            let name = path.strip_prefix(root()).expect("below the workspace").display().to_string();
            found.push(Source { name, text: fs::read_to_string(&path).expect("a readable source") });
        }
    }
}

/// The text with comments, and what stands between quotes, replaced by spaces: lines and braces stay where they are.
pub fn code(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut code = bytes.to_vec();
    let mut at = 0;
    while at < bytes.len() {
        let end = match &bytes[at..] {
            [b'/', b'/', ..] => find(bytes, at, b"\n"),
            [b'/', b'*', ..] => find(bytes, at, b"*/") + 2,
            [b'r', b'"' | b'#', ..] if !continues_word(bytes, at) => raw_string(bytes, at),
            [b'"', ..] => string(bytes, at),
            [b'\'', b'\\', ..] => find(bytes, at + 3, b"'") + 1,
            [b'\'', ..] if character(bytes, at).is_some() => character(bytes, at).unwrap_or(at + 1),
            _ => {
                at += 1;
                continue;
            }
        };
        let end = end.min(bytes.len());
        code[at..end].iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
        at = end;
    }
    String::from_utf8_lossy(&code).into_owned()
}

fn continues_word(bytes: &[u8], at: usize) -> bool {
    at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'_')
}

fn find(bytes: &[u8], from: usize, what: &[u8]) -> usize {
    let from = from.min(bytes.len());
    let found = bytes[from..].windows(what.len()).position(|it| it == what);
    found.map_or(bytes.len(), |at| from + at)
}

/// The end of a string that begins at `at`.
fn string(bytes: &[u8], at: usize) -> usize {
    let mut end = at + 1;
    while end < bytes.len() && bytes[end] != b'"' {
        end += if bytes[end] == b'\\' { 2 } else { 1 };
    }
    end + 1
}

/// The end of a raw string that begins at `at`, or the next byte where none does.
fn raw_string(bytes: &[u8], at: usize) -> usize {
    let hashes = bytes[at + 1..].iter().take_while(|byte| **byte == b'#').count();
    if bytes.get(at + 1 + hashes) != Some(&b'"') {
        return at + 1;
    }
    let close = [b"\"".as_slice(), &vec![b'#'; hashes]].concat();
    find(bytes, at + 2 + hashes, &close) + close.len()
}

/// The end of a character between quotes; lifetimes are none.
fn character(bytes: &[u8], at: usize) -> Option<usize> {
    let end = (2..6).find(|k| bytes.get(at + k) == Some(&b'\''))?;
    let inside = std::str::from_utf8(&bytes[at + 1..at + end]).ok()?;
    (inside.chars().count() == 1).then_some(at + end + 1)
}

/// The position behind the bracket that closes the one at `open`.
pub fn closing(code: &str, open: usize) -> usize {
    let mut depth = 0_usize;
    for (at, byte) in code.bytes().enumerate().skip(open) {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    code.len()
}

/// The code without what is compiled for tests only.
pub fn without_tests(code: &str) -> String {
    let mut rest = code.to_owned();
    while let Some(at) = rest.find("#[cfg(test)]") {
        let item = at + "#[cfg(test)]".len();
        let end = match rest[item..].find(['{', ';']).map(|end| item + end) {
            Some(end) if rest.as_bytes()[end] == b'{' => closing(&rest, end),
            Some(end) => end + 1,
            None => rest.len(),
        };
        let blank: String = rest[at..end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
        rest.replace_range(at..end, &blank);
    }
    rest
}

/// The functions that have a body, in the order in which they begin.
pub fn functions(text: &str) -> Vec<Function> {
    let code = code(text);
    let mut functions = Vec::new();
    for (at, _) in code.match_indices("fn ") {
        let name: String = code[at + 3..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if name.is_empty() || continues_word(code.as_bytes(), at) {
            continue;
        }
        let Some(open) = arguments_open(&code, at + 3 + name.len()) else { continue };
        let close = closing(&code, open);
        let Some(body) = code[close..].find(['{', ';']).map(|body| close + body) else { continue };
        if code.as_bytes()[body] == b'{' {
            let lines = code[at..closing(&code, body)].matches('\n').count() + 1;
            functions.push(Function { name, lines, arguments: count(&code[open + 1..close - 1]) });
        }
    }
    functions
}

/// Where the list of arguments opens behind a function's name: generic parameters may come before.
fn arguments_open(code: &str, from: usize) -> Option<usize> {
    let bytes = code.as_bytes();
    let mut depth = 0_i32;
    for at in from..bytes.len() {
        match bytes[at] {
            b'<' => depth += 1,
            b'>' if bytes[at - 1] != b'-' => depth -= 1,
            b'(' if depth == 0 => return Some(at),
            b'{' | b';' if depth == 0 => return None,
            _ => {}
        }
    }
    None
}

/// Number of arguments in a list, `self` not counted.
fn count(list: &str) -> usize {
    let bytes = list.as_bytes();
    let (mut depth, mut start, mut parts) = (0_i32, 0, Vec::new());
    for at in 0..bytes.len() {
        match bytes[at] {
            b'(' | b'[' | b'{' | b'<' => depth += 1,
            b')' | b']' | b'}' => depth -= 1,
            b'>' if at == 0 || bytes[at - 1] != b'-' => depth -= 1,
            b',' if depth == 0 => {
                parts.push(&list[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[start..]);
    let is_self = |part: &str| part.split(':').next().is_some_and(|name| name.trim().ends_with("self"));
    parts.iter().filter(|part| !part.trim().is_empty() && !is_self(part)).count()
}
