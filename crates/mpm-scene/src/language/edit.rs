//! Replaces one value in the text of a scene and leaves all the rest as it is, comments too.

use super::position::{Inside, Part, Walk};
use std::ops::Range;

/// A text in which a value was replaced or put in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edited {
    /// The new text.
    pub text: String,
    /// Where the new value stands, in bytes.
    pub value: Range<usize>,
    /// Where all that is new stands, in bytes: the value and, if it was not there, its name.
    pub new: Range<usize>,
}

/// A path that leads nowhere, or a value that is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// The path is wrong.
    #[error("{0}")]
    Path(String),
    /// The value is not RON.
    #[error("{0}")]
    Value(String),
}

/// Sets the value at `path` in the text of a scene, which is known to be well formed.
///
/// Paths are those of [`super::position_of`]: `bodies[0].points_per_cell`, `materials.clay.young`,
/// `schedule.steps`. A field that the text leaves to its default is put in; whether the scene's language has
/// a field of that name is for its reader to say.
///
/// # Errors
/// Where the path leads to no list entry, no named entry or into a value without parts, with the names there
/// are; where `value` is not a single RON value.
pub fn set_value(text: &str, path: &str, value: &str) -> Result<Edited, EditError> {
    let parts = parts(path)?;
    let value = value.trim();
    check_value(value)?;
    let mut walk = Walk { text, at: 0 };
    walk.space();
    for (k, part) in parts.iter().enumerate() {
        let before = walk.at;
        let inside = walk.inside().unwrap_or(Inside::Nothing);
        walk.at = before;
        let is_of_kind = part.name().is_some() || matches!(inside, Inside::List(_));
        if is_of_kind && walk.enter(*part).is_some() {
            continue;
        }
        let names: Option<Vec<&str>> = parts[k..].iter().map(|part| part.name()).collect();
        return match (inside, names) {
            (Inside::Fields(_, first), Some(names)) => Ok(insert(text, first, &names, value)),
            (inside, _) => Err(EditError::Path(lost(&parts, k, &inside, text[before..].trim_start()))),
        };
    }
    let start = walk.at;
    let end = walk.skip_value().map_or(text.len(), |()| walk.at);
    let text = format!("{}{value}{}", &text[..start], &text[end..]);
    let value = start..start + value.len();
    Ok(Edited { text, new: value.clone(), value })
}

/// Puts `a: (b: (c: value)), ` in at `first`.
fn insert(text: &str, first: usize, names: &[&str], value: &str) -> Edited {
    let opening: String = names
        .iter()
        .enumerate()
        .map(|(k, name)| format!("{}{name}: ", if k == 0 { "" } else { "(" }))
        .collect();
    let closing = ")".repeat(names.len() - 1);
    let start = first + opening.len();
    let value_range = start..start + value.len();
    let new = first..value_range.end + closing.len();
    let text = format!("{}{opening}{value}{closing}, {}", &text[..first], &text[first..]);
    Edited { text, value: value_range, new }
}

