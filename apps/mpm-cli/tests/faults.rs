//! Nothing computed is lost: kills, signals, full disks, folders that cannot be written, files that are locked,
//! deleted or damaged.
#![cfg(unix)]

use mpm_io::{Checkpoint, Results};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A plastic block that is pushed across its grid, in many load steps, with points at every third.
const SCENE: &str = r#"PlaneStrain(
    mesh: Box(axes: [Uniform(from: 0, to: 12, cells: 12), Uniform(from: 0, to: 4, cells: 4)]),
    basis: Gimp,
    materials: { "clay": VonMises(young: 1e3, poisson: 0.3, yield_radius: 4, density: 2) },
    bodies: [(name: "block", material: "clay", shape: Box(from: (0, 0), to: (4, 3)), points_per_cell: 2)],
    supports: [(name: "base", region: Plane(axis: Y, at: 0), fix: [Y], displace: [(axis: X, by: 3)])],
    loads: [BodyForce(acceleration: (0, -1))],
    schedule: (steps: STEPS),
    output: (fields: [CauchyStress, Displacement, Plastic], every: 3, checkpoint: (every: 4)),
)"#;

/// A folder of a test's own. One test at a time: what is timed is not kept waiting by another.
struct Place(tempfile::TempDir, #[expect(dead_code, reason = "held")] MutexGuard<'static, ()>);

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

impl Place {
    /// A folder with the scene `a.ron`.
    fn with(steps: usize) -> Self {
        // Every checkpoint waits for the disk; one in memory does not keep the tests waiting.
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let place = Self(folder.unwrap(), turn);
        fs::write(place.path("a.ron"), SCENE.replace("STEPS", &steps.to_string())).unwrap();
        place
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mpm"));
        // Small steps: a second thread would only wait for its turn.
        command
            .env("RAYON_NUM_THREADS", "1")
            .args(arguments)
            .current_dir(self.0.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn mpm(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program starts")
    }

    /// Runs in a shell after `before`.
    fn shell(&self, before: &str, arguments: &str) -> Output {
        let script = format!("{before}; exec {} {arguments}", env!("CARGO_BIN_EXE_mpm"));
        Command::new("sh").args(["-c", &script]).current_dir(self.0.path()).output().expect("there is a shell")
    }

    #[track_caller]
    fn completes(&self, arguments: &[&str]) {
        let output = self.mpm(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", said(&output));
    }

    /// Waits until the run has written so many rows.
    fn wait_for_rows(&self, file: &str, rows: usize, run: &mut Child) {
        let path = self.path(file);
        let written = || Results::open(&path).map_or(0, |results| results.rows());
        let began = Instant::now();
        while written() < rows {
            assert!(run.try_wait().unwrap().is_none(), "the run ended before {rows} rows");
            assert!(began.elapsed() < Duration::from_secs(120), "no {rows} rows in two minutes");
            sleep(Duration::from_millis(2));
        }
    }
}

fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(!text.contains("panicked"), "{text}");
    text
}

/// The same columns, residuals and points, bit for bit; only wall seconds may differ.
#[track_caller]
fn assert_same(expected: &Path, found: &Path) {
    let [a, b] = [expected, found].map(|path| Results::open(path).unwrap());
    assert_eq!((a.status(), a.rows(), a.columns()), (b.status(), b.rows(), b.columns()));
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for column in a.columns().iter().filter(|column| column.name != "wall_seconds") {
        let [a, b] = [&a, &b].map(|results| bits(results.column(&column.name).unwrap().values()));
        assert_eq!(a, b, "{}", column.name);
    }
    for row in 0..a.rows() {
        assert_eq!(
            bits(&a.residuals(row).unwrap()),
            bits(&b.residuals(row).unwrap()),
            "residuals of row {row}"
        );
    }
    assert_eq!(a.fractions(), b.fractions());
    for step in 0..a.fractions().len() {
        let [x, y] = [&a, &b].map(|results| bits(results.points(step).unwrap().values()));
        assert_eq!(x, y, "positions at {step}");
        for field in a.fields().unwrap() {
            let [x, y] = [&a, &b].map(|results| bits(results.field(&field, step).unwrap().values()));
            assert_eq!(x, y, "{field} at {step}");
        }
    }
    let [x, y] = [expected, found].map(|path| fs::read_to_string(path.with_extension("xdmf")).unwrap());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    assert_eq!(x.replace(&name(expected), ""), y.replace(&name(found), ""));
}

/// Kills runs at moments spread over their length, again and again until they are through.
fn survives_kills(kills: usize) {
    let place = Place::with(40);
    let began = Instant::now();
    place.completes(&["run", "a.ron", "-q", "-o", "whole.h5"]);
    let whole = began.elapsed();
    let mut killed = 0;
    for attempt in 0.. {
        if killed >= kills {
            break;
        }
        assert!(attempt < 20 * kills, "{killed} kills in {attempt} runs");
        for file in ["a.h5", "a.xdmf", "a.checkpoint.h5"] {
            let _ = fs::remove_file(place.path(file));
        }
        let mut arguments = vec!["run", "a.ron", "-q", "-o", "a.h5", "--force"];
        // Every run is killed up to three times.
        for round in 0..3 {
            let mut run = place.command(&arguments).spawn().unwrap();
            // Moments without pattern, over the whole length of the run and somewhat more.
            let part = ((attempt * 3 + round) * 7_919 % 997) as f64 / 997.0;
            sleep(whole.mul_f64(1.1 * part / f64::from(1 + round as u8)));
            let through = run.try_wait().unwrap().is_some();
            run.kill().unwrap();
            run.wait().unwrap();
            if through {
                break;
            }
            killed += 1;
            let rows = Results::open(place.path("a.h5")).map(|results| results.rows());
            match Checkpoint::open(place.path("a.checkpoint.h5")) {
                Ok(checkpoint) => {
                    // Whatever is killed, no more than four load steps (and the one being written) are lost.
                    let (rows, kept) = (rows.expect("the results are readable"), checkpoint.progress().rows());
                    assert!(kept <= rows && rows <= kept + 5, "{rows} rows, {kept} in the checkpoint");
                    arguments = vec!["resume", "a.checkpoint.h5", "-q"];
                }
                Err(error) => {
                    assert!(error.to_string().contains("No such file"), "{error}");
                    assert!(rows.unwrap_or(0) <= 5, "a checkpoint is due");
                }
            }
        }
        place.completes(&arguments);
        assert_same(&place.path("whole.h5"), &place.path("a.h5"));
    }
}

#[test]
fn runs_killed_at_any_moment_go_on_bit_for_bit() {
    survives_kills(100);
}

#[test]
fn signals_end_a_run_with_a_checkpoint_and_say_how_to_go_on() {
    let place = Place::with(600);
    place.completes(&["run", "a.ron", "-q", "-o", "whole.h5"]);
    // A scene that asks for no checkpoints gets one all the same.
    let scene = SCENE.replace("STEPS", "600").replace(", checkpoint: (every: 4)", "");
    fs::write(place.path("b.ron"), scene).unwrap();
    place.completes(&["run", "b.ron", "-q", "-o", "plain.h5"]);
    assert!(!place.path("plain.checkpoint.h5").exists(), "nobody asked for it");
    for (signal, scene, expected) in [("INT", "a.ron", "whole.h5"), ("TERM", "b.ron", "plain.h5")] {
        for earlier in ["c.xdmf", "c.h5", "c.checkpoint.h5"] {
            let _ = fs::remove_file(place.path(earlier));
        }
        let mut run = place.command(&["run", scene, "-q", "-o", "c.h5"]).spawn().unwrap();
        place.wait_for_rows("c.h5", 7, &mut run);
        let sent = Instant::now();
        let id = run.id().to_string();
        assert!(Command::new("sh").args(["-c", &format!("kill -{signal} {id}")]).status().unwrap().success());
        let output = run.wait_with_output().unwrap();
        let text = said(&output);
        assert_eq!(output.status.code(), Some(1), "{signal}: {text}");
        assert!(sent.elapsed() < Duration::from_secs(20), "{:?}", sent.elapsed());
        for part in ["interrupted at load fraction", "c.h5", "mpm resume c.checkpoint.h5"] {
            assert!(text.contains(part), "{part} in {text}");
        }
        let stopped = Results::open(place.path("c.h5")).unwrap();
        assert!(stopped.status().starts_with("failed: interrupted"), "{}", stopped.status());
        let kept = Checkpoint::open(place.path("c.checkpoint.h5")).unwrap().progress().rows();
        assert_eq!(kept, stopped.rows(), "no load step is lost");
        drop(stopped);
        assert!(kept < 601, "stopped on its way");
        place.completes(&["resume", "c.checkpoint.h5", "--quiet"]);
        assert_same(&place.path(expected), &place.path("c.h5"));
    }
}

#[test]
fn a_full_disk_ends_the_run_and_leaves_readable_files() {
    let place = Place::with(400);
    place.completes(&["run", "a.ron", "-q", "-o", "whole.h5"]);
    let size = fs::metadata(place.path("whole.h5")).unwrap().len();
    // In blocks of 512 bytes: nine tenths of the results.
    let limit = format!("trap '' XFSZ; ulimit -f {}", size * 9 / 10 / 512);
    let output = place.shell(&limit, "run a.ron -q -o a.h5");
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for part in ["File too large", "a.h5", "mpm resume a.checkpoint.h5"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let rows = Results::open(place.path("a.h5")).unwrap().rows();
    let kept = Checkpoint::open(place.path("a.checkpoint.h5")).unwrap().progress().rows();
    assert!(rows > 8 && kept + 4 >= rows, "{rows} rows, {kept} in the checkpoint");
    // Still full: the results of before stay as they are.
    let output = place.shell(&limit, "resume a.checkpoint.h5 -q");
    assert_ne!(output.status.code(), Some(0), "{}", said(&output));
    assert!(Results::open(place.path("a.h5")).unwrap().rows() >= kept);
    place.completes(&["resume", "a.checkpoint.h5", "-q"]);
    assert_same(&place.path("whole.h5"), &place.path("a.h5"));
}

/// A disk of its own that fills up, where the system lets us have one: unlike a limit on the size of files, it lets
/// files grow that it has no room for.
#[test]
fn a_small_disk_keeps_what_it_had_room_for() {
    let alone = |arguments: &[&str]| Command::new("unshare").args(["-rm"]).args(arguments).output();
    let can_mount = "mkdir -p disk && mount -t tmpfs -o size=64k none disk";
    let place = Place::with(60);
    let try_out = |script: &str| {
        alone(&["sh", "-c", &format!("cd \"$0\" && {script}"), place.path("").to_str().unwrap()])
    };
    if !try_out(can_mount).is_ok_and(|it| it.status.success()) {
        eprintln!("no disk of its own here: not tested");
        return;
    }
    place.completes(&["run", "a.ron", "-q"]);
    let size = fs::metadata(place.path("a.h5")).unwrap().len() / 1024;
    for part in 1..8 {
        // The disk disappears with the shell, so that its files are copied first.
        let (kilobytes, mpm) = (size * part / 5 + 64, env!("CARGO_BIN_EXE_mpm"));
        let output = try_out(&format!(
            "mkdir -p disk kept && mount -t tmpfs -o size={kilobytes}k none disk; \"{mpm}\" run a.ron -q -o disk/b.h5; \
             code=$?; cp disk/* kept; exit $code"
        ));
        let output = output.unwrap();
        let code = output.status.code();
        assert!(code == Some(0) || code == Some(1), "{kilobytes} kB: {}", said(&output));
        // There is no checkpoint where the disk had no room for the layout of the results.
        if Path::new(&place.path("kept/b.checkpoint.h5")).exists() {
            assert!(Results::open(place.path("kept/b.h5")).is_ok(), "{kilobytes} kB");
            place.completes(&["resume", "kept/b.checkpoint.h5", "-q", "-o", "kept/b.h5"]);
            assert_same(&place.path("a.h5"), &place.path("kept/b.h5"));
        }
        let _ = fs::remove_dir_all(place.path("kept"));
    }
}

#[test]
fn a_checkpoint_that_cannot_be_written_is_told_and_the_run_goes_on() {
    let place = Place::with(8);
    place.completes(&["run", "a.ron", "-q", "-o", "whole.h5"]);
    let full = Path::new("/dev/full");
    if full.exists() {
        let output = place.mpm(&["run", "a.ron", "-q", "-o", "/dev/full"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    }
    // The folder of the checkpoints goes away while the run goes.
    fs::create_dir(place.path("kept")).unwrap();
    fs::write(place.path("a.ron"), SCENE.replace("STEPS", "400")).unwrap();
    let arguments = ["run", "a.ron", "-q", "--checkpoint", "kept/c.h5", "--checkpoint-every", "1"];
    let mut run = place.command(&arguments).spawn().unwrap();
    place.wait_for_rows("a.h5", 3, &mut run);
    fs::rename(place.path("kept"), place.path("gone")).unwrap();
    place.wait_for_rows("a.h5", 100, &mut run);
    run.kill().unwrap();
    let text = said(&run.wait_with_output().unwrap());
    assert!(
        text.contains("warning: cannot write checkpoint kept/c.h5") && text.contains("No such file"),
        "{text}"
    );
    assert!(text.contains("the run goes on"), "{text}");
    // It can be gone on with from where it is now.
    assert!(Checkpoint::open(place.path("gone/c.h5")).is_ok());
}

#[test]
fn folders_that_cannot_be_written_are_refused_before_the_run() {
    let place = Place::with(8);
    fs::create_dir(place.path("read_only")).unwrap();
    let mut permissions = fs::metadata(place.path("read_only")).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(place.path("read_only"), permissions).unwrap();
    // A folder that not even the superuser can write into.
    let is_bound = fs::write(place.path("read_only/probe"), []).is_err();
    let folder = if is_bound { "read_only" } else { "/proc" };
    for arguments in [
        vec!["run", "a.ron", "-q", "-o", &format!("{folder}/a.h5")],
        vec!["run", "a.ron", "-q", "--checkpoint", &format!("{folder}/c.h5")],
        vec!["run", "a.ron", "-q", "--checkpoint", "read_only"],
    ] {
        let output = place.mpm(&arguments);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(
            text.contains("cannot create results file") || text.contains("cannot write checkpoint"),
            "{text}"
        );
    }
    assert!(!place.path("a.h5").exists());
}

#[test]
fn locked_and_deleted_results_are_told() {
    let place = Place::with(400);
    // Locked by another process.
    fs::write(place.path("locked.h5"), "of another program").unwrap();
    let other = fs::File::open(place.path("locked.h5")).unwrap();
    other.lock().unwrap();
    let output = place.mpm(&["run", "a.ron", "-q", "-o", "locked.h5"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("another program has the file open"), "{}", said(&output));
    assert_eq!(fs::read_to_string(place.path("locked.h5")).unwrap(), "of another program");

    // Deleted under the running simulation.
    let mut run = place.command(&["run", "a.ron", "-q", "-o", "a.h5"]).spawn().unwrap();
    place.wait_for_rows("a.h5", 9, &mut run);
    fs::remove_file(place.path("a.h5")).unwrap();
    let output = run.wait_with_output().unwrap();
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for part in ["a.h5", "deleted or replaced", "mpm resume a.checkpoint.h5"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let kept = Checkpoint::open(place.path("a.checkpoint.h5")).unwrap().progress().rows();
    assert!(kept >= 9, "{kept}");

    // The checkpoint is still there. The history goes on in a new file.
    let output = place.mpm(&["resume", "a.checkpoint.h5", "-q"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("is not there: name it by --output"), "{}", said(&output));
    let mut run = place.command(&["resume", "a.checkpoint.h5", "-q", "-o", "rest.h5"]).spawn().unwrap();
    place.wait_for_rows("rest.h5", 6, &mut run);
    run.kill().unwrap();
    run.wait().unwrap();
    let rest = Results::open(place.path("rest.h5")).unwrap();
    assert_eq!(rest.first_row(), kept);
}

#[test]
fn files_that_are_not_what_they_should_be_are_refused() {
    let place = Place::with(8);
    place.completes(&["run", "a.ron", "-q"]);
    let whole = fs::read(place.path("a.checkpoint.h5")).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 4;
    fs::write(place.path("flipped.h5"), &flipped).unwrap();
    fs::write(place.path("cut.h5"), &whole[..whole.len() / 3]).unwrap();
    fs::write(place.path("empty.h5"), []).unwrap();
    let results = fs::read(place.path("a.h5")).unwrap();
    for (file, part) in [
        ("none.h5", "cannot open checkpoint none.h5: No such file"),
        ("flipped.h5", "checkpoint flipped.h5: check sum: the file is damaged"),
        ("cut.h5", "checkpoint cut.h5: check sum: the file is damaged"),
        ("empty.h5", "checkpoint empty.h5: format: is not \"mpm-checkpoint\": this is no checkpoint"),
        ("a.h5", "checkpoint a.h5: format:"),
        ("a.ron", "checkpoint a.ron: format:"),
    ] {
        let output = place.mpm(&["resume", file, "-q"]);
        assert_eq!(output.status.code(), Some(2), "{file}: {}", said(&output));
        assert!(said(&output).contains(part), "{part} in {}", said(&output));
    }
    // The results of another scene, or of fewer load steps than the checkpoint counts on.
    fs::write(place.path("b.ron"), SCENE.replace("STEPS", "9")).unwrap();
    place.completes(&["run", "b.ron", "-q"]);
    fs::write(place.path("damaged.h5"), &results[..results.len() / 2]).unwrap();
    for (file, part) in [
        ("b.h5", "results file b.h5: scene: is another than that of the run"),
        ("damaged.h5", "cannot open results file damaged.h5"),
        ("a.checkpoint.h5", "is the checkpoint itself"),
    ] {
        let before = fs::read(place.path(file)).unwrap();
        let output = place.mpm(&["resume", "a.checkpoint.h5", "-q", "-o", file]);
        assert_eq!(output.status.code(), Some(2), "{file}: {}", said(&output));
        assert!(said(&output).contains(part), "{part} in {}", said(&output));
        assert_eq!(fs::read(place.path(file)).unwrap(), before, "{file} is untouched");
    }
    fs::copy(place.path("a.checkpoint.h5"), place.path("late.h5")).unwrap();
    let short = ["run", "a.ron", "-q", "-o", "short.h5", "--checkpoint-every", "1000"];
    let mut run = place.command(&short).spawn().unwrap();
    run.kill().unwrap();
    run.wait().unwrap();
    if Results::open(place.path("short.h5")).is_ok_and(|results| results.rows() < 9) {
        let output = place.mpm(&["resume", "late.h5", "-q", "-o", "short.h5"]);
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    }
}
