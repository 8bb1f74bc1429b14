"""Which variables are surely written where, over all paths that a task can take."""

from __future__ import annotations

from grip_bt.task import Leaf, Subtask
from grip_bt.task.kind_analysis import flow
from grip_bt.task.model import Childless, default_outcome
from grip_bt.task.parts import has_value
from grip_bt.task.validation.analysis import PlacedNode, TaskAnalysis
from grip_bt.task.validation.possible import PossibleOutcomes

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

    def __init__(self, analysis: TaskAnalysis, possible: PossibleOutcomes | None = None):
        self.missing: dict[tuple[str, tuple[str, ...]], str] = {}
        self._child_ends = (possible or PossibleOutcomes(analysis)).ends
        self._known: dict[tuple[str, int], States] = {}
        start = 0
        for declared in analysis.task_scope.values():
            start |= declared.bit if has_value(declared.variable) or declared.key == "inputs" else 0
        self.ends = self._after(analysis.root, start)

    def _after(self, placed: PlacedNode, state: int) -> States:
        key = (placed.path, state)
        if key not in self._known:
            after = self._analyse(placed, state)
            if placed.node.precondition:
                self._expressions(placed, state, ("precondition",))
                after = dict(after)
                _meet(after, "failure", state)
            self._known[key] = after
        return self._known[key]

    def _expressions(self, placed: PlacedNode, state: int, keys: tuple[str, ...]) -> None:
        """Note what the expressions at `keys` read before it is written."""
        for key, read in placed.expressions():
            for declared in read if key in keys else ():
                if not declared.bit & state:
                    self.missing[placed.path, (key,)] = declared.name

    def _analyse(self, placed: PlacedNode, state: int) -> States:
        node = placed.node
        if isinstance(node, _PORTED):
            return self._leaf(placed, node, state)
        if not placed.children and isinstance(node, Childless):
            return dict.fromkeys(placed.outcomes, state)
        for name in node.data:  # a scope begins anew each time its container is entered
            declared = placed.scope[name]
            state = state | declared.bit if has_value(declared.variable) else state & ~declared.bit

        def after(name: str, before: int) -> States:
            return self._after(placed.children[name], before)

        def bit_of(key: str) -> int:
            return placed.scope[getattr(node, key)].bit

        def read(key: str, there: int) -> None:
            if key not in node.reads:
                self._expressions(placed, there, (key.rstrip("_"),))
                return
            declared = placed.scope.get(getattr(node, key))
            if declared is not None and not declared.bit & there:
                self.missing[placed.path, (key,)] = declared.name

        return flow(node, self._child_ends[placed.path], state, after, bit_of, read)

    def _leaf(self, placed: PlacedNode, node: Leaf | Subtask, state: int) -> States:
        manifest = placed.manifest
        for port, name in node.in_.items():
            declared = placed.scope.get(name)
            if declared is not None and not declared.bit & state:
                self.missing[placed.path, ("in", port)] = name
        after = dict.fromkeys(placed.outcomes, state)
        for port, name in node.out.items():
            declared = placed.scope.get(name)
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


def _meet(states: States, label: str, state: int) -> None:
    states[label] = states.get(label, state) & state


def check_dataflow(analysis: TaskAnalysis, possible: PossibleOutcomes) -> None:
    """Find reads of variables that some path hasn't written, and note which outputs of the task are written when."""
    flow = DataFlow(analysis, possible)
    analysis.written = _written(analysis, flow.ends)
    for (path, keys), name in flow.missing.items():
        reader = f"the port {keys[1]!r}" if keys[0] == "in" else f"`{keys[0]}`"
        message = f"{reader} reads {name!r}, which isn't written on every path to here"
        fix = f"write {name!r} on every path before, or give it an initial value in `data`"
        analysis.add(path, keys, "read-before-write", message, fix)


def _written(analysis: TaskAnalysis, ends: States) -> dict[str, tuple[str, ...]]:
    """Return output of the task -> its outcomes with which it has been written on every path."""
    task, found = analysis.task, States()
    for outcome, state in ends.items():
        targets = [target for key, target in task.root.on.items() if key.partition(".")[0] == outcome]
        if outcome not in task.root.on and outcome in analysis.root.outcomes:
            by_itself = default_outcome(task, outcome, analysis.root.outcomes[outcome])
            targets = targets if by_itself is None else [*targets, by_itself]
        for target in targets:
            _meet(found, target, state)
    # an outcome that can't occur has nobody who misses anything
    return {
        name: tuple(o for o in task.outcomes if found.get(o, -1) & analysis.task_scope[name].bit)
        for name in task.outputs
    }
