"""One task that asks an arm, a hand and the scene for nearly everything, over fakes and in simulation."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.values import Pose
from grip_bt.commanders.taught import TaughtStates
from grip_bt.runtime import JournalReader

PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {hand: right_hand}}
hands: {right_hand: {}}
world: table
scene: room.scene
"""
ROOM = "(noname)+\n* lamp\n0.9 0.5 0.8\n0 0 0 1\n1\nsphere\n0.05\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n"
TASK = """grip: 1
name: tour
data: {plan: Plan, pose: Pose, target: Pose, before: Any, count: int, reached: JointState}
root:
  kind: sequence
  children:
    wall: {node: scene/add_shape, with: {name: wall, size: [0.02, 0.4, 0.3], position: [0.9, 0.3, 0.15]}}
    ball: {node: scene/add_shape, with: {name: ball, shape: sphere, size: [0.03], position: [0.4, -0.4, 0.6]}}
    allow: {node: scene/allow_collisions, with: {one: ball, other: right_hand}}
    before: {node: scene/snapshot, out: {snapshot: before}}
    attach: {node: scene/attach, with: {name: ball}}
    flat: {node: hand/fingers, with: {closing: {thumb: 0.1}}}
    up: {node: arm/jog, with: {linear: [0, 0, 0.1], seconds: 0.5}}
    show: {node: arm/teach, with: {name: above}}
    where: {node: arm/read_pose, out: {pose: pose}}
    aside: {node: pose/offset, with: {position: [0.0, 0.05, 0.0]}, in: {pose: pose}, out: {moved: target}}
    follow: {node: arm/follow, in: {pose: target}}
    back: {node: arm/move_straight, with: {offset: [0.0, -0.05, 0.0]}}
    plan: {node: arm/plan, with: {state: home}, out: {plan: plan}}
    go: {node: arm/execute, in: {plan: plan}, out: {reached: reached}}
    repeat: {node: arm/move_to_taught, with: {name: above}}
    detach: {node: scene/detach, with: {name: ball}}
    remove: {node: scene/remove, with: {name: "*"}, out: {count: count}}
    restore: {node: scene/restore, in: {snapshot: before}}
    free: {node: arm/move_to_pose, with: {free: orientation}, in: {pose: target}}
    home: {node: arm/move_to, with: {state: home}}
    unknown: {kind: invert, child: {gone: {node: scene/attach, with: {name: nothing}}}}
    lamp: {kind: invert, child: {fixed: {node: scene/remove, with: {name: lamp}}}}
    empty: {kind: invert, child: {touch: {node: hand/has_contact}}}
    close: {node: hand/synergy, with: {weights: [0.3]}}
    tips: {node: hand/fingertips, with: {tips: {index: [0.081, -0.048, 0.070], thumb: [-0.011, -0.037, 0.113]}}}
    hold: {node: arm/hold, with: {seconds: 0.1}}
    say: {node: flow/log, with: {message: taken out}, in: {value: count}}
    done: {node: flow/log, with: {message: measured}, in: {value: reached}}
"""


@pytest.fixture
def task(tmp_path) -> Path:
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "room.scene").write_text(ROOM)
    (tmp_path / "tour.yaml").write_text(TASK)
    return tmp_path / "tour.yaml"


@pytest.mark.parametrize("robot", ["fake", pytest.param("sim", marks=[pytest.mark.sim, pytest.mark.slow])])
def test_every_verb_does_its_work_and_the_refused_ones_say_why(task, robot):
    with open_session(task, RunOptions(robot=robot, journal=task.with_name("j.sqlite"))) as session:
        home = session.resources.arms["right"].grasp_pose()
        result = session.runner.run()
        arm, scene = session.resources.arms["right"], session.resources.scene
        assert (result.status, result.failure) == ("success", None), result.failure
        assert arm.grasp_pose().matrix() == pytest.approx(home.matrix(), abs=0.02)
        assert {"wall", "ball", "lamp"} <= set(scene.names())
        assert scene.solid("ball")[1] == Pose((0.4, -0.4, 0.6))
        above = arm.named_states()["above"]
    with JournalReader(task.with_name("j.sqlite")) as reader:
        events = list(reader.events(session.runner.run_id or ""))
    codes = {e.path: e.code for e in events if e.event == "exit" and e.code}
    assert codes["unknown/gone"] == "no_object"
    assert codes["lamp/fixed"] == "no_object"
    assert codes["empty/touch"] == "no_contact"
    taught = task.with_name("taught.yaml")
    assert taught.exists() == (robot == "sim")  # what fakes are taught lasts for the run
    if robot == "sim":
        assert TaughtStates(taught).of("right")["above"] == above


SWING = """grip: 1
name: swing
data: {there: Trajectory, reached: JointState}
root:
  kind: sequence
  children:
    look_up: {node: messages/get, with: {store: trajectories, name: NAME}, out: {value: there}}
    follow: {node: arm/execute_trajectory, in: {trajectory: there}, out: {reached: reached}}
"""
STATES = """low: {panda_joint1: 0.2, panda_joint4: -2.0}
high: {panda_joint1: -0.3, panda_joint4: -1.6}
"""
TRAJECTORIES = """
swing:
- {name: low, interpolate_time: 1, pause_time: 0.3}
- {name: high, interpolate_time: 2, pause_time: 0}
hurry:
- {name: low, interpolate_time: 1, pause_time: 0}
- {name: high, interpolate_time: 0.01, pause_time: 0}
"""


@pytest.mark.sim
@pytest.mark.parametrize(("name", "code"), [("swing", None), ("hurry", "out_of_limits")])
def test_a_stored_trajectory_is_followed_in_simulation_or_moves_nothing(tmp_path, name, code):
    (tmp_path / "grip.yaml").write_text(PROJECT.replace("scene: room.scene\n", ""))
    (tmp_path / "messages").mkdir()
    (tmp_path / "messages" / "joint_states.yaml").write_text(STATES)
    (tmp_path / "messages" / "trajectories.yaml").write_text(TRAJECTORIES)
    task = tmp_path / "swing.yaml"
    task.write_text(SWING.replace("NAME", name))
    with open_session(task, RunOptions(robot="sim", journal=tmp_path / "j.sqlite")) as session:
        arm = session.resources.arms["right"]
        before = arm.state().as_mapping()
        result = session.runner.run()
        after = arm.state().as_mapping()
    assert (result.failure and result.failure.code) == code
    wanted = before if code else {**before, "panda_joint1": -0.3, "panda_joint4": -1.6}
    assert after == pytest.approx(wanted, abs=0.03)
