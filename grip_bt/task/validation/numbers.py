"""Numbers that aren't finite, in what nodes are given and in what variables begin with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite, isnan

from grip_bt.task import Leaf, Subtask, Switch, Variable

from .analysis import TaskAnalysis

Place = tuple[str | int, ...]


def check_numbers(analysis: TaskAnalysis) -> None:
    """Find numbers that aren't finite in what nodes are given, and `.nan` also in what variables begin with."""
    for placed in analysis.nodes:
        node = placed.node
        if isinstance(node, Leaf):
            _not_finite(analysis, placed.path, node.with_, ("with",), told=True)
        elif isinstance(node, Subtask):
            _not_finite(analysis, placed.path, node.with_, ("with",))
        elif isinstance(node, Switch):
            _not_finite(analysis, placed.path, node.cases, ("cases",))
        else:
            _not_finite(analysis, placed.path, getattr(node, "seconds", None), ("seconds",), told=True)
    for declared in analysis.declared:
        if isinstance(declared.variable, Variable) and declared.variable.has_value:
            _not_finite(analysis, declared.owner, declared.variable.value, (declared.key, declared.name, "value"))


def _not_finite(analysis: TaskAnalysis, path: str, value: object, place: Place, told: bool = False) -> None:
    """Note what is no number, and where it is `told` infinity: a search for the least, for instance, begins with it."""
    for at, number in _strange(value, place):
        where = "/".join(map(str, at))
        if isnan(number):
            message = f"{where}: `.nan` can't be used as a value here"
            analysis.add(path, at, "not-a-number", message, "write a number, or leave it out")
        elif told:
            word = ".inf" if number > 0 else "-.inf"
            message = f"{where}: `{word}` isn't allowed here; for no limit write `null` or leave the key out"
            analysis.add(path, at, "infinite-number", message, "write a finite number")


def _strange(value: object, place: Place) -> Iterator[tuple[Place, float]]:
    """Yield every number within a literal that isn't finite, with its place."""
    if type(value) is float:
        if not isfinite(value):
            yield place, value
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from _strange(item, (*place, key))
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            yield from _strange(item, (*place, index))
