//! Every message that a scene can lead to is a page of the guide, `docs/guide/src/messages.md`, and true.
//!
//! A section of the page opens with the files of a scene that is right and says which command is given with which exit
//! code; every example then changes these files (`-` is replaced by `+`) and tells what the program says. `…`
//! stands for anything. What the program says now is put in by `MPM_WRITE_MESSAGES=1 cargo test -p mpm-cli --test
//! messages`; read it before it is kept.
//!
//! That none is forgotten is found from the sources: every sentence in them that becomes a message must be on the page,
//! or below among those that no scene leads to.

mod common;
#[path = "messages/elsewhere.rs"]
mod elsewhere;

use common::{complains, flat, mpm, workspace};
use elsewhere::ELSEWHERE;
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = "docs/guide/src/messages.md";

/// Files of a scene and what is done with them.
#[derive(Clone, Default)]
struct Section {
    files: Vec<(String, String)>,
    command: Vec<String>,
    code: i32,
}

/// One change of a section's files, and what is said of it.
struct Example {
    title: String,
    section: Section,
    /// What replaces what.
    edits: Vec<(String, String)>,
    command: Vec<String>,
    message: String,
    /// Lines of the page that hold the message.
    lines: std::ops::Range<usize>,
}

/// Whether a line of an example is none of its message.
fn is_head(line: &str) -> bool {
    let mark = line.split(' ').next();
    mark.is_some_and(|mark| ["-", "+", "$"].contains(&mark))
}

fn words(command: &str) -> Vec<String> {
    command.split_whitespace().skip(1).map(str::to_owned).collect()
}

fn read_page(page: &str) -> (Vec<Section>, Vec<Example>) {
    let lines: Vec<&str> = page.lines().collect();
    let (mut sections, mut examples): (Vec<Section>, Vec<Example>) = Default::default();
    let mut title = String::new();
    let mut at = 0;
    while at < lines.len() {
        let line = lines[at];
        at += 1;
        if line.starts_with("## ") {
            sections.push(Section::default());
        } else if let Some(name) = line.strip_prefix("### ") {
            title = name.to_owned();
        } else if let Some((command, rest)) =
            line.split_once("`mpm ").and_then(|(_, rest)| rest.split_once("` ends with exit code "))
        {
            let section = sections.last_mut().expect("commands stand in sections");
            section.command = words(&format!("mpm {command}"));
            section.code = rest.split('.').next().unwrap_or(rest).parse().expect("an exit code");
        } else if let Some(info) = line.strip_prefix("```") {
            let end = at + lines[at..].iter().position(|line| *line == "```").expect("blocks are closed");
            let block = &lines[at..end];
            let section = sections.last_mut().expect("blocks stand in sections");
            match info.split_once(' ') {
                Some((_, name)) => section.files.push((name.to_owned(), block.join("\n") + "\n")),
                None if info == "diff" => {
                    let heads = block.iter().take_while(|line| is_head(line)).count();
                    let mut command = section.command.clone();
                    let mut edits: Vec<[Vec<&str>; 2]> = Vec::new();
                    for head in &block[..heads] {
                        let text = head[1..].strip_prefix(' ').unwrap_or(&head[1..]);
                        match (head.as_bytes()[0], edits.last_mut()) {
                            (b'$', _) => command = words(text),
                            (b'-', Some([from, to])) if to.is_empty() => from.push(text),
                            (b'-', _) => edits.push([vec![text], Vec::new()]),
                            (_, Some([_, to])) => to.push(text),
                            (_, None) => panic!("{title}: `+` stands behind `-`"),
                        }
                    }
                    let edits = edits.iter().map(|[from, to]| (from.join("\n"), to.join("\n"))).collect();
                    let section = section.clone();
                    let message = block[heads..].join("\n");
                    examples.push(Example {
                        title: title.clone(),
                        section,
                        edits,
                        command,
                        message,
                        lines: at + heads..end,
                    });
                }
                None => {}
            }
            at = end + 1;
        }
    }
    (sections, examples)
}

/// A folder with a section's files, changed.
fn folder(files: &[(String, String)], edits: &[(String, String)], title: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut files = files.to_vec();
    for (from, to) in edits {
        let file = files.iter_mut().find(|(_, text)| text.contains(from.as_str()));
        let (_, text) = file.unwrap_or_else(|| panic!("{title}: no file holds `{from}`"));
        *text = text.replacen(from.as_str(), to, 1);
    }
    for (name, text) in &files {
        // The page holds lines, some files do not end with one.
        fs::write(folder.path().join(name), text.replace("␄\n", "")).expect("a file can be written");
    }
    folder
}

