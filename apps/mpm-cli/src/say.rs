//! What the program says on standard output.

use crate::complaint::Complaint;
use std::io::Write;

/// Prints to standard output; a reader that has gone away ends the program's talk, not its work.
pub fn say(text: &str) -> Result<(), Complaint> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Complaint::unfinished(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}
