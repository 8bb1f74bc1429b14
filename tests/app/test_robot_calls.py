"""A robot without a task: nodes are calls, and worlds are made in Python."""

from __future__ import annotations

from pathlib import Path

import pytest

import grip_bt as grip
from grip_bt.base.values import JointState
from grip_sim.worlds import load_world, read_world, world_files

GRIP = """\
grip: 1
robot: panda_allegro
arms: {right: {group: arm, hand: right_hand}}
hands: {right_hand: {group: hand}}
sensors: {overhead: {camera: overhead}}
world: table
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "grip.yaml").write_text(GRIP)
    return tmp_path


def test_nodes_are_calls_and_their_failures_are_errors(project: Path) -> None:
    with grip.Robot(project, "fake") as robot:
        assert (robot.arms, robot.hands, robot.cameras) == (("right",), ("right_hand",), ("overhead",))
        done = robot.do("arm/move_to", arm="right", state="home")
        assert (done.outcome, list(done)) == ("success", ["reached"])
        assert isinstance(done["reached"], JointState)
        assert done["reached"].position == pytest.approx(robot.arm().state().position)
        assert robot.do("flow/compute", a=2, b=3, expression="a * b")["value"] == 6
        assert robot.do("sensor/overhead")["points"] is not None
        with pytest.raises(grip.NodeFailedError, match="flow/fail: no_luck: today") as failed:
            robot.do("flow/fail", code="no_luck", message="today")
        assert (failed.value.outcome, failed.value.failure.code) == ("failure", "no_luck")
        with pytest.raises(grip.GripError, match="unknown named state 'nowhere'"):
            robot.do("arm/move_to", state="nowhere")
        with pytest.raises(grip.GripError, match="unknown port 'stat'; did you mean 'state'"):
            robot.do("arm/move_to", stat="home")
        with pytest.raises(TypeError, match=r"arm/move_to_pose needs pose \(Pose\)"):
            robot.do("arm/move_to_pose")
        with pytest.raises(grip.GripError, match="unknown output 'reach'; did you mean 'reached'"):
            _ = done["reach"]
        with pytest.raises(grip.GripError, match="unknown node 'arm/move_too'; did you mean 'arm/move_to'"):
            robot.do("arm/move_too")
        assert robot.do("arm/move_to", state="home").outcome == "success"  # as if nothing had been


def test_a_ready_made_robot_needs_no_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with grip.Robot("panda", "fake") as robot:
        assert robot.do("arm/move_to", state="home")["reached"].names[0] == "panda_joint1"
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(grip.GripError, match="component"), grip.Robot("panda", "fake", components=["none_such"]):
        pass


def test_a_world_that_was_read_is_written_and_drawn_alike(tmp_path: Path) -> None:
    for name in world_files():
        world = grip.World.like(name)
        file = world.save(tmp_path / f"{name}.yaml")
        assert read_world(str(file))[0].model_dump() == read_world(name)[0].model_dump()
        for seed in (0, 7):
            assert load_world(str(file), seed).objects == load_world(name, seed).objects == world.arranged(seed).objects


@pytest.mark.sim
def test_a_task_and_a_robot_have_the_world_that_was_made(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    table = {"box": [0.7, 1.2, 0.1], "at": [0.65, 0.0, -0.1]}
    cylinder = {"shape": "cylinder", "radius": 0.03, "height": 0.15, "at": [0.5, 0.1, 0.0]}
    camera = {"at": [0.5, 0.0, 1.2], "look_at": [0.5, 0.0, 0.0]}
    said = {"fixtures": {"table": table}, "objects": {"can": cylinder}, "cameras": {"overhead": camera}}
    world = grip.World.model_validate(said)
    points = grip.variable("points", "PointCloud")
    look = grip.build("look", grip.node("sensor/overhead", out={"points": points}))
    result = grip.run(look, world=world)
    with grip.Robot(project, world=world) as robot:
        assert robot.referee is not None
        assert list(robot.referee.truth()) == ["can"]
        seen = robot.do("sensor/overhead")["points"]
    for cloud in (seen, result.data["points"]):
        above = cloud.points[(cloud.points[:, 2] > 0.14) & (abs(cloud.points[:, :2] - [0.5, 0.1]) < 0.04).all(axis=1)]
        assert len(above) > 20