/// `file:line:column: path: message`, as far as there are any of it.
fn told(stderr: &str) -> String {
    let mut message = String::new();
    let (mut place, mut path) = (String::new(), String::new());
    for line in stderr.lines() {
        let trimmed = line.trim_start();
        if let Some(rest) = trimmed.strip_prefix(",-[") {
            place = format!("{}: ", rest.trim_end_matches([']', '-']));
        } else if let (Some((_, label)), false) = (line.split_once("`-- "), place.is_empty()) {
            path = format!("{label}: ");
        } else if place.is_empty() {
            message += line.strip_prefix("  x ").or(line.strip_prefix("  | ")).unwrap_or(line);
            message.push('\n');
        }
    }
    format!("{place}{path}{}", message.trim_end())
}

/// Whether `said` is `pattern`, in which `…` stands for anything.
fn is_told(pattern: &str, said: &str) -> bool {
    let mut parts = pattern.split('…');
    let Some(mut rest) = parts.next().and_then(|first| said.strip_prefix(first)) else { return false };
    let parts: Vec<&str> = parts.collect();
    for (k, part) in parts.iter().enumerate() {
        match (k + 1 == parts.len(), rest.find(part)) {
            (true, _) => return rest.ends_with(part),
            (false, Some(at)) => rest = &rest[at + part.len()..],
            (false, None) => return false,
        }
    }
    rest.is_empty()
}

