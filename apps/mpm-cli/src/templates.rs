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
    ($($topic:literal: $($name:literal)*;)*) => {
        &[$(($topic, &[$(($name, include_str!(concat!("../templates/", $name, ".ron")))),*])),*]
    };
}

/// Names and texts of scenes.
type Templates = &'static [(&'static str, &'static str)];

/// The shipped scenes that need no other file, by topic.
const SHIPPED: &[(&str, Templates)] = shipped!(
    "Stretched and turned": "simple_stretch" "simple_stretch_rollers" "corner_stretch_kite" "corner_stretch_rectilinear"
        "doughnut" "doughnut_elastic" "doughnut_limit" "doughnut_carried" "vortex";
    "Under their own weight": "column" "column_splines" "inclined_column" "collapse" "collapse_fine" "slope";
    "Loaded": "cantilever" "cylinder_pressure" "footing" "footing_stages";
    "Tools": "plough" "screw_pile";
    "Bodies of revolution": "circular_footing";
    "In space": "column_solid" "cantilever_solid" "collapse_solid" "cylinder" "tube_pulled" "tube_twist";
    "Softening": "path_arch" "path_doughnut" "doughnut_regularised";
);

/// Name and text of every template.
fn templates() -> impl Iterator<Item = (&'static str, &'static str)> {
    let shipped = SHIPPED.iter().flat_map(|(_, scenes)| scenes.iter().copied());
    std::iter::once((FIRST, reference::example())).chain(shipped)
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

/// The templates by topic, a line each.
fn list() -> String {
    let mut text = String::new();
    let width = templates().map(|(name, _)| name.len()).max().unwrap_or(0);
    let first = [(FIRST, reference::example())];
    let begin: (&str, &[(&str, &str)]) = ("To begin with", &first);
    for (topic, scenes) in std::iter::once(&begin).chain(SHIPPED) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{topic}");
        for (name, scene) in *scenes {
            let _ = writeln!(text, "  {name:<width$}  {}", title(scene));
        }
    }
    text
}

/// What a scene shows, in a few words.
fn title(scene: &str) -> &str {
    let title = scene.split_once("title: \"").and_then(|(_, rest)| rest.split_once('"'));
    title.map_or("", |(title, _)| title)
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
        assert_eq!(templates().count(), 1 + scenes.len());
    }

    #[test]
    fn every_template_says_what_it_shows() {
        let mut titles: Vec<&str> = templates().map(|(_, scene)| title(scene)).collect();
        assert!(titles.iter().all(|title| (6..50).contains(&title.len())), "{titles:?}");
        titles.sort_unstable();
        titles.dedup();
        assert_eq!(titles.len(), templates().count());
    }
}
