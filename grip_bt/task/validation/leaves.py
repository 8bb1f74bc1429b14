"""Leaves and subtasks against their manifests: types, parameters, ports, outcomes' meanings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Leaf, Subtask
from grip_bt.task.catalog import Manifest, check_value
from grip_bt.task.parts import has_value

from .analysis import PlacedNode, TaskAnalysis, type_or_none
from .codes import has_literal_form, suggestion


def check_names(analysis: TaskAnalysis) -> None:
    """Find unknown node types, and parameters, ports and meanings that a node's manifest doesn't have or needs."""
    words = cache(lambda id: _unknown_node(analysis, id))
    for placed in analysis.leaves:
        node, manifest = placed.node, placed.manifest
        assert isinstance(node, Leaf), "these are leaves"
        if manifest is None:
            analysis.add(placed.path, "node", "unknown-node", *words(node.node))
        else:
            _ports(analysis, placed, node, manifest)
            _parameters(analysis, placed.path, node, manifest)


def _ports(analysis: TaskAnalysis, placed: PlacedNode, node: Leaf | Subtask, manifest: Manifest) -> None:
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
                fix = _other_side(analysis, placed, key, name) if isinstance(node, Leaf) else ""
                analysis.unknown(placed.path, (key, name), f"unknown-{word}", message, name, allowed, otherwise, fix)
    for port, declared in manifest.inputs.items():
        if declared.required and port not in node.in_ and (isinstance(node, Leaf) or port not in node.with_):
            literal = "" if isinstance(node, Leaf) else f", or give a literal: `with: {{{port}: ...}}`"
            message = f"{manifest.id} needs the input {port!r} ({declared.type})"
            fix = f"bind it: `in: {{{port}: <variable>}}`{literal}"
            analysis.add(placed.path, ("in", port), "missing-input", message, fix)


def _unknown_node(analysis: TaskAnalysis, id: str) -> tuple[str, str]:
    ids = analysis.catalog.ids()
    hint = nearest(id, ids)
    fix = suggestion(hint, "correct the name, or add the component that has it")
    room = id.partition("/")[0]
    same_room = [other for other in ids if other.startswith(f"{room}/")]
    there = f" (available in {room}/: {listing(same_room)})" if same_room else ""
    return f"there is no node {id!r}{there}{hint}", fix


def _other_side(analysis: TaskAnalysis, placed: PlacedNode, key: str, name: str) -> str:
    """Return what to do with a name that is of the other side: an input given a literal, a parameter a variable."""
    inputs, parameters = (placed.manifest.inputs, placed.manifest.parameters) if placed.manifest else ({}, {})
    if key == "with" and name in inputs:
        text, type_ = inputs[name].type, type_or_none(inputs[name].type)
        given = type_ is None or has_literal_form(type_)
        declared = f"`data: {{{name}: {f'{{type: {text}, value: ...}}' if given else text}}}`"
        first = "" if type_ is None or given else "; write it first"
        return f"{name!r} is an input: declare a variable, {declared}, and bind it: `in: {{{name}: {name}}}`{first}"
    if key == "in" and name in parameters:
        return f"{name!r} is a parameter: give it as a literal, `with: {{{name}: ...}}`"
    return ""


def _parameters(analysis: TaskAnalysis, path: str, node: Leaf, manifest: Manifest) -> None:
    for name, parameter in manifest.parameters.items():
        if name in node.with_:
            reason = check_value(parameter.type, node.with_[name])
            if reason:
                message = f"the parameter {name!r} of {manifest.id} {reason}"
                fix = f"give a literal of type {parameter.type}"
                analysis.add(path, ("with", name), "wrong-parameter-type", message, fix)
        elif parameter.required:
            message = f"{manifest.id} needs the parameter {name!r} ({parameter.type})"
            analysis.add(path, ("with", name), "missing-parameter", message, f"give it: `with: {{{name}: ...}}`")


def check_subtasks(analysis: TaskAnalysis) -> None:
    """Find files that can't be run, ports that they don't have or that are missing, and outputs that nothing writes."""
    for placed in analysis.nodes:
        if isinstance(placed.node, Subtask):
            _, problem = analysis.subtasks.look(placed.node.task)
            if problem is not None:
                analysis.add(placed.path, "task", problem.code, problem.message, problem.fix)
            if placed.manifest is not None:
                _ports(analysis, placed, placed.node, placed.manifest)
                for port in placed.node.with_:
                    if port in placed.manifest.inputs:
                        _literal(analysis, placed, placed.node, port, placed.manifest.inputs[port].type)
    for name in analysis.task.outputs:
        output = analysis.task_scope[name]
        if not output.bit & analysis.root.writes and not has_value(output.variable):
            message = f"nothing writes the output {name!r}"
            fix = "bind it under `out` of the node that makes it, or remove it"
            analysis.add("", ("outputs", name), "unwritten-output", message, fix)


def _literal(analysis: TaskAnalysis, placed: PlacedNode, node: Subtask, port: str, type_name: str) -> None:
    if port in node.in_:
        message = f"the input {port!r} is bound under `in` and has a literal under `with`"
        analysis.add(placed.path, ("with", port), "input-given-twice", message, "leave it in one of them")
    reason = check_value(type_name, node.with_[port])
    if reason:
        message = f"the input {port!r} of {node.task} {reason}"
        fix = f"give a literal of type {type_name}"
        analysis.add(placed.path, ("with", port), "wrong-parameter-type", message, fix)
