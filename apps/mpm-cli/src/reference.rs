//! The language of scenes, told by its types: their JSON schema, and Markdown made of it.
//!
//! Types that exist once per dimension (`BodyInput<2>`, `BodyInput<3>`) have schemas that differ by a
//! number at the end of their names; they are told together, with what only one space has marked.

use schemars::schema_for;
use serde_json::{Map, Value};
use std::fmt::Write;

const INTRODUCTION: &str = include_str!("introduction.md");

/// The JSON schema of a scene.
pub fn json() -> String {
    format!("{:#}\n", schema_for!(mpm_scene::Scene).as_value())
}

/// The JSON schema of a file of `mpm drive`.
pub fn json_of_drive() -> String {
    format!("{:#}\n", schema_for!(mpm_scene::language::DriveInput).as_value())
}

/// The scene that the introduction explains.
pub fn example() -> &'static str {
    let after = INTRODUCTION.split_once("```ron\n").map_or("", |(_, after)| after);
    after.split_once("```").map_or(after, |(example, _)| example)
}

/// Introduction and reference of the language of scenes.
pub fn markdown() -> String {
    let schema = schema_for!(mpm_scene::Scene);
    let language = Language::new(schema.as_value(), "Scene");
    let mut text = INTRODUCTION.to_string();
    for group in &language.groups {
        language.write_type(&mut text, group);
    }
    text
}

/// The same of a file of `mpm drive`.
pub fn markdown_of_drive() -> String {
    let schema = schema_for!(mpm_scene::language::DriveInput);
    let language = Language::new(schema.as_value(), "Drive");
    let mut text = "# The language of `mpm drive`\n".to_string();
    for group in &language.groups {
        language.write_type(&mut text, group);
    }
    text
}

/// A schema, its types in the order in which a reader meets them, and the spaces that have them.
struct Language<'a> {
    types: &'a Map<String, Value>,
    groups: Vec<Group<'a>>,
}

/// A type, in one or more spaces.
struct Group<'a> {
    name: String,
    members: Vec<Member<'a>>,
}

struct Member<'a> {
    name: String,
    schema: &'a Value,
    /// Variants of the whole scene in which the type occurs.
    spaces: Vec<String>,
}

/// One way to write a type: a variant of an enum, or all of a struct.
struct Variant<'a> {
    name: String,
    description: &'a str,
    /// What it holds; nothing for a mere name.
    content: Option<&'a Value>,
}

/// A field of a struct or variant, in one or more spaces.
struct Field<'a> {
    name: &'a str,
    schema: &'a Value,
    required: bool,
    types: Vec<String>,
    spaces: Vec<String>,
}

impl<'a> Language<'a> {
    fn new(root: &'a Value, name: &str) -> Self {
        let types = root["$defs"].as_object().expect("it has parts");
        let mut language = Self { types, groups: Vec::new() };
        let spaces: Vec<Variant<'_>> = variants(root);
        let all = if spaces.is_empty() {
            vec![name.into()]
        } else {
            spaces.iter().map(|space| space.name.clone()).collect()
        };
        let whole = Member { name: name.into(), schema: root, spaces: all };
        language.groups.push(Group { name: name.into(), members: vec![whole] });
        if spaces.is_empty() {
            language.visit(&root["properties"], name);
        }
        for space in &spaces {
            language.visit(space.content.unwrap_or(&Value::Null), &space.name);
        }
        language
    }

    /// Enters every type that `schema` refers to, first met first.
    fn visit(&mut self, schema: &'a Value, space: &str) {
        match schema {
            Value::Object(map) => {
                for (key, value) in map {
                    match (key.as_str(), value) {
                        ("$ref", Value::String(reference)) => self.enter(reference, space),
                        ("default" | "description" | "const", _) => {}
                        _ => self.visit(value, space),
                    }
                }
            }
            Value::Array(list) => list.iter().for_each(|value| self.visit(value, space)),
            _ => {}
        }
    }

    fn enter(&mut self, reference: &str, space: &str) {
        let name = target(reference);
        let Some(schema) = self.types.get(name) else { return };
        let at = match self.groups.iter().position(|group| group.name == base(name)) {
            Some(at) => at,
            None => {
                self.groups.push(Group { name: base(name).into(), members: Vec::new() });
                self.groups.len() - 1
            }
        };
        let members = &mut self.groups[at].members;
        match members.iter_mut().find(|member| member.name == name) {
            Some(member) if member.spaces.iter().any(|known| known == space) => return,
            Some(member) => member.spaces.push(space.into()),
            None => members.push(Member { name: name.into(), schema, spaces: vec![space.into()] }),
        }
        self.visit(schema, space);
    }

