//! Reference tables: `validation/reference/*.csv`.

use crate::Broken;
use std::path::Path;

/// A table of numbers with named columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Reference {
    /// Reads `validation/reference/<name>.csv`: comments open with `#`, then the names, then rows.
    ///
    /// # Errors
    /// The file cannot be read, or is no such table.
    pub fn read(name: &str) -> Result<Self, Broken> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("reference").join(name).with_extension("csv");
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Self::parse(&text).map_err(|reason| format!("{}: {reason}", path.display()).into())
    }

    fn parse(text: &str) -> Result<Self, String> {
        let mut lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
        let split = |line: &str| line.split(',').map(|it| it.trim().to_owned()).collect::<Vec<_>>();
        let names = split(lines.next().ok_or("no line of names")?);
        let mut rows = Vec::new();
        for line in lines {
            let row: Vec<f64> = split(line)
                .iter()
                .map(|number| match number.as_str() {
                    "" => Ok(f64::NAN),
                    _ => number.parse().map_err(|_| format!("`{number}` is no number")),
                })
                .collect::<Result<_, _>>()?;
            if row.len() != names.len() {
                return Err(format!("{} names, but a row of {}: {line}", names.len(), row.len()));
            }
            rows.push(row);
        }
        Ok(Self { names, rows })
    }

    /// One column.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, Broken> {
        let at = self.names.iter().position(|it| it == name).ok_or_else(|| format!("no column `{name}`"))?;
        Ok(self.rows.iter().map(|row| row[at]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_by_names() {
        let table = Reference::parse("# said by\na, b, d\n1,2e1,\n3,-4,5\n").unwrap();
        assert_eq!(table.column("b").unwrap(), [20.0, -4.0]);
        assert!(table.column("d").unwrap()[0].is_nan());
        assert!(table.column("c").is_err());
    }

    #[test]
    fn broken_tables_are_refused() {
        assert!(Reference::parse("# nothing\n").is_err());
        assert!(Reference::parse("a,b\n1\n").is_err());
        assert!(Reference::parse("a\nx\n").is_err());
    }
}
