"""Results files."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable
from typing import Any

import numpy as np

from . import _native
from ._errors import InputError, MissingPackage


def open(path: str | os.PathLike[str]) -> Results:
    """Opens the results file of a finished, running, stopped or killed run.

    >>> import implicit_mpm as mpm
    >>> mpm.open("nowhere.h5")
    Traceback (most recent call last):
    ...
    implicit_mpm._errors.InputError: cannot open results file nowhere.h5: No such file or directory
    """
    return Results(path)


def plot(
    results: Iterable[Results | str | os.PathLike[str]],
    y: str | Iterable[str],
    against: str | None = None,
    *,
    absolute: bool = False,
) -> _native.Picture:
    """Columns of the histories of several results against each other, as :meth:`Results.plot` draws those of one."""
    paths = [it.path if isinstance(it, Results) else os.fspath(it) for it in results]
    if not paths:
        raise InputError("expected results to draw, got none")
    return _native.compared(paths, [y] if isinstance(y, str) else list(y), against, absolute)


class Results:
    """A results file as it was when it was opened; :meth:`refresh` looks again."""

    def __init__(self, path: str | os.PathLike[str]):
        self.path = os.fspath(path)
        self.refresh()

    def refresh(self) -> Results:
        """Reads what a run has written meanwhile."""
        self._native = _native.Results(self.path)
        return self

    @property
    def status(self) -> str:
        """``running`` (also of a killed run), ``completed`` or ``failed: <reason>``."""
        return self._native.head()[0]

    @property
    def program(self) -> str:
        """Name and version of the program that wrote the file."""
        return self._native.head()[1]

    @property
    def scene(self) -> str:
        """Text of the scene."""
        return self._native.head()[2]

    @property
    def history(self) -> Any:
        """The history, a row per load step, the first is the initial state.

        A pandas ``DataFrame`` with the load steps as index where pandas is installed, else a dict of arrays. A column with several
        numbers becomes several, ``reaction/left.x`` and so on. ``attrs["units"]`` of the frame has the units of its columns.
        """
        first, rows = self._native.rows()
        table: dict[str, np.ndarray] = {}
        units: dict[str, str] = {}
        for name, unit, width in self._native.columns():
            values = self._native.column(name).reshape(-1, width)
            heads = [name + _component(self._native.letters(), width, k) for k in range(width)]
            table.update({head: values[:, k] for k, head in enumerate(heads)})
            units.update(dict.fromkeys(heads, unit))
        return as_frame(table, units, np.arange(first, first + rows))

    def column(self, name: str) -> np.ndarray:
        """A column of the history: ``[rows]``, or ``[rows, width]``."""
        return self._native.column(name)

    def residuals(self, row: int) -> np.ndarray:
        """Relative out-of-balance force of every iterate of the load step of a row."""
        return self._native.residuals(row)

    @property
    def timings(self) -> dict[str, tuple[float, int]]:
        """Seconds spent in every phase of the run, and how often it was entered."""
        return {phase: (seconds, count) for phase, seconds, count in self._native.timings()}

    @property
    def load_fractions(self) -> np.ndarray:
        """Load fractions of the recorded steps, at which the points can be read."""
        return self._native.fractions()

    @property
    def fields(self) -> dict[str, str]:
        """Names of the recorded fields of the points, and their units in length L and force F."""
        return dict(self._native.fields())

    def positions(self, step: int = -1) -> np.ndarray:
        """Positions of the points at a recorded step (-1 is the last), ``[points, 3]`` [L]."""
        return self._native.positions(self._step(step))

    def field(self, name: str, step: int = -1) -> np.ndarray:
        """A field at a recorded step: one entry per point, a number, a row, or a matrix of 3 × 3."""
        return self._native.field(name, self._step(step))

    def points(self, step: int = -1) -> Any:
        """The points at a recorded step with their fields, as ``pyvista.PolyData``."""
        pyvista = _pyvista()
        return self._with_fields(pyvista.PolyData(self.positions(step)), "point_data", step)

    def domains(self, step: int = -1) -> Any:
        """The domains of the points at a recorded step, as ``pyvista.PolyData`` with the fields as data of its cells.

        Of results in the plane whose scene has ``Outline`` among ``output.fields``.
        """
        pyvista = _pyvista()
        if "outline" not in self.fields:
            raise InputError("no outlines of domains are recorded: a scene in the plane can have `Outline` in `output.fields`", file=self.path)
        corners = self.field("outline", step)
        n = len(corners)
        places = np.zeros((4 * n, 3))
        places[:, :2] = corners.reshape(-1, 2)
        faces = np.column_stack([np.full(n, 4), np.arange(4 * n).reshape(n, 4)])
        return self._with_fields(pyvista.PolyData(places, faces=faces.ravel()), "cell_data", step)

    def plot(self, y: str | Iterable[str], against: str | None = None, *, absolute: bool = False) -> _native.Picture:
        """Columns of the history, ``"reaction/footing.y"``, against another one, or against the load fraction.

        ``absolute`` draws sizes, without signs.
        """
        return plot([self], y, against, absolute=absolute)

    def picture(
        self,
        show: str | Iterable[str] = "body",
        *,
        field: str | None = None,
        step: int = -1,
        range: tuple[float, float] | None = None,
        body: str | None = None,
        mesh: bool = True,
        tools: bool = True,
        domains: bool = False,
        mirror: bool = False,
        view: str | tuple[float, float] = "corner",
        slice: str | None = None,
        cut: str | None = None,
    ) -> _native.Picture:
        """A picture as ``mpm plot`` draws it: ``body``, ``reaction``, ``moment``, ``tool``, ``convergence``, ``energy``, or several of them.

        ``field`` colours the body, with a component where it has several (``"cauchy_stress.xy"``), and ``range`` are the ends of its
        colour bar. ``body`` is drawn alone, ``mesh=False`` leaves the mesh out, with supports and loads, ``tools=False`` the tools.
        ``domains`` draws the domains of the points (recorded as ``Outline``, in the plane) in place of their shares. Bodies of revolution:
        ``mirror`` draws both sides of the axis. In three dimensions one looks from a ``"corner"``, along ``"x"``, ``"y"``, ``"z"``, or from an
        azimuth and an elevation in degrees, ``(30, 20)``;
        ``slice="z=0.5"`` draws the points next to a plane, ``cut="y=0"`` leaves out what stands before one.
        """
        looked = {
            "field": field,
            "step": self._step(step),
            "range": range,
            "body": body,
            "mesh": mesh,
            "tools": tools,
            "domains": domains,
            "mirror": mirror,
            "view": view if isinstance(view, str) else "{},{}".format(*view),
            "slice": slice,
            "cut": cut,
        }
        return _native.picture(self.path, [show] if isinstance(show, str) else list(show), looked)

    def _repr_html_(self) -> str:
        first, rows = self._native.rows()
        told = {
            "results": self.path,
            "status": self.status,
            "load steps": f"{max(0, first + rows - 1)}, {len(self.load_fractions)} recorded",
            "fields": ", ".join(self.fields),
        }
        return as_html(told)

    def _with_fields(self, mesh: Any, place: str, step: int) -> Any:
        for name in self.fields:
            if name != "outline":
                values = self.field(name, step)
                getattr(mesh, place)[name] = values.reshape(len(values), -1) if values.ndim > 1 else values
        mesh.field_data["load_fraction"] = [self.load_fractions[self._step(step)]]
        return mesh

    def _step(self, step: int) -> int:
        steps = len(self.load_fractions)
        if not -steps <= step < steps:
            raise InputError(f"has no recorded step {step}, expected {-steps} to {steps - 1}", file=self.path)
        return step % steps

    def __repr__(self) -> str:
        return f"<implicit_mpm.Results {self.path}: {self.status}>"


def as_html(told: dict[str, Any]) -> str:
    """What is told, as a table."""
    rows = (f"<tr><th>{html.escape(str(name))}</th><td>{html.escape(str(value))}</td></tr>" for name, value in told.items())
    return f"<table>{''.join(rows)}</table>"


def _component(axes: str, width: int, k: int) -> str:
    if width <= 3:
        return "" if width == 1 else "." + axes[k]
    return f".{axes[k // 3]}{axes[k % 3]}" if width == 9 else f"[{k}]"


def as_frame(table: dict[str, np.ndarray], units: dict[str, str], index: np.ndarray | None = None) -> Any:
    """A pandas ``DataFrame``, or the table as it is where pandas is not installed."""
    try:
        import pandas
    except ImportError:
        return table
    if index is not None:
        index = pandas.Index(index, name="load_step")
    frame = pandas.DataFrame(table, index=index)
    frame.attrs["units"] = units
    return frame


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError:
        raise MissingPackage("points and domains as meshes need pyvista: pip install pyvista") from None
    return pyvista
