import re
from pathlib import Path

from grip_bt.cli.__main__ import main

DOCS = (Path(__file__).parents[3] / "docs" / "porting.md").read_text()


def block(name):
    return re.search(rf'```\w+ title="{re.escape(name)}"\n(.*?)```', DOCS, re.DOTALL).group(1)


def test_the_example_of_the_guide_is_imported_as_it_says_and_runs(tmp_path, capsys):
    legacy, task = tmp_path / "legacy_fill.py", tmp_path / "tasks" / "fill.yaml"
    legacy.write_text(block("legacy_fill.py"))
    assert main(["import", str(legacy), "--from", "smach", "--execute", "-o", str(task)]) == 0
    assert capsys.readouterr().out == block("report")
    assert task.read_text() == block("fill.yaml")
    assert main(["run", str(task), "--robot", "fake", "--in-process"]) == 0
    assert capsys.readouterr().out.split(";")[0] == "success: succeeded"
