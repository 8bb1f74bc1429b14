"""How the file makes each leaf: grip's own with their manifest, behaviours of py_trees as they are."""

from __future__ import annotations

import ast
import copy
import keyword
import os
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import cast

from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.expression import CONSTANTS, parse_expression
from grip_bt.base.python_literals import py
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.formats.python_source import WIDTH, Bracketed, Raw, call, flat, literal, statement
from grip_bt.formats.standalone.builder import TARGET
from grip_bt.task import model
from grip_bt.task.catalog import AllowedImports, Catalog, Manifest
from grip_bt.task.catalog.source_code import line_of, source_of

from .builder import ModuleBuilder

_EQUAL = {*("flow/wait", "flow/succeed", "flow/fail", "flow/log"), *("flow/set", "flow/compute", "flow/count")}
"""Nodes of grip that have an equivalent without it."""
_PLAIN = {"success": "success", "failure": "failure"}


def initial(value: object, builder: ModuleBuilder) -> object:
    """Return an initial value of a variable; a value that is grip's own, such as a pose, is made of its fields."""
    value = value.tolist() if hasattr(value, "tolist") else value  # of an array
    if isinstance(value, list | tuple):
        return [initial(item, builder) for item in value]
    if isinstance(value, Mapping):
        return {key: initial(item, builder) for key, item in value.items()}
    if not is_dataclass(value):
        return value
    held = {field.name: initial(getattr(value, field.name), builder) for field in fields(value)}
    return call(_class_name("grip_bt.base.values", type(value).__name__, builder), **held)


def needs_grip(resolved: Resolved) -> bool:
    """Tell whether some leaf is grip's, which needs its manifest and the run's context."""
    return any(
        not _has_equal(part, part.manifest) and not is_plain(part.manifest)
        for part in resolved.root.walk()
        if part.manifest is not None
    )


def _has_equal(part: Part, manifest: Manifest) -> bool:
    limited = isinstance(part.node, model.Leaf) and part.node.with_.get("limit") is not None
    return manifest.id in _EQUAL and not limited  # a limit is an outcome more


def leaf(part: Part, builder: ModuleBuilder, builtin: Catalog) -> Bracketed:
    """Return what makes a leaf. Raises NotExpressibleError: it is py_trees' own and the task changes what it means."""
    node, manifest = cast(model.Leaf, part.node), cast(Manifest, part.manifest)
    parameters = {k: p.default for k, p in manifest.parameters.items() if not p.required} | dict(node.with_)
    if not builder.grip and _has_equal(part, manifest) and not node.meaning:
        return _equal(part, builder, parameters)
    if not is_plain(manifest):
        return _grips(part, builder, builtin, parameters)
    if node.in_ or node.out or node.meaning:
        what = f"{manifest.id}, a behaviour of py_trees, with `in`, `out` or `meaning`"
        raise NotExpressibleError(part.path, what, TARGET)
    odd = [name for name in parameters if not name.isidentifier() or keyword.iskeyword(name)]
    if odd:
        raise NotExpressibleError(part.path, f"the parameter {odd[0]!r}, which isn't a name in Python,", TARGET)
    return call(_imported(manifest, builder), part.name, **parameters)


def foreign(part: Part, builder: ModuleBuilder, code: AllowedImports) -> Bracketed:
    """Return the expression that makes somebody's own behaviour, in a node that has the part's name."""
    node = cast(model.Foreign, part.node)
    if node.children or node.built_by or node.in_ or node.out:
        raise NotExpressibleError(part.path, "a behaviour that is part of another tree or of a blackboard,", TARGET)
    module, _, name = node.behaviour.partition(":")
    first, *rest = name.split(".")
    own = {"name": part.name} if takes_name(node.behaviour, code) else {}
    made = call(".".join((_class_name(module, first, builder), *rest)), **{**own, **node.args})
    if builder.codes:
        builder.parts.add("foreign")
    return call("Foreign" if builder.codes else "py_trees.decorators.PassThrough", part.name, made)


