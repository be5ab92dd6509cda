"""Whole processes of other programs beside `mpm`, on the self-weight column: processor time from start to end, and the error of the stress that it buys.

    cargo build --release -p mpm-cli
    python3 -m venv target/foreign && target/foreign/bin/pip install KratosMPMApplication scikit-fem scipy warp-lang pyamg h5py
    python3 benchmarks/foreign/peers.py [--cells 64] [--steps 40] [--young 1e4] [--repetitions 5] [--at-most 120]
        [--mpm target/release/mpm] [--python target/foreign/bin/python] [--ample FOLDER] [--octave octave-cli] [--geowarp FOLDER]
        [--geomechanics-mpm BINARY]

Each program is run on one thread, in turn with the others, and set up by a script of its own beside this one. What is not installed is left out, with a message;
what fails is a row without numbers, with a message, and code 1 at the end. The first run of each is not counted: it fills caches, and GeoWarp compiles its
kernels in it. Of what takes long there are fewer repetitions: no more begin once `--at-most` seconds of processor are used up.

Every program is compared with `mpm` on the same functions and cells. The last column is the mean of |σ_yy − exact| over the stress at the base.
"""

import argparse
import csv
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "benchmarks/foreign"
HEIGHT, WEIGHT = 50.0, 800.0
STANDARD, GIMP, SPLINES = "standard MPM", "GIMP", "splines of degree 2, CPDI1"


class Failure(Exception):
    """A program that did not do what it was asked to; the text is for the reader."""


@dataclass
class Program:
    name: str
    functions: str
    command: list
    beside: str
    """Functions of the runs of `mpm` that it is compared with."""
    seconds: list = field(default_factory=list)
    error: float | None = None
    failed: bool = False


def say(text):
    print(text, file=sys.stderr, flush=True)


def ask(command):
    """What a program prints; nothing where it does not start or fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def run(command, folder):
    """Processor time `[s]` of a process, or what it says of itself, and what it printed."""
    one_thread = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(command, cwd=folder, env={**os.environ, **one_thread}, capture_output=True, text=True, errors="replace")
    except OSError as error:
        raise Failure(f"{command[0]} does not start: {error.strerror}") from error
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise Failure(f"`{' '.join(map(str, command))}` ended with code {done.returncode}: {(done.stderr or done.stdout).strip()[-2000:]}")
    own = printed("processor seconds", done.stdout)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used if own is None else own, done.stdout


def printed(what, text):
    found = re.search(rf"^{what} (\S+)$", text, re.MULTILINE)
    return float(found[1]) if found else None


def of_mpm(arguments):
    """Runs of `mpm`: the scene on as many cells, its basis and functions set. Splines need cells that are about square."""
    program, column = arguments.mpm, ROOT / "scenes/column.ron"
    if not os.access(program, os.X_OK):
        sys.exit(f"there is no program {program}: build it by `cargo build --release -p mpm-cli`, or name it by --mpm")
    width = HEIGHT / arguments.cells
    square = [f"mesh.axes[0].to={width}", f"bodies[0].shape.to[0]={width}", f"supports[2].region.at={width}"]
    splines = ["basis=Cpdi1", "mesh.functions=Splines(degree: 2)", *square]
    version = ask([program, "--version"]) or "mpm"
    for functions, own in ((STANDARD, ["basis=Smpm"]), (GIMP, ["basis=Gimp"]), (SPLINES, splines)):
        settings = [f"mesh.axes[1].cells={arguments.cells}", f"schedule.steps={arguments.steps}", f"materials.ground.young={arguments.young}", *own]
        settings = [word for setting in settings for word in ("--set", setting)]
        command = [program, "run", column, "-q", "--force", "-o", "column.h5", "--threads", "1", *settings]
        yield Program(version, functions, command, functions)


def peers(arguments):
    """The other programs that are installed."""
    python, size = arguments.python, [str(arguments.cells), str(arguments.steps), str(arguments.young)]

    def has(*distributions):
        """Versions of Python's distributions; none where one is missing."""
        ask_version = "from importlib.metadata import version; import sys; print(*map(version, sys.argv[1:]))"
        return ask([python, "-c", ask_version, *distributions]).split()

    if kratos := has("KratosMPMApplication"):
        yield Program(f"Kratos MPM {kratos[0]}", STANDARD, [python, SCRIPTS / "kratos_column.py", *size], STANDARD)
    else:
        say(f"Kratos is left out: {python} has no KratosMPMApplication (`pip install KratosMPMApplication`; --python names another Python)")

    script = SCRIPTS / "geomechanics_mpm_column.py"
    binary = arguments.geomechanics_mpm
    if binary and os.access(binary, os.X_OK):
        yield Program("geomechanics/mpm", STANDARD, [python if python.is_file() else sys.executable, script, binary, *size], STANDARD)
    elif binary:
        say(f"geomechanics/mpm is left out: {binary} is not a program")
    else:
        say("geomechanics/mpm is left out: expected its program by --geomechanics-mpm BINARY")

    octave = ask([arguments.octave, "--version"]).splitlines()
    if not arguments.ample or not (arguments.ample / "functions").is_dir():
        say("AMPLE is left out: expected its folder, with a folder `functions` in it, by --ample FOLDER")
    elif not octave:
        say(f"AMPLE is left out: there is no `{arguments.octave}` to run it (GNU Octave; --octave names another)")
    else:
        version = octave[0].replace("GNU Octave, version", "Octave")
        command = [arguments.octave, "--no-init-file", SCRIPTS / "ample_column.m", arguments.ample, *size]
        yield Program(f"AMPLE, {version}", GIMP, [*command, "gimp"], GIMP)

    warp = has("warp-lang", "scipy", "pyamg")
    if not arguments.geowarp or not (arguments.geowarp / "solvers").is_dir():
        say("GeoWarp is left out: expected its folder, with a folder `solvers` in it, by --geowarp FOLDER")
    elif not warp:
        say(f"GeoWarp is left out: {python} has not all of warp-lang, scipy and pyamg (`pip install warp-lang scipy pyamg`)")
    else:
        yield Program(f"GeoWarp, Warp {warp[0]}", GIMP, [python, SCRIPTS / "geowarp_column.py", arguments.geowarp, *size], GIMP)

    if elements := has("scikit-fem", "scipy"):
        command = [python, SCRIPTS / "quadratic_elements.py", "--column", *size]
        yield Program(f"scikit-fem {elements[0]}", "quadratic elements", command, SPLINES)
    else:
        say(f"Quadratic elements are left out: {python} has not both scikit-fem and scipy (`pip install scikit-fem scipy`)")


