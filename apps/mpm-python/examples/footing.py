"""A rigid footing on clay: load against settlement, and the limit load of Prandtl.

Run it from any folder: ``python apps/mpm-python/examples/footing.py``. The run stops once the load hardly grows any longer.
"""

import math
from pathlib import Path

import implicit_mpm as mpm

SCENES = Path(__file__).resolve().parents[3] / "scenes"


def main() -> None:
    scene = mpm.Scene(SCENES / "footing.ron")
    clay = scene.to_dict()["PlaneStrain"]["materials"]["clay"]["VonMises"]
    limit = (2 + math.pi) * clay["yield_radius"] / math.sqrt(2)

    print("settlement [m]  pressure / limit pressure")
    pressures = [0.0]
    with mpm.run(scene.with_values({"schedule.steps": 20}), output="footing.h5") as run:
        for step in run:
            settlement = -step.displacements["footing"][1]
            # Half of the footing, 0.5 m wide; the nodes' forces act on it and on half of the next cell.
            width = 0.5 + 0.5 * 0.126268
            pressures.append(-step.reactions["footing"][1] / width)
            print(f"{settlement:14.5f}  {pressures[-1] / limit:.4f}")
            if step.index > 2 and pressures[-1] < 1.002 * pressures[-2]:
                break

    history = mpm.open("footing.h5").history
    print(f"{len(history['load_fraction']) - 1} load steps are in footing.h5; the run is {run.status}")
    assert 0.9 < pressures[-1] / limit < 1.1


if __name__ == "__main__":
    main()
