"""Runs an imported machine in each of its forms, with leaves that take a set number of ticks, and preempts it."""

import random
import time
from collections import defaultdict
from zlib import crc32

from grip_bt import smach_compat
from grip_bt.app.project import find_project
from grip_bt.compilers import to_machine, to_tree
from grip_bt.compilers.restructure import to_trees
from grip_bt.graph import read
from grip_bt.nodes import smach_leaf
from grip_bt.nodes.smach_source import load_legacy
from grip_bt.runtime import RunContext, Runner

LIMIT = 20.0  # [s] beyond what any of these machines takes
FORMS = ("dispatch", "structured", "machine")
PATIENCE = 50  # [ms] how long a tick waits for an execute() that takes no tick
TICKS = 4  # leaves take 0 to 3 ticks


class PacedActivation(smach_leaf._Activation):
    """An activation that is seen to have ended after 0 to 3 ticks, and never before it has."""

    ticks = staticmethod(lambda path, number: 0)
    numbers: defaultdict = defaultdict(int)

    def __init__(self, state, values, name, wake, asked):
        self._left = self.ticks(name, self.numbers[name])
        self.numbers[name] += 1
        self._context, self._wake = values._leaf.context, wake
        super().__init__(state, values, name, wake, asked)

    def done(self):
        self._left -= 1
        if self._left >= 0:
            self._wake()
            return False
        # A state that has asked for a preempt waits for it, and it comes with a tick; one that waits for its turn in a
        # Concurrence may need a sibling that the task ticks later.
        for _ in range(PATIENCE):
            if self._ended.wait(0.001):
                return True
            if self._context.preempt_requested:
                break
        self._wake()
        return False


def fresh(file, preempt_at, request):
    """Return the legacy module as if it had just been imported."""
    legacy = load_legacy(file)
    legacy.TRACE.clear()
    legacy.ENDED.clear()
    legacy.WAITING.clear()
    legacy.WORLD.update(activations=0, preempt_at=preempt_at, request=request)
    return legacy


def _await_request(legacy, state):
    """Wait until a request has reached a state and its siblings that wait for their turn.

    It comes with a tick, and to the children of a Concurrence from its own thread.
    """
    deadline = time.monotonic() + LIMIT
    while not all(each.preempt_requested() for each in [state, *list(legacy.WAITING.values())]):
        assert time.monotonic() < deadline, "the request never arrived"
        time.sleep(0.001)


def run_form(path, file, form, preempt_at=None, pace=0, before=False):
    """Return (outcome, trace) of an imported task in one of its forms.

    Args:
        path: the task's file.
        file: the legacy file.
        form: one of FORMS.
        preempt_at: number of the activation in which a preempt is asked for.
        pace: seed of how many ticks each activation takes.
        before: whether a preempt is asked for before the run begins.
    """
    task, catalog = read(path).task, find_project(path).catalog()
    if form == "structured":
        task = to_trees(task, catalog).task
    compiled = (to_machine if form == "machine" else to_tree)(task, catalog)
    runner = Runner(compiled, RunContext())

    def request(state):
        runner.request_preempt()
        _await_request(legacy, state)

    legacy = fresh(file, preempt_at, request)
    PacedActivation.numbers.clear()
    # Children of a Concurrence take a tick at least: a sibling that answers a request in the tick in which they begin
    # answers it for them, see docs/porting.md.
    least = 1 if preempt_at is not None else 0

    def ticks(name, number):
        drawn = crc32(f"{pace} {name} {number}".encode()) % TICKS if pace else 0
        return max(least, drawn) if name.rpartition("/")[2].startswith("C") else drawn

    PacedActivation.ticks = staticmethod(ticks)
    if before:
        runner.request_preempt()
    result = runner.run()
    assert result.error is None, result.error
    return result.outcome, [list(row) for row in legacy.TRACE]


def run_compat(file, preempt_at=None, before=False, twice=False):
    """Return (outcome, trace) of the machine itself."""
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)

    def request(state):
        machine.request_preempt()
        _await_request(legacy, state)

    legacy = fresh(file, preempt_at, request)
    machine = legacy.build()
    for _ in range(before + twice):
        machine.request_preempt()
    return machine.execute(), [list(row) for row in legacy.TRACE]


