"""Task -> py_trees' XML. A leaf's tag is its catalogue id with a dot for the slash: `<arm.lift>`.

py_trees builds the tree of such a file when it is given a class for each of these tags.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.formats.blackboard import text_of_value
from grip_bt.formats.xml_trees import comment, leaf_attributes, require_expressible, xml_element, xml_text
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

_TARGET = "py_trees' XML"
_PLAIN = {"success": "success", "failure": "failure"}
_HIDDEN = "__DOT__"
"""What py_trees writes for a dot in a constant; a text that holds it would come back changed."""
_COMMON = {"doc", "on", "x", "kind", "children", "child", "exits"}
_KEYS: dict[type, set[str]] = {
    model.Leaf: {"node", "with_", "in_", "out"},
    model.Sequence: {"memory"},
    model.Fallback: {"memory"},
    model.Parallel: {"policy", "cancel"},
    model.Retry: {"times"},
    model.Repeat: {"times"},
    model.Timeout: {"seconds", "child_first"},
    model.Guard: {"if_"},
    model.Invert: set(),
    model.Force: {"as_"},
}


def to_xml(task: model.Task, catalog: Catalog) -> str:
    """Return a file that py_trees 2.6 reads as the tree of a task.

    Args:
        task: the document. `doc` becomes comments; free data (`x-*`) isn't written.
        catalog: where the leaves' manifests are.

    Raises:
        InvalidTaskError: the task is wrong.
        NotExpressibleError: the XML has no words for a part of it.
    """
    resolved = resolve(task, catalog)
    _check_task(resolved)
    root = ET.Element("root", main_tree_to_execute=task.name)
    root.extend(comment(task.doc))
    tree = ET.SubElement(root, "BehaviorTree", ID=task.name)
    tree.extend(comment(task.root.doc))
    tree.append(xml_element(resolved.root, _element, comments=True))
    return xml_text(root)


def _text(value: object, type_name: str) -> str:
    text = text_of_value(value, type_name, as_json=False)
    if _HIDDEN in text or "{" in text or "}" in text:
        raise ValueError(f"{value!r} would come back as something else")
    return text


def _check_task(resolved: Resolved) -> None:
    task = resolved.task
    try:
        _text(task.name, "str")
    except ValueError as error:
        raise NotExpressibleError("/", f"the task's name ({error})", _TARGET) from error
    if dict(task.outcomes) != _PLAIN or any(target != label for (_, label, _), target in resolved.ends):
        raise NotExpressibleError("/", "a task with outcomes of its own", _TARGET)
    for name, variable in task.data.items():
        if not isinstance(variable, str) and variable.has_value:
            raise NotExpressibleError("/", f"the initial value of the variable {name!r}", _TARGET)


def _element(part: Part) -> tuple[str, dict[str, str]]:
    require_expressible(part.path, part.node, _KEYS, _TARGET, _COMMON)
    tag, attributes = _tag_of(part)
    return tag, {"name": part.name, **attributes}


def _tag_of(part: Part) -> tuple[str, dict[str, str]]:
    node = part.node
    if not isinstance(node, model.Parallel) and part.exits:
        raise NotExpressibleError(part.path, "`exits`", _TARGET)
    match node:
        case model.Leaf():
            if both := node.in_.keys() & node.out.keys():
                what = f"{min(both)!r}, which is more than one port or parameter,"
                raise NotExpressibleError(part.path, what, _TARGET)
            return node.node.replace("/", "."), leaf_attributes(part, node, _text, _TARGET)
        case model.Sequence(memory=memory):
            return "Sequence", {"memory": str(memory).lower()}
        case model.Fallback(memory=memory):
            return "Selector", {"memory": str(memory).lower()}
        case model.Parallel():
            return "Parallel", {"policy": _policy(part, node)}
        case model.Retry(times=attempts):
            return ("FailureIsRunning", {}) if attempts is None else ("Retry", {"num_failures": str(attempts)})
        case model.Repeat(times=times):
            return "Repeat", {"num_success": str(-1 if times is None else times)}
        case model.Timeout(seconds=seconds, child_first=True):
            return "Timeout", {"duration": str(seconds)}
        case model.Timeout():
            what = "a timeout that looks at the clock before its child (py_trees' looks after it: `child_first: true`)"
            raise NotExpressibleError(part.path, what, _TARGET)
        case model.Guard(if_="true"):
            return "PassThrough", {}
        case model.Guard():
            raise NotExpressibleError(part.path, "a guard", _TARGET)
        case model.Invert():
            return "Inverter", {}
        case model.Force(as_=forced):
            return ("FailureIsSuccess" if forced == "success" else "SuccessIsFailure"), {}
    raise AssertionError(f"{type(node).__name__} passed the list of kinds and has no tag")


def _policy(part: Part, node: model.Parallel) -> str:
    if (node.policy, node.cancel) == ("all", "halt") and not part.exits:
        return "success_on_all"
    # py_trees' other policy fails with the first child that fails, which is an exit here.
    failing = {
        ((child.name, label, None), "failure")
        for child in part.children
        for label, means in child.meaning.items()
        if means == "failure"
    }
    if (node.policy, node.cancel) == ("any", "halt") and set(part.exits) == failing:
        return "success_on_one"
    raise NotExpressibleError(part.path, "this parallel, which matches no py_trees policy,", _TARGET)
