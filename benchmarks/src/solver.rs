//! Both linear solvers on tangents of whole problems, against other libraries where those are installed.

use crate::kernels::Connected;
use crate::machine::timed;
use crate::report::{Report, Settings};
use crate::skewed::Skewed;
use crate::{Failure, blocks};
use mpm_assembly::finish_tangent;
use mpm_grid::LoadFraction;
use mpm_linear::{Automatic, Choice, Hints, LatticePlaces, LinearSolver, Matrix, Pattern, predict};
use mpm_scene::language::{Scene, SolidBasis};
use mpm_scene::{Compiled, compile};
use mpm_solver::Model;
use mpm_validation::Table;
use mpm_validation::problems::{doughnut, vortex};
use mpm_validation::scenes::load;
use mpm_validation::variants::{CPDI1, GIMP, SMPM, plane, refined};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::Command;

/// One solver on one tangent.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Whose tangent.
    pub problem: &'static str,
    /// Dimensions of space.
    pub dimensions: usize,
    /// Equations, prescribed ones included.
    pub equations: usize,
    /// Stored entries of the lower triangle.
    pub entries: usize,
    /// The solver.
    pub solver: String,
    /// Processor seconds, the least of the repetitions.
    pub seconds: Seconds,
    /// The time of the one of ours that a run takes over this solver's, all steps together.
    pub ours_over_this: f64,
}

/// Processor seconds of the steps of one solver.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Seconds {
    /// Order and symbolic factorisation.
    pub analyse: f64,
    /// Numeric factorisation.
    pub factorise: f64,
    /// One right-hand side, refinement included where the solver refines.
    pub solve: f64,
    /// Largest residual over the largest right-hand side.
    pub error: f64,
}

impl Seconds {
    fn total(&self) -> f64 {
        self.analyse + self.factorise + self.solve
    }

    /// The least of each step.
    fn least(self, other: Self) -> Self {
        Self {
            analyse: self.analyse.min(other.analyse),
            factorise: self.factorise.min(other.factorise),
            solve: self.solve.min(other.solve),
            error: self.error.max(other.error),
        }
    }
}

struct Problem {
    name: &'static str,
    scene: fn() -> Result<Scene, Failure>,
    /// Load steps are taken before, so that the points lie anywhere in their cells.
    moved: bool,
    quick: bool,
}

const fn problem(name: &'static str, moved: bool, scene: fn() -> Result<Scene, Failure>) -> Problem {
    Problem { name, scene, moved, quick: false }
}

const PROBLEMS: [Problem; 11] = [
    Problem { quick: true, ..problem("block, sMPM, 24²", false, || blocks::plane(&SMPM, 24, 1)) },
    problem("block, sMPM, 100²", false, || blocks::plane(&SMPM, 100, 1)),
    problem("block, GIMP, 100²", true, || blocks::plane(&GIMP, 100, 1)),
    problem("doughnut twist, CPDI1, 40 × 256", false, || Ok(Scene::PlaneStrain(doughnut::ring(&CPDI1, 8)?))),
    problem("vortex, CPDI1, 288²", false, || Ok(Scene::PlaneStrain(vortex::vortex(&CPDI1, 12)?))),
    problem("cantilever, GIMP, 240 × 24", false, || {
        Ok(Scene::PlaneStrain(refined(GIMP.of(plane(load("cantilever")?)?), 12)))
    }),
    problem("block, sMPM, 224²", false, || blocks::plane(&SMPM, 224, 1)),
    problem("block, sMPM, 500²", false, || blocks::plane(&SMPM, 500, 1)),
    problem("block, sMPM, 21³", false, || blocks::solid(SolidBasis::Smpm, 21, 1)),
    problem("block, sMPM, 32³", false, || blocks::solid(SolidBasis::Smpm, 32, 1)),
    problem("block, sMPM, 40³", false, || blocks::solid(SolidBasis::Smpm, 40, 1)),
];

/// A linear system.
struct Tangent {
    dimensions: usize,
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
    lattice: Vec<[u32; 3]>,
    lines: [Vec<f64>; 3],
    periodic: [Option<u32>; 3],
    rhs: Vec<f64>,
}

