"""Task -> BehaviorTree.CPP 4's XML, with a TreeNodesModel of the leaves, so that Groot2 shows them with their ports.

A leaf's tag is its catalogue id with two underscores for the slash: `<arm__lift>`. What is written is read again, and
has to give the same task: what wouldn't is refused by name.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

from grip_bt.base.errors import DocumentError, NotExpressibleError
from grip_bt.base.expression import parse_expression
from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.formats.blackboard import text_of_value
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.formats.names import node_name
from grip_bt.formats.xml_trees import comment, leaf_attributes, require_expressible, xml_element, xml_text
from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest

from .importer import from_xml
from .lowered import TARGET, Xml, milliseconds, script_of, tag_of, tells, xml
from .lowering import Lowering

_CPP = {"int": "int", "float": "double", "bool": "bool", "str": "std::string", "Any": "BT::AnyTypeAllowed"}
_TOLD = {"outcome": "the label of the end", "code": "why it failed; empty where it didn't"}
_COMMON = {"doc", "precondition", "kind", "children", "child"}
_KEYS: dict[type, set[str]] = {
    model.Leaf: {"node", "with_", "in_", "out"},
    model.Sequence: {"memory"},
    model.Fallback: {"memory"},
    model.Parallel: {"policy", "rules", "wait_for", "cancel", "prompt", "order"},
    model.Retry: {"times"},
    model.Repeat: {"times"},
    model.Timeout: {"seconds"},
    model.Switch: {"on_value", "cases", "default", "memory"},
    model.Invert: set(),
    model.Force: {"as_"},
}
"""The kinds that have an equivalent, and what it can say of them."""


def to_xml(task: model.Task, catalog: Catalog) -> str:
    """Return a file that BehaviorTree.CPP 4 and Groot2 read as the tree of a task.

    Args:
        task: the document. Its own `doc` becomes a comment, that of nodes `_description`.
        catalog: where the leaves' manifests are.

    Raises:
        InvalidTaskError: the task is wrong.
        NotExpressibleError: the XML has no words for a part of it.
    """
    resolved = resolve(task, catalog)
    try:
        return _as_it_is(resolved, catalog)
    except NotExpressibleError:
        used: dict[str, Manifest] = {}
        return _file(task, Lowering(used).document(resolved), used, lowered=True)


def _file(task: model.Task, body: Xml, used: dict[str, Manifest], lowered: bool = False) -> str:
    root = xml("root", *comment(task.doc), BTCPP_format="4", main_tree_to_execute=task.name)
    root.append(xml("BehaviorTree", body, ID=task.name))
    if used:
        faces = (_face(manifest, lowered) for manifest in sorted(used.values(), key=lambda m: m.id))
        root.append(xml("TreeNodesModel", *faces))
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + xml_text(root)


def _as_it_is(resolved: Resolved, catalog: Catalog) -> str:
    """Return the file whose elements are the nodes of the task, which comes back as it was."""
    task = resolved.task
    _check_task(resolved)
    used: dict[str, Manifest] = {}
    text = _file(task, xml_element(resolved.root, lambda part: _described(part, used)), used)
    try:
        back = from_xml(text, catalog, "the file that was written").task
    except (DocumentError, ImportRefusedError) as error:
        raise NotExpressibleError("/", f"something ({error})", TARGET) from error
    _check_same(task, back)
    return text


def _check_task(resolved: Resolved) -> None:
    task = resolved.task
    if node_name(task.name) != task.name:
        raise NotExpressibleError("/", f"the name {task.name!r}", TARGET)
    plain = {"success": "success", "failure": "failure"}
    if dict(task.outcomes) != plain or any(target != label for (_, label, _), target in resolved.ends):
        raise NotExpressibleError("/", "a task with outcomes of its own", TARGET)
    if task.outputs:
        raise NotExpressibleError("/", "outputs of a task", TARGET)
    for name, variable in (*task.inputs.items(), *task.data.items()):
        if not isinstance(variable, str) and variable.has_value and variable.value is not None:
            what = f"the initial value of the variable {name!r} (give it by `flow/set`)"
            raise NotExpressibleError("/", what, TARGET)


def _check_same(task: model.Task, back: model.Task) -> None:
    """Refuse the first difference between a task and what came back; the task's own `doc` is a comment, may be lost."""

    def refuse(path: str, what: str, why: str) -> NoReturn:
        raise NotExpressibleError(path, f"{what} ({why})", TARGET)

    one, other = dict(model.walk(task.root)), dict(model.walk(back.root))
    for path, node in one.items():
        if path not in other:
            refuse(path, "its name or place", "it comes back under another")
        there = other[path]
        if type(node) is not type(there):
            one_kind, other_kind = (getattr(each, "kind", "leaf") for each in (node, there))
            refuse(path, f"a {one_kind}", f"it comes back as a {other_kind}")
        for name in type(node).model_fields.keys() - {"order"}:
            a, b = _compared(node, name), _compared(there, name)
            if a != b:
                refuse(path, f"`{name.rstrip('_')}`", f"{a!r} comes back as {b!r}")
    if more := other.keys() - one.keys():
        refuse(min(more), "an additional node", "it comes back with it")
    for kind in ("inputs", "data"):
        said, read = getattr(task, kind), getattr(back, kind)
        for name, variable in said.items():
            if name not in read:
                refuse("/", f"the variable {name!r}", "no node uses it, or only in another way")
            a, b = (v if isinstance(v, str) else v.type for v in (variable, read[name]))
            if a != b:
                refuse("/", f"the type of the variable {name!r}", f"{a} comes back as {b}")
        if extra := [name for name in read if name not in said]:
            refuse("/", f"the variable {extra[0]!r}", f"it comes back among the {kind}")


