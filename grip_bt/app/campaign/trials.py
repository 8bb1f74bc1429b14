"""Trials, in supervised processes, several at once; and what a campaign makes of each: success, and measures."""

from __future__ import annotations

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

from grip_bt.app.campaign.file import Campaign, Plain
from grip_bt.app.campaign.results import TrialRow, difference, picture_of, pictures_of, provenance
from grip_bt.app.campaign.statistics import wilson
from grip_bt.app.project.foreign_code import of_task, refuse
from grip_bt.app.project.worlds import STATES, world_of
from grip_bt.app.runs.execute import RunOptions, check_inputs, check_task
from grip_bt.app.runs.mocks import apply_mocks, check_nodes, scripted
from grip_bt.app.runs.motion_record import KEPT
from grip_bt.app.runs.supervisor import RunProcess, Supervisor
from grip_bt.base.errors import EvaluationError, ExpressionError, nearest
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.files import Closing
from grip_bt.base.types import JsonObject
from grip_bt.compilers.resolve import resolve
from grip_bt.runtime import JournalReader
from grip_bt.runtime.control import RunEnd
from grip_bt.runtime.motion_end import Rest

_Trial = tuple[str, int]
MOST = 500
"""Trials that one process executes."""
_WRONG = ("error", "timed_out")
_Compile = Callable[..., Callable[[], object]]
WAKE = 0.2
"""How often the wait for trials looks up [s]: a Ctrl-C that the system gives to another thread wakes nobody."""


