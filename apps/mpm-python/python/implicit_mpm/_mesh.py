"""Material points of a mesh of finite elements."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._errors import InputError

# Faces of a hexahedron, seen from outside anticlockwise.
_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_OF_PLANE, _OF_SPACE = ("triangle", "quad"), ("tetra", "hexahedron")


def points_of_mesh(mesh: Any) -> dict[str, np.ndarray]:
    """A table of material points, one in the centre of each cell, for ``tables`` of :class:`Scene`.

    ``mesh`` is what ``meshio.read`` returns: ``points`` ``[n, 2]`` or ``[n, 3]``, and ``cells``, blocks that have a ``type`` and ``data``. In the
    plane cells are triangles and quads, in space tetrahedra and hexahedra, each of first order; blocks of fewer dimensions are left out. Where
    all cells are quads or hexahedra, the table has domains: parallelograms with the mean edges of the cells.

    >>> from types import SimpleNamespace as Mesh
    >>> import implicit_mpm as mpm
    >>> quad = Mesh(type="quad", data=[[0, 1, 2, 3]])
    >>> table = mpm.points_of_mesh(Mesh(points=[[0, 0], [2, 0], [2, 1], [0, 1]], cells=[quad]))
    >>> {name: float(column[0]) for name, column in table.items()}
    {'x': 1.0, 'y': 0.5, 'volume': 2.0, 'r1x': 1.0, 'r1y': 0.0, 'r2x': 0.0, 'r2y': 0.5}
    """
    points = np.asarray(mesh.points, dtype=float)
    blocks = [(block.type, points[np.asarray(block.data)]) for block in mesh.cells if len(block.data)]
    in_space = any(kind in _OF_SPACE or kind.startswith(("tetra", "hexahedron", "wedge", "pyramid")) for kind, _ in blocks)
    known = _OF_SPACE if in_space else _OF_PLANE
    lower = ("vertex", "line", *(_OF_PLANE if in_space else ()))
    blocks = [(kind, corners) for kind, corners in blocks if kind not in lower]
    strange = [kind for kind, _ in blocks if kind not in known]
    if strange or not blocks:
        raise InputError(f"expected cells of the types {' and '.join(known)}, got {strange[0] if strange else 'none'}")
    if not in_space:
        if points.shape[1] == 3 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points, axis=0).max():
            raise InputError("expected a mesh in the plane z = const, or tetrahedra and hexahedra")
        blocks = [(kind, corners[..., :2]) for kind, corners in blocks]
    centres, volumes = (np.concatenate(of) for of in zip(*(_centres(kind, corners) for kind, corners in blocks)))
    if (volumes == 0).any():
        raise InputError(f"cell {int(np.flatnonzero(volumes == 0)[0])} has no volume")
    table = {axis: centres[:, d] for d, axis in enumerate("xyz"[: centres.shape[1]])}
    table["volume"] = np.abs(volumes)
    if all(kind in ("quad", "hexahedron") for kind, _ in blocks):
        domains = np.concatenate([_domains(corners) for _, corners in blocks])
        # Right-handed: cells may be numbered the other way round.
        domains[volumes < 0, 0] *= -1
        for r in range(domains.shape[1]):
            table.update({f"r{r + 1}{axis}": domains[:, r, d] for d, axis in enumerate("xyz"[: domains.shape[2]])})
    return table


def _centres(kind: str, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres of gravity and signed volumes, from simplices around the middles of cells and faces."""
    middle = corners.mean(axis=1)
    if kind in ("triangle", "quad"):
        following = np.roll(corners, -1, axis=1)
        simplices = [np.stack([middle, corners[:, k], following[:, k]], axis=1) for k in range(corners.shape[1])]
    elif kind == "tetra":
        simplices = [corners]
    else:
        faces = [corners[:, face] for face in _FACES]
        simplices = [
            np.stack([middle, face.mean(axis=1), face[:, k], face[:, (k + 1) % 4]], axis=1) for face in faces for k in range(4)
        ]
    dimensions = corners.shape[2]
    edges = [simplex[:, 1:] - simplex[:, :1] for simplex in simplices]
    parts = np.array([np.linalg.det(edge) for edge in edges]) / (2 if dimensions == 2 else 6)
    volumes = parts.sum(axis=0)
    moments = sum(part[:, None] * simplex.mean(axis=1) for part, simplex in zip(parts, simplices))
    return moments / np.where(volumes == 0, 1, volumes)[:, None], volumes


def _domains(corners: np.ndarray) -> np.ndarray:
    """Half of the mean edges along each of a cell's own directions ``[cells, D, D]``."""
    if corners.shape[2] == 2:
        ends = (((1, 2), (0, 3)), ((3, 2), (0, 1)))
    else:
        ends = (((1, 2, 5, 6), (0, 3, 4, 7)), ((2, 3, 6, 7), (0, 1, 4, 5)), ((4, 5, 6, 7), (0, 1, 2, 3)))
    return np.stack([0.5 * (corners[:, list(far)].mean(axis=1) - corners[:, list(near)].mean(axis=1)) for far, near in ends], axis=1)
