"""The coroutine of `docs/own_nodes.md` in a project of its own, with fake parts."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grip_bt.app.runs.execute import run
from grip_bt.runtime import JournalReader

PAGE = (Path(__file__).parents[2] / "docs" / "own_nodes.md").read_text()
TASK = """\
grip: 1
name: peek
data: {at: Pose}
root:
  kind: sequence
  children:
    make: {node: pose/make, with: {position: [0.4, 0.1, 0.4], quaternion: [0, 1, 0, 0]}, out: {pose: at}}
    peek: {node: shelf/peek, with: {seconds: 0.01}, in: {pose: at}}
"""


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_the_coroutine_on_the_page_moves_an_arm_there_and_back(tmp_path: Path, target: str) -> None:
    (source,) = (block for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "grip.AsyncLeaf" in block)
    (tmp_path / "nodes").mkdir()
    (tmp_path / "nodes" / "peek.py").write_text(source)
    (tmp_path / "grip.yaml").write_text("grip: 1\nrobot: panda_allegro\narms: {right: {group: arm}}\n")
    (tmp_path / "peek.yaml").write_text(TASK)
    assert run(tmp_path / "peek.yaml", target=target, robot="fake").status == "success"
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        events = reader.events(reader.runs()[0].id)
    said = [(e.event, e.outcome, e.data.get("text")) for e in events if e.path == "peek"]
    assert said == [("enter", None, None), ("message", None, "looking"), ("exit", "seen", None)]
