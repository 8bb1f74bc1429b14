"""BT.CPP's own decorators, actions and conditions as nodes of a task, and the attributes that any node may have."""

from __future__ import annotations

from grip_bt.formats.blackboard import key_of, value_of_text

from .controls import Reader, by_its_rules
from .drafts import FAIL, SUCCEED, NodeDraft, container, decorator, failing, sequence_of, set_variable, skip, switch
from .reading import ElementReader
from .scripts import Scripts, after

_ENDS = {"SUCCESS": "success", "FAILURE": "failure", "SKIPPED": "skipped"}


def end(status: str) -> NodeDraft:
    """Return a node that ends at once with a status of BT.CPP. Raises ValueError: no node ends with it."""
    if status not in _ENDS:
        raise ValueError(f"the status {status!r} isn't SUCCESS, FAILURE or SKIPPED")
    if status == "SKIPPED":
        return skip()
    return NodeDraft(dict(SUCCEED if status == "SUCCESS" else FAIL), instant=True)


def _scripts(here: ElementReader) -> Scripts:
    return Scripts(here.board, lambda text: here.note("changed", text))


def _around(kind: str, **settings: str) -> Reader:
    return lambda here: decorator(kind, here.only(), here.meaning, **settings)


def _unskipped(here: ElementReader) -> NodeDraft:
    """Return the child of a decorator that remembers something beyond its end, which can't be skipped."""
    child = here.only()
    if child.skips:
        kept = "clock" if here.element.tag == "Timeout" else "count"
        here.unequal(f"{here.element.children[0]} may be skipped, and its {kept} is kept for the next time then")
    return child


def _again(kind: str, port: str) -> Reader:
    def read(here: ElementReader) -> NodeDraft:
        child, times = _unskipped(here), here.number(port)
        if times == 0 or times < -1:
            here.refuse(f"`{port}` is {times}; write 1 or more, or -1 for ever")
        return decorator(kind, child, here.meaning, **({} if times == -1 else {"times": times}))

    return read


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
    return container("sequence", {"wait": wait, "do": child}, here.meaning)


def _precondition(here: ElementReader) -> NodeDraft:
    child = here.only()
    asked = here.exact(lambda: _scripts(here).condition(here.literal("if")))
    if here.literal("else", "FAILURE") == "RUNNING":
        wait = asked.before(NodeDraft({**SUCCEED, "precondition": asked.text}, instant=True), "success")
        until = decorator("retry", NodeDraft(wait.keys, name="until it holds"), "")
        return container("sequence", {"wait": until, "do": child}, here.meaning)
    other = here.exact(lambda: end(here.literal("else", "FAILURE")))
    made = switch(asked.text, {"do": True}, {"do": child, "else": other}, here.meaning, default="else")
    return asked.before(made, here.meaning)


def _run_once(here: ElementReader) -> NodeDraft:
    child = here.only()
    skips = here.exact(lambda: value_of_text(here.literal("then_skip", "true"), "bool"))
    ran = here.variable(f"{child.name}_ran", "str", "")
    well = container("sequence", {"do": child, "note": set_variable(ran, "success")}, here.meaning)
    failed = failing("note", set_variable(ran, "failure"))
    first = container("fallback", {"do": well, "failed": failed}, here.meaning)
    if skips:
        return switch(ran, {"first": ""}, {"first": first, "skip": skip()}, here.meaning, default="skip")
    ways = {"first": first, "succeeded": end("SUCCESS"), "had failed": end("FAILURE")}
    return switch(ran, {"first": "", "succeeded": "success"}, ways, here.meaning, default="had failed")


def _loop(type_name: str) -> Reader:
    def read(here: ElementReader) -> NodeDraft:
        text = here.literal("queue", "")
        if key_of(here.attributes.get("value", "{=}"), "value") is None:
            here.refuse("`value` has to be a key in braces")
        here.exact(lambda: [value_of_text(part, type_name) for part in text.split(";")] if text else [])
        here.exact(lambda: end(here.literal("if_empty", "SUCCESS")))
        here.unequal("")

    return read


DECORATORS: dict[str, tuple[Reader, tuple[str, ...]]] = {
    **dict.fromkeys(("SkipUnlessUpdated", "WaitValueUpdate"), (by_its_rules(1, 1), ("entry",))),
    "Inverter": (_around("invert"), ()),
    "ForceSuccess": (_around("force", **{"as": "success"}), ()),
    "ForceFailure": (_around("force", **{"as": "failure"}), ()),
    "Repeat": (_again("repeat", "num_cycles"), ("num_cycles",)),
    "RetryUntilSuccessful": (_again("retry", "num_attempts"), ("num_attempts",)),
    "KeepRunningUntilFailure": (lambda here: decorator("repeat", _unskipped(here), here.meaning), ()),
    "Timeout": (_timeout, ("msec",)),
    "Delay": (_delay, ("delay_msec",)),
    "Precondition": (_precondition, ("if", "else")),
    "RunOnce": (_run_once, ("then_skip",)),
    **{
        f"Loop{word}": (_loop(type_name), ("queue", "value", "if_empty"))
        for word, type_name in (("Int", "int"), ("Bool", "bool"), ("Double", "float"), ("String", "str"))
    },
}
"""Tag -> its reader and its ports."""


