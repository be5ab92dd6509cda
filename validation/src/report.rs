//! Programs that run cases and tell of them.

use crate::html::{self, Told};
use crate::{Case, Extent, pages};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

const OPTIONS: &str = "--readme, --pages FOLDER, --quick, --list, --pictures DIRECTORY, --report FILE";

/// What the arguments ask for.
struct Arguments {
    /// Print a section per case instead of rows of one table.
    readme: bool,
    /// List the names and run nothing.
    list: bool,
    /// Folder of the table of all cases, with the folder of their pages.
    pages: Option<PathBuf>,
    pictures: Option<PathBuf>,
    report: Option<PathBuf>,
    extent: Extent,
    /// Cases whose names hold one of these; all, where there are none.
    parts: Vec<String>,
}

impl Arguments {
    fn read(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut read = Self {
            readme: false,
            list: false,
            pages: None,
            pictures: None,
            report: None,
            extent: Extent::Full,
            parts: Vec::new(),
        };
        while let Some(word) = words.next() {
            let mut path = |what: &str| {
                words.next().map(|path| Some(PathBuf::from(path))).ok_or(format!("{word} needs a {what}"))
            };
            match word.as_str() {
                "--readme" => read.readme = true,
                "--quick" => read.extent = Extent::Tests,
                "--list" => read.list = true,
                "--pages" => read.pages = path("folder")?,
                "--pictures" => read.pictures = path("directory")?,
                "--report" => read.report = path("file")?,
                option if option.starts_with("--") => {
                    return Err(format!("unknown option {option}; there are {OPTIONS}"));
                }
                _ => read.parts.push(word),
            }
        }
        if read.pages.is_some() && read.extent == Extent::Tests {
            return Err("--pages tells of whole cases: expected no --quick".into());
        }
        Ok(read)
    }
}

/// Runs the cases that the program's arguments choose (`[--readme] [--pages FOLDER] [--quick] [--list]
/// [--pictures DIRECTORY] [--report FILE] [part of a name]...`) and prints a table, or with `--readme` a page that opens
/// with `introduction`.
pub fn program(cases: &'static [Case], introduction: &str) -> ExitCode {
    let refuse = |reason: &dyn std::fmt::Display| {
        eprintln!("{reason}");
        ExitCode::from(2)
    };
    let arguments = match Arguments::read(std::env::args().skip(1)) {
        Ok(arguments) => arguments,
        Err(reason) => return refuse(&reason),
    };
    if arguments.list {
        cases.iter().for_each(|case| println!("{}", case.name));
        return ExitCode::SUCCESS;
    }
    let parts = &arguments.parts;
    let named = |case: &&Case| parts.is_empty() || parts.iter().any(|part| case.name.contains(part));
    let chosen: Vec<&Case> = cases.iter().filter(named).collect();
    if chosen.is_empty() {
        let names: String = cases.iter().map(|case| format!("\n  {}", case.name)).collect();
        return refuse(&format!("no case is called so; there are:{names}"));
    }
    // A run takes hours: a wrong path is refused before it begins.
    if let Some(Err(error)) = arguments.report.as_ref().map(std::fs::File::create) {
        return refuse(&format!("cannot write the report: {error}"));
    }
    if let Some(Err(error)) =
        arguments.pages.as_ref().map(|folder| std::fs::create_dir_all(folder.join("cases")))
    {
        return refuse(&format!("cannot write the pages: {error}"));
    }

    println!("{}", if arguments.readme { introduction.trim_end() } else { TABLE });
    let mut failures = 0;
    let mut told = Vec::new();
    for case in chosen {
        let (failed, it) = tell(case, &arguments);
        failures += failed;
        told.push(it);
    }
    if let Some(file) = &arguments.report {
        let page = html::page(title(introduction), &told, arguments.extent).map_err(|error| error.to_string());
        failures += done(file, page.and_then(|page| save(file, &page)));
    }
    if let Some(folder) = &arguments.pages {
        let file = folder.join("README.md");
        let table = pages::overview(cases, folder).map_err(|error| error.to_string());
        failures += done(&file, table.and_then(|table| save(&file, &table)));
    }
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn save(file: &Path, text: &str) -> Result<(), String> {
    std::fs::write(file, text).map_err(|error| error.to_string())
}

/// Says that a file is written, or why not; the number of failures.
fn done(file: &Path, written: Result<(), String>) -> usize {
    match written {
        Ok(()) => {
            eprintln!("{}", file.display());
            0
        }
        Err(reason) => {
            eprintln!("{}: {reason}", file.display());
            1
        }
    }
}

/// The head of a page in Markdown.
fn title(introduction: &str) -> &str {
    introduction.lines().next().unwrap_or_default().trim_start_matches(['#', ' '])
}

const TABLE: &str = "| case | what is compared | error | tolerance | | remark |\n|---|---|---|---|---|---|";

/// Carries out a case, prints its rows or its section, and writes its page and pictures; returns the number of failures
/// and what is to be told.
fn tell(case: &'static Case, arguments: &Arguments) -> (usize, Told) {
    let clock = Instant::now();
    let found = (case.run)(arguments.extent);
    let time = clock.elapsed();
    eprintln!("{}: {:.1} s", case.name, time.as_secs_f64());
    let found = match found {
        Ok(findings) => findings,
        Err(broken) => {
            println!("| {} | could not be carried out: {broken} | | | FAIL | |", case.name);
            return (1, Told { case, found: Err(broken.to_string()), time });
        }
    };
    match arguments.readme {
        true => print!("\n{}", pages::section(case, &found, "##", "../docs/pictures")),
        false => found.checks.iter().for_each(|check| println!("| {} {}", case.name, pages::row(check))),
    }
    let mut failures = found.checks.iter().filter(|check| !check.passes()).count();
    if let Some(Err(reason)) = arguments.pages.as_ref().map(|folder| pages::write(case, &found, folder)) {
        eprintln!("{reason}");
        failures += 1;
    }
    for (directory, picture) in
        arguments.pictures.iter().flat_map(|it| found.pictures.iter().map(move |p| (it, p)))
    {
        if let Err(reason) = picture.save(directory) {
            eprintln!("{}: {reason}", picture.file);
            failures += 1;
        }
    }
    (failures, Told { case, found: Ok(found), time })
}
