//! Triangles of an STL file, binary or text.
//!
//! A text file holds one or more solids. Keywords may be in capitals, lines may be indented, and the last `endsolid` may
//! be missing. Normals are not read: the order of the corners says where the outside is.

use super::whole::whole;
use std::path::Path;
use std::str::SplitAsciiWhitespace;

type Triangle = [[f64; 3]; 3];

/// Bytes before the facets of a binary file: 80 of anything, and their number.
const HEAD: usize = 84;

/// Bytes of a facet of a binary file: normal, three corners, and two bytes of anything.
const FACET: usize = 50;

/// All triangles of a file. Memory is asked for as they are read, never by what the file says of itself.
pub(super) fn read(path: &Path) -> Result<Vec<Triangle>, String> {
    triangles(&whole(path)?)
}

fn triangles(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let count = bytes.get(HEAD - 4..HEAD).map(|it| u32::from_le_bytes([it[0], it[1], it[2], it[3]]) as usize);
    let needed = count.map(|n| HEAD as u64 + FACET as u64 * n as u64);
    // Some programs begin binary files, too, with the word by which text is known.
    if needed == Some(bytes.len() as u64) {
        return binary(bytes);
    }
    if is_text(bytes) {
        return text(bytes).map_err(|reason| format!("read as STL text, which begins with `solid`: {reason}"));
    }
    Err(match count.zip(needed) {
        None => format!("{} bytes are no STL file", bytes.len()),
        Some((n, needed)) => format!(
            "read as binary STL, because STL text begins with `solid`: {} bytes, but its {} need {}",
            rounded(bytes.len() as f64),
            rounded(n as f64) + " facets",
            rounded(needed as f64)
        ),
    })
}

/// A number with at most six digits.
fn rounded(number: f64) -> String {
    if number < 1e6 { number.to_string() } else { format!("{number:.3e}") }
}

fn binary(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    let facets = bytes[HEAD..].chunks_exact(FACET).enumerate();
    let facets = facets.map(|(k, facet)| {
        let number = |at: usize| f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
        let triangle: Triangle =
            [0, 1, 2].map(|corner| [0, 1, 2].map(|d| f64::from(number(12 + 12 * corner + 4 * d))));
        match triangle.as_flattened().iter().all(|x| x.is_finite()) {
            true => Ok(triangle),
            false => Err(format!("facet {} of binary STL has a corner that is not finite", k + 1)),
        }
    });
    facets.collect()
}

/// Without the mark of byte order and the blanks that some editors put before a text.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes).trim_ascii_start()
}

fn is_text(bytes: &[u8]) -> bool {
    let first = without_mark(bytes).split(u8::is_ascii_whitespace).next();
    first.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

fn text(bytes: &[u8]) -> Result<Vec<Triangle>, String> {
    // Names of solids may be in any encoding; all else is ASCII.
    let text = String::from_utf8_lossy(bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes));
    let mut words = Words { lines: text.lines(), line: 0, words: "".split_ascii_whitespace() };
    let mut triangles = Vec::new();
    while let Some(word) = words.next() {
        if !word.eq_ignore_ascii_case("solid") {
            return Err(words.wrong("solid", Some(word)));
        }
        words.skip_line();
        while let Some(word) = words.next() {
            if word.eq_ignore_ascii_case("endsolid") {
                words.skip_line();
                break;
            }
            if !word.eq_ignore_ascii_case("facet") {
                return Err(words.wrong("facet", Some(word)));
            }
            triangles.push(words.facet()?);
        }
    }
    Ok(triangles)
}

