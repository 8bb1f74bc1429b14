"""The page on comparing methods to grasp: its lines run, in the examples' folder; the demonstration is one of them."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "grasp_methods.md"
METHODS = {"pca_top", "image_antipodal", "cloud_antipodal", "grasp_network"}
LINES = [
    line for body in re.findall(r"^```sh\n(.*?)^```$", PAGE.read_text(), re.M | re.S) for line in body.splitlines()
]


@pytest.mark.ros
@pytest.mark.sim
@pytest.mark.parametrize("line", LINES)
def test_its_lines_run(line):
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    environment.pop("ROS_DOMAIN_ID", None)  # each run makes its own
    line += " --json" if line.startswith("grip demo") else ""
    done = subprocess.run(line.split(), cwd=ROOT / "examples", env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    if line.startswith("grip demo"):
        variants = json.loads(done.stdout)["variants"]
        assert {name.split("/")[0] for name in variants} == METHODS
        assert all(each["trials"] == 1 for each in variants.values())
        failed = {reason for each in variants.values() for reason in each["failures"]}
        assert not failed & {"error", "no_proposal.bad_reply", "no_proposal.server_lost"}, done.stdout
