"""Outcomes: where they lead, what nothing leads to, and what is never reached."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from grip_bt.base.errors import listing, nearest
from grip_bt.base.evaluation import same_literal
from grip_bt.task import Parallel, StateMachine, Switch, Task
from grip_bt.task.model import Childless, default_outcome
from grip_bt.task.validation.possible import PossibleOutcomes

from .analysis import PlacedNode, TaskAnalysis
from .codes import suggestion


def check_outcomes(analysis: TaskAnalysis, possible: PossibleOutcomes | None) -> None:
    """Find ends that lead nowhere, targets that don't exist, outcomes that nothing leads to and impossible ones."""
    for placed in analysis.nodes:
        node = placed.node
        if node.precondition and placed.outcomes.get("failure") == "success":
            message = "a precondition that is false ends the node with `failure`, which means success here"
            fix = "give the outcome that means success another name"
            analysis.add(placed.path, "precondition", "contradictory-outcome", message, fix)
        if isinstance(node, StateMachine):
            _machine(analysis, placed, node)
        elif not isinstance(node, Childless):
            if not placed.children:
                message = f"a {node.kind} without children does nothing"
                analysis.add(placed.path, "children", "empty-container", message, "add a child, or remove it")
            if isinstance(node, Switch):
                _cases(analysis, placed, node)
            for name in ("success", "failure"):
                if node.outcomes.get(name, name) != name:
                    message = f"the outcome {name!r} can't mean {node.outcomes[name]}"
                    analysis.add(
                        placed.path, ("outcomes", name), "contradictory-outcome", message, "give it another name"
                    )
            _exits(analysis, placed, node.exits, possible)
            rules = node.rules if isinstance(node, Parallel) else []
            targets = (*node.exits.values(), *(rule.then for rule in rules))
            _unused(analysis, placed.path, node.outcomes, targets, "`exits`")
        if placed.node.on and placed.parent is not None and not placed.in_machine:
            message = f"`on` stands only in children of a state_machine and in the root; {placed.parent.path} isn't one"
            fix = f"write `exits: {{{placed.name}.<outcome>: ...}}` in {placed.parent.path}, or make it a state_machine"
            analysis.add(placed.path, "on", "misplaced-on", message, fix)
    _root(analysis, analysis.task)


def _cases(analysis: TaskAnalysis, placed: PlacedNode, node: Switch) -> None:
    for key, names in (("cases", [*node.cases]), ("default", [node.default] if node.default else [])):
        for name in names:
            if name not in placed.children:
                where, message = (key, name) if key == "cases" else key, f"`{key}` names no child: {name!r}"
                analysis.unknown(placed.path, where, "unknown-child", message, name, placed.children)
    seen: list[tuple[str, object]] = []
    for child, literal in node.literals():
        earlier = next((name for name, other in seen if same_literal(other, literal)), None)
        if earlier is not None:
            message = f"{literal!r} is a case of {earlier!r} and again of {child!r}"
            analysis.add(placed.path, ("cases", child), "ambiguous-case", message, "leave it in one of them")
        seen.append((child, literal))


def _exits(
    analysis: TaskAnalysis, placed: PlacedNode, exits: Mapping[str, str], possible: PossibleOutcomes | None
) -> None:
    for key, target in exits.items():
        child_name, _, label = key.partition(".")
        where = ("exits", key)
        child = placed.children.get(child_name)
        if child is None or not label:
            message = f"exits are `child.outcome: exit`; {key!r} names no child"
            analysis.unknown(placed.path, where, "unknown-child", message, child_name, placed.children)
        elif check_label(analysis, placed.path, where, child, label):
            if possible is not None and label.partition(".")[0] not in possible.labels(child):
                message = f"{child_name!r} never ends with {label!r}"
                analysis.add(placed.path, where, "impossible-outcome", message, "remove this exit")
        if target not in placed.outcomes:
            unknown_target(analysis, placed.path, where, target, placed.outcomes, "outcomes of this container")


def check_label(analysis: TaskAnalysis, path: str, where: tuple[str | int, ...], child: PlacedNode, label: str) -> bool:
    """Check `outcome` or `outcome.code` of a child; tell whether there is such an outcome."""
    outcome, dot, code = label.partition(".")
    if outcome not in child.outcomes:
        message = f"{child.name!r} has no outcome {outcome!r}"
        analysis.unknown(path, where, "unknown-outcome", message, outcome, child.outcomes, "remove it")
        return False
    if dot and child.outcomes[outcome] == "success":
        analysis.add(path, where, "unknown-code", f"{outcome!r} is a success, which has no failure code", "remove it")
    elif dot and child.codes is not None and code not in child.codes:
        known = sorted(child.codes)
        hint = nearest(code, known)
        message = f"{child.name!r} never fails with {code!r}{hint} (its codes: {listing(known)})"
        analysis.add(path, where, "unknown-code", message, suggestion(hint, "remove it"))
    return True


