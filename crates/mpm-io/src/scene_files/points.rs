//! Material points from a table, CSV or HDF5.

use super::whole::whole;
use crate::calls::Call;
use crate::error::reason;
use hdf5::File;
use hdf5::types::{FloatSize, TypeDescriptor};
use mpm_scene::PointTable;
use std::path::Path;

/// Columns of positions.
const POSITION: [&str; 3] = ["x", "y", "z"];

/// No compression of HDF5 makes numbers so many times smaller.
const MOST_COMPRESSED: u64 = 1100;

/// A table of text, its columns named by the first line.
pub(super) fn csv(path: &Path, dimensions: usize) -> Result<PointTable, String> {
    let text = whole(path)?;
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_slice());
    let heads = reader.headers().map_err(|error| error.to_string())?.clone();
    let position: Vec<String> = POSITION[..dimensions].iter().map(|&it| it.into()).collect();
    let vectors = (1..=dimensions).flat_map(|r| POSITION[..dimensions].iter().map(move |d| format!("r{r}{d}")));
    let domain: Vec<String> = vectors.collect();
    let known: Vec<&str> = position
        .iter()
        .map(String::as_str)
        .chain(["volume"])
        .chain(domain.iter().map(String::as_str))
        .collect();
    let expected = known.join(", ");
    for (k, head) in heads.iter().enumerate() {
        if !known.contains(&head) {
            return Err(format!("unknown column `{head}`; expected {expected}"));
        }
        if heads.iter().take(k).any(|other| other == head) {
            return Err(format!("the column `{head}` is there twice"));
        }
    }
    let place = |name: &str| {
        let missing = || format!("the column `{name}` is missing; expected {expected}");
        heads.iter().position(|head| head == name).ok_or_else(missing)
    };
    let places = |names: &[String]| names.iter().map(|it| place(it)).collect::<Result<Vec<_>, _>>();
    let has_domains = domain.iter().any(|name| heads.iter().any(|head| head == name));
    let (position, volume) = (places(&position)?, place("volume")?);
    let domain = if has_domains { places(&domain)? } else { Vec::new() };

    let mut table = PointTable { row_kind: "line", ..PointTable::default() };
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, |before| line_of_record(&text, before));
        let number = |&column: &usize| {
            let text = record.get(column).unwrap_or_default();
            let refuse =
                || format!("line {line}, column `{}`: expected a number, got `{text}`", &heads[column]);
            text.parse::<f64>().map_err(|_| refuse())
        };
        table.row.push(line);
        table.volume.push(number(&volume)?);
        for column in &position {
            table.position.push(number(column)?);
        }
        for column in &domain {
            table.domain.push(number(column)?);
        }
    }
    Ok(table)
}