class Trials:
    """Runs trials of a campaign; one whose tick takes longer than `watchdog` [s] ends as an error.

    Trials share processes: planner, simulator and servers of components stay from one to the next, the world doesn't.
    A process ends with what goes wrong in it, and after `MOST` trials.

    Args:
        before: rows of earlier trials, by which the rule tells that a variant isn't tried any more.
        fresh: whether each trial has processes of its own.
        view: from where a picture of each simulated trial's end is taken, as `grip run --view` has it; it goes into a
            folder beside the journal. None for none.
    """

    def __init__(
        self,
        campaign: Campaign,
        journal: Path,
        ended: Callable[[TrialRow], None],
        watchdog: float = 10.0,
        before: Iterable[TrialRow] = (),
        fresh: bool = False,
        view: str | None = None,
    ):
        self._campaign, self.journal, self._ended, self._watchdog = campaign, journal, ended, watchdog
        self.fresh, self._lock = fresh, threading.RLock()
        self.view, self.pictures = view, pictures_of(journal)
        if view is not None and campaign.file.robot != "sim":
            raise campaign.error("pictures are taken in a simulated world, not with `robot: fake`")
        if view is not None:
            self.pictures.mkdir(parents=True, exist_ok=True)
        self._stopped = threading.Event()
        self._under_way: set[Supervisor] = set()
        self._left: deque[_Trial] = deque()
        self._tally = dict.fromkeys(campaign.file.variants, (0, 0))
        every = campaign.file.repeat if campaign.file.robot == "sim" else 0
        trials = campaign.trials()
        self._repeated = set(trials[every - 1 :: every]) if every else set()
        self._drawn = len(trials) <= KEPT
        self._provenance = {name: provenance(campaign, name) for name in campaign.file.variants}
        for row in before:
            self._count(row)

    def run(self, trials: Iterable[_Trial], workers: int = 1) -> None:
        """Run them all, `workers` at a time, to their ends or `stop`; what `ended` raises stops them, and is raised."""
        self.line_up(trials)
        with ThreadPoolExecutor(workers) as pool:
            jobs = [pool.submit(self._work) for _ in range(workers)]
            while (state := wait(jobs, WAKE)).not_done:
                if any(job.exception() for job in state.done):
                    self.stop()
        for job in jobs:
            job.result()

    def line_up(self, trials: Iterable[_Trial]) -> None:
        """Have `next` tell of these trials."""
        self._left.extend(trials)

    @property
    def stopped(self) -> bool:
        """Whether they were told to stop."""
        return self._stopped.is_set()

    def stop(self) -> None:
        """Stop the trials under way, and begin no other. They leave no row. May be called from a signal handler."""
        self._stopped.set()
        for supervisor in list(self._under_way):
            supervisor.stop()

    @property
    def left(self) -> int:
        """How many aren't begun, of variants that are tried on."""
        with self._lock:
            return sum(not self.enough(variant) for variant, _ in self._left)

    def enough(self, variant: str) -> bool:
        """Tell whether the campaign's rule says that a variant was tried often enough."""
        rule, (good, tried) = self._campaign.file.stop, self._tally.get(variant, (0, 0))
        if rule is None or tried < rule.least:
            return False
        low, high = wilson(good, tried)
        return high - low <= rule.width

    def _count(self, row: TrialRow) -> None:
        good, tried = self._tally.get(row["variant"], (0, 0))
        self._tally[row["variant"]] = good + row["success"], tried + 1

    def next(self) -> _Trial | None:
        """Return the trial that is to be run now; None where none is left, or they were told to stop."""
        with self._lock:
            while self._left and not self._stopped.is_set():
                trial = self._left.popleft()
                if not self.enough(trial[0]):
                    return trial
        return None

    def enter(self, row: TrialRow) -> None:
        """Take note of a trial's row, and hand it on."""
        with self._lock:
            self._count(row)
            self._ended(row)

    def _work(self) -> None:
        with Seat(self) as seat:
            while (trial := self.next()) is not None and (row := seat.run(*trial)) is not None:
                self.enter(row)

    def once_or_twice(self, variant: str, seed: int, process: RunProcess | None) -> TrialRow | None:
        """Run one trial in a process, and again in new ones where the campaign says so; None where it was stopped."""
        row = self.once(variant, seed, process)
        if row is not None and (variant, seed) in self._repeated and row["status"] not in _WRONG:
            again = self.once(variant, seed)
            if again is None:
                return None
            row["repeated"] = difference(self.journal, row["run"], again["run"]) or "the same"
        return row

    def once(self, variant: str, seed: int, process: RunProcess | None = None) -> TrialRow | None:
        """Run one trial, in processes of its own where none is given, and return its row; None where it was stopped."""
        began, late, said = time.monotonic(), threading.Event(), self._campaign.file
        task, options = str(self._campaign.task(variant)), self._options(variant, seed, process is None)
        supervisor = Supervisor(task, options, lambda event: None, self._watchdog, terminal=False, process=process)

        def too_late() -> None:
            late.set()
            supervisor.stop()

        supervisor.start()
        timer = threading.Timer(said.timeout, too_late)
        timer.daemon = True
        timer.start()
        with self._lock:
            self._under_way.add(supervisor)
        if self._stopped.is_set():
            supervisor.stop()
        end = supervisor.wait()
        timer.cancel()
        with self._lock:
            self._under_way.discard(supervisor)
        if self._stopped.is_set() and not late.is_set():
            return None
        if late.is_set() and end.get("status") == "stopped":
            end |= {"status": "timed_out", "message": f"not done after {said.timeout:g} s of wall time"}
        elif end["event"] == "failed":
            end |= {"status": "error"}
        return self.row(variant, seed, end, time.monotonic() - began, supervisor.started)

    def row(self, variant: str, seed: int, end: RunEnd, wall: float, started: JsonObject | None) -> TrialRow:
        """Return a trial's row, see `judged`."""
        row = judged(self._campaign, end, wall, started)
        what = {"trial": f"{variant}@{seed}", "variant": variant, "seed": seed}
        levels = {"levels": self._campaign.levels[variant]} if variant in self._campaign.levels else {}
        return TrialRow(**{**what, **levels, **row, "provenance": self._provenance[variant]})  # type: ignore[typeddict-item]

    def _options(self, variant: str, seed: int, alone: bool) -> RunOptions:
        said, settings = self._campaign.file, self._campaign.file.variants[variant]
        return RunOptions(
            target=settings.form,
            robot=said.robot,
            seed=seed,
            world=settings.world,
            object=settings.object,
            data=settings.set,
            mocks=scripted(settings.mocks),
            faults=settings.faults,
            journal=self.journal,
            watchdog=self._watchdog,
            picture=None if self.view is None else self.pictures / picture_of(f"{variant}@{seed}"),
            view=self.view or "",
            apart=True,
            motion=alone or self._drawn,
        )


class Seat(Closing):
    """Where trials run one after the other: in one process as long as nothing goes wrong in it, and `MOST` at most."""

    def __init__(self, trials: Trials):
        self._trials, self._count = trials, 0
        self._process: RunProcess | None = None

    def run(self, variant: str, seed: int) -> TrialRow | None:
        """Run a trial and return its row; None where it was stopped."""
        if self._process is not None and (self._count >= MOST or not self._process.waits):
            self.close()
        if self._process is None and not self._trials.fresh:
            self._process, self._count = RunProcess(terminal=False), 0
        row, self._count = self._trials.once_or_twice(variant, seed, self._process), self._count + 1
        if row is not None and row["status"] in _WRONG:
            self.close()
        return row

    def close(self) -> None:
        """Have the process end."""
        if self._process is not None:
            self._process.close()
            self._process = None


_KNOWN = ("status", "outcome", "code", "contradicted", "duration", "wall", "objects", *STATES)
"""What is known of every trial; the referee's numbers are None where there is none."""


