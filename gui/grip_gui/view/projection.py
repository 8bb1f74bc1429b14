"""A task as the page draws it. Computed here, so that Python is the one place that knows what a task means."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Literal, TypeAlias

from grip_bt.task.canonical import data_of
from grip_bt.task.canonical import file_data as plain_data
from grip_bt.task.catalog.manifest import Manifest
from grip_bt.task.kind_analysis import derived_edges, surely_first
from grip_bt.task.model import AnyNode, Foreign, Kind, Leaf, Subtask, Task, Variable, join, outcomes_of, walk
from grip_gui.wire.task import Meaning, NodeView, TaskView, Transition, VariableView

FindManifest: TypeAlias = Callable[[str], "Manifest | None"]
_SHOWN = {"node", "kind", "children", "child", "with", "in", "out"}
_SHOWN_FIELDS = {"node", "kind", "children", "child", "with_", "in_", "out"}
PREVIEW = 2000
"""Longest initial value that is shown whole, in characters."""


def project_task(task: Task, path: str, find: FindManifest) -> TaskView:
    """Return the view of a task.

    Args:
        task: what was read.
        path: the file, relative to the project folder.
        find: returns the manifest of a catalogue id or of a task's file, None for one that isn't known.
    """
    return TaskView.model_construct(  # nothing here comes from elsewhere, and the check copies every list
        path=path,
        name=task.name,
        doc=task.doc,
        outcomes=dict(task.outcomes),
        nodes=_nodes(task, cache(find)),
        variables=_variables(task),
        problems=[],
    )


def _nodes(task: Task, find: FindManifest) -> list[NodeView]:
    """Return the views of all nodes, parents first and in document order."""
    views: list[NodeView] = []

    def draw(node: AnyNode, view: NodeView) -> None:
        views.append(view)
        if isinstance(node, Leaf):
            return
        first, derived = surely_first(node), derived_edges(node)
        for name, below in node.below.items():
            leads = derived.get(name, {}).items()
            position: dict[str, Any] = {
                "path": join(view.path, name),
                "parent": view.path,
                "name": name,
                "on": _edges_below(node, name, below),
                "initial": first == name,
                "derived": [Transition(outcome=meaning, target=to, ends=ends) for meaning, (to, ends) in leads],
            }
            draw(below, _node(below, find, position))

    position = {"path": "/", "parent": None, "name": task.name, "on": _edges(task.root.on, ends=task.outcomes)}
    draw(task.root, _node(task.root, find, position))
    return views


def _node(node: AnyNode, find: FindManifest, position: dict[str, Any]) -> NodeView:
    if isinstance(node, Leaf):
        manifest = find(node.node)
        return NodeView(
            **position,
            kind="leaf",
            label=node.node,
            doc=node.doc or (manifest.doc if manifest else ""),
            outcomes=_outcomes_of(manifest, node.meaning),
            **_ports(node),
            fields=_fields(node),
        )
    ports = _ports(node) if isinstance(node, Subtask | Foreign) else {}
    return NodeView(
        **position,
        kind=node.kind,
        label=node.settings(),
        doc=node.doc,
        children=[join(position["path"], child) for child in node.below],
        outcomes=_outcomes_of(find(node.task), node.meaning) if isinstance(node, Subtask) else outcomes_of(node),
        **ports,
        fields=_fields(node),
    )


def _ports(node: Leaf | Subtask | Foreign) -> dict[str, Any]:
    given = node.args if isinstance(node, Foreign) else node.with_
    return {"inputs": dict(node.in_), "outputs": dict(node.out), "parameters": dict(given)}


def _outcomes_of(face: Manifest | None, meaning: Mapping[str, Meaning]) -> dict[str, Meaning]:
    if face is not None:
        return face.outcomes_for(dict(meaning))
    return {"success": "success", "failure": "failure", **meaning}


def _fields(node: AnyNode) -> dict[str, Any]:
    """Return the keys of a node that the view doesn't have elsewhere; only those that stand in the file."""
    if node.model_fields_set <= _SHOWN_FIELDS:
        return {}  # most nodes: the long way takes a third of the time of a large task's view
    return {key: plain_data(value) for key, value in data_of(node).items() if key not in _SHOWN}


def _edges_below(parent: Kind, name: str, child: AnyNode) -> list[Transition]:
    """Return where a child's outcomes lead: its `on` in a state machine, else its parent's `exits`."""
    if parent.by_edges:
        return _edges(child.on, ends=parent.outcomes)
    own = {key.removeprefix(f"{name}."): target for key, target in parent.exits.items() if key.startswith(f"{name}.")}
    return [Transition(outcome=outcome, target=target, ends=True) for outcome, target in own.items()]


def _edges(on: Mapping[str, str], ends: Mapping[str, Meaning]) -> list[Transition]:
    return [Transition(outcome=outcome, target=target, ends=target in ends) for outcome, target in on.items()]


def _variables(task: Task) -> list[VariableView]:
    scopes: list[tuple[str, Mapping[str, Variable | str]]] = [("", task.variables)]
    # Not `getattr(node, "data", {})`: what pydantic does about an attribute that isn't there takes most of an edit.
    scopes += [(path, node.data) for path, node in walk(task.root) if _may_declare(type(node))]  # type: ignore[union-attr]
    views = [_variable(scope, name, declared) for scope, data in scopes for name, declared in data.items()]
    sides: tuple[tuple[Literal["input", "output"], Mapping[str, object]], ...]
    sides = (("input", task.inputs), ("output", task.outputs))
    for i, view in enumerate(views):
        ports = [side for side, names in sides if view.scope == "" and view.name in names]
        views[i] = view.model_copy(update={"ports": ports}) if ports else view
    return views


@cache
def _may_declare(kind: type[AnyNode]) -> bool:
    """Tell whether nodes of a kind may have variables of their own."""
    return "data" in kind.model_fields


def _variable(scope: str, name: str, declared: Variable | str) -> VariableView:
    if isinstance(declared, str):
        return VariableView(scope=scope, name=name, type=declared)
    initial = json.dumps(plain_data(declared.value), default=str) if declared.has_value else None
    whole = initial is None or len(initial) <= PREVIEW
    shown = None if initial is None else initial[:PREVIEW]
    return VariableView(scope=scope, name=name, type=declared.type, doc=declared.doc, initial=shown, whole=whole)
