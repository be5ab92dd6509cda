//! The validation as one HTML page that needs nothing else: tables, curves and pictures are in it.

use crate::picture::{Panel, Picture};
use crate::{Case, Check, Extent, Findings, Table};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use mpm_plot::{Figure, PlotError};
use std::fmt::Write as _;
use std::time::{Duration, SystemTime};

/// A case that was carried out.
pub struct Told {
    /// The case.
    pub case: &'static Case,
    /// What it found, or why it could not be carried out.
    pub found: Result<Findings, String>,
    /// How long it took.
    pub time: Duration,
}

impl Told {
    fn passes(&self) -> bool {
        self.found.as_ref().is_ok_and(|found| found.checks.iter().all(Check::passes))
    }
}

const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --pass: #1a7f37; --fail: #cf222e; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 62rem; padding: 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.5rem; border-top: 1px solid var(--line); padding-top: 1rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: .75rem 0; font-size: .875rem; }
th, td { border: 1px solid var(--line); padding: .25rem .5rem; text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.pass { color: var(--pass); } .fail { color: var(--fail); font-weight: bold; }
.panels { display: flex; flex-wrap: wrap; gap: .25rem; background: white; }
.panels svg, .panels img { max-width: 100%; height: auto; }
figure { margin: 1rem 0; } figcaption { font-size: .875rem; }
";

/// The page: settings, a line per case, then each of them.
///
/// # Errors
/// A picture cannot be drawn.
pub fn page(title: &str, told: &[Told], extent: Extent) -> Result<String, PlotError> {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
        escaped(title)
    );
    let failed = told.iter().filter(|it| !it.passes()).count();
    let verdict = match failed {
        0 => format!("<p class=\"pass\">All {} cases pass.</p>", told.len()),
        _ => format!("<p class=\"fail\">{failed} of {} cases fail.</p>", told.len()),
    };
    text += &verdict;
    text +=
        &table(&["setting", ""], settings(told, extent).map(|(name, value)| vec![cell(name), cell(&value)]));

    let heads = ["case", "comparisons", "largest error over its tolerance", "", "time"];
    text += &table(&heads, told.iter().map(summary));
    for it in told {
        section(&mut text, it)?;
    }
    Ok(text + "</body>\n</html>\n")
}

