"""Machines that are there as objects become tasks whose leaves run these objects."""

import json
import sys
from pathlib import Path

import py_trees
import pytest
from smach_lowerings import Draw, per_path
from smach_runs import Trace, run_legacy
from smach_sources import source_of

import grip_bt
from grip_bt import smach_compat as smach
from grip_bt.base.errors import GripError
from grip_bt.compilers import to_machine, to_tree
from grip_bt.nodes.smach_source import load_legacy
from grip_bt.runtime import RunContext, Runner
from grip_bt.task import loads
from grip_bt.task.catalog import Catalog

DATA = Path(__file__).parent / "data"
COMPILERS = {"bt": to_tree, "sm": to_machine}


@pytest.fixture(autouse=True)
def silence():
    quiet = lambda text: None  # noqa: E731
    smach.set_loggers(quiet, quiet, quiet, quiet)


def run(made, target):
    compiled = COMPILERS[target](made.task, made.catalog, leaf_factory=made.leaf_factory)
    trace = Trace(set(compiled.leaves))
    runner = Runner(compiled, RunContext())
    runner.observe(trace)
    result = runner.run()
    assert result.error is None, result.error
    return result.outcome, trace.ends, {name: value for (_, name), value in compiled.data.snapshot().items()}


class Unheard:
    """A value that no file can hold."""

    def __init__(self):
        self.count = 0


class Use(smach.State):
    def __init__(self, label):
        smach.State.__init__(self, ["again", "enough"], ["tool"], ["tool"])
        self.label = label

    def execute(self, userdata):
        userdata.tool.count += 1
        return "enough" if userdata.tool.count > 2 else "again"


def tools():
    machine = smach.StateMachine(["over"])
    machine.userdata.tool = Unheard()
    with machine:
        smach.StateMachine.add("USE", Use("a"), {"again": "USE", "enough": "LAST"})
        smach.StateMachine.add("LAST", Use("b"), {"again": "USE", "enough": "over"})
    return machine


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_states_with_objects_for_arguments_and_userdata_run_as_they_are(target):
    machine = tools()
    made = grip_bt.from_machine(machine, "tools")
    assert made.exact
    outcome, ends, _ = run(made, target)
    assert (outcome, [path for path, _ in ends]) == ("over", ["USE", "USE", "USE", "LAST"])
    assert machine.userdata.tool.count == 4


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_random_machines_do_as_objects_what_their_tasks_do(target, tmp_path):
    compared = 0
    for seed in range(25):
        file = tmp_path / f"live_{seed}.py"
        file.write_text(source_of(Draw(seed).machine()))
        legacy = load_legacy(file, ros=False)
        legacy.TRACE.clear()
        wanted = legacy.build().execute(), json.loads(json.dumps(legacy.TRACE))
        legacy.TRACE.clear()
        legacy.ENDED.clear()
        made = grip_bt.from_machine(legacy.build())
        if not made.exact:
            assert all(issue.message for issue in made.issues)
            continue
        outcome, _, _ = run(made, target)
        assert (outcome, per_path(json.loads(json.dumps(legacy.TRACE)))) == (wanted[0], per_path(wanted[1])), seed
        compared += 1
    assert compared > 10


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("nested_with", "build"),
        ("iterate_list", "build"),
        ("concurrence_all", "build"),
        ("sequence_task", "get_sequence"),
        ("auto_chain", "make"),
    ],
)
def test_machines_of_every_kind_of_container_become_tasks(stem, name):
    build = getattr(load_legacy(DATA / f"{stem}.py", ros=False), name)
    made = grip_bt.from_machine(build())
    outcome, ends, _ = run(made, "bt")
    wanted, theirs = run_legacy(build())
    assert outcome == wanted
    own = ("next", "next_2", "asked")
    assert sorted(path for path, _ in ends if not path.endswith(own)) == sorted(p for p, _ in theirs)


def test_a_compiled_machine_becomes_its_task():
    task = loads("grip: 1\nname: a\nroot: {node: flow/succeed, on: {success: success}}\n")
    compiled = to_machine(task, Catalog.builtin())
    assert grip_bt.from_machine(compiled).task == task


def test_what_has_no_equal_is_one_leaf_or_refused_with_words():
    inner = smach.Concurrence(["over"], "over", outcome_cb=lambda outcomes: "over")
    with inner:
        smach.Concurrence.add("A", Use("a"))
    outer = smach.StateMachine(["over"])
    outer.userdata.tool = Unheard()
    with outer:
        smach.StateMachine.add("BOTH", inner, {"over": "over"})
    made = grip_bt.from_machine(outer)
    assert "imported as one leaf that runs the original container: its `outcome_cb` decides" in made.issues[0].message
    with pytest.raises(GripError, match=r"no exact equivalent:\n.*: its `outcome_cb` decides"):
        grip_bt.from_machine(inner)
    with pytest.raises(GripError, match="a dict isn't a container of grip_bt.smach_compat"):
        grip_bt.from_machine({})
    broken = smach.StateMachine(["over"])
    with broken:
        smach.StateMachine.add("A", smach.State(["x"]), {"x": "nowhere"})
    with pytest.raises(GripError, match="the machine is inconsistent"):
        grip_bt.from_machine(broken)


def test_the_page_about_it_is_true(tmp_path, monkeypatch):
    page = (Path(__file__).parents[3] / "docs" / "smach.md").read_text()
    legacy = page.split('```python title="legacy_pick.py"\n')[1].split("```")[0]
    shown, states = (
        block.split("```")[0] for block in page.split("## Machines and trees")[1].split("```python\n")[1:3]
    )
    (tmp_path / "legacy_pick.py").write_text(legacy)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    smach.install(ros=False)
    names = {}
    try:
        exec(compile(shown, "shown.py", "exec"), names)
    finally:
        sys.modules.pop("legacy_pick", None)
    assert names["made"].exact
    (tmp_path / "fetch.yaml").write_text("grip: 1\nname: fetch\nroot: {node: flow/succeed}\n")
    root = py_trees.behaviours.Success("root")
    sm = smach.StateMachine(["done"])
    sm.userdata.arm = "right"
    with sm:
        smach.StateMachine.add("LOOK", smach.CBState(lambda ud: "seen", outcomes=["seen"]), {"seen": "FETCH"})
    exec(compile(states, "states.py", "exec"), {"sm": sm, "smach": smach, "grip_bt": grip_bt, "root": root})
    assert sm.execute() == "done"
