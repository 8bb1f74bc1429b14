"""Code that a project lets its tasks import: what `code:` of its `grip.yaml` lists, and py_trees' own behaviours."""

from __future__ import annotations

import ast
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import StringConstraints

from .module_source import definition_of, names_in, source_of

_NAME = r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*"
CodePath = Annotated[str, StringConstraints(pattern=f"^{_NAME}(:{_NAME})?$")]
"""`package.module`, or `package.module:Name`."""
TRUSTED = "py_trees"
"""The package whose behaviours every task may use."""


@dataclass(frozen=True, slots=True)
class OwnCode:
    """What the tasks of a project may import.

    Attributes:
        listed: what the project lists: `package.module` for the behaviours that it, or a module below it, holds;
            `package.module:Name` for one class, or for one function that makes a behaviour.
        folder: where modules are looked for last: the project's; None for where Python looks alone.
    """

    listed: tuple[str, ...] = ()
    folder: Path | None = None

    def allows(self, behaviour: str) -> bool:
        """Tell whether a task may import `package.module:Name`."""
        module = behaviour.partition(":")[0]
        return self.names(behaviour) or any(_covers(entry, module) for entry in (TRUSTED, *self.listed))

    def names(self, behaviour: str) -> bool:
        """Tell whether it is listed word for word, as a function has to be."""
        return behaviour in self.listed

    def is_strange(self, behaviour: str) -> bool:
        """Tell whether it is the project's own code, or somebody's, and not py_trees'."""
        return not _covers(TRUSTED, behaviour.partition(":")[0])

    def names_in(self, module: str) -> Collection[str] | None:
        """Return what a module defines at its top level, read in its source; None where that can't tell.

        Raises:
            ModuleNotFoundError: there is no such module here.
        """
        file = source_of(module, self.folder)
        return None if file is None else names_in(file)

    def kind_of(self, behaviour: str) -> Literal["class", "function", "other"] | None:
        """Return what `package.module:Name` is, as its module's source tells; None where that can't tell.

        Raises:
            ModuleNotFoundError: there is no such module here.
        """
        module, _, name = behaviour.partition(":")
        file = source_of(module, self.folder)
        found = None if file is None or "." in name else definition_of(file, name)
        if found is not None:
            return "class" if isinstance(found.syntax, ast.ClassDef) else "function"
        return "other" if "." in name and not self.is_strange(behaviour) else None


def _covers(entry: str, module: str) -> bool:
    return ":" not in entry and (module == entry or module.startswith(f"{entry}."))
