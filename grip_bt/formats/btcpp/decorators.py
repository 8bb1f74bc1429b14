"""BT.CPP's own decorators, actions and conditions as nodes of a task, and the attributes that any node may have."""

from __future__ import annotations

from typing import Any

from grip_bt.formats.btcpp.drafts import key_of

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
from .element import ElementReader
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


def _inverter(here: ElementReader) -> NodeDraft:
    return decorator("invert", here.only(), here.meaning)


def _forced(outcome: str) -> Reader:
    def read(here: ElementReader) -> NodeDraft:
        return decorator("force", here.only(), here.meaning, **{"as": outcome})

    return read


def _unskipped(here: ElementReader) -> NodeDraft:
    """Return the child of a decorator that remembers something beyond its end, which can't be skipped."""
    child = here.only()
    if child.skips:
        below = here.element.children[0]
        kept = "clock" if here.element.tag == "Timeout" else "count"
        here.reading.refuse(
            below,
            f"may be skipped inside of <{here.element.tag}>, whose {kept} BT.CPP then keeps for the next time",
        )
    return child


def _repeat(here: ElementReader) -> NodeDraft:
    times = here.number("num_cycles")
    child = _unskipped(here)
    if times == 0 or times < -1:
        here.refuse(f"`num_cycles` is {times}; write 1 or more, or -1 for ever")
    return decorator("repeat", child, here.meaning, **({} if times == -1 else {"times": times}))


def _retry(here: ElementReader) -> NodeDraft:
    times = here.number("num_attempts")
    child = _unskipped(here)
    if times == 0 or times < -1:
        here.refuse(f"`num_attempts` is {times}; write 1 or more, or -1 for ever")
    if times > 0:
        return decorator("retry", child, here.meaning, times=times)
    failing = decorator("invert", child, here.meaning)
    failing.name = "fails"
    again = decorator("repeat", failing, here.meaning)
    again.name = "until it succeeds"
    return decorator("invert", again, here.meaning)


def _keep_running(here: ElementReader) -> NodeDraft:
    return decorator("repeat", _unskipped(here), here.meaning)


def _timeout(here: ElementReader) -> NodeDraft:
    seconds = here.seconds("msec")
    child = _unskipped(here) if seconds else here.only()
    made = decorator("timeout", child, here.meaning, seconds=seconds) if seconds else child
    made.instant = False
    return made


def _delay(here: ElementReader) -> NodeDraft:
    seconds = here.seconds("delay_msec")
    child = here.only()
    wait = NodeDraft({"node": "flow/wait", "with": {"seconds": seconds}}, name="wait")
    up = SkipHandling.of(here.meaning, {"do": child})
    return container("sequence", {"wait": wait, "do": child}, up)


def _precondition(here: ElementReader) -> NodeDraft:
    child = here.only()
    condition = here.exact(lambda: here.scripts.condition(here.literal("if")))
    other = here.exact(lambda: end(here.literal("else", "FAILURE")))
    return switch(condition, {"do": True}, {"do": child, "else": other}, here.meaning, default="else")


def _run_once(here: ElementReader) -> NodeDraft:
    child = here.only()
    skips = here.exact(lambda: value_of_text(here.literal("then_skip", "true"), "bool"))
    ran = here.variable(f"{child.name}_ran", "str", "")
    failed = NodeDraft(
        {"kind": "force", "as": "failure", "child": {"note": set_variable(ran, "failure").keys}}, instant=True
    )
    well = container(
        "sequence",
        {"do": child, "note": set_variable(ran, "success")},
        SkipHandling.of(here.meaning, {"do": child}),
    )
    up = SkipHandling.of(here.meaning, {"do": well})
    first = container("fallback", {"do": well, "failed": failed}, up)
    if skips:
        return switch(ran, {"first": ""}, {"first": first, "skip": skip()}, here.meaning, default="skip")
    ways = {"first": first, "succeeded": end("SUCCESS"), "had failed": end("FAILURE")}
    return switch(ran, {"first": "", "succeeded": "success"}, ways, here.meaning, default="had failed")


