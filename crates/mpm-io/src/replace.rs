//! Files that take the place of others.

use std::fs::{self, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Where a file is written before it takes its place.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    path.with_file_name(name)
}

/// Puts a file in the place of another, once it is on the disk.
pub(crate) fn put_in_place(part: &Path, path: &Path) -> Result<(), String> {
    let fail = |error: std::io::Error| error.to_string();
    fs::OpenOptions::new().write(true).open(part).and_then(|file| file.sync_all()).map_err(fail)?;
    fs::rename(part, path).map_err(fail)?;
    // The new name has to reach the disk as well; folders of some file systems cannot be synced.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Ok(folder) = fs::File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Whether a run is writing the results file at `path`, as far as its file system knows locks.
pub fn is_being_written(path: impl AsRef<Path>) -> bool {
    let file = fs::File::open(path);
    file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

/// Finds every reason not to write to `path` before HDF5 truncates what is there; a file that is there comes back
/// locked.
pub(crate) fn check_replaceable(path: &Path) -> Result<Option<fs::File>, String> {
    if path.extension().is_some_and(|extension| extension == "xdmf") {
        return Err("the .xdmf file is written beside it; choose another ending, such as .h5".into());
    }
    match fs::metadata(path) {
        Ok(there) if there.is_dir() => Err("is a directory".into()),
        Ok(_) => {
            let file = fs::OpenOptions::new().write(true).open(path).map_err(|error| error.to_string())?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => Err("another program has the file open".into()),
                // Some file systems know no locks.
                Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(file)),
            }
        }
        Err(_) => match path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            Some(parent) if !parent.is_dir() => Err(format!("there is no directory {}", parent.display())),
            _ => Ok(None),
        },
    }
}

/// Keeps other programs from writing a file, but not from reading it, for as long as it is open.
#[cfg(unix)]
pub(crate) fn keep_from_writing(file: &fs::File) -> Result<(), String> {
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Err("another program has the file open".into()),
        // Some file systems know no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// Locks of other systems would keep HDF5 itself from writing.
#[cfg(not(unix))]
pub(crate) fn keep_from_writing(file: &fs::File) -> Result<(), String> {
    let _ = file.unlock();
    Ok(())
}

/// Fills a file with zeros from its end on; on an error it has its length of before.
pub(crate) fn fill(mut file: &fs::File, from: u64, to: u64) -> io::Result<()> {
    let zeros = [0; 1 << 16];
    let mut at = file.seek(SeekFrom::Start(from))?;
    while at < to {
        let part = zeros.len().min(usize::try_from(to - at).unwrap_or(usize::MAX));
        if let Err(error) = file.write_all(&zeros[..part]) {
            file.set_len(from)?;
            return Err(error);
        }
        at += part as u64;
    }
    Ok(())
}

/// Whether a path still leads to an open file.
#[cfg(unix)]
pub(crate) fn is_at(file: &fs::File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |it: fs::Metadata| (it.dev(), it.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(there)) => identity(open) == identity(there),
        _ => false,
    }
}

/// Other systems do not let an open file be deleted.
#[cfg(not(unix))]
pub(crate) fn is_at(_file: &fs::File, path: &Path) -> bool {
    path.exists()
}
