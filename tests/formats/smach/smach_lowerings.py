"""Runs an imported machine in each of its forms, with leaves that take a set number of ticks, and preempts it."""

import random
import re
import time
from collections import defaultdict
from zlib import crc32

from smach_sources import LAST

from grip_bt import smach_compat
from grip_bt.app.project.catalogue import project_catalog
from grip_bt.compilers import to_machine, to_tree
from grip_bt.compilers.restructure import to_trees
from grip_bt.nodes import smach_leaf
from grip_bt.nodes.smach_source import load_legacy
from grip_bt.runtime import RunContext, Runner
from grip_bt.smach_compat import InvalidStateError, InvalidTransitionError, InvalidUserCodeError
from grip_bt.task import read

LIMIT = 120.0  # [s] beyond what any of these machines takes
FORMS = ("dispatch", "structured", "machine")
PATIENCE = 50  # [ms] how long a tick waits for an execute() that takes no tick
TICKS = 4  # leaves take 0 to 3 ticks
STUMBLES = re.compile(r"which is none of (the Iterator's|its outcomes)")


class PacedActivation(smach_leaf.Activation):
    """An activation that is seen to have ended after 0 to 3 ticks, and never before it has."""

    ticks = staticmethod(lambda path, number: 0)
    numbers: defaultdict = defaultdict(int)

    def __init__(self, state, values, name, wake):
        self._left = self.ticks(name, self.numbers[name])
        self.numbers[name] += 1
        self._context, self._wake = values._leaf.context, wake
        super().__init__(state, values, name, wake)

    def done(self):
        self._left -= 1
        if self._left >= 0:
            self._wake()
            return False
        # A state that has asked for a preempt waits for it, and it comes with a tick; one that waits for its turn in a
        # Concurrence may need a sibling that the task ticks later.
        for _ in range(PATIENCE):
            if self.over.wait(0.001):
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
    legacy.MADE.clear()
    legacy.WORLD.update(activations=0, preempt_at=tuple(preempt_at), request=request)
    return legacy


class StuckError(BaseException):
    """What was waited for hasn't come; no error of user code."""


def _await(condition, what):
    deadline = time.monotonic() + LIMIT
    while not condition():
        if time.monotonic() > deadline:
            raise StuckError(what)
        time.sleep(0.001)


def _has_returned(legacy, state):
    """Tell whether a state has been executed and isn't any more, as far as it knows itself."""
    return 0 < state.runs == legacy.ENDED.get(state.path) and state.path not in legacy.WAITING


def run_form(path, file, form, preempt_at=(), pace=0, before=0):
    """Return (outcome, trace) of an imported task in one of its forms; the outcome is None after an error.

    Args:
        path: the task's file.
        file: the legacy file.
        form: one of FORMS.
        preempt_at: numbers of the activations in which a preempt is asked for.
        pace: seed of how many ticks each activation takes.
        before: how often a preempt is asked for before the run begins.
    """
    runner, leaves = _runner(path, form, pace)

    def request(state):
        for leaf in leaves:  # what has returned has ended, whether or not the task has seen it
            activation = leaf._activation
            if leaf.state is not state and _has_returned(legacy, leaf.state) and activation is not None:
                _await(activation.over.done, "a state never returned")
                if form == "machine":  # its thread has to have seen that, else the request reaches a state that is over
                    _await(lambda leaf=leaf: not leaf.active, "a state never ended")
        by_path = {leaf.state.path: leaf for leaf in leaves}
        for last in _lasts_before(state, {path: leaf.state for path, leaf in by_path.items()}):
            if last.endswith(f"/{LAST}"):
                branch = by_path[last].enclosing[-1]
                _await(lambda branch=branch: not branch.runs(), "a branch never ended")
        runner.request_preempt()
        _await_arrival(runner, leaves)

    legacy = fresh(file, preempt_at, request)
    for _ in range(before):
        runner.request_preempt()
    result = runner.run()
    if result.error is not None:
        assert STUMBLES.search(str(result.error)), result.error
    return None if result.error is not None else result.outcome, [list(row) for row in legacy.TRACE]


def _runner(path, form, pace):
    compiled, leaves = compiled_as(path, form, pace)
    return Runner(compiled, RunContext()), leaves


def compiled_as(path, form, pace):
    """Return the compiled task in one of its forms, and its legacy states; other arguments as for `run_form`."""
    task, catalog = read(path).task, project_catalog(path)
    if form == "structured":
        task = to_trees(task, catalog).task
    compiled = (to_machine if form == "machine" else to_tree)(task, catalog)
    PacedActivation.numbers.clear()
    drawn = lambda name, number: crc32(f"{pace} {name} {number}".encode()) % TICKS if pace else 0  # noqa: E731
    PacedActivation.ticks = staticmethod(drawn)
    return compiled, [leaf for leaf in compiled.leaves.values() if isinstance(leaf, smach_leaf.SmachLeaf)]


