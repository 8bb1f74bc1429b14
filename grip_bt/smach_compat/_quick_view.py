"""A view of userdata for a state that is executed again and again: what `Remapper` does, in closures made once.

A view is read and written at each activation, and on Python 3.11 a class with `__getattr__` pays most for attributes
that it hasn't got. Here each input is a property and the parts of a view are in closures. Nothing is remembered that
can change: the store's values and locks, and the remapping, are looked at at each access; whatever isn't simply there
is left to `Remapper`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from .user_data import Const, Remapper, UserData

_BARE = frozenset({int, float, bool, complex, str, bytes, bytearray, type(None), list, tuple, dict, set, frozenset})
"""Types, and not their subclasses, whose values aren't wrapped, because they have no `__dict__`."""

_ACCESS = ("__getattr__", "__setattr__", "__getitem__", "__setitem__", "__contains__")
_OURS = [(cls, name, cls.__dict__[name]) for cls in (UserData, Remapper) for name in _ACCESS]
_METHODS = frozenset(dir(Remapper))


def untouched() -> bool:
    """Tell whether nobody has patched how userdata is had."""
    return all(cls.__dict__.get(name) is ours for cls, name, ours in _OURS)


def possible(store: Any) -> bool:
    """Tell whether values of a store may be had without asking it."""
    return type(store) is UserData and untouched()


def quick_view(store: UserData, inputs: Iterable[str], outputs: Iterable[str], names: Any) -> Remapper:
    """Return a `Remapper` with these arguments that is quicker to use and slower to make.

    It becomes an ordinary one as soon as an attribute that is no userdata is set on it; `vars(view)` isn't empty then.
    """
    readable, writable = frozenset(inputs), frozenset(outputs)
    variables = vars(store)
    read_item, write_item = _items(readable, writable, names, variables)
    kind: Any = type(
        "Remapper",
        (Remapper,),
        {
            "__slots__": (),
            "__module__": Remapper.__module__,
            "__qualname__": Remapper.__qualname__,
            "__doc__": Remapper.__doc__,
            "__reduce__": _reduce,
            "__setattr__": _writer(frozenset(key for key in writable if key[:1] != "_"), names, variables),
            "__getitem__": read_item,
            "__setitem__": write_item,
            **{
                key: property(_reader(key, key in writable, names, variables), _hide(key))
                for key in readable - _METHODS
                if key[:1] != "_"
            },
        },
    )
    return kind(store, readable, writable, names)  # type: ignore[no-any-return]


def _reader(name: str, itself: bool, names: Any, variables: dict[str, Any]) -> Callable[[Remapper], Any]:
    """Return the reading of one input; of the value itself or as an input only."""

    def read(view: Remapper) -> Any:
        if name in names:
            there = names[name]
            if there[0] == "_":
                return Remapper.__getattr__(view, name)
        else:
            there = name
        locks = variables["_locks"]
        if locks and there in locks:
            return Remapper.__getattr__(view, name)
        try:
            value = variables["_data"][there]
        except KeyError:
            return Remapper.__getattr__(view, name)
        if itself or type(value) in _BARE or not hasattr(value, "__dict__"):
            return value
        return Const(value)

    return read


def _hide(name: str) -> Callable[[Remapper, Any], None]:
    """Return what `object.__setattr__(view, name, value)` does: the attribute comes before the userdata."""

    def hide(view: Remapper, value: Any) -> None:
        object.__setattr__(view, "__class__", Remapper)
        object.__setattr__(view, name, value)

    return hide


def _writer(writable: frozenset[str], names: Any, variables: dict[str, Any]) -> Callable[[Remapper, str, Any], None]:
    """Return the setting of an attribute."""

    def write(view: Remapper, name: str, value: Any) -> None:
        if name in writable:
            variables["_data"][names[name] if name in names else name] = value
        else:
            if name[0] == "_":
                object.__setattr__(view, "__class__", Remapper)
            Remapper.__setattr__(view, name, value)

    return write


def _items(
    readable: frozenset[str], writable: frozenset[str], names: Any, variables: dict[str, Any]
) -> tuple[Callable[[Remapper, Any], Any], Callable[[Remapper, Any, Any], None]]:
    """Return the reading and the writing of an item."""

    def read(view: Remapper, key: Any) -> Any:
        if key in readable:
            there = names[key] if key in names else key
            locks, data = variables["_locks"], variables["_data"]
            if there in data and not (locks and there in locks) and there[0] != "_":
                value = data[there]
                if key in writable or type(value) in _BARE or not hasattr(value, "__dict__"):
                    return value
                return Const(value)
        return Remapper.__getitem__(view, key)

    def write(view: Remapper, key: Any, value: Any) -> None:
        if key in writable:
            variables["_data"][names[key] if key in names else key] = value
        else:
            Remapper.__setitem__(view, key, value)

    return read, write


def _reduce(view: Remapper) -> tuple[Any, ...]:
    """Let copies be ordinary views."""
    return (Remapper, (view._ud, view._input, view._output, view._map))
