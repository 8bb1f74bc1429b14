"""The demonstration from end to end, in both forms, and an object that can't be reached."""

import json
import shutil
from pathlib import Path

import pytest
from trial_attempts import CHECKS, AttemptRecorder
from trial_project import grip, processes_in, result_of

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.values import Pose
from grip_bt.cli.demo import ATTEMPT, demo_task, examples_folder
from grip_bt.nodes.node import Observer

pytestmark = [pytest.mark.ros, pytest.mark.sim, pytest.mark.slow]

FAR_LEAF = '''

from grip_bt.nodes import Leaf
from grip_bt.base.values import Grasp, Pose


class FarObject(Leaf):
    """Proposes to take something that stands two metres away."""

    def update(self):
        pose = Pose((2.0, 0.0, 0.1), (0.5, 0.5, 0.5, 0.5))
        grasp = Grasp(pose, pose.moved((-0.12, 0, 0)), pose.moved((0, 0, 0.15)), width=0.06)
        return self.end(grasps=[grasp])
'''
FAR_MANIFEST = """id: trial/far_object
doc: Propose to take something that stands two metres away.
implementation: leaf.py:FarObject
outputs: {grasps: {type: "list[Grasp]"}}
"""
FAR_TASK = """grip: 1
name: take_what_is_far
data: {grasps: "list[Grasp]", grasp: Grasp, tried: {type: "list[Grasp]", value: []}}
root:
  kind: sequence
  children:
    see: {node: trial/far_object, out: {grasps: grasps}}
    choose: {node: grasp/choose, with: {arm: right}, in: {grasps: grasps, tried: tried}, out: {grasp: grasp}}
    go: {node: arm/move_to_grasp, with: {arm: right}, in: {grasp: grasp}}
"""


@pytest.mark.parametrize("form", ["bt", "sm"])
def test_the_demo_clears_the_table_in_both_forms(form):
    done = grip("demo", "--seed", "3", "--as", form, "--json", domain=7, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    end = json.loads(done.stdout.splitlines()[-1])
    assert list(end["truth"].values()) == ["placed"] * 3
    assert end["outcome"] == "cleared"


@pytest.fixture
def project(tmp_path):
    folder = tmp_path / "project"
    shutil.copytree(examples_folder(), folder, ignore=shutil.ignore_patterns(".grip", "__pycache__"))
    own = folder / "nodes" / "far_object"
    own.mkdir(parents=True)
    (own / "manifest.yaml").write_text(FAR_MANIFEST)
    (own / "leaf.py").write_text(FAR_LEAF)
    (folder / "tasks" / "far.yaml").write_text(FAR_TASK)
    return folder


def test_an_object_out_of_reach_is_a_failure_with_its_reason(project: Path):
    done = grip("run", str(project / "tasks" / "far.yaml"), "--json", timeout=600)
    assert done.returncode == 3, done.stderr
    result = result_of(done)
    assert result["code"] == "no_grasp"
    assert "no_ik" in result["message"]
    assert processes_in(project) == []


class Thief(Observer):
    """Takes away the object that is about to be grasped, once, while the hand closes."""

    def __init__(self, recorder, referee):
        self.recorder, self.referee, self.stolen = recorder, referee, None

    def entered(self, path):
        if path.endswith("pick/close") and self.stolen is None:
            self.stolen = self.recorder.attempts[-1].target
            self.referee.move_object(self.stolen, Pose((0.0, 0.0, -1.0)))


@pytest.mark.parametrize("form", ["bt", "sm"])
def test_after_a_grasp_of_nothing_the_task_backs_off_and_takes_what_is_there(form):
    task = demo_task()
    with open_session(task, RunOptions(target=form, seed=3)) as session:
        referee = session.resources.referee
        recorder = AttemptRecorder(ATTEMPT, CHECKS["clear_table"], session.resources.clock.now, referee.truth)
        thief = Thief(recorder, referee)
        session.runner.observe(recorder)
        session.runner.observe(thief)
        result = session.runner.run()
        truth = referee.truth()
    assert (result.outcome, result.failure.code) == ("gave_up", "lost"), result
    failed = [a for a in recorder.attempts if a.failure is not None]
    assert [(a.target, a.failure.code) for a in failed] == [(thief.stolen, "no_contact")]
    assert dict(failed[0].steps)["pick/back_off"] == "success"
    assert "place" not in dict(failed[0].steps)
    assert sorted(t.status for t in truth.values()) == ["fallen", "placed", "placed"]
