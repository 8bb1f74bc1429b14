"""What compiled code relies on, and whether it still holds.

A node's structure is compared when it is ticked or halted. Methods are watched by the size of each node's attribute
dictionary: a method assigned to an instance makes it grow. A size that changed for another reason is forgotten.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite

from .known import LIFE_CYCLE

Changed = Callable[[], bool]

_children, _memory, _decorated = attrgetter("children"), attrgetter("memory"), attrgetter("decorated")


class Methods:
    """The life cycle methods of some instances, as they were when this was made."""

    def __init__(self, nodes: Iterable[Behaviour]):
        self.dicts = [_attributes(node) for node in nodes]
        self.sizes = [*map(len, self.dicts)]
        self._own = self._owned()

    def replaced(self) -> bool:
        """Tell whether an instance has got or lost a method of its life cycle; called when a size has changed."""
        if self._owned() != self._own:
            return True
        self.sizes[:] = map(len, self.dicts)
        return False

    def _owned(self) -> list[list[str]]:
        return [[name for name in LIFE_CYCLE if name in attributes] for attributes in self.dicts]


def watch(node: Any, kids: Sequence[Behaviour], fixed_methods: bool) -> Changed:
    """Return what tells whether an inner node has other children or settings, or its children methods of their own."""
    methods = Methods(() if fixed_methods else kids)
    dicts, sizes, replaced = methods.dicts, methods.sizes, methods.replaced
    watched = bool(dicts)
    if not isinstance(node, Composite):
        kid = kids[0]

        def changed() -> bool:
            return node.decorated is not kid or (watched and [*map(len, dicts)] != sizes and replaced())

    elif hasattr(node, "memory"):
        memory = node.memory

        def changed() -> bool:
            if node.children != kids or node.memory is not memory:
                return True
            return watched and [*map(len, dicts)] != sizes and replaced()

    else:

        def changed() -> bool:
            return node.children != kids or (watched and [*map(len, dicts)] != sizes and replaced())

    return changed


def watch_all(inner: Sequence[Any], below: Sequence[Behaviour], fixed_methods: bool) -> Changed:
    """Return what tells the same of all inner nodes of a sub-tree in one look, in C."""
    methods = Methods(() if fixed_methods else below)
    dicts, sizes, replaced = methods.dicts, methods.sizes, methods.replaced
    composites = [node for node in inner if isinstance(node, Composite)]
    ordered = [node for node in composites if hasattr(node, "memory")]
    decorators = [node for node in inner if not isinstance(node, Composite)]
    kids, memories = [list(node.children) for node in composites], [node.memory for node in ordered]
    decorated = [node.decorated for node in decorators]

    def changed() -> bool:
        return (
            [*map(_children, composites)] != kids
            or [*map(_memory, ordered)] != memories
            or [*map(_decorated, decorators)] != decorated
            or ([*map(len, dicts)] != sizes and replaced())
        )

    return changed


def watch_classes(classes: Iterable[type]) -> Changed:
    """Return what tells whether a life cycle method of a class was replaced."""
    watched = [(attrgetter(*(name for name in LIFE_CYCLE if hasattr(cls, name))), cls) for cls in set(classes)]
    was = [get(cls) for get, cls in watched]

    def changed() -> bool:
        return [get(cls) for get, cls in watched] != was

    return changed


_unshared: dict[int, weakref.ref[Behaviour]] = {}


def _attributes(node: Behaviour) -> dict[str, Any]:
    """Return the node's attributes, in a dictionary of their own.

    Asking for `__dict__` makes CPython 3.11 and 3.12 give up the instance's compact form for one that shares its keys
    with other instances, in which reading and writing attributes is slow. Plain dictionaries are fast. Each node gets
    one once, since whoever watches holds on to it.
    """
    key = id(node)
    known = _unshared.get(key)
    if known is None or known() is not node:
        node.__dict__ = dict(vars(node))
        _unshared[key] = weakref.ref(node, lambda _: _unshared.pop(key, None))
    attributes: dict[str, Any] = vars(node)
    return attributes
