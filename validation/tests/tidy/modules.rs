//! The modules of a crate and which of them use which.

use crate::source::{Source, closing, code, without_tests};
use std::collections::{BTreeMap, BTreeSet};

/// A path in code: its segments, and the name under which it is known there.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Import {
    path: Vec<String>,
    name: String,
    /// Whether others see it here, too.
    is_public: bool,
}

/// A module: its own file.
struct Module {
    imports: Vec<Import>,
    /// Its code without imports.
    body: String,
}

/// The modules of a crate by their paths; that of the root is empty.
pub struct Modules(BTreeMap<Vec<String>, Module>);

impl Modules {
    /// Of the sources below a crate's folder `src`; files of tests are left out.
    pub fn of(folder: &str, sources: &[Source]) -> Self {
        let mut modules = BTreeMap::new();
        for source in sources {
            let Some(file) = source.name.strip_prefix(&format!("{folder}/src/")) else { continue };
            let mut path: Vec<String> = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
            if path[0] == "bin" || path.iter().any(|segment| segment == "tests") {
                continue;
            }
            if ["mod", "lib", "main"].contains(&path[path.len() - 1].as_str()) {
                path.pop();
            }
            let (imports, body) = imports(&without_tests(&code(&source.text)));
            modules.insert(path, Module { imports, body });
        }
        Self(modules)
    }

    /// For every module those that it uses. Handing on the name of an item is no use of it, and whoever uses an item by
    /// such a name uses the module in which it stands.
    pub fn arrows(&self) -> BTreeMap<String, BTreeSet<String>> {
        let arrow = |own: &Vec<String>, module: &Module| {
            let mut used = BTreeSet::new();
            for import in &module.imports {
                if import.is_public && !mentions(&module.body, &import.name) {
                    continue;
                }
                match self.resolve(own, &import.path, 0) {
                    Some(target) if self.absolute(own, &import.path).as_ref() == Some(&target) => {
                        // A module by its name: what counts are the items that are used of it.
                        let items = qualified(&module.body, &import.name);
                        let of_items = items.iter().filter_map(|item| {
                            let path = [&import.path[..], std::slice::from_ref(item)].concat();
                            self.resolve(own, &path, 0)
                        });
                        used.extend(of_items);
                    }
                    target => used.extend(target),
                }
            }
            for path in paths(&module.body) {
                let is_local = matches!(path[0].as_str(), "crate" | "super" | "self");
                let is_child = self.0.contains_key(&[&own[..], &path[..1]].concat());
                if is_local || is_child {
                    used.extend(self.resolve(own, &path, 0));
                }
            }
            used.remove(own);
            (own.join("::"), used.iter().map(|path| path.join("::")).collect())
        };
        self.0.iter().map(|(own, module)| arrow(own, module)).collect()
    }

    /// The path from the root; `None` where it leads out of the crate.
    fn absolute(&self, own: &[String], path: &[String]) -> Option<Vec<String>> {
        let mut base = own.to_vec();
        let mut rest = path;
        match rest.first()?.as_str() {
            "crate" => {
                base.clear();
                rest = &rest[1..];
            }
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|segment| segment == "super") {
                    base.pop()?;
                    rest = &rest[1..];
                }
            }
            first => {
                base.push(first.to_owned());
                if !self.0.contains_key(&base) {
                    return None;
                }
                rest = &rest[1..];
            }
        }
        base.extend_from_slice(rest);
        Some(base)
    }

    /// The module in which the item stands that a path in module `own` leads to.
    fn resolve(&self, own: &[String], path: &[String], depth: usize) -> Option<Vec<String>> {
        let absolute = self.absolute(own, path)?;
        let known = (0..=absolute.len()).rev().find(|&n| self.0.contains_key(&absolute[..n]))?;
        let (module, item) = (&absolute[..known], absolute.get(known));
        let Some(item) = item else { return Some(module.to_vec()) };
        let handed_on =
            self.0[module].imports.iter().filter(|import| import.name == *item || import.name == "*");
        let found = handed_on.filter(|_| depth < 8).find_map(|import| {
            let mut path = import.path.clone();
            if import.name == "*" {
                path.push(item.clone());
            }
            self.resolve(module, &path, depth + 1)
        });
        Some(found.unwrap_or_else(|| module.to_vec()))
    }
}

