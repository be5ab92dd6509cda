"""Whole processes of other programs beside `mpm`, on the self-weight column: processor time from start to end, medians of runs in turn.

    cargo build --release -p mpm-cli
    python3 -m venv target/foreign && target/foreign/bin/pip install KratosMPMApplication
    python3 benchmarks/foreign/peers.py [--cells 64] [--steps 40] [--repetitions 5] [--python target/foreign/bin/python] [--mpm target/release/mpm]

Each program is run on one thread. What is not installed is left out, with a message.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def processor_seconds(command, folder):
    """Processor time of one process `[s]`; ends this one where it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"}, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed: {done.stderr.strip()}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def has_module(python, name):
    found = subprocess.run([python, "-c", f"import importlib.util, sys; sys.exit(importlib.util.find_spec('{name}') is None)"], capture_output=True)
    return found.returncode == 0


def programs(arguments):
    """Names and commands of what is installed; `mpm` first."""
    column, python = ROOT / "scenes/column.ron", arguments.python
    if not arguments.mpm.is_file():
        sys.exit(f"there is no program {arguments.mpm}: build it by `cargo build --release -p mpm-cli`, or name it by --mpm")
    settings = [f"mesh.axes[1].cells={arguments.cells}", f"schedule.steps={arguments.steps}", "basis=Smpm"]
    settings = [word for setting in settings for word in ("--set", setting)]
    yield "mpm", [arguments.mpm, "run", column, "-q", "--force", "-o", "column.h5", "--threads", "1", *settings]
    if python.is_file() and has_module(python, "KratosMultiphysics"):
        yield "Kratos MPM", [python, ROOT / "benchmarks/foreign/kratos_column.py", str(arguments.cells), str(arguments.steps)]
    else:
        print(f"Kratos is left out: {python} has no KratosMPMApplication", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--python", type=lambda path: Path(path).absolute(), default=ROOT / "target/foreign/bin/python")
    parser.add_argument("--mpm", type=lambda path: Path(path).absolute(), default=ROOT / "target/release/mpm")
    arguments = parser.parse_args()
    installed = list(programs(arguments))
    seconds = {name: [] for name, _ in installed}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.repetitions):
            for name, command in installed:
                seconds[name].append(processor_seconds(command, folder))
    ours = statistics.median(seconds["mpm"])
    print(f"Self-weight column, {arguments.cells} cells, {arguments.steps} load steps:\n")
    print("| program | seconds of processor | over mpm |\n|:--|--:|--:|")
    for name, times in seconds.items():
        median = statistics.median(times)
        print(f"| {name} | {median:.3f} | {median / ours:.1f} |")


main()
