import logging
import threading

import pytest
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.nodes.node import Observer
from grip_bt.nodes.smach_leaf import NextItem, SmachLeaf, task_name
from grip_bt.smach_compat import State
from grip_bt.task.catalog import Catalog
from grip_bt.task.catalog.manifest import Manifest

WAIT = 120  # s; only a broken leaf takes so long


class Context:
    def __init__(self):
        self.clock = type("Clock", (), {"now": lambda self: 0.0})()
        self.preempt_requested = False
        self.woken = threading.Semaphore(0)

    def wake(self):
        self.woken.release()

    def left(self, path, work):
        pass

    def unfinished(self):
        return ()


class Legacy(State):
    """A state that does what the test says, when it says so."""

    def __init__(self, work=lambda state, ud: "done", inputs=(), outputs=(), block=False):
        State.__init__(self, ["done", "preempted"], input_keys=list(inputs), output_keys=list(outputs))
        self.work, self.calls = work, 0
        self.entered, self.go = threading.Semaphore(0), threading.Semaphore(0)
        self.block = block

    def execute(self, userdata):
        self.calls += 1
        self.entered.release()
        if self.block:
            assert self.go.acquire(timeout=WAIT)
        return self.work(self, userdata)


def make(state, context, inputs=None, written=None, first=None, **params):
    face = Manifest(
        id="smach/test/Legacy",
        doc="Legacy.",
        implementation="test:Legacy",
        inputs={k: {"type": "Any", "required": False} for k in state.get_registered_input_keys()},
        outputs={k: {"type": "Any"} for k in state.get_registered_output_keys()},
        outcomes={"done": "success", "preempted": "failure"},
    )
    cls = type("Legacy", (SmachLeaf,), {"make": lambda self: state, "first": first or {}})
    leaf = cls("leaf", "task/leaf", face, params, {})
    for port, value in (inputs or {}).items():
        leaf.readers[port] = lambda value=value: value
    for port in face.outputs:
        leaf.writers[port] = lambda value, port=port: written.__setitem__(port, value)
    leaf.setup(context=context)
    return leaf


def tick(leaf):
    leaf.tick_once()
    return leaf.status


def run(leaf, context):
    while tick(leaf) == Status.RUNNING:
        assert context.woken.acquire(timeout=WAIT), "the end of execute() wakes the task"
    return leaf.outcome


def test_the_state_reads_and_writes_variables_and_its_end_wakes_the_task():
    context, written = Context(), {}

    def work(state, ud):
        ud.total = ud.a + 1
        ud.total = ud.total + ud.a  # sees its own write
        return "done"

    leaf = make(Legacy(work, ["a", "total"], ["total"]), context, {"a": 3}, written)
    assert run(leaf, context) == "done"
    assert written == {"total": 7}


def test_nothing_is_written_before_the_state_ends():
    context, written = Context(), {}

    def work(state, ud):
        ud.total = 1
        state.entered.release()
        assert state.go.acquire(timeout=WAIT)
        return "done"

    state = Legacy(work, outputs=["total"])
    leaf = make(state, context, written=written)
    assert tick(leaf) == Status.RUNNING
    assert state.entered.acquire(timeout=WAIT)
    assert state.entered.acquire(timeout=WAIT)
    assert written == {}
    state.go.release()
    assert run(leaf, context) == "done"
    assert written == {"total": 1}


def test_an_unbound_or_unwritten_key_is_missing_as_in_smach():
    context, seen = Context(), []

    def work(state, ud):
        seen.extend(("a" in ud, "b" in ud, "c" in ud))
        return "done"

    leaf = make(Legacy(work, ["a", "b", "c"]), context, {"b": None, "c": None}, unwritten=["b"])
    run(leaf, context)
    assert seen == [False, False, True]


def test_a_first_value_is_asked_for_once_per_run():
    context, seen, asked = Context(), [], []

    def first(leaf):
        asked.append(leaf.path)
        return object()

    state = Legacy(lambda state, ud: seen.append(ud.a) or "done", ["a"], ["a"])
    leaf = make(state, context, {"a": None}, {}, {"a": first}, unwritten=["a"])
    run(leaf, context)
    run(leaf, context)
    assert len(asked) == 1
    assert seen[0] is seen[1]


def test_the_object_lives_on_between_activations():
    context = Context()
    state = Legacy()
    leaf = make(state, context)
    run(leaf, context)
    run(leaf, context)
    assert state.calls == 2


def test_an_exception_of_the_state_is_raised_with_the_path():
    context = Context()

    def work(state, ud):
        raise ZeroDivisionError("tries")

    with pytest.raises(NodeError, match="task/leaf: ZeroDivisionError"):
        run(make(Legacy(work), context), context)