impl Tangent {
    fn of<const D: usize>(model: Model<D>, at: LoadFraction) -> Result<Self, Failure> {
        let layout = model.layout.clone();
        let mut connected = Connected::of(model, at)?;
        connected.pass(true);
        finish_tangent(&connected.pattern, &connected.constraints, &mut connected.values);
        let lattice = connected.mesh.lattice();
        let mut lines: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0]);
        for (padded, lines) in lines.iter_mut().zip(layout.lines()) {
            *padded = lines;
        }
        let (periodic, nodes) = (lattice.periodic(), lattice.nodes());
        let n = connected.pattern.n_equations();
        Ok(Self {
            dimensions: D,
            column_start: connected.pattern.column_start().to_vec(),
            row: connected.pattern.row().to_vec(),
            values: connected.values,
            lattice: connected.active.lattice_indices(),
            lines,
            periodic: std::array::from_fn(|d| (d < D && periodic[d]).then(|| nodes[d])),
            rhs: (0..n).map(|k| (k as f64 * 0.1).sin()).collect(),
        })
    }

    fn of_scene(problem: &Problem) -> Result<Self, Failure> {
        let mut compiled = compile(&(problem.scene)()?)?;
        if problem.moved {
            compiled.run(&mut ())?;
        }
        let at = if problem.moved { LoadFraction::END } else { LoadFraction::START };
        match compiled {
            Compiled::Plane(model) => Self::of(model, at),
            Compiled::Solid(model) => Self::of(model, at),
        }
    }

    /// Numbers of eight bytes, least first: n, entries, column starts, rows, values, right-hand side.
    fn write(&self, path: &Path) -> Result<(), Failure> {
        let mut bytes = Vec::with_capacity(16 * (self.row.len() + self.rhs.len()) + 32);
        let sizes = [self.rhs.len(), self.row.len()];
        for number in sizes.iter().chain(&self.column_start).chain(&self.row) {
            bytes.extend((*number as i64).to_le_bytes());
        }
        for number in self.values.iter().chain(&self.rhs) {
            bytes.extend(number.to_le_bytes());
        }
        std::fs::write(path, bytes).map_err(|error| format!("{}: {error}", path.display()).into())
    }

    /// One of our solvers; conjugate gradients leave [`LEFT`] of the right-hand side.
    fn ours(&self, choice: Choice) -> Result<Seconds, Failure> {
        let (mut solver, matrix) = (Automatic::new(choice), self.matrix());
        let analysis = timed(|| solver.analyse(matrix.pattern, &Hints::on_lattice(self.places())));
        analysis.result?;
        let first = solver.first_method();
        let factor = timed(|| solver.factorise(matrix));
        if factor.result?.method != first {
            return Err("the tangent is not positive definite".into());
        }
        let mut x = self.rhs.clone();
        let solution = timed(|| solver.solve(matrix, &mut x, LEFT));
        if solution.result?.method != first {
            return Err("conjugate gradients needed help".into());
        }
        Ok(Seconds {
            analyse: analysis.processor,
            factorise: factor.processor,
            solve: solution.processor,
            error: self.error(&x),
        })
    }

    /// LU or GMRES of the matrix made unsymmetric; none where GMRES needed help.
    fn skewed(&self, choice: Choice) -> Result<Option<Seconds>, Failure> {
        let skewed = Skewed::of(self.matrix());
        let (mut solver, matrix) = (Automatic::new(choice), skewed.matrix());
        let analysis = timed(|| solver.analyse(matrix.pattern, &Hints::on_lattice(self.places())));
        analysis.result?;
        let factor = timed(|| solver.factorise(matrix));
        factor.result?;
        let mut x = self.rhs.clone();
        let solution = timed(|| solver.solve(matrix, &mut x, LEFT));
        if solution.result?.taken_over.is_some() {
            return Ok(None);
        }
        let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let residual: Vec<f64> = matrix.times(&x).iter().zip(&self.rhs).map(|(kx, b)| b - kx).collect();
        Ok(Some(Seconds {
            analyse: analysis.processor,
            factorise: factor.processor,
            solve: solution.processor,
            error: largest(&residual) / largest(&self.rhs),
        }))
    }

    fn matrix(&self) -> Matrix<'_> {
        let pattern = Pattern::symmetric(&self.column_start, &self.row, self.dimensions);
        Matrix { pattern, values: &self.values }
    }

    fn places(&self) -> LatticePlaces<'_> {
        LatticePlaces { index: &self.lattice, lines: &self.lines, periods: self.periodic, degree: [1; 3] }
    }

    /// Which of our solvers a run takes.
    fn chosen(&self) -> Choice {
        let prediction = predict(self.matrix().pattern, self.places());
        if Choice::Auto.is_iterative(&prediction) { Choice::Iterative } else { Choice::Direct }
    }

    /// Largest residual over the largest right-hand side.
    fn error(&self, x: &[f64]) -> f64 {
        let mut residual = self.rhs.clone();
        for (column, entries) in self.column_start.windows(2).enumerate() {
            for k in entries[0]..entries[1] {
                let row = self.row[k];
                residual[row] -= self.values[k] * x[column];
                if row != column {
                    residual[column] -= self.values[k] * x[row];
                }
            }
        }
        let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        largest(&residual) / largest(&self.rhs)
    }
}