    fn write_type(&self, text: &mut String, group: &Group<'a>) {
        let first = group.members[0].schema;
        let spaces = union(group.members.iter().flat_map(|member| &member.spaces));
        let _ = write!(text, "\n## {}\n\n", group.name);
        let only =
            if spaces.len() < self.groups[0].members[0].spaces.len() { only(&spaces) } else { String::new() };
        let _ = writeln!(text, "{}{only}", paragraph(first["description"].as_str().unwrap_or_default()));

        let mut known: Vec<String> = Vec::new();
        for member in &group.members {
            for variant in variants(member.schema) {
                if !known.contains(&variant.name) {
                    self.write_variant(text, group, &variant, &spaces);
                    known.push(variant.name);
                }
            }
        }
        if !known.is_empty() {
            return;
        }
        if first.get("properties").is_some() {
            let parts = group.members.iter().map(|member| (member.schema, &member.spaces[..]));
            self.write_fields(text, &self.fields(parts), &spaces);
        } else {
            let forms = union(group.members.iter().map(|member| self.kind(member.schema)));
            let _ = writeln!(text, "\nForm: {}.", forms.join(" or "));
        }
    }

    fn write_variant(&self, text: &mut String, group: &Group<'a>, variant: &Variant<'a>, all: &[String]) {
        let same =
            |member: &Member<'a>| variants(member.schema).into_iter().find(|other| other.name == variant.name);
        let parts: Vec<(&Value, &[String])> = group
            .members
            .iter()
            .filter_map(|member| Some((same(member)?.content.unwrap_or(&Value::Null), &member.spaces[..])))
            .collect();
        let spaces = union(parts.iter().flat_map(|(_, spaces)| spaces.iter()));
        let only = if spaces.len() < all.len() { only(&spaces) } else { String::new() };
        let description = paragraph(variant.description);
        let name = &variant.name;
        match variant.content {
            None => {
                let _ = writeln!(text, "\n**`{name}`**: {description}{only}");
            }
            Some(content) if content.get("properties").is_some() => {
                let _ = writeln!(text, "\n**`{name}(…)`**: {description}{only}");
                self.write_fields(text, &self.fields(parts.into_iter()), &spaces);
            }
            Some(_) => {
                let kinds = union(parts.iter().map(|(content, _)| self.kind(content)));
                let _ = writeln!(text, "\n**`{name}(…)`** with {}: {description}{only}", kinds.join(" or "));
            }
        }
    }

    /// Fields of a struct that several spaces may have, in the order of their declaration.
    fn fields<'b>(&self, parts: impl Iterator<Item = (&'a Value, &'b [String])>) -> Vec<Field<'a>> {
        let mut fields: Vec<Field<'a>> = Vec::new();
        for (schema, spaces) in parts {
            let Some(properties) = schema["properties"].as_object() else { continue };
            for (name, field) in properties {
                let required =
                    schema["required"].as_array().is_some_and(|list| list.iter().any(|it| it == name));
                let kind = self.kind(field);
                match fields.iter_mut().find(|known| known.name == name) {
                    Some(known) => {
                        known.types = union(known.types.iter().cloned().chain([kind]));
                        known.spaces = union(known.spaces.iter().chain(spaces));
                    }
                    None => fields.push(Field {
                        name,
                        schema: field,
                        required,
                        types: vec![kind],
                        spaces: spaces.to_vec(),
                    }),
                }
            }
        }
        fields
    }

