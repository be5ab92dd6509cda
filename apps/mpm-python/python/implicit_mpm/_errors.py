"""What can go wrong."""

from __future__ import annotations


class MpmError(Exception):
    """Anything that this package complains about."""


class InputError(MpmError, ValueError):
    """An input is wrong: a scene, a file, or an argument. The program `mpm` would end with exit code 2.

    ``reason`` says what was found and what was expected; ``file``, ``line``, ``column`` (from 1) and ``field`` say where, as far
    as there is such a place. For scenes made of dicts the line is that of the text made of the dict, ``Scene.text``.
    """

    def __init__(
        self,
        reason: str,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        field: str | None = None,
    ):
        self.reason = reason
        self.file = file
        self.line = line
        self.column = column
        self.field = field
        place = ":".join(str(part) for part in (file, line, column) if part is not None)
        super().__init__(": ".join(part for part in (place, field, reason) if part))

    def __reduce__(self):
        return type(self), (self.reason, self.file, self.line, self.column, self.field)


class RunError(MpmError, RuntimeError):
    """A simulation could not finish. The program `mpm` would end with exit code 1.

    ``reason`` is why; the message also says where the load steps before it are, and how to go on.
    """

    def __init__(self, message: str, reason: str | None = None):
        self.reason = message if reason is None else reason
        super().__init__(message)

    def __reduce__(self):
        return type(self), (str(self), self.reason)


class MissingPackage(MpmError, ImportError):
    """Something needs a Python package that is not installed."""
