"""The example task does the same on both targets, with parts that do as they are asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import read_mocks
from grip_bt.runtime import JournalReader

TASK = Path(__file__).parents[2] / "examples" / "tasks" / "reactive_pick.yaml"


def activations(target: Any, file: Path) -> dict[str, list[tuple[str, str | None, str | None]]]:
    """Run the example, a fake camera's table being empty, as if something stood on it; return what each node did."""
    stands = read_mocks(None, ["next_object/attempt/todo/clear=failure.something_left,success"])
    options = RunOptions(target=target, robot="fake", journal=file, mocks=stands)
    with open_session(TASK, options) as session:
        result = session.runner.run()
        assert result.status == "success", result.error
    done: dict[str, list[tuple[str, str | None, str | None]]] = {}
    with JournalReader(file) as reader:
        for event in reader.events(session.runner.run_id or ""):
            if event.event in ("enter", "exit", "interrupted", "write"):
                done.setdefault(event.path, []).append((event.event, event.outcome, event.code))
    return done


def test_the_example_does_the_same_as_a_tree_and_as_a_machine(tmp_path: Path) -> None:
    tree = activations("bt", tmp_path / "bt.sqlite")
    assert tree == activations("sm", tmp_path / "sm.sqlite")
    assert ("exit", "lifted", None) in tree["next_object/attempt/pick"]