/// Words of a text, line by line.
struct Words<'a> {
    lines: std::str::Lines<'a>,
    /// Number of the line, from 1.
    line: usize,
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            self.words = self.lines.next()?.split_ascii_whitespace();
            self.line += 1;
        }
    }

    /// Skips the rest of the line, such as the name of a solid.
    fn skip_line(&mut self) {
        self.words = "".split_ascii_whitespace();
    }

    /// The corners of a facet, of which the first word has been read.
    fn facet(&mut self) -> Result<Triangle, String> {
        // Before the loop stands the normal, often zero or not a number: it says nothing new.
        loop {
            match self.next() {
                Some(word) if word.eq_ignore_ascii_case("outer") => break,
                Some(word) if word.eq_ignore_ascii_case("vertex") => {
                    return Err(self.wrong("outer loop", Some(word)));
                }
                Some(_) => {}
                None => return Err(self.wrong("outer loop", None)),
            }
        }
        self.expect("loop")?;
        let mut triangle = Triangle::default();
        for corner in &mut triangle {
            self.expect("vertex")?;
            for x in corner {
                *x = self.number()?;
            }
        }
        self.expect("endloop")?;
        self.expect("endfacet")?;
        Ok(triangle)
    }

    fn expect(&mut self, expected: &str) -> Result<(), String> {
        match self.next() {
            Some(word) if word.eq_ignore_ascii_case(expected) => Ok(()),
            other => Err(self.wrong(expected, other)),
        }
    }

    /// A coordinate, in single precision as in a binary file.
    fn number(&mut self) -> Result<f64, String> {
        let word = self.next();
        let number = word.and_then(|word| word.parse::<f32>().ok()).filter(|x| x.is_finite());
        number.map(f64::from).ok_or_else(|| match word {
            Some(word) => {
                format!("line {}: expected a finite number in single precision, got `{word}`", self.line)
            }
            None => self.wrong("vertex", None),
        })
    }

    fn wrong(&self, expected: &str, got: Option<&str>) -> String {
        match got {
            Some(word) => {
                let word: String = word.chars().take(20).collect();
                format!("line {}: expected `{expected}`, got `{word}`", self.line)
            }
            None => format!("the file ends at line {} in the middle of a facet", self.line),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1.5 0\n \
        endloop\n endfacet\nendsolid\n";
    const TRIANGLE: Triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0]];

    fn binary(facets: u32, head: &[u8]) -> Vec<u8> {
        let mut bytes = vec![b'.'; 80];
        bytes[..head.len()].copy_from_slice(head);
        bytes.extend(facets.to_le_bytes());
        for x in [0.0_f32, 0.0, 1.0].into_iter().chain(TRIANGLE.into_iter().flatten().map(|x| x as f32)) {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0; 2]);
        bytes
    }

    #[test]
    fn both_kinds_are_read_however_they_begin() {
        for bytes in [
            TEXT.into(),
            TEXT.replacen("solid", "solid a name", 1).into_bytes(),
            TEXT.replacen("solid", "solid facet", 1).into_bytes(),
            TEXT.replace('\n', "\r\n").into_bytes(),
            TEXT.to_uppercase().into_bytes(),
            format!("\u{feff}{TEXT}").into_bytes(),
            format!("\n  \t\n {TEXT}").into_bytes(),
            TEXT.replace("endsolid\n", "").into_bytes(),
            TEXT.replace("normal 0 0 1", "normal nan -nan(ind) 1.#IND").into_bytes(),
            [b"solid \xe9\xff".as_slice(), &TEXT.as_bytes()["solid".len()..]].concat(),
            binary(1, b"made by somebody"),
            binary(1, b"solid as a rock"),
        ] {
            assert_eq!(triangles(&bytes), Ok(vec![TRIANGLE]), "{}", String::from_utf8_lossy(&bytes));
        }
    }

    #[test]
    fn all_solids_of_a_text_are_read() {
        let second = TEXT.replace("1.5", "2.5").replacen("solid", "Solid second", 1);
        for ending in ["endsolid\n", "endsolid a name\n", "ENDSOLID"] {
            let text = TEXT.replace("endsolid\n", ending) + "\n" + &second + TEXT;
            let read = triangles(text.as_bytes()).unwrap();
            assert_eq!(read.len(), 3);
            assert_eq!(read[1][2], [0.0, 2.5, 0.0]);
        }
    }

    #[test]
    fn damaged_files_are_refused_with_their_kind_and_a_line() {
        let error = |bytes: &[u8]| triangles(bytes).unwrap_err();
        let text = |from: &str, to: &str| error(TEXT.replace(from, to).as_bytes());
        assert_eq!(error(b"abc"), "3 bytes are no STL file");
        // A file that claims 4 billion facets is refused at once.
        let said = error(&binary(u32::MAX, b""));
        assert_eq!(
            said,
            "read as binary STL, because STL text begins with `solid`: 134 bytes, but its 4.295e9 facets need 2.147e11"
        );
        let begin = "read as STL text, which begins with `solid`: ";
        for (from, to, expected) in [
            ("1.5", "1,5", "line 6: expected a finite number in single precision, got `1,5`"),
            ("1.5", "inf", "line 6: expected a finite number in single precision, got `inf`"),
            ("1.5", "1e39", "line 6: expected a finite number in single precision, got `1e39`"),
            ("endloop", "vertex 1 1 0\n endloop", "line 7: expected `endloop`, got `vertex`"),
            ("outer loop", "", "line 4: expected `outer loop`, got `vertex`"),
            (" endfacet\nendsolid\n", "", "the file ends at line 7 in the middle of a facet"),
            (
                "0 1.5 0\n endloop\n endfacet\nendsolid\n",
                "0 1.5",
                "the file ends at line 6 in the middle of a facet",
            ),
            ("endsolid\n", "color 1 0 0", "line 9: expected `facet`, got `color`"),
            ("endsolid\n", "endsolid\nendsolid", "line 10: expected `solid`, got `endsolid`"),
        ] {
            assert_eq!(text(from, to), format!("{begin}{expected}"), "{to}");
        }
        let mut infinite = binary(1, b"");
        infinite[HEAD + 12..HEAD + 16].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert_eq!(error(&infinite), "facet 1 of binary STL has a corner that is not finite");
        assert!(error(b"solid\xff").starts_with("8") || error(b"solid\xff").contains("no STL file"));
    }
}
