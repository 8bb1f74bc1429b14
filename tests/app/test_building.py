"""Tasks made in Python: whatever a file may hold can be built; and what is made in the program itself runs."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import grip_bt as grip
from grip_bt.app.building import NamedVariable, Part
from grip_bt.base.errors import DocumentError, InvalidTaskError, UnknownNameError
from grip_bt.runtime.observers import Observer
from grip_bt.task.model import KINDS
from grip_bt.task.parts import Variable

sys.path.append(str(Path(__file__).parents[1] / "parity"))

from parity_flows import make_flow
from parity_generate import make_case

Scope = Mapping[str, NamedVariable]


@grip.leaf("building/twice", outputs={"twice": int}, quick=True)
def twice(n: int, *, more: int = 0) -> int:
    """Double a number."""
    return 2 * n + more


class OwnLeaf(grip.Leaf):
    """A class, which a program can't give as a node."""


def variables_of(declared: Mapping[str, Any]) -> dict[str, NamedVariable]:
    return {name: NamedVariable(name, v if isinstance(v, str) else Variable(**v)) for name, v in declared.items()}


def rebuilt(name: str, node: Mapping[str, Any], around: Scope) -> Part:
    """Build a node of a document, its children first."""
    common = {key: node[key] for key in ("doc", "precondition", "on", "meaning") if key in node}
    if "node" in node:
        into = {port: around[v] for port, v in node.get("in", {}).items()}
        out = {port: around[v] for port, v in node.get("out", {}).items()}
        return grip.node(node["node"], out=out, **common, **node.get("with", {}), **into).named(name)
    here = {**around, **variables_of(node.get("data", {}))}
    if "item" in node:
        here[node["item"]] = grip.variable(node["item"], "Any")
    below = [rebuilt(n, child, here) for n, child in (node.get("children") or node.get("child") or {}).items()]
    fields = {k: v for k, v in node.items() if k not in ("kind", "children", "child", "data")}
    own = [here[each] for each in node.get("data", {})]
    made: Part = getattr(grip, node["kind"])(*below, **fields, **({"data": own} if own else {}))
    return made.named(name)


@pytest.mark.parametrize("make", [make_case, make_flow])
@pytest.mark.parametrize("chunk", range(2))
def test_whatever_a_file_holds_can_be_built(make: Any, chunk: int) -> None:
    for seed in range(25 * chunk, 25 * chunk + 25):
        said = make(seed)["task"]
        inputs, outputs, data = (variables_of(said.get(key, {})) for key in ("inputs", "outputs", "data"))
        root = rebuilt("root", said["root"], {**inputs, **outputs, **data})
        ports = {"inputs": [*inputs.values()], "outputs": [*outputs.values()], "data": [*data.values()]}
        task = grip.build(said["name"], root, **ports, outcomes=said.get("outcomes"), doc=said.get("doc", ""))
        assert task == grip.loads(grip.dumps(grip.Task.model_validate(said)))
        assert grip.loads(grip.dumps(task)) == task


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_what_is_made_in_the_program_runs(target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    n, one = grip.variable("n", int, 1), grip.variable("one", int)
    items = grip.variable("items", list[int], [1, 2, 3])
    double = grip.node(twice, n=n, out={"twice": n})
    add = grip.node("flow/compute", a=one, b=n, expression="a + b", out={"value": n})
    task = grip.build("sum", grip.sequence(double, double, grip.for_each(add, items=items, item=one)))
    assert str(task.check()) == "nothing is wrong"
    result = grip.run(task, robot="fake", target=target)
    assert (result.status, result.data["n"]) == ("success", 10)
    with task.tree() as tree:
        while tree.outcome is None:
            tree.tick()
        assert tree.data["n"] == 10
    assert list(task.root.below) == ["twice", "twice_2", "for_each"]
    assert "one" not in task.data  # an item is its container's own


def test_faults_are_told_where_they_are_made() -> None:
    n, other = grip.variable("n", int, 1), grip.variable("n", float)
    with pytest.raises(InvalidTaskError, match="two variables are called 'n': int and float"):
        grip.build("two", grip.sequence(grip.node("flow/count", count=n), grip.node("flow/count", count=other)))
    with pytest.raises(TypeError, match="retry has one child, not 2"):
        grip.retry(grip.node("flow/fail"), grip.node("flow/fail"), times=2)
    with pytest.raises(TypeError, match="subtask has no children, not 1"):
        grip.subtask(grip.node("flow/fail"), task="a.yaml")
    with pytest.raises(AttributeError, match="sequense"):
        _ = grip.sequense
    with pytest.raises(TypeError, match="OwnLeaf is a class: put it into the project's nodes/"):
        grip.node(OwnLeaf)

    @grip.leaf("building/inner")
    def inner() -> None:
        """Do nothing."""

    with pytest.raises(TypeError, match="inner is made within a function"):
        grip.node(inner)
    with pytest.raises((DocumentError, ValueError), match="times"):
        grip.build("never", grip.retry(grip.node("flow/fail"), times=-1))


def test_every_kind_is_a_function_and_others_are_not() -> None:
    assert {kind for kind in KINDS if callable(getattr(grip, kind))} == set(KINDS)
    with pytest.raises(UnknownNameError, match="unknown kind 'sequense'; did you mean 'sequence'"):
        import_container("sequense")


def import_container(kind: str) -> Any:
    from grip_bt.app.building import container

    return container(kind)


def test_a_run_that_is_awaited_ends_as_others_and_stops_when_it_is_cancelled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    began = asyncio.Event()

    class Told(Observer):
        def entered(self, path: str) -> None:
            loop.call_soon_threadsafe(began.set)

    async def both() -> str:
        nonlocal loop
        loop = asyncio.get_running_loop()
        short = grip.build("short", grip.node("flow/succeed"))
        result = await grip.run_async(short, robot="fake")
        running = asyncio.create_task(grip.run_async(grip.build("long", waiting), robot="fake", observer=Told()))
        await began.wait()
        running.cancel()
        with pytest.raises(asyncio.CancelledError):
            await running
        return result.status

    loop: Any = None
    waiting = grip.node("flow/wait", seconds=3600)
    assert asyncio.run(both()) == "success"
    with grip.JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        assert {(run.task_name, run.status) for run in reader.runs()} == {("short", "success"), ("long", "stopped")}