def _compared(node: model.AnyNode, field: str) -> object:
    value = getattr(node, field)
    if field in ("children", "child"):
        return list(value)
    if field in ("precondition", "on_value") and value:
        return ast.unparse(parse_expression(value).tree)
    if field == "with_" and isinstance(node, model.Leaf) and node.node == "flow/compute":
        return {**value, "expression": ast.unparse(parse_expression(value["expression"]).tree)}
    return value


def _described(part: Part, used: dict[str, Manifest]) -> tuple[str, dict[str, str]]:
    require_expressible(part.path, part.node, _KEYS, TARGET, _COMMON)
    if not isinstance(part.node, model.Leaf) and not part.children:
        raise NotExpressibleError(part.path, f"a {part.node.kind} without children", TARGET)
    tag, own = _element(part, used)
    said = {**({} if part.path == "/" else {"name": part.name}), **own}
    if part.node.precondition and not _is_condition(part):
        said["_failureIf"] = f"!({_script(part, part.node.precondition)})"
    if part.node.doc:
        said["_description"] = part.node.doc
    return tag, said


def _is_condition(part: Part) -> bool:
    node = part.node
    return isinstance(node, model.Leaf) and node.node == "flow/succeed" and bool(node.precondition)


def _type_of(part: Part) -> Callable[[str], str]:
    def type_of(name: str) -> str:
        cell = part.scope.find(name)
        return cell.type if cell is not None else "Any"

    return type_of


def _computed(part: Part, node: model.Leaf) -> str | None:
    """Return what `flow/compute` does as a script; None where a script would come back as something else."""
    text = node.with_["expression"]
    names = parse_expression(text).names
    if "value" not in node.out or list(node.in_) != list("abcdefgh"[: len(names)]) or list(names) != list(node.in_):
        return None
    try:
        return f"{node.out['value']} := {script_of(text, _type_of(part), node.in_)}"
    except ValueError:
        return None


def _script(part: Part, text: str) -> str:
    try:
        return script_of(text, _type_of(part))
    except ValueError as error:
        raise NotExpressibleError(part.path, f"`{text}` ({error})", TARGET) from error


def _element(part: Part, used: dict[str, Manifest]) -> tuple[str, dict[str, str]]:
    node = part.node
    match node:
        case model.Leaf():
            return _leaf(part, node, used)
        case model.Sequence(memory=memory):
            return ("Sequence" if memory else "ReactiveSequence"), {}
        case model.Fallback(memory=memory):
            return ("Fallback" if memory else "ReactiveFallback"), {}
        case model.Parallel():
            return _parallel(part, node)
        case model.Retry(times=attempts):
            return "RetryUntilSuccessful", {"num_attempts": str(-1 if attempts is None else attempts)}
        case model.Repeat(times=times):
            return "Repeat", {"num_cycles": str(-1 if times is None else times)}
        case model.Timeout(seconds=seconds):
            return "Timeout", {"msec": milliseconds(part, seconds)}
        case model.Switch():
            return _switch(part, node)
        case model.Invert():
            return "Inverter", {}
        case model.Force(as_=forced):
            return ("ForceSuccess" if forced == "success" else "ForceFailure"), {}
    raise AssertionError(f"{type(node).__name__} passed the list of kinds and has no tag")


