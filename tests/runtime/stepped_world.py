"""A world without physics that takes turns with a run, and leaves whose work is answered sooner or later."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable
from typing import Any

from timed import ManualClock

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.nodes import OperationLeaf
from grip_bt.nodes.node import Observer
from grip_bt.runtime import RunContext, Runner, RunParts
from grip_bt.runtime.lockstep import Lockstep
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

STEP = 0.01
"""Time goes in steps of this [s]."""


class SteppedWorld:
    """Implements `grip_bt.base.ports.Stepped`; motions take as long as they are said to take."""

    def __init__(self, delay: Callable[[], float]):
        self.clock, self.sent, self.free, self._delay = ManualClock(), 0, True, delay
        self._motions: list[tuple[float, Operation[float]]] = []
        self._in_turn: Any = None
        self._lock = threading.Lock()
        self._standing = threading.Event()

    def move(self, seconds: float) -> Operation[float]:
        """Begin a motion."""
        self.sent += 1
        operation: Operation[float] = Operation(on_cancel=lambda: operation.fail(CanceledError("canceled")))
        with self._lock:
            self._motions.append((self.clock.now() + seconds, operation))
        return self._in_turn(operation, holds=False)

    def keep_to_simulated(self, only: bool) -> None:
        """Its clock knows no other time."""

    def take_turns(self, in_turn: Any, stood: Callable[[], None]) -> None:
        self._in_turn, self._stood, self.free = in_turn, stood, False

    def go(self, until: float | None) -> bool:
        self._standing.clear()
        threading.Thread(target=self._go, args=(until,), daemon=True).start()
        return True

    def stand(self) -> None:
        self._standing.set()

    def go_freely(self) -> None:
        self.free = True
        self._standing.set()

    def _go(self, until: float | None) -> None:
        time.sleep(self._delay())
        while not self._standing.is_set():
            with self._lock:
                over = [operation for end, operation in self._motions if end <= self.clock.now()]
                self._motions = [(end, operation) for end, operation in self._motions if operation not in over]
            ended = [operation.succeed(self.clock.now()) for operation in over]
            if any(ended) or (until is not None and self.clock.now() >= until):
                break
            self.clock.advance(STEP)
        self._stood()


class Asking(OperationLeaf):
    """Asks for something, moves, or works in a thread that does; by its name."""

    world: SteppedWorld
    delay: Callable[[], float]

    def start(self) -> Operation[Any]:
        lockstep = self.context.lockstep
        match self.name.rstrip("0123456789"):
            case "ask":
                return lockstep.through(self._answered())
            case "move":
                return self.world.move(self._seconds())
            case "plan":
                plan = lockstep.through(self._answered(), patient=True)
                return plan.then(lambda _: self.world.move(self._seconds()))
            case "work":
                return self.context.run_in_worker(self._work)
            case "never":
                return lockstep.through(Operation())
        raise LookupError(self.name)

    def finish(self, result: Any) -> Any:
        return self.end(x=self.context.clock.now())

    def _seconds(self) -> float:
        return (sum(map(ord, self.path)) % 7) * 0.03  # some end in the same step

    def _answered(self) -> Operation[int]:
        operation: Operation[int] = Operation()
        threading.Timer(self.delay(), operation.succeed, [1]).start()
        return operation

    def _work(self) -> float:
        time.sleep(self.delay())
        moved = self.context.lockstep.through(self._answered()).then(lambda _: self.world.move(self._seconds()))
        moved.wait()
        time.sleep(self.delay())
        return moved.result()


class Trace(Observer):
    """What happened, in order and with the run's time."""

    def __init__(self, clock: Any):
        self.events: list[tuple[Any, ...]] = []
        self._now = clock.now

    def entered(self, path: str) -> None:
        self.events.append((self._now(), path, "enter"))

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        self.events.append((self._now(), path, outcome, None if failure is None else failure.code))

    def interrupted(self, path: str) -> None:
        self.events.append((self._now(), path, "interrupted"))

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        self.events.append((self._now(), path, variable, value))


KINDS = ("ask", "move", "plan", "work", "never")
CATALOG = Catalog(
    Manifest(
        id=f"test/{kind}",
        doc="Something that takes a while.",
        implementation="tests:Leaf",
        outputs={"x": {"type": "float", "on": ["success"]}},
    )
    for kind in KINDS
)


def runner_of(target: Any, root: dict[str, Any], delays: int) -> tuple[Runner, Trace, SteppedWorld]:
    """Return a run that takes turns with a world; `delays` is the seed of what it doesn't depend on."""
    rng, lock = random.Random(delays), threading.Lock()

    def delay() -> float:
        with lock:
            return rng.choice((0.0, 0.0, 0.001, 0.004))

    world = SteppedWorld(delay)

    def make(path: str, node: Any, manifest: Manifest) -> Asking:
        leaf = Asking(path.rsplit("/", 1)[-1], path, manifest, {}, {})
        leaf.world, leaf.delay = world, delay
        return leaf

    data = {"last": "float"}
    task = Task.model_validate({"grip": 1, "name": "run", "root": root, "data": data})
    compiled = target(task, CATALOG, leaf_factory=make)
    context = RunContext(world.clock, RunParts(lockstep=Lockstep(world)))
    runner = Runner(compiled, context)
    trace = Trace(world.clock)
    runner.observe(trace)
    return runner, trace, world
