"""Subtasks against the files that they run, and the ports of a task that is run as one."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Subtask
from grip_bt.task.catalog import Manifest, check_value

from ..survey import Spot, Survey
from ..wording import take_hint


def check_subtasks(survey: Survey) -> None:
    """Find files that can't be run, ports that they don't have or that are missing, and outputs that nothing writes."""
    for spot in survey.spots:
        if isinstance(spot.node, Subtask):
            found = survey.subtasks.look(spot.node.task)
            if found.code:
                survey.add(spot.path, "task", found.code, found.message, found.fix)
            if spot.manifest is not None:
                _ports(survey, spot, spot.node, spot.manifest)
    for name in survey.task.outputs:
        if not survey.task_scope[name].bit & survey.root.writes and not survey.task_scope[name].has_value:
            survey.add(
                "",
                ("outputs", name),
                "unwritten-output",
                f"nothing writes the output {name!r}",
                "bind it under `out` of the node that makes it, or remove it",
            )


def _ports(survey: Survey, spot: Spot, node: Subtask, face: Manifest) -> None:
    _unknown(survey, spot, "with", "input", node.with_, face.inputs)
    _unknown(survey, spot, "in", "input", node.in_, face.inputs)
    _unknown(survey, spot, "out", "output", node.out, face.outputs)
    _unknown(survey, spot, "meaning", "outcome", node.meaning, face.outcomes)
    for port, declared in face.inputs.items():
        if port in node.with_:
            _literal(survey, spot, node, port, declared.type)
        elif declared.required and port not in node.in_:
            survey.add(
                spot.path,
                ("in", port),
                "missing-input",
                f"{node.task} needs the input {port!r} ({declared.type})",
                f"bind it: `in: {{{port}: <variable>}}`, or give a literal: `with: {{{port}: ...}}`",
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


def _unknown(
    survey: Survey, spot: Spot, key: str, word: str, given: Mapping[str, object], allowed: Mapping[str, object]
) -> None:
    assert isinstance(spot.node, Subtask), "only these have files"
    for name in given:
        if name not in allowed:
            hint = nearest(name, allowed)
            survey.add(
                spot.path,
                (key, name),
                f"unknown-{word}",
                f"{spot.node.task} has no {word} {name!r}{hint} (there are: {listing(allowed)})",
                take_hint(hint, f"remove it from `{key}`"),
            )
