"""Leaves from functions: a blocking function, or a coroutine, and its annotations say everything else.

    @leaf("count/tall", doc="Count what is taller than a limit.", outputs={"count": int})
    def tall(cloud: PointCloud, *, limit: float = 0.1) -> int:
        return ...

Parameters before the `*` are inputs, those after it are parameters of the task; what is annotated `Context` gets the
run's context. The function runs in a worker, a coroutine on an event loop of its own there, and with `quick=True` in
the tick itself. An `ExpectedError` is a failure with its code; another exception is a bug. A function with outcomes
of its own returns `End("outcome", port=value)`.

The same decorator marks a class that is a leaf, whose ports stand in its annotations; see `nodes.ports_of_class`.
In a project's `nodes` folder both are found without running them; see `catalog.python_nodes`.
"""

from __future__ import annotations

import asyncio
import inspect
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from grip_bt.catalog.manifest import InputPort, Manifest, OutputPort, Parameter
from grip_bt.errors import CanceledError
from grip_bt.graph.frozen import FrozenDict
from grip_bt.operation import Operation
from grip_bt.ports import Context

from .leaf import Leaf, OperationLeaf, Status
from .ports_of_class import with_ports


class FunctionLeaf(OperationLeaf):
    """A leaf that calls a function; `leaf` makes its subclasses.

    Attributes:
        function: what is called.
        face: the manifest made from the function's annotations.
    """

    function: ClassVar[Callable[..., Any]]
    face: ClassVar[Manifest]
    context_names: ClassVar[tuple[str, ...]] = ()
    quick: ClassVar[bool] = False
    labelled: ClassVar[bool] = False

    def start(self) -> Operation[Any]:
        """Call the function in a worker."""
        ports = [p for p, port in self.manifest.inputs.items() if port.required or p in self.readers]
        arguments = {**{p: self.read(p) for p in ports}, **self.params}
        arguments.update(dict.fromkeys(self.context_names, self.context))
        call = type(self).function
        if type(self).quick:
            return Operation.finished(call(**arguments))
        if inspect.iscoroutinefunction(call):
            return _run_coroutine(self.context, lambda: call(**arguments))
        return self.context.run_in_worker(lambda: call(**arguments))

    def finish(self, result: Any) -> Status:
        """Hand out the result: as the one output, or as a mapping of several."""
        names = list(self.manifest.outputs)
        if isinstance(result, End):
            return self._end(result)
        if type(self).labelled:
            raise TypeError(f"{self.manifest.id} has outcomes of its own: return End('outcome', ...), not {result!r}")
        if not names:
            return self.end()
        if len(names) == 1:
            return self.end(**{names[0]: result})
        if not isinstance(result, Mapping) or set(result) != set(names):
            raise TypeError(f"{self.manifest.id} has several outputs: return a mapping with the keys {names}")
        return self.end(**result)

    def _end(self, said: End) -> Status:
        if said.code:
            return self.fail(said.code, said.message, outcome=said.outcome, outputs=said.outputs)
        return self.end(said.outcome, **said.outputs)


class End:
    """How a function ends that has outcomes of its own: `return End("heavy", weight=3.2)`.

    Args:
        outcome: one of those that were declared.
        code: of a failure, for `on: {failure.<code>: ...}`.
        message: of a failure, a sentence for people.
        **outputs: output port -> value.
    """

    def __init__(self, outcome: str, /, *, code: str = "", message: str = "", **outputs: Any):
        self.outcome, self.code, self.message, self.outputs = outcome, code, message, outputs


def leaf(
    id: str,
    *,
    doc: str = "",
    outputs: Mapping[str, Any] | None = None,
    codes: tuple[str, ...] = (),
    outcomes: Mapping[str, str] | None = None,
    quick: bool = False,
) -> Callable[[Any], Any]:
    """Make a leaf of a function or a coroutine, or mark a class as one.

    Args:
        id: catalogue id, such as `count/tall`.
        doc: what it does; the docstring by default.
        outputs: output port -> type. One output takes the function's result; several take a mapping. A class annotates
            its outputs instead.
        codes: failure codes that it may end with.
        outcomes: outcome -> `success` or `failure`; these two alone by default.
        quick: call the function in the tick, for what takes microseconds; else it runs in a worker.

    Raises:
        TypeError: a parameter has no annotation, or takes any number of arguments; a class isn't a `Leaf`.
    """

    def make(function: Callable[..., Any]) -> type[Leaf]:
        if isinstance(function, type):
            return with_ports(function)
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


def type_name(hint: Any) -> str:
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


def _run_coroutine(context: Context, coroutine: Callable[[], Any]) -> Operation[Any]:
    """Run a coroutine to its end in a worker; cancelling the operation cancels the coroutine's task."""
    loop_and_task: list[Any] = []

    async def main() -> Any:
        loop_and_task[:] = [asyncio.get_running_loop(), asyncio.current_task()]
        if whole.cancel_asked:
            raise CanceledError("canceled")
        return await coroutine()

    def work() -> Any:
        try:
            return asyncio.run(main())
        except asyncio.CancelledError:
            raise CanceledError("canceled") from None

    def cancel() -> None:
        if loop_and_task:
            loop, task = loop_and_task
            try:
                loop.call_soon_threadsafe(task.cancel)
            except RuntimeError:  # the loop has just closed: the coroutine has ended
                pass

    whole: Operation[Any] = Operation(on_cancel=cancel)
    part = context.run_in_worker(work)

    def ended() -> None:
        try:
            whole.succeed(part.result())
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            whole.fail(error)

    part.add_done_callback(ended)
    return whole
