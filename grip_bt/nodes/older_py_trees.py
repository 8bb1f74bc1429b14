"""py_trees as it was called before 2.2: code that was written for it builds its tree with today's."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial, wraps
from typing import Any
from unittest import mock

from py_trees import behaviours, composites, decorators, idioms
from py_trees.behaviour import Behaviour
from py_trees.common import OneShotPolicy, ParallelPolicy, Status

_POLICIES: dict[str, Any] = {
    "SUCCESS_ON_ALL": ParallelPolicy.SuccessOnAll(),
    "SUCCESS_ON_ONE": ParallelPolicy.SuccessOnOne(),
}
_DEFAULTS: dict[str, Any] = {
    "overwrite": True,
    "status": Status.SUCCESS,
    "completion_status": Status.SUCCESS,
}
_OF_CLASSES: dict[type, dict[str, Any]] = {
    composites.Sequence: {"memory": True},
    composites.Selector: {"memory": False},
    composites.Parallel: {"policy": _POLICIES["SUCCESS_ON_ALL"]},
    decorators.OneShot: {"policy": OneShotPolicy.ON_SUCCESSFUL_COMPLETION},
}
_PATIENCE = 15.0
"""How long [s] a `setup` is told that it may take."""
_DROPPED = ("memory", "blackbox_level")
"""What every composite took, and did nothing with where it had no use for it."""


@contextmanager
def older_calls() -> Iterator[None]:
    """Take the calls of older code too; those of today's mean what they mean."""
    with ExitStack() as patched:
        patched.enter_context(mock.patch.multiple(ParallelPolicy, create=True, **_POLICIES))
        patched.enter_context(mock.patch.object(idioms, "oneshot", partial(_once, idioms.oneshot)))
        for module in (behaviours, composites, decorators):
            for cls in vars(module).values():
                mine = isinstance(cls, type) and issubclass(cls, Behaviour) and cls.__module__ == module.__name__
                if mine and "name" in inspect.signature(cls).parameters and "__init__" in vars(cls):
                    patched.enter_context(mock.patch.object(cls, "__init__", _taking_both(cls)))
        yield


def take_older_setups(root: Behaviour) -> None:
    """Have each `setup(timeout)` of a tree called without arguments, as today's are."""
    for each in root.iterate():
        needed = inspect.signature(each.setup).parameters.get("timeout")
        if needed is not None and needed.default is needed.empty:
            vars(each)["setup"] = partial(each.setup, timeout=_PATIENCE)


def _once(original: Callable[..., Behaviour], *given: Any, **named: Any) -> Behaviour:
    """Make the idiom as it is called today, or as it was: with the behaviour last."""
    if given and not isinstance(given[0], Behaviour):
        given, named = (), dict(zip(("name", "variable_name", "behaviour"), given, strict=False)) | named
    return original(*given, **named)


def _taking_both(cls: Any) -> Callable[..., None]:
    original, parameters = cls.__init__, inspect.signature(cls).parameters
    others = [name for name in parameters if name != "name"]
    composite = issubclass(cls, composites.Composite)
    order = [others[0], "name", *others[1:]] if issubclass(cls, decorators.Decorator) else [*others, "name"]
    defaults = {name: each for name, each in (_DEFAULTS | _OF_CLASSES.get(cls, {})).items() if name in parameters}

    def binds(given: tuple[Any, ...], named: dict[str, Any]) -> bool:
        try:
            bound = inspect.signature(original).bind(None, *given, **named).arguments
        except TypeError:
            return False
        return isinstance(bound.get("name", ""), str) and not isinstance(bound.get("memory"), list | tuple)

    @wraps(original)
    def made(self: Any, *given: Any, **named: Any) -> None:
        if not binds(given, named):
            if composite:  # its name was the first argument, and `memory` wasn't there
                named = {n: each for n, each in named.items() if n in parameters or n not in _DROPPED}
                listed = len(given) > 1 and isinstance(given[1], list | tuple)
                named = dict(zip(("name", "children") if listed else parameters, given, strict=False)) | named
            else:
                named = dict(zip(order, given, strict=False)) | named
            given, named = (), {"name": type(self).__name__} | defaults | named
        original(self, *given, **named)

    return made
