"""Material points of meshes."""

from types import SimpleNamespace as Mesh

import numpy as np
import pytest

import implicit_mpm as mpm

CUBE = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)


def block(kind, *cells):
    return Mesh(type=kind, data=np.array(cells))


def test_cells_keep_volume_and_centre():
    # A trapezium: its centre of gravity is not the mean of its corners.
    points = [[0, 0, 5], [3, 0, 5], [1, 2, 5], [0, 2, 5]]
    quad = mpm.points_of_mesh(Mesh(points=points, cells=[block("quad", [0, 1, 2, 3]), block("line", [0, 1])]))
    halves = mpm.points_of_mesh(Mesh(points=points, cells=[block("triangle", [0, 1, 2], [0, 2, 3])]))
    assert quad["volume"] == pytest.approx([4]) and halves["volume"].sum() == pytest.approx(4)
    for axis in "xy":
        assert quad[axis][0] == pytest.approx(halves["volume"] @ halves[axis] / 4)
    assert "z" not in quad and "r1x" not in halves and quad["r2y"] == pytest.approx([1])


def test_a_skewed_hexahedron_is_its_own_domain():
    skew = np.array([[2, 0.3, 0], [0.1, 1, 0.2], [0, 0.4, 3]])
    mesh = Mesh(points=CUBE @ skew + 7, cells=[block("triangle", [0, 1, 2]), block("hexahedron", range(8))])
    table = mpm.points_of_mesh(mesh)
    assert table["volume"] == pytest.approx([np.linalg.det(skew)])
    assert [table[axis][0] for axis in "xyz"] == pytest.approx(skew.sum(axis=0) / 2 + 7)
    for r in range(3):
        assert [table[f"r{r + 1}{axis}"][0] for axis in "xyz"] == pytest.approx(skew[r] / 2)
    turned = Mesh(points=mesh.points, cells=[block("hexahedron", [1, 0, 3, 2, 5, 4, 7, 6])])
    again = mpm.points_of_mesh(turned)
    assert again["volume"] == pytest.approx(table["volume"]) and again["r1x"] == pytest.approx(table["r1x"])


def test_a_body_of_a_mesh_is_run():
    n = 4
    points = [[x / n, y / n] for y in range(n + 1) for x in range(n + 1)]
    cell = lambda x, y: [x + (n + 1) * y, x + 1 + (n + 1) * y, x + 1 + (n + 1) * (y + 1), x + (n + 1) * (y + 1)]
    mesh = Mesh(points=points, cells=[block("quad", *(cell(x, y) for y in range(n) for x in range(n)))])
    scene = mpm.Scene(
        """PlaneStrain(
            mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 2), Uniform(from: 0, to: 2, cells: 4)]),
            basis: Cpdi1, materials: {"m": Hencky(young: 1, poisson: 0)},
            bodies: [(name: "b", material: "m", shape: Points(file: "mesh"))],
            supports: [
                (name: "base", region: Plane(axis: Y, at: 0), fix: [X, Y]),
                (name: "top", region: Plane(axis: Y, at: 1), fix: [X], displace: [(axis: Y, by: 0.1)]),
            ],
            schedule: (steps: 1),
        )""",
        tables={"mesh": mpm.points_of_mesh(mesh)},
    )
    *_, last = mpm.run(scene)
    assert last.reactions["top"][1] == pytest.approx(np.log(1.1) / 1.1, rel=1e-9)


def test_other_cells_are_refused():
    with pytest.raises(mpm.InputError, match="expected cells of the types tetra and hexahedron, got tetra10"):
        mpm.points_of_mesh(Mesh(points=CUBE, cells=[block("tetra10", [0] * 10)]))
    with pytest.raises(mpm.InputError, match="got none"):
        mpm.points_of_mesh(Mesh(points=CUBE, cells=[block("line", [0, 1])]))
    with pytest.raises(mpm.InputError, match="in the plane z = const"):
        mpm.points_of_mesh(Mesh(points=CUBE, cells=[block("quad", [0, 1, 5, 4])]))
    with pytest.raises(mpm.InputError, match="cell 0 has no volume"):
        mpm.points_of_mesh(Mesh(points=CUBE[:4, :2], cells=[block("triangle", [0, 1, 1])]))
