"""Runs, and paths of one point."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from . import _native
from ._errors import InputError, RunError
from ._foreign import Law
from ._foreign import laws as foreign_laws
from ._foreign import loads as foreign_loads
from ._results import as_frame
from ._ron import Language
from ._scene import Path, Scene, Tables, _is_path, as_columns


def run(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    output: Path | None = None,
    checkpoint: Path | None = None,
    checkpoint_every: int | None = None,
    checkpoint_seconds: float | None = None,
    force: bool = False,
    threads: int | None = None,
    laws: Mapping[str, Law] | None = None,
    loads: Mapping[str, Callable[[np.ndarray, float], Any]] | None = None,
) -> _native.Run:
    """Runs a scene; iterate over what it returns.

    Nothing is written unless ``output`` names a results file (HDF5) or ``checkpoint`` a checkpoint. A run with results that is
    stopped leaves a checkpoint beside them, from which :func:`resume` goes on bit for bit. ``checkpoint_every`` load steps and
    ``checkpoint_seconds`` say when checkpoints are written besides; left out, the scene says it. Results of an
    interrupted or longer run are replaced with ``force=True`` only. ``threads`` never changes a result.

    ``laws`` puts laws that are written in Python, see :class:`Law`, in the place of those of bodies, by the names of the bodies.
    ``loads`` are functions of a point's position at rest ``[D]`` and the load fraction that return a force per volume at rest
    ``[D]``. They are slow, for prototypes; no checkpoint can tell of them, so that none is written.

    >>> import implicit_mpm as mpm
    >>> with mpm.run("scenes/simple_stretch.ron") as run:
    ...     for step in run:
    ...         stress = step.field("cauchy_stress")
    ...         if step.load_fraction >= 0.1:
    ...             break
    >>> run.status, stress.shape
    ('stopped', (16, 3, 3))
    """
    scene = scene if isinstance(scene, Scene) else Scene(scene)
    if (laws or loads) and not (checkpoint is None and checkpoint_every is None and checkpoint_seconds is None):
        raise InputError("a run with laws or loads in Python writes no checkpoint: none could tell of them")
    settings = _settings(output, checkpoint, checkpoint_every, checkpoint_seconds, force, threads)
    return _native.run(scene._native, settings, foreign_laws(laws), foreign_loads(loads, scene._dimensions) if loads else [])


def resume(
    checkpoint_file: Path,
    *,
    output: Path | None = None,
    checkpoint: Path | None = None,
    checkpoint_every: int | None = None,
    checkpoint_seconds: float | None = None,
    threads: int | None = None,
    tables: Tables | None = None,
    folder: Path | None = None,
) -> _native.Run:
    """Goes on with a run from its checkpoint, and with its results file, bit for bit.

    ``output`` names another results file; where there is none, its history begins here. Tables that stood for files are
    handed over again by ``tables``. The scene, and the rest of the arguments if they are left out, are those of the
    checkpoint.
    """
    settings = _settings(output, checkpoint, checkpoint_every, checkpoint_seconds, False, threads)
    folder = None if folder is None else os.fspath(folder)
    return _native.resume(os.fspath(checkpoint_file), folder, as_columns(tables), settings)


def _settings(
    output: Path | None,
    checkpoint: Path | None,
    checkpoint_every: int | None,
    checkpoint_seconds: float | None,
    force: bool,
    threads: int | None,
) -> dict[str, Any]:
    for name, value, least, most in (
        ("threads", threads, 1, 65535),
        ("checkpoint_every", checkpoint_every, 1, 2**32 - 1),
        ("checkpoint_seconds", checkpoint_seconds, 0.001, 1e15),
    ):
        if value is not None and not least <= value <= most:
            raise InputError(f"expected {name} from {least:g} to {most:g}, got {value}")
    if output is None and checkpoint is None and (checkpoint_every is not None or checkpoint_seconds is not None):
        raise InputError("a checkpoint was asked for without saying where: name it by checkpoint= or the results by output=")
    return {
        "output": output,
        "checkpoint": checkpoint,
        "checkpoint_every": checkpoint_every,
        "checkpoint_seconds": checkpoint_seconds,
        "force": bool(force),
        "threads": threads,
    }


@functools.cache
def _language() -> Language:
    return Language(_native.drive_schema())


def drive(source: str | os.PathLike[str] | Mapping[str, Any]) -> Any:
    """Drives one material point of a law along a path, as `mpm drive` does.

    ``source`` is the text of a path, a file, or a dict. The table has a row per step: a pandas ``DataFrame`` where pandas is
    installed, else a dict of arrays. ``attrs["units"]`` of the frame has the units of its columns.

    >>> import implicit_mpm as mpm
    >>> path = mpm.drive({
    ...     "law": {"Hencky": {"young": 100, "poisson": 0}},
    ...     "path": [{"Oedometer": {"by": -0.01, "steps": 2}}],
    ... })
    >>> [round(float(stress), 6) for stress in path["s11"]]
    [0.0, -0.502506, -1.01005]
    """
    name = "path"
    if isinstance(source, os.PathLike) or isinstance(source, str) and _is_path(source):
        name = os.fspath(source)
        text = _native.read_text(name)
    else:
        text = source if isinstance(source, str) else _language().text(source, "path")
    columns, units, rows, stopped = _native.drive(text, name)
    if stopped is not None:
        raise RunError(f"{name}: {stopped}", stopped)
    table = {column: rows[:, k] for k, column in enumerate(columns)}
    return as_frame(table, dict(zip(columns, units)))
