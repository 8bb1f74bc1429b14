"""Decorators of BT.CPP as containers of a task."""

from __future__ import annotations

from ..pytrees_xml.elements import Element
from .controls import Reader
from .leaves import value_of_text
from .making import FAIL, SUCCEED, Made, Skipping, around, container, set_to, skip, switch
from .names import key_of
from .reading import Reading, Where

_ENDS = {"SUCCESS": "success", "FAILURE": "failure", "SKIPPED": "skipped"}


def end(status: str) -> Made:
    """Return a node that ends at once with a status of BT.CPP.

    Raises:
        ValueError: it isn't one that a node may end with.
    """
    if status not in _ENDS:
        raise ValueError(f"the status {status!r} isn't SUCCESS, FAILURE or SKIPPED")
    if status == "SKIPPED":
        return skip()
    return Made(dict(SUCCEED if status == "SUCCESS" else FAIL), instant=True)


def _inverter(reading: Reading, element: Element, where: Where) -> Made:
    return around("invert", reading.only(element, where), where.meaning)


def _forced(outcome: str) -> Reader:
    def read(reading: Reading, element: Element, where: Where) -> Made:
        return around("force", reading.only(element, where), where.meaning, **{"as": outcome})

    return read


def _unskipped(reading: Reading, element: Element, where: Where) -> Made:
    """Return the child of a decorator that remembers something beyond its end, which can't be skipped."""
    child = reading.only(element, where)
    if child.skips:
        below = element.children[0]
        kept = "clock" if element.tag == "Timeout" else "count"
        reading.refuse(
            below, where, f"may be skipped inside of <{element.tag}>, whose {kept} BT.CPP then keeps for the next time"
        )
    return child


def _repeat(reading: Reading, element: Element, where: Where) -> Made:
    times = reading.number(element, where, "num_cycles")
    child = _unskipped(reading, element, where)
    if times == 0 or times < -1:
        reading.refuse(element, where, f"`num_cycles` is {times}; write 1 or more, or -1 for ever")
    return around("repeat", child, where.meaning, **({} if times == -1 else {"times": times}))


def _retry(reading: Reading, element: Element, where: Where) -> Made:
    times = reading.number(element, where, "num_attempts")
    child = _unskipped(reading, element, where)
    if times == 0 or times < -1:
        reading.refuse(element, where, f"`num_attempts` is {times}; write 1 or more, or -1 for ever")
    if times > 0:
        return around("retry", child, where.meaning, times=times)
    failing = around("invert", child, where.meaning)
    failing.name = "fails"
    again = around("repeat", failing, where.meaning)
    again.name = "until it succeeds"
    return around("invert", again, where.meaning)


def _keep_running(reading: Reading, element: Element, where: Where) -> Made:
    return around("repeat", _unskipped(reading, element, where), where.meaning)


def _timeout(reading: Reading, element: Element, where: Where) -> Made:
    seconds = reading.seconds(element, where, "msec")
    child = _unskipped(reading, element, where) if seconds else reading.only(element, where)
    made = around("timeout", child, where.meaning, seconds=seconds) if seconds else child
    made.instant = False
    return made


def _delay(reading: Reading, element: Element, where: Where) -> Made:
    seconds = reading.seconds(element, where, "delay_msec")
    child = reading.only(element, where)
    wait = Made({"node": "flow/wait", "with": {"seconds": seconds}}, name="wait")
    up = Skipping.of(where.meaning, {"do": child})
    return container("sequence", {"wait": wait, "do": child}, up)


def _precondition(reading: Reading, element: Element, where: Where) -> Made:
    child = reading.only(element, where)
    with reading.refusing(element, where):
        condition = reading.scripts(element, where).condition(reading.said(element, where, "if"))
        other = end(reading.said(element, where, "else", "FAILURE"))
    return switch(condition, {"do": True}, {"do": child, "else": other}, where.meaning, default="else")


def _run_once(reading: Reading, element: Element, where: Where) -> Made:
    child = reading.only(element, where)
    with reading.refusing(element, where):
        skips = value_of_text(reading.said(element, where, "then_skip", "true"), "bool")
    ran = reading.variable(f"{child.name}_ran", where, "str", "")
    failed = Made({"kind": "force", "as": "failure", "child": {"note": set_to(ran, "failure").keys}}, instant=True)
    well = container(
        "sequence",
        {"do": child, "note": set_to(ran, "success")},
        Skipping.of(where.meaning, {"do": child}),
    )
    up = Skipping.of(where.meaning, {"do": well})
    first = container("fallback", {"do": well, "failed": failed}, up)
    if skips:
        return switch(ran, {"first": ""}, {"first": first, "skip": skip()}, where.meaning, default="skip")
    ways = {"first": first, "succeeded": end("SUCCESS"), "had failed": end("FAILURE")}
    return switch(ran, {"first": "", "succeeded": "success"}, ways, where.meaning, default="had failed")


def _loop(type_name: str) -> Reader:
    def read(reading: Reading, element: Element, where: Where) -> Made:
        child = _unskipped(reading, element, where)
        text = element.attributes.get("queue", "")
        if key_of(text, "queue") is not None:
            reading.refuse(
                element,
                where,
                f"the queue {text} is taken apart on the blackboard, item by item; write it as a literal, or use"
                " `for_each` over a list",
            )
        key = key_of(element.attributes.get("value", "{=}"), "value")
        if key is None:
            reading.refuse(element, where, "`value` has to be a key in braces")
        with reading.refusing(element, where):
            items = [value_of_text(part, type_name) for part in text.split(";")] if text else []
            empty = end(reading.said(element, where, "if_empty", "SUCCESS"))
        queue = reading.variable(f"{element.attributes.get('name', 'loop')}_queue", where, f"list[{type_name}]", items)
        item = where.board.variables.new(f"{key}_item")
        target = where.board.variable(key)
        where.board.variables.every[target].written.append(type_name)
        take = {"node": "flow/compute", "with": {"expression": "a"}, "in": {"a": item}, "out": {"value": target}}
        each = container("sequence", {"take": Made(take, instant=True), "do": child})
        keys = {"kind": "for_each", "items": queue, "item": item, "child": {"each": each.keys}}
        del where.board.variables.every[item]
        if empty.keys == SUCCEED:
            return Made(keys)
        up = Skipping.of(where.meaning, {"empty": empty})
        return container("sequence", {"loop": Made(keys), "empty": empty}, up)

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
