//! `mpm-benchmarks [SET] [--quick] [--output FOLDER]`: runs a set of benchmarks.

use clap::{Parser, Subcommand};
use mpm_benchmarks::counts::{self, Act};
use mpm_benchmarks::report::{Settings, print_table};
use mpm_benchmarks::{
    Failure, growth, laws, phases, ranks, small, solver, space, threads, throughput, time_against_error,
};
use std::path::PathBuf;
use std::process::ExitCode;

/// Benchmarks of the implicit Material Point Method. Without a set: a short run of the first two.
#[derive(Parser)]
#[command(name = "mpm-benchmarks", version)]
struct Arguments {
    #[command(subcommand)]
    set: Option<Set>,
    /// Small sizes, one repetition: shows that everything works, measures nothing.
    #[arg(long, global = true)]
    quick: bool,
    /// Folder of the results.
    #[arg(long, global = true, default_value = "target/benchmarks")]
    output: PathBuf,
}

#[derive(Subcommand)]
enum Set {
    /// Processor time against error for every basis on problems with a known answer.
    Error,
    /// Points per second in every phase of every basis, beside memory bandwidth and peak flops.
    Throughput,
    /// Time and peak memory against the number of points, 10³ to 10⁶.
    Growth,
    /// Order, analysis, factorisation and solution, against CHOLMOD and PARDISO where installed.
    Solver {
        /// Larger problems are left out.
        #[arg(long, default_value_t = usize::MAX)]
        most_equations: usize,
    },
    /// Cubes in space up to two million points: seconds per phase, memory, iterations.
    Space,
    /// The pass over the points under every law, in pairs with von Mises.
    Laws,
    /// Whole processes of `mpm` on small scenes: what start, reading and output cost.
    Small {
        /// The program; that built beside this one if left out.
        #[arg(long)]
        program: Option<PathBuf>,
    },
    /// Whole processes of `mpm` on one thread and on two.
    Threads {
        /// The program; that built beside this one if left out.
        #[arg(long)]
        program: Option<PathBuf>,
    },
    /// Ranks of `mpm-mpi` against `mpm`: time by phase, memory, traffic, answers, and a model of 10⁹ points.
    Ranks {
        /// Cells along an edge of the block.
        #[arg(long, value_parser = clap::value_parser!(u32).range(2..=400))]
        cells: Option<u32>,
        /// The program `mpm`; that built beside this one if left out.
        #[arg(long)]
        program: Option<PathBuf>,
        /// The program `mpm-mpi`; that of its workspace if left out.
        #[arg(long)]
        mpm_mpi: Option<PathBuf>,
    },
    /// Instructions of a fixed set of kernels by callgrind, against the file of the repository.
    Counts {
        /// Fails where a kernel needs more instructions than the file allows.
        #[arg(long, conflicts_with = "update")]
        check: bool,
        /// Writes the file.
        #[arg(long)]
        update: bool,
        /// Part of the names of the kernels; all if left out.
        #[arg(default_value = "")]
        part: String,
    },
    /// Seconds per phase and peak memory of scenes, on one thread and on two.
    Phases {
        /// Scene files; those of the benchmarks if left out.
        scenes: Vec<PathBuf>,
    },
    /// The runs behind the reference of the cantilever, on meshes refined by these factors.
    #[command(hide = true)]
    CantileverEnd { factors: Vec<u32> },
    /// One run in a process of its own, for the other sets.
    #[command(hide = true)]
    One { scene: PathBuf, threads: usize },
    /// One kernel, for callgrind.
    #[command(hide = true)]
    Kernel { name: String },
    /// One cube in a process of its own.
    #[command(hide = true)]
    Cube { cells: u32, steps: u32, threads: usize },
    /// One block in a process of its own.
    #[command(hide = true)]
    Block { basis: String, cells: u32 },
}

/// Exit code where a program that is to be started has not been built.
const NOT_BUILT: u8 = 2;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let settings = Settings { quick: arguments.quick, output: arguments.output };
    match run(arguments.set, settings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{failure}");
            match failure.is::<ranks::NotBuilt>() {
                true => ExitCode::from(NOT_BUILT),
                false => ExitCode::FAILURE,
            }
        }
    }
}

fn run(set: Option<Set>, settings: Settings) -> Result<(), Failure> {
    match set {
        None => {
            println!(
                "sets: error, throughput, growth, solver, space, laws, small, threads, ranks, counts, phases (`--help` says more)"
            );
            let settings = Settings { quick: true, ..settings };
            time_against_error::run(&settings)?.publish(&settings)?;
            throughput::run(&settings)?.publish(&settings)
        }
        Some(Set::Throughput) => throughput::run(&settings)?.publish(&settings),
        Some(Set::Small { program }) => small::run(&settings, program)?.publish(&settings),
        Some(Set::Threads { program }) => threads::run(&settings, program)?.publish(&settings),
        Some(Set::Growth) => growth::run(&settings)?.publish(&settings),
        Some(Set::Solver { most_equations }) => solver::run(&settings, most_equations)?.publish(&settings),
        Some(Set::Ranks { cells, program, mpm_mpi }) => {
            ranks::run(&settings, cells, [program, mpm_mpi])?.publish(&settings)
        }
        Some(Set::Counts { check, update, part }) => {
            let act = if update {
                Act::Update
            } else if check {
                Act::Check
            } else {
                Act::Show
            };
            counts::run(&settings, act, &part)
        }
        Some(Set::Kernel { name }) => counts::one(&name),
        Some(Set::Block { basis, cells }) => print(&growth::block(&basis, cells)?),
        Some(Set::Laws) => laws::run(&settings)?.publish(&settings),
        Some(Set::Space) => space::run(&settings)?.publish(&settings),
        Some(Set::Cube { cells, steps, threads }) => print(&space::cube(cells, steps, threads)?),
        Some(Set::Error) => time_against_error::run(&settings)?.publish(&settings),
        Some(Set::Phases { scenes }) => phases::run(&scenes, &settings)?.publish(&settings),
        Some(Set::CantileverEnd { factors }) => {
            print_table(&time_against_error::cantilever_end(&factors)?);
            Ok(())
        }
        Some(Set::One { scene, threads }) => print(&phases::one(&scene, threads)?),
    }
}

fn print(result: &impl serde::Serialize) -> Result<(), Failure> {
    println!("{}", serde_json::to_string(result)?);
    Ok(())
}
