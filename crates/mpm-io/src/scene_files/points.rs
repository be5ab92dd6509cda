//! Material points from a table, CSV or HDF5.

use super::whole::whole;
use crate::calls::Call;
use crate::error::reason;
use hdf5::File;
use hdf5::types::{FloatSize, TypeDescriptor};
use mpm_scene::PointTable;
use std::borrow::Cow;
use std::path::Path;

/// Columns of positions.
const POSITION: [&str; 3] = ["x", "y", "z"];

/// No compression of HDF5 makes numbers so many times smaller.
const MOST_COMPRESSED: u64 = 1100;

/// Columns that are left out with a note: numbers of rows, which some programs put first, without a name even.
const NUMBERING: [&str; 3] = ["id", "index", ""];

/// A table of text, its columns named by the first line; separated by commas, semicolons, tabs or blanks.
pub(super) fn csv(path: &Path, dimensions: usize) -> Result<PointTable, String> {
    let whole = whole(path)?;
    let text = whole.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&whole);
    let separator = Separator::of(text);
    let mut reader = csv::ReaderBuilder::new();
    reader.trim(csv::Trim::All).comment(Some(b'#')).delimiter(separator.byte());
    // Several blanks part two numbers as one does.
    let text = if separator == Separator::Blank { single_blanks(text).into() } else { Cow::Borrowed(text) };
    let mut reader = reader.from_reader(&*text);
    let heads = reader.headers().map_err(|error| error.to_string())?.clone();
    let Columns { position, volume, domain, notes } = Columns::of(&heads, dimensions, Some(separator))?;

    let mut table = PointTable { row_kind: "line", notes, ..PointTable::default() };
    for record in reader.records() {
        let record =
            record.map_err(|error| wrong_length(&error, &text).unwrap_or_else(|| error.to_string()))?;
        let line = record.position().map_or(0, |before| line_of_record(&text, before));
        let number = |&column: &usize| number_in(&record, column, line, &heads[column]);
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

/// The number in a column of a record.
pub(super) fn number_in(
    record: &csv::StringRecord,
    column: usize,
    line: u64,
    head: &str,
) -> Result<f64, String> {
    let text = record.get(column).unwrap_or_default();
    let refuse = || {
        let is_decimal = text.contains(',') && text.replacen(',', ".", 1).parse::<f64>().is_ok();
        let hint = if is_decimal { " (decimals stand behind a point)" } else { "" };
        format!("line {line}, column `{head}`: expected a number, got `{text}`{hint}")
    };
    text.parse::<f64>().map_err(|_| refuse())
}

/// What stands between the columns of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Separator {
    Comma,
    Semicolon,
    Tab,
    Blank,
}

impl Separator {
    /// The first of semicolon, tab, comma and blank that the line of names holds: numbers may hold a comma.
    pub(super) fn of(text: &[u8]) -> Self {
        let mut lines = text.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
        let names = lines.find(|line| !line.is_empty() && line[0] != b'#').unwrap_or_default();
        let kinds = [Self::Semicolon, Self::Tab, Self::Comma, Self::Blank];
        kinds.into_iter().find(|kind| names.contains(&kind.byte())).unwrap_or(Self::Comma)
    }

    pub(super) fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
            Self::Blank => b' ',
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Comma => "commas",
            Self::Semicolon => "semicolons",
            Self::Tab => "tabs",
            Self::Blank => "blanks",
        }
    }
}

/// A text whose columns are separated by one blank, with as many lines.
pub(super) fn single_blanks(text: &[u8]) -> Vec<u8> {
    let mut lines = Vec::with_capacity(text.len());
    for (k, line) in text.split(|&byte| byte == b'\n').enumerate() {
        if k > 0 {
            lines.push(b'\n');
        }
        let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        lines.extend(words.collect::<Vec<_>>().join(&b' '));
    }
    lines
}

