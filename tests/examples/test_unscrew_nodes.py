"""The unscrewing example: where it sees the cap, where hands and fingertips go for it, and what the task does then."""

from __future__ import annotations

import importlib.util
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import MockStep, scripted
from grip_bt.app.runs.verdict import Verdict
from grip_bt.base.values import JointState, PointCloud
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.nodes.node import Observer

PROJECT = Path(__file__).parents[2] / "examples" / "unscrew"


def loaded(name):
    file = PROJECT / name
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


nodes = loaded("nodes/unscrew.py")
kinematics = loaded("components/finger_controller/kinematics.py")
gait = loaded("components/finger_controller/gait.py")
TABLE = {"x": [0.4, 0.7], "y": [-0.15, 0.15]}
HAND = RobotModel(load_robot("allegro_right"))
FINGERS = {"index": kinematics.INDEX, "middle": kinematics.MIDDLE, "thumb": kinematics.THUMB}


def bottle(x, y, cap=0.025, step=0.003):
    """Return a cloud of a table with a bottle of 14 cm and its cap, seen from above."""
    row = np.arange(-0.06, 0.06, step)
    around = np.stack(np.meshgrid(row, row), axis=-1).reshape(-1, 2)
    away = np.linalg.norm(around, axis=1)
    height = np.where(away < 0.02, 0.14 + cap, np.where(away < 0.03, 0.14, 0.0))
    return PointCloud(np.column_stack([around + [x, y], height]).astype(np.float32))


@pytest.mark.parametrize(("x", "y"), [(0.55, 0.0), (0.531, -0.017)])
def test_the_cap_is_the_highest_thing_there_is(x, y):
    found = nodes.find_cap.function(bottle(x, y), 0.0, **TABLE)
    assert found.outputs["cap"].position == pytest.approx([x, y, 0.165], abs=0.003)
    assert found.outputs["highest"] == pytest.approx(0.165, abs=0.001)


@pytest.mark.parametrize(("cloud", "code"), [(bottle(0.55, 0.4), "no_bottle"), (bottle(0.55, 0.0, cap=0.0), "no_cap")])
def test_a_table_without_a_bottle_and_a_bottle_without_the_cap_it_had_are_told_apart(cloud, code):
    assert nodes.find_cap.function(cloud, 0.165, **TABLE).code == code


def test_hands_face_the_bottle():
    cap = nodes.find_cap.function(bottle(0.55, 0.0), 0.0, **TABLE).outputs["cap"]
    ways = nodes.ways.function(cap)
    for grasp in ways["turning"]:
        assert grasp.pose.apply([nodes.CENTRE])[0] == pytest.approx(cap.position - [0, 0, 0.006])
        assert grasp.pose.rotation()[:, 2] == pytest.approx([0, 0, -1])
    for grasp in ways["holding"]:
        assert grasp.pose.position[:2] == pytest.approx(cap.position[:2])
        came = grasp.pose.position - grasp.pre_grasp.position
        assert came / np.linalg.norm(came) == pytest.approx(grasp.pose.rotation()[:, 2], abs=1e-6)


def tip_in_palm(finger, joints):
    """Return where our own model of the hand has a fingertip, in the palm's frame."""
    names = [f"joint_{finger.first + k}.0" for k in range(4)]
    at = HAND.description.named_state("hand", "open").as_mapping() | dict(zip(names, joints, strict=True))
    state = JointState.from_mapping(at)
    return HAND.link_poses(state)[f"link_{finger.first + 3}.0_tip"].position


@settings(max_examples=30)
@given(st.sampled_from(sorted(FINGERS)), st.lists(st.floats(0, 1), min_size=4, max_size=4))
def test_the_controllers_fingers_are_those_of_the_makers_description(name, shares):
    finger = FINGERS[name]
    q = finger.lower + np.array(shares) * (finger.upper - finger.lower)
    tip, jacobian = finger.tip(q)
    np.testing.assert_allclose(tip, tip_in_palm(finger, q), atol=1e-6)
    moved = [(finger.tip(q + step)[0] - tip) / 1e-6 for step in 1e-6 * np.eye(4)]
    np.testing.assert_allclose(jacobian, np.transpose(moved), atol=1e-5)


def test_controller_and_task_mean_one_place_for_the_cap():
    frame = HAND.description.grasp_frame
    np.testing.assert_allclose(frame.pose.apply([nodes.CENTRE])[0], gait.CENTRE, atol=1e-3)


def driven(hand, command, period=0.05):
    """Drive fingers that are where they are told to be; yield the gait after each cycle."""
    at = dict(hand.targets) or {finger: finger.rest for finger in gait.FINGERS}
    hand.begin(command, at)
    for _ in range(200):
        going = hand.advance(period)
        yield going
        if not going:
            return
    raise AssertionError(f"{command} has no end")


