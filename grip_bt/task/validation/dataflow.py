"""Which variables are surely written where: a forward analysis over all paths that a task can take.

The state is the set of variables that are written on *every* path to a point (an integer, a bit per variable). A
node maps the state before it to a state per outcome; where paths meet, only what both have written remains. State
machines are solved to the greatest fixed point by a work list: states only shrink, so it ends, and what is missing
in one round is missing in the last.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping

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

from .ends import root_target
from .survey import Spot, Survey

States = dict[str, int]
"""Outcome -> variables that are surely written when a node ends with it; an outcome that can't occur is absent."""


_PORTED = (Leaf, Subtask)


class DataFlow:
    """The analysis of one task.

    Attributes:
        missing: (path, keys) -> variable, for every read that may come before the write; `keys` lead to where the
            node says that it reads.
        ends: outcome of the root -> the variables that are surely written then.
    """

    def __init__(self, survey: Survey):
        self.missing: dict[tuple[str, tuple[str, ...]], str] = {}
        self._known: dict[tuple[str, int], States] = {}
        self._leaves: dict[tuple[str, int], States] = {}
        start = 0
        for declared in survey.task_scope.values():
            start |= declared.bit if declared.has_value or declared.key == "inputs" else 0
        self.ends = self._after(survey.root, start)

    def _after(self, spot: Spot, state: int) -> States:
        """Return the states after a node; nobody changes them."""
        if spot.plain and not spot.writes and not spot.reads & ~state:
            return self._untouched(spot, state)
        key = (spot.path, state)
        if key not in self._known:
            self._known[key] = self._entered(spot, state)
        return self._known[key]

    def _untouched(self, spot: Spot, state: int) -> States:
        """Return the states after a leaf that finds what it reads, and writes nothing."""
        assert spot.manifest is not None, "a plain leaf is of a known type"
        key = (spot.manifest.id, state)
        if key not in self._leaves:
            self._leaves[key] = dict.fromkeys(spot.outcomes, state)
        return self._leaves[key]

    def _entered(self, spot: Spot, state: int) -> States:
        if not spot.node.precondition:
            return self._analyse(spot, state)
        self._expressions(spot, state, ("precondition",))
        after = dict(self._analyse(spot, state))
        _meet(after, "failure", state)
        return after

    def _expressions(self, spot: Spot, state: int, keys: tuple[str, ...]) -> None:
        """Note what the expressions at `keys` read before it is written."""
        for key, read in spot.expressions():
            for declared in read if key in keys else ():
                if not declared.bit & state:
                    self.missing[spot.path, (key,)] = declared.name

    def _analyse(self, spot: Spot, state: int) -> States:
        node = spot.node
        if isinstance(node, _PORTED):
            return self._leaf(spot, node, state)
        for name in node.data:  # a scope begins anew each time its container is entered
            declared = spot.scope[name]
            state = state | declared.bit if declared.has_value else state & ~declared.bit
        self._expressions(spot, state, ("if", "while", "on_value"))
        if isinstance(node, Sequence):
            return self._in_order(spot, state, "success")
        if isinstance(node, Fallback):
            return self._in_order(spot, state, "failure")
        if isinstance(node, Foreign):
            return dict.fromkeys(spot.outcomes, state)
        if isinstance(node, Parallel):
            return self._parallel(spot, node, state)
        if isinstance(node, StateMachine):
            return self._machine(spot, node, state)
        if isinstance(node, Switch):
            return self._switch(spot, node, state)
        if isinstance(node, ForEach):
            return self._for_each(spot, node, state)
        return self._decorated(spot, state)

    def _leaf(self, spot: Spot, node: Leaf | Subtask, state: int) -> States:
        manifest = spot.manifest
        for port, name in node.in_.items():
            declared = spot.scope.get(name)
            if declared is not None and not declared.bit & state:
                self.missing[spot.path, ("in", port)] = name
        after = dict.fromkeys(spot.outcomes, state)
        for port, name in node.out.items():
            declared = spot.scope.get(name)
            if declared is None:
                continue
            output = manifest.outputs.get(port) if manifest else None
            for outcome in after:
                if output is None or manifest is None:
                    written = True  # unknown: another rule says so
                elif output.on:
                    written = outcome in output.on
                else:
                    written = manifest.outcomes.get(outcome) == "success"  # a precondition's refusal isn't in it
                if written:
                    after[outcome] |= declared.bit
        return after

    def _ends(self, spot: Spot, child: Spot, after: States) -> Iterator[tuple[str, bool, int]]:
        """Yield what each end of a child is to its container: an exit (True) or a meaning, and the state there."""
        exits: Mapping[str, str] = getattr(spot.node, "exits", {})
        refined = {k.rpartition(".")[0]: v for k, v in exits.items() if k.count(".") == 2}
        for label, state in after.items():
            key = f"{child.name}.{label}"
            if key in refined:
                yield refined[key], True, state
            if key in exits:
                yield exits[key], True, state
            elif label in child.outcomes:  # what an exit leads to needn't be there
                yield child.outcomes[label], False, state

    def _in_order(self, spot: Spot, state: int, goes_on: str) -> States:
        found: States = {}
        plain = not getattr(spot.node, "exits", {})
        for child in spot.children.values():
            if plain and child.plain and child.known is not None and not child.writes and not child.reads & ~state:
                reached = False
                for meaning, _ in child.known.ends:
                    if meaning == goes_on:
                        reached = True
                    else:
                        _meet(found, meaning, state)
                if not reached:
                    return found
                continue
            going_on: States = {}
            for label, is_exit, there in self._ends(spot, child, self._after(child, state)):
                _meet(going_on if label == goes_on and not is_exit else found, label, there)
            if goes_on not in going_on:
                return found
            state = going_on[goes_on]
        _meet(found, goes_on, state)
        return found

    def _parallel(self, spot: Spot, node: Parallel, state: int) -> States:
        one, every = ("failure", "success") if node.policy == "all" else ("success", "failure")
        if node.rules or node.wait_for is not None:  # who has ended then, only a run can tell
            afters = [self._after(child, state) for child in spot.children.values()]
            for after in afters if node.cancel != "halt" else ():
                state |= _met(after) if after else 0
            labels = {"success", "failure", *node.exits.values(), *(rule.then for rule in node.rules)}
            return dict.fromkeys(labels & spot.outcomes.keys(), state)
        found: States = {}
        decided: States = {}
        together, joined, all_can = state, state, True
        for child in spot.children.values():
            after = self._after(child, state)
            ends: States = {}
            for label, is_exit, there in self._ends(spot, child, after):
                _meet(found if is_exit else decided if label == one else ends, label, there)
            if node.cancel != "halt" and after:
                joined |= _met(after)
            all_can = all_can and every in ends
            together |= ends.get(every, 0)
        if one in decided:  # the others may have been interrupted, unless they are joined
            _meet(found, one, decided[one] | joined)
        if all_can:
            _meet(found, every, together)
        return found

    def _switch(self, spot: Spot, node: Switch, state: int) -> States:
        found: States = {} if node.default else {"failure": state}
        for name, child in spot.children.items():
            if name in node.cases or name == node.default:
                for label, _, there in self._ends(spot, child, self._after(child, state)):
                    _meet(found, label, there)
        return found

    def _for_each(self, spot: Spot, node: ForEach, state: int) -> States:
        declared = spot.scope.get(node.items)
        if declared is not None and not declared.bit & state:
            self.missing[spot.path, ("items",)] = node.items
        return {**self._decorated(spot, state | spot.scope[node.item].bit), "success": state}

    def _decorated(self, spot: Spot, state: int) -> States:
        node = spot.node
        found: States = {}
        for child in spot.children.values():
            for label, is_exit, there in self._ends(spot, child, self._after(child, state)):
                if is_exit:
                    _meet(found, label, there)
                elif isinstance(node, Invert):
                    _meet(found, "failure" if label == "success" else "success", there)
                elif isinstance(node, Force):
                    _meet(found, node.as_, there)
                elif not (isinstance(node, Repeat | Loop) and node.times is None and label == "success"):
                    _meet(found, "failure" if isinstance(node, Loop) else label, there)
        if isinstance(node, Timeout | Guard | Cooldown):
            _meet(found, "failure", state)
        if isinstance(node, Loop) and node.while_:
            _meet(found, "success", state)
        return found

    def _machine(self, spot: Spot, node: StateMachine, state: int) -> States:
        found: States = {}
        before: States = {node.initial: state}
        todo = deque(name for name in (node.initial,) if name in spot.children)
        while todo:
            name = todo.popleft()
            child = spot.children[name]
            for label, there in self._after(child, before[name]).items():
                for target in _targets(child.node.on, label):
                    if target in node.outcomes:
                        _meet(found, target, there)
                    if target in spot.children and _meet(before, target, there):
                        todo.append(target)
        return found


