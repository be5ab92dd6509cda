//! Damaged and hostile files: refused with a message, or read; never a panic.

mod fake;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use mpm_io::{Checkpoint, CheckpointError, CheckpointHead, CheckpointInterval, Results, ResultsWriter};
use mpm_scene::Scene;
use mpm_scene::{Compiled, compile};
use mpm_solver::observe::{LoadStep, Moment, Observer, ObserverError, Outcome, Space};
use mpm_solver::{State, StateLayout};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};

const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 2, cells: 2), Uniform(from: 0, to: 2, cells: 2)]),
    basis: Cpdi2q, domains: (fallback_beyond: 0.5),
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y])],
    loads: [BodyForce(acceleration: (0, -1)), PointForce(body: "block", near: (1, 1), force: (0.1, 0))],
    schedule: (steps: 3),
)"#;

fn compiled() -> Compiled {
    compile(&Scene::from_ron(SCENE).unwrap()).unwrap()
}

/// Keeps the state after a load step.
struct Kept(usize, Option<State>);

impl Observer for Kept {
    fn load_step(&mut self, _: &LoadStep<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        if at == Moment::Step(self.0) {
            self.1 = Some(state());
        }
        Ok(())
    }
}

fn state() -> State {
    let mut kept = Kept(2, None);
    compiled().run(&mut kept).unwrap();
    kept.1.unwrap()
}

fn head(folder: &Path) -> CheckpointHead {
    CheckpointHead {
        scene: SCENE.into(),
        folder: folder.join("scenes"),
        program: "mpm test".into(),
        results: folder.join("größe.h5"),
        interval: CheckpointInterval { steps: Some(7), seconds: Some(0.1) },
    }
}

/// A folder with a checkpoint, and its bytes.
fn checkpoint() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.checkpoint.h5");
    Checkpoint::write(&path, &head(folder.path()), &state()).unwrap();
    let bytes = fs::read(&path).unwrap();
    (folder, path, bytes)
}

#[test]
fn a_checkpoint_returns_as_it_was() {
    let (folder, path, _) = checkpoint();
    let read = Checkpoint::open(&path).unwrap();
    assert_eq!(read.head(), &head(folder.path()));
    let written = {
        let mut kept = state();
        kept.progress = read.progress().clone();
        kept
    };
    assert_eq!(read.state(&compiled().state_layout()).unwrap(), written);
    assert_eq!(read.progress().rows(), 3);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
    // Another folder: the results are found all the same.
    let elsewhere = CheckpointHead { results: "/results/b.h5".into(), ..head(folder.path()) };
    Checkpoint::write(&path, &elsewhere, &state()).unwrap();
    assert_eq!(Checkpoint::open(&path).unwrap().head().results, Path::new("/results/b.h5"));
}

#[test]
fn a_checkpoint_that_cannot_be_written_leaves_that_of_before() {
    let (folder, path, bytes) = checkpoint();
    fs::create_dir(folder.path().join("a.checkpoint.h5.part")).unwrap();
    let error = Checkpoint::write(&path, &head(folder.path()), &state()).unwrap_err();
    assert!(matches!(error, CheckpointError::Write { .. }), "{error}");
    assert!(Checkpoint::check_writable(&path).is_err());
    assert_eq!(fs::read(&path).unwrap(), bytes);
}

/// One change of a file.
#[derive(Clone, Debug)]
enum Damage {
    Flip(Vec<(prop::sample::Index, u8)>),
    Overwrite(prop::sample::Index, Vec<u8>),
    Truncate(prop::sample::Index),
    Append(Vec<u8>),
}

impl Damage {
    fn to(&self, bytes: &[u8]) -> Vec<u8> {
        let mut damaged = bytes.to_vec();
        match self {
            Damage::Flip(places) => {
                places.iter().for_each(|(at, bit)| damaged[at.index(bytes.len())] ^= 1 << (bit % 8));
            }
            Damage::Overwrite(at, by) => {
                let at = at.index(bytes.len());
                damaged.iter_mut().skip(at).zip(by).for_each(|(byte, by)| *byte = *by);
            }
            Damage::Truncate(at) => damaged.truncate(at.index(bytes.len())),
            Damage::Append(more) => damaged.extend(more),
        }
        damaged
    }
}

fn damage() -> impl Strategy<Value = Damage> {
    let extreme = prop_oneof![Just(0_u64), Just(u64::MAX), Just(1 << 62), Just(1 << 40), any::<u64>()];
    prop_oneof![
        4 => prop::collection::vec(any::<(prop::sample::Index, u8)>(), 1..4).prop_map(Damage::Flip),
        3 => (any::<prop::sample::Index>(), extreme)
            .prop_map(|(at, number)| Damage::Overwrite(at, number.to_le_bytes().to_vec())),
        1 => any::<prop::sample::Index>().prop_map(Damage::Truncate),
        1 => prop::collection::vec(any::<u8>(), 1..40).prop_map(Damage::Append),
    ]
}

