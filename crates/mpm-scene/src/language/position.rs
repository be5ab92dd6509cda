//! Where in a scene's text a field stands.
//!
//! The reader reports the place of what it cannot read. What is wrong only in the light of the whole
//! scene is known by its path, `supports[1].region`; this finds the path's place by walking the text.

/// A place in a text, both numbers from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line.
    pub line: usize,
    /// Column, in characters.
    pub column: usize,
}

impl Position {
    /// The place of the byte at `offset`, which lies on the border of a character.
    pub fn of(text: &str, offset: usize) -> Self {
        place(text, offset)
    }

    /// The byte at this place; the end of the line or text where the place lies beyond it.
    pub fn offset(self, text: &str) -> usize {
        let line_start = match self.line {
            0 | 1 => 0,
            line => text.match_indices('\n').nth(line - 2).map_or(text.len(), |(newline, _)| newline + 1),
        };
        let line = text[line_start..].split('\n').next().unwrap_or_default();
        let column = line.char_indices().nth(self.column.saturating_sub(1)).map_or(line.len(), |(at, _)| at);
        line_start + column
    }
}

/// Start and end of the value at `path` in a RON text that is known to be well formed.
///
/// A path is what field names and list indices it takes to get there, `bodies[0].shape.from`; names
/// of enum variants are not part of it, keys of maps are written like fields. A path whose last part
/// is missing from the text (a field left to its default) gives its parent.
pub fn position_of(text: &str, path: &str) -> Option<(Position, Position)> {
    let mut walk = Walk { text, at: 0 };
    walk.space();
    for part in parts(path) {
        let before = walk.at;
        if walk.enter(part).is_none() {
            walk.at = before;
            break;
        }
    }
    let start = walk.at;
    walk.skip_value()?;
    Some((place(text, start), place(text, walk.at)))
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Part<'a> {
    Field(&'a str),
    Index(usize),
}

impl<'a> Part<'a> {
    /// Its name, if it has one.
    pub(super) fn name(self) -> Option<&'a str> {
        match self {
            Part::Field(name) => Some(name),
            Part::Index(_) => None,
        }
    }
}

fn parts(path: &str) -> impl Iterator<Item = Part<'_>> {
    path.split(['.', '[']).filter(|part| !part.is_empty()).map(|part| match part.strip_suffix(']') {
        Some(index) => Part::Index(index.parse().unwrap_or(0)),
        None => Part::Field(part),
    })
}

fn place(text: &str, at: usize) -> Position {
    let before = &text[..at];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    Position { line: before.matches('\n').count() + 1, column: before[line_start..].chars().count() + 1 }
}

pub(super) struct Walk<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
}

/// What a value holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Inside {
    /// Named fields; the first one begins at this byte.
    Fields(Vec<String>, usize),
    /// Entries of a map, by name.
    Entries(Vec<String>),
    /// So many values in a row.
    List(usize),
    /// Nothing that could be told apart.
    Nothing,
}

