"""What py_trees' own leaves do in `update`, with the key of the blackboard bound when the leaf is compiled.

Whatever isn't the usual case (a variable that isn't there, no right to read it, an activity stream, an attribute of the
leaf that was replaced since) is done by the leaf's own `update`.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import partial
from operator import attrgetter
from typing import Any

from py_trees import behaviours
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Status

Update = Callable[[], Status]

S, F, R = Status.SUCCESS, Status.FAILURE, Status.RUNNING

_COMPARE = behaviours.CheckBlackboardVariableValue.update
_LACKING = "blackboard key-value pair exists, but the value does not have the requested nested attributes [{}]"
_SCALARS = frozenset({bool, int, float, str, type(None)})
"""Types whose values always have the same text."""


class Bound:
    """One key of a node's client, its place on the blackboard found out once.

    Args:
        node: whose client it is.
        key: the name of a variable, without attributes.
    """

    def __init__(self, node: Any, key: str):
        client = node.blackboard
        self.usual = not _is_attribute(client, key) and "." not in key
        self.name = Blackboard.absolute_name(client.namespace, key)
        self.rights = client.read
        self.places: dict[str, str] = client.remappings

    def read(self) -> Any:
        """Return what the client's `get` does for the bare key.

        Raises:
            KeyError: this isn't the usual case; ask the client.
        """
        if not self.usual or Blackboard.activity_stream is not None or self.name not in self.rights:
            raise KeyError(self.name)
        return Blackboard.storage[self.places[self.name]]


def _is_attribute(client: Client, key: str) -> bool:
    """Tell whether the client has an attribute of the variable's name, which its `get` returns instead."""
    try:
        object.__getattribute__(client, key)
    except AttributeError:
        return False
    return True


def compare(node: Any) -> Update:
    """`CheckBlackboardVariableValue.update`."""
    own, key, check, attributes = partial(_COMPARE, node), node.key, node.check, node.key_attributes
    variable, read, client = check.variable, Bound(node, key).read, node.blackboard
    inside = attrgetter(attributes) if attributes else None
    seen: tuple[Any, Any, Any] = (own, own, own)
    message = ""

    def update() -> Status:
        nonlocal seen, message
        if (
            node.check is not check
            or node.key is not key
            or node.key_attributes is not attributes
            or node.blackboard is not client
            or check.variable is not variable
        ):
            return own()
        try:
            value = read()
        except KeyError:
            return own()
        if inside is not None:
            try:
                value = inside(value)
            except AttributeError:
                node.feedback_message = _LACKING.format(key)
                return F
        expected = check.value_generator()
        result = check.operator(value, expected)
        holds = bool(result)
        if value is not seen[0] or expected is not seen[1] or holds is not seen[2]:
            ends = "succeeded" if holds else "failed"
            message = f"'{variable}' comparison {ends} [v: {value}][e: {expected}]"
            same = type(value) in _SCALARS and type(expected) in _SCALARS
            seen = (value, expected, holds) if same else (own, own, own)
        node.feedback_message = message
        return S if holds else F

    return update


def compare_waiting(node: Any) -> Update:
    """`WaitForBlackboardVariableValue.update`."""
    now = compare(node)

    def update() -> Status:
        status = now()
        return R if status is F else status

    return update


def exists(node: Any) -> Update:
    """`CheckBlackboardVariableExists.update`."""
    return _found(node, "variable '{}' found", node.update)


def exists_waiting(node: Any) -> Update:
    """`WaitForBlackboardVariable.update`."""
    return _found(node, "'{}' found", node.update, of_key=True)


def _found(node: Any, text: str, own: Update, of_key: bool = False) -> Update:
    variable, key, client = node.variable_name, node.key, node.blackboard
    read = Bound(node, variable.split(".")[0]).read
    attributes = ".".join(variable.split(".")[1:])
    message = text.format(key if of_key else variable)
    if attributes:
        return own

    def update() -> Status:
        if node.variable_name is not variable or node.key is not key or node.blackboard is not client:
            return own()
        try:
            read()
        except KeyError:
            return own()
        node.feedback_message = message
        return S

    return update


def status_of(node: Any) -> Update:
    """`BlackboardToStatus.update`."""
    own, variable, client = node.update, node.variable_name, node.blackboard
    read = Bound(node, variable).read
    messages = {status: f"{variable}: {status}" for status in Status}
    if "." in variable:
        return own  # type: ignore[no-any-return]

    def update() -> Status:
        if node.variable_name is not variable or node.blackboard is not client:
            return own()
        try:
            status = read()
        except KeyError:
            return own()
        if not isinstance(status, Status):
            return own()
        node.feedback_message = messages[status]
        return status

    return update


def set_value(node: Any) -> Update:
    """`SetBlackboardVariable.update`."""
    own, variable, client = node.update, node.variable_name, node.blackboard
    name = Blackboard.absolute_name(client.namespace, variable)
    writable, places = client.write, client.remappings
    if "." in variable:
        return own  # type: ignore[no-any-return]

    def update() -> Status:
        if (
            node.variable_name is not variable
            or node.blackboard is not client
            or Blackboard.activity_stream is not None
            or name not in writable
            or not node.overwrite
        ):
            return own()
        place = places[name]
        Blackboard.storage[place] = node.variable_value_generator()
        return S

    return update


def queue(node: Any) -> Update:
    """`StatusQueue.update`."""

    def update() -> Status:
        if not node.current_queue:
            if node.eventually is not None:
                return node.eventually
            node.current_queue = copy(node.queue)
        return node.current_queue.pop(0)

    return update


def every_n(node: Any) -> Update:
    """`SuccessEveryN.update`."""

    def update() -> Status:
        node.count += 1
        if node.count % node.every_n == 0:
            node.feedback_message = "now"
            return S
        node.feedback_message = "not yet"
        return F

    return update
