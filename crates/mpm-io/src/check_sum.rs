//! The block before a checkpoint: its format, its length and its check sum.

use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::error::CheckpointError;
use crate::names::{CHECKPOINT, CHECKPOINT_VERSION};

/// Length of the block before the HDF5 file proper that holds its length and check sum [bytes].
pub(crate) const BLOCK: usize = 512;

/// The block that the rest of a file must have before it.
pub(crate) fn block_of(file: &mut fs::File) -> std::io::Result<Vec<u8>> {
    let mut sum = crc32fast::Hasher::new();
    let mut length = 0_u64;
    let mut buffer = vec![0; 1 << 16];
    file.seek(SeekFrom::Start(BLOCK as u64))?;
    loop {
        let n = file.read(&mut buffer)?;
        if n == 0 {
            break;
        }
        sum.update(&buffer[..n]);
        length += n as u64;
    }
    let sum = sum.finalize();
    let mut block =
        format!("{CHECKPOINT} {CHECKPOINT_VERSION}\n{length} bytes follow this block, CRC-32 {sum:08x}\n")
            .into_bytes();
    block.resize(BLOCK, 0);
    Ok(block)
}

/// Compares the check sum; returns the length of the file.
pub(crate) fn check_sum(path: &Path) -> Result<u64, CheckpointError> {
    let fail = |error: std::io::Error| CheckpointError::Open { path: path.into(), reason: error.to_string() };
    let malformed = |item: &str, reason: String| Err(CheckpointError::malformed(path, item, reason));
    let mut file = fs::File::open(path).map_err(fail)?;
    let length = file.metadata().map_err(fail)?.len();
    let mut found = Vec::with_capacity(BLOCK);
    Read::by_ref(&mut file).take(BLOCK as u64).read_to_end(&mut found).map_err(fail)?;
    let line = |text: &[u8], k: usize| {
        let line = text.split(|&byte| byte == b'\n' || byte == 0).nth(k).unwrap_or_default();
        String::from_utf8_lossy(&line[..line.len().min(80)]).into_owned()
    };
    let expected = format!("{CHECKPOINT} {CHECKPOINT_VERSION}");
    if !found.starts_with(CHECKPOINT.as_bytes()) {
        let reason = format!(
            "is not {CHECKPOINT:?}: this is no checkpoint; a run writes one beside its results, as in NAME.checkpoint.h5"
        );
        return malformed("format", reason);
    }
    if line(&found, 0) != expected {
        return malformed("format", format!("is {:?}, expected {expected:?}", line(&found, 0)));
    }
    let block = block_of(&mut file).map_err(fail)?;
    if found != block {
        let (said, is) = (line(&found, 1), line(&block, 1));
        return malformed("check sum", format!("the file is damaged: it says {said:?}, expected {is:?}"));
    }
    Ok(length)
}
