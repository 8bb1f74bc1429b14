import asyncio
import threading

import pytest
from py_trees.common import Status

from grip_bt.base.failures import NoGraspError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Context
from grip_bt.base.types import parse_type
from grip_bt.base.values import Grasp, PointCloud
from grip_bt.nodes.function import leaf, type_name


def make(cls, context, data=None, inputs=None, **params):
    defaults = {n: p.default for n, p in cls.face.parameters.items()}
    node = cls("leaf", "task/leaf", cls.face, {**defaults, **params}, {})
    for port, value in (inputs or {}).items():
        node.readers[port] = lambda value=value: value
    for port in cls.face.outputs:
        node.writers[port] = lambda value, port=port: data.__setitem__(port, value)
    node.setup(context=context)
    return node


@leaf("test/scale", outputs={"scaled": float})
def scale(value: float, offset: float = 0.0, *, factor: float = 2.0) -> float:
    """Scale a value."""
    return value * factor + offset


def test_annotations_make_the_manifest():
    face = scale.face
    assert (face.id, face.doc) == ("test/scale", "Scale a value.")
    assert {n: (p.type, p.required) for n, p in face.inputs.items()} == {
        "value": ("float", True),
        "offset": ("float", False),
    }
    assert face.parameters["factor"].default == 2.0
    assert face.outputs["scaled"].type == "float"


@pytest.mark.parametrize(
    ("hint", "name"),
    [
        (int, "int"),
        (list[Grasp], "list[Grasp]"),
        (PointCloud | None, "PointCloud | None"),
        (dict[str, int], "dict[str, int]"),
    ],
)
def test_type_names_are_those_of_manifests(hint, name):
    assert type_name(hint) == name
    parse_type(name)


def test_a_function_gets_inputs_and_parameters_and_fills_the_output(world, tick):
    data = {}
    node = make(scale, world.context, data, {"value": 3.0}, factor=10.0)
    assert tick(node) == ("SUCCESS", "success", None)
    assert data == {"scaled": 30.0}
    node = make(scale, world.context, data, {"value": 3.0, "offset": 1.0})
    tick(node)
    assert data == {"scaled": 7.0}


def test_a_function_runs_in_a_worker_and_not_in_the_tick(world, tick):
    data = {}
    world.context.defer = True
    node = make(scale, world.context, data, {"value": 1.0})
    assert tick(node)[0] == "RUNNING"
    world.context.work()
    assert world.context.wakes == 1
    assert tick(node)[0] == "SUCCESS"


def test_expected_trouble_is_a_failure_and_anything_else_a_bug(world, tick):
    @leaf("test/refuse", codes=("no_grasp",))
    def refuse(*, bug: bool):
        """Fail."""
        raise KeyError("oops") if bug else NoGraspError("none")

    assert tick(make(refuse, world.context, bug=False)) == ("FAILURE", "failure", "no_grasp")
    with pytest.raises(Exception, match="KeyError"):
        tick(make(refuse, world.context, bug=True))


def test_several_outputs_come_as_a_mapping_with_exactly_their_names(world, tick):
    @leaf("test/split", outputs={"a": int, "b": int})
    def split(*, good: bool):
        """Split."""
        return {"a": 1, "b": 2} if good else {"a": 1}

    data = {}
    tick(make(split, world.context, data, good=True))
    assert data == {"a": 1, "b": 2}
    with pytest.raises(Exception, match="return a mapping with the keys"):
        tick(make(split, world.context, data, good=False))


def test_what_is_annotated_context_gets_the_context(world):
    @leaf("test/time", outputs={"time": float})
    def now(context: Context) -> float:
        """Tell the time."""
        return context.clock.now()

    data = {}
    assert not now.face.inputs
    make(now, world.context, data).tick_once()
    assert data == {"time": 100.0}


def test_a_parameter_without_annotation_is_refused_when_the_leaf_is_made():
    with pytest.raises(TypeError, match="'x' needs an annotation"):

        @leaf("test/bad")
        def bad(x):
            """Nothing."""


class ThreadContext:
    """Runs work in real threads."""

    preempt_requested = False

    def __init__(self):
        self.woken = threading.Event()

    def left(self, path, work):
        """Nothing here takes its time to stop."""

    def unfinished(self):
        return ()

    def wake(self):
        self.woken.set()

    def run_in_worker(self, work):
        operation = Operation()

        def run():
            try:
                operation.succeed(work())
            except BaseException as error:  # noqa: BLE001
                operation.fail(error)

        threading.Thread(target=run, daemon=True).start()
        return operation


def test_a_coroutine_runs_to_its_end():
    @leaf("test/slow", outputs={"answer": int})
    async def slow(value: int) -> int:
        """Wait a turn of the loop."""
        await asyncio.sleep(0)
        return value + 1

    data, context = {}, ThreadContext()
    node = make(slow, context, data, {"value": 1})
    node.tick_once()
    while node.status == Status.RUNNING:  # it may have ended within the first tick already
        assert context.woken.wait(120)
        context.woken.clear()
        node.tick_once()
    assert (node.status, data) == (Status.SUCCESS, {"answer": 2})


def test_a_halt_cancels_a_coroutine_where_it_waits():
    began, canceled = threading.Event(), threading.Event()

    @leaf("test/endless")
    async def endless():
        """Wait for ever."""
        began.set()
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            canceled.set()
            raise

    context = ThreadContext()
    node = make(endless, context)
    node.tick_once()
    assert began.wait(120)
    node.stop(Status.INVALID)
    assert canceled.wait(120)
    assert context.woken.wait(120)