def _equal(part: Part, builder: ModuleBuilder, parameters: dict[str, object]) -> Bracketed:
    node = cast(model.Leaf, part.node)
    match node.node:
        case "flow/succeed":
            return call("py_trees.behaviours.Success", part.name)
        case "flow/wait":
            return call("py_trees.timers.Timer", part.name, duration=parameters["seconds"])
        case "flow/fail" if not builder.codes:
            return call("py_trees.behaviours.Failure", part.name)
        case "flow/fail":
            builder.parts.add("fail")
            return call("Fail", part.name, code=parameters["code"])
        case "flow/set" | "flow/compute" | "flow/count":
            return _assigned(part, node, builder, parameters)
    builder.parts.add("log")
    value = {"value": Raw(f"{builder.visible(part)[node.in_['value']]}.get")} if "value" in node.in_ else {}
    return call("Log", part.name, message=parameters["message"], **value)


def _assigned(part: Part, node: model.Leaf, builder: ModuleBuilder, parameters: dict[str, object]) -> Bracketed:
    """Return what gives a variable a literal, the value of an expression over inputs, or one more than it had."""
    builder.parts |= {"assign", "variable"}
    variables = builder.visible(part)
    seen = {port: variables[variable] for port, variable in node.in_.items()}
    match node.node:
        case "flow/set":
            body = f"copy.deepcopy({flat(literal(parameters['value']))})"
        case "flow/compute":
            body = _python(str(parameters["expression"]), seen)
        case _:
            before = f"({seen['count']}.get() or 0)" if "count" in node.in_ else "0"
            body = f"{before} + {parameters['step']}"
    written = [Raw(variables[variable]) for variable in node.out.values()]
    return call("Assign", part.name, _function(body, "Any", f"value_of_{part.name}", builder), *written)


def _grips(part: Part, builder: ModuleBuilder, builtin: Catalog, parameters: dict[str, object]) -> Bracketed:
    node, manifest = cast(model.Leaf, part.node), cast(Manifest, part.manifest)
    known = manifest.id in builtin and builtin.get(manifest.id) == manifest
    builder.builtin = builder.builtin or known
    if not known and manifest.id not in builder.manifests:
        builder.manifests[manifest.id] = builder.identifiers.take(manifest.id.upper().replace("/", "_"))
    face = call("NODES.get", manifest.id) if known else Raw(builder.manifests[manifest.id])
    made = call(_imported(manifest, builder), part.name, part.path, face, parameters, dict(node.meaning))
    if not (node.in_ or node.out):
        return made
    builder.parts |= {"bind", "variable"}
    seen = builder.visible(part)
    inputs, outputs = (
        {port: Raw(seen[variable]) for port, variable in bound.items()} for bound in (node.in_, node.out)
    )
    return call("bind", made, inputs=inputs, outputs=outputs)


def _imported(manifest: Manifest, builder: ModuleBuilder) -> str:
    where, _, name = manifest.implementation.rpartition(":")
    if is_file(manifest):
        return f"load_implementation({builder.manifests[manifest.id]})"
    return _class_name(where, name, builder)


def _class_name(module: str, name: str, builder: ModuleBuilder) -> str:
    classes = builder.imports.setdefault(module, {})
    if name not in classes:
        classes[name] = builder.identifiers.take(name, f"{name}Of{module.rsplit('.', 1)[-1].title()}")
    return classes[name]


def is_file(manifest: Manifest) -> bool:
    """Tell whether the code of a node is a file by its path, and not an importable module."""
    return manifest.implementation.rpartition(":")[0].endswith(".py")