def error_of_mpm(program, folder):
    """Mean error of the vertical stress in the results that `mpm` has left in a folder."""
    run([program, "export", "column.h5", "--csv", "-o", "tables"], folder)
    tables = sorted((folder / "tables").glob("points_*.csv"))
    if not tables:
        raise Failure(f"`{program} export` has left no tables of points")
    rest, end = ([row for row in csv.DictReader(table.open())] for table in (tables[0], tables[-1]))
    errors = [abs(float(now["cauchy_stress.yy"]) + WEIGHT * (HEIGHT - float(before["y"]))) for before, now in zip(rest, end)]
    shutil.rmtree(folder / "tables")
    return sum(errors) / (WEIGHT * HEIGHT * len(errors))


def first_run(program, ours, folder):
    """The run that is not counted: it tells the error, and whether the program works."""
    _, text = run(program.command, folder)
    program.error = error_of_mpm(program.command[0], folder) if ours else printed("mean stress error", text)


def attempt(program, step):
    """Does a step with a program; one that fails is not run again and loses no other its row."""
    try:
        step()
    except Failure as failure:
        program.failed = True
        say(f"{program.name}, {program.functions}: {failure}")


def measure(ours, others, arguments):
    programs = [*ours, *others]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for program in programs:
            attempt(program, lambda: first_run(program, program in ours, folder))
        for _ in range(arguments.repetitions):
            for program in programs:
                if not program.failed and sum(program.seconds) < arguments.at_most:
                    attempt(program, lambda: program.seconds.append(run(program.command, folder)[0]))


def row(program, ours):
    beside = next((it for it in ours if it.functions == program.beside and not it.failed), None)
    cells = [program.name, program.functions, "failed", "", "", ""]
    if not program.failed:
        median = statistics.median(program.seconds)
        cells[2:4] = f"{median:.3f}", str(len(program.seconds))
        cells[4] = f"{median / statistics.median(beside.seconds):.1f}" if beside else "–"
        cells[5] = "–" if program.error is None else f"{program.error:.3e}"
    return f"| {' | '.join(cells)} |"


def path(text):
    return Path(text).absolute()


def named(variable):
    """The path that a variable of the environment holds."""
    return path(os.environ[variable]) if os.environ.get(variable) else None


def main():
    parser = argparse.ArgumentParser(description="Whole processes of other programs beside `mpm`, on the self-weight column.")
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--young", type=float, default=1e4, help="Young's modulus [1e4; 1e6 is the mild column, in 20 steps]")
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--at-most", type=float, default=120.0, help="no more repetitions of a program that has used as many seconds [120]")
    parser.add_argument("--mpm", type=path, default=ROOT / "target/release/mpm")
    parser.add_argument("--python", type=path, default=ROOT / "target/foreign/bin/python", help="with Kratos, scikit-fem, Warp")
    parser.add_argument("--ample", type=path, default=named("AMPLE"), help="folder of AMPLE [the variable AMPLE]")
    parser.add_argument("--octave", default="octave-cli")
    parser.add_argument("--geowarp", type=path, default=named("GEOWARP"), help="folder of GeoWarp [the variable GEOWARP]")
    parser.add_argument("--geomechanics-mpm", type=path, default=named("GEOMECHANICS_MPM"), help="its program [the variable GEOMECHANICS_MPM]")
    arguments = parser.parse_args()
    if min(arguments.cells, arguments.steps, arguments.repetitions) < 1:
        sys.exit("expected at least one cell, one step and one repetition")
    ours, others = list(of_mpm(arguments)), list(peers(arguments))
    measure(ours, others, arguments)
    print(f"Self-weight column, {arguments.cells} cells, {arguments.steps} load steps, E = {arguments.young:g}:\n")
    print("| program | functions | seconds of processor | runs | over mpm on the same | mean error of the stress |\n|:--|:--|--:|--:|--:|--:|")
    for program in (*ours, *others):
        print(row(program, ours))
    if any(program.failed for program in (*ours, *others)):
        sys.exit(1)


if __name__ == "__main__":
    main()
