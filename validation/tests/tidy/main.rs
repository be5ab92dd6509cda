//! What keeps the sources readable: short files and functions, few arguments, no circle of modules.

mod exceptions;
mod modules;
mod source;

use exceptions::{CIRCLES, LONG_FILES, LONG_FUNCTIONS, MANY_ARGUMENTS};
use modules::{Modules, circles};
use source::{Source, below, code, functions, root};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Lines of a file at most.
const FILE: usize = 450;
/// Lines of a function at most.
const FUNCTION: usize = 80;
/// Arguments of a function at most, `self` not counted.
const ARGUMENTS: usize = 6;

const FOLDERS: [&str; 5] = ["crates", "apps", "validation", "benchmarks", "examples"];

fn all() -> Vec<Source> {
    FOLDERS.iter().flat_map(|folder| below(folder)).collect()
}

/// Compares what was found with the exceptions: all that was found must be listed, and all that is listed found.
fn compare(rule: &str, found: &BTreeMap<String, String>, listed: &[(&str, &str)]) {
    let listed: BTreeSet<&str> = listed.iter().map(|(what, _reason)| *what).collect();
    let new: Vec<String> = found
        .iter()
        .filter(|(what, _)| !listed.contains(what.as_str()))
        .map(|(a, b)| format!("{a}: {b}"))
        .collect();
    assert!(new.is_empty(), "{rule}; shorten these, or list them with a reason:\n{}", new.join("\n"));
    let gone: Vec<&&str> = listed.iter().filter(|what| !found.contains_key(**what)).collect();
    assert!(gone.is_empty(), "{rule}; these exceptions are no longer needed, delete them: {gone:#?}");
}

#[test]
fn files_are_short() {
    let lines = |source: &Source| source.text.lines().count();
    let long = all().into_iter().filter(|it| lines(it) > FILE);
    let found = long.map(|it| (it.name.clone(), format!("{} lines", lines(&it)))).collect();
    compare(&format!("a file has at most {FILE} lines"), &found, LONG_FILES);
}

#[test]
fn functions_are_short_and_have_few_arguments() {
    let (mut long, mut many) = (BTreeMap::new(), BTreeMap::new());
    let mut count = 0;
    for source in all() {
        for function in functions(&source.text) {
            count += 1;
            let name = format!("{} {}", source.name, function.name);
            if function.lines > FUNCTION {
                long.insert(name.clone(), format!("{} lines", function.lines));
            }
            if function.arguments > ARGUMENTS {
                many.insert(name, format!("{} arguments", function.arguments));
            }
        }
    }
    assert!(count > 1000, "{count} functions");
    compare(&format!("a function has at most {FUNCTION} lines"), &long, LONG_FUNCTIONS);
    compare(&format!("a function has at most {ARGUMENTS} arguments"), &many, MANY_ARGUMENTS);
}

#[test]
fn modules_form_no_circle() {
    let mut found = BTreeMap::new();
    for group in ["crates", "apps"] {
        for entry in fs::read_dir(root().join(group)).expect("the workspace has this folder") {
            let name = entry.expect("a readable folder").file_name().to_string_lossy().into_owned();
            let folder = format!("{group}/{name}");
            let arrows = Modules::of(&folder, &below(&folder)).arrows();
            assert!(arrows.len() > 1, "{folder} has modules");
            for circle in circles(&arrows) {
                let uses = |module: &String| {
                    let used: Vec<&str> = arrows[module].intersection(&circle).map(String::as_str).collect();
                    format!("{module} uses {}", used.join(", "))
                };
                let how: Vec<String> = circle.iter().map(uses).collect();
                found
                    .entry(name.clone())
                    .or_insert_with(String::new)
                    .push_str(&format!("\n    {}", how.join("; ")));
            }
        }
    }
    compare("modules that use one another cannot be read apart", &found, CIRCLES);
}

#[test]
fn code_is_told_from_text() {
    let text = "fn a(x: &'static str) { // fn b() {\n    \"fn c() {\"; 'x'; r#\"fn \"d\"() {\"#; '\\''\n}\n";
    assert_eq!(code(text).matches("fn ").count(), 1);
    assert_eq!(code(text).lines().count(), text.lines().count());
    let text = "fn f<F: Fn(u8, u8) -> u8>(&mut self, f: F, (a, b): (u8, [u8; 2]),\n) -> u8 {\n}\ntrait T { fn g(&self); }\n";
    let [f] = &functions(text)[..] else { panic!("one function has a body") };
    assert_eq!((f.name.as_str(), f.lines, f.arguments), ("f", 3, 2));
}

#[test]
fn circles_are_found_behind_names_that_are_handed_on() {
    let source = |name: &str, text: &str| Source { name: format!("a/src/{name}.rs"), text: text.to_owned() };
    let circles_of = |sources: &[Source]| circles(&Modules::of("a", sources).arrows());
    // The root hands on names alone.
    let mut sources = vec![
        source("lib", "mod b;\nmod c;\npub use b::B;\npub use c::{self, C};\n"),
        source("b", "use crate::C;\npub struct B(C);\n"),
        source("c", "pub struct C;\n#[cfg(test)]\nmod tests {\n    use crate::B;\n}\n"),
    ];
    assert!(circles_of(&sources).is_empty());
    sources[2] = source("c", "use crate::{\n    B,\n};\npub struct C;\nfn f(_: B) {}\n");
    assert_eq!(circles_of(&sources), [BTreeSet::from(["b".to_owned(), "c".to_owned()])]);
    // A parent that uses its child, and a child that uses what its parent defines.
    let sources = [
        source("lib", "mod d;\n"),
        source("d/mod", "mod e;\npub struct D;\nfn f() { e::g() }\n"),
        source("d/e", "use super::D;\npub fn g() -> D { D }\n"),
    ];
    assert_eq!(circles_of(&sources), [BTreeSet::from(["d".to_owned(), "d::e".to_owned()])]);
}
