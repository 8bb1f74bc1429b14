"""Task -> BehaviorTree.CPP 4's XML, with a TreeNodesModel of the leaves, so that Groot2 shows them with their ports.

A leaf's tag is its catalogue id with two underscores for the slash: `<arm__lift>`. What is written is read again, and
has to give the same task: what wouldn't is refused by name.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from grip_bt.base.errors import DocumentError, NotExpressibleError
from grip_bt.base.expression import parse_expression
from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.formats.blackboard import text_of_value
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.formats.xml_trees import comment, leaf_attributes, require_expressible, xml_element, xml_text
from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest

from .importer import from_xml
from .lowered import TARGET, Xml, milliseconds, script_of, tag_of, tells, xml
from .lowering import Lowering

_CPP = {"int": "int", "float": "double", "bool": "bool", "str": "std::string", "Any": "BT::AnyTypeAllowed"}
_TOLD = {"outcome": "the label of the end", "code": "why it failed; empty where it didn't"}


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
    with suppress(*_INDIRECT):
        return _as_it_is(resolved, catalog)
    used: dict[str, Manifest] = {}
    return _file(task, Lowering(used).document(resolved), used, lowered=True)


def _file(task: model.Task, body: Xml, used: dict[str, Manifest], lowered: bool = False) -> str:
    root = xml("root", *comment(task.doc), BTCPP_format="4", main_tree_to_execute=task.name)
    root.append(xml("BehaviorTree", body, ID=task.name))
    if used:
        faces = (_face(manifest, lowered) for manifest in sorted(used.values(), key=lambda m: m.id))
        root.append(xml("TreeNodesModel", *faces))
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + xml_text(root)


_INDIRECT = (ValueError, NotExpressibleError, DocumentError, ImportRefusedError)
"""What is raised where no element says the same; then it takes several."""


def _as_it_is(resolved: Resolved, catalog: Catalog) -> str:
    """Return the file whose elements are the nodes of the task, which comes back as it was."""
    task = resolved.task
    variables = [v for v in (*task.inputs.values(), *task.data.values()) if not isinstance(v, str)]
    plain = dict(task.outcomes) == {"success": "success", "failure": "failure"} and not task.outputs
    if not plain or any(target != label for (_, label, _), target in resolved.ends):
        raise ValueError("outcomes or outputs of its own")
    if any(variable.has_value and variable.value is not None for variable in variables):
        raise ValueError("initial values")
    used: dict[str, Manifest] = {}
    text = _file(task, xml_element(resolved.root, lambda part: _described(part, used)), used)
    if _compared(from_xml(text, catalog, "the file that was written").task) != _compared(task):
        raise ValueError("it comes back as another one")
    return text


def _compared(task: model.Task) -> object:
    """Return what has to be the same of a task that came back; its own `doc` is a comment, and may be lost."""
    types = [{n: v if isinstance(v, str) else v.type for n, v in each.items()} for each in (task.inputs, task.data)]
    nodes = {}
    for path, node in model.walk(task.root):
        held = {name: getattr(node, name) for name in type(node).model_fields.keys() - {"order"}}
        held |= {name: list(held[name]) for name in ("children", "child") if name in held}
        held |= {name: _bare(held[name]) for name in ("precondition", "on_value") if held.get(name)}
        if isinstance(node, model.Leaf) and node.node == "flow/compute":
            held["with_"] = {**node.with_, "expression": _bare(node.with_["expression"])}
        nodes[path] = (type(node), held)
    return task.name, types, nodes


def _bare(expression: str) -> str:
    """Return an expression without parentheses that change nothing."""
    return ast.unparse(parse_expression(expression).tree)


def _described(part: Part, used: dict[str, Manifest]) -> tuple[str, dict[str, str]]:
    if type(part.node) not in _ELEMENTS:
        raise ValueError("no element")
    fields, element = _ELEMENTS[type(part.node)]
    require_expressible(part.path, part.node, (*fields, "precondition"), TARGET)
    if not isinstance(part.node, model.Leaf) and not part.children:
        raise ValueError("no children")
    tag, own = _leaf(part, part.node, used) if isinstance(part.node, model.Leaf) else element(part, part.node)
    said = {**({} if part.path == "/" else {"name": part.name}), **own}
    if part.node.precondition and not _is_condition(part):
        said["_failureIf"] = f"!({_script(part, part.node.precondition)})"
    if part.node.doc:
        said["_description"] = part.node.doc
    return tag, said


def _is_condition(part: Part) -> bool:
    node = part.node
    return isinstance(node, model.Leaf) and node.node == "flow/succeed" and bool(node.precondition)


def _script(part: Part, text: str, names: Mapping[str, str] | None = None) -> str:
    def type_of(name: str) -> str:
        cell = part.scope.find(name)
        return cell.type if cell is not None else "Any"

    return script_of(text, type_of, names)


def _computed(part: Part, node: model.Leaf) -> str | None:
    """Return what `flow/compute` does as a script; None where a script would come back as something else."""
    text = node.with_["expression"]
    names = parse_expression(text).names
    if "value" not in node.out or list(node.in_) != list("abcdefgh"[: len(names)]) or list(names) != list(node.in_):
        return None
    with suppress(ValueError):
        return f"{node.out['value']} := {_script(part, text, node.in_)}"
    return None


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
    raise ValueError("no element's rules")


def _switch(part: Part, node: model.Switch) -> tuple[str, dict[str, str]]:
    cases = list(node.cases.values())
    names = [child.name for child in part.children]
    if node.memory or names != [*node.cases, node.default] or not 2 <= len(cases) <= 6:
        raise ValueError("no element's cases")
    said = {"variable": f"{{{node.on_value}}}"}
    for number, case in enumerate(cases, 1):
        if isinstance(case, bool | float) or not isinstance(case, str | int | list):
            raise ValueError(f"the case {case!r}")
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
    if any((port in node.in_) != (port in node.out) for port in both & set(said)):
        raise ValueError("a port of which only one side is bound")
    return tag_of(manifest), said


_Element = Callable[[Part, Any], tuple[str, dict[str, str]]]
_ELEMENTS: dict[type, tuple[tuple[str, ...], _Element]] = {
    model.Leaf: (("node", "with_", "in_", "out"), lambda part, node: ("", {})),
    model.Sequence: (("memory",), lambda part, node: ("Sequence" if node.memory else "ReactiveSequence", {})),
    model.Fallback: (("memory",), lambda part, node: ("Fallback" if node.memory else "ReactiveFallback", {})),
    model.Parallel: (("policy", "rules", "wait_for", "cancel", "prompt", "order"), _parallel),
    model.Retry: (("times",), lambda part, node: ("RetryUntilSuccessful", {"num_attempts": str(node.times or -1)})),
    model.Repeat: (("times",), lambda part, node: ("Repeat", {"num_cycles": str(node.times or -1)})),
    model.Timeout: (("seconds",), lambda part, node: ("Timeout", {"msec": milliseconds(part, node.seconds)})),
    model.Switch: (("on_value", "cases", "default", "memory"), _switch),
    model.Invert: ((), lambda part, node: ("Inverter", {})),
    model.Force: (("as_",), lambda part, node: (f"Force{node.as_.capitalize()}", {})),
}
"""The kinds that have an equivalent: what it can say of them, and the element with its attributes."""


def _face(manifest: Manifest, lowered: bool) -> Xml:
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
