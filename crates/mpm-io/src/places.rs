//! Nothing is written over what is read, nor two files at one place, nor a run over another that is worth more.

use crate::checkpoint::Checkpoint;
use crate::reader::Results;
use crate::replace::is_being_written;
use mpm_scene::Scene;
use std::path::{Path, PathBuf};

/// Refuses to write over what is read (files with what each is), or two files at one place: the results file, the .xdmf
/// file beside it, and the checkpoint.
///
/// # Errors
/// A sentence that names the file that would be written.
pub fn check_places(
    read: &[(&str, PathBuf)],
    results: Option<&Path>,
    checkpoint: Option<&Path>,
) -> Result<(), String> {
    let mut written = Vec::new();
    if let Some(results) = results {
        written.push(("results file", results.to_path_buf()));
        let xdmf = results.with_extension("xdmf");
        // A results file that ends in .xdmf is refused elsewhere.
        if xdmf != results {
            written.push((".xdmf file of the results", xdmf));
        }
    }
    written.extend(checkpoint.map(|path| ("checkpoint", path.to_path_buf())));
    for (k, (what, path)) in written.iter().enumerate() {
        if let Some((other, _)) = read.iter().chain(&written[..k]).find(|other| is_same(path, &other.1)) {
            return Err(format!("the {what} {} is the {other} itself", path.display()));
        }
    }
    Ok(())
}

/// Whether two paths lead to one file, there or not.
pub fn is_same(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| {
        path.canonicalize().or_else(|_| {
            let folder = path.parent().filter(|it| !it.as_os_str().is_empty()).unwrap_or(Path::new("."));
            folder.canonicalize().map(|folder| folder.join(path.file_name().unwrap_or_default()))
        })
    };
    resolved(a).is_ok_and(|a| resolved(b).is_ok_and(|b| a == b))
}

/// Reads a file beforehand, as in another process that may crash over it.
///
/// # Errors
/// A sentence that says how the file cannot be read.
pub type Survives<'a> = &'a dyn Fn(&Path) -> Result<(), String>;

/// Why results at `path` are not to be replaced unasked: they were interrupted, are longer than those of the scene can become
/// (of which the text is given as well, where there is one), or cannot be read as results.
pub fn reason_to_keep_results(
    path: &Path,
    by: Option<(&Scene, &str)>,
    survives: Survives<'_>,
) -> Option<String> {
    // What is being written, and what is no file, is for the writer to refuse.
    let length = path.metadata().ok().filter(|it| it.is_file())?.len();
    if length == 0 || is_being_written(path) {
        return None;
    }
    let opened = survives(path).and_then(|()| Results::open(path).map_err(|error| error.to_string()));
    let Ok(results) = opened else { return Some("is there and cannot be read as results".into()) };
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

/// The results file of the unfinished run that a checkpoint is of; none if the checkpoint may be replaced unasked.
pub fn unfinished_results(checkpoint: &Path, survives: Survives<'_>, head: Survives<'_>) -> Option<PathBuf> {
    if !checkpoint.is_file() || survives(checkpoint).is_err() {
        return None;
    }
    let kept = Checkpoint::open(checkpoint).ok()?;
    let of = &kept.head().results;
    let planned = Scene::from_ron(&kept.head().scene).map_or(usize::MAX, |scene| steps_of(&scene));
    let is_needed = if of.exists() {
        reason_to_keep_results(of, None, head).is_some()
    } else {
        kept.progress().rows() <= planned
    };
    is_needed.then(|| of.clone())
}

/// Load steps that a scene asks for.
fn steps_of(scene: &Scene) -> usize {
    usize::try_from(scene.schedule().n_steps()).unwrap_or(usize::MAX)
}
