"""What keeps a node from being compiled, and conditions bound to the variables of its scope."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from grip_bt.base.errors import ExpressionError, listing, nearest
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.base.issue import Issue
from grip_bt.compilers.scopes import Cell, Scope, Scopes
from grip_bt.nodes.answers import Answers
from grip_bt.nodes.control import Condition
from grip_bt.task.catalog import Manifest
from grip_bt.task.edges import Edges
from grip_bt.task.model import AnyNode, Kind, Leaf, Parallel, Subtask, Task
from grip_bt.task.walking import expressions_of, outcomes_of

if TYPE_CHECKING:
    from grip_bt.compilers.resolve import Part


def check_expressions(path: str, node: AnyNode, around: Scope, own: Scope, problems: list[Issue]) -> None:
    """Every expression of a node can be read, and its variables are there."""
    for key, text in expressions_of(node):
        scope = around if key == "precondition" else own
        try:
            names = parse_expression(text).names
        except ExpressionError as error:
            problems.append(Issue(path, "bad-expression", "error", str(error)))
            continue
        for name in names:
            if scope.find(name) is None:
                there = scope.visible()
                message = f"`{text}` reads {name!r}, which isn't declared here or above{nearest(name, there)}"
                problems.append(Issue(path, "undeclared-variable", "error", f"{message} (there are: {listing(there)})"))


def bind_condition(path: str, key: str, text: str, scope: Scope, scopes: Scopes) -> Condition:
    """Return the condition at `key` of the node at `path`."""
    expression, cells = _cells(text, scope)
    readers = {name: scopes.reader(path, key, cell) for name, cell in cells.items()}

    def watch(written: Callable[[], None]) -> None:
        for cell in cells.values():
            cell.watchers.append(written)

    return Condition(expression.text, condition_of(expression, readers), watch)


def answers_of(part: Part, scopes: Scopes) -> Answers:
    """Return the answers of a run to the kind of a container."""
    assert isinstance(part.node, Kind), "leaves ask nothing"
    answers = Answers(part.path, [child.name for child in part.children], part.exits, part.edges)
    bind_answers(answers, part, part.node, scopes)
    return answers


def bind_answers(answers: Answers, part: Part, kind: Kind, scopes: Scopes) -> None:
    """Bind answers to the cells of the variables that a kind asks for."""
    path, scope = part.path, part.scope
    for key, text in kind.expressions():
        field = next(name for name in (*kind.conditions, *kind.values) if name.rstrip("_") == key)
        if field in kind.conditions:
            answers.conditions[field] = bind_condition(path, key, text, scope, scopes).holds
        else:
            answers.readers[field] = bind_value(path, key, text, scope, scopes)
    for key in kind.reads:
        answers.readers[key] = scopes.reader(path, key, _cell(scope, getattr(kind, key)))
    for key in kind.puts:
        answers.writers[key] = scopes.writer(path, key, _cell(scope, getattr(kind, key)))


def bind_value(path: str, key: str, text: str, scope: Scope, scopes: Scopes) -> Callable[[], Any]:
    """Return what computes the expression at `key` of the node at `path`."""
    expression, cells = _cells(text, scope)
    return value_of(expression, {name: scopes.reader(path, key, cell) for name, cell in cells.items()})


def _cells(text: str, scope: Scope) -> tuple[Expression, dict[str, Cell]]:
    expression = parse_expression(text)
    cells: dict[str, Cell] = {}
    for name in expression.names:
        cells[name] = _cell(scope, name)
    return expression, cells


def _cell(scope: Scope, name: str) -> Cell:
    cell = scope.find(name)
    assert cell is not None, "resolved variables are declared"
    return cell


def problem(path: str, code: str, message: str) -> Issue:
    """Return an issue that keeps a task from being compiled; the codes are those of validation."""
    return Issue(path, code, "error", message)


def check_leaf(path: str, node: Leaf, manifest: Manifest, scope: Scope, problems: list[Issue]) -> None:
    """Parameters, ports and variables of a leaf are there."""
    for name, parameter in manifest.parameters.items():
        if parameter.required and name not in node.with_:
            problems.append(
                problem(path, "missing-parameter", f"{manifest.id} needs `with: {{{name}: ...}}` ({parameter.type})")
            )
    check_ports(path, node, manifest, scope, problems)


def check_ports(path: str, node: Leaf | Subtask, manifest: Manifest, scope: Scope, problems: list[Issue]) -> None:
    """Ports and variables of a leaf or a subtask are there."""
    subtask = isinstance(node, Subtask)
    for port, declared in manifest.inputs.items():
        if declared.required and port not in node.in_ and not (subtask and port in node.with_):
            problems.append(
                problem(path, "missing-input", f"{manifest.id} needs `in: {{{port}: <variable>}}` ({declared.type})")
            )
    for kind, given, allowed in (
        ("input" if subtask else "parameter", node.with_, manifest.inputs if subtask else manifest.parameters),
        ("input", node.in_, manifest.inputs),
        ("output", node.out, manifest.outputs),
        ("outcome", node.meaning, manifest.outcomes),
    ):
        for name in given:
            if name not in allowed:
                problems.append(
                    problem(
                        path,
                        f"unknown-{kind}",
                        f"{manifest.id} has no {kind} {name!r}{nearest(name, allowed)} (there are: {listing(allowed)})",
                    )
                )
    for variable in (*node.in_.values(), *node.out.values()):
        if scope.find(variable) is None:
            there = scope.visible()
            problems.append(
                problem(
                    path,
                    "undeclared-variable",
                    f"no variable {variable!r} is declared here or above{nearest(variable, there)}"
                    f" (there are: {listing(there)})",
                )
            )


def check_edges(
    path: str,
    edges: Edges,
    ends: Mapping[str, Mapping[str, str]],
    outcomes: set[str],
    initial: str | None,
    problems: list[Issue],
) -> None:
    """Edges leave ends that exist, and lead somewhere; in a state machine every end has one.

    Args:
        path: the container.
        edges: its exits, or the edges of a state machine.
        ends: child -> its outcomes and their meaning.
        outcomes: the container's outcomes.
        initial: the first child of a state machine; None for other containers.
        problems: what is found is added here.
    """
    targets = outcomes | set(ends) if initial is not None else outcomes
    for (child, outcome, _), target in edges:
        if child not in ends:
            problems.append(
                problem(
                    path, "unknown-child", f"an exit names {child!r}{nearest(child, ends)} (children: {listing(ends)})"
                )
            )
        elif ends[child] and outcome not in ends[child]:
            problems.append(
                problem(
                    path,
                    "unknown-outcome",
                    f"{child!r} never ends with {outcome!r}{nearest(outcome, ends[child])}"
                    f" (it ends with: {listing(ends[child])})",
                )
            )
        if target not in targets:
            problems.append(
                problem(
                    path,
                    "unknown-target",
                    f"{child}.{outcome} leads to {target!r}{nearest(target, targets)}"
                    f" (allowed: {listing(sorted(targets))})",
                )
            )
    if initial is None:
        return
    if initial not in ends:
        problems.append(
            problem(
                path,
                "unknown-child",
                f"initial {initial!r} isn't a child{nearest(initial, ends)} (children: {listing(ends)})",
            )
        )
    for child, labels in ends.items():
        for outcome in labels:
            if edges.target(child, outcome) is None:
                problems.append(
                    problem(
                        path,
                        "missing-target",
                        f"{child!r} may end with {outcome!r}, which leads nowhere; add it to `on:` of {child!r}",
                    )
                )


def check_rules(path: str, node: Parallel, ends: Mapping[str, Mapping[str, str]], problems: list[Issue]) -> None:
    """Rules of a parallel are about ends that its children have, and lead to its outcomes."""
    waited = node.wait_for if isinstance(node.wait_for, list) else []
    for child in (*waited, *(child for rule in node.rules for child in rule.when)):
        if child not in ends:
            problems.append(problem(path, "unknown-child", f"a rule names {child!r}{nearest(child, ends)}"))
    for rule in node.rules:
        if rule.then not in outcomes_of(node):
            problems.append(problem(path, "unknown-target", f"a rule leads to {rule.then!r}, which isn't an outcome"))
        for child, said in rule.when.items():
            for label in [said] if isinstance(said, str) else said:
                if ends.get(child) and label.partition(".")[0] not in ends[child]:
                    problems.append(problem(path, "unknown-outcome", f"{child!r} never ends with {label!r}"))


def check_root(task: Task, meaning: Mapping[str, str], problems: list[Issue], path: str = "/") -> dict[str, str]:
    """Return where each end of the root leads; what `on:` doesn't map keeps its label, or else goes by its meaning.

    Args:
        task: the document.
        meaning: each outcome of its root -> success or failure.
        problems: what is found is added here.
        path: the root's path.
    """
    on = dict(task.root.on)
    for label, target in on.items():
        if label.split(".", 1)[0] not in meaning and meaning:
            problems.append(
                problem(
                    path, "unknown-outcome", f"the root never ends with {label!r} (it ends with: {listing(meaning)})"
                )
            )
        if target not in task.outcomes:
            problems.append(
                problem(
                    path,
                    "unknown-target",
                    f"{label!r} leads to {target!r}{nearest(target, task.outcomes)}"
                    f" (the task's outcomes: {listing(task.outcomes)})",
                )
            )
    for outcome, means in meaning.items():
        if outcome not in on:
            found = next((t for t in (outcome, means) if t in task.outcomes), None)
            if found is None:
                problems.append(
                    problem(
                        path,
                        "missing-target",
                        f"the root may end with {outcome!r}, which leads to no outcome of the task;"
                        " add it to `on:` of the root",
                    )
                )
            else:
                on[outcome] = found
    return on