/// Where the columns of a table stand.
pub(super) struct Columns {
    pub(super) position: Vec<usize>,
    pub(super) volume: usize,
    /// Empty where the table has no domains.
    pub(super) domain: Vec<usize>,
    pub(super) notes: Vec<String>,
}

impl Columns {
    /// Finds them by their names, in small or capital letters, with or without a unit in brackets.
    pub(super) fn of(
        heads: &csv::StringRecord,
        dimensions: usize,
        separator: Option<Separator>,
    ) -> Result<Self, String> {
        let axes = &POSITION[..dimensions];
        let position: Vec<String> = axes.iter().map(|&it| it.into()).collect();
        let domain: Vec<String> =
            (1..=dimensions).flat_map(|r| axes.iter().map(move |d| format!("r{r}{d}"))).collect();
        let known: Vec<&str> = position
            .iter()
            .map(String::as_str)
            .chain(["volume"])
            .chain(domain.iter().map(String::as_str))
            .collect();
        let expected = known.join(", ");
        let names: Vec<(String, Option<&str>)> = heads.iter().map(name_and_unit).collect();
        let mut notes = Vec::new();
        for (k, (name, _)) in names.iter().enumerate() {
            let head = &heads[k];
            if known.contains(&name.as_str()) {
                if names[..k].iter().any(|other| other.0 == *name) {
                    return Err(format!("the column `{head}` is there twice"));
                }
            } else if NUMBERING.contains(&name.as_str()) && heads.len() > 1 {
                let which = if name.is_empty() { "without a name".into() } else { format!("`{head}`") };
                notes.push(format!("the column {which} is not read"));
            } else {
                let parted =
                    separator.map_or(String::new(), |it| format!(" (columns parted by {})", it.name()));
                return Err(format!("unknown column `{head}`{parted}; expected {expected}"));
            }
        }
        let place = |name: &str| {
            let missing = || format!("the column `{name}` is missing; expected {expected}");
            names.iter().position(|it| it.0 == name).ok_or_else(missing)
        };
        let places = |names: &[String]| names.iter().map(|it| place(it)).collect::<Result<Vec<_>, _>>();
        let has_domains = domain.iter().any(|name| names.iter().any(|it| it.0 == *name));
        let (position, volume) = (places(&position)?, place("volume")?);
        let domain = if has_domains { places(&domain)? } else { Vec::new() };
        let lengths = position.iter().chain(&domain).filter_map(|&k| Some((&heads[k], names[k].1?)));
        let volume_unit = names[volume].1.map(|unit| (&heads[volume], unit));
        check_units(lengths, volume_unit, dimensions)?;
        Ok(Self { position, volume, domain, notes })
    }
}

/// The name of a column in small letters, and its unit: `X [mm]` or `x (mm)`.
pub(super) fn name_and_unit(head: &str) -> (String, Option<&str>) {
    let head = head.trim();
    let ends = [('[', ']'), ('(', ')')];
    let parted = ends.iter().find_map(|&(open, close)| head.strip_suffix(close)?.split_once(open));
    let (name, unit) = parted.map_or((head, None), |(name, unit)| (name, Some(unit.trim())));
    (name.trim().to_lowercase(), unit.filter(|unit| !unit.is_empty()))
}

/// Units are not converted: they must be one unit of length and, of volumes, its power.
fn check_units<'a>(
    mut lengths: impl Iterator<Item = (&'a str, &'a str)>,
    volume: Option<(&str, &str)>,
    dimensions: usize,
) -> Result<(), String> {
    let Some((head, unit)) = lengths.next() else { return Ok(()) };
    if let Some((other, _)) = lengths.find(|it| it.1 != unit) {
        return Err(format!(
            "the columns `{head}` and `{other}` have different units, which are not converted"
        ));
    }
    let power = [["²", "2"], ["³", "3"]][dimensions - 2];
    let is_power = |volume: &str| {
        let rest = volume.strip_prefix(unit).unwrap_or_default();
        power.contains(&rest.trim_start_matches(['^', '*']))
    };
    match volume {
        Some((other, volume)) if !is_power(volume) => Err(format!(
            "the column `{other}` has another unit than the {} of `{head}`, and units are not converted",
            if dimensions == 2 { "square" } else { "cube" }
        )),
        _ => Ok(()),
    }
}

