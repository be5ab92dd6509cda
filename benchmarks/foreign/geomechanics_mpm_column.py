"""The self-weight column of `scenes/column.ron` with geomechanics/mpm, the successor of CB-Geo's MPM, to be timed as a whole process.

    OMP_NUM_THREADS=1 python3 benchmarks/foreign/geomechanics_mpm_column.py BINARY [CELLS] [STEPS] [YOUNG] [FOLDER]

BINARY is the program `mpm` built from https://github.com/geomechanics/mpm. This script writes its input (`mpm.json`, mesh, sets, points) into FOLDER, the
current one unless named, runs it on one thread, and reads the HDF5 table of points that it leaves (with `h5py`, where there is one). Standard MPM, points of
finite strain, Hencky's law, 2² points a cell, Newton's method, sparse LU.

The program gives the weight at once and cannot raise it step by step; in one quasi-static step Newton's method turns this column inside out. The input
therefore asks for implicit dynamics, with Newmark parameters (1, 3/2) whose damping brings the column to rest: 40 seconds, of stiffer ground less, in as many
steps as the others have load steps. In one dimension, with finite elements, an error of 6e-9 is left of the hard column after 40 steps, of 2e-8 of the mild
one after 20. The format is that which the program's own tests write; this input has not been run.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

HEIGHT, WIDTH, DENSITY, GRAVITY = 50.0, 3.125, 80.0, 10.0
BASE, SIDES = 0, 1


def write_mesh(cells):
    """Nodes row by row, then the four nodes of each cell, anticlockwise."""
    rows = cells + 1
    lines = [f"{2 * rows} {cells}"]
    lines += [f"{side * WIDTH!r} {row * HEIGHT / cells!r}" for row in range(rows) for side in range(2)]
    lines += [f"{2 * row} {2 * row + 1} {2 * row + 3} {2 * row + 2}" for row in range(cells)]
    Path("mesh.txt").write_text("\n".join(lines) + "\n")
    sets = [{"id": BASE, "set": [0, 1]}, {"id": SIDES, "set": list(range(2 * rows))}]
    Path("sets.json").write_text(json.dumps({"node_sets": sets, "particle_sets": []}))


def write_points(cells):
    quarters = (0.25, 0.75)
    places = [((row + y) * HEIGHT / cells, x * WIDTH) for row in range(cells) for y in quarters for x in quarters]
    lines = [str(len(places))] + [f"{x!r} {y!r}" for y, x in places]
    Path("points.txt").write_text("\n".join(lines) + "\n")


def write_input(cells, steps, young):
    write_mesh(cells)
    write_points(cells)
    # Stiffer ground comes to rest sooner.
    duration = 40.0 * (1e4 / young) ** 0.25
    held = [{"nset_id": BASE, "dir": 1, "displacement": 0.0}, {"nset_id": SIDES, "dir": 0, "displacement": 0.0}]
    text = {
        "title": "Self-weight column",
        "mesh": {
            "mesh": "mesh.txt",
            "entity_sets": "sets.json",
            "io_type": "Ascii2D",
            "check_duplicates": False,
            "isoparametric": False,
            "node_type": "N2D",
            "cell_type": "ED2Q4",
            "boundary_conditions": {"displacement_constraints": held},
        },
        "particles": [
            {
                "generator": {
                    "type": "file",
                    "location": "points.txt",
                    "io_type": "Ascii2D",
                    "particle_type": "P2DFS",
                    "material_id": 0,
                    "pset_id": 0,
                    "check_duplicates": False,
                }
            }
        ],
        "materials": [
            {"id": 0, "type": "HenckyHyperElastic2D", "density": DENSITY, "youngs_modulus": young, "poisson_ratio": 0.0},
        ],
        "external_loading_conditions": {"gravity": [0.0, -GRAVITY]},
        "analysis": {
            "type": "MPMImplicit2D",
            "mpm_scheme": "newmark",
            "scheme_settings": {
                "nonlinear": True,
                "quasi_static": False,
                "beta": 1.0,
                "gamma": 1.5,
                "max_iteration": 20,
                "displacement_tolerance": 1e-10,
                "residual_tolerance": 1e-9,
                "relative_residual_tolerance": 1e-9,
                "verbosity": 0,
            },
            "velocity_update": False,
            "locate_particles": True,
            "pressure_smoothing": False,
            "dt": duration / steps,
            "nsteps": steps,
            "uuid": "column",
            "linear_solver": {
                "assembler_type": "EigenImplicit2D",
                "solver_settings": [
                    {
                        "dof": "displacement",
                        "solver_type": "DirectEigen",
                        "sub_solver_type": "lu",
                        "max_iter": 100,
                        "tolerance": 1e-12,
                        "verbosity": 0,
                    }
                ],
            },
        },
        "post_processing": {"path": "results/", "output_steps": steps},
    }
    Path("mpm.json").write_text(json.dumps(text, indent=1))


def stress_error(steps):
    """Mean error of the vertical stress in the table of the last step; None without `h5py`."""
    tables = sorted(Path("results/column").glob(f"*particles*{steps}.h5"))
    if not tables:
        sys.exit(f"geomechanics_mpm_column.py: the program has left no table of points; expected results/column/*particles*{steps}.h5")
    try:
        import h5py
    except ImportError:
        print("geomechanics_mpm_column.py: no error is printed, since there is no h5py to read the results with", file=sys.stderr)
        return None
    with h5py.File(tables[0]) as file:
        table = file["table"][:]
    weight = DENSITY * GRAVITY
    at_rest = table["coord_y"] - table["displacement_y"]
    return abs(table["stress_yy"] + weight * (HEIGHT - at_rest)).mean() / (weight * HEIGHT)


def main():
    words = sys.argv[1:]
    if not words or not os.access(words[0], os.X_OK):
        sys.exit("geomechanics_mpm_column.py: expected the program of geomechanics/mpm as the first argument")
    binary = Path(words[0]).absolute()
    cells, steps = (int(words[k]) if len(words) > k else default for k, default in ((1, 64), (2, 40)))
    young = float(words[3]) if len(words) > 3 else 1e4
    if len(words) > 4:
        os.chdir(words[4])
    shutil.rmtree("results", ignore_errors=True)
    write_input(cells, steps, young)
    done = subprocess.run([binary, "-f", f"{os.getcwd()}/", "-i", "mpm.json", "-p", "1"], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{binary} ended with code {done.returncode}: {(done.stderr or done.stdout).strip()[-2000:]}")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"processor seconds {used.ru_utime + used.ru_stime:.6f}")
    error = stress_error(steps)
    if error is not None:
        print(f"mean stress error {error:.6e}")


if __name__ == "__main__":
    main()