/// Groups of modules that all use one another, directly or by way of others.
pub fn circles(arrows: &BTreeMap<String, BTreeSet<String>>) -> Vec<BTreeSet<String>> {
    let reached: BTreeMap<&String, BTreeSet<&String>> = arrows
        .keys()
        .map(|from| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
            while let Some(at) = open.pop() {
                open.extend(arrows.get(at).into_iter().flatten().filter(|next| seen.insert(*next)));
            }
            (from, seen)
        })
        .collect();
    let mut circles: Vec<BTreeSet<String>> = Vec::new();
    for (from, seen) in &reached {
        if seen.contains(*from) && !circles.iter().any(|circle| circle.contains(*from)) {
            let both = seen.iter().filter(|it| reached.get(**it).is_some_and(|back| back.contains(*from)));
            circles.push(both.map(|it| (*it).clone()).collect());
        }
    }
    circles
}

/// The imports of a module, and the rest of its code.
fn imports(code: &str) -> (Vec<Import>, String) {
    let (mut imports, mut body) = (Vec::new(), code.to_owned());
    let mut from = 0;
    while let Some(at) = body[from..].find("use ").map(|at| from + at) {
        let line = body[..at].rfind('\n').map_or(0, |line| line + 1);
        let before = body[line..at].trim();
        let is_statement =
            before.is_empty() || before == "pub" || (before.starts_with("pub(") && before.ends_with(')'));
        let Some(end) = body[at..].find(';').map(|end| at + end).filter(|_| is_statement) else {
            from = at + 4;
            continue;
        };
        leaves(&body[at + 4..end], &[], !before.is_empty(), &mut imports);
        let blank: String = body[line..=end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
        body.replace_range(line..=end, &blank);
        from = end;
    }
    (imports, body)
}

/// The leaves of a tree of imports.
fn leaves(tree: &str, above: &[String], is_public: bool, found: &mut Vec<Import>) {
    let tree = tree.trim();
    if let Some(open) = tree.find('{') {
        let mut path = above.to_vec();
        path.extend(tree[..open].split("::").map(str::trim).filter(|it| !it.is_empty()).map(str::to_owned));
        let inside = &tree[open + 1..closing(tree, open) - 1];
        let (mut depth, mut start) = (0_i32, 0);
        for (at, byte) in inside.bytes().enumerate().chain([(inside.len(), b',')]) {
            match byte {
                b'{' => depth += 1,
                b'}' => depth -= 1,
                b',' if depth == 0 => {
                    leaves(&inside[start..at], &path, is_public, found);
                    start = at + 1;
                }
                _ => {}
            }
        }
    } else if !tree.is_empty() {
        let (path, alias) = tree.split_once(" as ").map_or((tree, None), |(path, alias)| (path, Some(alias)));
        let mut all = above.to_vec();
        all.extend(path.split("::").map(|it| it.trim().to_owned()));
        if all.len() > 1 && all[all.len() - 1] == "self" {
            all.pop();
        }
        let name = alias.map_or_else(|| all[all.len() - 1].clone(), |alias| alias.trim().to_owned());
        if name == "*" {
            all.pop();
        }
        found.push(Import { path: all, name, is_public });
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether a name stands somewhere in code.
fn mentions(code: &str, name: &str) -> bool {
    code.match_indices(name)
        .any(|(at, _)| !code[..at].ends_with(is_word) && !code[at + name.len()..].starts_with(is_word))
}

/// The names that stand behind `name::` in code.
fn qualified(code: &str, name: &str) -> BTreeSet<String> {
    paths(code)
        .into_iter()
        .filter(|path| path[0] == name && path.len() > 1)
        .map(|path| path[1].clone())
        .collect()
}

/// All paths of several segments in code.
fn paths(code: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find(is_word) {
        rest = &rest[at..];
        let mut path = Vec::new();
        loop {
            let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            path.push(rest[..end].to_owned());
            rest = &rest[end..];
            match rest.strip_prefix("::") {
                Some(next) if next.starts_with(is_word) => rest = next,
                _ => break,
            }
        }
        if path.len() > 1 {
            paths.push(path);
        }
    }
    paths
}