/// That a row has another number of columns than the first line.
pub(super) fn wrong_length(error: &csv::Error, text: &[u8]) -> Option<String> {
    let csv::ErrorKind::UnequalLengths { pos, expected_len, len } = error.kind() else { return None };
    let line = pos.as_ref().map_or(0, |before| line_of_record(text, before));
    Some(format!("line {line} has {len} columns, the first line {expected_len}"))
}

/// Line of the record after a position: lines that hold nothing, or a comment, may stand between.
pub(super) fn line_of_record(text: &[u8], before: &csv::Position) -> u64 {
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
pub(super) fn numbers(file: &File, name: &str, shape: &[usize]) -> Result<Vec<f64>, String> {
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
    fn tables_are_read_as_other_programs_write_them() {
        let plain = of("x,y,volume\n1,2,3\n4,5e-1,6\n", 2).unwrap();
        for text in [
            "\u{feff}x;y;volume\n1;2;3\n4;5e-1;6\n",
            "x\ty\tvolume\n1\t2\t3\n4\t5e-1\t6\n",
            "x y volume\n1 2 3\n4 5e-1 6\n",
            "  x   y  volume\n 1   2   3\n 4   5e-1 6\n",
            "X,Y,Volume\r\n1,2,3\r\n4,0.5,6\r\n",
            "x [m], y [m], volume [m^2]\n1,2,3\n4,0.5,6\n",
            "x (m);y (m);volume (m²)\n1;2;3\n4;0.5;6\n",
            "\"x\",\"y\",\"volume\"\n1,2,3\n4,0.5,6\n",
        ] {
            assert_eq!(of(text, 2).as_ref(), Ok(&plain), "{text}");
        }
        for (text, head) in [
            ("id,x,y,volume\n7,1,2,3\n8,4,0.5,6\n", "`id`"),
            ("x,ID,y,volume\n1,a,2,3\n4,b,0.5,6\n", "`ID`"),
            (",x,y,volume\n0,1,2,3\n1,4,0.5,6\n", "without a name"),
        ] {
            let table = of(text, 2).unwrap();
            assert_eq!(table.notes, [format!("the column {head} is not read")]);
            assert_eq!(PointTable { notes: Vec::new(), ..table }, plain, "{text}");
        }
    }

    #[test]
    fn wrong_tables_are_refused_with_line_and_column() {
        let error = |text: &str| of(text, 2).unwrap_err();
        assert_eq!(error("x,y,volume\n1,2,3\n1,two,3\n"), "line 3, column `y`: expected a number, got `two`");
        assert_eq!(
            error("x;y;volume\n1;2,5;3\n"),
            "line 2, column `y`: expected a number, got `2,5` (decimals stand behind a point)"
        );
        assert!(
            error("x,y\n1,2\n").starts_with("the column `volume` is missing; expected x, y, volume, r1x, ")
        );
        assert!(
            error("x,y,z,volume\n").starts_with("unknown column `z` (columns parted by commas); expected ")
        );
        assert!(error("x|y|volume\n1|2|3\n").starts_with("unknown column `x|y|volume` (columns parted by"));
        assert!(error("x,y,volume,r1x\n").starts_with("the column `r1y` is missing"));
        assert_eq!(error("x,y,X,volume\n"), "the column `X` is there twice");
        assert_eq!(error("x,y,volume\n1,2,3\n\n1,2\n"), "line 4 has 2 columns, the first line 3");
        assert_eq!(
            error("x [m],y [mm],volume\n"),
            "the columns `x [m]` and `y [mm]` have different units, which are not converted"
        );
        let said = error("x [mm],y [mm],volume [m^2]\n");
        assert_eq!(
            said,
            "the column `volume [m^2]` has another unit than the square of `x [mm]`, and units are not converted"
        );
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
