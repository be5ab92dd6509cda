//! Scenes that are almost right: changes of their words, numbers, groups, and characters.

use super::random::Random;

/// Numbers that are likely to be wrong somewhere.
pub(super) const EXTREMES: &[&str] = &[
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "7",
    "40",
    "41",
    "128",
    "255",
    "256",
    "1000",
    "65536",
    "1000000",
    "16777217",
    "1000000000",
    "2147483648",
    "4294967294",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "340282366920938463463374607431768211456",
    "NaN",
    "-NaN",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1.7976931348623157e308",
    "1e-308",
    "5e-324",
    "-5e-324",
    "1e-300",
    "1e300",
    "1e154",
    "1e-154",
    "1e16",
    "1e-16",
    "1e9",
    "1e-9",
    "0.5",
    "0.49999999999999994",
    "0.1",
    "-0.5",
    "1e999",
    "1_000",
    "0x10",
    "0b1",
    "1.",
    ".5",
    "-",
];

/// Texts that are likely to be wrong somewhere.
const TEXTS: &[&str] = &[
    "\"\"",
    "\"a/b\"",
    "\"\\u{0}\"",
    "\"\\\"\"",
    "\"größe 木 🦀\"",
    "r#\"raw\"#",
    "\"unclosed",
    "'c'",
    "\"\\xff\"",
    "\"\\q\"",
    "/* */",
    "/*",
    "//",
    "()",
    "[]",
    "{}",
    "Some(1)",
    "None",
    "true",
    "#![enable(unwrap_newtypes)]",
    "\u{feff}",
    "\u{0}",
    "\u{202e}",
];

/// How deep groups are nested.
const DEPTHS: &[usize] = &[1, 2, 10, 100, 127, 128, 129, 1000, 20_000];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number,
    Word,
    Text,
    Open,
    Close,
    Other,
}

#[derive(Clone)]
struct Token {
    kind: Kind,
    text: String,
}

/// The scenes that changes start from, and the words that they take from each other.
pub(super) struct Corpus {
    scenes: Vec<Vec<Token>>,
    words: Vec<String>,
    texts: Vec<String>,
}

impl Corpus {
    pub(super) fn new<'a>(scenes: impl IntoIterator<Item = &'a str>) -> Self {
        let scenes: Vec<Vec<Token>> = scenes.into_iter().map(tokens).collect();
        let of = |kind| {
            let mut all: Vec<String> =
                scenes.iter().flatten().filter(|it| it.kind == kind).map(|it| it.text.clone()).collect();
            all.sort();
            all.dedup();
            all
        };
        let (words, texts) = (of(Kind::Word), of(Kind::Text));
        Self { scenes, words, texts }
    }

    /// With more words.
    pub(super) fn with_words(mut self, words: &[&str]) -> Self {
        self.words.extend(words.iter().map(|&it| it.to_owned()));
        self
    }

    /// Whether a word is among those that changes put in.
    #[cfg(test)]
    pub(super) fn says(&self, word: &str) -> bool {
        self.words.iter().any(|it| it == word)
    }

    /// One of the scenes, changed here and there.
    pub(super) fn changed(&self, random: &mut Random) -> Vec<u8> {
        let mut tokens = random.pick(&self.scenes).cloned().unwrap_or_default();
        let mut changes = 1;
        while random.below(3) == 0 && changes < 8 {
            changes += 1;
        }
        let mut raw = false;
        for _ in 0..changes {
            match random.below(24) {
                0..=9 => number(&mut tokens, random),
                10..=12 => self.word(&mut tokens, random),
                13 => self.text(&mut tokens, random),
                14 => drop(remove(&mut tokens, random)),
                15 => duplicate(&mut tokens, random),
                16 => swap(&mut tokens, random),
                17 | 18 => remove_group(&mut tokens, random),
                19 => duplicate_group(&mut tokens, random),
                20 | 21 => self.graft(&mut tokens, random),
                22 => nest(&mut tokens, random),
                _ => raw = true,
            }
        }
        let mut bytes: Vec<u8> = tokens.iter().flat_map(|it| it.text.bytes()).collect();
        if raw {
            super::bytes::change(&mut bytes, random);
        }
        bytes
    }

    fn word(&self, tokens: &mut [Token], random: &mut Random) {
        if let (Some(at), Some(word)) = (one_of(tokens, Kind::Word, random), random.pick(&self.words)) {
            tokens[at].text.clone_from(word);
        }
    }

    fn text(&self, tokens: &mut [Token], random: &mut Random) {
        let Some(at) = one_of(tokens, Kind::Text, random) else { return };
        tokens[at].text = match random.below(4) {
            0 => format!("\"{}\"", "long ".repeat(1 << random.below(16))),
            1 => (*random.pick(TEXTS).expect("there are texts")).into(),
            _ => random.pick(&self.texts).cloned().unwrap_or_default(),
        };
    }

    /// A group in place of another that opens alike.
    fn graft(&self, tokens: &mut Vec<Token>, random: &mut Random) {
        let Some(other) = random.pick(&self.scenes) else { return };
        let (Some(from), Some(to)) = (group(other, random), group(tokens, random)) else { return };
        if other[from.start].text == tokens[to.start].text {
            tokens.splice(to, other[from].iter().cloned());
        }
    }
}

