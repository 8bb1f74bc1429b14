"""Lines of source with their indentation, and the objects that their names stand for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class Writer:
    """Collects source.

    Attributes:
        lines: what was written.
        names: global names in it -> what they stand for.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.names: dict[str, Any] = {}
        self._indent = " "
        self._numbers = 0

    def __call__(self, *lines: str) -> None:
        """Write lines at the current indentation."""
        self.lines += [self._indent + line for line in lines]

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Write `head` and indent what follows."""
        self(head)
        before, self._indent = self._indent, self._indent + " "
        yield
        self._indent = before

    def number(self) -> int:
        """Return a number that no other node of this text has."""
        self._numbers += 1
        return self._numbers

    def bind(self, name: str, value: Any) -> str:
        """Have a name stand for an object."""
        self.names[name] = value
        return name
