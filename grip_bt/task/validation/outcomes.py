"""Outcomes: where they lead, what nothing leads to, and what is never reached."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from grip_bt.base.errors import listing, nearest
from grip_bt.base.evaluation import same_literal
from grip_bt.task import Parallel, StateMachine, Switch, Task
from grip_bt.task.model import Childless

from .codes import default_outcome, suggestion
from .possible import Possible, machine_edges, reachable
from .survey import Spot, Survey


def check_outcomes(survey: Survey, possible: Possible | None) -> None:
    """Find ends that lead nowhere, targets that don't exist, outcomes that nothing leads to and impossible ones."""
    for spot in survey.spots:
        node = spot.node
        if node.precondition and spot.outcomes.get("failure") == "success":
            survey.add(
                spot.path,
                "precondition",
                "contradictory-outcome",
                "a precondition that is false ends the node with `failure`, which means success here",
                "give the outcome that means success another name",
            )
        if isinstance(node, StateMachine):
            _machine(survey, spot, node)
        elif not isinstance(node, Childless):
            if not spot.children:
                survey.add(
                    spot.path,
                    "children",
                    "empty-container",
                    f"a {node.kind} without children does nothing",
                    "add a child, or remove it",
                )
            if isinstance(node, Switch):
                _cases(survey, spot, node)
            _reserved(survey, spot, node.outcomes)
            _exits(survey, spot, node.exits, possible)
            rules = node.rules if isinstance(node, Parallel) else []
            targets = (*node.exits.values(), *(rule.then for rule in rules))
            _unused(survey, spot.path, node.outcomes, targets, "`exits`")
        if spot.node.on and spot.parent is not None and not spot.in_machine:
            survey.add(
                spot.path,
                "on",
                "misplaced-on",
                f"`on` stands only in children of a state_machine and in the root; {spot.parent.path} isn't one",
                f"write `exits: {{{spot.name}.<outcome>: ...}}` in {spot.parent.path}, or make it a state_machine",
            )
    _root(survey, survey.task)


def _cases(survey: Survey, spot: Spot, node: Switch) -> None:
    for key, names in (("cases", [*node.cases]), ("default", [node.default] if node.default else [])):
        for name in names:
            if name not in spot.children:
                where, message = (key, name) if key == "cases" else key, f"`{key}` names no child: {name!r}"
                survey.unknown(spot.path, where, "unknown-child", message, name, spot.children)
    seen: list[tuple[str, object]] = []
    for child, literal in node.literals():
        earlier = next((name for name, other in seen if same_literal(other, literal)), None)
        if earlier is not None:
            survey.add(
                spot.path,
                ("cases", child),
                "ambiguous-case",
                f"{literal!r} is a case of {earlier!r} and again of {child!r}",
                "leave it in one of them",
            )
        seen.append((child, literal))


def _reserved(survey: Survey, spot: Spot, outcomes: Mapping[str, str]) -> None:
    for name in ("success", "failure"):
        if outcomes.get(name, name) != name:
            survey.add(
                spot.path,
                ("outcomes", name),
                "contradictory-outcome",
                f"the outcome {name!r} can't mean {outcomes[name]}",
                "give it another name",
            )


def _exits(survey: Survey, spot: Spot, exits: Mapping[str, str], possible: Possible | None) -> None:
    for key, target in exits.items():
        child_name, _, label = key.partition(".")
        where = ("exits", key)
        child = spot.children.get(child_name)
        if child is None or not label:
            hint = nearest(child_name, spot.children)
            survey.add(
                spot.path,
                where,
                "unknown-child",
                f"exits are `child.outcome: exit`; {key!r} names no child{hint} (available: {listing(spot.children)})",
            )
        elif check_label(survey, spot.path, where, child, label):
            if possible is not None and label.partition(".")[0] not in possible.labels(child):
                survey.add(
                    spot.path,
                    where,
                    "impossible-outcome",
                    f"{child_name!r} never ends with {label!r}",
                    "remove this exit",
                )
        if target not in spot.outcomes:
            unknown_target(survey, spot.path, where, target, spot.outcomes, "outcomes of this container")


def check_label(survey: Survey, path: str, where: tuple[str | int, ...], child: Spot, label: str) -> bool:
    """Check `outcome` or `outcome.code` of a child; tell whether there is such an outcome."""
    outcome, dot, code = label.partition(".")
    if outcome not in child.outcomes:
        message = f"{child.name!r} has no outcome {outcome!r}"
        survey.unknown(path, where, "unknown-outcome", message, outcome, child.outcomes, "remove it")
        return False
    if dot and child.outcomes[outcome] == "success":
        survey.add(path, where, "unknown-code", f"{outcome!r} is a success, which has no failure code", "remove it")
    elif dot and child.codes is not None and code not in child.codes:
        known = sorted(child.codes)
        hint = nearest(code, known)
        survey.add(
            path,
            where,
            "unknown-code",
            f"{child.name!r} never fails with {code!r}{hint} (its codes: {listing(known)})",
            suggestion(hint, "remove it"),
        )
    return True


