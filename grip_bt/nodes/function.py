"""Leaves from functions and classes, whose annotations say everything else; `docs/own_nodes.md` shows how."""

from __future__ import annotations

import inspect
import re
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Generic, TypeVar, overload

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Context
from grip_bt.base.types import Value
from grip_bt.nodes.async_leaf import AsyncLeaf, finish, run_coroutine
from grip_bt.nodes.leaf import Leaf, OperationLeaf, Status
from grip_bt.task.catalog.manifest import InputPort, Manifest, OutputPort, Parameter

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
    def __get__(self, leaf: Leaf | None, owner: type) -> object:
        return self if leaf is None else self.of(leaf)

    def __set__(self, leaf: Leaf, value: T) -> None:
        raise AttributeError(f"port {self.name!r} can't be assigned; an output is given to self.end({self.name}=...)")

    def of(self, leaf: Leaf) -> T:
        raise NotImplementedError


class Input(_Port[T]):
    """An input port: the value of the bound variable, read anew each time; None where it is optional and unbound."""

    def of(self, leaf: Leaf) -> T:
        value: T = leaf.read(self.name)
        return value


class Param(_Port[T]):
    """A parameter: the literal of the task, or the default."""

    def of(self, leaf: Leaf) -> T:
        value: T = leaf.params[self.name]
        return value


class Output(_Port[T]):
    """An output port; its value is given to `self.end`."""

    def of(self, leaf: Leaf) -> T:
        raise AttributeError(f"output {self.name!r} can't be read; give its value to self.end({self.name}=...)")


_OWN = frozenset(
    ("name", "path", "manifest", "params", "meaning", "inputs_read", "askers", "readers", "writers", "context")
    + ("id", "parent", "children", "status", "iterator", "logger", "feedback_message", "blackboards", "observer")
    + ("outcome", "failure", "qualified_name", "blackbox_level")
)
"""Attributes that leaves get when they are made."""
_KINDS: dict[str, type[_Port[object]]] = {"Input": Input, "Output": Output, "Param": Param}


def _with_ports(cls: type) -> type[Leaf]:
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
            raise TypeError(f"{cls.__qualname__}: leaves have an attribute {name!r} already; rename the port")
        setattr(cls, name, _KINDS[mark.group(1)](name))
    return cls


def _check_run(cls: type[Leaf]) -> None:
    run = getattr(cls, "run", None)
    if issubclass(cls, AsyncLeaf):
        if run is AsyncLeaf.run or not inspect.iscoroutinefunction(run):
            raise TypeError(f"{cls.__qualname__}: a grip_bt.AsyncLeaf has a coroutine: async def run(self)")
    elif inspect.iscoroutinefunction(run):
        raise TypeError(f"{cls.__qualname__}: a class with `async def run` has to be a grip_bt.AsyncLeaf")
    if inspect.iscoroutinefunction(cls.update):
        raise TypeError(f"{cls.__qualname__}: update() is ticked; make it `async def run` of a grip_bt.AsyncLeaf")


class FunctionLeaf(OperationLeaf):
    """A leaf that calls a function; `leaf` makes its subclasses, with the manifest made from its annotations."""

    function: ClassVar[Callable[..., Value]]
    face: ClassVar[Manifest]
    context_names: ClassVar[tuple[str, ...]] = ()
    quick: ClassVar[bool] = False
    labelled: ClassVar[bool] = False

    def start(self) -> Operation[Value]:
        ports = [p for p, port in self.manifest.inputs.items() if port.required or p in self.readers]
        arguments = {**{p: self.read(p) for p in ports}, **self.params}
        arguments.update(dict.fromkeys(self.context_names, self.context))
        call = type(self).function
        if type(self).quick:
            return Operation.finished(call(**arguments))
        if inspect.iscoroutinefunction(call):
            return run_coroutine(self.context, lambda: call(**arguments))
        return self.context.run_in_worker(lambda: call(**arguments))

    def finish(self, result: Value) -> Status:
        return finish(self, result, labelled=type(self).labelled)


def leaf(
    id: str,
    *,
    doc: str = "",
    outputs: Mapping[str, object] | None = None,
    codes: tuple[str, ...] = (),
    outcomes: Mapping[str, str] | None = None,
    quick: bool = False,
    moves: bool | None = None,
) -> Callable[[Callable[..., Value]], type[Leaf]]:
    """Make a leaf of a function or a coroutine, or mark a class as one.

    Args:
        id: catalogue id, such as `count/tall`.
        doc: what it does; the docstring by default.
        outputs: output port -> type. One output takes the function's result; several take a mapping. A class annotates
            its outputs instead.
        codes: failure codes that it may end with.
        outcomes: outcome -> `success` or `failure`; these two alone by default.
        quick: call the function in the tick, for what takes microseconds; else it runs in a worker.
        moves: whether its work may move something; see `Manifest.moves`. A function that gets no context doesn't,
            unless this says so.

    Raises:
        TypeError: a parameter has no annotation, or takes any number of arguments; a class isn't a `Leaf`.
    """

    def make(function: Callable[..., Any]) -> type[Leaf]:
        if isinstance(function, type):
            return _with_ports(function)
        if quick and inspect.iscoroutinefunction(function):
            raise TypeError(f"{function.__qualname__}: a coroutine waits, so it can't be quick")
        hints = typing.get_type_hints(function)
        inputs, parameters, contexts = {}, {}, []
        for name, parameter in inspect.signature(function).parameters.items():
            if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD) or name not in hints:
                raise TypeError(f"{function.__qualname__}: {name!r} needs an annotation and a name of its own")
            given = {} if parameter.default is parameter.empty else {"default": parameter.default}
            if hints[name] is Context:
                contexts.append(name)
            elif parameter.kind is parameter.KEYWORD_ONLY:
                parameters[name] = Parameter(type=type_name(hints[name]), **given)
            else:
                inputs[name] = InputPort(type=type_name(hints[name]), required=not given)
        face = Manifest(
            id=id,
            doc=doc or inspect.getdoc(function) or id,
            implementation=f"{function.__module__}:{function.__qualname__}",
            parameters=FrozenDict(parameters),
            inputs=FrozenDict(inputs),
            outputs=FrozenDict({n: OutputPort(type=type_name(t)) for n, t in (outputs or {}).items()}),
            codes=codes,
            moves=False if moves is None and not contexts else moves,
            **({"outcomes": FrozenDict(outcomes)} if outcomes else {}),
        )
        members = {
            "quick": quick,
            "labelled": outcomes is not None,
            "function": staticmethod(function),
            "face": face,
            "context_names": tuple(contexts),
            "__doc__": face.doc,
            "__module__": function.__module__,
            "__qualname__": function.__qualname__,
        }
        return type(function.__name__, (FunctionLeaf,), members)

    return make


def type_name(hint: object) -> str:
    """Return how a manifest spells a Python annotation: `list[Grasp]`, `float | None`, `Any`."""
    if hint is Any:
        return "Any"
    if hint is type(None):
        return "None"
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " | ".join(type_name(a) for a in arguments)
    if origin is not None:
        return f"{origin.__name__}[{', '.join(type_name(a) for a in arguments)}]"
    return str(getattr(hint, "__name__", hint))
