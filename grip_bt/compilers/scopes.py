"""The variables of one run: a scope per declaring container, a cell per variable, closures for ports."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from typing import Any

from grip_bt.base.errors import DataError
from grip_bt.base.values import Pose
from grip_bt.task.catalog import Type, check_value, parse_type
from grip_bt.task.model import Variable


class _Unset:
    def __repr__(self) -> str:
        return "<unset>"


UNSET = _Unset()
"""The value of a variable that hasn't been written."""


def written(type_: Type, literal: object) -> object:
    """Return the value that a literal of a task file stands for: itself, or a pose."""
    if type_.name == "Pose" and isinstance(literal, Mapping):
        return Pose(**literal)
    if type_.item is not None and isinstance(literal, list):
        return [written(type_.item, each) for each in literal]
    if type_.item is not None and isinstance(literal, dict):
        return {key: written(type_.item, each) for key, each in literal.items()}
    return literal


class Cell:
    """One variable of one scope."""

    __slots__ = ("initial", "name", "parsed", "type", "value", "watchers")

    def __init__(self, name: str, declared: Variable | str):
        variable = Variable(type=declared) if isinstance(declared, str) else declared
        self.name, self.type, self.parsed = name, variable.type, parse_type(variable.type)
        self.initial: Any = written(self.parsed, variable.value) if variable.has_value else UNSET
        self.value: Any = UNSET
        self.watchers: list[Callable[[], None]] = []
        self.reset()

    def reset(self) -> None:
        self.value = self.initial if self.initial is UNSET else deepcopy(self.initial)

    def preset(self, value: object) -> None:
        self.initial = value
        self.reset()


class Scope:
    """The variables that one container declares."""

    def __init__(self, path: str, declared: Mapping[str, Variable | str], outer: Scope | None = None):
        self.path, self.outer = path, outer
        self.cells = {name: Cell(name, variable) for name, variable in declared.items()}
        above = outer._seen.maps if outer is not None else ()
        self._seen: ChainMap[str, Cell] = ChainMap(self.cells, *above)

    def reset(self) -> None:
        for cell in self.cells.values():
            cell.reset()

    def find(self, name: str) -> Cell | None:
        return self._seen.get(name)

    def cell(self, name: str) -> Cell:
        return self._seen[name]

    def visible(self) -> list[str]:
        return list(dict.fromkeys(name for cells in self._seen.maps for name in cells))


class Scopes:
    """All variables of a compiled task; `[path]` is the scope that the container at `path` declares.

    The task's own variables are under the empty path.

    Attributes:
        on_write: called as (node's path, variable, type, value) after each write.
    """

    TASK = ""

    def __init__(self) -> None:
        self._scopes: dict[str, Scope] = {}
        self.on_write: Callable[[str, str, str, Any], None] | None = None

    def declare(self, path: str, declared: Mapping[str, Variable | str], outer: Scope | None) -> Scope:
        """Add a scope; a container that declares nothing shares its outer one."""
        if not declared and outer is not None:
            return outer
        scope = self._scopes[path] = Scope(path, declared, outer)
        return scope

    def __getitem__(self, path: str) -> Scope:
        return self._scopes[path]

    def __iter__(self) -> Iterator[Scope]:
        return iter(self._scopes.values())

    def snapshot(self) -> dict[tuple[str, str], Any]:
        return {
            (path, name): cell.value
            for path, scope in self._scopes.items()
            for name, cell in scope.cells.items()
            if cell.value is not UNSET
        }

    def reader(self, path: str, port: str, cell: Cell) -> Callable[[], object]:
        def read() -> Any:
            value = cell.value
            if value is UNSET:
                raise DataError(path, port, f"variable {cell.name!r} was read before it was written")
            return value

        return read

    def writer(self, path: str, port: str, cell: Cell) -> Callable[[object], None]:
        """Return what the port of the node at `path` writes with; a value of a wrong type is refused."""
        of_class_alone = cell.parsed.item is None
        fitting: type | None = None

        def write(value: object) -> None:
            nonlocal fitting
            if type(value) is not fitting:
                wrong = check_value(cell.parsed, value)
                if wrong is not None:
                    raise DataError(path, port, f"variable {cell.name!r} is {cell.type}: {wrong}")
                if of_class_alone:
                    fitting = type(value)
            cell.value = value
            if self.on_write is not None:
                self.on_write(path, cell.name, cell.type, value)
            for written in cell.watchers:
                written()

        return write
