"""Exported machines run by themselves, with the project's nodes, subtasks and parts."""

import subprocess
import sys
from pathlib import Path

import grip_bt
from grip_bt import smach_compat
from grip_bt.app import project_catalog
from grip_bt.codegen.smach import export
from grip_bt.graph import load

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_an_exported_file_runs_as_a_program_with_the_projects_subtasks(tmp_path):
    for file in ("grip.yaml", "tasks/count_up.yaml", "tasks/count_to.yaml"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text("grip: 1\n" if file == "grip.yaml" else (EXAMPLES / file).read_text())
    task = tmp_path / "tasks" / "count_up.yaml"
    (tmp_path / "count_up.py").write_text(export(load(task), project_catalog(task), tmp_path))
    done = subprocess.run([sys.executable, "count_up.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "success"


def test_a_machine_takes_the_projects_parts_and_gives_them_back():
    states = {"state": "home", "arm": "right"}
    node = {"node": "arm/move_to", "with": states}
    with grip_bt.tree_run(EXAMPLES / "tasks" / "x.yaml", ["arm/move_to"], robot="fake") as run:
        state = grip_bt.BehaviourTree.of_node(node, run, place="go")
        assert state.execute(smach_compat.UserData()) == "success"
