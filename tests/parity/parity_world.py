"""Scripted leaves, and one task run by both targets: what they did, written down in the same way."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from itertools import groupby
from typing import Any

from oracle.running import FACES, MAX_ACTIVATIONS, MAX_TURNS, TIRED, Oracle, Run
from py_trees.common import Status
from py_trees.trees import BehaviourTree
from timed import ManualClock

from grip_bt.base.errors import DataError, NodeError
from grip_bt.compilers import Halted, to_machine, to_tree
from grip_bt.compilers.scopes import Scopes
from grip_bt.nodes import Leaf
from grip_bt.nodes.node import halt
from grip_bt.runtime.engine import make_ticker
from grip_bt.task.catalog import Catalog, Manifest, TaskTexts
from grip_bt.task.model import Subtask, Task, walk

CATALOG = Catalog(
    Manifest(
        id=id,
        doc="Does what its script says.",
        implementation="tests:ScriptedLeaf",
        parameters={"script": {"type": "str"}},
        inputs={port: {"type": "int", "required": False} for port in ("a", "b")},
        outputs={port: {"type": "int", "on": list(outcomes)} for port in ("x", "y")},
        outcomes=outcomes,
    )
    for id, outcomes in FACES.items()
)
PATIENCE = 60
"""Seconds until a turnstile takes it that nobody comes; only a run that differs waits so long."""


@dataclass
class World:
    """What the scripted leaves of one run share; also their context and the observer of all nodes."""

    scripts: dict[str, list[dict[str, Any]]]
    preempt_at: int | None = None
    origin: Mapping[str, str] | None = None
    """Path -> what is written down for it, of a task that was restructured; what isn't in it is left out."""
    subtasks: frozenset[str] = frozenset()
    """Paths of the subtasks of that task: what is inside of them goes with them."""
    outside: Mapping[str, float] = field(default_factory=dict)
    """What comes from outside, between two ticks: `period`, `preempt_tick`, `stop_tick`."""
    clock: ManualClock = field(default_factory=ManualClock)
    activations: int = 0
    turns: int = 0
    over_budget: bool = False
    preempt_requested: bool = False
    stopped: bool = False
    request_preempt: Any = None
    counts: dict[str, int] = field(default_factory=dict)
    trace: list[tuple[Any, ...]] = field(default_factory=list)
    events: list[tuple[Any, ...]] = field(default_factory=list)
    lock: threading.Lock = field(default_factory=threading.Lock)
    order: list[str] = field(default_factory=list)
    """The leaf of each tick of a leaf."""
    schedule: list[str] | None = None
    """A turnstile: the `order` of another run, in which the leaves of this one are let through one at a time."""
    gate: threading.Condition = field(default_factory=threading.Condition)
    inside: bool = False
    """Whether a leaf is being ticked."""
    stuck: bool = False

    def arrive(self, path: str) -> None:
        """Wait until it is this leaf's turn; raise Halted where its turn never comes."""
        with self.gate:
            if self.schedule is not None:
                self.gate.wait_for(lambda: self._next_is(path) or self._nobody_is_next(), timeout=PATIENCE)
                if not self._next_is(path):
                    self.stuck = True
                    self.gate.notify_all()
                    raise Halted
            self.inside = True
            self.order.append(path)

    def leave(self) -> None:
        """Let the next leaf through."""
        with self.gate:
            self.inside = False
            self.gate.notify_all()

    def _next_is(self, path: str) -> bool:
        return (
            self.schedule is not None
            and not self.inside
            and self.schedule[len(self.order) : len(self.order) + 1] == [path]
        )

    def _nobody_is_next(self) -> bool:
        ended = self.schedule is not None and not self.inside and len(self.order) >= len(self.schedule)
        return ended or self.stuck or self.stopped or self.over_budget

    def wake(self) -> None:
        """The runs here never wait."""

    def wake_at(self, time: float) -> None:
        """The runs here never wait."""

    def begin(self, path: str, script: str) -> tuple[int, dict[str, Any]]:
        with self.lock:
            if self.preempt_at == self.activations:
                self.request_preempt()
            k = self.counts.get(path, 0)
            self.counts[path] = k + 1
            self.activations += 1
            if self.activations > MAX_ACTIVATIONS:
                self.over_budget = True
                return k, {"raises": True}  # ends both at the same place, whatever interrupts whom
        steps = self.scripts[script]
        step = steps[k % len(steps)]
        return k, step if k < TIRED else {**step, "outcome": ("success", "failure")[k % 2]}

    # --- as a pacer ---

    def turn(self) -> int:
        self.turns += 1
        if self.turns > MAX_TURNS:
            self.over_budget = True
        if self.turns > 1:
            self.clock.advance(self.outside.get("period", 0))
        if self.turns == self.outside.get("preempt_tick"):
            self.request_preempt()
        self.stopped = self.stopped or self.turns == self.outside.get("stop_tick")
        if self.stopped or self.turns > MAX_TURNS:
            raise Halted
        return 0

    def rest(self, seen: int) -> None:
        """Go on at once."""

    # --- as an observer ---

    def named(self, path: str) -> str | None:
        if self.origin is None or path in self.origin:
            return path if self.origin is None else self.origin[path]
        above = next((p for p in self.subtasks if path.startswith(f"{p}/")), None)
        return None if above is None else self.origin[above] + path.removeprefix(above)

    def note(self, path: str, *event: Any) -> None:
        name = self.named(path)
        if name is not None:
            self.events.append((name, *event))

    def entered(self, path: str) -> None:
        self.note(path, "enter")

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        self.note(path, "exit", outcome, failure.code if failure else None)

    def interrupted(self, path: str) -> None:
        self.note(path, "interrupted")

    def message(self, path: str, text: str) -> None:
        self.note(path, "message", text)

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        self.note(path, "write", variable, type_name, value)


