"""A set of names that remembers the order of declaration.

Legacy code touches the sets of a state directly (`state._outcomes.add(...)`, differences), so it has to be a `set`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import wraps
from typing import Any


class Names(set[Any]):
    """A set that iterates in the order in which names were added first.

    Attributes:
        frozen: the very object that `freeze` returned, until the set is changed: shows at a glance that it wasn't.
    """

    def __init__(self, names: Iterable[Any] = ()):
        self._order: dict[Any, None] = dict.fromkeys(names)
        super().__init__(self._order)
        self.frozen: frozenset[Any] | None = None

    def freeze(self) -> frozenset[Any]:
        """Return the names as they are now, the same object as long as nothing changes them."""
        if self.frozen is None:
            self.frozen = frozenset(self)
        return self.frozen

    def __iter__(self) -> Iterator[Any]:
        # What C code removed is left out; what it added by other ways (`^=`) comes last.
        known = [name for name in self._order if name in self]
        if len(known) != len(self):
            known.extend(set.difference(self, self._order))
        return iter(known)

    def add(self, name: Any) -> None:
        """Add a name at the end."""
        self._order.setdefault(name)
        super().add(name)
        self.frozen = None

    def update(self, *others: Iterable[Any]) -> None:
        """Add several names at the end."""
        for names in others:
            for name in names:
                self.add(name)

    def __ior__(self, other: Any) -> Names:  # type: ignore[misc]  # `|` still gives a plain set
        self.update(other)
        return self

    def union(self, *others: Iterable[Any]) -> Names:
        """Return a new set: these names, then the others'."""
        result = Names(self)
        result.update(*others)
        return result

    def __reduce__(self) -> tuple[Any, ...]:
        return (Names, (list(self),))


def _noting(method: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method of `set` that changes it, with a note that it did."""

    @wraps(method)
    def changes(self: Names, *args: Any) -> Any:
        try:
            return method(self, *args)
        finally:
            self.frozen = None

    return changes


for _name in (
    *("discard", "remove", "pop", "clear", "difference_update", "intersection_update"),
    *("symmetric_difference_update", "__isub__", "__iand__", "__ixor__"),
):
    setattr(Names, _name, _noting(getattr(set, _name)))
