"""Files of BehaviorTree.CPP, imported and ticked by hand with scripted leaves on a manual clock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.common import Status
from timed import ManualClock

from grip_bt.compilers import to_tree
from grip_bt.compilers.binding import implementation_of
from grip_bt.formats.btcpp import from_xml
from grip_bt.formats.imported import Imported
from grip_bt.nodes import Leaf
from grip_bt.runtime.engine import make_ticker
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.validation import validate

BUILTIN = Catalog.builtin()


def document(body: str, *more: str, models: str = "") -> str:
    """Return a file whose main tree holds `body`; `more` are whole elements."""
    trees = f'<BehaviorTree ID="Main">{body}</BehaviorTree>' + "".join(more)
    model = f"<TreeNodesModel>{models}</TreeNodesModel>" if models else ""
    return f'<root BTCPP_format="4" main_tree_to_execute="Main">{trees}{model}</root>'


def imported(body: str, *more: str, models: str = "") -> Imported:
    """Return what a file becomes; it passes every check that is an error."""
    made = from_xml(document(body, *more, models=models), BUILTIN, "f.xml")
    report = validate(made.task, BUILTIN.with_manifests(made.manifests))
    assert not report.errors, report.errors
    return made


class Scripted(Leaf):
    """Its script has one word per activation: a dot per running tick, then `s` or `f`; `x=3` before it is an output."""

    world: World
    type_name: str
    script: list[str]

    def initialise(self) -> None:
        self.word = self.script.pop(0) if len(self.script) > 1 else self.script[0]

    def update(self) -> Status:
        self.world.trace.append(self.type_name)
        if self.word.startswith("."):
            self.word = self.word[1:]
            return self.running()
        *outputs, end = self.word.split(",")
        values = {port: eval(text) for port, text in (each.split("=") for each in outputs)}
        self.world.read.append({port: self.read(port) for port in self.readers})
        return self.end("success" if end == "s" else "failure", **values)

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.status == Status.RUNNING:
            self.world.trace.append(f"halt {self.type_name}")


class World:
    """The tree of a file, and the trace of its own leaves: their types as they are ticked, `halt NAME`.

    Args:
        body: what the main tree holds.
        scripts: leaf's name -> its script; without one it succeeds at once.
        more: further elements.
        models: of the TreeNodesModel.
        by_engine: whether the tick engine ticks.
        data: initial values of the task's variables and inputs.
    """

    def __init__(
        self,
        body: str,
        scripts: Mapping[str, str] | None = None,
        *more: str,
        models: str = "",
        by_engine: bool = False,
        **data: Any,
    ):
        self.clock = ManualClock()
        self.preempt_requested = False
        self.trace: list[str] = []
        self.read: list[dict[str, Any]] = []
        self.scripts = dict(scripts or {})
        self.file = imported(body, *more, models=models)
        catalog = BUILTIN.with_manifests(self.file.manifests)
        self.tree = to_tree(self.file.task, catalog, leaf_factory=self._make, data=data)
        self.tree.prepare(self)
        self.tree.data[""].reset()
        self.tick_once = make_ticker(self.tree.root) if by_engine else self.tree.root.tick_once

    def _make(self, path: str, node: Any, manifest: Manifest) -> Leaf:
        if manifest.implementation.startswith("grip_bt."):
            return implementation_of(path, node, manifest)
        made = Scripted(path, path, manifest, dict(node.with_), dict(node.meaning))
        made.type_name = manifest.id.partition("/")[2]
        made.world, made.script = self, self.scripts.get(made.type_name, "s").split()
        return made

    def tick(self) -> str:
        """Tick once; return the outcome, or `running`, and forget the trace before."""
        self.trace.clear()
        self.tick_once()
        return "running" if self.tree.root.status == Status.RUNNING else str(self.tree.root.outcome)

    def ticks(self, times: int, period: float = 0.0) -> list[str]:
        """Return what each of some ticks showed, so long [s] after one another: the trace, then how the tree ended."""
        said = []
        for _ in range(times):
            end = self.tick()
            said.append(" ".join([*self.trace, end.upper()]))
            self.clock.advance(period)
        return said

    def value(self, variable: str) -> Any:
        """Return what a variable of the task holds."""
        return self.tree.data.snapshot().get(("", variable))

    # --- the context ---

    def wake(self) -> None: ...

    def wake_at(self, time: float) -> None: ...
