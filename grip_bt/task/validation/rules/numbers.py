"""Literals that are no numbers to work with: `.nan`, and `.inf` where something finite is meant."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite, isnan
from typing import Any

from grip_bt.task import Leaf, Subtask, Switch, Variable

from ..survey import Survey

Place = tuple[str | int, ...]


def check_numbers(survey: Survey) -> None:
    """Find numbers that aren't finite in what nodes are given, and `.nan` also in what variables begin with."""
    for spot in survey.spots:
        node = spot.node
        if isinstance(node, Leaf):
            for place, number in _strange(node.with_, ("with",)):
                _say(survey, spot.path, place, number)
        elif isinstance(node, Subtask):
            _say_of_nan(survey, spot.path, node.with_, ("with",))
        elif isinstance(node, Switch):
            _say_of_nan(survey, spot.path, node.cases, ("cases",))
        elif isinstance(seconds := getattr(node, "seconds", None), float) and not isfinite(seconds):
            _say(survey, spot.path, ("seconds",), seconds)
    for declared in survey.declared:
        if isinstance(declared.variable, Variable) and declared.has_value:
            _say_of_nan(survey, declared.owner, declared.variable.value, (declared.key, declared.name, "value"))


def _say_of_nan(survey: Survey, path: str, value: Any, place: Place) -> None:
    """Note only what is no number at all: a search for the least, for instance, begins with infinity."""
    for found, number in _strange(value, place):
        if isnan(number):
            _say(survey, path, found, number)


def _strange(value: Any, place: Place) -> Iterator[tuple[Place, float]]:
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


def _say(survey: Survey, path: str, place: Place, number: float) -> None:
    where = "/".join(map(str, place))
    if isnan(number):
        reason = "`.nan` is no number: nothing equals it, and no motion, time or limit can be made of it"
        survey.add(path, place, "not-a-number", f"{where}: {reason}", "write a number, or leave it out")
        return
    word = ".inf" if number > 0 else "-.inf"
    reason = f"`{word}` isn't finite: no place, time or force is; what has no end is `null`, or isn't said"
    survey.add(path, place, "infinite-number", f"{where}: {reason}", "write a finite number")
