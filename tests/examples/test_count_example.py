"""The example of a subtask: it is right, canonical, drawn, and does the same on both targets."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.app.runs.execute import RunOptions, check_task, open_session
from grip_bt.base.errors import InvalidTaskError
from grip_bt.cli.__main__ import main
from grip_bt.formats.draw import to_dot, to_mermaid, to_svg
from grip_bt.runtime import JournalReader
from grip_bt.task import dumps, load, loads
from grip_bt.task.catalog import Catalog

TASKS = Path(__file__).parents[2] / "examples" / "tasks"
UP, TO = TASKS / "count_up.yaml", TASKS / "count_to.yaml"


@pytest.mark.parametrize("file", [UP, TO], ids=lambda file: file.stem)
def test_it_has_no_issue_and_is_canonical(file: Path) -> None:
    assert check_task(file)[2].issues == ()
    assert main(["fmt", "--check", str(file)]) == 0
    assert loads(dumps(load(file))) == load(file)


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_the_journal_has_the_paths_of_nodes_inside_of_subtasks(target, tmp_path: Path) -> None:
    with open_session(UP, RunOptions(target=target, journal=tmp_path / "j.sqlite")) as session:
        assert session.runner.run().status == "success"
    with JournalReader(tmp_path / "j.sqlite") as reader:
        events = list(reader.events(session.runner.run_id or ""))
    ends = [(e.path, e.outcome, e.code) for e in events if e.event == "exit" and e.path.startswith("second/")]
    assert ends == [
        ("second/go_on/begin", "success", None),
        *[("second/go_on/count/add", "success", None)] * 10,
        ("second/go_on/count", "failure", "loop_limit"),
        ("second/go_on/", "failure", "loop_limit"),
        ("second/go_on", "too_far", "loop_limit"),
        ("second/gave_up", "success", None),
    ]


def test_run_by_itself_it_needs_its_input(tmp_path: Path) -> None:
    with pytest.raises(InvalidTaskError, match=r"count_to.yaml:6:10: .*needs the input 'limit' \(int\).*--set limit="):
        with open_session(TO, RunOptions(journal=tmp_path / "j.sqlite")):
            pass
    with open_session(TO, RunOptions(journal=tmp_path / "j.sqlite", data={"limit": 4})) as session:
        assert session.runner.run().outcome == "done"


@pytest.mark.parametrize("draw", [to_svg, to_dot, to_mermaid])
@pytest.mark.parametrize("view", ["tree", "flow"])
def test_a_subtask_is_drawn_with_its_file(draw, view) -> None:
    assert "tasks/count_to.yaml" in draw(load(UP), Catalog.builtin(), view)
