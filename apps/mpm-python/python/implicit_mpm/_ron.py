"""Python objects as text in the language of scenes, by the language's own JSON schema."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ._errors import InputError

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
_WIDTH = 100


class Language:
    """A JSON schema, which tells a list from a tuple, a name from a text, and fields from entries."""

    def __init__(self, schema: str):
        self._root = json.loads(schema)

    def text(self, value: Any, what: str = "scene") -> str:
        """The value as text. What the schema does not know is written as it stands, for the reader to complain about."""
        text = self._write(_plain(value, what), self._root, "")
        return text + "\n"

    def text_at(self, path: str, value: Any) -> str:
        """A value as text for a place in a scene, as in ``tools[0].interface``; of a place that there is not, as it stands."""
        places = [form for form, _ in self._forms(self._root)]
        # The space is not part of a path.
        places = [self._resolved(inside) for form in places for inside in form.get("properties", {}).values()]
        for name in re.findall(r"[^.\[\]]+", path):
            places = [place for schema in places for place in self._inside(schema, name)]
        return self._write(_plain(value, path), {"anyOf": places}, "")

    def _inside(self, schema: dict, name: str) -> list[dict]:
        """What a part of a value is: a field, also of what stands in the parentheses of a variant, an entry or an element."""
        found = []
        for form, is_variant in self._forms(schema):
            fields = form.get("properties", {})
            if is_variant:
                inside = [it for value in fields.values() for it, _ in self._forms(value)]
            else:
                inside = [form]
            for it in inside:
                of = it.get("properties", {})
                entries = it.get("additionalProperties")
                if name in of:
                    found.append(self._resolved(of[name]))
                elif name.isdigit() and "array" in it.get("type", ""):
                    first = it.get("prefixItems", [])
                    found.append(self._resolved(first[int(name)] if int(name) < len(first) else it.get("items", {})))
                elif isinstance(entries, dict):
                    found.append(self._resolved(entries))
        return found

    def _resolved(self, schema: Any) -> dict:
        while isinstance(schema, dict) and "$ref" in schema:
            target = self._root
            for part in schema["$ref"].removeprefix("#/").split("/"):
                target = target[part]
            schema = target
        return schema if isinstance(schema, dict) else {}

    def _forms(self, schema: Any, is_variant: bool = False) -> list[tuple[dict, bool]]:
        """The schema, or each of those that it offers, and whether that is a variant of several names."""
        schema = self._resolved(schema)
        if "oneOf" in schema:
            return [form for each in schema["oneOf"] for form in self._forms(each, True)]
        if "anyOf" in schema:
            return [form for each in schema["anyOf"] for form in self._forms(each)]
        return [(schema, is_variant)]

    def _write(self, value: Any, schema: Any, indent: str) -> str:
        if value is None:
            return "None"
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, (int, float)):
            return repr(value)
        forms = self._forms(schema)
        if isinstance(value, str):
            return self._string(value, forms)
        if isinstance(value, dict):
            return self._dict(value, forms, indent)
        # The type of what may be left out is a list of types.
        return self._list(value, [form for form, _ in forms if "array" in form.get("type", "")], indent)

    def _string(self, value: str, forms: list[tuple[dict, bool]]) -> str:
        is_name = any(is_variant or "enum" in form for form, is_variant in forms)
        if is_name and _NAME.match(value):
            return value
        # The escapes of JSON that the language does not have.
        text = json.dumps(value, ensure_ascii=False)
        return re.sub(r"\\(\\|b|f|u00(..))", _escape, text)

    def _dict(self, value: dict, forms: list[tuple[dict, bool]], indent: str) -> str:
        variants = {}
        for form, is_variant in forms:
            if is_variant:
                variants.update(form.get("properties", {}))
        structs = [form for form, is_variant in forms if not is_variant and "properties" in form]
        entries = [form["additionalProperties"] for form, _ in forms if isinstance(form.get("additionalProperties"), dict)]
        if len(value) == 1:
            ((name, inside),) = value.items()
            # A name in front of what stands in its parentheses; of one that the language does not have, the reader says so.
            if name in variants or variants and not structs and not entries and _NAME.match(name):
                return name + self._parenthesised(inside, variants.get(name, {}), indent)
        if entries and not structs:
            inner = indent + "    "
            parts = [f"{self._string(name, [])}: {self._write(it, entries[0], inner)}" for name, it in value.items()]
            return _joined("{", parts, "}", indent)
        return self._fields(value, structs[0]["properties"] if structs else {}, indent)

    def _fields(self, value: dict, known: dict, indent: str) -> str:
        parts = []
        for name, it in value.items():
            if it is None:
                continue
            if not _NAME.match(name):
                raise InputError(f"a field of a scene has the name {name!r}, expected letters, digits and underscores")
            parts.append(f"{name}: {self._write(it, known.get(name, {}), indent + '    ')}")
        return _joined("(", parts, ")", indent)

    def _parenthesised(self, inside: Any, schema: Any, indent: str) -> str:
        text = self._write(inside, schema, indent)
        # Fields of a variant stand in its own parentheses, and so do several values without names.
        is_tuple = isinstance(inside, list) and text.startswith("(")
        is_fields = isinstance(inside, dict) and text.startswith("(")
        return text if is_tuple or is_fields else f"({text})"

    def _list(self, value: list, lists: list[dict], indent: str) -> str:
        inner = indent + "    "
        of = lists[0] if lists else {}
        if len(lists) == 1 and ("prefixItems" in of or of.get("minItems", -1) == of.get("maxItems")):
            first = of.get("prefixItems", [])
            rest = [of.get("items", {})] * max(0, len(value) - len(first))
            items = [self._write(it, schema, inner) for it, schema in zip(value, [*first, *rest])]
            return "(" + ", ".join(items) + ")"
        return _joined("[", [self._write(it, of.get("items", {}), inner) for it in value], "]", indent)


def _escape(found: re.Match[str]) -> str:
    """An escape of JSON in the language of scenes."""
    if found[2] is not None:
        return f"\\x{found[2]}"
    return {"b": "\\x08", "f": "\\x0c"}.get(found[1], found[0])


def _joined(opened: str, parts: list[str], closed: str, indent: str) -> str:
    line = opened + ", ".join(parts) + closed
    if "\n" not in line and len(line) + len(indent) <= _WIDTH:
        return line
    inner = indent + "    "
    return opened + "".join(f"\n{inner}{part}," for part in parts) + f"\n{indent}{closed}"


def _plain(value: Any, path: str) -> Any:
    """Dicts with names, lists, numbers and texts, of whatever there was."""
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, (float, np.floating)):
        value = float(value)
        if not np.isfinite(value):
            raise InputError(f"expected a finite number, got {value}", field=path)
        return value
    if isinstance(value, (np.bool_, np.integer)):
        return value.item()
    if isinstance(value, np.ndarray):
        return _plain(value.tolist(), path)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _plain({field.name: getattr(value, field.name) for field in dataclasses.fields(value)}, path)
    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                raise InputError(f"expected names for keys, got {name!r}", field=path)
        return {name: _plain(it, f"{path}.{name}") for name, it in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(it, f"{path}[{k}]") for k, it in enumerate(value)]
    raise InputError(f"expected a dict, a list, a number or a text, got {type(value).__name__}", field=path)