class ScriptedLeaf(Leaf):
    """Runs for so many ticks, then reads, writes a function of what it read, and ends as its script says."""

    world: World
    step: dict[str, Any] | None = None

    @property
    def known_as(self) -> str:
        return self.world.named(self.path) or self.path

    arrived = False

    def initialise(self) -> None:
        self.world.arrive(self.known_as)
        self.arrived = True
        self.k, self.step = self.world.begin(self.known_as, self.params["script"])
        self.ticks = self.step.get("ticks", 0)

    def update(self) -> Status:
        if not self.arrived:
            self.world.arrive(self.known_as)
        try:
            return self._update()
        finally:
            self.arrived = False
            self.world.leave()

    def _update(self) -> Status:
        assert self.step is not None
        if self.step.get("stops"):
            self.world.stopped = True
            return self.running()
        self.world.clock.advance(self.step.get("advance", 0))
        if self.ticks:
            self.ticks -= 1
            return self.running()
        if self.step.get("raises"):
            raise RuntimeError(f"{self.known_as} breaks")
        seen = {port: self._seen(port) for port in sorted(self.readers)}
        value = (sum(v for v in seen.values() if v != "-") + 7 * self.k + len(self.known_as)) % 101
        outputs = {port: value + i for i, port in enumerate(sorted(self.writers))}
        outcome, code = self.step["outcome"], self.step.get("code")
        outcome = outcome if outcome in self.meaning else "failure"
        self._note(seen, outcome, code)
        self.step = None
        status = self.end(outcome, **outputs)
        if code is not None and status == Status.FAILURE:
            self.fail(code, outcome=outcome)
        return status

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.step is not None:
            self._note({}, "halted", None)
            self.step = None

    def _seen(self, port: str) -> Any:
        try:
            return self.read(port)
        except DataError:
            return "-"

    def _note(self, seen: dict[str, Any], outcome: str, code: str | None) -> None:
        record = (self.known_as, self.k, tuple(seen.items()), outcome, code, self.context.preempt_requested)
        self.world.trace.append(record)


def _factory(world: World) -> Any:
    def make(path: str, node: Any, manifest: Manifest) -> Leaf:
        leaf = ScriptedLeaf(path, path, manifest, dict(node.with_), dict(node.meaning))
        leaf.world = world
        return leaf

    return make


