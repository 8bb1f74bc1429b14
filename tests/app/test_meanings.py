"""What an outcome means is shown, not what it is called: in every view of runs of random tasks."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from timed import ManualClock

from grip_bt.app.runs.export_mcap import _line
from grip_bt.app.runs.replay import ENDS, line_of
from grip_bt.compilers import to_machine, to_tree
from grip_bt.runtime import Event, Journal, JournalReader, RunContext, Runner
from grip_bt.task import Task, dumps
from grip_bt.task.catalog import Catalog

LABELS = ("success", "failure", "gave_up", "done", "no_luck", "best_effort")


def random_task(choice: random.Random) -> dict[str, Any]:
    """Return a task whose outcomes are called anything: a machine of machines, of leaves that end as they like."""

    def machine(depth: int) -> tuple[dict[str, Any], dict[str, str]]:
        meaning = {label: choice.choice(("success", "failure")) for label in choice.sample(LABELS[2:], 3)}
        meaning |= {"success": "success", "failure": "failure"}
        names = list(meaning)
        states: dict[str, Any] = {}
        for number in range(choice.randrange(1, 4)):
            if depth and choice.random() < 0.5:
                inner, ends = machine(depth - 1)
                states[f"s{number}"] = inner
            else:
                fails = choice.random() < 0.4
                node = {"node": "flow/fail", "with": {"code": "tired"}} if fails else {"node": "flow/succeed"}
                states[f"s{number}"], ends = dict(node), {"failure": ""} if fails else {"success": ""}
            later = [f"s{number + 1}"]
            states[f"s{number}"]["on"] = {end: choice.choice(names + 2 * later) for end in ends}
        last = f"s{len(states)}"
        for state in states.values():
            state["on"] = {end: choice.choice(names) if to == last else to for end, to in state["on"].items()}
        return {"kind": "state_machine", "initial": "s0", "outcomes": meaning, "children": states}, meaning

    root, meaning = machine(2)
    return {"grip": 1, "name": "any", "outcomes": meaning, "root": {**root, "on": {end: end for end in meaning}}}


def runs(tmp_path: Path, many: int) -> Iterator[tuple[Any, list[Event], Any]]:
    """Yield compiled tasks with the events of their runs, and how those ended."""
    with Journal(tmp_path / "runs.sqlite") as journal:
        for seed in range(many):
            task = Task.model_validate(random_task(random.Random(seed)))
            compiled = (to_tree, to_machine)[seed % 2](task, Catalog.builtin())
            runner = Runner(compiled, RunContext(ManualClock()), journal=journal, task_text=dumps(task))
            result = runner.run()
            journal.flush()
            with JournalReader(journal.file) as reader:
                yield compiled, reader.events(str(runner.run_id)), (result, reader.run(str(runner.run_id)))


def test_each_end_is_shown_as_what_it_means(tmp_path: Path) -> None:
    seen: set[tuple[str, str]] = set()
    for compiled, events, (result, record) in runs(tmp_path, 60):
        meant = {part.path: part.meaning for part in compiled._resolved.root.walk()}
        assert (result.status, record.status) == (result.meaning, result.meaning)
        for event in (event for event in events if event.event == "exit"):
            meaning = meant[event.path][str(event.outcome)]
            assert event.meaning == meaning
            assert re.search(f" {ENDS[meaning]} ", line_of(event))
            assert (_line(event)[1] == 3) == (meaning == "failure")
            seen.add((str(event.outcome), meaning))
    own = {(label, meaning) for label, meaning in seen if label not in ("success", "failure")}
    assert {meaning for _, meaning in own} == {"success", "failure"}
    assert len(own) > 4, "labels of both meanings were met"


def test_journals_of_earlier_versions_dont_guess() -> None:
    event = Event(1, 0.0, 0.0, "a", "exit", "gave_up", None, {})
    assert f" {ENDS[None]} a gave_up" in line_of(event)
    assert ENDS[None] not in (ENDS["success"], ENDS["failure"])


def test_the_page_and_the_export_say_it_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from grip_bt.cli.__main__ import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "t.yaml").write_text(
        "grip: 1\nname: t\noutcomes: {gave_up: failure}\n"
        "root:\n  kind: state_machine\n  initial: a\n  outcomes: {gave_up: failure}\n"
        "  on: {gave_up: gave_up}\n  children:\n    a: {node: flow/succeed, on: {success: gave_up}}\n"
    )
    assert main(["run", "t.yaml", "--in-process", "--robot", "fake"]) == 3
    assert main(["runs", "last", "--to", "jsonl", "-o", "run.jsonl"]) == 0
    ends = [json.loads(line) for line in Path("run.jsonl").read_text().splitlines()]
    assert [(e["path"], e["meaning"]) for e in ends if e["event"] == "exit"] == [("a", "success"), ("/", "failure")]
    capsys.readouterr()
    assert main(["replay", "last"]) == 0
    assert "✗ / gave_up" in capsys.readouterr().out
