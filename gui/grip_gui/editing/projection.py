"""What the page draws and offers: a task's nodes and variables, the catalogue's leaves, the kinds of containers."""

from __future__ import annotations

import json
import types
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import cache
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

from annotated_types import MinLen
from pydantic.fields import FieldInfo

from grip_bt.base.errors import SubtaskError
from grip_bt.task.canonical import data_of
from grip_bt.task.canonical import file_data as plain_data
from grip_bt.task.catalog import Catalog, Manifest, manifest_of_task
from grip_bt.task.kind_analysis import derived_edges, surely_first
from grip_bt.task.model import KINDS, AnyNode, Foreign, Kind, Leaf, Subtask, Task, Variable, join, outcomes_of, walk
from grip_gui.wire.editing import CatalogView, NodeFace, ParameterFace, PortFace
from grip_gui.wire.task import FieldType, KindView, Meaning, NodeView, SettingView, TaskView, Transition, VariableView

FindManifest: TypeAlias = Callable[[str], "Manifest | None"]
_SHOWN = {"node", "kind", "children", "child", "with", "in", "out"}
"""Keys that the view of a node has elsewhere; `fields` has the others that stand in the file."""
PREVIEW = 2000  # longest initial value that is shown whole, in characters


def project_task(task: Task, path: str, find: FindManifest) -> TaskView:
    """Return the view of a task; `find` returns the manifest of a catalogue id or of a task's file, None for none."""
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
    face = find(node.node) if isinstance(node, Leaf) else find(node.task) if isinstance(node, Subtask) else None
    return NodeView(
        **position,
        kind="leaf" if isinstance(node, Leaf) else node.kind,
        label=node.node if isinstance(node, Leaf) else node.settings(),
        doc=node.doc or (face.doc if face and isinstance(node, Leaf) else ""),
        children=[] if isinstance(node, Leaf) else [join(position["path"], child) for child in node.below],
        outcomes=_outcomes_of(face, node.meaning) if isinstance(node, Leaf | Subtask) else outcomes_of(node),
        **(_ports(node) if isinstance(node, Leaf | Subtask | Foreign) else {}),
        fields={key: plain_data(value) for key, value in data_of(node).items() if key not in _SHOWN},
    )


def _ports(node: Leaf | Subtask | Foreign) -> dict[str, Any]:
    given = node.args if isinstance(node, Foreign) else node.with_
    return {"inputs": dict(node.in_), "outputs": dict(node.out), "parameters": dict(given)}


def _outcomes_of(face: Manifest | None, meaning: Mapping[str, Meaning]) -> dict[str, Meaning]:
    if face is not None:
        return face.outcomes_for(dict(meaning))
    return {"success": "success", "failure": "failure", **meaning}


def _edges_below(parent: Kind, name: str, child: AnyNode) -> list[Transition]:
    """Return where a child's outcomes lead: its `on` in a state machine, else its parent's `exits`."""
    if parent.by_edges:
        return _edges(child.on, ends=parent.outcomes)
    own = {key.removeprefix(f"{name}."): target for key, target in parent.exits.items() if key.startswith(f"{name}.")}
    return [Transition(outcome=outcome, target=target, ends=True) for outcome, target in own.items()]


def _edges(on: Mapping[str, str], ends: Mapping[str, Meaning]) -> list[Transition]:
    return [Transition(outcome=outcome, target=target, ends=target in ends) for outcome, target in on.items()]


def _variables(task: Task) -> list[VariableView]:
    sides: dict[Literal["input", "output"], Mapping[str, object]] = {"input": task.inputs, "output": task.outputs}
    views = [
        _variable("", name, declared, [side for side, names in sides.items() if name in names])
        for name, declared in task.variables.items()
    ]
    for path, node in walk(task.root):
        # Not `getattr(node, "data", {})`: what pydantic does about an attribute that isn't there takes most of an edit.
        if "data" in type(node).model_fields:
            views += [_variable(path, name, declared, []) for name, declared in node.data.items()]  # type: ignore[union-attr]
    return views