#[test]
fn the_page_tells_what_the_program_says() {
    let file = workspace(PAGE);
    let page = fs::read_to_string(&file).expect("the guide has this page");
    let (_, examples) = read_page(&page);
    assert!(examples.len() > 100, "{} examples", examples.len());
    let mut lines: Vec<String> = page.lines().map(str::to_owned).collect();
    let mut wrong = Vec::new();
    for example in examples.iter().rev() {
        let folder = folder(&example.section.files, &example.edits, &example.title);
        let arguments: Vec<&str> = example.command.iter().map(String::as_str).collect();
        let said = if std::env::var_os("MPM_WRITE_MESSAGES").is_some() {
            let output = mpm(folder.path(), &arguments);
            let code = output.status.code().filter(|code| *code != example.section.code);
            let wrong = code.map_or(String::new(), |code| format!("EXIT CODE {code}\n"));
            wrong + &told(&String::from_utf8_lossy(&output.stderr))
        } else {
            let text = complains(folder.path(), example.section.code, &arguments);
            assert!(text.matches("  x ").count() == 1, "{}: {text}", example.title);
            told(&text)
        };
        if !is_told(&example.message, &said) {
            wrong.push(format!("{}: expected\n{}\ngot\n{said}\n", example.title, example.message));
            lines.splice(example.lines.clone(), said.lines().map(str::to_owned));
        }
    }
    if std::env::var_os("MPM_WRITE_MESSAGES").is_some() {
        fs::write(&file, lines.join("\n") + "\n").expect("the page can be written");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_scenes_of_the_page_are_right() {
    let page = fs::read_to_string(workspace(PAGE)).expect("the guide has this page");
    for section in read_page(&page).0.iter().filter(|section| section.code == 2) {
        let folder = folder(&section.files, &[], "a section");
        let command = if section.command[0] == "drive" { "drive" } else { "check" };
        common::says(folder.path(), &[command, "scene.ron"]);
    }
}

/// Sources whose sentences become messages about scenes.
const SOURCES: &[&str] = &[
    "crates/mpm-grid/src",
    "crates/mpm-geometry/src",
    "crates/mpm-basis/src",
    "crates/mpm-contact/src",
    "crates/mpm-material/src",
    "crates/mpm-assembly/src",
    "crates/mpm-linear/src",
    "crates/mpm-solver/src",
    "crates/mpm-scene/src",
    "crates/mpm-io/src/scene_files",
    "apps/mpm-cli/src/input.rs",
];

/// Every sentence of a source that can become a message: all literals with several words, and whatever
/// `#[error(…)]` holds, but not documentation, tests, and what only a broken program says.
fn sentences(tokens: TokenStream, found: &mut Vec<String>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        let token = &tokens[at];
        at += 1;
        match token {
            TokenTree::Punct(hash) if hash.as_char() == '#' => {
                at += usize::from(tokens.get(at).is_some_and(|it| it.to_string() == "!"));
                let Some(TokenTree::Group(attribute)) = tokens.get(at) else { continue };
                let text = attribute.stream().to_string();
                at += 1;
                if text.starts_with("error") {
                    let mut all = Vec::new();
                    literals(attribute.stream(), &mut all);
                    found.extend(all.into_iter().next());
                } else if text.starts_with("cfg") && text.contains("test") {
                    // The item that only tests have.
                    while let Some(token) = tokens.get(at) {
                        at += 1;
                        let brace = matches!(token, TokenTree::Group(it) if it.delimiter() == Delimiter::Brace);
                        if brace || matches!(token, TokenTree::Punct(it) if it.as_char() == ';') {
                            break;
                        }
                    }
                }
            }
            TokenTree::Ident(name) => {
                let name = name.to_string();
                // Behind a macro's name stands `!`.
                let arguments = at + usize::from(tokens.get(at).is_some_and(|it| it.to_string() == "!"));
                let is_inner = name == "expect"
                    || name.contains("assert")
                    || ["unreachable", "panic", "json_schema"].contains(&name.as_str());
                if is_inner && matches!(tokens.get(arguments), Some(TokenTree::Group(_))) {
                    at = arguments + 1;
                }
            }
            TokenTree::Group(group) => sentences(group.stream(), found),
            TokenTree::Literal(literal) => found.extend(string(literal).filter(|it| is_sentence(it))),
            TokenTree::Punct(_) => {}
        }
    }
}

fn literals(tokens: TokenStream, found: &mut Vec<String>) {
    for token in tokens {
        match token {
            TokenTree::Group(group) => literals(group.stream(), found),
            TokenTree::Literal(literal) => found.extend(string(&literal)),
            _ => {}
        }
    }
}

fn string(literal: &proc_macro2::Literal) -> Option<String> {
    syn::parse_str::<syn::LitStr>(&literal.to_string()).ok().map(|it| it.value())
}

/// The parts of a format string between what is put in.
fn parts(format: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let (mut depth, mut characters) = (0, format.chars().peekable());
    while let Some(c) = characters.next() {
        match c {
            '{' | '}' if characters.peek() == Some(&c) && depth == 0 => {
                characters.next();
                parts.last_mut().expect("one at least").push(c);
            }
            '{' => {
                depth += 1;
                parts.push(String::new());
            }
            '}' => depth -= 1,
            c if depth == 0 => parts.last_mut().expect("one at least").push(c),
            _ => {}
        }
    }
    parts
}

fn is_sentence(text: &str) -> bool {
    let plain = parts(text).concat();
    let words = plain.split_whitespace().filter(|word| word.chars().filter(|c| c.is_alphabetic()).count() > 1);
    words.count() >= 2
}

/// Whether a message can have been made of a format string.
fn is_made_of(message: &str, format: &str) -> bool {
    let mut rest = message;
    parts(&flat(format)).iter().all(|part| {
        let found = rest.find(part.as_str());
        rest = found.map_or("", |at| &rest[at + part.len()..]);
        found.is_some()
    })
}

fn sources(path: &Path, found: &mut Vec<PathBuf>) {
    if path.is_dir() {
        let mut entries: Vec<PathBuf> =
            fs::read_dir(path).expect("a source folder").map(|entry| entry.expect("an entry").path()).collect();
        entries.sort();
        entries.iter().for_each(|entry| sources(entry, found));
    } else if path.extension().is_some_and(|it| it == "rs") && !path.ends_with("tests.rs") {
        found.push(path.to_owned());
    }
}

#[test]
fn no_message_is_forgotten() {
    let page = fs::read_to_string(workspace(PAGE)).expect("the guide has this page");
    let (_, examples) = read_page(&page);
    let messages: Vec<String> = examples.iter().map(|example| flat(&example.message)).collect();
    let mut files = Vec::new();
    SOURCES.iter().for_each(|source| sources(&workspace(source), &mut files));
    let mut used = vec![false; ELSEWHERE.len()];
    let mut count = 0;
    let mut forgotten = Vec::new();
    for file in &files {
        let text = fs::read_to_string(file).expect("a source file");
        let mut found = Vec::new();
        sentences(text.parse().expect("a source file is Rust"), &mut found);
        let name = file.strip_prefix(workspace("")).expect("in the workspace").display().to_string();
        for sentence in found {
            count += 1;
            let is_here = messages.iter().any(|message| is_made_of(message, &sentence));
            let elsewhere = ELSEWHERE
                .iter()
                .position(|(place, begin, _)| name.contains(place) && flat(&sentence).starts_with(begin));
            match (is_here, elsewhere) {
                (true, _) => {}
                (false, Some(k)) => used[k] = true,
                (false, None) => forgotten.push(format!("{name}: {}", flat(&sentence))),
            }
        }
    }
    assert!(count > 100, "{count} sentences in {files:?}");
    assert!(forgotten.is_empty(), "on no page:\n{}", forgotten.join("\n"));
    let unused: Vec<_> = ELSEWHERE.iter().zip(used).filter(|(_, used)| !used).map(|(it, _)| it).collect();
    assert!(unused.is_empty(), "no longer needed: {unused:?}");
}