def _loop(type_name: str) -> Reader:
    def read(here: ElementReader) -> NodeDraft:
        child = _unskipped(here)
        text = here.attributes.get("queue", "")
        if key_of(text, "queue") is not None:
            here.refuse(
                f"the queue {text} is consumed on the blackboard item by item; write it as a literal, or"
                " use `for_each` over a list",
            )
        key = key_of(here.attributes.get("value", "{=}"), "value")
        if key is None:
            here.refuse("`value` has to be a key in braces")
        items = here.exact(lambda: [value_of_text(part, type_name) for part in text.split(";")] if text else [])
        empty = here.exact(lambda: end(here.literal("if_empty", "SUCCESS")))
        queue = here.variable(f"{here.attributes.get('name', 'loop')}_queue", f"list[{type_name}]", items)
        item = here.board.variables.new(f"{key}_item")
        target = here.board.variable(key)
        here.board.variables.every[target].written.append(type_name)
        take = {"node": "flow/compute", "with": {"expression": "a"}, "in": {"a": item}, "out": {"value": target}}
        each = container("sequence", {"take": NodeDraft(take, instant=True), "do": child})
        keys = {"kind": "for_each", "items": queue, "item": item, "child": {"each": each.keys}}
        del here.board.variables.every[item]
        if empty.keys == SUCCEED:
            return NodeDraft(keys)
        up = SkipHandling.of(here.meaning, {"empty": empty})
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


def check_attributes(here: ElementReader) -> None:
    """Refuse attributes that have no equivalent."""
    for name in here.attributes:
        if name == "_onHalted":
            here.refuse(
                "`_onHalted` runs a script when the node is halted; nothing of a task does: use a leaf of your own",
            )
        if name.startswith("_") and name not in (*_CONDITIONS, *_SCRIPTS, *_NO_MATTER):
            here.note("left-out", f"the attribute `{name}`, which BT.CPP gives no meaning, was left out")


def with_conditions(here: ElementReader, node: NodeDraft) -> NodeDraft:
    """Return a node with its conditions before and its scripts after it.

    BT.CPP looks at `_failureIf`, `_successIf`, `_skipIf` and `_while` in this order when the node begins, and at
    `_while` on every tick; the scripts also run when a condition has decided.
    """
    said = here.attributes
    made = here.exact(lambda: _with_conditions(here, node))
    made.name = node.name
    if said.get("_description"):
        made.keys = {**made.keys, "doc": said["_description"]}
    return made


def _with_conditions(here: ElementReader, node: NodeDraft) -> NodeDraft:
    said, scripts = here.attributes, here.scripts
    made = node
    for name in reversed(_CONDITIONS):
        if name in said:
            made = _condition_before(name, said[name], scripts, made, here.meaning)
    always = said.get("_post", "")
    well = [each for text in (said.get("_onSuccess", ""), always) for each in scripts.assignments(text)]
    badly = [each for text in (said.get("_onFailure", ""), always) for each in scripts.assignments(text)]
    return after(made, well, badly, here.meaning)


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
    return lambda here: NodeDraft(dict(keys), instant=True)


def _sleep(here: ElementReader) -> NodeDraft:
    return NodeDraft({"node": "flow/wait", "with": {"seconds": here.seconds("msec")}})


def _script(here: ElementReader) -> NodeDraft:
    made = here.exact(lambda: here.scripts.assignments(here.literal("code")))
    return NodeDraft(sequence_of(made, "script").keys if made else dict(SUCCEED), instant=True)


def _script_condition(here: ElementReader) -> NodeDraft:
    condition = here.exact(lambda: here.scripts.condition(here.literal("code")))
    return NodeDraft({**SUCCEED, "precondition": condition}, instant=True)


def _set_blackboard(here: ElementReader) -> NodeDraft:
    out = here.attributes.get("output_key", "")
    key = key_of(out, "output_key") or out
    if not key:
        here.refuse("needs `output_key`")
    variable = here.board.variable(key)
    entry = here.board.variables.every[variable]
    text = here.attributes.get("value", "")
    source = key_of(text, "value")
    if source is None:
        entry.texts = True
        kind = entry.type if entry.type in ("int", "float", "bool") else "str"
        return set_variable(variable, here.exact(lambda: value_of_text(text, kind)))
    other = here.board.variable(source)
    entry.written.append(here.board.variables.every[other].type)
    here.board.variables.every[other].read.append("Any")
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
"""Tag -> why it has no equivalent, and what to do."""
