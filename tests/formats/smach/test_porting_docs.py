import re
import subprocess
import sys
from pathlib import Path

DOCS = (Path(__file__).parents[3] / "docs" / "porting.md").read_text()


def block(name):
    return re.search(rf'```\w+ title="{re.escape(name)}"\n(.*?)```', DOCS, re.DOTALL).group(1)


def test_the_example_of_the_guide_is_imported_as_it_says_and_runs(tmp_path):
    legacy, task = tmp_path / "legacy_fill.py", tmp_path / "tasks" / "fill.yaml"
    legacy.write_text(block("legacy_fill.py"))
    command = [sys.executable, "-m", "grip_bt.cli.__main__"]
    words = [*command, "import", str(legacy), "--from", "smach", "--execute", "-o", str(task)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stdout) == (0, block("report"))
    assert task.read_text() == block("fill.yaml")
    ran = subprocess.run([*command, "run", str(task), "--robot", "fake"], capture_output=True, text=True, timeout=600)
    assert (ran.returncode, ran.stdout.split(";")[0]) == (0, "success: succeeded")
