//! Time, memory and traffic of one scene on one process and on ranks: `scaling [CELLS] [MOST RANKS]`.
//!
//! The scene is a block of CELLS³ cells with eight points each, elastic and with von Mises plasticity. `mpm` is run on one
//! thread. `mpm-mpi` is the program beside this one's folder.

use mpm_io::{FolderFiles, Options, Results, ResultsWriter};
use mpm_scene::{Scene, compile_with};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const LAWS: [(&str, &str); 2] = [
    ("elastic", "Hencky(young: 1e3, poisson: 0.3, density: 1)"),
    ("von Mises", "VonMises(young: 1e3, poisson: 0.3, yield_radius: 30, density: 1)"),
];

fn scene(cells: u32, law: &str) -> String {
    let n = f64::from(cells);
    let axis = format!("Uniform(from: 0, to: {n}, cells: {cells})");
    // The weight is that of a block of 24 cells, whatever the size.
    let g = 4.0 * 24.0 / n;
    format!(
        "Solid(
    mesh: Box(axes: [{axis}, {axis}, {axis}]),
    basis: Smpm,
    materials: {{ \"rock\": {law} }},
    bodies: [(name: \"block\", material: \"rock\", shape: Box(from: (0, 0, 0), to: ({n}, {n}, {n})), points_per_cell: 2)],
    supports: [
        (name: \"base\", region: Plane(axis: Y, at: 0), fix: [X, Y, Z]),
        (name: \"left\", region: Plane(axis: X, at: 0), fix: [X]),
        (name: \"back\", region: Plane(axis: Z, at: 0), fix: [Z]),
        (name: \"right\", region: Plane(axis: X, at: {n}), fix: [X]),
        (name: \"front\", region: Plane(axis: Z, at: {n}), fix: [Z]),
    ],
    loads: [BodyForce(acceleration: (0, -{g}, 0))],
    solver: Iterative,
    schedule: (steps: 1),
    output: (fields: []),
)
"
    )
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    match arguments.get(1).map(String::as_str) {
        Some("--alone") => return alone(Path::new(&arguments[2]), Path::new(&arguments[3])),
        Some("--watch") => return watch(&arguments[2..]),
        _ => {}
    }
    let number = |k: usize, default: u32| arguments.get(k).map_or(default, |it| it.parse().expect("a number"));
    let (cells, most) = (number(1, 48), number(2, 2));
    let folder = tempfile::tempdir().expect("a folder");
    println!(
        "{:>10} {:>8} {:>8} {:>9} {:>7} {:>7}  phases [s]",
        "law", "ranks", "wall s", "peak MB", "Newton", "linear"
    );
    for (name, law) in LAWS {
        let path = folder.path().join("block.ron");
        fs::write(&path, scene(cells, law)).expect("it is writable");
        for ranks in 0..=most {
            measured(name, ranks, &path, &folder.path().join("block.h5"));
        }
    }
}

/// Runs the scene on ranks, or on one process where there are none, and prints a line.
fn measured(name: &str, ranks: u32, scene: &Path, results: &Path) {
    let this = std::env::current_exe().expect("a program has a path");
    let program: PathBuf = this.parent().and_then(Path::parent).expect("a folder").join("mpm-mpi");
    let clock = Instant::now();
    let mut command = Command::new(if ranks == 0 { &this } else { Path::new("mpirun") });
    if ranks > 0 {
        command.args(["-n", &ranks.to_string(), "--oversubscribe"]).arg(&this);
        command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    }
    command.arg("--watch").env("OMP_NUM_THREADS", "1").env("RAYON_NUM_THREADS", "1");
    if ranks == 0 {
        command.arg(&this).arg("--alone").arg(scene).arg(results);
    } else {
        command.arg(&program).args(["run", "--quiet", "--force"]).arg(scene).arg("-o").arg(results);
        command.args(["--", "-mpm_traffic"]);
    }
    let output = command.stderr(Stdio::piped()).output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let wall = clock.elapsed().as_secs_f64();
    let peaks =
        String::from_utf8_lossy(&output.stdout).split_whitespace().map(String::from).collect::<Vec<_>>();
    let found = Results::open(results).expect("results");
    let phases = found.timings().expect("timings");
    let phases = phases.iter().filter(|it| it.seconds > 0.01);
    let phases: Vec<String> = phases.map(|it| format!("{} {:.2}", it.phase, it.seconds)).collect();
    let newton: usize = (0..found.rows()).map(|row| found.residuals(row).expect("a row").len()).sum();
    let linear: f64 = found.column("linear_iterations").expect("a column").values().iter().sum();
    let who = if ranks == 0 { "mpm".to_owned() } else { ranks.to_string() };
    println!(
        "{name:>10} {who:>8} {wall:>8.2} {:>9} {newton:>7} {linear:>7}  {}",
        peaks.join("+"),
        phases.join(", ")
    );
    said.lines().filter(|it| it.starts_with("rank ")).for_each(|it| println!("{:>20}{it}", ""));
}

/// Runs a scene on this process alone.
fn alone(path: &Path, results: &Path) {
    let text = fs::read_to_string(path).expect("the scene");
    let scene = Scene::from_ron(&text).expect("the scene");
    let mut compiled = compile_with(&scene, &FolderFiles::default()).expect("the scene");
    let fields = compiled.fields(scene.output()).expect("compiled with them");
    let options = Options { scene: text, ..Options::of(scene.output(), fields) };
    let mut writer = ResultsWriter::create(results, options).expect("it is writable");
    compiled.run(&mut writer).expect("it runs");
}

/// Runs a program, and prints the most memory that it has held [MB].
fn watch(arguments: &[String]) {
    let mut child = Command::new(&arguments[0]).args(&arguments[1..]).spawn().expect("it starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    let code = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let size = line.and_then(|it| it.split_whitespace().next()?.parse::<u64>().ok());
        peak = peak.max(size.unwrap_or(0));
        if let Some(code) = child.try_wait().expect("it is a child") {
            break code;
        }
        sleep(Duration::from_millis(20));
    };
    println!("{}", peak / 1000);
    std::process::exit(code.code().unwrap_or(1));
}
