"""Exported machines run by themselves, with the project's nodes, subtasks and parts."""

import subprocess
import sys
from pathlib import Path

import pytest

import grip_bt
from grip_bt import smach_compat
from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.formats.smach_export import export
from grip_bt.runtime import JournalReader
from grip_bt.task import load

EXAMPLES = Path(__file__).parents[2] / "examples"
TASKS = sorted((EXAMPLES / "tasks").glob("*.yaml"))
INPUTS = {"count_to": {"limit": 4}}


def ends_of_leaves(task, data, journal):
    """Run a task as the machine that the compiler makes; return its outcome, and how its leaves ended, by path."""
    ends = {}
    with open_session(task, RunOptions(target="sm", robot="fake", journal=journal, data=data)) as session:
        outcome = session.runner.run().outcome
        leaves = session.runner.compiled.leaves
    with JournalReader(journal) as reader:
        for event in reader.events(session.runner.run_id):
            if event.event in ("exit", "interrupted") and event.path in leaves:
                ends.setdefault(event.path, []).append((event.event, event.outcome, event.code))
    return outcome, ends


def ends_of_exported_leaves(task, data):
    """Run the exported source likewise."""
    module, ends = {"__name__": "exported", "__file__": str(task.with_suffix(".py"))}, {}
    exec(compile(export(load(task), project_catalog(task), task.parent), "exported.py", "exec"), module)
    with grip_bt.tree_run(task, module["NODES"], robot="fake") as run:
        made = run.leaf_factory

        def noted(path, node, manifest):
            leaf = made(path, node, manifest)
            conclude = leaf.conclude

            def note(status):
                conclude(status)
                ends.setdefault(path, []).append(("exit", leaf.outcome, leaf.code))

            leaf.conclude = note
            return leaf

        run.leaf_factory = noted
        machine = module["build"](run)
        for name, value in data.items():
            machine.userdata[name] = value
        return machine.execute(), ends


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.stem)
def test_each_example_does_as_source_of_smach_what_it_does_as_a_task(task, tmp_path):
    data = INPUTS.get(task.stem, {})
    outcome, ends = ends_of_leaves(task, data, tmp_path / "journal.sqlite")
    assert ends_of_exported_leaves(task, data) == (outcome, ends)
    assert ends


def test_an_exported_file_takes_the_inputs_of_its_task_as_arguments(tmp_path):
    task = EXAMPLES / "tasks" / "count_to.yaml"
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "count_to.py").write_text(export(load(task), project_catalog(task), tmp_path))
    command = [sys.executable, "count_to.py"]
    for arguments, said in ((["limit=4", "start=2"], "done"), (["limit=400"], "too_far")):
        done = subprocess.run([*command, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=600)
        assert done.stdout.splitlines()[-1] == said, done.stderr


def test_an_exported_file_runs_as_a_program_with_the_projects_subtasks(tmp_path):
    for file in ("grip.yaml", "tasks/count_up.yaml", "tasks/count_to.yaml"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text("grip: 1\n" if file == "grip.yaml" else (EXAMPLES / file).read_text())
    task = tmp_path / "tasks" / "count_up.yaml"
    (tmp_path / "count_up.py").write_text(export(load(task), project_catalog(task), tmp_path))
    done = subprocess.run([sys.executable, "count_up.py"], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "success"


def test_a_machine_takes_the_projects_parts_and_gives_them_back():
    states = {"state": "home", "arm": "right"}
    node = {"node": "arm/move_to", "with": states}
    with grip_bt.tree_run(EXAMPLES / "tasks" / "x.yaml", ["arm/move_to"], robot="fake") as run:
        state = grip_bt.BehaviourTree.of_node(node, run, place="go")
        assert state.execute(smach_compat.UserData()) == "success"
