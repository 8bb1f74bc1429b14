"""Which leaves of py_trees' own have a compiled `update`.

Looking up a blackboard variable by a client costs py_trees microseconds: a debug message, the split of the name, the
client's rights, its remapping, the text of the feedback.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from py_trees import behaviours
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Client
from py_trees.common import Status

from .builtin_updates import (
    F,
    R,
    S,
    Update,
    compare,
    compare_all,
    compare_two,
    compare_waiting,
    every_n,
    exists,
    exists_waiting,
    queue,
    set_value,
    status_of,
    unset,
)
from .kinds import replaced_on

_CONSTANT = {
    behaviours.Success.update: (S, "success"),
    behaviours.Failure.update: (F, "failure"),
    behaviours.Running.update: (R, "running"),
    behaviours.Dummy.update: (R, "crash test dummy"),
}
_MAKERS: dict[Any, Callable[[Any], Update]] = {
    behaviours.StatusQueue.update: queue,
    behaviours.SuccessEveryN.update: every_n,
    behaviours.BlackboardToStatus.update: status_of,
    behaviours.SetBlackboardVariable.update: set_value,
    behaviours.CheckBlackboardVariableExists.update: exists,
    behaviours.WaitForBlackboardVariable.update: exists_waiting,
    behaviours.CheckBlackboardVariableValue.update: compare,
    behaviours.WaitForBlackboardVariableValue.update: compare_waiting,
    behaviours.CheckBlackboardVariableValues.update: compare_all,
    behaviours.CompareBlackboardVariables.update: compare_two,
    behaviours.UnsetBlackboardVariable.update: unset,
}
_CALLED: dict[Any, tuple[Any, Any]] = {
    cls.update: (base, base.update)
    for cls, base in (
        (behaviours.WaitForBlackboardVariable, behaviours.CheckBlackboardVariableExists),
        (behaviours.WaitForBlackboardVariableValue, behaviours.CheckBlackboardVariableValue),
    )
}
"""Updates that call the one of another class."""
_CLEARING = {cls.terminate for cls in (behaviours.Success, behaviours.Failure, behaviours.Running, behaviours.Dummy)}
_CLIENT = ("get", "set", "unset", "__getattr__", "__setattr__")
_AS_IMPORTED = [getattr(Client, name) for name in _CLIENT]


@dataclass(frozen=True)
class Builtin:
    """What stands for the `update` of a leaf of py_trees.

    Attributes:
        update: does what the leaf's own does.
        constant: the result and the feedback of a leaf that always gives the same.
        clears: whether its `terminate` does nothing but empty the feedback of a leaf that becomes INVALID.
    """

    update: Update
    constant: tuple[Status, str] | None = None
    clears: bool = False


def builtin(node: Any, handed: dict[int, Status]) -> Builtin | None:
    """Return what stands for the `update` of a leaf; None where that is nothing else than its own.

    Args:
        node: a leaf.
        handed: results that were given already, by `id` of the leaf; each is taken once instead of looking again.
    """
    if not is_builtin(node):
        return None
    function = type(node).update
    if function in _CONSTANT:
        status, message = _CONSTANT[function]
        clears = type(node).terminate in _CLEARING and not replaced_on(node, "terminate")
        return Builtin(_constant(node, status, message), (status, message), clears)
    quick, key = _MAKERS[function](node), id(node)

    def update() -> Status:
        if handed and key in handed:
            return handed.pop(key)
        return quick()

    return Builtin(update)


def is_builtin(node: Any) -> bool:
    """Tell whether a node's `update` is one that is compiled."""
    if not relies_on_update(type(node)) or replaced_on(node, "update"):
        return False
    base, update = _CALLED.get(type(node).update, (Behaviour, Behaviour.update))
    return base.update is update and [getattr(Client, name) for name in _CLIENT] == _AS_IMPORTED


def relies_on_update(cls: type) -> bool:
    """Tell whether the `update` of a class is compiled, so that another one changes how a leaf is ticked."""
    function = getattr(cls, "update", None)
    return function in _CONSTANT or function in _MAKERS


def _constant(node: Any, status: Status, message: str) -> Update:
    def update() -> Status:
        node.feedback_message = message
        return status

    return update
