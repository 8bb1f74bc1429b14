"""What the palette offers: the catalogue's leaves and the kinds of containers, with what forms need to know."""

from __future__ import annotations

import types
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from grip_bt.base.errors import SubtaskError
from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest, face_of
from grip_gui.edit_messages import CatalogView, FieldFace, FieldType, KindFace, NodeFace, ParameterFace, PortFace

_ELSEWHERE = {"doc", "on", "x", "data", "outcomes", "children", "child", "exits", "kind"}
"""Keys that have places of their own on the page."""
_EXPRESSIONS = {"precondition", "if", "while", "on_value"}
_SPECIAL: dict[str, FieldType] = {"items": "variable", "initial": "child", "default": "child", "item": "text"}
_BLANKS: dict[str, dict[str, Any]] = {
    "retry": {"times": 3},
    "timeout": {"seconds": 10.0},
    "guard": {"if": "true"},
    "switch": {"on_value": "0", "cases": {}},
    "for_each": {"items": "items", "item": "item"},
    "cooldown": {"seconds": 1.0},
    "force": {"as": "success"},
    "foreign": {"behaviour": "py_trees.behaviours:Success"},
    "state_machine": {"initial": "", "outcomes": {"success": "success", "failure": "failure"}},
}


def catalog_view(catalog: Catalog, tasks: Iterable[str] = (), trouble: str = "") -> CatalogView:
    """Return everything that a task can be made of.

    Args:
        catalog: the nodes that exist.
        tasks: the project's task files; those that can't be read aren't offered.
        trouble: why nodes are missing.
    """
    return CatalogView(
        nodes=[_node(manifest) for manifest in catalog],
        kinds=[_kind(shape) for shape in _containers()],
        tasks=[face for file in tasks if (face := _subtask(catalog, file)) is not None],
        trouble=trouble,
    )


def _subtask(catalog: Catalog, file: str) -> NodeFace | None:
    try:
        return _node(face_of(file, catalog.tasks.read(file)))
    except SubtaskError:
        return None


def _containers() -> list[Any]:
    found = {_kind_of(shape): shape for shape in get_args(model.Container)}
    return [found[kind] for kind in model.KINDS if kind in found]


def _kind_of(shape: Any) -> str:
    return str(get_args(shape.model_fields["kind"].annotation)[0])


def _node(manifest: Manifest) -> NodeFace:
    return NodeFace(
        id=manifest.id,
        doc=manifest.doc,
        parameters=[
            ParameterFace(name=name, type=p.type, doc=p.doc, required=p.required, default=p.default)
            for name, p in manifest.parameters.items()
        ],
        inputs=[
            PortFace(name=name, type=p.type, doc=p.doc, required=p.required) for name, p in manifest.inputs.items()
        ],
        outputs=[PortFace(name=name, type=p.type, doc=p.doc) for name, p in manifest.outputs.items()],
        outcomes=dict(manifest.outcomes),
        codes=list(manifest.codes),
    )


def _kind(shape: Any) -> KindFace:
    fields = shape.model_fields
    holds: Literal["none", "one", "many"] = "one" if "child" in fields else "many" if "children" in fields else "none"
    return KindFace(
        kind=_kind_of(shape),
        doc=(shape.__doc__ or "").strip(),
        children=holds,
        fields=[_field(info.alias or name, info) for name, info in fields.items() if name not in _ELSEWHERE],
        blank=_BLANKS.get(_kind_of(shape), {}),
    )


def _field(key: str, info: FieldInfo) -> FieldFace:
    kind, choices = _type(key, info.annotation)
    default = None if info.is_required() or not isinstance(info.default, bool | int | float | str) else info.default
    doc = info.description or ""
    return FieldFace(key=key, type=kind, doc=doc, required=info.is_required(), default=default, choices=choices)


def _type(key: str, annotation: Any) -> tuple[FieldType, list[str]]:
    if key in _EXPRESSIONS:
        return "expression", []
    if key in _SPECIAL:
        return _SPECIAL[key], []
    parts = _members(annotation)
    if parts and all(get_origin(part) is Literal for part in parts):
        return "choice", [str(value) for part in parts for value in get_args(part)]
    names: dict[Any, FieldType] = {bool: "bool", int: "int", float: "float", str: "text"}
    return (names.get(parts[0], "json") if len(parts) == 1 else "json"), []


def _members(annotation: Any) -> list[Any]:
    """Return the alternatives of a type, without None and without constraints."""
    if get_origin(annotation) is Annotated:
        return _members(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return [m for part in get_args(annotation) if part is not type(None) for m in _members(part)]
    return [annotation]