def _await_arrival(runner, leaves):
    _await(lambda: leaves[0].asking._seen == runner.context.preempt_requests, "the request never arrived")


def run_imported(path, form, pace, before, give_request):
    """Return the outcome of a task in one of its forms, None after an error.

    Args:
        path: the task's file.
        form: one of FORMS.
        pace: seed of how many ticks each activation takes.
        before: how often a preempt is asked for before the run begins.
        give_request: gets a function of a state that asks for a preempt and waits until it has arrived.
    """
    runner, leaves = _runner(path, form, pace)

    def request(state):
        runner.request_preempt()
        _await_arrival(runner, leaves)

    give_request(request)
    for _ in range(before):
        runner.request_preempt()
    result = runner.run()
    return None if result.error is not None else result.outcome


def run_compat(file, preempt_at=(), before=0):
    """Return (outcome, trace) of the machine itself; the outcome is None after an error."""
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)

    def request(state):
        around, place = _concurrence(machine, state.path)
        if around is None:
            return machine.request_preempt()
        for last in _lasts_before(state, legacy.MADE):
            label = last[len(place) :].split("/")[1]
            _await(lambda label=label: around._child_outcomes[label] is not None, "a branch never ended")
        for label, sibling in around.get_children().items():
            if sibling is not state and hasattr(sibling, "path") and _has_returned(legacy, sibling):
                _await(lambda label=label: around._child_outcomes[label] is not None, "a child never ended")
        before = around._woken
        machine.request_preempt()
        if around._woken and not before:  # it asks its children from its own thread, once
            asked = [state, *legacy.WAITING.values()]
            _await(lambda: all(each.preempt_requested() for each in asked), "the request never arrived")
        return None

    legacy = fresh(file, preempt_at, request)
    machine = legacy.build()
    for _ in range(before):
        machine.request_preempt()
    try:
        outcome = machine.execute()
    except (InvalidTransitionError, InvalidUserCodeError, InvalidStateError):
        outcome = None
    outcome = outcome if outcome in machine.get_registered_outcomes() else None
    return outcome, [list(row) for row in legacy.TRACE]


def _lasts_before(state, states):
    """Yield the last states of the branches before that of a state."""
    after = state.after
    while after is not None:
        yield after
        after = states[after].after


def _concurrence(machine, path):
    """Return the Concurrence that a state is in, and its path."""
    *above, _ = path.strip("/").split("/")
    found, place = (machine if isinstance(machine, smach_compat.Concurrence) else None), ""
    for number, label in enumerate(above):
        machine = machine[label]
        if isinstance(machine, smach_compat.Concurrence):
            found, place = machine, "".join(f"/{each}" for each in above[: number + 1])
    return found, place


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
        spec = self.state_machine(2)
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
        kind = self.random.random()
        if depth < 2 and kind < 0.3:
            return self.concurrence()
        return self.iterator(depth) if kind < 0.5 else self.state_machine(depth)

    def iterator(self, depth):
        """Return an Iterator over a few items, whose state may be a container."""
        child = self.container(depth - 1) if depth and self.random.random() < 0.4 else self.leaf()
        loops = self.some(child["outcomes"], 0, len(child["outcomes"]))
        breaks = [outcome for outcome in child["outcomes"] if outcome not in loops]
        outcomes = list(dict.fromkeys([*self.some(self.NAMES), "exhausted"]))
        final = {o: self.random.choice(outcomes) for o in child["outcomes"] if o not in outcomes or o in loops}
        if self.random.random() < 0.2:  # a preempted Iterator may end with what is none of its outcomes
            final = {o: target for o, target in final.items() if o not in loops}
        return {
            "kind": "iter",
            "outcomes": outcomes,
            "items": list(range(self.random.randint(0, 3))),
            "label": self.random.choice(self.KEYS),
            "state": "IT",
            "child": child,
            "loop": loops,
            "break": breaks,
            "final": final,
            "exh": "exhausted",
        } | self.keys()

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
            states.append([label, child, table, self.remapping(child["in"])])
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
        children = []
        for number, key in enumerate(self.random.sample(self.KEYS, self.random.randint(2, 3))):
            leaf = self.leaf() | {
                "in": [key],
                "out": [key],
            }  # each its own key: what siblings write is seen later
            children.append([f"C{number}", leaf, {}])
        table = {"succeeded": {label: child["outcomes"][0] for label, child, _ in children}}
        keys = list(self.KEYS)
        return {
            "kind": "conc",
            "outcomes": ["succeeded", "aborted", "preempted"],
            "default": "aborted",
            "map": table,
            "children": children,
            "in": keys,
            "out": keys,
        }


def per_path(trace):
    """Return path -> its activations."""
    rows = defaultdict(list)
    for path, *rest in trace:
        rows[path].append(rest)
    return dict(rows)
