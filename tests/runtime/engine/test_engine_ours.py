"""The tick engine on tasks: our own nodes tell observers what they tell them when py_trees' generators tick."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from timed import ManualClock

from grip_bt.base.errors import NodeError
from grip_bt.compilers import CompiledTree, Rushing, to_machine, to_tree
from grip_bt.nodes import Leaf
from grip_bt.runtime import RunContext, TickEngine
from grip_bt.runtime.engine import make_ticker
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

R = Status.RUNNING
CATALOG = Catalog(
    [
        Manifest(
            id="test/leaf",
            doc="Does what it is told.",
            implementation="tests:Leaf",
            outputs={"x": {"type": "bool", "on": ["success"]}},
        )
    ]
)


class Told(Leaf):
    """Runs until it is told what to do; `script` is shared by the leaves of a task, by path."""

    def update(self) -> Status:
        deed = self.manifest.script.get(self.path, "end")  # type: ignore[attr-defined]
        match deed:
            case "run":
                return self.running()
            case "fail":
                return self.fail("tired", "that will do")
            case "raise":
                raise RuntimeError("broken")
            case "nonsense":
                return "success"  # type: ignore[return-value]
            case "shut":
                return self.end(x=False)
        return self.end()


class OwnTick(Told):
    """Does more after it has yielded itself, which a parent that leaves it never lets it do."""

    def tick(self) -> Iterator[Behaviour]:
        yield from super().tick()
        self.feedback_message += " and more"


class Heard:
    """Notes what observers are told."""

    def __init__(self) -> None:
        self.told: list[tuple[Any, ...]] = []

    def entered(self, path: str) -> None:
        self.told.append(("entered", path))

    def ended(self, path: str, outcome: str, failure: Any) -> None:
        self.told.append(("ended", path, outcome, failure and failure.code))

    def interrupted(self, path: str) -> None:
        self.told.append(("interrupted", path))

    def message(self, path: str, text: str) -> None:
        self.told.append(("message", path, text))

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        self.told.append(("wrote", path, variable, value))


def leaf(**more: Any) -> dict[str, Any]:
    return {"node": "test/leaf", **more}


def container(kind: str, **children: Any) -> dict[str, Any]:
    return {"kind": kind, "children": children}


def around(kind: str, child: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"kind": kind, "child": {"c": child}, **more}


ROOTS: dict[str, tuple[dict[str, Any], str]] = {
    "sequence": (container("sequence", a=leaf(), b=container("sequence", c=leaf(), w=leaf()), z=leaf()), "b/w"),
    "fallback": (container("fallback", w=leaf(), b=leaf()), "w"),
    "parallel": (container("parallel", a=leaf(), w=container("sequence", v=leaf()), z=leaf()), "w/v"),
    "guard": (around("guard", leaf(), **{"if": "go"}), "c"),
    "timeout": (around("timeout", leaf(), seconds=5), "c"),
    "retry": (around("retry", around("invert", leaf()), times=3), "c/c"),
    "repeat": (around("repeat", leaf(), times=3), "c"),
    "force": ({**around("force", leaf()), "as": "failure"}, "c"),
    "loop": (around("loop", leaf(), **{"while": "go"}), "c"),
    "machine": (
        {
            "kind": "state_machine",
            "initial": "a",
            "outcomes": {"success": "success", "failure": "failure"},
            "children": {
                "a": leaf(on={"success": "w", "failure": "failure"}),
                "w": leaf(on={"success": "success", "failure": "a"}),
            },
        },
        "w",
    ),
    "labels": (
        {
            **container("sequence", a=leaf(), b={**container("sequence", w=leaf(), z=leaf())}),
            "outcomes": {"success": "success", "failure": "failure", "odd": "success"},
            "exits": {"a.failure": "odd", "b.failure.tired": "odd"},
        },
        "b/w",
    ),
    "exit": (
        {
            **container("sequence", a=leaf(), w=leaf(), z=leaf()),
            "outcomes": {"success": "success", "failure": "failure", "odd": "success"},
            "exits": {"w.success": "odd"},
        },
        "w",
    ),
}


def compiled(root: dict[str, Any], script: dict[str, str], target: Any = to_tree) -> tuple[Any, Heard, ManualClock]:
    root = {**root}
    task: dict[str, Any] = {"grip": 1, "name": "t", "root": root, "data": {"go": {"type": "bool", "value": True}}}
    if "outcomes" in root:
        task["outcomes"] = root["outcomes"]

    def make(path: str, node: Any, manifest: Manifest) -> Leaf:
        kind = OwnTick if path == script.get("own tick") else Told
        made = kind(path, path, manifest, {}, {})
        object.__setattr__(made, "manifest", _Scripted(manifest, script))
        return made

    made = target(Task.model_validate(task), CATALOG, leaf_factory=make)
    heard, clock = Heard(), ManualClock()
    made.observe(heard)
    made.prepare(RunContext(clock))
    return made, heard, clock


class _Scripted:
    def __init__(self, manifest: Manifest, script: dict[str, str]):
        self._manifest, self.script = manifest, script

    def __getattr__(self, name: str) -> Any:
        return getattr(self._manifest, name)


def state(made: CompiledTree) -> list[tuple[Any, ...]]:
    """Return what anybody may look at."""
    return [
        (n.path, n.status, n.outcome, n.code, n.active, n.feedback_message, getattr(n.tip(), "path", None))
        for n in made.by_path.values()
    ]


@pytest.mark.parametrize("ending", ["end", "fail", "raise", "close", "late", "halt"])
@pytest.mark.parametrize("name", ROOTS)
def test_a_tree_that_goes_on_after_steady_ticks_tells_what_py_trees_tells(name: str, ending: str) -> None:
    root, waits = ROOTS[name]
    script = {waits: "run"}
    theirs, ours = compiled(root, script), compiled(root, script)
    engine = TickEngine(ours[0].root)
    sides = [(theirs[0].root.tick_once, *theirs), (engine.tick, *ours)]
    for made, _, _ in (theirs, ours):
        made.data[""].reset()
    for _ in range(12):
        for tick, *_ in sides:
            tick()
    before = len(ours[1].told)
    engine.tick()
    theirs[0].root.tick_once()
    assert len(ours[1].told) == before, "nothing happens"
    script[waits] = {"close": "run", "late": "run", "halt": "run"}.get(ending, ending)
    for _ in range(4):
        for tick, made, _, clock in sides:
            if ending == "close":
                made.data[""].cells["go"].value = False
            if ending == "late":
                clock.advance(2)
            if ending == "halt":
                made.root.stop(Status.INVALID)
            try:
                tick()
            except NodeError as error:
                made.raised = str(error)  # type: ignore[attr-defined]
        assert state(ours[0]) == state(theirs[0])
        assert ours[1].told == theirs[1].told
        assert getattr(ours[0], "raised", None) == getattr(theirs[0], "raised", None)
        if hasattr(ours[0], "raised"):
            return  # a run ends here


@pytest.mark.parametrize("deed", ["end", "run", "fail", "raise"])
@pytest.mark.parametrize("name", ROOTS)
def test_a_leaf_with_a_tick_of_its_own_is_ticked_as_by_py_trees(name: str, deed: str) -> None:
    root, path = ROOTS[name]
    script = {path: deed, "own tick": path}
    theirs, ours = compiled(root, script), compiled(root, script)
    engine = TickEngine(ours[0].root)
    for made, _, _ in (theirs, ours):
        made.data[""].reset()
    for _ in range(3):
        raised = []
        for tick in (theirs[0].root.tick_once, engine.tick):
            try:
                tick()
                raised.append("")
            except NodeError as error:
                raised.append(str(error))
        assert raised[0] == raised[1]
        assert state(ours[0]) == state(theirs[0])
        assert ours[1].told == theirs[1].told


@pytest.mark.parametrize("deed", ["end", "run", "fail", "raise", "nonsense"])
def test_the_tick_of_a_single_leaf_is_that_of_py_trees(deed: str) -> None:
    script = {"/": deed}
    theirs, ours = compiled(leaf(), script), compiled(leaf(), script)
    tick = make_ticker(ours[0].root)
    for _ in range(3):
        errors = []
        for one in (theirs[0].root.tick_once, tick):
            try:
                one()
                errors.append(None)
            except NodeError as error:
                errors.append((str(error), type(error.__cause__)))
        assert errors[0] == errors[1]
        assert state(ours[0]) == state(theirs[0])
        assert ours[1].told == theirs[1].told


@pytest.mark.parametrize("name", [name for name in ROOTS if name not in ("timeout", "guard", "parallel")])
@pytest.mark.parametrize("deed", ["end", "fail", "raise"])
def test_a_machine_whose_states_the_engine_ticks_tells_the_same(name: str, deed: str) -> None:
    root, path = ROOTS[name]
    ends = []
    for make in (None, make_ticker):
        script = {path: deed}
        made, heard, _ = compiled(root, script, to_machine)
        if name in ("loop",) and deed == "end":
            continue  # nobody ends it
        if name == "machine" and deed == "fail":
            continue  # nor this
        try:
            end: Any = made.execute(Rushing(), make)
        except NodeError as error:
            end = str(error)
        ends.append((end, heard.told))
    assert all(end == ends[0] for end in ends)
