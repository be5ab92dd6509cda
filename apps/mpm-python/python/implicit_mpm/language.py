"""Constructors for every word of the language of scenes, made from its schema when they are first asked for.

>>> from implicit_mpm.language import Body, Box, Hencky, Uniform
>>> Box(axes=[Uniform(**{"from": 0, "to": 1, "cells": 4})] * 2)["Box"]["axes"][0]
{'Uniform': {'from': 0, 'to': 1, 'cells': 4}}
>>> Uniform(from_=0, to=1, cells=4)
{'Uniform': {'from': 0, 'to': 1, 'cells': 4}}
>>> Hencky(yong=1.0)
Traceback (most recent call last):
...
implicit_mpm._errors.InputError: `Hencky` has no field `yong`; expected young, poisson
>>> Hencky(young=1.0)
Traceback (most recent call last):
...
implicit_mpm._errors.InputError: `Hencky` needs `poisson`

What they return are dicts for :class:`implicit_mpm.Scene`, which checks the values. A name that Python keeps for itself has an underscore
behind it (``from_``). Where a word has several meanings (``Box`` is a mesh and a shape), its fields say which is meant. Words without
fields are texts: ``Cpdi1 == "Cpdi1"``.
"""

from __future__ import annotations

import functools
import inspect
import json
import keyword
import re
from typing import Any

from . import _native
from ._errors import InputError


class Word:
    """A word of the language of scenes with fields; calling it gives a dict."""

    def __init__(self, name: str, is_variant: bool):
        self.__name__ = self.__qualname__ = name
        self._is_variant = is_variant
        self._meanings: list[dict] = []

    def _add(self, schema: dict, description: str) -> None:
        if all(set(schema.get("properties", {})) != set(it.get("properties", {})) for it in self._meanings):
            self._meanings.append({**schema, "description": description})
            self.__doc__ = "\n\nOr:\n\n".join(_described(it) for it in self._meanings)

    @property
    def __signature__(self) -> inspect.Signature:
        of = {name: None for meaning in self._meanings for name in meaning.get("properties", {})}
        if not of:
            return inspect.Signature([inspect.Parameter("value", inspect.Parameter.POSITIONAL_ONLY)])
        parameters = [inspect.Parameter(_safe(name), inspect.Parameter.KEYWORD_ONLY, default=None) for name in of]
        return inspect.Signature(parameters)

    def __call__(self, *values: Any, **fields: Any) -> dict[str, Any]:
        """The word with its fields, or with its value where it has no fields."""
        inside = self._inside(values, {_plain(name): value for name, value in fields.items() if value is not None})
        return {self.__name__: inside} if self._is_variant else inside

    def _inside(self, values: tuple[Any, ...], fields: dict[str, Any]) -> Any:
        if values and not fields:
            if not self._is_variant:
                raise InputError(f"`{self.__name__}` takes its fields by their names")
            return values[0] if len(values) == 1 else list(values)
        wrong = []
        for meaning in self._meanings:
            known = meaning.get("properties", {})
            strange = [name for name in fields if name not in known]
            missing = [name for name in meaning.get("required", []) if name not in fields]
            if not strange and not missing:
                return fields
            wrong.append((len(strange), strange, missing, known))
        _, strange, missing, known = min(wrong, key=lambda it: it[0])
        if strange:
            raise InputError(f"`{self.__name__}` has no field `{strange[0]}`; expected {', '.join(known) or 'one value'}")
        raise InputError(f"`{self.__name__}` needs `{'`, `'.join(missing)}`")

    def __repr__(self) -> str:
        return f"<{self.__name__}{self.__signature__}>"


def _plain(name: str) -> str:
    return name[:-1] if name.endswith("_") and keyword.iskeyword(name[:-1]) else name


def _safe(name: str) -> str:
    return name + "_" if keyword.iskeyword(name) else name


def _described(meaning: dict) -> str:
    lines = [meaning["description"]]
    for name, field in meaning.get("properties", {}).items():
        told = " ".join(field.get("description", "").split())
        lines.append(f"{_safe(name)}: {told}" + (f" [{json.dumps(field['default'])}]" if "default" in field else ""))
    return "\n".join(lines)


@functools.cache
def _words() -> dict[str, Any]:
    root = json.loads(_native.schema())
    definitions = root["$defs"]

    def resolved(schema: Any) -> dict:
        while isinstance(schema, dict) and "$ref" in schema:
            schema = definitions[schema["$ref"].rsplit("/", 1)[1]]
        return schema if isinstance(schema, dict) else {}

    variants: dict[str, Word] = {}
    texts: set[str] = set()
    for schema in [root, *definitions.values()]:
        for form in schema.get("oneOf", []):
            texts.update([form["const"]] if "const" in form else form.get("enum", []))
            for name, inside in form.get("properties", {}).items():
                described = form.get("description", "")
                variants.setdefault(name, Word(name, True))._add(resolved(inside), described)
    structs: dict[str, Word] = {}
    for name, schema in definitions.items():
        bare = re.sub(r"(Input|In)?\d*\Z", "", name)
        if "properties" in schema and bare != "Scene":
            # `Stretch` is the motion; one of its axes is `StretchInput`.
            bare = bare if bare not in variants else re.sub(r"\d*\Z", "", name)
            structs.setdefault(bare, Word(bare, False))._add(schema, schema.get("description", ""))
    return {text: text for text in texts} | structs | variants


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    try:
        return _words()[name]
    except KeyError:
        raise AttributeError(f"the language of scenes has no word `{name}`") from None


def __dir__() -> list[str]:
    return sorted(_words())
