"""Attributes that any node of BT.CPP may have: conditions before it, scripts after it, and a description."""

from __future__ import annotations

from ..pytrees_xml.elements import Element
from .decorators import end
from .making import Made, skip, switch
from .reading import Reading, Where
from .statements import Scripts, after

_BEFORE = ("_failureIf", "_successIf", "_skipIf", "_while")
_AFTER = ("_onSuccess", "_onFailure", "_post")
_NO_MATTER = ("_uid", "_fullpath", "_autoremap", "_description")
"""Groot's own notes, and what sub-trees read."""


def check(reading: Reading, element: Element, where: Where) -> None:
    """Refuse attributes that have no equal."""
    for name in element.attributes:
        if name == "_onHalted":
            reading.refuse(
                element,
                where,
                "`_onHalted` runs a script when the node is halted; nothing of a task does: use a leaf of your own",
            )
        if name.startswith("_") and name not in (*_BEFORE, *_AFTER, *_NO_MATTER):
            reading.remark(element, where, f"the attribute `{name}`, which BT.CPP gives no meaning, was left out")


def wrapped(reading: Reading, element: Element, node: Made, where: Where) -> Made:
    """Return a node with its conditions before and its scripts after it.

    BT.CPP looks at `_failureIf`, `_successIf`, `_skipIf` and `_while` in this order when the node begins, and at
    `_while` on every tick; the scripts also run when a condition has decided.
    """
    said = element.attributes
    made = node
    with reading.refusing(element, where):
        scripts = reading.scripts(element, where)
        for name in reversed(_BEFORE):
            if name in said:
                made = _before(name, said[name], scripts, made, where.meaning)
        always = said.get("_post", "")
        well = [each for text in (said.get("_onSuccess", ""), always) for each in scripts.assignments(text)]
        badly = [each for text in (said.get("_onFailure", ""), always) for each in scripts.assignments(text)]
        made = after(made, well, badly, where.meaning)
    made.name = node.name
    if said.get("_description"):
        made.keys = {**made.keys, "doc": said["_description"]}
    return made


def _before(name: str, text: str, scripts: Scripts, node: Made, meaning: str) -> Made:
    if name == "_failureIf" and "precondition" not in node.keys:
        holds = scripts.condition(f"!({text})")
        return Made({**node.keys, "precondition": holds}, node.skips, node.name, node.instant)
    condition = scripts.condition(text)
    if name == "_failureIf":
        return switch(condition, {"fails": True}, {"fails": end("FAILURE"), "do": node}, meaning, default="do")
    if name == "_successIf":
        return switch(condition, {"succeeds": True}, {"succeeds": end("SUCCESS"), "do": node}, meaning, default="do")
    if name == "_skipIf":
        return switch(condition, {"skip": True}, {"skip": skip(), "do": node}, meaning, default="do")
    return switch(condition, {"do": True}, {"do": node, "skip": skip()}, meaning, default="skip", memory=False)