def _parallel(part: Part, node: model.Parallel) -> tuple[str, dict[str, str]]:
    count = len(part.children)
    rules = [rule.model_dump(exclude_defaults=True) for rule in node.rules]
    if node.cancel == "join" and not rules and not node.prompt:
        return "ParallelAll", {"max_failures": "1" if node.policy == "all" else str(count)}
    if (node.prompt, node.policy, node.wait_for, len(rules)) == (True, "all", None, 2):
        successes, failures = (rule.get("at_least", 0) for rule in rules)
        return "Parallel", {"success_count": str(successes), "failure_count": str(failures)}
    if (node.policy, node.cancel, node.wait_for, len(rules), node.prompt) == ("all", "halt", "all", 2, False):
        return "ParallelAll", {"max_failures": str(rules[0].get("at_least", 0))}
    raise NotExpressibleError(part.path, "this parallel (use `prompt` with two rules, or `cancel: join`)", TARGET)


def _switch(part: Part, node: model.Switch) -> tuple[str, dict[str, str]]:
    cases = list(node.cases.values())
    names = [child.name for child in part.children]
    if node.memory or names != [*node.cases, node.default] or not 2 <= len(cases) <= 6:
        what = "this switch (it needs `memory: false`, 2 to 6 cases in order, and a default as the last child)"
        raise NotExpressibleError(part.path, what, TARGET)
    said = {"variable": f"{{{node.on_value}}}"}
    for number, case in enumerate(cases, 1):
        if isinstance(case, bool | float) or not isinstance(case, str | int | list):
            raise NotExpressibleError(part.path, f"the case {case!r}", TARGET)
        said[f"case_{number}"] = str(case[0] if isinstance(case, list) and case else case)
    return f"Switch{len(cases)}", said


def _leaf(part: Part, node: model.Leaf, used: dict[str, Manifest]) -> tuple[str, dict[str, str]]:
    manifest = part.manifest
    assert manifest is not None, "resolved leaves have a manifest"
    if _is_condition(part):
        return "ScriptCondition", {"code": _script(part, node.precondition)}
    if node.node == "flow/succeed":
        return "AlwaysSuccess", {}
    if node.node == "flow/fail" and not node.with_:
        return "AlwaysFailure", {}
    if node.node == "flow/wait":
        return "Sleep", {"msec": milliseconds(part, node.with_["seconds"])}
    if node.node == "flow/set" and node.out and isinstance(node.with_["value"], bool | int | float | str):
        return "Script", {"code": f"{node.out['value']} := {_script(part, repr(node.with_['value']))}"}
    if node.node == "flow/compute" and (code := _computed(part, node)) is not None:
        return "Script", {"code": code}
    used[manifest.id] = manifest
    said = leaf_attributes(part, node, text_of_value, TARGET)
    both = set(manifest.inputs) & set(manifest.outputs)
    for port in both & set(said):
        if (port in node.in_) != (port in node.out):
            raise NotExpressibleError(part.path, f"{port!r}, of which only one side is bound,", TARGET)
    return tag_of(manifest), said


def _face(manifest: Manifest, lowered: bool) -> Xml:
    """Return what a TreeNodesModel says of a leaf."""
    made = xml("Action", ID=tag_of(manifest))
    for name, parameter in manifest.parameters.items():
        default = {}
        if not parameter.required:
            with suppress(ValueError):  # where the default isn't a text, the port is optional all the same
                default["default"] = text_of_value(parameter.default, parameter.type)
        made.append(_port("input_port", name, parameter.type, parameter.doc, **default))
    for name, port in manifest.inputs.items():
        made.append(_port("inout_port" if name in manifest.outputs else "input_port", name, port.type, port.doc))
    for name, output in manifest.outputs.items():
        if name not in manifest.inputs:
            made.append(_port("output_port", name, output.type, output.doc))
    for name in ("outcome", "code") if lowered and tells(manifest) else ():
        made.append(_port("output_port", name, "str", _TOLD[name]))
    return made


def _port(tag: str, name: str, type_name: str, doc: str, **more: str) -> Xml:
    made = xml(tag, name=name, type=_CPP.get(type_name, type_name), **more)
    made.text = doc
    return made