impl Walk<'_> {
    pub(super) fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn next(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Skips white space, comments and `#![…]` attributes.
    pub(super) fn space(&mut self) {
        loop {
            let rest = self.rest();
            let skipped = if let Some(comment) = rest.strip_prefix("//") {
                2 + comment.find('\n').unwrap_or(comment.len())
            } else if rest.starts_with("/*") {
                let (mut depth, mut end) = (0, 0);
                let bytes = rest.as_bytes();
                while end < bytes.len() {
                    if bytes[end..].starts_with(b"/*") {
                        (depth, end) = (depth + 1, end + 2);
                    } else if bytes[end..].starts_with(b"*/") {
                        (depth, end) = (depth - 1, end + 2);
                    } else {
                        end += 1;
                    }
                    if depth == 0 {
                        break;
                    }
                }
                end
            } else if rest.starts_with("#![") {
                rest.find(']').map_or(rest.len(), |end| end + 1)
            } else {
                rest.len() - rest.trim_start().len()
            };
            if skipped == 0 {
                return;
            }
            self.at += skipped;
        }
    }

    /// Skips `c` and the space after it.
    fn token(&mut self, c: char) -> Option<()> {
        if self.next() != Some(c) {
            return None;
        }
        self.at += c.len_utf8();
        self.space();
        Some(())
    }

    /// Skips an identifier; empty where there is none.
    fn identifier(&mut self) -> String {
        let word: String = self.rest().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        self.at += word.len();
        word
    }

    fn string(&mut self) -> Option<String> {
        let raw = self.rest().strip_prefix('r').map(|rest| rest.chars().take_while(|c| *c == '#').count());
        if let Some(hashes) = raw.filter(|n| self.rest()[1 + n..].starts_with('"')) {
            let close = format!("\"{}", "#".repeat(hashes));
            let start = self.at + hashes + 2;
            let length = self.text[start..].find(&close)?;
            self.at = start + length + close.len();
            return Some(self.text[start..start + length].to_string());
        }
        let mut content = String::new();
        let mut characters = self.rest().char_indices();
        if characters.next()?.1 != '"' {
            return None;
        }
        let mut escaped = false;
        for (offset, c) in characters {
            match c {
                _ if escaped => escaped = false,
                '\\' => escaped = true,
                '"' => {
                    self.at += offset + 1;
                    return Some(content);
                }
                _ => {}
            }
            content.push(c);
        }
        None
    }

    /// Skips one value and the space after it is left alone.
    pub(super) fn skip_value(&mut self) -> Option<()> {
        if self.string().is_some() {
            return Some(());
        }
        match self.next()? {
            '(' | '[' | '{' => self.skip_bracket(),
            '\'' => {
                let escape = usize::from(self.rest()[1..].starts_with('\\'));
                let close = self.rest()[1 + escape..].char_indices().nth(1)?.0;
                self.at += 1 + escape + close + 1;
                Some(())
            }
            _ => {
                let length = self.rest().find(|c: char| ",()[]{}:/".contains(c) || c.is_whitespace());
                let length = length.unwrap_or(self.rest().len());
                if length == 0 {
                    return None;
                }
                self.at += length;
                let end = self.at;
                self.space();
                if self.next() == Some('(') {
                    return self.skip_bracket();
                }
                self.at = end;
                Some(())
            }
        }
    }

    fn skip_bracket(&mut self) -> Option<()> {
        self.at += 1;
        self.space();
        while !matches!(self.next()?, ')' | ']' | '}') {
            if self.next() == Some(',') || self.next() == Some(':') {
                self.at += 1;
            } else {
                self.skip_value()?;
            }
            self.space();
        }
        self.at += 1;
        Some(())
    }

    /// What the value at the present place holds; the place is left anywhere inside it.
    pub(super) fn inside(&mut self) -> Option<Inside> {
        if !matches!(self.next()?, '(' | '[' | '{' | '"') {
            self.identifier();
            self.space();
        }
        let Some(open @ ('(' | '[' | '{')) = self.next() else { return Some(Inside::Nothing) };
        self.token(open)?;
        let is_list = open == '[' || (open == '(' && self.next() == Some('['));
        if is_list && open == '(' {
            self.token('[')?;
        }
        let first = self.at;
        let (mut names, mut values) = (Vec::new(), 0);
        while !matches!(self.next()?, ')' | ']' | '}') {
            let start = self.at;
            let key = match self.string() {
                Some(key) => key,
                None => self.identifier(),
            };
            self.space();
            if !is_list && self.token(':').is_some() {
                names.push(key);
            } else {
                self.at = start;
            }
            self.skip_value()?;
            values += 1;
            self.space();
            if self.next() == Some(',') {
                self.token(',')?;
            }
        }
        Some(match open {
            '{' => Inside::Entries(names),
            '(' if !is_list && names.len() == values => Inside::Fields(names, first),
            _ => Inside::List(values),
        })
    }

    /// Steps into the value at the present place, to its field or entry.
    pub(super) fn enter(&mut self, part: Part<'_>) -> Option<()> {
        if !matches!(self.next()?, '(' | '[' | '{' | '"') {
            self.identifier();
            self.space();
        }
        let open = self.next()?;
        self.token(open)?;
        // `Variant([…])` holds its list one bracket deeper.
        if let (Part::Index(_), '(', Some('[')) = (part, open, self.next()) {
            self.token('[')?;
        }
        let mut index = 0;
        loop {
            if matches!(self.next()?, ')' | ']' | '}') {
                return None;
            }
            match part {
                Part::Index(wanted) => {
                    if index == wanted {
                        return Some(());
                    }
                    self.skip_value()?;
                }
                Part::Field(name) => {
                    let key = match self.string() {
                        Some(key) => key,
                        None => self.identifier(),
                    };
                    self.space();
                    self.token(':')?;
                    if key == name {
                        return Some(());
                    }
                    self.skip_value()?;
                }
            }
            self.space();
            if self.next() == Some(',') {
                self.token(',')?;
            }
            index += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"// a comment (with brackets [
PlaneStrain(
    title: "a \"quoted\" (title)",
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), /* c */ Nodes([0, 1])]),
    materials: { "soft clay": Hencky(young: 1e3, poisson: 0) },
    motion: Stretch([(axis: X, anchor: 0)]),
    bodies: [
        (name: "a", shape: Box(from: (0, 0), to: (1, 1))),
    ],
)
"#;

    #[track_caller]
    fn check(path: &str, expected: &str) {
        let (start, end) = position_of(TEXT, path).expect("the path exists");
        let line = TEXT.lines().nth(start.line - 1).unwrap();
        assert_eq!(start.line, end.line);
        let found: String = line.chars().skip(start.column - 1).take(end.column - start.column).collect();
        assert_eq!(found, expected, "{path}");
    }

    #[test]
    fn paths_lead_to_their_values() {
        check("title", r#""a \"quoted\" (title)""#);
        check("mesh.axes[0].to", "2");
        check("mesh.axes[1]", "Nodes([0, 1])");
        check("mesh.axes[1][1]", "1");
        check("materials.soft clay.young", "1e3");
        check("motion[0].anchor", "0");
        check("bodies[0].shape", "Box(from: (0, 0), to: (1, 1))");
        check("bodies[0].shape.to[1]", "1");
        check("bodies[0].material", r#"(name: "a", shape: Box(from: (0, 0), to: (1, 1)))"#);
    }
}
