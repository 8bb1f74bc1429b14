"""Somebody's own behaviour of py_trees as a node of a task: it keeps its life cycle and gets a path and an outcome."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure

from .node import Node


class Variable(Protocol):
    """Where a variable's value is."""

    value: object


Shared = tuple[Variable, Callable[[object], None] | None]
"""A variable that is a key of py_trees' blackboard too, where None means that the key isn't there; what writes it."""


class Foreign(Node, decorators.Decorator):
    """Ends as the behaviour that it holds; when that has failed, its feedback message is the reason."""

    def __init__(
        self,
        name: str,
        path: str,
        meaning: Mapping[str, str],
        behaviour: Behaviour,
        shared: Mapping[str, Shared] | None = None,
    ):
        decorators.Decorator.__init__(self, name, behaviour)
        self.path, self.meaning, self._shared = path, dict(meaning), dict(shared or {})
        self._known: dict[str, Any] = {}

    def tick(self) -> Iterator[Behaviour]:
        """Tick as py_trees does; what the behaviour raises is named."""
        if self.status != Status.RUNNING:
            self.begin()
        try:
            self._give()
            yield from super().tick()
        except NodeError:
            raise  # of a node below it
        except Exception as error:
            raise NodeError(self.path, error) from error

    def update(self) -> Status:
        self._take()
        return self.decorated.status

    def conclude(self, status: Status) -> None:
        super().conclude(status)
        message = str(self.decorated.feedback_message)
        self.failure = Failure("foreign", message) if status == Status.FAILURE else None

    def _give(self) -> None:
        """Put the variables that were written since onto the blackboard; what was there before all is taken from it."""
        for key, (variable, _) in self._shared.items():
            value = variable.value
            if value is self._known.get(key) or (key not in self._known and value is None):
                continue
            self._known[key] = value
            if value is None:
                Blackboard.storage.pop(key, None)
            else:
                Blackboard.storage[key] = value

    def _take(self) -> None:
        """Write the variables whose keys have another value now."""
        for key, (variable, write) in self._shared.items():
            value = Blackboard.storage.get(key)
            if value is not self._known.get(key):
                self._known[key] = value
                if write is not None and value is not variable.value:
                    write(value)


def give_children(behaviour: Behaviour, children: Sequence[Behaviour]) -> None:
    """Replace the children of a decorator or composite, wherever it names them."""
    before = list(behaviour.children)
    for child in children:
        child.parent = behaviour
    behaviour.children = list(children)
    for name, value in list(vars(behaviour).items()):
        for old, new in zip(before, children, strict=False):
            if value is old:
                setattr(behaviour, name, new)
    if isinstance(behaviour, decorators.Decorator):
        behaviour.decorated = children[0]


def by_path(root: Behaviour) -> dict[str, Behaviour]:
    """Return every behaviour of a tree by the names on the way to it; `/` is the root, and doubles are numbered."""
    found, stack = {"/": root}, [("/", root)]
    while stack:
        path, node = stack.pop()
        for child in node.children:
            name, number = (path + "/" + child.name).lstrip("/") or "/", 2
            key = name
            while key in found:
                key, number = f"{name}#{number}", number + 1
            found[key] = child
            stack.append((key, child))
    return found


def class_path(behaviour: Behaviour) -> str:
    """Return where its class is: `package.module:Class`; one that a function makes stands below the function."""
    cls = type(behaviour)
    return f"{cls.__module__}:{cls.__qualname__}".replace("<locals>.", "")