def _machine(analysis: TaskAnalysis, placed: PlacedNode, node: StateMachine) -> None:
    if node.initial not in placed.children:
        message = f"`initial` names no child: {node.initial!r}"
        analysis.unknown(placed.path, "initial", "unknown-child", message, node.initial, placed.children)
    targets: list[str] = []
    for child in placed.children.values():
        targets.extend(child.node.on.values())
        for label, target in child.node.on.items():
            check_label(analysis, child.path, ("on", label), child, label)
            _machine_target(analysis, placed, child, label, target)
        for outcome in child.outcomes:
            if outcome not in child.node.on and child.outcomes:
                codes = [key for key in child.node.on if key.startswith(f"{outcome}.")]
                only = f"; {listing(codes)} covers only failures with that code" if codes else ""
                message = f"its outcome {outcome!r} isn't connected{only}"
                fix = f"add `{outcome}: <sibling or outcome>` to its `on`"
                analysis.add(child.path, ("on", outcome), "missing-target", message, fix)
    if not set(node.outcomes).isdisjoint(targets):  # or else it is endless, which is said by another rule
        _unused(analysis, placed.path, node.outcomes, targets, "`on` of a child")


def _machine_target(analysis: TaskAnalysis, placed: PlacedNode, child: PlacedNode, label: str, target: str) -> None:
    sibling, outcome = target in placed.children, target in placed.outcomes
    where = ("on", label)
    if sibling and outcome:
        message = f"{target!r} is both a sibling and an outcome of {placed.path}"
        analysis.add(child.path, where, "ambiguous-target", message, "rename one of them")
    elif not sibling and not outcome:
        allowed = (*placed.children, *placed.outcomes)
        unknown_target(analysis, child.path, where, target, allowed, "siblings and outcomes")


def unknown_target(
    analysis: TaskAnalysis, path: str, where: tuple[str | int, ...], target: str, allowed: Iterable[str], kind: str
) -> None:
    """Note a target that isn't among what is allowed."""
    hint = nearest(target, allowed)
    message = f"{where[-1]!r} leads to {target!r}, which isn't there{hint} ({kind}: {listing(allowed)})"
    analysis.add(path, where, "unknown-target", message, suggestion(hint, ""))


def _unused(analysis: TaskAnalysis, path: str, outcomes: Iterable[str], targets: Iterable[str], where: str) -> None:
    used = set(targets)
    for outcome in outcomes:
        if outcome not in used and not (outcome in ("success", "failure") and where == "`exits`"):
            message = f"outcome {outcome!r} is never used"
            analysis.add(path, ("outcomes", outcome), "unused-outcome", message, f"lead to it in {where}, or remove it")


def _root(analysis: TaskAnalysis, task: Task) -> None:
    root, targets = analysis.root, [*task.root.on.values()]
    for label, target in task.root.on.items():
        check_label(analysis, "/", ("on", label), root, label)
        if target not in task.outcomes:
            unknown_target(analysis, "/", ("on", label), target, task.outcomes, "outcomes of the task")
    for outcome, meaning in root.outcomes.items():
        if outcome in task.root.on:
            continue
        if (by_itself := default_outcome(task, outcome, meaning)) is not None:
            targets.append(by_itself)
        else:
            message = f"the root may end with {outcome!r}, which leads to no outcome of the task"
            fix = f"add `{outcome}: <one of {listing(task.outcomes)}>` to the root's `on`"
            analysis.add("/", ("on", outcome), "missing-target", message, fix)
    _unused(analysis, "", task.outcomes, targets, "`on` of the root")


def check_reach(analysis: TaskAnalysis, possible: PossibleOutcomes) -> None:
    """Find children that nothing leads to, state machines that can't end, and children from which no end is reached."""
    for placed in possible.unreached:
        assert placed.parent is not None
        how = (
            "no `on` leads to it"
            if isinstance(placed.parent.node, StateMachine)
            else "an earlier child always ends its container first"
        )
        analysis.add(placed.path, None, "unreachable-node", f"it is never reached: {how}", "lead to it, or remove it")
    for placed in analysis.containers:
        if isinstance(placed.node, StateMachine) and placed.node.initial in placed.children:
            _ends(analysis, placed, placed.node, possible)


def _ends(analysis: TaskAnalysis, placed: PlacedNode, node: StateMachine, possible: PossibleOutcomes) -> None:
    edges = {
        name: [t for label, t in child.node.on.items() if label.partition(".")[0] in possible.labels(child)]
        for name, child in placed.children.items()
    }
    back: dict[str, list[str]] = {}
    for source, targets in edges.items():
        for target in targets:
            back.setdefault(target, []).append(source)
    ending = {name for outcome in node.outcomes for name in _reachable(outcome, back)}
    if node.initial not in ending:
        message = "it can't end: no path from `initial` leads to one of its outcomes"
        analysis.add(placed.path, "outcomes", "endless-machine", message, "let `on` of a child lead to an outcome")
        return
    reached = _reachable(node.initial, edges)
    for name, child in placed.children.items():
        if name in reached and name not in ending and edges[name]:
            message = f"{placed.path} can't end once it is reached"
            analysis.add(child.path, "on", "dead-end", message, "let a path from here lead to an outcome")


def _reachable(start: str, edges: Mapping[str, list[str]]) -> set[str]:
    """Return everything that can be reached from `start`, itself included."""
    seen, stack = {start}, [start]
    while stack:
        for target in edges.get(stack.pop(), ()):
            if target not in seen:
                seen.add(target)
                stack.append(target)
    return seen
