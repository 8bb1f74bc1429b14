"""Tasks for the runner: leaves that wait to be told, break, or hang."""

from __future__ import annotations

import threading
from typing import Any

from py_trees.common import Status

from grip_bt.base.operation import Operation
from grip_bt.compilers import to_machine, to_tree
from grip_bt.nodes import Leaf, OperationLeaf
from grip_bt.runtime import Journal, RunContext, Runner, RunResult
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

TARGETS = (to_tree, to_machine)
CATALOG = Catalog(
    Manifest(
        id=f"test/{kind}",
        doc=f"A leaf that can {kind}.",
        implementation="tests:Leaf",
        outputs={"x": {"type": "Any", "on": ["success"]}},
    )
    for kind in ("wait", "end", "break", "unready", "work", "obey", "hang")
)


class Waiting(Leaf):
    """Runs until it is told to end; says when it is ticked, wakes nobody."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.ticked = threading.Semaphore(0)
        self.ticks = 0
        self.told = threading.Event()
        self.terminated: list[Status] = []
        self.was_terminated = threading.Event()

    def update(self) -> Status:
        self.ticks += 1
        self.ticked.release()
        return self.end(x=1) if self.told.is_set() else self.running(f"tick {self.ticks}")

    def terminate(self, new_status: Status) -> None:
        self.terminated.append(new_status)
        self.was_terminated.set()


class Ending(Leaf):
    def update(self) -> Status:
        return self.end(x=[1, 2, 3])


class Breaking(Leaf):
    def update(self) -> Status:
        raise RuntimeError("the arm fell off")


class Unready(Ending):
    def prepare(self) -> None:
        raise ConnectionError("no driver")


class Working(OperationLeaf):
    def start(self) -> Operation[Any]:
        return self.context.run_in_worker(lambda: threading.current_thread().name)

    def finish(self, result: Any) -> Status:
        return self.end(x=result)


class Hanging(Leaf):
    """Its update doesn't return before it is released."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.inside, self.released = threading.Event(), threading.Event()

    def update(self) -> Status:
        self.inside.set()
        self.released.wait(20)
        return self.running()


class Obeying(Waiting):
    def update(self) -> Status:
        status = super().update()
        return self.fail("preempted") if self.context.preempt_requested else status


KINDS = {
    "wait": Waiting,
    "end": Ending,
    "break": Breaking,
    "unready": Unready,
    "work": Working,
    "obey": Obeying,
    "hang": Hanging,
}


def leaf(kind: str, **more: Any) -> dict[str, Any]:
    return {"node": f"test/{kind}", **more}


class Started:
    """A run under way in a thread of its own."""

    def __init__(
        self,
        target: Any,
        root: dict[str, Any],
        context: RunContext | None = None,
        journal: Journal | None = None,
        poll: float | None = None,
        data: dict[str, Any] | None = None,
    ):
        def make(path: str, node: Any, manifest: Manifest) -> Leaf:
            return KINDS[node.node.split("/")[1]](path, path, manifest, {}, {})

        task = Task.model_validate({"grip": 1, "name": "run", "root": root, "data": data or {}})
        self.compiled = target(task, CATALOG, leaf_factory=make)
        self.leaves: dict[str, Any] = self.compiled.leaves
        self.context = context or RunContext()
        self.runner = Runner(self.compiled, self.context, journal=journal, poll=poll)
        self.result: RunResult | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        self.result = self.runner.run()

    def start(self) -> Started:
        self._thread.start()
        return self

    def wait_tick(self, path: str) -> None:
        assert self.leaves[path].ticked.acquire(timeout=120), f"{path} wasn't ticked"

    def join(self) -> RunResult:
        self._thread.join(timeout=120)
        assert self.result is not None, "the run hasn't ended"
        return self.result
