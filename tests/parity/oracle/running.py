"""A run of a task by docs/semantics.md alone, with the scripted leaves of these tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .containers import KINDS
from .node import UNWRITTEN, Broken, End, Node, Scope, code_first, failure

FACES = {
    "fuzz/plain": {"success": "success", "failure": "failure"},
    "fuzz/rich": {"success": "success", "failure": "failure", "none": "success", "lost": "failure"},
}
"""The outcomes of the scripted leaves."""
MAX_ACTIVATIONS = 150
TIRED = 6
"""Activations of a leaf after which it succeeds and fails by turns, whatever its script says: so most tasks end."""
MAX_TURNS = 3000


@dataclass
class Run:
    """What was seen of one run.

    Attributes:
        end: outcome, meaning and code; or `stopped`; or `error` and whose.
        trace: the activations of leaves: path, which, what was read, outcome, code, whether asked to stop.
        events: entries, ends, interruptions and writes, by path.
        data: (path, name) -> value of each variable that was written.
        over_budget: whether it was cut off.
        turns: how many ticks it took.
        order: the leaf of each tick of a leaf.
    """

    end: tuple[Any, ...]
    trace: list[tuple[Any, ...]]
    events: list[tuple[Any, ...]]
    data: dict[Any, Any]
    over_budget: bool
    turns: int
    order: list[str] = field(default_factory=list)


class Oracle:
    """One run of a case: its clock, what is asked of it, and what was written down.

    Args:
        case: a task with scripts for its leaves, and with files.
    """

    def __init__(self, case: Mapping[str, Any]):
        self.case = case
        self.now = 0.0
        self.preempted = case.get("preempt_at") == -1
        self.stopped = self.over_budget = False
        self.activations = self.turns = 0
        self.counts: dict[str, int] = {}
        self.trace: list[tuple[Any, ...]] = []
        self.events: list[tuple[Any, ...]] = []
        self.order: list[str] = []
        self.scopes: list[Scope] = []

    def note(self, path: str, *event: Any) -> None:
        """Write an event down."""
        self.events.append((path, *event))

    def run(self) -> Run:
        """Tick the task to its end."""
        task = self.case["task"]
        around = Scope("", task.get("data", {}))
        self.scopes.append(around)
        root = self.make(task["root"], "", "/", around, None)
        end = self._end(root, task)
        data = {(s.path, n): v for s in self.scopes for n, v in s.values.items() if v is not UNWRITTEN}
        return Run(end, self.trace, self.events, data, self.over_budget, self.turns, self.order)

    def _end(self, root: Node, task: Mapping[str, Any]) -> tuple[Any, ...]:
        try:
            while True:
                self.turns += 1
                self.over_budget = self.over_budget or self.turns > MAX_TURNS
                self._from_outside(self.case.get("outside", {}))
                if self.stopped or self.turns > MAX_TURNS:
                    root.halt()
                    return ("stopped",)
                end = root.tick()
                if end is not None:
                    reached = task_end(task, end)
                    return (reached.outcome, reached.meaning, reached.code)
        except Broken as broken:
            broken.node.halt()
            root.halt()
            return ("error", broken.node.path)

    def _from_outside(self, outside: Mapping[str, float]) -> None:
        """Let come what comes between two ticks."""
        if self.turns > 1:
            self.now += outside.get("period", 0)
        self.preempted = self.preempted or self.turns == outside.get("preempt_tick")
        self.stopped = self.stopped or self.turns == outside.get("stop_tick")

    def make(self, document: Mapping[str, Any], name: str, path: str, around: Scope, above: Node | None) -> Node:
        """Return a node with everything below it."""
        kind = document.get("kind", "leaf")
        made = {**KINDS, "leaf": Leaf, "foreign": Foreign, "subtask": Subtask}[kind](
            document, name, path, around, above, self
        )
        if made.scope is not around:
            self.scopes.append(made.scope)
        if isinstance(made, Subtask):
            made.children = [self.make(made.file["root"], "", f"{path}/", made.scope, made)]
        for below, said in {**document.get("children", {}), **document.get("child", {})}.items():
            inside = path if path.endswith("/") else f"{path}/"
            made.children.append(self.make(said, below, f"{'' if path == '/' else inside}{below}", made.scope, made))
        return made


def task_end(task: Mapping[str, Any], end: End) -> End:
    """Return the end of a task whose root has ended."""
    outcomes = {"success": "success", "failure": "failure"} if not task.get("outcomes") else task["outcomes"]
    label = code_first(task["root"].get("on", {}), "", end)
    if label is None:
        label = end.outcome if end.outcome in outcomes else end.meaning
    return End(label, outcomes[label], end.code if outcomes[label] == "failure" else None)


class Leaf(Node):
    """A scripted leaf: it runs for so many ticks, reads, writes a function of what it read, and ends."""

    run: Any
    step: dict[str, Any] = {}

    def begin(self) -> None:
        run = self.run
        if run.case.get("preempt_at") == run.activations:
            run.preempted = True
        self.count = run.counts.get(self.path, 0)
        run.counts[self.path] = self.count + 1
        run.activations += 1
        steps = run.case["scripts"][self.document["with"]["script"]]
        self.step = dict(steps[self.count % len(steps)])
        if self.count >= TIRED:
            self.step["outcome"] = ("success", "failure")[self.count % 2]
        if run.activations > MAX_ACTIVATIONS:
            run.over_budget, self.step = True, {"raises": True}
        self.ticks = self.step.get("ticks", 0)

    def work(self) -> End | None:
        run, step = self.run, self.step
        run.order.append(self.path)
        if step.get("stops"):
            run.stopped = True
            return None
        run.now += step.get("advance", 0)
        if self.ticks:
            self.ticks -= 1
            return None
        if step.get("raises"):
            raise Broken(self)
        return self._end()

    def _end(self) -> End:
        read = {port: self._seen(name) for port, name in sorted(self.document.get("in", {}).items())}
        value = (sum(v for v in read.values() if v != "-") + 7 * self.count + len(self.path)) % 101
        meaning = {**FACES[self.document["node"]], **self.document.get("meaning", {})}
        outcome = self.step["outcome"] if self.step["outcome"] in meaning else "failure"
        self._note(read, outcome, self.step.get("code"))
        for number, (_, name) in enumerate(sorted(self.document.get("out", {}).items())):
            self.write(name, value + number)
        self.step = {}
        return End(outcome, meaning[outcome], self.said)

    def _seen(self, name: str) -> Any:
        try:
            return self.scope.read(name)
        except LookupError:
            return "-"

    def _note(self, read: Mapping[str, Any], outcome: str, code: str | None) -> None:
        self.said = code
        self.run.trace.append((self.path, self.count, tuple(read.items()), outcome, code, self.preempted()))

    def over(self) -> None:
        if self.step:
            self._note({}, "halted", None)


class Foreign(Node):
    """The two behaviours of py_trees that the random tasks have, of which one is made when the task is compiled."""

    ticks = 0

    def work(self) -> End | None:
        self.ticks += 1
        every = self.document["args"].get("n", 1)
        return End("success", "success") if self.ticks % every == 0 else failure("foreign")


class Subtask(Node):
    """The root of a file with variables of its own."""

    run: Any

    def __init__(self, *arguments: Any):
        super().__init__(*arguments)
        self.file = self.run.case["files"][self.document["task"]]
        declared = {**self.file.get("outputs", {}), **self.file.get("inputs", {}), **self.file.get("data", {})}
        self.scope = Scope(self.path, declared)

    def begin(self) -> None:
        for port, name in self.document.get("in", {}).items():
            self.write(port, self.computed(lambda name=name: self.around.read(name)))  # type: ignore[misc]
        for port, value in self.document.get("with", {}).items():
            self.write(port, value)

    def work(self) -> End | None:
        end = self.children[0].tick()
        if end is None:
            return None
        for port, name in self.document.get("out", {}).items():
            value, home = self.scope.values[port], self.around.home(name)
            if value is not UNWRITTEN:
                home.values[name] = value
                self.run.note(self.path, "write", name, home.type(name), value)
        reached = task_end(self.file, end)
        meaning = {**self.file.get("outcomes", {}), **self.document.get("meaning", {})}
        return End(reached.outcome, meaning.get(reached.outcome, reached.meaning), end.code)