class Draw:
    """Random machines in the words of the golden file: nested, remapped, with Concurrences of states."""

    KEYS = ("a", "b", "c", "d")
    NAMES = ("succeeded", "aborted", "preempted", "x1", "x2")

    def __init__(self, seed):
        self.random = random.Random(seed)

    def some(self, names, least=1, most=3):
        return self.random.sample(names, self.random.randint(least, min(most, len(names))))

    def machine(self):
        """Return a spec of a root."""
        spec = self.container(2)
        spec["ud"] = {key: self.random.randint(0, 9) for key in self.KEYS}
        spec["in"] = spec["out"] = []
        return spec

    def leaf(self):
        keys = self.some(self.KEYS, 0, 2)
        outcomes = self.some(self.NAMES)
        script = [self.random.randrange(len(outcomes)) for _ in range(self.random.randint(1, 4))]
        mode = self.random.choice(("ignore", "service", "serve_outcome"))
        return {"kind": "leaf", "outcomes": outcomes, "script": script, "in": keys, "out": keys, "preempt": mode}

    def container(self, depth):
        if depth < 2 and self.random.random() < 0.3:
            return self.concurrence()
        return self.state_machine(depth)

    def state_machine(self, depth):
        outcomes = self.some(self.NAMES)
        labels = [f"S{number}" for number in range(self.random.randint(1, 4))]
        states = []
        for number, label in enumerate(labels):
            child = self.container(depth - 1) if depth and self.random.random() < 0.4 else self.leaf()
            ends = [*labels[number + 1 :], *outcomes]  # forward, so that every machine ends ...
            table = {outcome: self.random.choice(ends) for outcome in child["outcomes"]}
            if len(child.get("script", ())) > 1 and len(child["outcomes"]) > 1:
                steps = {child["outcomes"][step] for step in child["script"]}
                if len(steps) > 1:  # ... but a state that has two ends in its script may go back by one of them
                    table[child["outcomes"][child["script"][0]]] = self.random.choice(labels[: number + 1])
            remapping = {} if child["kind"] == "conc" else self.remapping(child["in"])
            states.append([label, child, table, remapping])
        return {
            "kind": "sm",
            "outcomes": outcomes,
            "initial": None,
            "states": states,
            "in": [],
            "out": [],
        } | self.keys()

    def keys(self):
        keys = self.some(self.KEYS, 0, 3)
        return {"in": keys, "out": keys}

    def remapping(self, keys):
        return (
            dict(zip(keys, self.random.sample(self.KEYS, len(keys)), strict=True)) if self.random.random() < 0.4 else {}
        )

    def concurrence(self):
        children, mode = [], self.random.choice(("ignore", "service"))  # all answer a request or none: see porting.md
        for number, key in enumerate(self.random.sample(self.KEYS, self.random.randint(2, 3))):
            leaf = self.leaf() | {
                "in": [key],
                "out": [key],
                "preempt": mode,
            }  # each its own key: what siblings write is seen later
            children.append([f"C{number}", leaf, {}])
        table = {"succeeded": {label: child["outcomes"][0] for label, child, _ in children}}
        keys = list(self.KEYS)
        return {
            "kind": "conc",
            "outcomes": ["succeeded", "aborted"],
            "default": "aborted",
            "map": table,
            "children": children,
            "in": keys,
            "out": keys,
        }


def enters_a_concurrence_preempted(trace, at):
    """Tell whether a Concurrence begins after the request, which SMACH's doesn't pass on and a task's parallel does."""
    begun = trace[at][0].rpartition("/")[0] if at is not None else None
    later = [path for path, *_ in trace[0 if at is None else at :] if path.rpartition("/")[2].startswith("C")]
    return len(set(later)) < len(later) or any(path.rpartition("/")[0] != begun for path in later)


def finds_an_old_request(trace):
    """Tell whether a state is asked after others no longer were: by a flag that a nested machine was left with."""
    asked = [row[-1] for row in trace]
    answered = asked.index(False, asked.index(True)) if True in asked and False in asked[asked.index(True) :] else None
    return answered is not None and any(asked[answered:])


def per_path(trace):
    """Return path -> its activations."""
    rows = defaultdict(list)
    for path, *rest in trace:
        rows[path].append(rest)
    return dict(rows)
