"""Control nodes of BT.CPP as containers of a task."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grip_bt.formats.blackboard import key_of

from .drafts import Keys, NodeDraft, container, named, switch
from .reading import ElementReader

Reader = Callable[[ElementReader], NodeDraft]


def _series(kind: str, memory: bool) -> Reader:
    def read(here: ElementReader) -> NodeDraft:
        children = here.children(meaning="success" if kind == "sequence" else "failure")
        skips = all(child.skips for child in children)
        if skips and len(children) > 1:
            here.unequal("all of its children may be skipped")
        more: Keys = {} if memory else {"memory": False}
        return container(kind, named(children), here.meaning if skips else "", **more)

    return read


def by_its_rules(least: int = 1, most: int = 10_000) -> Reader:
    """Return what leaves a node with so many children to the control node that follows its rules."""

    def read(here: ElementReader) -> NodeDraft:
        here.children(least, most)
        here.unequal("")

    return read


def _parallel(here: ElementReader) -> NodeDraft:
    children = _unskipped(here)
    count = len(children)
    successes = _threshold(here, "success_count", "-1", count)
    failures = _threshold(here, "failure_count", "1", count)
    rules = [
        {"at_least": successes, "then": "success"},
        {"at_least": min(failures, count - successes + 1), "ends": "failure", "then": "failure"},
    ]
    return container("parallel", named(children), rules=rules, prompt=True)


def _parallel_all(here: ElementReader) -> NodeDraft:
    children = _unskipped(here)
    most = _threshold(here, "max_failures", "1", len(children))
    if most in (1, len(children)):
        made = container("parallel", named(children), cancel="join")
        return made if most == 1 else NodeDraft({**made.keys, "policy": "any"}, instant=made.instant)
    rules = [{"at_least": most, "ends": "failure", "then": "failure"}, {"then": "success"}]
    return container("parallel", named(children), rules=rules, wait_for="all")


def _unskipped(here: ElementReader) -> list[NodeDraft]:
    children = here.children()
    for child, below in zip(children, here.element.children, strict=True):
        if child.skips:
            here.unequal(f"{below} may be skipped, and is asked again on every tick")
    return children


def _threshold(here: ElementReader, port: str, default: str, count: int) -> int:
    said = here.number(port, default)
    number = said if said >= 0 else max(count + said + 1, 0)
    if not 1 <= number <= count:
        here.unequal(f"`{port}` is {said}, and there are {count} children")
    return number


def _switch(cases: int) -> Reader:
    def read(here: ElementReader) -> NodeDraft:
        children = here.children(cases + 1, cases + 1)
        text = here.attributes.get("variable", "")
        key = key_of(text, "variable")
        if key is None:
            here.refuse(f"`variable` has to be a key in braces, not {text!r}")
        variable = here.board.variable(key)
        entry = here.board.variables.every[variable]
        entry.read.append("Any")
        parts = named(children)
        literals: dict[str, Any] = {}
        taken: list[str] = []
        for number, name in zip(range(1, cases + 1), parts, strict=False):
            said = here.literal(f"case_{number}")
            if said in taken:
                here.refuse(f"`case_{number}` is {said!r} again")
            taken.append(said)
            try:
                literals[name] = _case(said, entry.type)
            except ValueError as error:
                here.unequal(str(error))
        return switch(variable, literals, parts, here.meaning, default=list(parts)[-1], memory=False)

    return read


def _case(text: str, kind: str) -> Any:
    """Return the literal of a case; BT.CPP compares as texts, then as numbers."""
    try:
        number: int | None = int(text)
    except ValueError:
        number = None
    if kind in ("bool", "float"):
        raise ValueError(f"a Switch over a {kind} compares its text; switch over a text or a whole number")
    if kind == "int":
        if number is None:
            raise ValueError(f"the case {text!r} for a whole number: an enum's word isn't known here, write its number")
        return number
    return text if number is None or kind == "str" else [text, number]


CONTROLS: dict[str, tuple[Reader, tuple[str, ...]]] = {
    "Sequence": (_series("sequence", True), ()),
    "Fallback": (_series("fallback", True), ()),
    "ReactiveSequence": (_series("sequence", False), ()),
    "ReactiveFallback": (_series("fallback", False), ()),
    **dict.fromkeys(("AsyncSequence", "AsyncFallback", "SequenceWithMemory", "SequenceStar"), (by_its_rules(), ())),
    "Parallel": (_parallel, ("success_count", "failure_count")),
    "ParallelAll": (_parallel_all, ("max_failures",)),
    "IfThenElse": (by_its_rules(2, 3), ()),
    "WhileDoElse": (by_its_rules(2, 3), ()),
    "TryCatch": (by_its_rules(2), ("catch_on_halt",)),
    **{f"Switch{n}": (_switch(n), ("variable", *(f"case_{i}" for i in range(1, n + 1)))) for n in range(2, 7)},
}
"""Tag -> its reader and its ports."""
