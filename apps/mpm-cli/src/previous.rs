//! Results and checkpoints of earlier runs, which a new run does not replace unasked.

use crate::complaint::Complaint;
use crate::reading::{self, Kind};
use mpm_io::{Checkpoint, Results, is_being_written};
use mpm_scene::Scene;
use std::path::Path;

/// Refuses to replace results that were interrupted or are longer than those of `scene` can become, and checkpoints of such
/// results.
pub fn protect(scene: &Scene, text: &str, results: &Path, checkpoint: &Path) -> Result<(), Complaint> {
    if let Some(reason) = reason_to_keep(results, Some((scene, text))) {
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
    if !checkpoint.is_file() || reading::survives(checkpoint, Kind::Checkpoint).is_err() {
        return Ok(());
    }
    let Ok(kept) = Checkpoint::open(checkpoint) else { return Ok(()) };
    let of = &kept.head().results;
    let planned = Scene::from_ron(&kept.head().scene).map_or(usize::MAX, |scene| steps_of(&scene));
    let is_needed =
        if of.exists() { reason_to_keep(of, None).is_some() } else { kept.progress().rows() <= planned };
    if !is_needed {
        return Ok(());
    }
    Err(Complaint::input(format!(
        "checkpoint {} is that of an unfinished run with the results {}: go on with it by `mpm resume {}`, write to \
         another file by --checkpoint, or replace it by --force",
        checkpoint.display(),
        of.display(),
        checkpoint.display()
    )))
}

/// Why results are not to be replaced: by others of this scene, if one is given.
fn reason_to_keep(path: &Path, by: Option<(&Scene, &str)>) -> Option<String> {
    // What is being written, and what is no file, is for the writer to refuse.
    let length = path.metadata().ok().filter(|it| it.is_file())?.len();
    if length == 0 || is_being_written(path) {
        return None;
    }
    let opened = match reading::survives(path, Kind::Head) {
        Ok(()) => Results::open(path).map_err(|error| error.to_string()),
        Err(complaint) => Err(complaint.to_string()),
    };
    let results = match opened {
        Ok(results) => results,
        Err(_) => return Some("is there and cannot be read as results".into()),
    };
    let steps = (results.first_row() + results.rows()).saturating_sub(1);
    if steps == 0 {
        return None;
    }
    let status = results.status();
    if status == "running" || status.starts_with("failed: interrupted") {
        return Some(format!("holds {steps} load steps of a run that was interrupted"));
    }
    let (scene, text) = by?;
    // The same scene takes as many steps, those that were halved too.
    let planned = steps_of(scene);
    if results.scene() == text || steps <= planned {
        return None;
    }
    let before = Scene::from_ron(results.scene()).map_or(0, |before| steps_of(&before));
    let longer = steps.min(before.max(planned));
    (longer > planned).then(|| format!("holds {steps} load steps, and this run plans {planned}"))
}

/// Load steps that a scene asks for.
fn steps_of(scene: &Scene) -> usize {
    usize::try_from(scene.schedule().n_steps()).unwrap_or(usize::MAX)
}
