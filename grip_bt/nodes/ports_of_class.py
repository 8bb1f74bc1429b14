"""Ports of a leaf that is written as a class: annotations, and attributes that read them.

    @grip.leaf("shop/weigh", outcomes={"heavy": "success", "light": "success"})
    class Weigh(grip.Leaf):
        \"\"\"Say whether what stands on the scales is heavy.\"\"\"

        scales: grip.Input[str]
        limit: grip.Param[float] = 2.0
        weight: grip.Output[float]

        def update(self):
            weight = read_scales(self.scales)
            return self.end("heavy" if weight > self.limit else "light", weight=weight)

`self.scales` reads the variable that is bound to the input, `self.limit` is the parameter of the task. An input with
the default None may be left unbound.
"""

from __future__ import annotations

import inspect
import re
from typing import Any, Generic, TypeVar, overload

from .async_leaf import AsyncLeaf
from .leaf import Leaf

T = TypeVar("T")
_MARK = re.compile(r"(?:^|\.)(Input|Output|Param)\[")


class _Port(Generic[T]):
    """What an annotation stands for; type checkers see the value's type."""

    def __init__(self, name: str):
        self.name = name

    @overload
    def __get__(self, leaf: None, owner: type) -> _Port[T]: ...
    @overload
    def __get__(self, leaf: Leaf, owner: type) -> T: ...
    def __get__(self, leaf: Leaf | None, owner: type) -> Any:
        return self if leaf is None else self.of(leaf)

    def __set__(self, leaf: Leaf, value: T) -> None:
        raise AttributeError(f"port {self.name!r} can't be assigned; an output is given to self.end({self.name}=...)")

    def of(self, leaf: Leaf) -> T:
        """Return the port's value."""
        raise NotImplementedError


class Input(_Port[T]):
    """An input port: the value of the bound variable, read anew each time; None where it is optional and unbound."""

    def of(self, leaf: Leaf) -> T:
        """Read the variable."""
        value: T = leaf.read(self.name)
        return value


class Param(_Port[T]):
    """A parameter: the literal of the task, or the default."""

    def of(self, leaf: Leaf) -> T:
        """Return the literal."""
        value: T = leaf.params[self.name]
        return value


class Output(_Port[T]):
    """An output port; its value is given to `self.end`."""

    def of(self, leaf: Leaf) -> T:
        """Refuse to read it."""
        raise AttributeError(f"output {self.name!r} can't be read; give its value to self.end({self.name}=...)")


_OWN = frozenset(
    ("name", "path", "manifest", "params", "meaning", "inputs_read", "askers", "readers", "writers", "context")
    + ("id", "parent", "children", "status", "iterator", "logger", "feedback_message", "blackboards", "observer")
    + ("outcome", "failure", "qualified_name", "blackbox_level")
)
"""Attributes that leaves get when they are made."""
_KINDS: dict[str, type[_Port[Any]]] = {"Input": Input, "Output": Output, "Param": Param}


def with_ports(cls: type) -> type[Leaf]:
    """Give a class that is a leaf an attribute for each annotated port.

    Raises:
        TypeError: it isn't a `Leaf`, a port has the name of something that leaves have already, or its coroutine
            `run` and its base don't go together.
    """
    if not issubclass(cls, Leaf):
        raise TypeError(
            f"class {cls.__qualname__} has to be a grip_bt.Leaf, a grip_bt.OperationLeaf or a grip_bt.AsyncLeaf"
        )
    _check_run(cls)
    for name, hint in vars(cls).get("__annotations__", {}).items():
        mark = _MARK.search(hint if isinstance(hint, str) else str(hint))
        if mark is None:
            continue
        if any(hasattr(base, name) for base in cls.__bases__) or name in _OWN:
            raise TypeError(f"{cls.__qualname__}: leaves have an attribute {name!r} already; call the port otherwise")
        setattr(cls, name, _KINDS[mark.group(1)](name))
    return cls


def _check_run(cls: type[Leaf]) -> None:
    """Refuse a coroutine `run` that nobody would call, and a `run` that isn't one."""
    run = getattr(cls, "run", None)
    if issubclass(cls, AsyncLeaf):
        if run is AsyncLeaf.run or not inspect.iscoroutinefunction(run):
            raise TypeError(f"{cls.__qualname__}: a grip_bt.AsyncLeaf has a coroutine: async def run(self)")
    elif inspect.iscoroutinefunction(run):
        raise TypeError(f"{cls.__qualname__}: a class with `async def run` has to be a grip_bt.AsyncLeaf")
    if inspect.iscoroutinefunction(cls.update):
        raise TypeError(f"{cls.__qualname__}: update() is ticked; make it `async def run` of a grip_bt.AsyncLeaf")
