"""With which outcomes nodes can end at all, and which children are ever reached, whatever the leaves do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from grip_bt.task import (
    Cooldown,
    Fallback,
    Force,
    ForEach,
    Foreign,
    Guard,
    Invert,
    Leaf,
    Loop,
    Parallel,
    Repeat,
    Sequence,
    StateMachine,
    Subtask,
    Switch,
    Timeout,
)

from .survey import Spot, Survey


class Possible:
    """Possible ends of every node, found from the leaves upwards."""

    def __init__(self, survey: Survey):
        self._labels: dict[str, frozenset[str]] = {}
        self.unreached: list[Spot] = []
        for spot in reversed(survey.spots):
            if spot.plain and spot.known is not None:
                self._labels[spot.path] = spot.known.labels
                continue
            labels = self._of(spot)
            self._labels[spot.path] = labels | {"failure"} if spot.node.precondition else labels

    def labels(self, spot: Spot) -> frozenset[str]:
        """Return the outcomes with which a node can end."""
        return self._labels[spot.path]

    def _of(self, spot: Spot) -> frozenset[str]:
        node = spot.node
        if isinstance(node, Leaf | Foreign | Subtask):
            return frozenset(spot.outcomes)
        if isinstance(node, StateMachine):
            return self._machine(spot, node)
        if isinstance(node, Sequence | Fallback):
            return self._in_order(spot, "success" if isinstance(node, Sequence) else "failure")
        if isinstance(node, Parallel):
            return self._parallel(spot, node)
        if isinstance(node, Switch):
            return self._switch(spot, node)
        return self._decorated(spot)

    def _ends(self, spot: Spot, child: Spot) -> Iterable[tuple[str, bool]]:
        """Return what each possible end of a child is to its container: an exit (True) or a meaning."""
        exits: Mapping[str, str] = getattr(spot.node, "exits", {})
        if exits or not child.plain or child.known is None:
            return self._ends_by(exits, child)
        return child.known.ends

    def _ends_by(self, exits: Mapping[str, str], child: Spot) -> Iterator[tuple[str, bool]]:
        refined = {k.rpartition(".")[0]: v for k, v in exits.items() if k.count(".") == 2}
        for label in self._labels[child.path]:
            key = f"{child.name}.{label}"
            if key in refined:
                yield refined[key], True
            if key in exits:
                yield exits[key], True
            elif label in child.outcomes:  # what an exit leads to needn't be there
                yield child.outcomes[label], False

    def _in_order(self, spot: Spot, goes_on: str) -> frozenset[str]:
        found: set[str] = set()
        reached = True
        for child in spot.children.values():
            if not reached:
                self.unreached.append(child)
                continue
            reached = False
            for label, is_exit in self._ends(spot, child):
                if is_exit or label != goes_on:
                    found.add(label)
                else:
                    reached = True
        return frozenset(found | {goes_on}) if reached else frozenset(found)

    def _parallel(self, spot: Spot, node: Parallel) -> frozenset[str]:
        one, every = ("failure", "success") if node.policy == "all" else ("success", "failure")
        if node.rules or node.wait_for is not None:
            return frozenset({"success", "failure", *node.exits.values(), *(rule.then for rule in node.rules)})
        ends = [set(self._ends(spot, child)) for child in spot.children.values()]
        found = {label for each in ends for label, is_exit in each if is_exit}
        if any((one, False) in each for each in ends):
            found.add(one)
        if all((every, False) in each for each in ends):
            found.add(every)
        return frozenset(found)

    def _switch(self, spot: Spot, node: Switch) -> frozenset[str]:
        taken = {*node.cases, node.default}
        self.unreached.extend(child for name, child in spot.children.items() if name not in taken)
        found = {label for name, c in spot.children.items() if name in taken for label, _ in self._ends(spot, c)}
        return frozenset(found if node.default else found | {"failure"})

    def _decorated(self, spot: Spot) -> frozenset[str]:
        node = spot.node
        found: set[str] = set()
        for child in spot.children.values():
            for label, is_exit in self._ends(spot, child):
                if is_exit:
                    found.add(label)
                elif isinstance(node, Invert):
                    found.add("failure" if label == "success" else "success")
                elif isinstance(node, Force):
                    found.add(node.as_)
                elif not (isinstance(node, Repeat | Loop) and node.times is None and label == "success"):
                    found.add("failure" if isinstance(node, Loop) else label)
        if isinstance(node, Timeout | Guard | Cooldown):
            found.add("failure")
        if isinstance(node, ForEach) or (isinstance(node, Loop) and node.while_):
            found.add("success")
        return frozenset(found)

    def _machine(self, spot: Spot, node: StateMachine) -> frozenset[str]:
        edges = machine_edges(spot, self._labels)
        reached = reachable(node.initial, edges)
        self.unreached.extend(c for name, c in spot.children.items() if name not in reached)
        return frozenset(node.outcomes) & reached


def machine_edges(spot: Spot, labels: Mapping[str, frozenset[str]]) -> dict[str, list[str]]:
    """Return where each child of a state machine can lead: siblings and outcomes."""
    edges: dict[str, list[str]] = {}
    for name, child in spot.children.items():
        possible = labels[child.path]
        edges[name] = [t for label, t in child.node.on.items() if label.partition(".")[0] in possible]
    return edges


def reachable(start: str, edges: Mapping[str, list[str]]) -> set[str]:
    """Return everything that can be reached from `start`, itself included."""
    seen, stack = {start}, [start]
    while stack:
        for target in edges.get(stack.pop(), ()):
            if target not in seen:
                seen.add(target)
                stack.append(target)
    return seen
