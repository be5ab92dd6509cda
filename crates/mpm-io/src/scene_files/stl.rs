//! Triangles of an STL file, binary or text.

use super::whole::whole;
use std::io::Cursor;
use std::path::Path;

type Triangle = [[f64; 3]; 3];

/// Bytes before the facets of a binary file: 80 of anything, and their number.
const HEAD: usize = 84;

/// Bytes of a facet of a binary file.
const FACET: usize = 50;

/// All triangles of a file. Memory is asked for as they are read, never by what the file says of itself.
pub(super) fn read(path: &Path) -> Result<Vec<Triangle>, String> {
    triangles(whole(path)?)
}

fn triangles(mut bytes: Vec<u8>) -> Result<Vec<Triangle>, String> {
    let count = bytes.get(HEAD - 4..HEAD).map(|it| u32::from_le_bytes([it[0], it[1], it[2], it[3]]) as usize);
    let is_binary = count.is_some_and(|n| bytes.len() as u64 == HEAD as u64 + FACET as u64 * n as u64);
    if is_binary {
        // Some programs begin these, too, with the word by which text is known.
        bytes[0] = b' ';
    } else if !bytes.starts_with(b"solid") {
        return Err(match count {
            None => format!("{} bytes are no STL file", bytes.len()),
            Some(n) => format!(
                "is no STL text (which begins with `solid`), and as binary STL has {} bytes where {n} facets need {}",
                bytes.len(),
                HEAD as u64 + FACET as u64 * n as u64
            ),
        });
    } else if !bytes.starts_with(b"solid ") {
        // A solid without a name is one with an empty name.
        bytes.splice(5..5, *b" ");
    }
    let mut cursor = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(|error| error.to_string())?;
    let mut triangles = Vec::new();
    for triangle in reader {
        let triangle = triangle.map_err(|error| format!("facet {}: {error}", triangles.len() + 1))?;
        triangles.push(triangle.vertices.map(|vertex| vertex.0.map(f64::from)));
    }
    Ok(triangles)
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
            TEXT.replace('\n', "\r\n").into_bytes(),
            binary(1, b"made by somebody"),
            binary(1, b"solid as a rock"),
        ] {
            assert_eq!(triangles(bytes), Ok(vec![TRIANGLE]));
        }
    }

    #[test]
    fn damaged_files_are_refused_with_a_place() {
        let error = |bytes: Vec<u8>| triangles(bytes).unwrap_err();
        assert_eq!(error(b"abc".to_vec()), "3 bytes are no STL file");
        // A file that claims 4 billion facets is refused at once.
        let said = error(binary(u32::MAX, b""));
        assert!(said.contains("134 bytes where 4294967295 facets need 214748364834"), "{said}");
        let said = error(TEXT.replace("1.5", "1,5").into());
        assert!(said.starts_with("facet 1: ") && said.contains("float"), "{said}");
        assert!(error(TEXT.replace("1.5", "inf").into()).contains("finite"));
        assert!(error(TEXT.replace("endsolid", "").into()).starts_with("facet 2: "));
        assert!(error(vec![b's', b'o', b'l', b'i', b'd', 0xff]).len() > 3);
    }
}
