"""Laws and loads that are written in Python: slow, for prototypes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ._errors import InputError


class Law:
    """An isotropic law in principal logarithmic strains, to be derived from.

    ``young`` and ``poisson`` are the elastic constants of the undeformed material. ``history`` has the numbers that a point
    remembers and their values at the start, eight at most; they can be recorded and plotted by these names.
    ``symmetric`` says whether the tangent is symmetric in every state.

    >>> import numpy as np
    >>> import implicit_mpm as mpm
    >>> class Linear(mpm.Law):
    ...     young, poisson = 1000.0, 0.25
    ...     def update(self, strain, history):
    ...         tangent = np.full((3, 3), 400.0) + 800.0 * np.eye(3)
    ...         return tangent @ strain, tangent
    >>> bool(mpm.tangent_error(Linear(), [0.01, -0.02, 0.0]) < 1e-8)
    True
    """

    young: float
    poisson: float
    symmetric: bool = True
    history: Mapping[str, float] = {}

    def update(self, strain: np.ndarray, history: np.ndarray) -> Any:
        """Answers the three principal elastic trial strains and what the point remembers.

        Returns the principal Kirchhoff stresses ``[3]`` and their derivatives by the strains ``[3, 3]``; of a point that yields
        the elastic strains that are left ``[3]`` and what it remembers from here on besides. ``None`` if there is no admissible
        state: the load step is then cut. The principal directions have equal rights, and their order means nothing.
        """
        raise NotImplementedError

    def energy(self, elastic_strain: np.ndarray, history: np.ndarray) -> float:
        """Elastic energy per volume at rest: unless a law says otherwise that of stresses linear in the strains."""
        bulk = self.young / (3 * (1 - 2 * self.poisson))
        shear = self.young / (2 * (1 + self.poisson))
        volumetric = elastic_strain.sum()
        deviator = elastic_strain - volumetric / 3
        return 0.5 * bulk * volumetric**2 + shear * deviator @ deviator


def tangent_error(law: Law, strain: Any, history: Any = None, step: float = 1e-6) -> float:
    """Largest error of a law's tangent against central differences of its stresses, part of its largest entry.

    ``strain`` are principal trial strains, ``history`` what the point remembers (that at the start if left out). A right tangent gives
    1e-6 or less, where the law is smooth.
    """
    strain = np.asarray(strain, dtype=float)
    remembered = list(law.history.values()) if history is None else [float(it) for it in history]

    def answer(at: np.ndarray) -> Any:
        told = _update(law)(list(at), remembered)
        if told is None:
            raise InputError(f"the law finds no admissible state for the strains {at}")
        return told

    tangent = np.array(answer(strain)[1])
    columns = [
        (np.array(answer(strain + step * e)[0]) - np.array(answer(strain - step * e)[0])) / (2 * step) for e in np.eye(3)
    ]
    return float(np.abs(tangent - np.column_stack(columns)).max() / np.abs(tangent).max())


def laws(given: Mapping[str, Law] | None) -> list[tuple[str, dict[str, Any]]]:
    """Laws as the extension module takes them."""
    return [(body, _law(body, law)) for body, law in (given or {}).items()]


def _law(body: str, law: Law) -> dict[str, Any]:
    if not isinstance(law, Law):
        raise InputError(f"expected a Law for body `{body}`, got {type(law).__name__}")
    return {
        "update": _update(law),
        "energy": lambda strain, history: float(law.energy(np.array(strain), np.array(history))),
        "young": law.young,
        "poisson": law.poisson,
        "symmetric": law.symmetric,
        "names": list(law.history),
        "initial": [float(value) for value in law.history.values()],
    }


def _update(law: Law) -> Callable[[list[float], list[float]], Any]:
    name, width = type(law).__name__, len(law.history)

    def numbers(what: str, value: Any, shape: tuple[int, ...]) -> Any:
        array = np.asarray(value, dtype=float)
        if array.shape != shape:
            raise InputError(f"{name}.update: expected {what} of the shape {list(shape)}, got {list(array.shape)}")
        return array.tolist()

    def update(strain: list[float], history: list[float]) -> Any:
        answer = law.update(np.array(strain), np.array(history))
        if answer is None:
            return None
        plastic = len(answer) == 4
        if not plastic and len(answer) != 2:
            raise InputError(
                f"{name}.update: expected stresses and tangent, of a point that yields also elastic strains and history; "
                f"got {len(answer)} values"
            )
        stress, tangent, elastic, remembered = answer if plastic else (*answer, strain, history)
        return (
            numbers("stresses", stress, (3,)),
            numbers("a tangent", tangent, (3, 3)),
            numbers("elastic strains", elastic, (3,)),
            numbers("a history", remembered, (width,)),
            plastic,
        )

    return update


def loads(given: Mapping[str, Callable[[np.ndarray, float], Any]] | None, dimensions: int) -> list[tuple[str, Any]]:
    """Loads as the extension module takes them."""
    return [(body, _load(body, load, dimensions)) for body, load in (given or {}).items()]


def _load(body: str, load: Callable[[np.ndarray, float], Any], dimensions: int) -> Any:
    if not callable(load):
        raise InputError(f"expected a function as load of body `{body}`, got {type(load).__name__}")

    def force(rest: list[float], fraction: float) -> list[float]:
        array = np.asarray(load(np.array(rest), fraction), dtype=float)
        if array.shape != (dimensions,) or not np.isfinite(array).all():
            raise InputError(f"load of body `{body}`: expected {dimensions} finite numbers, got {array}")
        return array.tolist()

    return force
