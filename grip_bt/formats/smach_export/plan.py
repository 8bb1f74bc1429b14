"""What the file holds, gathered while the machine of a task is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.compilers.scopes import Cell
from grip_bt.task import model

from ..standalone.identifiers import Identifiers
from ..standalone.layout import Code, Items, call, literal, statement
from .keys import reads, writes

_TAKEN = (
    *("smach", "copy", "sys", "Path", "HERE", "NODES", "build", "run", "task", "load_legacy", "BehaviourTree"),
    *("Choose", "Count", "Each", "Joining", "begin_anew", "tree_run", "userdata", "states", "ends"),
)


@dataclass
class Plan:
    """The file under construction.

    Attributes:
        resolved: the task.
        identifiers: names that are free.
        body: statements of `build`, laid out.
        functions: functions above it.
        parts: names of the supporting parts that are used.
        modules: legacy file -> its name in the file.
        built: source of what builds a legacy machine -> name of that machine in `build`.
        trees: paths of containers that one state ticks -> kind.
        nodes: catalogue ids of the leaves that are ticked.
        classes: containers of ours that are used.
    """

    resolved: Resolved
    identifiers: Identifiers = field(default_factory=lambda: Identifiers(_TAKEN))
    body: list[str] = field(default_factory=list)
    functions: list[str] = field(default_factory=list)
    parts: set[str] = field(default_factory=set)
    modules: dict[Path, str] = field(default_factory=dict)
    built: dict[str, str] = field(default_factory=dict)
    trees: dict[str, str] = field(default_factory=dict)
    nodes: dict[str, None] = field(default_factory=dict)
    classes: dict[str, None] = field(default_factory=dict)

    def take(self, part: Part) -> str:
        """Return a name for the container of a node."""
        above = part.path.strip("/").split("/")[:-1]
        return self.identifiers.take(part.name, f"{above[-1] if above else 'whole'}_{part.name}")

    def write(self, expression: Items | Code, target: str = "", indent: int = 4) -> None:
        """Add a statement."""
        self.body.append(statement(target, expression, indent))

    def begin(self, name: str, made: Items, part: Part) -> None:
        """Write a container's object, and what begins its variables anew."""
        self.body.append("")
        self.write(made, name)
        declared = getattr(part.node, "data", {})
        if not declared:
            return
        self.parts.add("begin_anew")
        values = {cell.name: initial(declared, cell) for cell in part.scope.cells.values()}
        given = {key: held[0] for key, held in values.items() if held}
        unset = [key for key, held in values.items() if not held]
        self.write(call(f"{name}.register_start_cb", Code("begin_anew"), [given, unset]))


def initial(declared: Mapping[str, model.Variable | str], cell: Cell) -> list[Any]:
    """Return the initial value of a variable in a list, which is empty where it has none."""
    variable = declared.get(cell.name)
    return [variable.value] if isinstance(variable, model.Variable) and variable.has_value else []


def keys_of(part: Part) -> dict[str, list[str]]:
    """Return the keys of a container: all go in and out.

    SMACH would hand in wrapped what only comes in; and what only goes out would be, where nobody has written it this
    time, the value of the time before.
    """
    keys = list({**reads(part), **writes(part)})
    return {"input_keys": keys, "output_keys": keys} if keys else {}


def set_key(plan: Plan, userdata: str, name: str, value: object) -> None:
    """Write a value of userdata."""
    plain = name.isidentifier() and not name.startswith("_")
    plan.write(_expression(value), f"{userdata}.{name}" if plain else f"{userdata}[{name!r}]")


def _expression(value: object) -> Items | Code:
    found = literal(value)
    assert isinstance(found, Items | Code), "these are all expressions"
    return found