def _targets(on: Mapping[str, str], label: str) -> list[str]:
    """Return where a label leads, with any failure code."""
    return [t for key, t in on.items() if key == label or key.startswith(f"{label}.")]


def _meet(states: States, label: str, state: int) -> bool:
    """Let a path with `state` lead to `label`; tell whether that changed what is known there."""
    old = states.get(label)
    states[label] = state if old is None else old & state
    return states[label] != old


def _met(states: States) -> int:
    met = -1
    for state in states.values():
        met &= state
    return met


def check_dataflow(survey: Survey) -> None:
    """Find reads of variables that some path hasn't written, and note which outputs of the task are written when."""
    flow = DataFlow(survey)
    survey.written = _written(survey, flow.ends)
    for (path, keys), name in flow.missing.items():
        reader = f"the port {keys[1]!r}" if keys[0] == "in" else f"`{keys[0]}`"
        survey.add(
            path,
            keys,
            "read-before-write",
            f"{reader} reads {name!r}, which isn't written on every path to here",
            f"write {name!r} on every path before, or give it an initial value in `data`",
        )


def _written(survey: Survey, ends: States) -> dict[str, tuple[str, ...]]:
    """Return output of the task -> its outcomes with which it has been written on every path."""
    task, found = survey.task, States()
    for outcome, state in ends.items():
        targets = _targets(task.root.on, outcome)
        if outcome not in task.root.on and outcome in survey.root.outcomes:
            by_itself = root_target(task, outcome, survey.root.outcomes[outcome])
            targets = targets if by_itself is None else [*targets, by_itself]
        for target in targets:
            _meet(found, target, state)
    # an outcome that can't occur has nobody who misses anything
    return {
        name: tuple(o for o in task.outcomes if found.get(o, -1) & survey.task_scope[name].bit) for name in task.outputs
    }
