"""Scenes."""

from __future__ import annotations

import dataclasses
import functools
import html
import json
import os
from collections.abc import Mapping
from typing import Any, Union

import numpy as np

from . import _native
from ._errors import InputError
from ._results import as_html
from ._ron import Language

Path = Union[str, "os.PathLike[str]"]
Tables = Mapping[str, Mapping[str, Any]]


@functools.cache
def _language() -> Language:
    return Language(_native.schema())


class Check(dict):
    """What ``mpm check --json`` prints: sizes, how long a run may take, and what is probably not meant."""

    def _repr_html_(self) -> str:
        return as_html({name: _told(value) for name, value in self.items() if value not in (None, [], {})})


def _told(value: Any) -> str:
    """A value of a check in words."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {_told(it)}" for name, it in value.items() if it is not None)
    if isinstance(value, list):
        return "; ".join(_told(it) for it in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


class Scene:
    """A scene: what a file of the program `mpm` says.

    ``source`` is the text of a scene, a path (a ``pathlib.Path``, or a text that ends in ``.ron``), or a dict (or mapping, or
    dataclass) as the JSON schema of scenes has it: ``{"PlaneStrain": {"mesh": {"Box": {"axes": [...]}}, ...}}``. Names are texts,
    tuples are tuples or lists, and what is ``None`` is left out.

    ``tables`` gives tables of numbers for files that the scene names: for points the columns ``x``, ``y`` (``z``), ``volume``,
    and perhaps ``r1x`` ... of the domains' half-vectors, or the arrays ``position`` and ``domain`` of HDF5 tables; for fields
    of parameters any columns. Files that are not among them are read from ``folder``: that of the scene, or the present one.

    >>> import implicit_mpm as mpm
    >>> mpm.Scene("PlaneStrain(mesh: Box(axis: []))")
    Traceback (most recent call last):
    ...
    implicit_mpm._errors.InputError: scene:1:23: unknown field `axis` of `Box`; expected `axes`
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | Mapping[str, Any] | Any,
        *,
        tables: Tables | None = None,
        folder: Path | None = None,
    ):
        name, beside = "scene", ""
        if isinstance(source, os.PathLike) or isinstance(source, str) and _is_path(source):
            name = os.fspath(source)
            beside = os.path.dirname(name)
            text = _native.read_text(name)
        elif isinstance(source, str):
            text = source
        elif isinstance(source, Mapping) or dataclasses.is_dataclass(source):
            text = _language().text(source)
        else:
            raise InputError(f"expected a scene as text, path or dict, got {type(source).__name__}")
        folder = beside if folder is None else os.fspath(folder)
        self._native = _native.Scene(text, name, folder, as_columns(tables))

    @classmethod
    def _of(cls, native: _native.Scene) -> Scene:
        scene = cls.__new__(cls)
        scene._native = native
        return scene

    @property
    def text(self) -> str:
        """Its text, in RON."""
        return self._native.text

    @property
    def title(self) -> str:
        """What it shows."""
        return self._native.title

    @property
    def name(self) -> str:
        """Name of its file, for messages."""
        return self._native.name

    def to_dict(self) -> dict[str, Any]:
        """The scene as a dict, with the values that its text leaves out; ``Scene(scene.to_dict()) == scene``."""
        scene = json.loads(self._native.json())
        for space in scene.values():
            fields = space["output"]["fields"]
            # What a law remembers is asked for by its bare name.
            fields[:] = [field["Remembered"] if isinstance(field, dict) else field for field in fields]
        return scene

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """The scene with other values, by their paths: ``scene.with_values({"schedule.steps": 20})``.

        A value is a number, a truth value, or text in the language of scenes, as for ``mpm run --set``.
        """
        native = self._native
        for path, value in values.items():
            if isinstance(value, (bool, np.bool_)):
                value = "true" if value else "false"
            elif isinstance(value, (np.integer, np.floating)):
                value = value.item()
            native = native.with_value(path, value if isinstance(value, str) else repr(value))
        return self._of(native)

    def check(self) -> Check:
        """How large the scene is, how long a run may take, and what is probably not meant: what `mpm check --json` prints."""
        return Check(json.loads(self._native.check()))

    def _repr_html_(self) -> str:
        return as_html({"scene": self.title or self.name}) + f"<details><pre>{html.escape(self.text)}</pre></details>"

    @property
    def _dimensions(self) -> int:
        (space,) = json.loads(self._native.json())
        return 3 if space == "Solid" else 2

    def __eq__(self, other: object) -> bool:
        return self._native == other._native if isinstance(other, Scene) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<implicit_mpm.Scene {self.name}: {self.title}>" if self.title else f"<implicit_mpm.Scene {self.name}>"


def _is_path(source: str) -> bool:
    return source.endswith(".ron") and "\n" not in source


def as_columns(tables: Tables | None) -> dict[str, list[tuple[str, np.ndarray]]]:
    """Tables as lists of columns; the arrays of HDF5 tables become the columns of CSV tables."""
    return {file: _columns(file, table) for file, table in (tables or {}).items()}


def _columns(file: str, table: Mapping[str, Any]) -> list[tuple[str, np.ndarray]]:
    columns = []
    for name in table:
        try:
            values = np.asarray(table[name], dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"column `{name}`: expected numbers, got {error}", file=file) from None
        axes = "xyz"[: values.shape[-1]] if values.ndim > 1 else ""
        if name == "position" and values.ndim == 2 and values.shape[1] in (2, 3):
            columns += [(axis, values[:, d]) for d, axis in enumerate(axes)]
        elif name == "domain" and values.ndim == 3 and values.shape[1] == values.shape[2] and values.shape[1] in (2, 3):
            columns += [(f"r{r + 1}{axis}", values[:, r, d]) for r in range(len(axes)) for d, axis in enumerate(axes)]
        elif values.ndim == 1:
            columns.append((name, values))
        else:
            raise InputError(f"column `{name}` has the shape {list(values.shape)}, expected a list", file=file)
    return columns
