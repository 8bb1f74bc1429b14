"""Leaves against their manifests: types, parameters, ports, outcomes' meanings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grip_bt.catalog import Manifest, check_value
from grip_bt.errors import listing, nearest
from grip_bt.graph import Leaf

from ..survey import Spot, Survey
from ..wording import take_hint


def check_names(survey: Survey) -> None:
    """Find unknown node types, and parameters, ports and meanings that a node's manifest doesn't have or needs."""
    for spot in survey.leaves:
        assert isinstance(spot.node, Leaf), "these are leaves"
        if spot.known is not None and spot.known.fits(spot.node):
            continue
        if spot.manifest is None:
            _unknown_node(survey, spot.path, spot.node.node)
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


def _unknown_node(survey: Survey, path: str, id: str) -> None:
    ids = survey.catalog.ids()
    hint = nearest(id, ids)
    fix = take_hint(hint, "correct the name, or add the component that has it")
    room = id.partition("/")[0]
    same_room = [other for other in ids if other.startswith(f"{room}/")]
    there = f" (in {room}/ there are: {listing(same_room)})" if same_room else ""
    survey.add(path, "node", "unknown-node", f"there is no node {id!r}{there}{hint}", fix)


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
                take_hint(hint, f"remove it from `{key}`"),
            )


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