#[track_caller]
fn check(cases: u32, test: impl Fn(Damage) -> Result<(), TestCaseError>) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new(config).run(&damage(), test).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn every_damage_of_a_checkpoint_is_found() {
    let (_folder, path, bytes) = checkpoint();
    check(3000, |damage| {
        let damaged = damage.to(&bytes);
        prop_assume!(damaged != bytes);
        fs::write(&path, damaged).unwrap();
        let refused = Checkpoint::open(&path);
        prop_assert!(matches!(refused, Err(CheckpointError::Malformed { .. })), "{refused:?}");
        Ok(())
    });
}

/// Set for the process that reads; its value is the first case, and the folder follows.
const READER: &str = "MPM_IO_HOSTILE_FILE";
const CASES: u32 = 3000;

/// Reads damaged files in processes of their own. HDF5 itself may not survive a hostile file (its crashes
/// are counted and told); a panic is ours.
#[track_caller]
fn never_panics(test: &str, bytes: &[u8], read: impl Fn(&Path)) {
    if let Ok(first) = std::env::var(READER) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.h5");
        for case in first.parse().unwrap()..CASES {
            eprintln!("case {case}");
            let mut seed = [7; 32];
            seed[..4].copy_from_slice(&case.to_le_bytes());
            let random = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
            let mut runner = TestRunner::new_with_rng(Config::default(), random);
            let damaged = damage().new_tree(&mut runner).unwrap().current().to(bytes);
            fs::write(&path, if test.contains("checkpoint") { vouched_for(damaged) } else { damaged }).unwrap();
            read(&path);
        }
        return;
    }
    let (mut first, mut crashes) = (0, 0);
    while first < CASES {
        let reader = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", test, "--nocapture"])
            .env(READER, first.to_string())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&reader.stderr);
        let last = text.lines().rev().find_map(|line| line.strip_prefix("case ")?.parse::<u32>().ok());
        match reader.status.code() {
            Some(0) => break,
            Some(_) => panic!("case {last:?}: {text}"),
            None => crashes += 1,
        }
        first = last.expect("a case was begun") + 1;
    }
    println!("{crashes} of {CASES} damaged files crash the HDF5 library itself");
    assert!(crashes < CASES / 20, "{crashes}");
}

#[test]
fn no_checkpoint_is_hostile_enough_for_a_panic() {
    let (_folder, _, bytes) = checkpoint();
    assert_eq!(vouched_for(bytes.clone()), bytes);
    let layout = compiled().state_layout();
    never_panics("no_checkpoint_is_hostile_enough_for_a_panic", &bytes, |path| {
        if let Ok(state) = Checkpoint::open(path).and_then(|read| read.state(&layout)) {
            // Whether it can be gone on with or not: it says so.
            let _ = compiled().resume(&state, &mut ());
        }
    });
}

/// Says of the bytes what an honest writer would say.
fn vouched_for(mut bytes: Vec<u8>) -> Vec<u8> {
    const BLOCK: usize = 512;
    bytes.resize(bytes.len().max(BLOCK), 0);
    let sum = crc32fast::hash(&bytes[BLOCK..]);
    let length = bytes.len() - BLOCK;
    let mut block =
        format!("mpm-checkpoint 4\n{length} bytes follow this block, CRC-32 {sum:08x}\n").into_bytes();
    block.resize(BLOCK, 0);
    bytes[..BLOCK].copy_from_slice(&block);
    bytes
}

#[test]
fn no_results_file_is_hostile_enough_for_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let mut writer = ResultsWriter::create(&path, fake::options()).unwrap();
    fake::start(&mut writer, 3).unwrap();
    for step in 0..3 {
        fake::load_step(&mut writer, step, 3).unwrap();
    }
    writer.finish(&Outcome::Completed, &[]).unwrap();
    let bytes = fs::read(&path).unwrap();
    never_panics("no_results_file_is_hostile_enough_for_a_panic", &bytes, |path| {
        let Ok(results) = Results::open(path) else { return };
        for column in results.columns() {
            let _ = results.column(&column.name);
        }
        for row in 0..results.rows().min(10) {
            let _ = results.residuals(row);
        }
        let _ = results.timings();
        for step in 0..results.fractions().len().min(10) {
            let _ = results.points(step);
            for field in results.fields().unwrap_or_default() {
                let _ = results.field(&field, step);
            }
        }
    });
}

#[test]
fn a_checkpoint_of_another_space_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.checkpoint.h5");
    let (ring, plane) = (Space::Axisymmetric, Space::Cartesian);
    for (written, other) in [(ring, plane), (plane, ring)] {
        Checkpoint::write(&path, &head(folder.path()), &State { space: written, ..state() }).unwrap();
        let read = Checkpoint::open(&path).unwrap();
        let layout = |space| StateLayout { space, ..compiled().state_layout() };
        assert_eq!(read.state(&layout(written)).unwrap().space, written);
        let error = read.state(&layout(other)).unwrap_err().to_string();
        let expected = format!("space: is {}, expected {}, that of the scene", written.name(), other.name());
        assert!(error.contains(&expected), "{error}");
    }
}
