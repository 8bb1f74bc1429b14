"""A task with scripted leaves, ticked by hand on a manual clock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.common import Status
from timed import ManualClock

from grip_bt.compilers import CompiledTree, to_tree
from grip_bt.nodes import Leaf
from grip_bt.task.catalog import AllowedImports, Catalog, Manifest
from grip_bt.task.model import Task

CATALOG = Catalog(
    [
        Manifest(
            id="test/leaf",
            doc="Does what its script says.",
            implementation="tests:Scripted",
            inputs={"a": {"type": "int", "required": False}},
            outputs={"x": {"type": "int"}},
            outcomes={"success": "success", "failure": "failure", "none": "success"},
        )
    ]
).with_(code=AllowedImports(("test_control_foreign", "test_control_foreign:number", "no_such_module")))


def leaf(**more: Any) -> dict[str, Any]:
    """Return the document of a scripted leaf."""
    return {"node": "test/leaf", **more}


class Scripted(Leaf):
    """Its script has one word per activation: a dot per running tick, then outcome or outcome.code; `!` raises."""

    world: World
    script: list[str]

    def initialise(self) -> None:
        self.word = self.script.pop(0) if len(self.script) > 1 else self.script[0]

    def update(self) -> Status:
        self.world.ticked.append(self.path)
        if self.word.startswith("."):
            self.word = self.word[1:]
            return self.running()
        if self.word == "!":
            raise RuntimeError("broken")
        outcome, _, code = self.word.partition(".")
        outputs = {"x": (self.read("a") or 0) + 1} if "x" in self.writers and outcome != "failure" else {}
        return self.fail(code, "as the script says", outcome=outcome) if code else self.end(outcome, **outputs)

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.status == Status.RUNNING:
            self.world.halted.append(self.path)


class World:
    """The compiled tree of `root`, and what happens in it.

    Args:
        root: a document.
        scripts: leaf's name -> its script, words separated by blanks; without one it succeeds at once.
        task: more keys of the task.
    """

    def __init__(self, root: dict[str, Any], scripts: Mapping[str, str] | None = None, **task: Any):
        self.clock = ManualClock()
        self.preempt_requested = False
        self.wakes = 0
        self.wake_times: list[float] = []
        self.ticked: list[str] = []
        self.halted: list[str] = []
        self.events: list[tuple[Any, ...]] = []
        self.scripts = dict(scripts or {})
        document = {"grip": 1, "name": "tested", "root": root, **task}
        self.tree: CompiledTree = to_tree(Task.model_validate(document), CATALOG, leaf_factory=self._make)
        self.root = self.tree.root
        self.tree.observe(self)
        self.tree.prepare(self)

    def _make(self, path: str, node: Any, manifest: Manifest) -> Leaf:
        made = Scripted(path, path, manifest, {}, dict(node.meaning))
        made.world, made.script = self, self.scripts.get(path.rsplit("/", 1)[-1], "success").split()
        return made

    def tick(self, times: int = 1) -> Status:
        """Tick, and return the root's status."""
        for _ in range(times):
            self.root.tick_once()
        return self.root.status

    def run(self, ticks: int = 100) -> int:
        """Tick to the end; return how many ticks it took."""
        for n in range(1, ticks + 1):
            if self.tick() != Status.RUNNING:
                return n
        raise AssertionError(f"still running after {ticks} ticks")

    @property
    def reason(self) -> str | None:
        """The code that the root failed with."""
        return self.root.failure.code if self.root.failure else None

    # --- the context ---

    def wake(self) -> None:
        self.wakes += 1

    def wake_at(self, time: float) -> None:
        self.wake_times.append(time)

    # --- the observer ---

    def entered(self, path: str) -> None:
        self.events.append(("enter", path))

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        self.events.append(("exit", path, outcome))

    def interrupted(self, path: str) -> None:
        self.events.append(("interrupted", path))

    def message(self, path: str, text: str) -> None:
        self.events.append(("message", path, text))

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        self.events.append(("write", path, variable, value))
