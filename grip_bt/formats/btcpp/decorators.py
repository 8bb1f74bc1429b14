"""BT.CPP's own decorators, actions and conditions as nodes of a task, and the attributes that any node may have."""

from __future__ import annotations

from typing import Any

from grip_bt.formats.xml_trees import Element

from .blackboard import key_of
from .controls import Reader
from .drafts import (
    FAIL,
    SUCCEED,
    NodeDraft,
    SkipHandling,
    container,
    decorator,
    sequence_of,
    set_variable,
    skip,
    switch,
)
from .element import ReadContext, Reading
from .expressions import Scripts, after
from .leaves import value_of_text

_ENDS = {"SUCCESS": "success", "FAILURE": "failure", "SKIPPED": "skipped"}


def end(status: str) -> NodeDraft:
    """Return a node that ends at once with a status of BT.CPP.

    Raises:
        ValueError: it isn't one that a node may end with.
    """
    if status not in _ENDS:
        raise ValueError(f"the status {status!r} isn't SUCCESS, FAILURE or SKIPPED")
    if status == "SKIPPED":
        return skip()
    return NodeDraft(dict(SUCCEED if status == "SUCCESS" else FAIL), instant=True)


def _inverter(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    return decorator("invert", reading.only(element, where), where.meaning)


def _forced(outcome: str) -> Reader:
    def read(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
        return decorator("force", reading.only(element, where), where.meaning, **{"as": outcome})

    return read


def _unskipped(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    """Return the child of a decorator that remembers something beyond its end, which can't be skipped."""
    child = reading.only(element, where)
    if child.skips:
        below = element.children[0]
        kept = "clock" if element.tag == "Timeout" else "count"
        reading.refuse(
            below, f"may be skipped inside of <{element.tag}>, whose {kept} BT.CPP then keeps for the next time"
        )
    return child


def _repeat(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    times = reading.number(element, where, "num_cycles")
    child = _unskipped(reading, element, where)
    if times == 0 or times < -1:
        reading.refuse(element, f"`num_cycles` is {times}; write 1 or more, or -1 for ever")
    return decorator("repeat", child, where.meaning, **({} if times == -1 else {"times": times}))


def _retry(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    times = reading.number(element, where, "num_attempts")
    child = _unskipped(reading, element, where)
    if times == 0 or times < -1:
        reading.refuse(element, f"`num_attempts` is {times}; write 1 or more, or -1 for ever")
    if times > 0:
        return decorator("retry", child, where.meaning, times=times)
    failing = decorator("invert", child, where.meaning)
    failing.name = "fails"
    again = decorator("repeat", failing, where.meaning)
    again.name = "until it succeeds"
    return decorator("invert", again, where.meaning)


def _keep_running(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    return decorator("repeat", _unskipped(reading, element, where), where.meaning)


def _timeout(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    seconds = reading.seconds(element, where, "msec")
    child = _unskipped(reading, element, where) if seconds else reading.only(element, where)
    made = decorator("timeout", child, where.meaning, seconds=seconds) if seconds else child
    made.instant = False
    return made


def _delay(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    seconds = reading.seconds(element, where, "delay_msec")
    child = reading.only(element, where)
    wait = NodeDraft({"node": "flow/wait", "with": {"seconds": seconds}}, name="wait")
    up = SkipHandling.of(where.meaning, {"do": child})
    return container("sequence", {"wait": wait, "do": child}, up)


def _precondition(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    child = reading.only(element, where)
    with reading.refusing(element):
        condition = reading.scripts(element, where).condition(reading.said(element, where, "if"))
        other = end(reading.said(element, where, "else", "FAILURE"))
    return switch(condition, {"do": True}, {"do": child, "else": other}, where.meaning, default="else")


def _run_once(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    child = reading.only(element, where)
    with reading.refusing(element):
        skips = value_of_text(reading.said(element, where, "then_skip", "true"), "bool")
    ran = reading.variable(f"{child.name}_ran", where, "str", "")
    failed = NodeDraft(
        {"kind": "force", "as": "failure", "child": {"note": set_variable(ran, "failure").keys}}, instant=True
    )
    well = container(
        "sequence",
        {"do": child, "note": set_variable(ran, "success")},
        SkipHandling.of(where.meaning, {"do": child}),
    )
    up = SkipHandling.of(where.meaning, {"do": well})
    first = container("fallback", {"do": well, "failed": failed}, up)
    if skips:
        return switch(ran, {"first": ""}, {"first": first, "skip": skip()}, where.meaning, default="skip")
    ways = {"first": first, "succeeded": end("SUCCESS"), "had failed": end("FAILURE")}
    return switch(ran, {"first": "", "succeeded": "success"}, ways, where.meaning, default="had failed")


def _loop(type_name: str) -> Reader:
    def read(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
        child = _unskipped(reading, element, where)
        text = element.attributes.get("queue", "")
        if key_of(text, "queue") is not None:
            reading.refuse(
                element,
                f"the queue {text} is taken apart on the blackboard, item by item; write it as a literal, or use"
                " `for_each` over a list",
            )
        key = key_of(element.attributes.get("value", "{=}"), "value")
        if key is None:
            reading.refuse(element, "`value` has to be a key in braces")
        with reading.refusing(element):
            items = [value_of_text(part, type_name) for part in text.split(";")] if text else []
            empty = end(reading.said(element, where, "if_empty", "SUCCESS"))
        queue = reading.variable(f"{element.attributes.get('name', 'loop')}_queue", where, f"list[{type_name}]", items)
        item = where.board.variables.new(f"{key}_item")
        target = where.board.variable(key)
        where.board.variables.every[target].written.append(type_name)
        take = {"node": "flow/compute", "with": {"expression": "a"}, "in": {"a": item}, "out": {"value": target}}
        each = container("sequence", {"take": NodeDraft(take, instant=True), "do": child})
        keys = {"kind": "for_each", "items": queue, "item": item, "child": {"each": each.keys}}
        del where.board.variables.every[item]
        if empty.keys == SUCCEED:
            return NodeDraft(keys)
        up = SkipHandling.of(where.meaning, {"empty": empty})
        return container("sequence", {"loop": NodeDraft(keys), "empty": empty}, up)

    return read


DECORATORS: dict[str, tuple[Reader, tuple[str, ...]]] = {
    "Inverter": (_inverter, ()),
    "ForceSuccess": (_forced("success"), ()),
    "ForceFailure": (_forced("failure"), ()),
    "Repeat": (_repeat, ("num_cycles",)),
    "RetryUntilSuccessful": (_retry, ("num_attempts",)),
    "KeepRunningUntilFailure": (_keep_running, ()),
    "Timeout": (_timeout, ("msec",)),
    "Delay": (_delay, ("delay_msec",)),
    "Precondition": (_precondition, ("if", "else")),
    "RunOnce": (_run_once, ("then_skip",)),
    "LoopInt": (_loop("int"), ("queue", "value", "if_empty")),
    "LoopBool": (_loop("bool"), ("queue", "value", "if_empty")),
    "LoopDouble": (_loop("float"), ("queue", "value", "if_empty")),
    "LoopString": (_loop("str"), ("queue", "value", "if_empty")),
}
"""Tag -> its reader and its ports."""


_CONDITIONS = ("_failureIf", "_successIf", "_skipIf", "_while")
_SCRIPTS = ("_onSuccess", "_onFailure", "_post")
_NO_MATTER = ("_uid", "_fullpath", "_autoremap", "_description")
"""Groot's own notes, and what sub-trees read."""


def check_attributes(reading: Reading, element: Element) -> None:
    """Refuse attributes that have no equal."""
    for name in element.attributes:
        if name == "_onHalted":
            reading.refuse(
                element,
                "`_onHalted` runs a script when the node is halted; nothing of a task does: use a leaf of your own",
            )
        if name.startswith("_") and name not in (*_CONDITIONS, *_SCRIPTS, *_NO_MATTER):
            reading.note("left-out", element, f"the attribute `{name}`, which BT.CPP gives no meaning, was left out")


def with_conditions(reading: Reading, element: Element, node: NodeDraft, where: ReadContext) -> NodeDraft:
    """Return a node with its conditions before and its scripts after it.

    BT.CPP looks at `_failureIf`, `_successIf`, `_skipIf` and `_while` in this order when the node begins, and at
    `_while` on every tick; the scripts also run when a condition has decided.
    """
    said = element.attributes
    made = node
    with reading.refusing(element):
        scripts = reading.scripts(element, where)
        for name in reversed(_CONDITIONS):
            if name in said:
                made = _condition_before(name, said[name], scripts, made, where.meaning)
        always = said.get("_post", "")
        well = [each for text in (said.get("_onSuccess", ""), always) for each in scripts.assignments(text)]
        badly = [each for text in (said.get("_onFailure", ""), always) for each in scripts.assignments(text)]
        made = after(made, well, badly, where.meaning)
    made.name = node.name
    if said.get("_description"):
        made.keys = {**made.keys, "doc": said["_description"]}
    return made


def _condition_before(name: str, text: str, scripts: Scripts, node: NodeDraft, meaning: str) -> NodeDraft:
    if name == "_failureIf" and "precondition" not in node.keys:
        holds = scripts.condition(f"!({text})")
        return NodeDraft({**node.keys, "precondition": holds}, node.skips, node.name, node.instant)
    condition = scripts.condition(text)
    if name == "_failureIf":
        return switch(condition, {"fails": True}, {"fails": end("FAILURE"), "do": node}, meaning, default="do")
    if name == "_successIf":
        return switch(condition, {"succeeds": True}, {"succeeds": end("SUCCESS"), "do": node}, meaning, default="do")
    if name == "_skipIf":
        return switch(condition, {"skip": True}, {"skip": skip(), "do": node}, meaning, default="do")
    return switch(condition, {"do": True}, {"do": node, "skip": skip()}, meaning, default="skip", memory=False)


def _end(keys: dict[str, Any]) -> Reader:
    return lambda reading, element, where: NodeDraft(dict(keys), instant=True)


def _sleep(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    return NodeDraft({"node": "flow/wait", "with": {"seconds": reading.seconds(element, where, "msec")}})


def _script(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    with reading.refusing(element):
        made = reading.scripts(element, where).assignments(reading.said(element, where, "code"))
        if not made:
            return NodeDraft(dict(SUCCEED), instant=True)
        script = sequence_of(made, "script")
        return NodeDraft(script.keys, instant=True)
    raise AssertionError("a refusal raises")


def _script_condition(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    with reading.refusing(element):
        condition = reading.scripts(element, where).condition(reading.said(element, where, "code"))
        return NodeDraft({**SUCCEED, "precondition": condition}, instant=True)
    raise AssertionError("a refusal raises")


def _set_blackboard(reading: Reading, element: Element, where: ReadContext) -> NodeDraft:
    out = element.attributes.get("output_key", "")
    key = key_of(out, "output_key") or out
    if not key:
        reading.refuse(element, "needs `output_key`")
    variable = where.board.variable(key)
    entry = where.board.variables.every[variable]
    text = element.attributes.get("value", "")
    source = key_of(text, "value")
    if source is None:
        entry.texts = True
        kind = entry.type if entry.type in ("int", "float", "bool") else "str"
        with reading.refusing(element):
            return set_variable(variable, value_of_text(text, kind))
    other = where.board.variable(source)
    entry.written.append(where.board.variables.every[other].type)
    where.board.variables.every[other].read.append("Any")
    keys = {"node": "flow/compute", "with": {"expression": "a"}, "in": {"a": other}, "out": {"value": variable}}
    return NodeDraft(keys, instant=True)


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
    "ManualSelector": "asks the user at a terminal which child to tick; use a `switch` over a variable",
    "UnsetBlackboard": "takes a variable away; give it a value that means nothing",
    "SkipUnlessUpdated": _COUNTS,
    "WaitValueUpdate": _COUNTS,
    "EntryUpdated": _COUNTS,
    "WasEntryUpdated": _COUNTS,
    "WaitEntryUpdated": _COUNTS,
    "SkipUnlessEntryUpdated": _COUNTS,
    "ConsumeQueue": "consumes a queue on the blackboard; use `for_each` over a list",
    "PopFromQueue": "consumes a queue on the blackboard; use `for_each` over a list",
    "QueueSize": "asks for the length of a queue on the blackboard; use `len(...)` of a list",
    "TestNode": "is BT.CPP's stand-in for tests",
    "AlwaysRunning": "never ends",
    "BlackboardCheckInt": "belongs to BehaviorTree.CPP 3; write `_skipIf` or <Precondition>",
    "BlackboardCheckDouble": "belongs to BehaviorTree.CPP 3; write `_skipIf` or <Precondition>",
    "BlackboardCheckString": "belongs to BehaviorTree.CPP 3; write `_skipIf` or <Precondition>",
    "BlackboardCheckBool": "belongs to BehaviorTree.CPP 3; write `_skipIf` or <Precondition>",
    "SequenceStar": "belongs to BehaviorTree.CPP 3; use <SequenceWithMemory>",
    "RetryUntilSuccesful": "belongs to BehaviorTree.CPP 3; use <RetryUntilSuccessful>",
    "SubTreePlus": 'belongs to BehaviorTree.CPP 3; use <SubTree _autoremap="true">',
}
"""Tag -> why it has no equal, and what to do."""
