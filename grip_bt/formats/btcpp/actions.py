"""BT.CPP's own actions and conditions as leaves of a task."""

from __future__ import annotations

from typing import Any

from ..pytrees_xml.elements import Element
from .controls import Reader
from .leaves import value_of_text
from .making import FAIL, SUCCEED, Made, in_turn, set_to
from .names import key_of
from .reading import Reading, Where


def _end(keys: dict[str, Any]) -> Reader:
    return lambda reading, element, where: Made(dict(keys), instant=True)


def _sleep(reading: Reading, element: Element, where: Where) -> Made:
    return Made({"node": "flow/wait", "with": {"seconds": reading.seconds(element, where, "msec")}})


def _script(reading: Reading, element: Element, where: Where) -> Made:
    with reading.refusing(element, where):
        made = reading.scripts(element, where).assignments(reading.said(element, where, "code"))
        if not made:
            return Made(dict(SUCCEED), instant=True)
        script = in_turn(made, "script")
        return Made(script.keys, instant=True)
    raise AssertionError("a refusal raises")


def _script_condition(reading: Reading, element: Element, where: Where) -> Made:
    with reading.refusing(element, where):
        condition = reading.scripts(element, where).condition(reading.said(element, where, "code"))
        return Made({**SUCCEED, "precondition": condition}, instant=True)
    raise AssertionError("a refusal raises")


def _set_blackboard(reading: Reading, element: Element, where: Where) -> Made:
    out = element.attributes.get("output_key", "")
    key = key_of(out, "output_key") or out
    if not key:
        reading.refuse(element, where, "needs `output_key`")
    variable = where.board.variable(key)
    entry = where.board.variables.every[variable]
    text = element.attributes.get("value", "")
    source = key_of(text, "value")
    if source is None:
        entry.texts = True
        kind = entry.type if entry.type in ("int", "float", "bool") else "str"
        with reading.refusing(element, where):
            return set_to(variable, value_of_text(text, kind))
    other = where.board.variable(source)
    entry.written.append(where.board.variables.every[other].type)
    where.board.variables.every[other].read.append("Any")
    keys = {"node": "flow/compute", "with": {"expression": "a"}, "in": {"a": other}, "out": {"value": variable}}
    return Made(keys, instant=True)


ACTIONS: dict[str, tuple[Reader, tuple[str, ...]]] = {
    "AlwaysSuccess": (_end(SUCCEED), ()),
    "AlwaysFailure": (_end(FAIL), ()),
    "Sleep": (_sleep, ("msec",)),
    "Script": (_script, ("code",)),
    "ScriptCondition": (_script_condition, ("code",)),
    "SetBlackboard": (_set_blackboard, ("value", "output_key")),
}
"""Tag -> its reader and its ports."""

_COUNTS = "counts the writes of a blackboard entry; use a leaf of your own that remembers what it has seen"
REFUSED = {
    "ManualSelector": "asks a person at a terminal which child to tick; use a `switch` over a variable",
    "UnsetBlackboard": "takes a variable away; give it a value that means nothing",
    "SkipUnlessUpdated": _COUNTS,
    "WaitValueUpdate": _COUNTS,
    "EntryUpdated": _COUNTS,
    "WasEntryUpdated": _COUNTS,
    "WaitEntryUpdated": _COUNTS,
    "SkipUnlessEntryUpdated": _COUNTS,
    "ConsumeQueue": "takes a queue on the blackboard apart; use `for_each` over a list",
    "PopFromQueue": "takes a queue on the blackboard apart; use `for_each` over a list",
    "QueueSize": "asks for the length of a queue on the blackboard; use `len(...)` of a list",
    "TestNode": "is BT.CPP's stand-in for tests",
    "AlwaysRunning": "never ends",
    "BlackboardCheckInt": "is of BT.CPP 3; write `_skipIf` or <Precondition>",
    "BlackboardCheckDouble": "is of BT.CPP 3; write `_skipIf` or <Precondition>",
    "BlackboardCheckString": "is of BT.CPP 3; write `_skipIf` or <Precondition>",
    "BlackboardCheckBool": "is of BT.CPP 3; write `_skipIf` or <Precondition>",
    "SequenceStar": "is of BT.CPP 3; it is <SequenceWithMemory> in 4",
    "RetryUntilSuccesful": "is of BT.CPP 3; it is <RetryUntilSuccessful> in 4",
    "SubTreePlus": 'is of BT.CPP 3; it is <SubTree _autoremap="true"> in 4',
}
"""Tag -> why it has no equal, and what to do."""
