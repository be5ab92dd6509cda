//! Tables in memory that stand for files.

use super::FolderFiles;
use super::columns::check_lists;
use super::points::Columns;
use mpm_geometry::Surface;
use mpm_scene::{NamedColumns, PointTable, SceneFiles};
use std::collections::BTreeMap;

/// Tables of numbers in memory by the names of files that a scene names, and a folder for all others.
///
/// A table has the columns that a CSV file would have.
#[derive(Clone, Debug, Default)]
pub struct ArrayFiles {
    folder: FolderFiles,
    tables: BTreeMap<String, Vec<(String, Vec<f64>)>>,
}

impl ArrayFiles {
    /// Files of this folder.
    pub fn beside(folder: FolderFiles) -> Self {
        Self { folder, tables: BTreeMap::new() }
    }

    /// Puts a table in the place of a file: names and numbers of its columns.
    pub fn insert(&mut self, file: impl Into<String>, columns: Vec<(String, Vec<f64>)>) {
        self.tables.insert(file.into(), columns);
    }

    /// Whether a table stands for this file.
    pub fn holds(&self, file: &str) -> bool {
        self.tables.contains_key(file)
    }

    /// Where the other files lie.
    pub fn folder(&self) -> &FolderFiles {
        &self.folder
    }
}

impl SceneFiles for ArrayFiles {
    fn surface(&self, file: &str) -> Result<Surface, String> {
        match self.holds(file) {
            true => Err(format!("{file}: expected a surface, got a table of numbers")),
            false => self.folder.surface(file),
        }
    }

    fn points(&self, file: &str, dimensions: usize) -> Result<PointTable, String> {
        let Some(columns) = self.tables.get(file) else { return self.folder.points(file, dimensions) };
        points(columns, dimensions)
            .map(|table| PointTable { file: file.into(), ..table })
            .map_err(|it| format!("{file}: {it}"))
    }

    fn columns(&self, file: &str) -> Result<NamedColumns, String> {
        let Some(columns) = self.tables.get(file) else { return self.folder.columns(file) };
        let columns: Vec<_> = columns.iter().map(|(name, it)| (name.to_lowercase(), it.clone())).collect();
        check_lists(&columns, "column").map_err(|it| format!("{file}: {it}"))?;
        Ok(NamedColumns { file: file.into(), columns })
    }
}

fn points(columns: &[(String, Vec<f64>)], dimensions: usize) -> Result<PointTable, String> {
    let heads: csv::StringRecord = columns.iter().map(|(name, _)| name.as_str()).collect();
    let Columns { position, volume, domain, notes } = Columns::of(&heads, dimensions, None)?;
    let (first, rows) = (&columns[volume].0, columns[volume].1.len());
    if let Some((name, values)) = columns.iter().find(|column| column.1.len() != rows) {
        return Err(format!("column `{name}` has {} rows, `{first}` {rows}", values.len()));
    }
    let interleaved = |of: &[usize]| -> Vec<f64> {
        (0..rows).flat_map(|row| of.iter().map(move |&column| columns[column].1[row])).collect()
    };
    Ok(PointTable {
        row_kind: "row",
        row: (0..rows as u64).collect(),
        position: interleaved(&position),
        volume: columns[volume].1.clone(),
        domain: interleaved(&domain),
        notes,
        ..PointTable::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(columns: &[(&str, &[f64])]) -> ArrayFiles {
        let mut files = ArrayFiles::default();
        files.insert("a", columns.iter().map(|(name, values)| ((*name).into(), values.to_vec())).collect());
        files
    }

    #[test]
    fn tables_stand_for_files() {
        let table = files(&[("volume", &[1.0, 2.0]), ("Y", &[3.0, 4.0]), ("x", &[5.0, 6.0])]);
        let points = table.points("a", 2).unwrap();
        assert_eq!(points.position, [5.0, 3.0, 6.0, 4.0]);
        assert_eq!((points.file.as_str(), points.row_kind, points.volume), ("a", "row", vec![1.0, 2.0]));
        let columns = table.columns("a").unwrap().columns;
        assert_eq!(columns[1], ("y".to_string(), vec![3.0, 4.0]));
    }

    #[test]
    fn wrong_tables_are_refused() {
        let said = |columns: &[(&str, &[f64])]| files(columns).points("a", 2).unwrap_err();
        assert!(
            said(&[("x", &[1.0]), ("y", &[1.0])]).starts_with("a: the column `volume` is missing; expected")
        );
        assert!(said(&[("mass", &[1.0])]).starts_with("a: unknown column `mass`; expected x, y, volume, "));
        let uneven: &[(&str, &[f64])] = &[("x", &[1.0]), ("y", &[]), ("volume", &[1.0])];
        assert_eq!(said(uneven), "a: column `y` has 0 rows, `volume` 1");
        let said = files(&[("su", &[1.0, f64::NAN])]).columns("a").unwrap_err();
        assert_eq!(said, "a: row 1, column `su`: expected a finite number, got NaN");
        assert_eq!(files(&[]).surface("a").unwrap_err(), "a: expected a surface, got a table of numbers");
    }
}
