"""Leaves and subtasks against their manifests: types, parameters, ports, outcomes' meanings, numbers in literals."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from itertools import count
from math import isfinite, isnan
from typing import Any

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Leaf, Subtask, Switch, Variable
from grip_bt.task.catalog import Manifest, check_value

from .codes import has_literal_form, producers, suggestion
from .survey import Spot, Survey, type_or_none

HINTED = 300
"""Unknown node types for which a similar one is looked for: who has more has no slip of the pen."""


def check_names(survey: Survey) -> None:
    """Find unknown node types, and parameters, ports and meanings that a node's manifest doesn't have or needs."""
    words = cache(lambda id: _unknown_node(survey, id, next(asked) < HINTED))
    asked = count()
    for spot in survey.leaves:
        node, manifest = spot.node, spot.manifest
        assert isinstance(node, Leaf), "these are leaves"
        if manifest is None:
            survey.add(spot.path, "node", "unknown-node", *words(node.node))
        else:
            _ports(survey, spot, node, manifest)
            _parameters(survey, spot.path, node, manifest)


def _ports(survey: Survey, spot: Spot, node: Leaf | Subtask, manifest: Manifest) -> None:
    """Find names under `with`, `in`, `out` and `meaning` that a manifest doesn't have, and inputs that are missing."""
    literals = ("input", manifest.inputs) if isinstance(node, Subtask) else ("parameter", manifest.parameters)
    sides: tuple[tuple[str, Iterable[str], str, Mapping[str, object]], ...] = (
        ("with", node.with_, *literals),
        ("in", node.in_, "input", manifest.inputs),
        ("out", node.out, "output", manifest.outputs),
        ("meaning", node.meaning, "outcome", manifest.outcomes),
    )
    for key, given, word, allowed in sides:
        for name in given:
            if name not in allowed:
                message = f"{manifest.id} has no {word} {name!r}"
                otherwise = f"remove it from `{key}`"
                fix = _other_side(survey, spot, key, name) if isinstance(node, Leaf) else ""
                survey.unknown(spot.path, (key, name), f"unknown-{word}", message, name, allowed, otherwise, fix)
    for port, declared in manifest.inputs.items():
        if declared.required and port not in node.in_ and (isinstance(node, Leaf) or port not in node.with_):
            literal = "" if isinstance(node, Leaf) else f", or give a literal: `with: {{{port}: ...}}`"
            message = f"{manifest.id} needs the input {port!r} ({declared.type})"
            fix = f"bind it: `in: {{{port}: <variable>}}`{literal}"
            survey.add(spot.path, ("in", port), "missing-input", message, fix)


def _unknown_node(survey: Survey, id: str, hinted: bool) -> tuple[str, str]:
    """Return what is said about a node that doesn't exist, and what to do about it."""
    ids = survey.catalog.ids()
    hint = nearest(id, ids) if hinted else ""
    fix = suggestion(hint, "correct the name, or add the component that has it")
    room = id.partition("/")[0]
    same_room = [other for other in ids if other.startswith(f"{room}/")]
    there = f" (available in {room}/: {listing(same_room)})" if same_room else ""
    return f"there is no node {id!r}{there}{hint}", fix


def _other_side(survey: Survey, spot: Spot, key: str, name: str) -> str:
    """Return what to do with a name that is of the other side: an input given a literal, a parameter a variable."""
    inputs, parameters = (spot.manifest.inputs, spot.manifest.parameters) if spot.manifest else ({}, {})
    if key == "with" and name in inputs:
        text, type_ = inputs[name].type, type_or_none(inputs[name].type)
        given = type_ is None or has_literal_form(type_)
        declared = f"`data: {{{name}: {f'{{type: {text}, value: ...}}' if given else text}}}`"
        first = "" if type_ is None or given else f"; write it first{producers(survey.catalog, type_)}"
        return f"{name!r} is an input: declare a variable, {declared}, and bind it: `in: {{{name}: {name}}}`{first}"
    if key == "in" and name in parameters:
        return f"{name!r} is a parameter: give it as a literal, `with: {{{name}: ...}}`"
    return ""


def _parameters(survey: Survey, path: str, node: Leaf, manifest: Manifest) -> None:
    for name, parameter in manifest.parameters.items():
        if name in node.with_:
            reason = check_value(parameter.type, node.with_[name])
            if reason:
                survey.add(
                    path,
                    ("with", name),
                    "wrong-parameter-type",
                    f"the parameter {name!r} of {manifest.id} {reason}",
                    f"give a literal of type {parameter.type}",
                )
        elif parameter.required:
            survey.add(
                path,
                ("with", name),
                "missing-parameter",
                f"{manifest.id} needs the parameter {name!r} ({parameter.type})",
                f"give it: `with: {{{name}: ...}}`",
            )


def check_subtasks(survey: Survey) -> None:
    """Find files that can't be run, ports that they don't have or that are missing, and outputs that nothing writes."""
    for spot in survey.spots:
        if isinstance(spot.node, Subtask):
            found = survey.subtasks.look(spot.node.task)
            if found.code:
                survey.add(spot.path, "task", found.code, found.message, found.fix)
            if spot.manifest is not None:
                _ports(survey, spot, spot.node, spot.manifest)
                for port in spot.node.with_:
                    if port in spot.manifest.inputs:
                        _literal(survey, spot, spot.node, port, spot.manifest.inputs[port].type)
    for name in survey.task.outputs:
        if not survey.task_scope[name].bit & survey.root.writes and not survey.task_scope[name].has_value:
            survey.add(
                "",
                ("outputs", name),
                "unwritten-output",
                f"nothing writes the output {name!r}",
                "bind it under `out` of the node that makes it, or remove it",
            )


def _literal(survey: Survey, spot: Spot, node: Subtask, port: str, type_name: str) -> None:
    if port in node.in_:
        survey.add(
            spot.path,
            ("with", port),
            "input-given-twice",
            f"the input {port!r} is bound under `in` and has a literal under `with`",
            "leave it in one of them",
        )
    reason = check_value(type_name, node.with_[port])
    if reason:
        survey.add(
            spot.path,
            ("with", port),
            "wrong-parameter-type",
            f"the input {port!r} of {node.task} {reason}",
            f"give a literal of type {type_name}",
        )


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
