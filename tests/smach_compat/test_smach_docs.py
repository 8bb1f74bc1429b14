"""docs/smach.md is true: its example runs and prints what it says, and the tests that it names exist."""

import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
PAGE = (HERE.parents[1] / "docs" / "smach.md").read_text()


def test_the_porting_example_runs_as_printed(tmp_path):
    files = re.findall(r'^```python title="(\w+\.py)"\n(.*?)^```', PAGE, re.MULTILINE | re.DOTALL)
    (printed,) = re.findall(r"^```text\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert [name for name, _ in files] == ["legacy_pick.py", "run_pick.py"]
    for name, text in files:
        (tmp_path / name).write_text(text)
    assert "grip_bt" not in files[0][1], "the legacy file knows nothing of us"
    result = subprocess.run([sys.executable, "run_pick.py"], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert (result.stdout, result.stderr, result.returncode) == (printed, "", 0)


def test_each_deviation_names_tests_that_exist():
    page = (HERE.parents[1] / "docs" / "compatibility.md").read_text()
    table = page.split("## SMACH: what differs")[1].split("\n## ")[0]
    rows = [line for line in table.splitlines() if re.match(r"\| \d+ \|", line)]
    files = [*HERE.glob("test_smach_*.py"), HERE.parent / "ros" / "test_ros_smach.py"]
    sources = "\n".join(file.read_text() for file in files)
    defined = set(re.findall(r"^def (test_\w+)", sources, re.MULTILINE))
    assert len(rows) == 20
    for row in rows:
        named = re.findall(r"`(test_\w+)`", row)
        assert named, row
        assert set(named) <= defined, row
