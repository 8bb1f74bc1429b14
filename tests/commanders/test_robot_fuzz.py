import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

MORE = int(os.environ.get("GRIP_FUZZ_ROBOTS", "1"))
"""How many times the sample; 6 spoils more than 1,000 files."""


@pytest.mark.parametrize(("kind", "few"), [("urdf", 80), ("srdf", 80), ("xacro", 8)])
def test_spoiled_files_are_refused_with_typed_errors_or_make_a_model(kind, few):
    """A process of its own: a crash of a native library would end it, not the test run."""
    count = few * MORE
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("robot_fuzz.py")), kind, str(count), "7"],
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    found = re.search(r"valid (\d+) refused (\d+)", done.stdout)
    assert found is not None
    valid, refused = map(int, found.groups())
    assert valid + refused == count
    assert refused > 0
    assert valid > 0 or kind == "xacro"