/// Our solvers, and what they are called.
const OURS: [(&str, Choice); 2] = [("ours, direct", Choice::Direct), ("ours, iterative", Choice::Iterative)];

/// The same on the matrix made unsymmetric.
const SKEWED: [(&str, Choice); 2] = [
    ("ours, LU of it made unsymmetric", Choice::Direct),
    ("ours, GMRES of it made unsymmetric", Choice::Iterative),
];

/// Part of the right-hand side that iterations leave; a run leaves more in most iterations.
const LEFT: f64 = 1e-10;

/// Equations in space beyond which a minimum-degree order takes minutes, and is left out.
const MOST_BY_DEGREE: usize = 50_000;

/// A solver in a program of its own.
struct Foreign {
    name: String,
    program: PathBuf,
    /// What follows the matrix on its command line.
    argument: String,
}

impl Foreign {
    fn solve(&self, matrix: &Path) -> Result<Seconds, Failure> {
        let mut command = Command::new(&self.program);
        command.arg(matrix).arg(&self.argument);
        for threads in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
            command.env(threads, "1");
        }
        // OpenBLAS recognises few processors by name, and may leave instructions unused that this one has.
        let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        if known.contains("avx512vl") {
            command.env("OPENBLAS_CORETYPE", "SkylakeX");
        }
        let output = command.output()?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            return Err(format!("{}: {said}", self.name).into());
        }
        Ok(serde_json::from_slice(&output.stdout)?)
    }
}

/// The solvers that can be had here; says which cannot.
fn foreign(folder: &Path) -> Result<Vec<Foreign>, Failure> {
    std::fs::create_dir_all(folder)?;
    let mut found = Vec::new();
    match build("cholmod", "-lcholmod", folder) {
        Ok(program) => {
            for order in ["amd", "metis"] {
                let (name, program) = (format!("CHOLMOD, {order}"), program.clone());
                found.push(Foreign { name, program, argument: order.into() });
            }
        }
        Err(why) => println!("left out: CHOLMOD (Debian package `libsuitesparse-dev`): {why}"),
    }
    let pardiso = mkl().and_then(|library| Ok((build("pardiso", "-ldl", folder)?, library)));
    match pardiso {
        Ok((program, library)) => {
            found.push(Foreign { name: "PARDISO".into(), program, argument: library.display().to_string() })
        }
        Err(why) => println!("left out: PARDISO (Python package `mkl`): {why}"),
    }
    Ok(found)
}

fn build(name: &str, library: &str, folder: &Path) -> Result<PathBuf, Failure> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("foreign").join(name).with_extension("c");
    let program = folder.join(name);
    let output = Command::new("cc")
        .args(["-O2".as_ref(), source.as_os_str(), "-o".as_ref(), program.as_os_str()])
        .args([library, "-lm"])
        .output()
        .map_err(|error| format!("cc does not run: {error}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(said.lines().next().unwrap_or("cc fails").to_owned().into());
    }
    // A bare name would be looked up along the path.
    Ok(std::fs::canonicalize(program)?)
}

/// `libmkl_rt`, as the variable `MPM_MKL` says or from a Python environment in `target/foreign`.
fn mkl() -> Result<PathBuf, Failure> {
    if let Some(path) = std::env::var_os("MPM_MKL") {
        return Ok(path.into());
    }
    let folder = Path::new("target/foreign/lib");
    let files = std::fs::read_dir(folder).map_err(|_| format!("no libmkl_rt in {}", folder.display()))?;
    let mut names: Vec<PathBuf> = files.map(|file| file.map(|it| it.path())).collect::<Result<_, _>>()?;
    names.retain(|path| path.to_string_lossy().contains("libmkl_rt.so"));
    names.sort();
    let library = names.pop().ok_or_else(|| format!("no libmkl_rt in {}", folder.display()))?;
    Ok(std::fs::canonicalize(library)?)
}

