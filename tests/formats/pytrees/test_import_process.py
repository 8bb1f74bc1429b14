"""The process that runs somebody's code ends with the one that asked for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

NEVER_DONE = """
import os, threading
pipe = open(os.environ["ALIVE"], "w")
pipe.write("here\\n")
pipe.flush()
threading.Event().wait()
"""


def test_code_that_never_ends_dies_with_a_killed_import(tmp_path: Path) -> None:
    (tmp_path / "patrol.py").write_text(NEVER_DONE)
    alive = tmp_path / "alive"
    os.mkfifo(alive)
    asks = "from pathlib import Path; from grip_bt.formats.pytrees import import_from_code"
    asks += "; import_from_code('patrol:tree', Path())"
    parent = subprocess.Popen([sys.executable, "-c", asks], cwd=tmp_path, env={**os.environ, "ALIVE": str(alive)})
    with alive.open() as pipe:
        assert pipe.readline() == "here\n"
        parent.kill()
        parent.wait()
        assert pipe.read() == ""  # comes to its end when nobody has it open any more