_DECIDED = {"_failureIf": ("fails", "FAILURE"), "_successIf": ("succeeds", "SUCCESS"), "_skipIf": ("skip", "SKIPPED")}
_CONDITIONS = (*_DECIDED, "_while")
_SCRIPTS = ("_onSuccess", "_onFailure", "_post", "_onHalted")
_NO_MATTER = (
    *("_uid", "_fullpath", "_autoremap", "_description"),
    *("_collapsed", "_favorite", "_subtreeOnly", "_hardcoded"),
)
"""Editors' own notes, and what sub-trees read."""


def check_attributes(here: ElementReader) -> None:
    """Name the attributes that have no meaning."""
    for name in here.attributes:
        if name.startswith("_") and name not in (*_CONDITIONS, *_SCRIPTS, *_NO_MATTER):
            here.note("left-out", f"the attribute `{name}`, which BT.CPP gives no meaning, was left out")


def with_conditions(here: ElementReader, node: NodeDraft) -> NodeDraft:
    """Return a node with its conditions before and its scripts after it.

    BT.CPP looks at `_failureIf`, `_successIf`, `_skipIf` and `_while` in this order when the node begins, and at
    `_while` on every tick; the scripts also run when a condition has decided.
    """
    said, scripts = here.attributes, _scripts(here)

    def read() -> NodeDraft:
        made = node
        if "_onHalted" in said:
            made = scripts.on_halted(said["_onHalted"], made, here.meaning)
        for name in reversed(_CONDITIONS):
            if name in said:
                made = _condition_before(name, said[name], scripts, made, here.meaning)
        well, badly = (
            [each for attribute in (own, "_post") for each in scripts.assignments(said.get(attribute, ""))]
            for own in ("_onSuccess", "_onFailure")
        )
        return after(made, well, badly, here.meaning)

    made = here.exact(read)
    made.name = node.name
    if said.get("_description"):
        made.keys = {**made.keys, "doc": said["_description"]}
    return made


def _condition_before(name: str, text: str, scripts: Scripts, node: NodeDraft, meaning: str) -> NodeDraft:
    asked = scripts.condition(text, negated=name == "_failureIf" and "precondition" not in node.keys)
    if asked.negated:
        made = NodeDraft({**node.keys, "precondition": asked.text}, node.skips, node.name, node.instant)
    elif name == "_while":
        ways = {"do": node, "skip": skip()}
        made = switch(asked.text, {"do": True}, ways, meaning, default="skip", memory=False)
        return asked.before(made, meaning, memory=False)
    else:
        way, status = _DECIDED[name]
        made = switch(asked.text, {way: True}, {way: end(status), "do": node}, meaning, default="do")
    return asked.before(made, meaning)


def _script(here: ElementReader) -> NodeDraft:
    made = here.exact(lambda: _scripts(here).assignments(here.literal("code")))
    return NodeDraft(sequence_of(made, "script").keys if made else dict(SUCCEED), instant=True)


def _script_condition(here: ElementReader) -> NodeDraft:
    asked = here.exact(lambda: _scripts(here).condition(here.literal("code")))
    return asked.before(NodeDraft({**SUCCEED, "precondition": asked.text}, instant=True), here.meaning)


def _unset(here: ElementReader) -> NodeDraft:
    text = here.attributes.get("key", "")
    variable = here.board.variable(key_of(text, "key") or text)
    here.board.variables.every[variable].written.append("Any")
    here.note("changed", f"{variable!r} is null from then on; where it is read, BT.CPP ends with an error")
    return set_variable(variable, None)


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
    "AlwaysSuccess": (lambda here: end("SUCCESS"), ()),
    "AlwaysFailure": (lambda here: end("FAILURE"), ()),
    "Sleep": (lambda here: NodeDraft({"node": "flow/wait", "with": {"seconds": here.seconds("msec")}}), ("msec",)),
    "Script": (_script, ("code",)),
    "ScriptCondition": (_script_condition, ("code",)),
    "SetBlackboard": (_set_blackboard, ("value", "output_key")),
    "UnsetBlackboard": (_unset, ("key",)),
}
"""Tag -> its reader and its ports."""

REFUSED = {
    **dict.fromkeys(
        ("BlackboardCheckInt", "BlackboardCheckDouble", "BlackboardCheckString", "BlackboardCheckBool"),
        "belongs to BehaviorTree.CPP 3; write `_skipIf` or <Precondition>",
    ),
    "RetryUntilSuccesful": "belongs to BehaviorTree.CPP 3; use <RetryUntilSuccessful>",
    "SubTreePlus": 'belongs to BehaviorTree.CPP 3; use <SubTree _autoremap="true">',
}
"""Tag -> why it has no equivalent, and what to do."""
