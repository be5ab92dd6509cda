//! `mpm new`: scenes to begin with.

use crate::complaint::Complaint;
use crate::offered::Offered;
use crate::reference;
use clap::Args;
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct NewArguments {
    /// Name of the template.
    #[arg(required_unless_present = "list", value_parser = Offered(names), hide_possible_values = true)]
    template: Option<String>,
    /// The scene's file, which must not be there yet; `-` prints it [default: the template's name with .ron].
    file: Option<PathBuf>,
    /// List the templates and what they show.
    #[arg(long, conflicts_with_all = ["template", "file"])]
    list: bool,
}

/// The example of the language's reference, with a comment on every part.
const FIRST: &str = "first";

macro_rules! shipped {
    ($($name:literal)*) => { [$(($name, include_str!(concat!("../templates/", $name, ".ron")))),*] };
}

/// The shipped scenes that need no other file.
const SHIPPED: &[(&str, &str)] = &shipped!(
    "simple_stretch" "simple_stretch_rollers" "corner_stretch_kite" "corner_stretch_rectilinear" "doughnut"
    "doughnut_elastic" "doughnut_limit" "doughnut_carried" "column" "column_splines" "slope" "circular_footing" "cantilever" "collapse" "collapse_fine" "footing" "footing_stages" "vortex"
    "plough" "screw_pile" "path_arch" "path_doughnut" "column_solid" "cantilever_solid" "collapse_solid" "tube_twist" "cylinder" "tube_pulled"
);

/// Name and text of every template.
fn templates() -> impl Iterator<Item = (&'static str, &'static str)> {
    std::iter::once((FIRST, reference::example())).chain(SHIPPED.iter().copied())
}

fn names() -> Vec<&'static str> {
    templates().map(|(name, _)| name).collect()
}

/// Writes a scene and says where, or lists what there is.
pub fn new(arguments: &NewArguments) -> Result<String, Complaint> {
    let Some(wanted) = arguments.template.as_deref().filter(|_| !arguments.list) else { return Ok(list()) };
    let Some((name, text)) = templates().find(|(name, _)| *name == wanted) else {
        let names = names().join(", ");
        return Err(Complaint::input(format!("no template named `{wanted}`; there are {names}")));
    };
    let file = arguments.file.clone().unwrap_or_else(|| PathBuf::from(name).with_extension("ron"));
    if file == Path::new("-") {
        return Ok(text.to_string());
    }
    let written = OpenOptions::new().write(true).create_new(true).open(&file);
    let written = written.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| Complaint::input(format!("cannot create scene {}: {error}", file.display())))?;
    Ok(format!("{}\n", file.display()))
}

fn list() -> String {
    let mut text = String::new();
    let width = templates().map(|(name, _)| name.len()).max().unwrap_or(0);
    for (name, scene) in templates() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<width$}  {}", summary(scene));
    }
    text
}

/// First sentence of the comment that a scene opens with.
fn summary(scene: &str) -> String {
    let lines = scene.lines().map_while(|line| line.strip_prefix("//"));
    let comment = lines.map(str::trim).collect::<Vec<_>>().join(" ");
    match comment.split_once(". ") {
        Some((sentence, _)) => format!("{sentence}."),
        None => comment,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_scene_is_a_template() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut scenes: Vec<_> = files.filter(|path| path.extension().is_some_and(|it| it == "ron")).collect();
        scenes.retain(|scene| !std::fs::read_to_string(scene).unwrap().contains("(file:"));
        scenes.sort();
        for scene in &scenes {
            let name = scene.file_stem().unwrap().to_str().unwrap();
            let found = templates().find(|(template, _)| *template == name);
            let text = std::fs::read_to_string(scene).unwrap();
            assert_eq!(found.map(|it| it.1), Some(text.as_str()), "{name}: list it in templates.rs");
        }
        assert_eq!(SHIPPED.len(), scenes.len());
    }

    #[test]
    fn every_template_says_what_it_shows() {
        for (name, scene) in templates() {
            let said = summary(scene);
            assert!(said.len() > 20 && said.ends_with('.'), "{name}: {said}");
        }
    }
}