def catalog_of(case: dict[str, Any]) -> Catalog:
    """Return the catalogue with the case's files."""
    return CATALOG.with_(tasks=TaskTexts({k: Task.model_validate(v) for k, v in case.get("files", {}).items()}))


def _world(case: dict[str, Any], task: Task, origin: Mapping[str, str] | None) -> World:
    subtasks = frozenset(path for path, node in walk(task.root) if isinstance(node, Subtask))
    return World(case["scripts"], case.get("preempt_at"), origin, subtasks, case.get("outside", {}))


def _run_of(world: World, end: tuple[Any, ...], data: Scopes) -> Run:
    values = {(world.named(path) or path, name): value for (path, name), value in data.snapshot().items()}
    if end[0] == "error":
        known_as = world.named(end[1]) or end[1]
        end = ("error", known_as, end[2].replace(f"{end[1]}:", f"{known_as}:"))
    return Run(end, world.trace, world.events, values, world.over_budget, world.turns, world.order)


def run_tree(
    case: dict[str, Any],
    task: Task | None = None,
    origin: Mapping[str, str] | None = None,
    *,
    by_engine: bool = False,
) -> Run:
    """Tick the compiled tree with py_trees' own manager, or by the tick engine.

    Args:
        case: a task with scripts.
        task: run this task instead, which is the same under other paths.
        origin: path in `task` -> path in the case.
        by_engine: whether the tick engine ticks.
    """
    task = task or Task.model_validate(case["task"])
    world = _world(case, task, origin)
    compiled = to_tree(task, catalog_of(case), leaf_factory=_factory(world))

    def request_preempt() -> None:
        world.preempt_requested = True

    world.request_preempt = request_preempt
    if world.preempt_at == -1:
        request_preempt()
    compiled.observe(world)
    tree = BehaviourTree(compiled.root)
    tree.setup(context=world)
    tick = tree.tick
    if by_engine:
        tick = make_ticker(compiled.root)
    try:
        while True:
            world.turn()
            tick()
            if compiled.root.status != Status.RUNNING:
                break
        reached = compiled.end()
        end: tuple[Any, ...] = (reached.outcome, reached.meaning, reached.failure.code if reached.failure else None)
    except Halted:
        halt(compiled.root)
        end = ("stopped",)
    except NodeError as error:
        halt(compiled.root)
        end = ("error", error.path, str(error.cause))
    return _run_of(world, end, compiled.data)


def run_machine(
    case: dict[str, Any],
    task: Task | None = None,
    origin: Mapping[str, str] | None = None,
    *,
    schedule: list[str] | None = None,
) -> Run:
    """Execute the compiled machine; arguments as for `run_tree`, and the turnstile of its leaves, if there is one."""
    task = task or Task.model_validate(case["task"])
    world = _world(case, task, origin)
    world.schedule = schedule
    compiled = to_machine(task, catalog_of(case), leaf_factory=_factory(world))
    world.request_preempt = compiled.request_preempt
    if world.preempt_at == -1:
        compiled.request_preempt()
    compiled.observe(world)
    compiled.prepare(world)
    try:
        reached = compiled.execute(world, make_ticker if len(str(case)) % 2 else None)
        end: tuple[Any, ...] = (reached.outcome, reached.meaning, reached.failure.code if reached.failure else None)
    except Halted:
        end = ("stopped",)
    except NodeError as error:
        end = ("error", error.path, str(error.cause))
    return _run_of(world, end, compiled.data)


def projections(records: list[tuple[Any, ...]]) -> dict[str, list[tuple[Any, ...]]]:
    """Return the records of each path, in order."""
    result: dict[str, list[tuple[Any, ...]]] = {}
    for record in records:
        result.setdefault(record[0], []).append(record)
    return result


def difference(case: dict[str, Any]) -> str | None:
    """Run a case as a tree by py_trees, as the same tree by the tick engine, by the oracle, and as a machine.

    A machine's steps aren't ticks: what comes from outside between two ticks is left out where it is compared.

    Returns:
        how two of them differ, None when they don't, '' when it can't be told.
    """
    tree, ticked = run_tree(case), run_tree(case, by_engine=True)
    unlike = _unlike(tree, ticked, "engine") or _unlike(_as_said(tree), _as_said(Oracle(case).run()), "oracle")
    if unlike:
        return unlike
    if case.get("outside"):
        case = {key: said for key, said in case.items() if key != "outside"}
        tree = run_tree(case)
    return compare(case, {"tree": tree, "machine": run_machine(case)})


