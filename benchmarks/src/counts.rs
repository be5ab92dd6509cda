//! Instructions of the fixed set of [`crate::kernels`], as callgrind counts them: the same on a noisy
//! machine as on a quiet one. A file of the repository keeps them; a check compares.

use crate::report::{Report, Settings, write};
use crate::{Failure, kernels};
use mpm_validation::Table;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A count may change by this part without being told.
const TOLERANCE: f64 = 0.02;

/// What a file of counts holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Compiler and settings of the program that was counted, on which the counts depend.
    pub made_with: String,
    /// Instructions per kernel.
    pub counts: BTreeMap<String, u64>,
}

/// What to do with the counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Show how they differ from the file.
    Show,
    /// Fail where they exceed those of the file.
    Check,
    /// Write the file.
    Update,
}

/// The file of the repository.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("counts.json")
}

/// Counts the kernels whose names hold `part`, and compares them with the file or writes it.
///
/// # Errors
/// Callgrind is missing or fails; a check found more instructions than the file allows.
pub fn run(settings: &Settings, act: Act, part: &str) -> Result<(), Failure> {
    let mut found = Counts { made_with: made_with()?, counts: BTreeMap::new() };
    for kernel in kernels::all().iter().filter(|kernel| kernel.name.contains(part)) {
        let count = callgrind(&kernel.name, settings)?;
        eprintln!("{}: {count}", kernel.name);
        found.counts.insert(kernel.name.clone(), count);
        if settings.quick && found.counts.len() == 2 {
            break;
        }
    }
    if act == Act::Update {
        if settings.quick {
            return Err("a quick run counts too little to be kept".into());
        }
        if !part.is_empty() {
            let kept = read()?;
            found.counts = kept.counts.into_iter().chain(found.counts).collect();
        }
        write(&file(), &(serde_json::to_string_pretty(&found)? + "\n"))?;
        println!("written: {}", file().display());
        return Ok(());
    }
    let kept = read()?;
    if kept.made_with != found.made_with {
        println!("The file was made with {}, this program with {}.", kept.made_with, found.made_with);
    }
    let worse = compare(&kept.counts, &found.counts);
    Report {
        set: "counts",
        tables: vec![table(&kept.counts, &found.counts)],
        pictures: Vec::new(),
        results: found,
    }
    .publish(settings)?;
    if act == Act::Check && !worse.is_empty() {
        return Err(format!(
            "more instructions than in {} by over {:.0} % (`counts --update` where that is meant): {}",
            file().display(),
            100.0 * TOLERANCE,
            worse.join("; ")
        )
        .into());
    }
    Ok(())
}

fn read() -> Result<Counts, Failure> {
    let path = file();
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(serde_json::from_str(&text)?)
}

/// Kernels that need more instructions than they may, or that the file does not know.
fn compare(kept: &BTreeMap<String, u64>, found: &BTreeMap<String, u64>) -> Vec<String> {
    let worse = found.iter().filter_map(|(name, &count)| match kept.get(name) {
        None => Some(format!("{name} is not in the file")),
        Some(&before) if count as f64 > (1.0 + TOLERANCE) * before as f64 => {
            Some(format!("{name} {before} → {count}"))
        }
        Some(_) => None,
    });
    worse.collect()
}

fn table(kept: &BTreeMap<String, u64>, found: &BTreeMap<String, u64>) -> Table {
    let mut table =
        Table::new("Instructions of one call, against the file.", &["kernel", "file", "now", "change"]);
    for (name, &count) in found {
        let before = kept.get(name);
        let change = before.map(|&before| 100.0 * (count as f64 / before as f64 - 1.0));
        table.push([
            name.clone(),
            before.map_or("-".into(), u64::to_string),
            count.to_string(),
            change.map_or("new".into(), |percent| format!("{percent:+.2} %")),
        ]);
    }
    table
}

/// Compiler and settings that the counts depend on.
fn made_with() -> Result<String, Failure> {
    let said = Command::new("rustc").arg("--version").output();
    let said = said.map_err(|error| format!("rustc tells its version: {error}"))?.stdout;
    let setting =
        |name: &str, value: Option<&str>| value.map_or(String::new(), |it| format!(", {name} = {it}"));
    Ok([
        String::from_utf8_lossy(&said).trim().to_owned(),
        setting("lto", option_env!("CARGO_PROFILE_RELEASE_LTO")),
        setting("codegen-units", option_env!("CARGO_PROFILE_RELEASE_CODEGEN_UNITS")),
        setting("flags", option_env!("RUSTFLAGS")),
    ]
    .concat())
}

/// Instructions of one kernel.
fn callgrind(name: &str, settings: &Settings) -> Result<u64, Failure> {
    std::fs::create_dir_all(&settings.output)?;
    let out = settings.output.join("callgrind.out");
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg("--collect-atstart=no")
        .arg("--toggle-collect=*kernels::counted_region*")
        .arg(format!("--callgrind-out-file={}", out.display()))
        .arg(std::env::current_exe()?)
        .args(["kernel", name])
        .env("RAYON_NUM_THREADS", "1")
        // Valgrind does not know all instructions of AVX2.
        .env("MPM_VECTORS", "off")
        .output()
        .map_err(|error| format!("valgrind (Debian package `valgrind`) does not run: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("{name}: {}", said.trim()).into());
    }
    let text = std::fs::read_to_string(&out)?;
    total(&text).ok_or_else(|| format!("{name}: callgrind counted nothing: {}", said.trim()).into())
}

/// The total of a file that callgrind wrote; none where it counted nothing.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("totals:").or(line.strip_prefix("summary:")))?;
    line.split_whitespace().next()?.parse().ok().filter(|&count| count > 0)
}

/// Does the work of one kernel once to warm up, and once to be counted.
///
/// # Errors
/// There is no such kernel, or it cannot be prepared.
pub fn one(name: &str) -> Result<(), Failure> {
    let kernels = kernels::all();
    let kernel = kernels.iter().find(|kernel| kernel.name == name);
    let mut work = kernel.ok_or_else(|| format!("there is no kernel `{name}`"))?.work()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        work();
        kernels::counted_region(&mut work);
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(pairs: &[(&str, u64)]) -> BTreeMap<String, u64> {
        pairs.iter().map(|&(name, count)| (name.to_owned(), count)).collect()
    }

    #[test]
    fn only_what_grew_is_told() {
        let kept = counts(&[("a", 1000), ("b", 1000), ("c", 1000)]);
        let found = counts(&[("a", 1020), ("b", 1021), ("c", 10), ("d", 1)]);
        assert_eq!(compare(&kept, &found), ["b 1000 → 1021", "d is not in the file"]);
    }

    #[test]
    fn totals_are_read() {
        assert_eq!(total("events: Ir\nfn=a\n12\ntotals: 1234\n"), Some(1234));
        assert_eq!(total("summary: 0\n"), None);
        assert_eq!(total("nothing"), None);
    }

    #[test]
    fn the_file_knows_every_kernel_and_no_other() {
        let kept: Vec<String> = read().unwrap().counts.into_keys().collect();
        let mut names: Vec<String> = kernels::all().into_iter().map(|kernel| kernel.name).collect();
        names.sort();
        assert_eq!(kept, names);
    }
}
