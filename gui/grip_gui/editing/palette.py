"""What the palette offers: the catalogue's leaves and the kinds of containers, with what forms need to know."""

from __future__ import annotations

import types
from collections.abc import Iterable
from contextlib import suppress
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import MinLen
from pydantic.fields import FieldInfo

from grip_bt.base.errors import SubtaskError
from grip_bt.task.catalog import Catalog, Manifest, manifest_of_task
from grip_bt.task.model import KINDS, Kind
from grip_gui.wire.editing import CatalogView, NodeFace, ParameterFace, PortFace
from grip_gui.wire.task import FieldType, KindView, SettingView

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
            faces.append(_node(manifest_of_task(file, catalog.tasks.read(file))))
    return CatalogView(nodes=[_node(manifest) for manifest in catalog], tasks=faces, error=error)


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
    return (names.get(parts[0], "json") if len(parts) == 1 else "json"), []


def _members(annotation: object) -> list[Any]:
    """Return the alternatives of a type, without None and without constraints."""
    if get_origin(annotation) is Annotated:
        return _members(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return [m for part in get_args(annotation) if part is not type(None) for m in _members(part)]
    return [annotation]