def _unlike(tree: Run, other: Run, name: str) -> str | None:
    """Return how a tree's run differs from another, tick by tick: in nothing at all, that is the claim."""
    for field_ in fields(Run):
        left, right = getattr(tree, field_.name), getattr(other, field_.name)
        if left != right:
            return f"{field_.name} differ\n  {'tree:':{len(name) + 1}} {left}\n  {name}: {right}"
    return None


def _as_said(run: Run) -> Run:
    """Return what docs/semantics.md says of a run: no words of errors or for people, no order among what is halted."""
    events = _any_order([e for e in run.events if e[1] != "message"], "interrupted")
    end = run.end[:2] if run.end[0] == "error" else run.end
    return replace(run, end=end, trace=_any_order(run.trace, "halted"), events=events)


def _any_order(records: list[tuple[Any, ...]], word: str) -> list[tuple[Any, ...]]:
    """Return the records with those in a row that have a word sorted."""
    return [
        r for halted, row in groupby(records, lambda r: word in r) for r in (sorted(row, key=str) if halted else row)
    ]


def compare(case: dict[str, Any], runs: Mapping[str, Run]) -> str | None:
    """Return how two named runs of a case differ, None when they don't, '' when they don't as far as both came.

    Runs come equally far but in three cases: one that goes round without an activation is stopped after so many ticks,
    and a tick isn't a machine's step; where siblings are at once, their order isn't fixed, so that what a stop, an
    error or a request finds them at isn't either; and where a sibling may interrupt the leaf that asks for the stop,
    one run may do more in the same tick than the other does before it looks.
    """
    (left_name, left_run), (right_name, right_run) = runs.items()
    width = max(len(left_name), len(right_name)) + 1
    partly = _cut_short(case, left_run, right_run)
    for what in ("trace", "events") if partly else ("trace", "events", "end", "data"):
        left, right = getattr(left_run, what), getattr(right_run, what)
        if case.get("concurrent") and what in ("trace", "events"):
            requested = what == "trace" and case.get("preempt_at", -1) >= 0
            left, right = (projections([r[:-1] for r in side] if requested else side) for side in (left, right))
        if not (_agree(left, right, 10 * bool(case.get("embedded"))) if partly else left == right):
            return f"{what} differ\n  {left_name + ':':{width}} {left}\n  {right_name + ':':{width}} {right}"
    return "" if partly else None


def _cut_short(case: dict[str, Any], left: Run, right: Run) -> bool:
    """Tell whether two runs needn't have come equally far."""
    if left.turns > MAX_TURNS or right.turns > MAX_TURNS:
        return True
    if not case.get("concurrent") and not case.get("embedded"):
        return False
    ends = {left.end[0], right.end[0]}
    if "stopped" in ends and _asked_and_halted(case, left, right):
        return True  # one may even have ended in the tick in which the stop was asked for
    return ends <= ({"error", "stopped"} if case.get("concurrent") else {"stopped"})


def _asked_and_halted(case: dict[str, Any], left: Run, right: Run) -> bool:
    """Tell whether the same leaf was interrupted in both runs, of a case in which leaves ask for stops."""
    asks = any(step.get("stops") for steps in case["scripts"].values() for step in steps)
    return asks and bool({r[0] for r in left.trace if "halted" in r} & {r[0] for r in right.trace if "halted" in r})


def _agree(left: Any, right: Any, margin: int) -> bool:
    """Tell whether two lists are the same as far as both go, but for `margin` at the end; of projections, each."""
    if isinstance(left, dict):
        return all(_agree(left[path], right[path], margin) for path in left.keys() & right.keys())
    left, right = ([r for r in side if "halted" not in r and "interrupted" not in r] for side in (left, right))
    both = max(0, min(len(left), len(right)) - margin)
    return bool(left[:both] == right[:both])
