"""One task file, whatever the hand: the example takes a thing, and the referee sees it held through the shake."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.verdict import Verdict

pytestmark = pytest.mark.sim
EXAMPLES = Path(__file__).parents[2] / "examples"
PROJECT = """grip: 1
robot: {robot}
arms: {{arm: {{group: arm, hand: hand}}}}
hands: {{hand: {{group: hand}}}}
sensors: {{overhead: {{camera: overhead}}}}
world: one
"""
WORLD = """grip: 1
fixtures: {table: {box: [0.70, 1.20, 0.10], at: [0.65, 0.0, -0.10]}}
objects: {thing: %s}
cameras:
  overhead: {at: [0.53, 0, 1.3], quaternion: [0, 0.7071067811865476, -0.7071067811865476, 0], field_of_view: 0.44}
shake: {amplitude: 0.02, frequency: 0.6}
dt: %r
judge: {shaken: held_through_shake == 1}
"""
CUBE = "{model: cube, at: [0.52, 0.05, 0.0], yaw: 0.4}"
CAN = "{model: can, at: [0.48, 0.02, 0.0335], yaw: 0.7, tilt: [0, 1.5708]}"
"""It lies, and weighs 360 g: it rolled out between a thumb and the one finger against it."""


@pytest.mark.parametrize(
    ("robot", "thing"), [("panda", CUBE), ("panda_allegro", CUBE), ("panda_allegro", CAN), ("panda_allegro_left", CAN)]
)
def test_a_gripper_and_hands_take_things_by_one_task_and_hold_them_through_a_shake(tmp_path, robot, thing):
    assert held_through_shake(tmp_path, robot, thing, 1 / 240)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [300, 480])
@pytest.mark.parametrize(("robot", "thing"), [("panda", CUBE), ("panda_allegro", CAN)])
def test_what_is_held_does_not_depend_on_the_time_step(tmp_path, robot, thing, steps):
    assert held_through_shake(tmp_path, robot, thing, 1 / steps)


def held_through_shake(tmp_path, robot, thing, dt) -> bool:
    for part in ("nodes", "tasks", "worlds"):
        (tmp_path / part).mkdir()
    shutil.copy(EXAMPLES / "nodes" / "hands.py", tmp_path / "nodes")
    text = (EXAMPLES / "tasks" / "lift_and_shake.yaml").read_text()
    task = tmp_path / "tasks" / "lift_and_shake.yaml"
    task.write_text(text.replace("{node: hands/shake}", "{node: hands/shake, with: {frequency: 0.6, seconds: 2.5}}"))
    (tmp_path / "grip.yaml").write_text(PROJECT.format(robot=robot))
    (tmp_path / "worlds" / "one.yaml").write_text(WORLD % (thing, dt))
    with open_session(task, RunOptions(seed=0)) as session:
        verdict = Verdict(session)
        result = session.runner.run()
        facts = verdict.facts(result)
    assert result.status == "success", result.failure
    return facts["judged"] == {"shaken": True}