/// Why part `k` is not to be found.
fn lost(parts: &[Part<'_>], k: usize, inside: &Inside, found: &str) -> String {
    let (there, wanted) = (shown(&parts[..k]), &parts[k]);
    let place = if k == 0 { "the scene".to_string() } else { format!("`{there}`") };
    match (wanted, inside) {
        (Part::Field(name), Inside::Entries(names)) => {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            format!("{place} has no entry `{name}`; there are {}", names.join(", "))
        }
        (Part::Index(_), Inside::List(0)) => format!("{place} is empty"),
        (Part::Index(index), Inside::List(n)) => {
            format!("{place} has no entry {index}; there are {n}, numbered from 0")
        }
        (Part::Field(name), Inside::List(n)) => {
            format!("{place} is a list of {n}; expected an index in place of `{name}`, as in `{there}[0]`")
        }
        (Part::Index(index), Inside::Fields(names, _) | Inside::Entries(names)) => {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            format!("{place} is no list, so has no entry {index}; there are {}", names.join(", "))
        }
        (part, _) => {
            let end = found.find([',', '\n', '(', ')', ']', '}']).unwrap_or(found.len());
            let inner = if found[end..].starts_with('(') { "( … )" } else { "" };
            format!("{place} is {}{inner}, in which there is no {}", found[..end].trim(), shown(&[*part]))
        }
    }
}

fn shown(parts: &[Part<'_>]) -> String {
    let mut path = String::new();
    for part in parts {
        match part {
            Part::Field(name) if path.is_empty() => path += name,
            Part::Field(name) => path = format!("{path}.{name}"),
            Part::Index(index) => path = format!("{path}[{index}]"),
        }
    }
    path
}

/// The parts of a path.
fn parts(path: &str) -> Result<Vec<Part<'_>>, EditError> {
    let wrong = || {
        EditError::Path(format!(
            "`{path}` is no path: expected names and indices such as `schedule.steps` or `bodies[0].points_per_cell`"
        ))
    };
    let mut parts = Vec::new();
    for name in path.split('.') {
        let (name, indices) = name.split_at(name.find('[').unwrap_or(name.len()));
        if name.is_empty() || name.contains([']', '(', ')', ',', ':', '"']) {
            return Err(wrong());
        }
        parts.push(Part::Field(name));
        let Some(indices) = indices.strip_prefix('[') else { continue };
        let indices = indices.strip_suffix(']').ok_or_else(wrong)?;
        for index in indices.split("][") {
            parts.push(Part::Index(index.parse().map_err(|_| wrong())?));
        }
    }
    Ok(parts)
}

/// Whether `value` is one value with its brackets and quotes closed.
fn check_value(value: &str) -> Result<(), EditError> {
    let mut walk = Walk { text: value, at: 0 };
    walk.space();
    let whole = walk.skip_value().is_some() && {
        walk.space();
        walk.rest().is_empty()
    };
    let wrong = || EditError::Value(format!("expected one value in RON, got `{value}`"));
    // A comment to the end of the line would swallow what follows.
    let is_plain = !value.contains("//") || value.contains('"');
    (whole && is_plain).then_some(()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::language::Scene;

    const TEXT: &str = r#"// steps: 1
PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    basis: Smpm, // standard
    materials: { "soft clay": Hencky(young: 1e3, poisson: 0) },
    bodies: [(name: "a", material: "soft clay", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    schedule: (steps: 4),
)
"#;

    fn set(path: &str, value: &str) -> String {
        let edited = set_value(TEXT, path, value).unwrap();
        assert_eq!(&edited.text[edited.value.clone()], value);
        // All the rest stays.
        assert!(TEXT.starts_with(&edited.text[..edited.new.start]));
        let rest = &edited.text[edited.new.end..];
        assert!(TEXT.ends_with(rest.strip_prefix(", ").filter(|it| TEXT.ends_with(it)).unwrap_or(rest)));
        edited.text
    }

    #[test]
    fn values_are_replaced_or_put_in() {
        for (path, value) in [
            ("schedule.steps", "7"),
            ("bodies[0].points_per_cell", "3"),
            ("materials.soft clay.young", "2e3"),
            ("basis", "Cpdi1"),
            ("mesh.axes[1].cells", "4"),
            ("bodies[0].shape.to[1]", "2"),
            ("schedule.cuts", "0"),
            ("domains.control", "Cap(cells: 0.5)"),
            ("output", "(fields: [Rho], every: 2)"),
            ("title", "\"a (title\""),
            ("output.checkpoint.every", "5"),
        ] {
            let text = set(path, value);
            Scene::from_ron(&text).unwrap_or_else(|error| panic!("{path}: {error}\n{text}"));
        }
        assert_eq!(set("schedule.steps", "7"), TEXT.replace("steps: 4", "steps: 7"));
        let scene = Scene::from_ron(&set("output.checkpoint.every", "5")).unwrap();
        assert_eq!(scene.output().checkpoint.as_ref().and_then(|it| it.every).map(|count| count.0), Some(5));
    }

    #[test]
    fn what_leads_nowhere_is_told_with_what_there_is() {
        for (path, value, expected) in [
            ("materials.hard.young", "1", "`materials` has no entry `hard`; there are `soft clay`"),
            ("bodies[2].name", "1", "`bodies` has no entry 2; there are 1, numbered from 0"),
            ("bodies.name", "1", "`bodies` is a list of 1; expected an index in place of `name`"),
            ("basis.kind", "1", "`basis` is Smpm, in which there is no kind"),
            ("schedule[0]", "1", "`schedule` is no list, so has no entry 0; there are `steps`"),
            ("bodies[x]", "1", "`bodies[x]` is no path"),
            ("", "1", "`` is no path"),
            ("schedule.steps", "7, cuts: 3", "expected one value in RON"),
            ("schedule.steps", "(7", "expected one value in RON"),
            ("schedule.steps", "7 // more", "expected one value in RON"),
            ("schedule.steps", "", "expected one value in RON"),
        ] {
            let error = set_value(TEXT, path, value).unwrap_err().to_string();
            assert!(error.contains(expected), "{path}={value}: {error}");
        }
    }
}
