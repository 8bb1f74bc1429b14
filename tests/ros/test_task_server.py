"""`grip serve`: a client that isn't ours, in a shell that sourced one file, lists, runs, pauses and stops tasks."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grip_bt.ros.command import child_environment

pytestmark = [pytest.mark.ros, pytest.mark.timeout(900)]
CLIENT = Path(__file__).parent / "data" / "plain_task_client.py"
COUNT = """grip: 1
name: count
doc: Count once.
data: {n: {type: int, value: 0}}
root:
  kind: sequence
  precondition: n == 5
  children:
    step: {node: flow/count, in: {count: n}, out: {count: n}}
"""
ABORTED, CANCELED, SUCCEEDED = 6, 5, 4


def test_other_software_lists_runs_pauses_and_stops_tasks(own_domain: int, tmp_path: Path) -> None:
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "count.yaml").write_text(COUNT)
    fails = "{grip: 1, name: failing, root: {node: flow/fail, with: {code: no_luck, message: today}}}"
    (tmp_path / "tasks" / "failing.yaml").write_text(fails)
    waits = "{grip: 1, name: endless, root: {node: flow/wait, with: {seconds: 36000}}}"
    (tmp_path / "tasks" / "endless.yaml").write_text(waits)
    (tmp_path / "tasks" / "broken.yaml").write_text("grip: 1\nname: [\n")
    setup = tmp_path / "setup.bash"
    command = [sys.executable, "-m", "grip_bt.cli", "serve", ".", "--robot", "fake", "--managed", "--setup", str(setup)]
    with subprocess.Popen(
        command, cwd=tmp_path, env=child_environment((), own_domain), stdout=subprocess.PIPE, text=True
    ) as server:
        try:
            assert server.stdout is not None
            assert "serving 4 tasks" in server.stdout.readline()
            clean = {name: os.environ[name] for name in ("PATH", "HOME")}  # a shell that has sourced nothing
            asked = subprocess.run(
                ["bash", "-c", f'source "{setup}"; exec "{sys.executable}" "{CLIENT}"'],
                env=clean,
                capture_output=True,
                text=True,
            )
        finally:
            server.terminate()
    assert asked.returncode == 0, asked.stderr
    seen = json.loads(asked.stdout.splitlines()[-1])
    assert (seen["before"], seen["managed"], seen["after"]) == (False, [True, True], False)
    assert seen["listed"]["count"] == ["tasks/count.yaml", "Count once."]
    assert seen["listed"]["broken"][1].startswith("can't be read: ")
    assert seen["count"] == {"goal": SUCCEEDED, "status": "success", "outcome": "success", "code": "", "message": ""}
    steps = [["/", "enter", ""], ["step", "enter", ""], ["step", "success", ""], ["/", "success", ""]]
    assert [told for told in seen["feedback"] if told in steps] == steps
    assert (seen["failing"]["goal"], seen["failing"]["code"]) == (ABORTED, "no_luck")
    assert "unknown task 'coutn'; did you mean 'count'?" in seen["unknown"]["message"]
    assert "`inputs` isn't JSON" in seen["no_json"]["message"]
    assert (seen["second"], seen["pause"], seen["nothing"]) == (False, True, False)
    assert (seen["cancelled"]["goal"], seen["cancelled"]["status"]) == (CANCELED, "stopped")
    assert (seen["deactivated"], seen["stopped"]["status"]) == (True, "stopped")