fn one_of(tokens: &[Token], kind: Kind, random: &mut Random) -> Option<usize> {
    let places: Vec<usize> = (0..tokens.len()).filter(|&k| tokens[k].kind == kind).collect();
    random.pick(&places).copied()
}

fn number(tokens: &mut [Token], random: &mut Random) {
    let Some(at) = one_of(tokens, Kind::Number, random) else { return };
    let before = tokens[at].text.parse::<f64>().unwrap_or(1.0);
    tokens[at].text = match random.below(8) {
        0 => format!("{}", -before),
        1 => format!("{}", before * 2.0),
        2 => format!("{}", before * 0.5),
        3 => format!("{}", before + 1.0),
        4 => format!("{}", before * (1.0 + 1e-9)),
        5 => format!("{:e}", before * 10_f64.powi(random.below(61) as i32 - 30)),
        _ => (*random.pick(EXTREMES).expect("there are numbers")).into(),
    };
}

fn remove(tokens: &mut Vec<Token>, random: &mut Random) -> Option<Token> {
    (!tokens.is_empty()).then(|| tokens.remove(random.below(tokens.len())))
}

fn duplicate(tokens: &mut Vec<Token>, random: &mut Random) {
    if let Some(token) = random.pick(tokens).cloned() {
        tokens.insert(random.below(tokens.len() + 1), token);
    }
}

fn swap(tokens: &mut [Token], random: &mut Random) {
    if !tokens.is_empty() {
        tokens.swap(random.below(tokens.len()), random.below(tokens.len()));
    }
}

fn remove_group(tokens: &mut Vec<Token>, random: &mut Random) {
    if let Some(group) = group(tokens, random) {
        tokens.drain(group);
    }
}

fn duplicate_group(tokens: &mut Vec<Token>, random: &mut Random) {
    let Some(group) = group(tokens, random) else { return };
    let mut copy = tokens[group.clone()].to_vec();
    // At most some hundred times as much text.
    let times = if copy.len() < 200 { 1 << random.below(7) } else { 1 };
    copy.insert(0, Token { kind: Kind::Other, text: ", ".into() });
    for _ in 0..times {
        tokens.splice(group.end..group.end, copy.iter().cloned());
    }
}

fn nest(tokens: &mut Vec<Token>, random: &mut Random) {
    let Some(group) = group(tokens, random) else { return };
    let depth = *random.pick(DEPTHS).expect("there are depths");
    let (open, close) = *random
        .pick(&[
            ("(", ")"),
            ("[", "]"),
            ("{", "}"),
            ("All([", "])"),
            ("Some(", ")"),
            ("{\"a\":", "}"),
            ("/*", "*/"),
            ("[", ""),
        ])
        .expect("there are brackets");
    let repeated = |text: &str| Token { kind: Kind::Other, text: text.repeat(depth) };
    tokens.insert(group.end, repeated(close));
    tokens.insert(group.start, repeated(open));
}

/// A bracket, what it holds, and the bracket that closes it.
fn group(tokens: &[Token], random: &mut Random) -> Option<std::ops::Range<usize>> {
    let start = one_of(tokens, Kind::Open, random)?;
    let mut depth = 0_usize;
    for (k, token) in tokens.iter().enumerate().skip(start) {
        match token.kind {
            Kind::Open => depth += 1,
            Kind::Close => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(start..k + 1);
        }
    }
    None
}

fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let until = |end: fn(char) -> bool| rest.find(end).unwrap_or(rest.len());
        let (kind, length) = match first {
            '(' | '[' | '{' => (Kind::Open, 1),
            ')' | ']' | '}' => (Kind::Close, 1),
            '"' => (Kind::Text, rest[1..].find('"').map_or(rest.len(), |end| end + 2)),
            '/' if rest.starts_with("//") => (Kind::Other, rest.find('\n').unwrap_or(rest.len())),
            it if it.is_whitespace() => (Kind::Other, until(|c| !c.is_whitespace())),
            it if it.is_ascii_digit() || "+-.".contains(it) => {
                (Kind::Number, until(|c| !(c.is_ascii_alphanumeric() || "+-._".contains(c))))
            }
            it if it.is_alphabetic() || it == '_' => {
                (Kind::Word, until(|c| !(c.is_alphanumeric() || c == '_')))
            }
            it => (Kind::Other, it.len_utf8()),
        };
        let (token, behind) = rest.split_at(length.max(1));
        tokens.push(Token { kind, text: token.into() });
        rest = behind;
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_its_tokens_and_changes_are_those_of_the_case() {
        let scene = "PlaneStrain( // größe\n  at: [(-1.5e3, \"a b\")], x: 木)";
        let all = tokens(scene);
        assert_eq!(all.iter().map(|it| it.text.as_str()).collect::<String>(), scene);
        let numbers: Vec<&str> =
            all.iter().filter(|it| it.kind == Kind::Number).map(|it| it.text.as_str()).collect();
        assert_eq!(numbers, ["-1.5e3"]);
        let corpus = Corpus::new([scene]);
        let changed = |case| corpus.changed(&mut Random::of_case(1, case));
        assert_eq!(changed(5), changed(5));
        let differ = (0..100).filter(|&case| changed(case) != scene.as_bytes()).count();
        assert!(differ > 80, "{differ}");
    }
}
