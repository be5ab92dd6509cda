//! Checkpoints: files from which a run goes on bit for bit.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::mem;
use std::path::{Path, PathBuf};

use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use hdf5::{File, Group, H5Type};
use mpm_linear::Saved;
use mpm_solver::{
    BodyLayout, Progress, State, StateLayout, StoredColumn, StoredContribution, StoredPoints, StoredPredictor,
    StoredShare, observe::Space,
};

use crate::calls::{Call, Closing};
use crate::check_sum::{BLOCK, block_of, check_sum};
use crate::error::{CheckpointError, reason};
use crate::replace::{part_of, put_in_place};
use crate::spaces;

/// What a checkpoint says of its run besides the state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CheckpointHead {
    /// The scene as it was read.
    pub scene: String,
    /// The folder of the scene, where the files lie that it names; empty where it names none. That of the
    /// checkpoint is written down as such, so that both may move.
    pub folder: PathBuf,
    /// Name and version of the program.
    pub program: String,
    /// The results file; one in the checkpoint's own folder is written down by its name alone.
    pub results: PathBuf,
    /// When checkpoints are written.
    pub interval: CheckpointInterval,
}

/// When checkpoints are written while a run goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CheckpointInterval {
    /// After every so many load steps.
    pub steps: Option<u32>,
    /// After the first load step that ends so long after the last checkpoint `[s]`.
    pub seconds: Option<f64>,
}

/// A checkpoint that was opened: undamaged, of the known version, its state not yet read.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    file: Closing,
    /// Bytes of the file: nothing in it can be larger.
    length: u64,
    head: CheckpointHead,
    progress: Progress,
}

