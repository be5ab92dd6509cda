"""The self-weight column of `scenes/column.ron` with GeoWarp on the processor, to be timed as a whole process.

    python3 -m venv target/foreign && target/foreign/bin/pip install warp-lang scipy pyamg
    git clone https://github.com/choo-group/GeoWarp
    OMP_NUM_THREADS=1 target/foreign/bin/python benchmarks/foreign/geowarp_column.py GEOWARP_FOLDER [CELLS] [STEPS] [YOUNG] [warp|pyamg|scipy]

GIMP, implicit and quasi-static, the tangent by automatic differentiation, Hencky's law, 2² points a cell, the weight in as many equal steps, Newton's method
to 1e-9 of the weight. The linear solver is SciPy's sparse LU unless another is named. GeoWarp's cells are squares and its body begins one cell within the
mesh: the column is one cell wide, and since its sides are held and Poisson's ratio is zero, its width changes nothing. Warp compiles its kernels at the
first run and keeps them: time a later one. Prints the mean error of the vertical stress.
"""

import contextlib
import io
import os
import sys
from pathlib import Path

HEIGHT, DENSITY, GRAVITY = 50.0, 80.0, 10.0


def column(cells, young, linear_solver):
    """GeoWarp's solver with the column in it, its sides and base held."""
    import warp
    from solvers.quasi_static_solver_2d import quasi_static_solver_2d

    side = HEIGHT / cells
    across, along = 3, cells + 2
    solver = quasi_static_solver_2d(
        background_grid_dict={
            "n_grid_x": across,
            "n_grid_y": along,
            "max_x": across * side,
            "dx": side,
            "start_x": side,
            "end_x": 2 * side,
            "start_y": side,
            "end_y": side + HEIGHT,
        },
        particles_dict={"n_particles": 4 * cells, "PPD": 2, "p_vol": (side / 2) ** 2, "p_rho": DENSITY},
        iteration_dict={"n_iter": 20, "tol": 1e-9 * DENSITY * GRAVITY * HEIGHT * side, "solver_name": linear_solver},
        material_dict={"youngs_modulus": young, "poisson_ratio": 0.0, "material_name": "Hencky elasticity"},
        load_dict={
            "gravity_mag": GRAVITY,
            "traction_value_x": 0.0,
            "traction_value_y": 0.0,
            "point_load_value_x": 0.0,
            "point_load_value_y": 0.0,
        },
    )
    # Nodes go row by row; all displacements across come before all those along the column.
    row = 1 + across
    nodes = row * (along + 1)
    held = [dof < nodes + 2 * row for dof in range(2 * nodes)]
    solver.dofStruct.boundary_flag_array = warp.array(held, dtype=warp.bool)
    return solver


def main():
    words = sys.argv[1:]
    if not words or not (Path(words[0]) / "solvers/quasi_static_solver_2d.py").is_file():
        sys.exit("geowarp_column.py: expected the folder of GeoWarp, with `solvers/quasi_static_solver_2d.py` in it, as the first argument")
    cells, steps = (int(words[k]) if len(words) > k else default for k, default in ((1, 64), (2, 40)))
    young = float(words[3]) if len(words) > 3 else 1e4
    linear_solver = words[4] if len(words) > 4 else "scipy"
    sys.path.insert(0, os.path.abspath(words[0]))
    import numpy as np
    import warp

    warp.config.quiet = True
    warp.set_device("cpu")
    with contextlib.redirect_stdout(io.StringIO()):
        solver = column(cells, young, linear_solver)
        at_rest = solver.x_particles.numpy()[:, 1] - solver.start_y
        for step in range(steps):
            solver.advance_one_step(step, steps)
    if np.linalg.norm(solver.rhs.numpy()) >= solver.tol:
        sys.exit("geowarp_column.py: Newton's method has not converged in the last load step")
    stress = solver.particle_Cauchy_stress_array.numpy()[:, 1, 1]
    exact = -DENSITY * GRAVITY * (HEIGHT - at_rest)
    print(f"{len(stress)} points, highest at {solver.x_particles.numpy()[:, 1].max() - solver.start_y}")
    print(f"mean stress error {np.abs(stress - exact).mean() / (DENSITY * GRAVITY * HEIGHT):.6e}")


if __name__ == "__main__":
    main()
