//! Tables of numbers by the names of their columns, CSV or HDF5.

use super::points::{
    Separator, line_of_record, name_and_unit, number_in, numbers, single_blanks, wrong_length,
};
use super::whole::whole;
use crate::calls::Call;
use crate::error::reason;
use hdf5::File;
use std::borrow::Cow;
use std::path::Path;

type Columns = Vec<(String, Vec<f64>)>;

/// A table of text as points have it, whatever its columns are called; units are not looked at.
pub(super) fn csv(path: &Path) -> Result<Columns, String> {
    let whole = whole(path)?;
    let text = whole.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&whole);
    let separator = Separator::of(text);
    let mut reader = csv::ReaderBuilder::new();
    reader.trim(csv::Trim::All).comment(Some(b'#')).delimiter(separator.byte());
    let text = if separator == Separator::Blank { single_blanks(text).into() } else { Cow::Borrowed(text) };
    let mut reader = reader.from_reader(&*text);
    let heads = reader.headers().map_err(|error| error.to_string())?.clone();
    let mut columns: Columns = heads.iter().map(|head| (name_and_unit(head).0, Vec::new())).collect();
    check_names(&columns)?;
    for record in reader.records() {
        let record =
            record.map_err(|error| wrong_length(&error, &text).unwrap_or_else(|| error.to_string()))?;
        let line = record.position().map_or(0, |before| line_of_record(&text, before));
        for (k, column) in columns.iter_mut().enumerate() {
            let number = number_in(&record, k, line, &heads[k])?;
            check(number).map_err(|said| format!("line {line}, column `{}`: {said}", &heads[k]))?;
            column.1.push(number);
        }
    }
    Ok(columns)
}

/// Lists of an HDF5 file, all of one length; a dataset `position` stands for the columns x, y (and z).
pub(super) fn hdf5(path: &Path) -> Result<Columns, String> {
    hdf5::silence_errors(true);
    let _call = Call::begin();
    let file = File::open(path).map_err(|error| reason(&error))?;
    let mut columns = Columns::new();
    for name in file.member_names().map_err(|error| reason(&error))? {
        let shape = file.dataset(&name).map(|dataset| dataset.shape()).unwrap_or_default();
        match (name.as_str(), &shape[..]) {
            ("position", &[rows, dimensions @ (2 | 3)]) => {
                let values = numbers(&file, &name, &[rows, dimensions])?;
                for (d, axis) in ["x", "y", "z"][..dimensions].iter().enumerate() {
                    let column = values.iter().skip(d).step_by(dimensions);
                    columns.push(((*axis).into(), column.copied().collect()));
                }
            }
            (_, &[_]) => columns.push((name.to_lowercase(), numbers(&file, &name, &[])?)),
            _ => {}
        }
    }
    check_lists(&columns, "dataset").map(|()| columns)
}

/// Refuses lists of different lengths, names that stand twice, and numbers that are not finite; `kind` is what a list is called.
pub(super) fn check_lists(columns: &[(String, Vec<f64>)], kind: &str) -> Result<(), String> {
    check_names(columns)?;
    if let Some((name, values)) = columns.iter().find(|column| column.1.len() != columns[0].1.len()) {
        let (other, expected) = (&columns[0].0, columns[0].1.len());
        return Err(format!("{kind} `{name}` has {} rows, `{other}` {expected}", values.len()));
    }
    for (name, values) in columns {
        if let Some(row) = values.iter().position(|value| !value.is_finite()) {
            return Err(format!("row {row}, {kind} `{name}`: expected a finite number, got {}", values[row]));
        }
    }
    Ok(())
}

fn check(number: f64) -> Result<(), String> {
    if number.is_finite() { Ok(()) } else { Err(format!("expected a finite number, got {number}")) }
}

fn check_names(columns: &[(String, Vec<f64>)]) -> Result<(), String> {
    let twice = (0..columns.len()).find(|&k| columns[..k].iter().any(|other| other.0 == columns[k].0));
    match twice {
        Some(k) => Err(format!("the column `{}` is there twice", columns[k].0)),
        None if columns.is_empty() => Err("there is no column of numbers".into()),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_any_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        let of = |text: &str| {
            std::fs::write(&path, text).unwrap();
            csv(&path)
        };
        let column = |name: &str, values: &[f64]| (name.to_string(), values.to_vec());
        let found = of("# strengths\nY [m]; Su [kPa]\n\n0; 30\n-2; 1e1\n").unwrap();
        assert_eq!(found, [column("y", &[0.0, -2.0]), column("su", &[30.0, 10.0])]);
        assert_eq!(of("y,su\n0,inf\n").unwrap_err(), "line 2, column `su`: expected a finite number, got inf");
        assert_eq!(of("y,su\n0,a\n").unwrap_err(), "line 2, column `su`: expected a number, got `a`");
        assert_eq!(of("y,Y\n0,1\n").unwrap_err(), "the column `y` is there twice");
        assert_eq!(of("y,su\n1,2\n3\n").unwrap_err(), "line 3 has 1 columns, the first line 2");
    }

    #[test]
    fn lists_of_hdf5_are_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.h5");
        let of = |make: &dyn Fn(&File)| {
            let file = File::create(&path).unwrap();
            make(&file);
            file.close().unwrap();
            hdf5(&path)
        };
        let list = |file: &File, name: &str, values: &[f64]| {
            file.new_dataset_builder().with_data(values).create(name).unwrap();
        };
        let found = of(&|file| {
            let positions = ndarray::arr2(&[[0.0, 1.0], [2.0, 3.0]]);
            file.new_dataset_builder().with_data(&positions).create("position").unwrap();
            list(file, "Su", &[5.0, 6.0]);
        });
        let column = |name: &str, values: &[f64]| (name.to_string(), values.to_vec());
        let mut found = found.unwrap();
        found.sort_by(|a, b| a.0.cmp(&b.0));
        assert_eq!(found, [column("su", &[5.0, 6.0]), column("x", &[0.0, 2.0]), column("y", &[1.0, 3.0])]);
        let said = of(&|file| {
            list(file, "a", &[1.0]);
            list(file, "b", &[1.0, 2.0]);
        });
        assert_eq!(said.unwrap_err(), "dataset `b` has 2 rows, `a` 1");
        let said = of(&|file| list(file, "a", &[1.0, f64::NAN])).unwrap_err();
        assert_eq!(said, "row 1, dataset `a`: expected a finite number, got NaN");
        assert_eq!(of(&|_| ()).unwrap_err(), "there is no column of numbers");
    }
}
