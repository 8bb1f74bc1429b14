"""What py_trees' own leaves do in `update`, with the key of the blackboard bound when the leaf is compiled.

Whatever isn't the usual case (a variable that isn't there, no right to read it, an activity stream, an attribute of the
leaf that was replaced since) is done by the leaf's own `update`.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import partial, reduce
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

    def readable(self) -> bool:
        """Tell whether `read` fails only where the variable isn't there."""
        return self.usual and Blackboard.activity_stream is None and self.name in self.rights

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


def compare_two(node: Any) -> Update:
    """`CompareBlackboardVariables.update`."""
    own, first, second, client = node.update, node.var1_key, node.var2_key, node.blackboard
    read_first, read_second = Bound(node, first).read, Bound(node, second).read

    def update() -> Status:
        if node.var1_key is not first or node.var2_key is not second or node.blackboard is not client:
            return own()
        try:
            left, right = read_first(), read_second()
        except KeyError:
            return own()
        holds = bool(node.operator(left, right))
        ends = "succeeded" if holds else "failed"
        node.feedback_message = f"'{first}, {second}' comparison {ends} [v1: {left}][v2: {right}]"
        return S if holds else F

    return update


def compare_all(node: Any) -> Update:
    """`CheckBlackboardVariableValues.update`."""
    own, client = node.update, node.blackboard
    known = [(check, check.variable, Bound(node, Blackboard.key(check.variable))) for check in node.checks]
    inner = [_inside(check.variable) for check in node.checks]

    def usual() -> bool:
        if node.blackboard is not client or len(node.checks) != len(known):
            return False
        for check, (was, variable, bound) in zip(node.checks, known, strict=True):
            if check is not was or check.variable is not variable or not bound.readable():
                return False
        return True

    def update() -> Status:
        if not usual():
            return own()
        results = []
        for (check, variable, bound), inside in zip(known, inner, strict=True):
            try:
                value = bound.read() if inside is None else inside(bound.read())
            except (KeyError, AttributeError):
                node.feedback_message = f"variable '{variable}' does not yet exist on the blackboard"
                return F
            results.append(check.operator(value, check.value_generator()))
        if node.blackboard_results is not None:
            for number, result in enumerate(results, 1):
                node.blackboard_results.set(str(number), result)
        holds = bool(reduce(node.operator, results))
        node.feedback_message = f"[{'|'.join(['T' if result else 'F' for result in results])}]"
        return S if holds else F

    return update


def _inside(variable: str) -> Callable[[Any], Any] | None:
    """Return what gets the nested attribute that a name asks for; None where it asks for none."""
    attributes = variable.partition(".")[2]
    return attrgetter(attributes) if attributes else None


def exists(node: Any) -> Update:
    """`CheckBlackboardVariableExists.update`."""
    variable = node.variable_name
    return _found(node, f"variable '{variable}' found", F, f"variable '{variable}' not found")


def exists_waiting(node: Any) -> Update:
    """`WaitForBlackboardVariable.update`."""
    return _found(node, f"'{node.key}' found", R, f"waiting for key '{node.key}'...")


def _found(node: Any, message: str, otherwise: Status, lacking: str) -> Update:
    own, variable, key, client = node.update, node.variable_name, node.key, node.blackboard
    read, inside = Bound(node, Blackboard.key(variable)).read, _inside(variable)

    def update() -> Status:
        if node.variable_name is not variable or node.key is not key or node.blackboard is not client:
            return own()
        try:
            value = read()
        except KeyError:
            return own()
        if inside is not None:
            try:
                inside(value)
            except (AttributeError, KeyError):
                node.feedback_message = lacking
                return otherwise
        node.feedback_message = message
        return S

    return update


def status_of(node: Any) -> Update:
    """`BlackboardToStatus.update`."""
    own, variable, client = node.update, node.variable_name, node.blackboard
    read, inside = Bound(node, Blackboard.key(variable)).read, _inside(variable)
    messages = {status: f"{variable}: {status}" for status in Status}

    def update() -> Status:
        if node.variable_name is not variable or node.blackboard is not client:
            return own()
        try:
            status = read()
        except KeyError:
            return own()
        if inside is not None:  # looked at once, as the leaf does: it may be a property
            try:
                status = inside(status)
            except AttributeError as error:
                raise KeyError(f"Key exists, but does not have the specified nested attributes [{variable}]") from error
        if not isinstance(status, Status):
            raise TypeError(f"{variable} is not of type py_trees.common.Status")
        node.feedback_message = messages[status]
        return status

    return update


def set_value(node: Any) -> Update:
    """`SetBlackboardVariable.update`."""
    own, variable, client = node.update, node.variable_name, node.blackboard
    name, _, attribute = Blackboard.absolute_name(client.namespace, variable).partition(".")
    writable, places = client.write, client.remappings

    def usual() -> bool:
        return (
            node.variable_name is variable
            and node.blackboard is client
            and Blackboard.activity_stream is None
            and name in writable
            and bool(node.overwrite)
        )

    def update() -> Status:
        if not usual():
            return own()
        place = places[name]
        Blackboard.storage[place] = node.variable_value_generator()
        return S

    def update_inside() -> Status:
        if not usual() or places[name] not in Blackboard.storage:
            return own()
        value = node.variable_value_generator()
        try:
            setattr(getattr(client, name), attribute, value)
        except AttributeError:  # it has no such attribute
            return F
        return S

    return update_inside if attribute else update


def unset(node: Any) -> Update:
    """`UnsetBlackboardVariable.update`."""
    own, key, client = node.update, node.key, node.blackboard
    name, places = Blackboard.absolute_name(client.namespace, key), client.remappings
    message = f"'{key}' found and removed"

    def update() -> Status:
        if (
            node.key is not key
            or node.blackboard is not client
            or Blackboard.activity_stream is not None
            or name not in places
        ):
            return own()
        place = places[name]
        if place in Blackboard.storage:
            del Blackboard.storage[place]
            node.feedback_message = message
        else:
            node.feedback_message = "'{}' not found, nothing to remove"  # theirs, which nobody fills in
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
