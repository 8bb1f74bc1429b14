"""What lowered tasks are made of: elements, scripts, and conditions on how a node has ended."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.resolve import Part
from grip_bt.task.catalog import Manifest
from grip_bt.task.parts import Edges

TARGET = "BehaviorTree.CPP's XML"


@dataclass
class Xml:
    """One element that is written."""

    tag: str
    said: dict[str, str] = field(default_factory=dict)
    children: list[Xml] = field(default_factory=list)


def script(*statements: str) -> Xml:
    """Return assignments."""
    return Xml("Script", {"code": "; ".join(statements)})


def holds(condition: str) -> Xml:
    """Return a condition."""
    return Xml("ScriptCondition", {"code": condition})


def around(tag: str, *children: Xml, **said: str) -> Xml:
    """Return an element with others in it."""
    return Xml(tag, said, list(children))


def chosen(ways: Iterable[tuple[str, str]], other: str) -> str:
    """Return the value of the first way whose condition holds."""
    text = other
    for condition, value in reversed(list(ways)):
        text = f"({condition} ? {value} : {text})"
    return text.removeprefix("(").removesuffix(")") if text.startswith("(") else text


def tells(manifest: Manifest) -> bool:
    """Tell whether a leaf has more to say of its end than success and failure."""
    return (
        bool(manifest.codes)
        or {*manifest.outcomes} - {"success", "failure"} != set()
        or not manifest.implementation.startswith("grip_bt.")
    )


def leads(
    edges: Edges, child: Part, quote: str = "'", outcome: str = "outcome", code: str = "code"
) -> list[tuple[str, str]]:
    """Return conditions on how a child has ended, those with codes first, and where each leads."""
    found = [(label, why, target) for (name, label, why), target in edges if name == child.name]
    found.sort(key=lambda each: each[1] is None)
    return [(labelled(said_of(lab, why), outcome, code), f"{quote}{to}{quote}") for lab, why, to in found]


def said_of(label: str, why: str | None) -> str:
    """Return `outcome` or `outcome.code`."""
    return label if why is None else f"{label}.{why}"


def labelled(said: str, outcome: str, code: str) -> str:
    """Return the condition of `outcome` or `outcome.code`."""
    label, _, why = said.partition(".")
    return f"({outcome} == '{label}' && {code} == '{why}')" if why else f"{outcome} == '{label}'"


def any_of(conditions: Iterable[str]) -> str:
    """Return that one of them holds."""
    every = list(conditions)
    return "(" + " || ".join(f"({one})" for one in every) + ")" if every else "false"


def all_of(conditions: Iterable[str]) -> str:
    """Return that all of them hold."""
    every = list(conditions)
    return "(" + " && ".join(f"({one})" for one in every) + ")" if every else "true"


def tag_of(manifest: Manifest) -> str:
    """Return the element that stands for a node of the catalogue."""
    group, _, name = manifest.id.partition("/")
    return name if group in ("btcpp", "nav2") else manifest.id.replace("/", "__")


def lines(made: Xml, depth: int) -> Iterator[str]:
    """Yield the lines of an element."""
    start = "  " * depth + f"<{made.tag}" + "".join(f" {key}={quoteattr(value)}" for key, value in made.said.items())
    if not made.children:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for child in made.children:
        yield from lines(child, depth + 1)
    yield f"{'  ' * depth}</{made.tag}>"


def milliseconds(part: Part, seconds: float) -> str:
    """Return a time [s] in milliseconds.

    Raises:
        NotExpressibleError: it isn't a whole number of them.
    """
    milliseconds = round(seconds * 1000)
    if milliseconds / 1000 != seconds:
        raise NotExpressibleError(part.path, f"{seconds} s, which isn't a whole number of milliseconds,", TARGET)
    return str(milliseconds)