impl Checkpoint {
    /// Writes a checkpoint: to a file beside it, which takes its place once it is on the disk.
    ///
    /// At any moment `path` holds the checkpoint of before or the new one, whole.
    ///
    /// # Errors
    /// [`CheckpointError::Write`]; what stood at `path` is untouched.
    pub fn write(path: impl AsRef<Path>, head: &CheckpointHead, state: &State) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let part = part_of(path);
        let written = fill(&part, path, head, state).and_then(|()| put_in_place(&part, path));
        written.map_err(|reason| {
            // A full disk gets its space back although HDF5 may keep the file open.
            if let Ok(file) = fs::OpenOptions::new().write(true).open(&part) {
                let _ = file.set_len(0);
            }
            let _ = fs::remove_file(&part);
            CheckpointError::Write { path: path.into(), reason }
        })
    }

    /// Finds out whether a checkpoint could be written.
    ///
    /// # Errors
    /// [`CheckpointError::Write`].
    pub fn check_writable(path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let fail = |reason: String| CheckpointError::Write { path: path.into(), reason };
        if path.is_dir() {
            return Err(fail("is a directory".into()));
        }
        let part = part_of(path);
        fs::write(&part, []).and_then(|()| fs::remove_file(&part)).map_err(|error| fail(error.to_string()))
    }

    /// Opens a checkpoint; refuses one that is damaged or not of this version.
    ///
    /// # Errors
    /// [`CheckpointError::Open`], [`CheckpointError::Malformed`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let path = path.as_ref().to_path_buf();
        hdf5::silence_errors(true);
        let length = check_sum(&path)?;
        let _call = Call::begin();
        let file = File::open(&path)
            .map_err(|error| CheckpointError::Open { path: path.clone(), reason: reason(&error) })?;
        let (file, head) = (Closing::new(file), CheckpointHead::default());
        let mut checkpoint = Self { path, file, length, head, progress: Progress::default() };
        let (steps, seconds) = (checkpoint.setting("every_steps")?, checkpoint.setting("every_seconds")?);
        if steps.fract() != 0.0 || steps > f64::from(u32::MAX) {
            let reason = format!("is {steps}, expected a whole number up to {}", u32::MAX);
            return Err(checkpoint.malformed("every_steps", reason));
        }
        let folder = checkpoint.path.parent().unwrap_or(Path::new("")).to_path_buf();
        checkpoint.head = CheckpointHead {
            scene: checkpoint.text("scene")?,
            folder: match checkpoint.text("scene_folder")? {
                said if said.is_empty() => PathBuf::new(),
                said => folder.join(said),
            },
            program: checkpoint.text("program")?,
            results: folder.join(checkpoint.text("results")?),
            interval: CheckpointInterval {
                steps: (steps > 0.0).then_some(steps as u32),
                seconds: (seconds > 0.0).then_some(seconds),
            },
        };
        let progress = ron::from_str(&checkpoint.text("progress")?);
        checkpoint.progress = progress.map_err(|it| checkpoint.malformed("progress", it))?;
        Ok(checkpoint)
    }

    /// A text, stored as a dataset of bytes, because HDF5 does not check the heap in which its own texts lie.
    fn text(&self, name: &str) -> Result<String, CheckpointError> {
        let bytes = self.numbers::<u8>(&self.file, name, name, 1, (0, usize::MAX))?;
        String::from_utf8(bytes).map_err(|_| self.malformed(name, "is not UTF-8 text"))
    }

    /// The space of the bodies: Cartesian where nothing is said.
    fn space(&self) -> Result<Space, CheckpointError> {
        let _call = Call::begin();
        let is_said = self.file.link_exists("space");
        let name = if is_said { self.text("space")? } else { Space::Cartesian.name().into() };
        spaces::named(&name).map_err(|reason| self.malformed("space", reason))
    }

    fn setting(&self, name: &str) -> Result<f64, CheckpointError> {
        match self.numbers::<f64>(&self.file, name, name, 1, (1, 1))?[..] {
            [number] if (0.0..=1e15).contains(&number) => Ok(number),
            ref other => Err(self.malformed(name, format!("is {other:?}, expected 0 to 1e15"))),
        }
    }

    /// What it says of its run; the results file with the checkpoint's folder before it.
    pub fn head(&self) -> &CheckpointHead {
        &self.head
    }

    /// How far the run had come.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Reads the state of a model with this layout. Nothing is read before it is known to have the shape
    /// that the layout says.
    ///
    /// # Errors
    /// [`CheckpointError::Malformed`]; whether the values are those of the model is for
    /// [`mpm_solver::resume`] to see.
    pub fn state(&self, layout: &StateLayout) -> Result<State, CheckpointError> {
        let space = self.space()?;
        layout.check_space(space).map_err(|it| self.malformed(&it.item, it.reason))?;
        let bodies = self.members("bodies", layout.bodies.len())?;
        let bodies = bodies.iter().zip(&layout.bodies).enumerate();
        let bodies = bodies.map(|(k, (group, body))| self.points(group, &format!("bodies/{k}"), body));
        let loads = self.members("loads", layout.loads)?;
        let loads = loads.iter().enumerate().map(|(k, group)| {
            let item = |name: &str| format!("loads/{k}/{name}");
            let most = layout.bodies.iter().map(|body| body.most).max().unwrap_or(0).saturating_mul(8);
            let points = self.indices(group, "point", &item("point"), most)?;
            let shares = self.numbers::<f64>(group, "share", &item("share"), 1, (0, most))?;
            if points.len() != shares.len() {
                let reason = format!("holds {} numbers, expected {}", shares.len(), points.len());
                return Err(self.malformed(&item("share"), reason));
            }
            let arms = self.numbers::<f64>(group, "arm", &item("arm"), 3, (0, most))?;
            if arms.len() != 3 * points.len() {
                let reason = format!("holds {} numbers, expected {}", arms.len(), 3 * points.len());
                return Err(self.malformed(&item("arm"), reason));
            }
            let parts = points.into_iter().zip(shares).zip(arms.as_chunks().0);
            Ok(parts.map(|((point, part), &arm)| StoredShare { point, part, arm }).collect())
        });
        let contributions = self.members("contributions", layout.contributions.len())?;
        let contributions = contributions.iter().enumerate().map(|(k, group)| {
            let item = |name: &str| format!("contributions/{k}/{name}");
            let name = self.numbers::<u8>(group, "name", &item("name"), 1, (0, usize::MAX))?;
            let name = String::from_utf8(name);
            let name = name.map_err(|_| self.malformed(&item("name"), "is not UTF-8 text"))?;
            let numbers = self.numbers::<f64>(group, "number", &item("number"), 1, (0, usize::MAX))?;
            Ok(StoredContribution { name, numbers })
        });
        let path = self.group("path")?;
        let components = layout.nodes.saturating_mul(layout.dimensions);
        let linear_solver = self.group("linear_solver")?;
        let item = |name: &str| format!("linear_solver/{name}");
        let fingerprint =
            self.numbers::<u64>(&linear_solver, "fingerprint", &item("fingerprint"), 1, (0, 1))?;
        let numbers = self.numbers::<u64>(&linear_solver, "number", &item("number"), 1, (0, usize::MAX))?;
        let linear_solver = fingerprint.first().map(|&fingerprint| Saved { fingerprint, numbers });
        Ok(State {
            space,
            progress: self.progress.clone(),
            bodies: bodies.collect::<Result<_, _>>()?,
            shares: loads.collect::<Result<_, _>>()?,
            contributions: contributions.collect::<Result<_, _>>()?,
            predictor: StoredPredictor {
                nodes: self.numbers(&path, "node", "path/node", 1, (0, layout.nodes))?,
                increment: self.numbers(&path, "increment", "path/increment", 1, (0, components))?,
            },
            linear_solver,
        })
    }

    /// Reads everything in the file, whatever it is, to find out whether HDF5 crashes on it.
    ///
    /// # Errors
    /// [`CheckpointError::Malformed`].
    pub fn read_all(&self) -> Result<(), CheckpointError> {
        self.read_below(&self.file, "")
    }

    fn read_below(&self, group: &Group, path: &str) -> Result<(), CheckpointError> {
        const DEEPEST: usize = 3; // links of a hostile file can form a ring
        if path.matches('/').count() > DEEPEST {
            return Err(self.malformed(path, "is nested too deeply"));
        }
        let _call = Call::begin();
        let fail = |error: hdf5::Error| self.malformed(path, reason(&error));
        for name in group.member_names().map_err(fail)? {
            let item = format!("{path}{name}");
            if let Ok(below) = group.group(&name) {
                self.read_below(&below, &format!("{item}/"))?;
                continue;
            }
            let dataset = group.dataset(&name).map_err(fail)?;
            let width = dataset.shape().get(1).copied().unwrap_or(1);
            let any = (0, usize::MAX);
            match dataset.dtype().and_then(|kind| kind.to_descriptor()).map_err(fail)? {
                TypeDescriptor::Float(FloatSize::U8) => {
                    drop(self.numbers::<f64>(group, &name, &item, width, any)?)
                }
                TypeDescriptor::Unsigned(IntSize::U8) => {
                    drop(self.numbers::<u64>(group, &name, &item, width, any)?)
                }
                _ => drop(self.numbers::<u8>(group, &name, &item, width, any)?),
            }
        }
        Ok(())
    }

    fn points(&self, group: &Group, item: &str, body: &BodyLayout) -> Result<StoredPoints, CheckpointError> {
        if group.len() != body.columns.len() as u64 {
            let names: Vec<&str> = body.columns.iter().map(|column| column.0).collect();
            let reason = format!("has {} members, expected {}", group.len(), names.join(", "));
            return Err(self.malformed(item, reason));
        }
        let mut stored = StoredPoints::default();
        for &(name, width) in &body.columns {
            let item = format!("{item}/{name}");
            let rows = if stored.columns.is_empty() {
                (body.least, body.most)
            } else {
                (stored.points, stored.points)
            };
            let values = self.numbers::<f64>(group, name, &item, width, rows)?;
            stored.points = values.len() / width;
            stored.columns.push(StoredColumn { name, width, values });
        }
        Ok(stored)
    }

    fn malformed(&self, item: &str, reason: impl ToString) -> CheckpointError {
        CheckpointError::malformed(&self.path, item, reason)
    }

    fn group(&self, name: &str) -> Result<Group, CheckpointError> {
        let _call = Call::begin();
        self.file.group(name).map_err(|error| self.malformed(name, reason(&error)))
    }

    /// The groups `0`, `1`, … of a group that has `count` members.
    fn members(&self, name: &str, count: usize) -> Result<Vec<Group>, CheckpointError> {
        let group = self.group(name)?;
        if group.len() != count as u64 {
            return Err(self.malformed(name, format!("has {} members, expected {count}", group.len())));
        }
        (0..count).map(|k| self.group(&format!("{name}/{k}"))).collect()
    }

    /// A dataset of `least` to `most` rows of `width` numbers, one after the other.
    fn numbers<T: H5Type>(
        &self,
        group: &Group,
        name: &str,
        item: &str,
        width: usize,
        (least, most): (usize, usize),
    ) -> Result<Vec<T>, CheckpointError> {
        let _call = Call::begin();
        let fail = |error: hdf5::Error| self.malformed(item, reason(&error));
        let dataset = group.dataset(name).map_err(fail)?;
        let kind = dataset.dtype().and_then(|kind| kind.to_descriptor()).map_err(fail)?;
        let expected = T::type_descriptor();
        if kind != expected {
            return Err(self.malformed(item, format!("holds {kind}, expected {expected}")));
        }
        let shape = dataset.shape();
        let rows = match shape[..] {
            [rows] if width == 1 => Some(rows),
            [rows, found] if found == width && width > 1 => Some(rows),
            _ => None,
        };
        let bytes = rows.and_then(|rows| rows.checked_mul(width)).and_then(|n| n.checked_mul(kind.size()));
        match (rows, bytes) {
            (Some(rows), Some(bytes)) if (least..=most).contains(&rows) && bytes as u64 <= self.length => {
                dataset.read_raw::<T>().map_err(fail)
            }
            _ => {
                let reason = format!("has shape {shape:?}, expected {least} to {most} rows of {width}");
                Err(self.malformed(item, reason))
            }
        }
    }

    /// At most `most` numbers for use as indices.
    fn indices(
        &self,
        group: &Group,
        name: &str,
        item: &str,
        most: usize,
    ) -> Result<Vec<usize>, CheckpointError> {
        let numbers = self.numbers::<u64>(group, name, item, 1, (0, most))?;
        let indices = numbers
            .iter()
            .map(|&it| usize::try_from(it).map_err(|_| self.malformed(item, format!("holds {it}"))));
        indices.collect()
    }
}