def check(campaign: Campaign) -> None:
    """Find what is wrong before anything runs: tasks, inputs, mocks, counted nodes, names in expressions.

    Raises:
        DocumentError, InvalidTaskError: a task is wrong.
        CampaignError: the campaign speaks of what its tasks don't have.
        UntrustedCodeError: a task runs code that isn't GRIP's, which is forbidden.
    """
    said = campaign.file
    for name in said.count:
        if name in _KNOWN:
            raise campaign.error(f"{name!r} is known of every trial already; choose another name")
    for variant, settings in said.variants.items():
        project, document, _, nodes = check_task(campaign.task(variant), world=settings.world)
        check_inputs(document, settings.set)
        mocks = scripted(settings.mocks)
        task, catalog, _ = apply_mocks(document.task, nodes, mocks)
        refuse(of_task(project, task, catalog, said.robot, mocks))
        paths = [part.path for part in resolve(document.task, nodes).root.walk()]
        check_nodes(settings.faults, paths)
        for name, path in said.count.items():
            if path not in paths:
                raise campaign.error(f"count/{name}: {variant!r} has no node {path!r}{nearest(path, paths)}")
        variables = {*document.task.inputs, *document.task.variables}
        for given in settings.set:
            if given not in variables:
                raise campaign.error(f"{variant}/set: the task has no variable {given!r}{nearest(given, variables)}")
        simulated = said.robot == "sim" and project.file.world
        conditions = world_of(project, campaign.seeds[0], object=settings.object).judge if simulated else {}
        names = {*_KNOWN, *said.count, *variables, *conditions}
        for place, text in (("success", said.success), *((f"measure/{k}", v) for k, v in said.measure.items())):
            try:
                parsed = parse_expression(text)
            except ExpressionError as error:
                raise campaign.error(f"{place}: {error}") from error
            for name in parsed.names:
                if name not in names:
                    known = ", ".join((*_KNOWN, "the names below `count`", *conditions, "the task's variables"))
                    raise campaign.error(f"{place}: unknown name {name!r}{nearest(name, names)} (available: {known})")


def judged(campaign: Campaign, end: RunEnd, wall: float, started: Mapping[str, str] | None) -> TrialRow:
    """Return what came of a trial that took `wall` [s] in all, from its events `started`, if any, and `ended`.

    `truth`: object -> the referee's word; `contradicted`: whether that contradicts a success; `unconfirmed`: what
    couldn't be confirmed to have stopped, in words; `unclear`: what couldn't be computed, with the reason.
    """
    truth = end.get("truth")
    row: TrialRow = {
        "status": end["status"],
        "outcome": end.get("outcome"),
        "code": end.get("code"),
        "message": end.get("message", ""),
        "duration": end.get("duration"),
        "wall": round(wall, 3),
        "run": started["run"] if started else None,
        "truth": truth,
        "contradicted": bool(end.get("contradiction")),
        "judged": end.get("judged") or {},
        "unconfirmed": str(Rest(unconfirmed=end.get("unconfirmed") or {})),
    }
    counts, variables = _looked_up(campaign, started)
    states = Counter((truth or {}).values())
    seen = {state: None if truth is None else states[state] for state in STATES}
    seen["objects"] = None if truth is None else len(truth)
    told = ("status", "outcome", "code", "duration", "contradicted", "wall")
    facts = {**variables, **row["judged"], **seen, **counts, **{key: row.get(key) for key in told}}
    unclear: dict[str, str] = {}
    measures = {name: _computed(text, facts, unclear, name, value_of) for name, text in campaign.file.measure.items()}
    success = bool(_computed(campaign.file.success, facts, unclear, "success", condition_of))
    return {**row, "counts": counts, "measures": measures, "success": success, "unclear": unclear}


def _looked_up(campaign: Campaign, started: Mapping[str, str] | None) -> tuple[dict[str, int], dict[str, object]]:
    counts = dict.fromkeys(campaign.file.count, 0)
    if started is None:
        return counts, {}
    with JournalReader(started["journal"]) as reader:
        begun = Counter(event.path for event in reader.iterate(started["run"]) if event.event == "enter")
        variables = {name: reader.value(event) for name, event in reader.variables(started["run"]).items()}
    return {name: begun[path] for name, path in campaign.file.count.items()}, variables


def _computed(
    text: str,
    facts: Mapping[str, object],
    unclear: dict[str, str],
    name: str,
    compile_: _Compile,
) -> Plain:
    parsed = parse_expression(text)
    missing = [each for each in parsed.names if each not in facts]
    if missing:
        unclear[name] = f"{missing[0]} was never written"
        return None
    try:
        value = compile_(parsed, {each: (lambda each=each: facts[each]) for each in parsed.names})()
    except EvaluationError as error:
        unclear[name] = str(error)
        return None
    return value if isinstance(value, bool | int | float | str | None) else str(value)