    fn write_fields(&self, text: &mut String, fields: &[Field<'a>], all: &[String]) {
        if fields.is_empty() {
            return;
        }
        text.push_str("\n| field | type | default | meaning |\n|---|---|---|---|\n");
        for field in fields {
            let default = match field.schema.get("default") {
                _ if field.required => "required".into(),
                None | Some(Value::Null) => "none".into(),
                Some(value) => format!("`{}`", self.ron(value, field.schema)),
            };
            let description = paragraph(field.schema["description"].as_str().unwrap_or_default());
            let only = if field.spaces.len() < all.len() { only(&field.spaces) } else { String::new() };
            let types = field.types.join(" or ");
            let _ = writeln!(
                text,
                "| `{}` | {types} | {default} | {}{only} |",
                field.name,
                description.replace('|', "\\|")
            );
        }
    }

    /// How a value is written, with links to the types in it.
    fn kind(&self, schema: &Value) -> String {
        if let Some(reference) = schema["$ref"].as_str() {
            let name = base(target(reference));
            return format!("[{name}](#{})", name.to_lowercase());
        }
        if let Some(choices) = schema["anyOf"].as_array() {
            let kinds = choices.iter().filter(|it| it["type"] != "null").map(|it| self.kind(it));
            return union(kinds).join(" or ");
        }
        let named = match &schema["type"] {
            Value::Array(names) => names.iter().find(|name| *name != "null"),
            name => Some(name),
        };
        match named.and_then(Value::as_str) {
            Some("string") => "text".into(),
            Some("boolean") => "`true` or `false`".into(),
            Some("integer") => match (&schema["minimum"], &schema["maximum"]) {
                (Value::Null, _) | (_, Value::Null) => "whole number".into(),
                (low, high) => format!("whole number from {low} to {high}"),
            },
            Some("number") => "number".into(),
            Some("array") => self.list(schema),
            Some("object") => match schema.get("additionalProperties") {
                Some(entry @ Value::Object(_)) => format!("`{{ \"name\": … }}` of {}", self.kind(entry)),
                _ => "`( … )`".into(),
            },
            _ => "value".into(),
        }
    }

    fn list(&self, schema: &Value) -> String {
        let in_parentheses = |kinds: Vec<String>| format!("({})", kinds.join(", "));
        if let Some(items) = schema["prefixItems"].as_array() {
            return in_parentheses(items.iter().map(|item| self.kind(item)).collect());
        }
        let item = self.kind(&schema["items"]);
        match (schema["minItems"].as_u64(), schema["maxItems"].as_u64()) {
            (Some(low), Some(high)) if low == high => in_parentheses(vec![item; low as usize]),
            _ => format!("`[ … ]` of {item}"),
        }
    }

    /// A default as a scene would write it.
    fn ron(&self, value: &Value, schema: &Value) -> String {
        let schema = match schema["$ref"].as_str() {
            Some(reference) => self.types.get(target(reference)).unwrap_or(schema),
            None => schema,
        };
        // Of several forms a default has the first.
        let schema = match schema["anyOf"].get(0) {
            Some(first) if value.is_array() => first,
            _ => schema,
        };
        match value {
            Value::Null => "None".into(),
            Value::String(name) if schema["type"] != "string" => name.clone(),
            Value::Number(number) => match number.as_f64() {
                Some(x) if x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e6) => format!("{x:e}"),
                Some(x) => x.to_string(),
                None => number.to_string(),
            },
            Value::Array(items) => {
                let tuple = schema["minItems"].is_u64() && schema["minItems"] == schema["maxItems"];
                let of = |k: usize| match schema["prefixItems"].get(k) {
                    Some(item) => item,
                    None => &schema["items"],
                };
                let items: Vec<String> =
                    items.iter().enumerate().map(|(k, item)| self.ron(item, of(k))).collect();
                let (open, close) = if tuple { ("(", ")") } else { ("[", "]") };
                format!("{open}{}{close}", items.join(", "))
            }
            Value::Object(entries) => {
                let field = |(name, value): (&String, &Value)| {
                    format!("{name}: {}", self.ron(value, &schema["properties"][name]))
                };
                format!("({})", entries.iter().map(field).collect::<Vec<_>>().join(", "))
            }
            other => other.to_string(),
        }
    }
}

/// Variants of an enum's schema; none of any other.
fn variants(schema: &Value) -> Vec<Variant<'_>> {
    let choices = schema["oneOf"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut variants = Vec::new();
    let names = |list: &Value| list.as_array().cloned().unwrap_or_default();
    for choice in choices {
        let description = choice["description"].as_str().unwrap_or_default();
        for name in choice.get("const").cloned().into_iter().chain(names(&choice["enum"])) {
            let name = name.as_str().unwrap_or_default().to_string();
            variants.push(Variant { name, description, content: None });
        }
        for (name, content) in choice["properties"].as_object().into_iter().flatten() {
            variants.push(Variant { name: name.clone(), description, content: Some(content) });
        }
    }
    for name in names(&schema["enum"]) {
        let name = name.as_str().unwrap_or_default().to_string();
        variants.push(Variant { name, description: "", content: None });
    }
    variants
}

fn target(reference: &str) -> &str {
    reference.rsplit('/').next().unwrap_or(reference)
}

/// Name of a type without the number that tells its spaces apart.
fn base(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit())
}

fn only(spaces: &[String]) -> String {
    format!(" (`{}` only)", spaces.join("`, `"))
}

/// One line per paragraph.
fn paragraph(text: &str) -> String {
    let paragraphs = text.split("\n\n").map(|it| it.split_whitespace().collect::<Vec<_>>().join(" "));
    paragraphs.collect::<Vec<_>>().join("\n\n")
}

/// Distinct entries in the order of their first appearance.
fn union<S: ToString>(entries: impl IntoIterator<Item = S>) -> Vec<String> {
    let mut distinct: Vec<String> = Vec::new();
    for entry in entries {
        let entry = entry.to_string();
        if !distinct.contains(&entry) {
            distinct.push(entry);
        }
    }
    distinct
}
