//! Results and checkpoints of earlier runs, which a new run does not replace unasked.

use crate::complaint::Complaint;
use crate::reading::{self, Kind};
use mpm_io::{reason_to_keep_results, unfinished_results};
use mpm_scene::Scene;
use std::path::Path;

/// Refuses to replace results that were interrupted or are longer than those of `scene` can become, and checkpoints of such
/// results.
pub fn protect(scene: &Scene, text: &str, results: &Path, checkpoint: &Path) -> Result<(), Complaint> {
    let survives = |file: &Path, kind| reading::survives(file, kind).map_err(|complaint| complaint.to_string());
    let head = |file: &Path| survives(file, Kind::Head);
    if let Some(reason) = reason_to_keep_results(results, Some((scene, text)), &head) {
        let resume = if checkpoint.exists() {
            format!("go on with them by `mpm resume {}`, ", checkpoint.display())
        } else {
            String::new()
        };
        return Err(Complaint::input(format!(
            "results file {} {reason}: {resume}write to another file by --output, or replace them by --force",
            results.display()
        )));
    }
    let whole = |file: &Path| survives(file, Kind::Checkpoint);
    let Some(of) = unfinished_results(checkpoint, &whole, &head) else { return Ok(()) };
    Err(Complaint::input(format!(
        "checkpoint {} is that of an unfinished run with the results {}: go on with it by `mpm resume {}`, write to \
         another file by --checkpoint, or replace it by --force",
        checkpoint.display(),
        of.display(),
        checkpoint.display()
    )))
}