/// Runs the set, on problems of at most so many equations.
///
/// # Errors
/// A scene cannot be made, or a solver fails.
pub fn run(settings: &Settings, most_equations: usize) -> Result<Report<Vec<Row>>, Failure> {
    let folder = settings.output.join("foreign");
    let foreign = foreign(&folder)?;
    let matrix = folder.join("matrix.bin");
    let mut rows = Vec::new();
    for problem in PROBLEMS.iter().filter(|problem| problem.quick == settings.quick) {
        let tangent = Tangent::of_scene(problem)?;
        if tangent.rhs.len() > most_equations {
            println!("left out: {} has {} equations", problem.name, tangent.rhs.len());
            continue;
        }
        tangent.write(&matrix)?;
        let large = tangent.dimensions == 3 && tangent.rhs.len() > MOST_BY_DEGREE;
        let foreign: Vec<&Foreign> = foreign.iter().filter(|it| !(large && it.argument == "amd")).collect();
        let mut found: Vec<(String, Seconds)> = Vec::new();
        for (name, choice) in OURS {
            found.push((name.into(), tangent.ours(choice)?));
        }
        let mut skewed = Vec::new();
        for (_, choice) in SKEWED {
            skewed.push(tangent.skewed(choice)?);
        }
        for solver in &foreign {
            found.push((solver.name.clone(), solver.solve(&matrix)?));
        }
        // Short ones again, in turn: a machine that others use is not the same from one second to the next.
        let spent: f64 = found.iter().map(|(_, seconds)| seconds.total()).sum();
        let repetitions = if settings.quick || spent > 40.0 { 0 } else { 2 };
        for _ in 0..repetitions {
            for ((_, choice), (_, least)) in OURS.iter().zip(&mut found) {
                *least = least.least(tangent.ours(*choice)?);
            }
            for ((_, choice), least) in SKEWED.iter().zip(&mut skewed) {
                if let Some(found) = least {
                    *least = tangent.skewed(*choice)?.map(|again| found.least(again));
                }
            }
            for (solver, (_, least)) in foreign.iter().zip(&mut found[OURS.len()..]) {
                *least = least.least(solver.solve(&matrix)?);
            }
        }
        let chosen = tangent.chosen();
        let taken = OURS.iter().position(|(_, choice)| *choice == chosen).expect("it is one of ours");
        let ours = found[taken].1.total();
        for ((name, _), seconds) in SKEWED.iter().zip(skewed) {
            match seconds {
                Some(seconds) => found.push(((*name).into(), seconds)),
                None => println!("left out: {name}, {}: it does not converge", problem.name),
            }
        }
        for (solver, seconds) in found {
            eprintln!("{}, {solver}: {:.3} s", problem.name, seconds.total());
            rows.push(Row {
                problem: problem.name,
                dimensions: tangent.dimensions,
                equations: tangent.rhs.len(),
                entries: tangent.row.len(),
                ours_over_this: ours / seconds.total(),
                solver,
                seconds,
            });
        }
        std::fs::remove_file(&matrix)?;
    }
    Ok(Report { set: "solver", tables: vec![table(&rows)], pictures: Vec::new(), results: rows })
}

fn table(rows: &[Row]) -> Table {
    let heads = [
        "problem",
        "equations",
        "solver",
        "order + analyse",
        "factorise",
        "solve",
        "all",
        "residual",
        "ours/this",
    ];
    let text = "Processor seconds on one thread; the last column is the time of the one of ours that a run takes over that solver's.";
    let mut table = Table::new(text, &heads);
    for row in rows {
        let Seconds { analyse, factorise, solve, error } = row.seconds;
        table.push([
            row.problem.to_owned(),
            row.equations.to_string(),
            row.solver.clone(),
            format!("{analyse:.3}"),
            format!("{factorise:.3}"),
            format!("{solve:.3}"),
            format!("{:.3}", row.seconds.total()),
            format!("{error:.0e}"),
            format!("{:.2}", row.ours_over_this),
        ]);
    }
    table
}
