"""Results files by h5py alone, to be copied: histories, and the points of any recorded step.

    from mpm_results import Results
    with Results("stretch.h5") as results:
        force = results.history("reaction/pulled")[:, 0]
        stress = results.field("cauchy_stress", step=-1)
"""
import sys

import h5py
import numpy as np


class Results:
    """A results file; trust it while its run goes on, too: it reads complete rows and steps only."""

    def __init__(self, path):
        self.file = h5py.File(path, "r")
        self.rows = int(self.file["history"].attrs["rows"])
        self.steps = int(self.file["VTKHDF/Steps"].attrs["NSteps"])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()

    @property
    def status(self):
        """`running`, `completed` or `failed: <reason>`."""
        return self.file.attrs["status"]

    def history(self, column):
        """A column of the history, a row per load step; row 0 is the initial state."""
        return self.file["history"][column][: self.rows]

    def load_fractions(self):
        """Load fractions of the recorded steps."""
        return self.file["VTKHDF/Steps/Values"][: self.steps]

    def points(self, step=-1):
        """Positions of the points at a recorded step, [points, 3]; -1 is the last."""
        return self._at("Points", step)

    def field(self, name, step=-1):
        """A field at a recorded step: [points], [points, n], or [points, 3, 3] of tensors."""
        values = self._at("PointData/" + name, step)
        return values.reshape(-1, 3, 3) if values.ndim == 2 and values.shape[1] == 9 else values

    def _at(self, name, step):
        step = range(self.steps)[step]
        # Points of all recorded steps lie one after the other; each step says where its own begin.
        first = int(self.file["VTKHDF/Steps/PointOffsets"][step])
        part = int(self.file["VTKHDF/Steps/PartOffsets"][step])
        count = int(self.file["VTKHDF/NumberOfPoints"][part])
        return self.file["VTKHDF"][name][first : first + count]


if __name__ == "__main__":
    with Results(sys.argv[1]) as results:
        print(results.status, results.rows - 1, "load steps,", results.steps, "recorded")
        for k, fraction in enumerate(results.load_fractions()):
            points = results.points(k)
            print(f"step {k} at load fraction {fraction:g}: {len(points)} points, mean position {np.mean(points, axis=0)}")