@settings(max_examples=4)
@given(st.floats(0.015, 0.022), st.floats(20, 50), st.floats(1, 10), st.sampled_from([0.05, 0.1]))
def test_a_ratchet_is_within_reach_and_no_joint_jumps(radius, stroke, force, period):
    hand = gait.Gait(radius, np.radians(stroke), force, stiffness=6.0)
    for command in ("release", "turn"):
        before = None
        for _ in driven(hand, command, period):
            assert hand.reached
            now = np.concatenate([hand.targets[finger] for finger in gait.FINGERS])
            assert before is None or np.abs(now - before).max() <= gait.FASTEST * period + 1e-9
            before = now
    assert hand.at == pytest.approx((-np.radians(stroke) / 2, radius + gait.TIP, force))


def test_fingers_press_inwards_alone_and_hold_each_other_the_balance():
    hand = gait.Gait(0.02, np.radians(48), force=8.0, stiffness=6.0)
    for command in ("release", "turn"):
        assert list(driven(hand, command))[-1] is False
    total = np.zeros(3)
    for finger, place in gait.FINGERS.items():
        away = gait.outwards(place + hand.at[0])
        touching = finger.towards(gait.CENTRE + hand.rim * away)
        torque = hand.stiffness * (hand.targets[finger] - touching)
        force = np.linalg.lstsq(finger.tip(touching)[1].T, torque, rcond=None)[0]
        np.testing.assert_allclose(force, -gait.SHARES[finger] * 8.0 * away, atol=1e-6)
        total += force
    np.testing.assert_allclose(total, 0.0, atol=1e-6)


class Ends(Observer):
    def __init__(self):
        self.seen = Counter()

    def ended(self, path, outcome, failure):
        self.seen[path.rpartition("/")[2], outcome] += 1


WITH_VALUES = "find ways take_bottle/avoid take_bottle/choose take_bottle/remember take_bottle/reach take_bottle/attach"
TURNING = "choose above lift has_cap"
RATCHET = "attempt/open/until_off/unscrew/until_loose/ratchet"


def run(form, folder, **mocks):
    """Run the task over fakes; return its outcome, and how often which node ended how."""
    pulls = [MockStep(outcome="success", outputs={"pull": pull}) for pull in (-8.0, -7.0, 0.2)]
    script = {f"attempt/open/{path}": "success" for path in [*WITH_VALUES.split(), "take_bottle/close"]}
    script |= {f"attempt/open/until_off/unscrew/{name}": "success" for name in TURNING.split()}
    script |= {f"{RATCHET}/{name}": "success" for name in ("let_go", "free", "turn")}
    script |= {f"{RATCHET}/pull": pulls, "attempt/open/until_off/hold": [MockStep(outcome="failure", seconds=1e6)]}
    script |= {f"attempt/open/{path}": steps for path, steps in mocks.items()}
    journal = folder / "runs.sqlite"
    options = RunOptions(target=form, robot="fake", mocks=scripted(script), journal=journal)
    ends = Ends()
    with open_session(PROJECT / "tasks" / "unscrew.yaml", options) as session:
        session.runner.observe(ends)
        Verdict(session)  # whose goal names what only a simulated world has
        result = session.runner.run()
    assert result.status != "error", result.error
    return result.outcome, ends.seen


@pytest.mark.parametrize("form", ["bt", "sm"])
def test_the_hand_turns_until_a_pull_says_that_the_cap_is_loose_and_never_lets_go_after_that(form, tmp_path):
    outcome, seen = run(form, tmp_path)
    assert outcome == "opened", seen
    assert seen["turn", "success"] == seen["let_go", "success"] == seen["pull", "success"] == 3
    assert seen["lift", "success"] == 1


@pytest.mark.parametrize("form", ["bt", "sm"])
def test_what_slips_out_of_a_hand_is_begun_again_from_a_new_look(form, tmp_path):
    outcome, seen = run(form, tmp_path, **{"take_bottle/close": "failure.no_contact,success"})
    assert outcome == "opened"
    assert seen["look", "success"] == 2
    assert seen["holder", "success"] == 1  # the arm got clear


@pytest.mark.parametrize("form", ["bt", "sm"])
def test_a_bottle_that_has_lost_its_cap_isnt_turned_on(form, tmp_path):
    outcome, seen = run(
        form, tmp_path, **{"until_off/unscrew/has_cap": "failure.no_contact", "find": "success,failure.no_cap"}
    )
    assert outcome == "dropped"
    assert seen["look", "success"] == 2
    assert seen["has_cap", "failure"] == 1
