"""What compiled code relies on, and whether it still holds.

A node's structure (children, memory, the decorated child) is compared at each visit. Methods are watched by the size of
each node's attribute dictionary, in one pass of C over the children: a method assigned to an instance makes it grow. A
size that changed for another reason is noted and forgotten.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour

from .builtin import relies_on_update
from .kinds import LIFE_CYCLE


class Methods:
    """The methods of some instances, as they were when this was made.

    Args:
        nodes: whose methods; none where somebody has promised that none is replaced.
    """

    passing: ClassVar[int] = 0
    """How many plans have put something into their nodes that will be gone after the tick: sizes aren't noted then."""

    def __init__(self, nodes: Iterable[Behaviour] = ()):
        watched = list(nodes)
        self.dicts = [_attributes(node) for node in watched]
        self.sizes = [*map(len, self.dicts)]
        self._names = [_watched(type(node)) for node in watched]
        self._own = self._owned()

    @classmethod
    def joined(cls, parts: Iterable[Methods]) -> Methods:
        """Return those of all `parts`, as they were when each of them was made."""
        whole = cls()
        for part in parts:
            whole.dicts += part.dicts
            whole.sizes += part.sizes
            whole._names += part._names
            whole._own += part._own
        return whole

    def replaced(self) -> bool:
        """Tell whether an instance has got or lost a method of its life cycle; called when a size has changed."""
        if self._owned() != self._own:
            return True
        if not Methods.passing:
            self.sizes[:] = map(len, self.dicts)
        return False

    def _owned(self) -> list[list[str]]:
        """Return which methods each instance has of its own."""
        pairs = zip(self.dicts, self._names, strict=True)
        return [[name for name in names if name in attributes] for attributes, names in pairs]


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


def _watched(cls: type) -> tuple[str, ...]:
    """Return the methods whose replacement changes how an instance is compiled; others are looked up at each call."""
    return (*LIFE_CYCLE, "update") if relies_on_update(cls) else LIFE_CYCLE


class Classes:
    """The life cycle methods of some classes, as they were when this was made."""

    def __init__(self, classes: Iterable[type]):
        self._seen: list[tuple[Any, ...]] = [(cls, *_methods(cls)) for cls in set(classes)]
        called = {base for cls, *_ in self._seen if relies_on_update(cls) for base in cls.__mro__}
        self._updates: list[tuple[Any, Any]] = [(cls, cls.update) for cls in called if hasattr(cls, "update")]

    def changed(self) -> bool:
        """Tell whether a method of a class was replaced."""
        for cls, tick, stop, initialise, terminate in self._seen:
            if (
                cls.tick is not tick
                or cls.stop is not stop
                or cls.initialise is not initialise
                or cls.terminate is not terminate
            ):
                return True
        return any(cls.update is not update for cls, update in self._updates) if self._updates else False


def _methods(cls: Any) -> tuple[Any, Any, Any, Any]:
    return cls.tick, cls.stop, cls.initialise, cls.terminate


def watch_children(node: Any, kids: list[Behaviour], methods: Methods, memory: bool | None) -> Callable[[], bool]:
    """Return a function that tells whether the node, or what it knows about its children, has changed.

    Args:
        node: a composite or decorator.
        kids: its children when it was compiled.
        methods: those of the children.
        memory: the flag of a sequence or selector when it was compiled; None where there is none.
    """
    dicts, sizes, replaced = methods.dicts, methods.sizes, methods.replaced
    if memory is not None:

        def changed() -> bool:
            return node.children != kids or node.memory is not memory or ([*map(len, dicts)] != sizes and replaced())

    elif hasattr(node, "decorated"):
        (kid,) = kids

        def changed() -> bool:
            return node.decorated is not kid or ([*map(len, dicts)] != sizes and replaced())

    else:

        def changed() -> bool:
            return node.children != kids or ([*map(len, dicts)] != sizes and replaced())

    return changed
