"""Task -> py_trees' XML. A leaf's tag is its catalogue id with a dot for the slash: `<arm.lift>`.

py_trees builds the tree of such a file when it is given a class for each of these tags.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.sax.saxutils import escape, quoteattr

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from .literals import to_text

_TARGET = "py_trees' XML"
_PLAIN = {"success": "success", "failure": "failure"}
_KINDS = (
    *(model.Leaf, model.Sequence, model.Fallback, model.Parallel, model.Retry, model.Repeat),
    *(model.Timeout, model.Guard, model.Invert, model.Force),
)
_KEYS = {
    *(
        "doc",
        "on",
        "x",
        "kind",
        "children",
        "child",
        "exits",
        "memory",
        "policy",
        "cancel",
        "times",
        "seconds",
        "child_first",
        "as_",
        "if_",
    ),
    *("node", "with_", "in_", "out"),
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
    lines = [f"<root main_tree_to_execute={quoteattr(task.name)}>", f"  <BehaviorTree ID={quoteattr(task.name)}>"]
    lines[1:1] = _comment(task.doc, 1)
    lines += [*_lines(resolved.root, 2), "  </BehaviorTree>", "</root>"]
    return "\n".join(lines) + "\n"


def _check_task(resolved: Resolved) -> None:
    task = resolved.task
    try:
        to_text(task.name, "str")
    except ValueError as error:
        raise NotExpressibleError("/", f"the task's name ({error})", _TARGET) from error
    if dict(task.outcomes) != _PLAIN or any(target != label for (_, label, _), target in resolved.ends):
        raise NotExpressibleError("/", "a task with outcomes of its own", _TARGET)
    for name, variable in task.data.items():
        if not isinstance(variable, str) and variable.has_value:
            raise NotExpressibleError("/", f"the initial value of the variable {name!r}", _TARGET)


def _lines(part: Part, depth: int) -> Iterator[str]:
    _check(part)
    yield from _comment(part.node.doc, depth)
    tag, attributes = _leaf(part) if isinstance(part.node, model.Leaf) else _container(part)
    said = "".join(f" {key}={quoteattr(value)}" for key, value in {"name": part.name, **attributes}.items())
    indent = "  " * depth
    if not part.children:
        yield f"{indent}<{tag}{said}/>"
        return
    yield f"{indent}<{tag}{said}>"
    for child in part.children:
        yield from _lines(child, depth + 1)
    yield f"{indent}</{tag}>"


def _check(part: Part) -> None:
    """Refuse what a node says and the XML can't."""
    if type(part.node) not in _KINDS:
        raise NotExpressibleError(part.path, f"a {getattr(part.node, 'kind', 'leaf')}", _TARGET)
    for name, field in type(part.node).model_fields.items():
        if name not in _KEYS and getattr(part.node, name) != field.get_default(call_default_factory=True):
            raise NotExpressibleError(part.path, f"`{field.alias or name}`", _TARGET)


def _container(part: Part) -> tuple[str, dict[str, str]]:
    node = part.node
    if not isinstance(node, model.Parallel) and part.exits:
        raise NotExpressibleError(part.path, "`exits`", _TARGET)
    match node:
        case model.Sequence(memory=memory):
            return "Sequence", {"memory": str(memory).lower()}
        case model.Fallback(memory=memory):
            return "Selector", {"memory": str(memory).lower()}
        case model.Parallel():
            return "Parallel", {"policy": _policy(part, node)}
        case model.Retry(times=attempts):
            return "Retry", {"num_failures": str(attempts)}
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
    raise NotExpressibleError(part.path, "this parallel, which no policy of py_trees is,", _TARGET)


def _leaf(part: Part) -> tuple[str, dict[str, str]]:
    node, manifest = part.node, part.manifest
    assert isinstance(node, model.Leaf)
    assert manifest is not None, "resolved leaves have a manifest"
    attributes: dict[str, str] = {}
    for name, value in node.with_.items():
        try:
            attributes[name] = to_text(value, manifest.parameters[name].type)
        except ValueError as error:
            raise NotExpressibleError(part.path, f"`{name}` ({error})", _TARGET) from error
    for port, variable in (*node.in_.items(), *node.out.items()):
        if attributes.get(port, f"{{{variable}}}") != f"{{{variable}}}" or (port in node.in_ and port in node.out):
            raise NotExpressibleError(part.path, f"{port!r}, which is more than one port or parameter,", _TARGET)
        attributes[port] = f"{{{variable}}}"
    if {"name", "ID"} & set(attributes):
        raise NotExpressibleError(part.path, "a port or parameter called `name` or `ID`", _TARGET)
    return manifest.id.replace("/", "."), attributes


def _comment(text: str, depth: int) -> list[str]:
    said = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    while "--" in said:
        said = said.replace("--", "- -")
    return [f"{'  ' * depth}<!-- {escape(said)} -->"] if said else []