fn settings(told: &[Told], extent: Extent) -> [(&'static str, String); 6] {
    let seconds: f64 = told.iter().map(|it| it.time.as_secs_f64()).sum();
    [
        ("version", format!("implicit-mpm {}", env!("CARGO_PKG_VERSION"))),
        ("date", humantime::format_rfc3339_seconds(SystemTime::now()).to_string()),
        ("extent", extent.pick("coarse meshes only", "everything").into()),
        ("machine", machine()),
        ("threads", std::env::var("RAYON_NUM_THREADS").unwrap_or_else(|_| "one per core".into())),
        ("time", format!("{seconds:.1} s")),
    ]
}

/// Processor and operating system.
fn machine() -> String {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = information.lines().find(|line| line.starts_with("model name"));
    let model = model.and_then(|line| line.split_once(':')).map_or("processor", |(_, model)| model.trim());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores, {} {}", std::env::consts::OS, std::env::consts::ARCH)
}

/// The line of a case in the first table.
fn summary(it: &Told) -> Vec<String> {
    let name = format!("<td><a href=\"#{}\">{}</a></td>", anchor(it.case.name), escaped(it.case.name));
    let (number, worst) = match &it.found {
        Ok(found) => {
            let ratio = |check: &Check| if check.error == 0.0 { 0.0 } else { check.error / check.tolerance };
            // Not a number is the worst of all.
            let worst =
                found.checks.iter().map(ratio).fold(0.0_f64, |a, b| if a > b || a.is_nan() { a } else { b });
            (found.checks.len().to_string(), format!("{worst:.1e}"))
        }
        Err(_) => ("-".into(), "-".into()),
    };
    let time = format!("{:.1} s", it.time.as_secs_f64());
    vec![name, right(&number), right(&worst), verdict(it.passes()), right(&time)]
}

fn section(text: &mut String, it: &Told) -> Result<(), PlotError> {
    let Case { name, goal, setup, reference, .. } = it.case;
    // Writing to a string cannot fail.
    let _ = writeln!(text, "<h2 id=\"{}\">{}</h2>", anchor(name), escaped(name));
    for (head, what) in [("Goal", goal), ("Setup", setup), ("Reference", reference)] {
        let _ = writeln!(text, "<p><em>{head}.</em> {}</p>", inline(what));
    }
    let found = match &it.found {
        Ok(found) => found,
        Err(reason) => {
            let _ = writeln!(text, "<p class=\"fail\">Could not be carried out: {}</p>", inline(reason));
            return Ok(());
        }
    };
    let rows = found.checks.iter().map(|check| {
        let (error, tolerance) = (format!("{:.1e}", check.error), format!("{:.0e}", check.tolerance));
        vec![cell(&check.what), right(&error), right(&tolerance), verdict(check.passes()), cell(&check.remark)]
    });
    *text += &table(&["what is compared", "error", "tolerance", "", "remark"], rows);
    for Table { text: about, heads, rows } in &found.tables {
        let _ = writeln!(text, "<p>{}</p>", inline(about));
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        *text += &table(&heads, rows.iter().map(|row| row.iter().map(|word| cell(word)).collect()));
    }
    for picture in &found.pictures {
        *text += &figure(picture)?;
    }
    Ok(())
}

/// Every panel by itself, so that they find their places on any screen.
fn figure(picture: &Picture) -> Result<String, PlotError> {
    let mut text = String::from("<figure>\n<div class=\"panels\">\n");
    let whole = picture.figure();
    let panels: &[Panel] = whole.panels;
    for k in 0..panels.len() {
        let panel = Figure { panel: whole.panel, ..Figure::new(&panels[k..=k]) };
        if picture.file.ends_with(".svg") {
            text += &panel.svg()?;
        } else {
            let bytes = STANDARD.encode(panel.image()?.small_png()?);
            let alt = escaped(&picture.caption);
            let _ = write!(text, "<img alt=\"{alt}\" src=\"data:image/png;base64,{bytes}\">");
        }
    }
    let _ = writeln!(text, "\n</div>\n<figcaption>{}</figcaption>\n</figure>", inline(&picture.caption));
    Ok(text)
}

fn table(heads: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let heads: String = heads.iter().map(|head| format!("<th>{}</th>", inline(head))).collect();
    let mut text = format!("<div class=\"scroll\"><table>\n<tr>{heads}</tr>\n");
    for row in rows {
        let _ = writeln!(text, "<tr>{}</tr>", row.concat());
    }
    text + "</table></div>\n"
}

fn cell(text: &str) -> String {
    format!("<td>{}</td>", inline(text))
}

fn right(text: &str) -> String {
    format!("<td class=\"number\">{}</td>", escaped(text))
}

fn verdict(passes: bool) -> String {
    let word = if passes { "pass" } else { "fail" };
    format!("<td class=\"{word}\">{word}</td>")
}

fn anchor(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect()
}

/// Text with `code` in it.
fn inline(text: &str) -> String {
    let mut html = String::new();
    let parts: Vec<&str> = text.split('`').collect();
    for (k, part) in parts.iter().enumerate() {
        let is_code = k % 2 == 1 && k + 1 < parts.len();
        let part = escaped(part);
        html += &if is_code { format!("<code>{part}</code>") } else { part };
    }
    html
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CASES;
    use crate::picture::{Patch, Shapes};

    /// Curves are drawn as text, bodies as pixels, both within the page; a failure is told as one.
    #[test]
    fn pictures_and_failures_are_in_the_page() {
        let shapes = Shapes {
            range: [(0.0, 1.0); 2],
            patches: vec![Patch::new(vec![(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], 1.0)],
            ..Shapes::default()
        };
        let picture = |file| Picture {
            file,
            caption: "a < b".into(),
            panels: vec![Panel::Shapes(shapes.clone()), Panel::Shapes(shapes.clone())],
        };
        let found = Findings {
            checks: vec![Check::new("one", 1.0, 2.0), Check::new("two", f64::NAN, 2.0)],
            tables: Vec::new(),
            pictures: vec![picture("a.svg"), picture("a.png")],
        };
        let time = Duration::from_secs(1);
        let told = [
            Told { case: &CASES[0], found: Ok(found), time },
            Told { case: &CASES[1], found: Err("no <disk>".into()), time },
        ];
        let page = page("t", &told, Extent::Full).unwrap();
        assert_eq!(page.matches("<svg").count(), 2, "a picture per panel");
        assert_eq!(page.matches("src=\"data:image/png;base64,iVBOR").count(), 2);
        assert!(page.contains("<figcaption>a &lt; b</figcaption>"));
        assert!(
            page.contains("2 of 2 cases fail.") && page.contains("Could not be carried out: no &lt;disk&gt;")
        );
        assert!(page.contains(">NaN<") && page.matches("class=\"fail\">fail").count() == 3, "{page}");
    }

    #[test]
    fn code_stands_out_and_nothing_breaks_the_page() {
        assert_eq!(inline("a `b<c` & `d"), "a <code>b&lt;c</code> &amp; d");
        assert_eq!(inline("none"), "none");
        assert_eq!(anchor("Newton's rate"), "newton-s-rate");
    }
}
