"""The source under construction, and its states: legacy ones, and those that tick a node."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.compilers.scopes import Cell
from grip_bt.formats.names import Identifiers
from grip_bt.formats.python_source import Bracketed, Raw, call, literal, statement
from grip_bt.formats.smach_export.forms import legacy_state, reads, writes
from grip_bt.task import model

_TAKEN = (
    *("smach", "copy", "sys", "Path", "HERE", "NODES", "build", "run", "task", "load_legacy", "BehaviourTree"),
    *("Choose", "Count", "begin_anew", "tree_run", "userdata", "states", "ends"),
)
_PLAIN = {"success": "success", "failure": "failure"}


@dataclass
class SourceBuilder:
    """The file under construction: the body of `build`, the functions above it, and what these use.

    `built`: source of what builds a legacy machine -> its name; `trees`: paths of what one state ticks -> kind.
    """

    resolved: Resolved
    identifiers: Identifiers = field(default_factory=lambda: Identifiers(_TAKEN))
    body: list[str] = field(default_factory=list)
    functions: list[str] = field(default_factory=list)
    parts: set[str] = field(default_factory=set)
    modules: dict[Path, str] = field(default_factory=dict)
    built: dict[str, str] = field(default_factory=dict)
    trees: dict[str, str] = field(default_factory=dict)
    nodes: dict[str, None] = field(default_factory=dict)

    def take(self, part: Part) -> str:
        """Return a name for the container of a node."""
        above = part.path.strip("/").split("/")[:-1]
        return self.identifiers.take(part.name, f"{above[-1] if above else 'whole'}_{part.name}")

    def write(self, expression: Bracketed | Raw, target: str = "", indent: int = 4) -> None:
        """Add a statement."""
        self.body.append(statement(target, expression, indent))

    def begin(self, name: str, made: Bracketed, part: Part) -> None:
        """Write a container's object, and what begins its variables anew."""
        self.body.append("")
        self.write(made, name)
        declared = getattr(part.node, "data", {})
        if not declared:
            return
        self.parts.add("begin_anew")
        values = {cell.name: initial(declared, cell) for cell in part.scope.cells.values()}
        given = {key: held[0] for key, held in values.items() if held}
        unset = [key for key, held in values.items() if not held]
        self.write(call(f"{name}.register_start_cb", Raw("begin_anew"), [given, unset]))


def initial(declared: Mapping[str, model.Variable | str], cell: Cell) -> list[Any]:
    """Return the initial value of a variable in a list, which is empty where it has none."""
    variable = declared.get(cell.name)
    return [variable.value] if isinstance(variable, model.Variable) and variable.has_value else []


def keys_of(part: Part) -> dict[str, list[str]]:
    """Return the keys of a container: all go in and out.

    SMACH would hand in wrapped what only comes in; and what only goes out would be, where nobody has written it this
    time, the value of the time before.
    """
    keys = list({**reads(part), **writes(part)})
    return {"input_keys": keys, "output_keys": keys} if keys else {}


def set_key(builder: SourceBuilder, userdata: str, name: str, value: object) -> None:
    """Write a value of userdata."""
    plain = name.isidentifier() and not name.startswith("_")
    builder.write(literal(value), f"{userdata}.{name}" if plain else f"{userdata}[{name!r}]")


def tree(builder: SourceBuilder, part: Part, needed: Refined) -> Bracketed:
    """Return the state that ticks a node as GRIP does."""
    document = _ordered(part.node.model_dump(by_alias=True, exclude_unset=True, mode="json", exclude={"on", "x"}))
    used = {**reads(part), **writes(part)}
    more: dict[str, object] = {}
    if used:
        more["variables"] = {name: cell.type for name, cell in used.items()}
    if dict(part.meaning) != _PLAIN:
        more["outcomes"] = dict(part.meaning)
    if needed:
        more["codes"] = [f"{outcome}.{code}" for outcome, code in sorted(needed)]
    if not isinstance(part.node, model.Leaf):
        builder.trees[part.path] = part.node.kind
    for below in part.walk():
        if below.manifest is not None and isinstance(below.node, model.Leaf):
            builder.nodes[below.manifest.id] = None
    return call("BehaviourTree.of_node", document, Raw("run"), place=part.path, **more)


def _ordered(document: dict[str, Any]) -> dict[str, Any]:
    """Return a node's keys with what it is first and its children last, as task files have them."""
    first: dict[str, Any] = {key: document[key] for key in ("doc", "kind", "node", "task") if key in document}
    below: dict[str, Any] = {}
    for key in ("child", "children"):
        if key in document:
            below[key] = {name: _ordered(node) for name, node in document[key].items()}
    return {**first, **{key: value for key, value in document.items() if key not in {*first, *below}}, **below}


def legacy(builder: SourceBuilder, part: Part) -> Raw:
    """Return the expression that makes a legacy state."""
    state = legacy_state(part)
    assert state is not None, "this form is for legacy states"
    own = ast.parse(ast.unparse(state.source), mode="eval").body  # a copy, which is changed
    made = _Renaming(builder, state.modules).visit(own)
    return Raw(ast.unparse(ast.fix_missing_locations(made)))


class _Renaming(ast.NodeTransformer):
    """Gives legacy modules, and the machines that they build, their names in the file."""

    def __init__(self, builder: SourceBuilder, modules: Mapping[str, Path]):
        self.builder, self.modules = builder, modules

    def visit_Name(self, node: ast.Name) -> ast.expr:
        file = self.modules.get(node.id)
        if file is None:
            return node
        if file not in self.builder.modules:
            self.builder.modules[file] = self.builder.identifiers.take(file.stem)
        return ast.Name(self.builder.modules[file], ast.Load())

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        match node.value:
            case ast.Attribute(ast.Name(module), "smach") if module in self.modules:
                return ast.Attribute(ast.Name("smach", ast.Load()), node.attr, ast.Load())
        self.generic_visit(node)
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        match node:
            case ast.Call(ast.Attribute(ast.Name("self"), "built"), [factory, *arguments], keywords):
                made = ast.unparse(ast.Call(factory, arguments, keywords))
                if made not in self.builder.built:
                    self.builder.built[made] = self.builder.identifiers.take("legacy_machine")
                return ast.Name(self.builder.built[made], ast.Load())
        return node