def _variable(scope: str, name: str, declared: Variable | str, ports: list[Literal["input", "output"]]) -> VariableView:
    if isinstance(declared, str):
        return VariableView(scope=scope, name=name, type=declared, ports=ports)
    text = json.dumps(plain_data(declared.value), default=str) if declared.has_value else ""
    return VariableView(
        scope=scope,
        name=name,
        type=declared.type,
        doc=declared.doc,
        initial=text[:PREVIEW] if declared.has_value else None,
        whole=len(text) <= PREVIEW,
        ports=ports,
    )


# --- what a task can be made of ---------------------------------------------------------------------------------------

_ELSEWHERE = set("doc on * data outcomes children child exits kind with in out meaning".split())
"""Keys that have places of their own on the page."""
_CHILDREN: dict[str, FieldType] = {"initial": "child", "default": "child", "cases": "cases"}
"""Keys that name children."""


def catalog_view(catalog: Catalog, tasks: Iterable[str] = (), error: str = "") -> CatalogView:
    """Return everything that a task can be made of; `error` says why nodes are missing.

    Task files that can't be read aren't offered.
    """
    faces = []
    for file in tasks:
        with suppress(SubtaskError):
            faces.append(_face(manifest_of_task(file, catalog.tasks.read(file))))
    return CatalogView(nodes=[_face(manifest) for manifest in catalog], tasks=faces, error=error)


def _face(manifest: Manifest) -> NodeFace:
    return NodeFace(
        id=manifest.id,
        doc=manifest.doc,
        parameters=[
            ParameterFace(name=name, type=p.type, doc=p.doc, required=p.required, default=p.default)
            for name, p in manifest.parameters.items()
        ],
        inputs=[PortFace(name=n, type=p.type, doc=p.doc, required=p.required) for n, p in manifest.inputs.items()],
        outputs=[PortFace(name=name, type=p.type, doc=p.doc) for name, p in manifest.outputs.items()],
        outcomes=dict(manifest.outcomes),
        codes=list(manifest.codes),
    )


def kind_views() -> list[KindView]:
    """Return the kinds of containers."""
    return [_kind(kind) for kind in KINDS.values()]


def _kind(kind: type[Kind]) -> KindView:
    fields = kind.model_fields
    children = fields.get("child") or fields.get("children")
    return KindView(
        kind=kind.kind_name(),
        title=kind.title or kind.kind_name().replace("_", " "),
        icon=kind.icon,
        doc=(kind.__doc__ or "").strip(),
        holds="none" if children is None else "one" if "child" in fields else "many",
        needs_child=children is not None and any(isinstance(each, MinLen) for each in children.metadata),
        edges=kind.by_edges,
        concurrent=kind.concurrent,
        declares="data" in fields,
        fields=[_field(kind, name, info) for name, info in fields.items() if (info.alias or name) not in _ELSEWHERE],
        blank=dict(kind.example),
    )


def _field(kind: type[Kind], name: str, info: FieldInfo) -> SettingView:
    type_, choices = _type(kind, name, info.annotation)
    default = None if info.is_required() or not isinstance(info.default, bool | int | float | str) else info.default
    return SettingView(
        key=info.alias or name,
        type=type_,
        doc=info.description or "",
        required=info.is_required(),
        default=default,
        choices=choices,
    )


def _type(kind: type[Kind], name: str, annotation: object) -> tuple[FieldType, list[str]]:
    if name in ("precondition", *kind.conditions, *kind.values):
        return "expression", []
    if name in kind.reads:
        return "variable", []
    if name in _CHILDREN:
        return _CHILDREN[name], []
    parts = _members(annotation)
    if parts and all(get_origin(part) is Literal for part in parts):
        return "choice", [str(value) for part in parts for value in get_args(part)]
    names: dict[Any, FieldType] = {bool: "bool", int: "int", float: "float", str: "text"}
    return names.get(parts[0] if len(parts) == 1 else None, "json"), []


def _members(annotation: object) -> list[Any]:
    """Return the alternatives of a type, without None and without constraints."""
    if get_origin(annotation) is Annotated:
        return _members(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return [m for part in get_args(annotation) if part is not type(None) for m in _members(part)]
    return [annotation]
