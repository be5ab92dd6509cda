"""Implicit Material Point Method: quasi-static, finite strain, elasto-plastic.

>>> import implicit_mpm as mpm
>>> scene = mpm.Scene(\"\"\"
... PlaneStrain(
...     mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 1), Uniform(from: 0, to: 1, cells: 1)]),
...     motion: Stretch([(axis: X, anchor: 0, driven: 1, displacement: 1)]),
...     basis: Smpm,
...     materials: {"rubber": NeoHooke(young: 1, poisson: 0)},
...     bodies: [(name: "block", material: "rubber", shape: Box(from: (0, 0), to: (1, 1)), points_per_cell: 2)],
...     supports: [
...         (name: "held", region: Plane(axis: X, at: 0), fix: [X]),
...         (name: "base", region: Plane(axis: Y, at: 0), fix: [Y]),
...         (name: "pulled", region: Plane(axis: X, at: 1), follow_mesh: [X]),
...     ],
...     schedule: (steps: 4),
... )
... \"\"\")
>>> for step in mpm.run(scene):
...     print(step.load_fraction, round(step.reactions["pulled"][0], 6))
0.0 0.0
0.25 0.225
0.5 0.416667
0.75 0.589286
1.0 0.75
"""

from ._errors import InputError, MissingPackage, MpmError, RunError
from ._foreign import Law, tangent_error
from ._mesh import points_of_mesh
from ._native import Picture, Run, Step, __version__
from ._results import Results, open, plot
from ._run import drive, resume, run
from ._scene import Check, Scene

__all__ = [
    "Check",
    "InputError",
    "Law",
    "MissingPackage",
    "MpmError",
    "Picture",
    "Results",
    "Run",
    "RunError",
    "Scene",
    "Step",
    "__version__",
    "drive",
    "open",
    "plot",
    "points_of_mesh",
    "resume",
    "run",
    "tangent_error",
]
