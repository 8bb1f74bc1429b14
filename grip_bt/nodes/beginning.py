"""How a leaf begins to be a behaviour: what `Behaviour.__init__` does, without asking the system for random numbers.

A task of a thousand nodes makes a thousand behaviours before its first tick, and the `uuid4` of each takes a third of
that time. Here an id is the next one after a random beginning: as unique, and a version 4 UUID like every other.
"""

from __future__ import annotations

from itertools import count
from uuid import UUID, uuid4

from py_trees import common, logging
from py_trees.behaviour import Behaviour

_LAST_BITS = 48
_FIRST = uuid4().int >> _LAST_BITS << _LAST_BITS
_NEXT = count(1)
_FIELDS = {
    *("id", "name", "blackboards", "qualified_name", "status", "iterator", "parent", "children", "logger"),
    *("feedback_message", "blackbox_level"),
}


def next_id() -> UUID:
    """Return an id that no other behaviour has."""
    made = object.__new__(UUID)
    made.__setstate__({"int": _FIRST + next(_NEXT)})  # type: ignore[attr-defined]
    return made


class _Sample(Behaviour):
    def update(self) -> common.Status:
        return common.Status.SUCCESS


def _as_known() -> bool:
    """Tell whether a behaviour has just the attributes that are set here; in another py_trees there may be more."""
    return vars(_Sample("")).keys() == _FIELDS and hasattr(UUID, "__setstate__")


def _begin(behaviour: Behaviour, name: str) -> None:
    behaviour.id = next_id()
    behaviour.name = name
    behaviour.blackboards = []
    behaviour.qualified_name = f"{behaviour.__class__.__qualname__}/{name}"
    behaviour.status = common.Status.INVALID
    behaviour.iterator = behaviour.tick()
    behaviour.parent = None
    behaviour.children = []
    behaviour.logger = logging.Logger(name)
    behaviour.feedback_message = ""
    behaviour.blackbox_level = common.BlackBoxLevel.NOT_A_BLACKBOX


begin = _begin if _as_known() else Behaviour.__init__
"""Called as (behaviour, name) in place of `Behaviour.__init__`."""