def manifest_text(manifest: Manifest, name: str, folder: Path | None) -> str:
    """Return the assignment of a manifest that isn't grip's own; `folder`: where the file will lie."""
    held = manifest.model_dump(mode="json", exclude_defaults=True)
    where, _, class_name = manifest.implementation.rpartition(":")
    given: dict[str, object] = dict(held)
    if is_file(manifest):
        file = os.path.relpath(Path(where).resolve(), (folder or Path.cwd()).resolve())
        inside = f"{Path(file).as_posix()}:{class_name}".replace("{", "{{").replace("}", "}}")
        given["implementation"] = Raw("f" + py(f"{{HERE}}/{inside}"))
    return statement(name, call("Manifest.model_validate", given), 0)


def is_plain(manifest: Manifest) -> bool:
    """Tell whether a node is a behaviour of py_trees that knows nothing of grip; one that can't be read is grip's."""
    where, _, name = manifest.implementation.rpartition(":")
    if where.partition(".")[0] == "grip_bt":
        return False
    if where.partition(".")[0] == "py_trees":
        return True
    try:
        file = Path(where) if where.endswith(".py") else source_of(where)
    except ModuleNotFoundError:
        return False
    names = [] if file is None else [each for each in line_of(file, name) if isinstance(each, str)]
    return bool(names) and names[0].startswith("py_trees.")


def takes_name(behaviour: str, code: AllowedImports) -> bool:
    """Tell whether a class or function has a parameter `name`; what can't be read has one, as behaviours do."""
    module, _, name = behaviour.partition(":")
    try:
        file = source_of(module, code.folder)
    except ModuleNotFoundError:
        return True
    for each in () if file is None else line_of(file, name):
        makers = [] if isinstance(each, str) else [each.syntax]
        if makers and isinstance(makers[0], ast.ClassDef):
            makers = [m for m in makers[0].body if isinstance(m, ast.FunctionDef) and m.name == "__init__"]
        for maker in makers:
            assert isinstance(maker, ast.FunctionDef | ast.AsyncFunctionDef), "a class was looked into"
            given = maker.args
            return "name" in {a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)}
    return True


def function_of(text: str, part: Part, builder: ModuleBuilder, *, around: bool = False) -> Raw:
    """Return a function that computes a condition: a lambda, or the name of one that is too long for a line."""
    inner = _python(text, builder.visible(part, around=around))
    # What an attribute of a value compares to may be numpy's kind of bool, which py_trees refuses.
    own = any(isinstance(node, ast.Attribute) for node in ast.walk(parse_expression(text).tree))
    return _function(f"bool({inner})" if own else inner, "bool", f"condition_of_{part.name}", builder)


def value_of(text: str, part: Part, builder: ModuleBuilder) -> Raw:
    """Return a function that computes any value, likewise."""
    return _function(_python(text, builder.visible(part)), "Any", f"value_of_{part.name}", builder)


def _function(body: str, returns: str, name: str, builder: ModuleBuilder) -> Raw:
    if len(body) < WIDTH // 2 - 8:
        return Raw(f"lambda: {body}")
    name = builder.identifiers.take(name)
    skip = "  # fmt: skip" if len(body) + len("        return ") > WIDTH else ""
    builder.statements.append(f"\n    def {name}() -> {returns}:\n        return {body}{skip}\n")
    return Raw(name)


def _python(text: str, variables: Mapping[str, str]) -> str:
    tree = copy.deepcopy(parse_expression(text).tree)
    return ast.unparse(ast.fix_missing_locations(_Reading(variables).visit(tree)))


class _Reading(ast.NodeTransformer):
    def __init__(self, variables: Mapping[str, str]):
        self.variables = variables

    def visit_Call(self, node: ast.Call) -> ast.Call:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        """Write `not a in b` as `a not in b`, as people do."""
        match node:
            case ast.UnaryOp(ast.Not(), ast.Compare(ops=[ast.In() | ast.Is() as way]) as inner):
                inner.ops = [ast.NotIn() if isinstance(way, ast.In) else ast.IsNot()]
                return self.generic_visit(inner)
        return self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in CONSTANTS:
            return ast.Constant(CONSTANTS[node.id])
        return ast.Call(ast.Attribute(ast.Name(self.variables[node.id]), "get"), [], [])
