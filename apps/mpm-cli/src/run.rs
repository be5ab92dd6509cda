//! `mpm run`.

use crate::complaint::Complaint;
use crate::watch::Watch;
use crate::{RunArguments, input, report, say};
use mpm_io::{Options, ResultsWriter};
use mpm_solver::Error;
use std::path::{Path, PathBuf};

/// Runs a scene from file to file.
pub fn run(arguments: &RunArguments) -> Result<(), Complaint> {
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .map_err(|error| Complaint::input(format!("cannot start {threads} threads: {error}")))?;
    }
    let mut input = input::read(&arguments.scene)?;
    let path = output(arguments)?;
    let options = Options {
        scene: input.text.clone(),
        program: concat!("mpm ", env!("CARGO_PKG_VERSION")).into(),
        fields: input.scene.output().fields.clone(),
        every: input.scene.output().every.0 as usize,
        ..Options::default()
    };
    let writer = ResultsWriter::create(&path, options).map_err(|error| Complaint::input(error.to_string()))?;

    let mut watch = Watch::new(writer, arguments.quiet);
    let outcome = input.compiled.run(&mut watch);
    if !arguments.quiet {
        say(&report::convergence(watch.rows()))?;
        if let Ok(summary) = &outcome {
            say(&report::summary(summary, &input.scene, &path))?;
        }
    }
    match outcome {
        Ok(_) => Ok(()),
        Err(Error::Scene(error)) => Err(input::refused(&arguments.scene, &input.text, error)),
        Err(error) => Err(Complaint::unfinished(format!(
            "{error}\nThe {} load steps before it are in {}",
            watch.rows().len(),
            path.display()
        ))),
    }
}

/// Where the results go.
fn output(arguments: &RunArguments) -> Result<PathBuf, Complaint> {
    let path = match &arguments.output {
        Some(path) => path.clone(),
        None => Path::new(arguments.scene.file_stem().unwrap_or_default()).with_extension("h5"),
    };
    // The results would replace the scene that they come from.
    let same = |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
    if same(&path, &arguments.scene) {
        return Err(Complaint::input(format!("the results file {} is the scene itself", path.display())));
    }
    Ok(path)
}
