"""Do two forms of a task do the same? Both are run with leaves that end as a script says, for every short script."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from itertools import count
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import DataError, EvaluationError, NodeError
from grip_bt.nodes import Leaf
from grip_bt.nodes.node import Observer, halt
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Foreign as ForeignNode
from grip_bt.task.model import Kind, Task, walk
from grip_bt.task.model import Leaf as LeafNode

from ..to_tree import CompiledTree, to_tree
from .result import Restructured

WORK = 30_000
"""Nodes that are compiled at most for one form, over all runs."""
RUNS = 200
ENDS = 12
"""Ends of leaves in a script at most; whatever comes later is as the first outcome says."""
_TICKS = 400
_FOREIGN = Manifest(id="foreign/behaviour", doc="Somebody's own behaviour.", implementation="")
_VALUES: Mapping[str, Any] = {"bool": True, "int": 1, "float": 1.0, "str": "a", "list": [], "dict": {}}


@dataclass(frozen=True)
class End:
    """How one activation of a leaf ends.

    Attributes:
        path: the leaf, in the task that was converted.
        count: which of its activations, from 0.
    """

    path: str
    count: int
    outcome: str
    code: str | None = None
    ticks: int = 0

    def __str__(self) -> str:
        label = self.outcome if self.code is None else f"{self.outcome}.{self.code}"
        return f"{self.path}: {label}" + (" after a tick" if self.ticks else "")


@dataclass(frozen=True)
class Difference:
    """A script with which two forms do different things.

    Attributes:
        script: how each activation of a leaf ends, in the order in which they end in the first form; last those that
            it interrupts.
        before: what the first form does: ends of leaves, then its own.
    """

    script: tuple[End, ...]
    before: tuple[str, ...]
    after: tuple[str, ...]

    def __str__(self) -> str:
        lines = ["with leaves that end like this:", *(f"  {end}" for end in self.script)]
        shared = next((n for n, (a, b) in enumerate(zip(self.before, self.after, strict=False)) if a != b), None)
        at = min(len(self.before), len(self.after)) if shared is None else shared
        for name, did in (("before", self.before), ("after", self.after)):
            lines.append(f"step {at + 1} {name}: {did[at] if at < len(did) else 'nothing any more'}")
        return "\n".join(lines)


@dataclass(frozen=True)
class Comparison:
    """What came of comparing two forms.

    Attributes:
        length: all scripts that say how so many ends are, with the usual outcome after them, are among them; None
            where there are no longer ones.
    """

    runs: int
    length: int | None
    difference: Difference | None

    def __str__(self) -> str:
        if self.difference is not None:
            return f"not the same: {self.difference}"
        scripts = "every script there is" if self.length is None else f"every way in which the first {self.length} end"
        return f"the same in {self.runs} runs of both forms with scripted leaves ({scripts} among them)"


def compare(task: Task, result: Restructured, catalog: Catalog, runs: int | None = None) -> Comparison:
    """Run a task and its other form with scripted leaves, shortest scripts first.

    Time stands still but for a second with each end of a leaf; outputs have one value a type, and those of types
    that aren't Python's stay unwritten.

    Args:
        runs: how many scripts are tried at most; by default up to 200, and fewer for large tasks.

    Raises:
        InvalidTaskError: a form isn't right.
    """
    origin = {new: old for old, new in result.paths.items()}
    most = runs or max(10, min(RUNS, WORK // max(1, len(origin))))
    concurrent = any(isinstance(node, Kind) and node.concurrent for _, node in walk(task.root))
    codes = _codes(task)
    order = count()
    queue: list[tuple[int, int, tuple[End, ...]]] = [(0, next(order), ())]
    done = 0
    while queue and done < most:
        _, _, prefix = heappop(queue)
        first = _Run(task, catalog, None, prefix, codes)
        other = _Run(result.task, catalog, origin, first.played(), codes)
        done += 1
        if _unlike(first, other, concurrent):
            return Comparison(done, None, Difference(first.played(), tuple(first.did()), tuple(other.did())))
        for at in range(len(prefix), min(len(first.log), ENDS)):
            for each in first.others(first.log[at]):
                heappush(queue, (at + 1, next(order), (*first.log[:at], each)))
    return Comparison(done, queue[0][0] - 1 if queue else None, None)


def play(
    task: Task, catalog: Catalog, script: tuple[End, ...], observe: Callable[[Callable[[], float]], Observer]
) -> tuple[str, ...]:
    """Run one form with leaves that end as a script says, and tell an observer what all of its nodes do.

    Args:
        script: how activations of leaves end, by their paths here; others end with their first success.
        observe: given what tells the time of the run [s], returns who is told.

    Returns:
        Outcome and failure's code; or `error` and where or why; nothing where the task goes on and on.
    """
    return _Run(task, catalog, None, script, _codes(task), observe).end


def moved(script: tuple[End, ...], paths: Mapping[str, str]) -> tuple[End, ...]:
    """Return a script with the paths of another form: `paths` are those of a `Restructured`."""
    return tuple(replace(end, path=_moved(end.path, paths)) for end in script)


def _moved(path: str, paths: Mapping[str, str]) -> str:
    """Return where a leaf is in the other form; what is inside a subtask goes with it."""
    above = path
    while above not in paths and "/" in above:
        above = above.rpartition("/")[0]
    return paths.get(above, above) + path[len(above) :]


def _unlike(first: _Run, other: _Run, concurrent: bool) -> bool:
    one, two = (_by_leaf(r.log) if concurrent else r.log for r in (first, other))
    if first.unfinished or other.unfinished:
        return not concurrent and any(a != b for a, b in zip(first.log, other.log, strict=False))
    return one != two or first.end != other.end


def _by_leaf(log: list[End]) -> Any:
    return {path: [end for end in log if end.path == path] for path in {end.path for end in log}}


def _codes(task: Task) -> dict[str, None]:
    found: dict[str, None] = {}
    for _, node in walk(task.root):
        keys = [*(k for k in node.on if "." in k), *(k for k in getattr(node, "exits", ()) if k.count(".") == 2)]
        found |= dict.fromkeys(key.rpartition(".")[2] for key in keys)
    return found


class _Clock:
    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        return self.time


@dataclass
class _Context:
    clock: _Clock = field(default_factory=_Clock)
    preempt_requested: bool = False

    def wake(self) -> None:
        """Nobody waits."""

    def wake_at(self, time: float) -> None:
        """Nobody waits."""


class _Run:
    """One form run once; `log` says how the leaves have ended, under the paths of the first form."""

    def __init__(
        self,
        task: Task,
        catalog: Catalog,
        origin: Mapping[str, str] | None,
        script: tuple[End, ...],
        codes: Mapping[str, None],
        observe: Callable[[Callable[[], float]], Observer] | None = None,
    ):
        self.script = {(end.path, end.count): end for end in script}
        self.origin, self.codes = origin, tuple(codes)
        self.context = _Context()
        self.log: list[End] = []
        self.begun: list[End] = []
        self.counts: dict[str, int] = {}
        self.faces: dict[str, Leaf] = {}
        self.unfinished = False
        compiled = to_tree(task, catalog, leaf_factory=self._leaf, behaviour_factory=self._foreign)
        if observe is not None:
            compiled.observe(observe(self.context.clock.now))
        self.end: tuple[str, ...] = self._run(compiled)

    def played(self) -> tuple[End, ...]:
        """Return the script of this run: the activations that have ended, then those that were interrupted before."""
        return (*self.log, *(end for end in self.begun if end not in self.log))

    def did(self) -> Iterator[str]:
        yield from map(str, self.log)
        yield "the task goes on" if self.unfinished else f"the task ends: {' '.join(self.end)}"

    def others(self, end: End) -> Iterator[End]:
        for outcome, meaning in self.faces[end.path].meaning.items():
            coded = meaning == "failure" and self.faces[end.path].manifest is not _FOREIGN
            for code in (None, *(self.codes if coded else ())):
                for ticks in (0, 1):
                    other = End(end.path, end.count, outcome, code, ticks)
                    if other != end:
                        yield other

    def _leaf(self, path: str, node: LeafNode, manifest: Manifest) -> Leaf:
        return self._scripted(path, manifest, node.with_, node.meaning)

    def _foreign(self, path: str, name: str, node: ForeignNode, children: Sequence[Behaviour]) -> Leaf:
        """Return what takes the place of somebody's own behaviour, which isn't imported to be compared."""
        return self._scripted(path, _FOREIGN)

    def _scripted(
        self, path: str, manifest: Manifest, given: Mapping[str, object] = {}, meaning: Mapping[str, str] = {}
    ) -> Leaf:
        known_as = self._known_as(path)
        made = _Scripted(path, path, manifest, dict(given), dict(meaning))
        made.run, made.known_as = self, known_as
        self.faces[known_as] = made
        return made

    def _known_as(self, path: str) -> str:
        return path if self.origin is None else _moved(path, self.origin)

    def _run(self, compiled: CompiledTree) -> tuple[str, ...]:
        compiled.prepare(self.context)
        try:
            for _ in range(_TICKS):
                compiled.root.tick_once()
                if compiled.root.status != Status.RUNNING:
                    end = compiled.end()
                    return (end.outcome, *((end.failure.code,) if end.failure else ()))
                if len(self.log) > 2 * ENDS:
                    break
        except NodeError as error:
            return ("error", self._known_as(error.path))
        except (DataError, EvaluationError) as error:
            return ("error", type(error).__name__)
        self.unfinished = True
        halt(compiled.root)
        return ()

    def begin(self, leaf: _Scripted) -> End:
        count = self.counts.get(leaf.known_as, 0)
        self.counts[leaf.known_as] = count + 1
        usual = next((o for o, m in leaf.meaning.items() if m == "success"), next(iter(leaf.meaning)))
        end = self.script.get((leaf.known_as, count)) or End(leaf.known_as, count, usual)
        self.begun.append(end)
        return end


class _Scripted(Leaf):
    run: _Run
    known_as: str

    def initialise(self) -> None:
        self.step = self.run.begin(self)
        self.ticks = self.step.ticks

    def update(self) -> Status:
        if self.ticks:
            self.ticks -= 1
            return self.running()
        step = self.step
        self.run.log.append(step)
        self.run.context.clock.time += 1.0
        outputs = {p: _VALUES[t] for p, t in ((p, o.type.partition("[")[0]) for p, o in self.outputs()) if t in _VALUES}
        status = self.end(step.outcome, **outputs)
        if step.code is not None and status == Status.FAILURE:
            self.fail(step.code, outcome=step.outcome)
        return status

    def outputs(self) -> Iterator[tuple[str, Any]]:
        return ((port, face) for port, face in self.manifest.outputs.items() if port in self.writers)
