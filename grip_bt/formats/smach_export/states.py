"""The expressions of states: legacy ones by their own source, everything else as a tree that one state ticks."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.resolve import Part
from grip_bt.task import model

from ..standalone.layout import Code, Items, call
from .keys import reads, writes
from .legacy import legacy_state
from .plan import Plan

_PLAIN = {"success": "success", "failure": "failure"}


def tree(plan: Plan, part: Part, needed: Refined) -> Items:
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
        plan.trees[part.path] = part.node.kind
    for below in part.walk():
        if below.manifest is not None and isinstance(below.node, model.Leaf):
            plan.nodes[below.manifest.id] = None
    return call("BehaviourTree.of_node", document, Code("run"), place=part.path, **more)


def _ordered(document: dict[str, Any]) -> dict[str, Any]:
    """Return a node's keys with what it is first and its children last, as task files have them."""
    first: dict[str, Any] = {key: document[key] for key in ("doc", "kind", "node", "task") if key in document}
    below: dict[str, Any] = {}
    for key in ("child", "children"):
        if key in document:
            below[key] = {name: _ordered(node) for name, node in document[key].items()}
    return {**first, **{key: value for key, value in document.items() if key not in {*first, *below}}, **below}


def legacy(plan: Plan, part: Part) -> Code:
    """Return the expression that makes a legacy state."""
    state = legacy_state(part)
    assert state is not None, "this form is for legacy states"
    own = ast.parse(ast.unparse(state.source), mode="eval").body  # a copy, which is changed
    made = _Renaming(plan, state.modules).visit(own)
    return Code(ast.unparse(ast.fix_missing_locations(made)))


class _Renaming(ast.NodeTransformer):
    """Gives legacy modules, and the machines that they build, their names in the file."""

    def __init__(self, plan: Plan, modules: Mapping[str, Path]):
        self.plan, self.modules = plan, modules

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Name a module."""
        file = self.modules.get(node.id)
        if file is None:
            return node
        if file not in self.plan.modules:
            self.plan.modules[file] = self.plan.identifiers.take(file.stem)
        return ast.Name(self.plan.modules[file], ast.Load())

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """Name smach itself, which the file imports too."""
        match node.value:
            case ast.Attribute(ast.Name(module), "smach") if module in self.modules:
                return ast.Attribute(ast.Name("smach", ast.Load()), node.attr, ast.Load())
        self.generic_visit(node)
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Name what is built once."""
        self.generic_visit(node)
        match node:
            case ast.Call(ast.Attribute(ast.Name("self"), "built"), [factory, *arguments], keywords):
                made = ast.unparse(ast.Call(factory, arguments, keywords))
                if made not in self.plan.built:
                    self.plan.built[made] = self.plan.identifiers.take("legacy_machine")
                return ast.Name(self.plan.built[made], ast.Load())
        return node