@pytest.mark.parametrize(("result", "words"), [(None, "returned None"), ("other", "isn't an outcome")])
def test_what_is_no_outcome_is_an_error(result, words):
    context = Context()
    with pytest.raises(NodeError, match=words):
        run(make(Legacy(lambda state, ud: result), context), context)


def test_sys_exit_in_a_state_ends_the_run_and_not_the_process():
    context = Context()

    def work(state, ud):
        raise SystemExit(1)

    with pytest.raises(NodeError, match="execute\\(\\) raised SystemExit"):
        run(make(Legacy(work), context), context)


def asked(state, ud):
    if state.preempt_requested():
        state.service_preempt()
        return "preempted"
    return "done"


def test_a_preempt_request_reaches_a_running_state():
    context = Context()
    state = Legacy(asked, block=True)
    leaf = make(state, context)
    assert tick(leaf) == Status.RUNNING
    context.preempt_requested = True
    assert tick(leaf) == Status.RUNNING
    state.go.release()
    assert run(leaf, context) == "preempted"


def test_a_request_that_nobody_serviced_travels_to_the_next_state():
    context = Context()
    context.preempt_requested = True
    first, second, third = Legacy(), Legacy(asked), Legacy(asked)
    assert run(make(first, context), context) == "done"
    assert run(make(second, context), context) == "preempted"
    assert not first.preempt_requested()
    assert run(make(third, context), context) == "done"


class Messages(Observer):
    def __init__(self):
        self.texts = []

    def message(self, path, text):
        self.texts.append((path, text))


def test_a_halted_state_is_a_zombie_that_says_so_writes_nothing_and_is_waited_for(caplog):
    context, written, seen = Context(), {}, Messages()

    def work(state, ud):
        ud.total = state.calls
        return "done"

    state = Legacy(work, outputs=["total"], block=True)
    leaf = make(state, context, written=written)
    leaf.observer = seen
    assert tick(leaf) == Status.RUNNING
    assert state.entered.acquire(timeout=WAIT)
    leaf.stop(Status.INVALID)
    assert (state.preempt_requested(), leaf.zombie) == (True, True)
    assert seen.texts == [("task/leaf", "interrupted: execute() was asked to return and still runs")]
    with caplog.at_level(logging.WARNING):
        leaf.shutdown()
    assert "still runs" in caplog.text
    assert tick(leaf) == Status.RUNNING
    assert state.calls == 1, "an object that still runs isn't entered again"
    state.go.release()
    state.go.release()
    assert run(leaf, context) == "done"
    assert (state.calls, leaf.zombie, state.preempt_requested()) == (2, False, False)
    assert written == {"total": 2}, "what the interrupted call wrote is dropped"


def test_a_manifest_that_lacks_an_outcome_of_the_state_is_refused():
    state = Legacy()
    state.register_outcomes(["more"])
    with pytest.raises(TypeError, match="outcomes \\['more'\\]"):
        make(state, Context())


def test_items_come_one_by_one_and_then_no_more():
    data = {"position": 0}
    face = Catalog.builtin().get("smach/next_item")
    leaf = NextItem("next", "next", face, {"items": ["a", "b"], "leaves_by": ""}, {})
    leaf.readers["position"] = lambda: data["position"]
    leaf.writers.update({k: lambda value, k=k: data.__setitem__(k, value) for k in face.outputs})
    ends = []
    for _ in range(3):
        leaf.tick_once()
        ends.append((leaf.outcome, data["item"]))
    assert ends == [("item", "a"), ("item", "b"), ("exhausted", "b")]


@pytest.mark.parametrize(
    ("label", "name"), [("PICK", "PICK"), ("a.b", "a_b"), ("1st", "_1st"), ("x/y z-1", "x_y z-1"), ("", "_")]
)
def test_labels_are_spelled_as_tasks_can(label, name):
    assert task_name(label) == name


def test_a_state_below_a_parallel_that_asks_is_asked_once_each_time():
    context = Context()
    context.preempt_requests = 0
    state = Legacy(asked, block=True)
    leaf = make(state, context)
    leaf.askers.append(type("Parallel", (), {"asked": False})())
    leaf.setup(context=context)
    assert tick(leaf) == Status.RUNNING
    assert not state.preempt_requested()
    leaf.askers[0].asked = True
    assert tick(leaf) == Status.RUNNING
    assert state.preempt_requested()
    state.recall_preempt()
    assert tick(leaf) == Status.RUNNING
    assert not state.preempt_requested(), "a state that has answered isn't asked again"
    state.go.release()
    assert run(leaf, context) == "done"
