//! What a set of benchmarks found: tables for people, JSON for programs, pictures for both.

use crate::{Failure, machine};
use mpm_validation::{Picture, Table};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// How the sets are run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Small sizes, one repetition: to see that everything works, not to measure.
    pub quick: bool,
    /// Where results go.
    pub output: PathBuf,
}

impl Settings {
    /// One of two: the first for a quick run, the second to measure.
    pub fn pick<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }
}

/// What a set found.
pub struct Report<R> {
    /// Name of the set.
    pub set: &'static str,
    /// Tables, printed.
    pub tables: Vec<Table>,
    /// Pictures and how many panels stand side by side.
    pub pictures: Vec<(Picture, usize)>,
    /// The same as numbers.
    pub results: R,
}

#[derive(Serialize)]
struct File<'a, R> {
    set: &'a str,
    quick: bool,
    /// `[s]` since 1970.
    written: u64,
    cores: usize,
    /// At the end of the run: above the number of cores the machine was not ours alone.
    load_average: Option<f64>,
    results: &'a R,
}

impl<R: Serialize> Report<R> {
    /// Prints the tables and writes `<set>.json` and the pictures into the folder of the results.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn publish(&self, settings: &Settings) -> Result<(), Failure> {
        for table in &self.tables {
            print_table(table);
        }
        for file in self.save(settings)? {
            println!("written: {}", file.display());
        }
        Ok(())
    }

    /// Writes `<set>.json` and the pictures into the folder of the results, and says where.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn save(&self, settings: &Settings) -> Result<Vec<PathBuf>, Failure> {
        std::fs::create_dir_all(&settings.output)
            .map_err(|error| format!("{}: {error}", settings.output.display()))?;
        let seconds = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH)?.as_secs();
        let file = File {
            set: self.set,
            quick: settings.quick,
            written: seconds,
            cores: std::thread::available_parallelism()?.get(),
            load_average: machine::load_average(),
            results: &self.results,
        };
        let path = settings.output.join(self.set).with_extension("json");
        write(&path, &(serde_json::to_string_pretty(&file)? + "\n"))?;
        let mut written = vec![path];
        for (picture, columns) in &self.pictures {
            picture.save_in_columns(&settings.output, *columns)?;
            written.push(settings.output.join(picture.file));
        }
        Ok(written)
    }
}

/// Writes a file, or says which one it could not write.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Prints a table in Markdown, its columns as wide as their longest word.
pub fn print_table(table: &Table) {
    println!("\n{}\n", table.text);
    let width = |k: usize| {
        let words = table.rows.iter().map(|row| &row[k]).chain([&table.heads[k]]);
        words.map(|word| word.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..table.heads.len()).map(width).collect();
    let line = |row: &[String]| {
        let words: Vec<String> = row.iter().zip(&widths).map(|(word, &n)| format!("{word:<n$}")).collect();
        println!("| {} |", words.join(" | "));
    };
    line(&table.heads);
    println!("|{}|", widths.iter().map(|&n| "-".repeat(n + 2)).collect::<Vec<_>>().join("|"));
    table.rows.iter().for_each(|row| line(row));
}

/// Slope and constant of the line that fits `ln y` over `ln x` best, in least squares: `y ≈ c x^slope`.
/// Not a number for fewer than two points.
pub fn power_law(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|it| it.0), mean(|it| it.1));
    let covariance: f64 = logs.iter().map(|it| (it.0 - x) * (it.1 - y)).sum();
    let variance: f64 = logs.iter().map(|it| (it.0 - x) * (it.0 - x)).sum();
    let slope = covariance / variance;
    (slope, (y - slope * x).exp())
}

/// The powers of ten around some positive numbers, at least a decade.
pub fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|x| x.is_finite() && *x > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return (0.1, 1.0);
    }
    let (from, to) = (low.log10().floor(), high.log10().ceil());
    (10_f64.powf(from), 10_f64.powf(to.max(from + 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_again() {
        let points: Vec<(f64, f64)> = [1e3, 1e4, 3e5].iter().map(|&x: &f64| (x, 2e-6 * x.powf(1.1))).collect();
        let (slope, constant) = power_law(&points);
        assert!((slope - 1.1).abs() < 1e-12 && (constant / 2e-6 - 1.0).abs() < 1e-10);
        assert!(power_law(&points[..1]).0.is_nan());
    }

    #[test]
    fn decades_hold_all_numbers() {
        assert_eq!(decades([0.02, 3.0, f64::NAN].into_iter()), (0.01, 10.0));
        let (from, to) = decades([10.0].into_iter());
        assert!((to / from - 10.0).abs() < 1e-12);
    }
}