/// Writes the whole file at `part`, check sum and all.
fn fill(part: &Path, path: &Path, head: &CheckpointHead, state: &State) -> Result<(), String> {
    hdf5::silence_errors(true);
    let progress = ron::to_string(&state.progress).map_err(|error| error.to_string())?;
    let file = File::with_options()
        .with_fapl(|access| access.libver_v110())
        .with_fcpl(|create| create.userblock(BLOCK as u64).obj_track_times(false))
        .create(part)
        .map_err(|error| reason(&error))?;
    let written = write_all(&file, path, head, &progress, state).and_then(|()| file.flush());
    match written {
        Ok(()) => file.close().map_err(|error| reason(&error))?,
        Err(error) => {
            // Closing the file would try to write the rest.
            mem::forget(file);
            return Err(reason(&error));
        }
    }
    let fail = |error: std::io::Error| error.to_string();
    let mut file = fs::OpenOptions::new().read(true).write(true).open(part).map_err(fail)?;
    let block = block_of(&mut file).map_err(fail)?;
    file.seek(SeekFrom::Start(0)).and_then(|_| file.write_all(&block)).map_err(fail)
}

fn write_all(
    file: &File,
    path: &Path,
    head: &CheckpointHead,
    progress: &str,
    state: &State,
) -> hdf5::Result<()> {
    let CheckpointHead { scene, folder, program, results, interval } = head;
    let beside = results.parent() == path.parent();
    let results =
        if beside { Path::new(results.file_name().unwrap_or_default()).into() } else { absolute(results) };
    let results = results.to_string_lossy();
    let own = path.parent().filter(|own| !own.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = match folder {
        none if none.as_os_str().is_empty() => PathBuf::new(),
        same if same.canonicalize().is_ok_and(|same| own.canonicalize().is_ok_and(|own| own == same)) => {
            ".".into()
        }
        other => absolute(other),
    };
    let folder = folder.to_string_lossy();
    let texts = [
        ("scene", &scene[..]),
        ("scene_folder", &folder),
        ("program", program),
        ("results", &results),
        ("progress", progress),
    ];
    let of_space = (state.space != Space::Cartesian).then(|| ("space", state.space.name()));
    for (name, text) in texts.into_iter().chain(of_space) {
        write_numbers(file, name, 1, text.as_bytes())?;
    }
    write_numbers(file, "every_steps", 1, &[f64::from(interval.steps.unwrap_or(0))])?;
    write_numbers(file, "every_seconds", 1, &[interval.seconds.unwrap_or(0.0)])?;

    let bodies = file.create_group("bodies")?;
    for (k, stored) in state.bodies.iter().enumerate() {
        let group = bodies.create_group(&k.to_string())?;
        for StoredColumn { name, width, values } in &stored.columns {
            write_numbers(&group, name, *width, values)?;
        }
    }
    let loads = file.create_group("loads")?;
    for (k, shares) in state.shares.iter().enumerate() {
        let group = loads.create_group(&k.to_string())?;
        let points: Vec<u64> = shares.iter().map(|it| it.point as u64).collect();
        write_numbers(&group, "point", 1, &points)?;
        write_numbers(&group, "share", 1, &shares.iter().map(|it| it.part).collect::<Vec<f64>>())?;
        write_numbers(&group, "arm", 3, &shares.iter().flat_map(|it| it.arm).collect::<Vec<f64>>())?;
    }
    let contributions = file.create_group("contributions")?;
    for (k, stored) in state.contributions.iter().enumerate() {
        let group = contributions.create_group(&k.to_string())?;
        write_numbers(&group, "name", 1, stored.name.as_bytes())?;
        write_numbers(&group, "number", 1, &stored.numbers)?;
    }
    let predictor = file.create_group("path")?;
    write_numbers(&predictor, "node", 1, &state.predictor.nodes)?;
    write_numbers(&predictor, "increment", 1, &state.predictor.increment)?;
    let linear_solver = file.create_group("linear_solver")?;
    let fingerprint = state.linear_solver.as_ref().map(|saved| saved.fingerprint);
    write_numbers(&linear_solver, "fingerprint", 1, fingerprint.as_slice())?;
    let numbers = state.linear_solver.as_ref().map_or(&[][..], |saved| &saved.numbers);
    write_numbers(&linear_solver, "number", 1, numbers)
}

fn write_numbers<T: H5Type>(group: &Group, name: &str, width: usize, values: &[T]) -> hdf5::Result<()> {
    let builder = group.new_dataset::<T>().obj_track_times(false);
    let dataset = match width {
        1 => builder.shape(values.len()).create(name)?,
        _ => builder.shape((values.len() / width, width)).create(name)?,
    };
    if values.is_empty() { Ok(()) } else { dataset.write_raw(values) }
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}
