"""The self-weight column of `scenes/column.ron` with the MPM of Kratos Multiphysics, to be timed as a whole process.

    python3 -m venv target/foreign && target/foreign/bin/pip install KratosMPMApplication
    OMP_NUM_THREADS=1 target/foreign/bin/python benchmarks/foreign/kratos_column.py [CELLS] [STEPS] [YOUNG] [FOLDER]

Standard MPM, implicit and quasi-static, updated Lagrangian elements with four points a cell, a neo-Hookean law (Kratos has no elastic Hencky law for
points), the weight in as many equal steps, Newton's method to 1e-8. The law decides how far the column settles, but the exact vertical stress is the weight
above a point under every law: the mean error of the stress, printed at the end, compares with that of the others.
"""

import json
import os
import sys

HEIGHT, WIDTH, DENSITY, GRAVITY = 50.0, 3.125, 80.0, 10.0


def mesh(name, element, cells, top):
    """A column of cells, one wide, from the base to `top`, with its sides and base named."""
    lines = ["Begin ModelPartData", "End ModelPartData", "Begin Properties 0", "End Properties", "Begin Nodes"]
    n = cells + 1
    for row in range(n):
        for side in range(2):
            lines.append(f"{1 + 2 * row + side} {side * WIDTH!r} {row * top / cells!r} 0.0")
    lines += ["End Nodes", f"Begin Elements {element}"]
    for row in range(cells):
        first = 1 + 2 * row
        lines.append(f"{1 + row} 0 {first} {first + 1} {first + 3} {first + 2}")
    lines.append("End Elements")

    def part(name, nodes=(), elements=()):
        lines.extend([f"Begin SubModelPart {name}", "Begin SubModelPartNodes", *map(str, nodes), "End SubModelPartNodes"])
        lines.extend(["Begin SubModelPartElements", *map(str, elements), "End SubModelPartElements", "End SubModelPart"])

    if element.startswith("MPM"):
        part("column", range(1, 2 * n + 1), range(1, cells + 1))
    else:
        part("grid", range(1, 2 * n + 1), range(1, cells + 1))
        part("base", [1, 2])
        part("sides", range(1, 2 * n + 1))
    with open(f"{name}.mdpa", "w") as file:
        file.write("\n".join(lines) + "\n")


def fixed(part, component):
    constrained = [component == axis for axis in range(3)]
    return {
        "python_module": "assign_vector_variable_process",
        "kratos_module": "KratosMultiphysics",
        "Parameters": {
            "model_part_name": f"Background_Grid.{part}",
            "variable_name": "DISPLACEMENT",
            "interval": [0.0, "End"],
            "constrained": constrained,
            "value": [0.0 if held else None for held in constrained],
        },
    }


def write(cells, steps, young):
    mesh("body", "MPMUpdatedLagrangian2D4N", cells, HEIGHT)
    mesh("grid", "Element2D4N", cells, HEIGHT)
    law = {
        "Material": {
            "constitutive_law": {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"},
            "Variables": {
                "THICKNESS": 1.0,
                "MATERIAL_POINTS_PER_ELEMENT": 4,
                "DENSITY": DENSITY,
                "YOUNG_MODULUS": young,
                "POISSON_RATIO": 0.0,
            },
            "Tables": {},
        },
        "model_part_name": "Initial_MPM_Material.column",
        "properties_id": 1,
    }
    with open("materials.json", "w") as file:
        json.dump({"properties": [law]}, file)
    return {
        "problem_data": {"problem_name": "column", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0, "end_time": 1.0},
        "solver_settings": {
            "time_stepping": {"time_step": 1.0 / steps},
            "solver_type": "quasi_static",
            "model_part_name": "MPM_Material",
            "domain_size": 2,
            "echo_level": 0,
            "analysis_type": "non_linear",
            "model_import_settings": {"input_type": "mdpa", "input_filename": "body"},
            "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "grid"},
            "material_import_settings": {"materials_filename": "materials.json"},
            "convergence_criterion": "residual_criterion",
            "residual_relative_tolerance": 1e-8,
            "residual_absolute_tolerance": 1e-9,
            "max_iteration": 20,
            "problem_domain_sub_model_part_list": ["column", "grid"],
            "processes_sub_model_part_list": ["base", "sides"],
            "linear_solver_settings": {"solver_type": "skyline_lu_factorization"},
            "auxiliary_variables_list": ["NORMAL"],
        },
        "processes": {"constraints_process_list": [fixed("base", 1), fixed("sides", 0)]},
        "output_processes": {},
    }


def main():
    cells, steps = (int(sys.argv[k]) if len(sys.argv) > k else default for k, default in ((1, 64), (2, 40)))
    young = float(sys.argv[3]) if len(sys.argv) > 3 else 1e4
    if len(sys.argv) > 4:
        os.chdir(sys.argv[4])
    import KratosMultiphysics as kratos
    import KratosMultiphysics.MPMApplication as mpm
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis

    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)

    class Column(MpmAnalysis):
        """The weight grows with the time."""

        def points(self):
            return self.model["MPM_Material"]

        def of_points(self, variable, component):
            """A component of a variable at every point, in the order of the points."""
            points = self.points()
            values = (element.CalculateOnIntegrationPoints(variable, points.ProcessInfo)[0] for element in points.Elements)
            return [value[component] for value in values]

        def Initialize(self):
            super().Initialize()
            self.at_rest = self.of_points(mpm.MP_COORD, 1)
            self.solutions = 0

        def InitializeSolutionStep(self):
            weight = kratos.Vector([0.0, -GRAVITY * self.time, 0.0])
            info = self.points().ProcessInfo
            for element in self.points().Elements:
                element.SetValuesOnIntegrationPoints(mpm.MP_VOLUME_ACCELERATION, [weight], info)
            super().InitializeSolutionStep()

        def FinalizeSolutionStep(self):
            super().FinalizeSolutionStep()
            self.solutions += self.points().ProcessInfo[kratos.NL_ITERATION_NUMBER]

    column = Column(kratos.Model(), kratos.Parameters(json.dumps(write(cells, steps, young))))
    column.Run()
    stress, heights = column.of_points(mpm.MP_CAUCHY_STRESS_VECTOR, 1), column.of_points(mpm.MP_COORD, 1)
    weight = DENSITY * GRAVITY
    errors = [abs(value + weight * (HEIGHT - height)) for value, height in zip(stress, column.at_rest)]
    print(f"{len(heights)} points, highest at {max(heights)}, {column.solutions} iterations of Newton's method")
    print(f"mean stress error {sum(errors) / (weight * HEIGHT * len(errors)):.6e}")


if __name__ == "__main__":
    main()
