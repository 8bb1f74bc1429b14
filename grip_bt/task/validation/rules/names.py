"""Leaves against their manifests: types, parameters, ports, outcomes' meanings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from itertools import count

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Leaf
from grip_bt.task.catalog import Manifest, check_value

from ..survey import Spot, Survey
from ..wording import has_literals, made_by, take_hint

HINTED = 300
"""Unknown node types for which a similar one is looked for: who has more has no slip of the pen."""


def check_names(survey: Survey) -> None:
    """Find unknown node types, and parameters, ports and meanings that a node's manifest doesn't have or needs."""
    words = cache(lambda id: _unknown_node(survey, id, next(asked) < HINTED))
    asked = count()
    for spot in survey.leaves:
        assert isinstance(spot.node, Leaf), "these are leaves"
        if spot.known is not None and spot.known.fits(spot.node):
            continue
        if spot.manifest is None:
            survey.add(spot.path, "node", "unknown-node", *words(spot.node.node))
            continue
        node, manifest = spot.node, spot.manifest
        _unknown(survey, spot, "with", "parameter", node.with_, manifest.parameters)
        _unknown(survey, spot, "in", "input", node.in_, manifest.inputs)
        _unknown(survey, spot, "out", "output", node.out, manifest.outputs)
        _unknown(survey, spot, "meaning", "outcome", node.meaning, manifest.outcomes)
        _parameters(survey, spot.path, node, manifest)
        for port, declared in manifest.inputs.items():
            if declared.required and port not in node.in_:
                survey.add(
                    spot.path,
                    ("in", port),
                    "missing-input",
                    f"{manifest.id} needs the input {port!r} ({declared.type})",
                    f"bind it: `in: {{{port}: <variable>}}`",
                )


def _unknown_node(survey: Survey, id: str, hinted: bool) -> tuple[str, str]:
    """Return what is said about a node that doesn't exist, and what to do about it."""
    ids = survey.catalog.ids()
    hint = nearest(id, ids) if hinted else ""
    fix = take_hint(hint, "correct the name, or add the component that has it")
    room = id.partition("/")[0]
    same_room = [other for other in ids if other.startswith(f"{room}/")]
    there = f" (in {room}/ there are: {listing(same_room)})" if same_room else ""
    return f"there is no node {id!r}{there}{hint}", fix


def _unknown(
    survey: Survey, spot: Spot, key: str, word: str, given: Iterable[str], allowed: Mapping[str, object]
) -> None:
    for name in given:
        if name not in allowed:
            hint = nearest(name, allowed)
            node = spot.node.node if isinstance(spot.node, Leaf) else ""
            survey.add(
                spot.path,
                (key, name),
                f"unknown-{word}",
                f"{node} has no {word} {name!r}{hint} (there are: {listing(allowed)})",
                _other_side(survey, spot, key, name) or take_hint(hint, f"remove it from `{key}`"),
            )


def _other_side(survey: Survey, spot: Spot, key: str, name: str) -> str:
    """Return what to do with a name that is of the other side: an input given a literal, a parameter a variable."""
    inputs, parameters = (spot.manifest.inputs, spot.manifest.parameters) if spot.manifest else ({}, {})
    if key == "with" and name in inputs:
        text, type_ = inputs[name].type, spot.known.inputs[name] if spot.known else None
        given = type_ is None or has_literals(type_)
        declared = f"`data: {{{name}: {f'{{type: {text}, value: ...}}' if given else text}}}`"
        first = "" if type_ is None or given else f"; write it first{made_by(survey.catalog, type_)}"
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