/// Line of the record after a position: lines that hold nothing, or a comment, may stand between.
fn line_of_record(text: &[u8], before: &csv::Position) -> u64 {
    let rest = usize::try_from(before.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or_default();
    let lines = rest.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let skipped = lines.take_while(|line| line.is_empty() || line[0] == b'#').count();
    before.line() + skipped as u64
}

/// Datasets of an HDF5 file.
pub(super) fn hdf5(path: &Path, dimensions: usize) -> Result<PointTable, String> {
    hdf5::silence_errors(true);
    let _call = Call::begin();
    let file = File::open(path).map_err(|error| reason(&error))?;
    let volume = numbers(&file, "volume", &[])?;
    let rows = volume.len();
    let position = numbers(&file, "position", &[rows, dimensions])?;
    let domain = match file.link_exists("domain") {
        true => numbers(&file, "domain", &[rows, dimensions, dimensions])?,
        false => Vec::new(),
    };
    let row = (0..rows as u64).collect();
    Ok(PointTable { row_kind: "row", row, position, volume, domain, ..PointTable::default() })
}

/// A dataset of real numbers with a shape; a list if that is left out. Nothing is read before it is known that the
/// file can hold so much.
fn numbers(file: &File, name: &str, shape: &[usize]) -> Result<Vec<f64>, String> {
    let fail = |error: hdf5::Error| format!("dataset `{name}`: {}", reason(&error));
    let dataset = file.dataset(name).map_err(fail)?;
    let kind = dataset.dtype().and_then(|kind| kind.to_descriptor()).map_err(fail)?;
    let size = match kind {
        TypeDescriptor::Float(FloatSize::U4) => 4,
        TypeDescriptor::Float(FloatSize::U8) => 8,
        _ => return Err(format!("dataset `{name}` holds {kind}, expected real numbers of 4 or 8 bytes")),
    };
    let found = dataset.shape();
    let fits = if shape.is_empty() { found.len() == 1 } else { found == shape };
    if !fits {
        let expected = if shape.is_empty() { "a list".into() } else { format!("{shape:?}") };
        return Err(format!("dataset `{name}` has the shape {found:?}, expected {expected}"));
    }
    let bytes = found.iter().try_fold(size, |bytes: u64, &n| bytes.checked_mul(n as u64));
    let stored = dataset.storage_size();
    if bytes.is_none_or(|bytes| bytes > stored.saturating_mul(MOST_COMPRESSED)) {
        return Err(format!("dataset `{name}` has the shape {found:?}, but only {stored} bytes in the file"));
    }
    dataset.read_raw::<f64>().map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, dimensions: usize) -> Result<PointTable, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, text).unwrap();
        csv(&path, dimensions)
    }

    #[test]
    fn columns_may_stand_in_any_order() {
        let table = of("# two points\nvolume, y, x\n1, 2, 3\n\n0.5, -1e-3, 4\n", 2).unwrap();
        assert_eq!(table.position, [3.0, 2.0, 4.0, -1e-3]);
        assert_eq!(table.volume, [1.0, 0.5]);
        assert_eq!((table.row, table.row_kind, table.domain.len()), (vec![3, 5], "line", 0));
        let table = of("x,y,volume,r2x,r2y,r1x,r1y\n1,2,3,4,5,6,7\n", 2).unwrap();
        assert_eq!(table.domain, [6.0, 7.0, 4.0, 5.0]);
    }

    #[test]
    fn wrong_tables_are_refused_with_line_and_column() {
        let error = |text: &str| of(text, 2).unwrap_err();
        assert_eq!(error("x,y,volume\n1,2,3\n1,two,3\n"), "line 3, column `y`: expected a number, got `two`");
        assert!(
            error("x,y\n1,2\n").starts_with("the column `volume` is missing; expected x, y, volume, r1x, ")
        );
        assert!(error("x,y,z,volume\n").starts_with("unknown column `z`; expected "));
        assert!(error("x,y,volume,r1x\n").starts_with("the column `r1y` is missing"));
        assert_eq!(error("x,y,x,volume\n"), "the column `x` is there twice");
        let said = error("x,y,volume\n1,2,3\n1,2\n");
        assert!(said.contains("line: 3") && said.contains("fields"), "{said}");
    }

    fn file(make: impl FnOnce(&File)) -> Result<PointTable, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.h5");
        let file = File::create(&path).unwrap();
        make(&file);
        file.close().unwrap();
        hdf5(&path, 2)
    }

    #[test]
    fn hdf5_is_read_in_either_precision() {
        let table = file(|it| {
            it.new_dataset_builder().with_data(&[1.0_f32, 2.0]).create("volume").unwrap();
            it.new_dataset_builder()
                .with_data(&ndarray::arr2(&[[0.0, 1.0], [2.0, 3.0]]))
                .create("position")
                .unwrap();
        });
        let table = table.unwrap();
        assert_eq!(table.position, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!((table.volume, table.row, table.row_kind), (vec![1.0, 2.0], vec![0, 1], "row"));
    }

    #[test]
    fn hdf5_that_does_not_fit_is_refused() {
        let error = |make: &dyn Fn(&File)| file(make).unwrap_err();
        let volume = |it: &File| {
            it.new_dataset_builder().with_data(&[1.0, 2.0]).create("volume").unwrap();
        };
        assert!(error(&|_| ()).starts_with("dataset `volume`: "));
        assert!(error(&volume).starts_with("dataset `position`: "));
        let said = error(&|it| {
            volume(it);
            it.new_dataset::<f64>().shape((2, 3)).create("position").unwrap();
        });
        assert_eq!(said, "dataset `position` has the shape [2, 3], expected [2, 2]");
        let said = error(&|it| {
            it.new_dataset_builder().with_data(&[1_i32]).create("volume").unwrap();
        });
        assert!(said.contains("expected real numbers"), "{said}");
        // Thirty-two terabytes that are not there.
        let said = error(&|it| {
            it.new_dataset::<f64>().shape(1_usize << 42).chunk(1 << 10).create("volume").unwrap();
        });
        assert!(said.contains("but only 0 bytes in the file"), "{said}");
    }
}