def _machine(survey: Survey, spot: Spot, node: StateMachine) -> None:
    if node.initial not in spot.children:
        message = f"`initial` names no child: {node.initial!r}"
        survey.unknown(spot.path, "initial", "unknown-child", message, node.initial, spot.children)
    targets: list[str] = []
    for child in spot.children.values():
        targets.extend(child.node.on.values())
        for label, target in child.node.on.items():
            check_label(survey, child.path, ("on", label), child, label)
            _machine_target(survey, spot, child, label, target)
        for outcome in child.outcomes:
            if outcome not in child.node.on and child.outcomes:
                _uncovered(survey, child, outcome)
    if not set(node.outcomes).isdisjoint(targets):  # or else it is endless, which is said by another rule
        _unused(survey, spot.path, node.outcomes, targets, "`on` of a child")


def _machine_target(survey: Survey, spot: Spot, child: Spot, label: str, target: str) -> None:
    sibling, outcome = target in spot.children, target in spot.outcomes
    where = ("on", label)
    if sibling and outcome:
        survey.add(
            child.path,
            where,
            "ambiguous-target",
            f"{target!r} is both a sibling and an outcome of {spot.path}",
            "rename one of them",
        )
    elif not sibling and not outcome:
        allowed = (*spot.children, *spot.outcomes)
        unknown_target(survey, child.path, where, target, allowed, "siblings and outcomes")


def unknown_target(
    survey: Survey, path: str, where: tuple[str | int, ...], target: str, allowed: Iterable[str], kind: str
) -> None:
    """Note a target that isn't among what is allowed."""
    hint = nearest(target, allowed)
    survey.add(
        path,
        where,
        "unknown-target",
        f"{where[-1]!r} leads to {target!r}, which isn't there{hint} ({kind}: {listing(allowed)})",
        suggestion(hint, ""),
    )


def _uncovered(survey: Survey, child: Spot, outcome: str) -> None:
    codes = [key for key in child.node.on if key.startswith(f"{outcome}.")]
    only = f"; {listing(codes)} covers only failures with that code" if codes else ""
    survey.add(
        child.path,
        ("on", outcome),
        "missing-target",
        f"it may end with {outcome!r}, which leads nowhere{only}",
        f"add `{outcome}: <sibling or outcome>` to its `on`",
    )


def _unused(survey: Survey, path: str, outcomes: Iterable[str], targets: Iterable[str], where: str) -> None:
    used = set(targets)
    for outcome in outcomes:
        if outcome not in used and not (outcome in ("success", "failure") and where == "`exits`"):
            survey.add(
                path,
                ("outcomes", outcome),
                "unused-outcome",
                f"nothing leads to the outcome {outcome!r}",
                f"lead to it in {where}, or remove it",
            )


def _root(survey: Survey, task: Task) -> None:
    root = survey.root
    for label, target in task.root.on.items():
        check_label(survey, "/", ("on", label), root, label)
        if target not in task.outcomes:
            unknown_target(survey, "/", ("on", label), target, task.outcomes, "outcomes of the task")
    for outcome, meaning in root.outcomes.items():
        if outcome not in task.root.on and default_outcome(task, outcome, meaning) is None:
            survey.add(
                "/",
                ("on", outcome),
                "missing-target",
                f"the root may end with {outcome!r}, which leads to no outcome of the task",
                f"add `{outcome}: <one of {listing(task.outcomes)}>` to the root's `on`",
            )
    _unused(survey, "", task.outcomes, _root_targets(task, root), "`on` of the root")


def _root_targets(task: Task, root: Spot) -> Iterator[str]:
    yield from task.root.on.values()
    for outcome, meaning in root.outcomes.items():
        if outcome not in task.root.on:
            target = default_outcome(task, outcome, meaning)
            if target is not None:
                yield target


def check_reach(survey: Survey, possible: Possible) -> None:
    """Find children that nothing leads to, state machines that can't end, and children from which no end is reached."""
    for spot in possible.unreached:
        assert spot.parent is not None
        how = (
            "no `on` leads to it"
            if isinstance(spot.parent.node, StateMachine)
            else "the children before it never let it have its turn"
        )
        survey.add(spot.path, None, "unreachable-node", f"it is never reached: {how}", "lead to it, or remove it")
    for spot in survey.containers:
        if isinstance(spot.node, StateMachine) and spot.node.initial in spot.children:
            _ends(survey, spot, spot.node, possible)


def _ends(survey: Survey, spot: Spot, node: StateMachine, possible: Possible) -> None:
    edges = machine_edges(spot, {c.path: possible.labels(c) for c in spot.children.values()})
    back: dict[str, list[str]] = {}
    for source, targets in edges.items():
        for target in targets:
            back.setdefault(target, []).append(source)
    ending = {name for outcome in node.outcomes for name in reachable(outcome, back)}
    if node.initial not in ending:
        survey.add(
            spot.path,
            "outcomes",
            "endless-machine",
            "it can't end: no path from `initial` leads to one of its outcomes",
            "let `on` of a child lead to an outcome",
        )
        return
    reached = reachable(node.initial, edges)
    for name, child in spot.children.items():
        if name in reached and name not in ending and edges[name]:
            survey.add(
                child.path,
                "on",
                "dead-end",
                f"once it is reached, {spot.path} can't end any more",
                "let a path from here lead to an outcome",
            )
