"""Userdata -> variables: each key of each container is a variable of the task.

SMACH copies the inputs of a nested container in and its outputs out; in the task both are one variable. Userdata is
never cleared, so the variables belong to the task and not to the containers.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import Variable

from .found import FoundContainer, Opaque, Reference

_LARGEST = 2**63


@dataclass
class Variables:
    """The variables of a task.

    Attributes:
        values: name -> initial value, where there is one that a task can hold.
        first: name -> an initial value that it can't hold: its source and file, or its key and the container that
            has it in its userdata at run time.
    """

    names: dict[str, None] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)
    first: dict[str, tuple[ast.expr, Any]] = field(default_factory=dict)

    def new(self, key: str, prefix: str) -> str:
        """Return a new variable for a key of a container."""
        wanted = task_name(key)
        if wanted in self.names:
            wanted = task_name(f"{prefix}_{key}")
        while wanted in self.names:
            wanted += "_"
        self.names[wanted] = None
        return wanted

    def declared(self, maybe_unwritten: set[str]) -> dict[str, Variable | str]:
        """Return them as a task's `data`."""
        made: dict[str, Variable | str] = {}
        for name in self.names:
            if name in self.values:
                made[name] = Variable(type="Any", value=self.values[name])
            elif name in maybe_unwritten:
                made[name] = Variable(type="Any", value=None)
            else:
                made[name] = "Any"
        return made


class Keys:
    """The keys of one container, as variables."""

    def __init__(self, variables: Variables, label: str, shared: Mapping[str, str] | None = None):
        self._variables, self._label, self._names = variables, label, dict(shared or {})

    def __call__(self, key: str) -> str:
        """Return a key's variable, which is made when it is asked for the first time."""
        if key not in self._names:
            self._names[key] = self._variables.new(key, self._label)
        return self._names[key]

    def begin(self, found: FoundContainer) -> None:
        """Take over the initial values of a container's userdata."""
        for key, value in found.userdata.items():
            name = self(key)
            if name in self._variables.values or name in self._variables.first:
                continue  # the parent's value comes in
            try:
                self._variables.values[name] = plain_literal(value)
            except ValueError as error:
                self._first(found, key, name, value, str(error))

    def _first(self, found: FoundContainer, key: str, name: str, value: Any, shown: str) -> None:
        expression = value.expression if isinstance(value, (Opaque, Reference)) else getattr(value, "expression", None)
        if expression is not None:
            self._variables.first[name] = (expression, found.span.file)
        elif root_entry(found) is None:
            found.problem(
                "partial",
                f"userdata `{key}` begins as `{shown}`, which only a run knows: give the variable `{name}` a value,"
                " or have a state write it",
            )
        else:
            self._variables.first[name] = (ast.Constant(key), found)


def root_entry(found: FoundContainer) -> FoundContainer | None:
    """Return the outermost container when generated code can get hold of it."""
    while found.parent is not None:
        found = found.parent
    return found if found.entry is not None else None


def plain_literal(value: Any) -> Any:
    """Return a value as a task can hold it; a tuple becomes a list.

    Raises:
        ValueError: a task can't hold it; the message is its source.
    """
    if value is None or isinstance(value, (bool, float, str)):
        return value
    if isinstance(value, int) and abs(value) < _LARGEST:
        return value
    if isinstance(value, (list, range)):
        return [plain_literal(item) for item in value]
    if isinstance(value, dict) and all(isinstance(key, str) for key in value):
        return {key: plain_literal(item) for key, item in value.items()}
    raise ValueError(value.text if isinstance(value, Opaque) else getattr(value, "cls", repr(value)))
