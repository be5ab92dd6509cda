//! Files that are read in one piece.

use std::fs;
use std::path::Path;

/// All bytes of a file. Pipes and devices, which may never end, are refused before they are opened.
pub(super) fn whole(path: &Path) -> Result<Vec<u8>, String> {
    let fail = |error: std::io::Error| error.to_string();
    let found = fs::metadata(path).map_err(fail)?;
    if !found.is_file() {
        return Err("this is no regular file".into());
    }
    // What the system makes up as it is read has no length, either, and may never end.
    if found.len() == 0 {
        return Err("the file is empty".into());
    }
    fs::read(path).map_err(fail)
}
