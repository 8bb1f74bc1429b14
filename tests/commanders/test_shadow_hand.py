"""The Shadow hand's kinematics, against values computed by hand from the numbers in the maker's model."""

import numpy as np
import pinocchio as pin
import pytest
from table_top import robot_model

from grip_bt.base.values import JointState


def place(model, link, positions, of="rh_palm"):
    """Return a link's frame in the palm."""
    data = model.model.createData()
    q = model.configuration(JointState(tuple(positions), tuple(positions.values())), base=pin.neutral(model.model))
    pin.framesForwardKinematics(model.model, data, q)
    frames = [data.oMf[model.model.getFrameId(name)] for name in (of, link)]
    return frames[0].actInv(frames[1])


def test_straight_fingers_end_where_the_sums_of_their_bones_say():
    model = robot_model("shadow_right")
    bones = 0.045 + 0.025  # proximal and middle
    for link, knuckle in (
        ("rh_ffdistal", (0.033, 0, 0.095)),
        ("rh_mfdistal", (0.011, 0, 0.099)),
        ("rh_rfdistal", (-0.011, 0, 0.095)),
        ("rh_lfdistal", (-0.033, 0, 0.02071 + 0.06579)),
    ):
        assert np.allclose(place(model, link, {}).translation, np.array(knuckle) + (0, 0, bones), atol=1e-9)
    assert np.allclose(place(model, "rh_palm", {}, of="rh_forearm").translation, (0, -0.01, 0.21301 + 0.034))


def test_a_finger_flexes_about_x_towards_the_palm():
    """At 90 degrees the bones leave the knuckle along -y; the second joint turns them back along -z."""
    model = robot_model("shadow_right")
    one = place(model, "rh_ffdistal", {"rh_FFJ3": np.pi / 2})
    assert np.allclose(one.translation, (0.033, -0.045 - 0.025, 0.095), atol=1e-9)
    two = place(model, "rh_ffdistal", {"rh_FFJ3": np.pi / 2, "rh_FFJ2": np.pi / 2})
    assert np.allclose(two.translation, (0.033, -0.045, 0.095 - 0.025), atol=1e-9)


def test_knuckles_spread_about_minus_y_and_the_ring_fingers_about_plus_y():
    model, angle, bones = robot_model("shadow_right"), 0.3, 0.07
    index = place(model, "rh_ffdistal", {"rh_FFJ4": angle}).translation
    assert np.allclose(index, (0.033 - bones * np.sin(angle), 0, 0.095 + bones * np.cos(angle)), atol=1e-9)
    ring = place(model, "rh_rfdistal", {"rh_RFJ4": angle}).translation
    assert np.allclose(ring, (-0.011 + bones * np.sin(angle), 0, 0.095 + bones * np.cos(angle)), atol=1e-9)


def test_the_thumb_stands_45_degrees_to_the_palm():
    """Its base turns by the quaternion 0.92388 0 0.382683 0, 45 degrees about y: its z is (1, 0, 1) / sqrt 2."""
    along = np.array([1, 0, 1]) / np.sqrt(2)
    tip = place(robot_model("shadow_right"), "rh_thdistal", {}).translation
    assert np.allclose(tip, np.array([0.034, -0.00858, 0.029]) + (0.038 + 0.032) * along, atol=1e-6)


def test_limits_and_masses_are_the_models():
    model = robot_model("shadow_right")
    joints = {str(n): k for k, n in enumerate(model.model.names)}
    column = model.model.joints[joints["rh_LFJ5"]].idx_q
    assert model.model.upperPositionLimit[column] == pytest.approx(0.785398)
    assert model.model.lowerPositionLimit[model.model.joints[joints["rh_WRJ2"]].idx_q] == pytest.approx(-0.523599)
    total = 3 + 0.1 + 0.3 + 4 * (0.008 + 0.03 + 0.017 + 0.013) + 0.03 + 0.01 + 0.04 + 0.005 + 0.02 + 0.017
    assert pin.computeTotalMass(model.model) == pytest.approx(total - 3), "the forearm stands still"


def test_the_left_hand_is_the_right_ones_mirror_image():
    left, right = robot_model("shadow_left"), robot_model("shadow_right")
    pose = {"FFJ3": 0.7, "FFJ2": 0.4, "LFJ5": 0.3, "LFJ3": 0.5, "THJ4": 0.6, "THJ5": 0.2}
    for tip in ("ffdistal", "lfdistal", "thdistal"):
        one = place(left, f"lh_{tip}", {f"lh_{j}": q for j, q in pose.items()}, of="lh_palm").translation
        other = place(right, f"rh_{tip}", {f"rh_{j}": q for j, q in pose.items()}).translation
        assert np.allclose(one, other * (-1, 1, 1), atol=1e-6)


def test_closed_fingers_lie_in_front_of_the_palm_as_grasps_need_them():
    model = robot_model("shadow_right")
    frame = model.grasp_pose().inverse()
    data, q = model.model.createData(), model.configuration(model.description.named_state("hand", "closed"))
    pin.framesForwardKinematics(model.model, data, q)
    for finger, links in model.description.finger_links.items():
        x, _, z = frame.apply([data.oMf[model.model.getFrameId(links[-1])].translation])[0]
        assert z > 0.04, finger
        assert abs(x) < 0.03, finger
