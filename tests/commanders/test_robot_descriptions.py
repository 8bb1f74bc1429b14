import pickle
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from table_top import AT_TABLES, named, robot_model

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.description.packages import ROBOTS

EYE = np.array([0.53, 0.10, 1.3])
"""Of the overhead camera."""
PICK_LOW, PICK_HIGH = np.array([0.38, -0.12]), np.array([0.70, 0.36])


@pytest.mark.parametrize("name", ROBOTS)
def test_all_joints_have_drives_limits_and_accelerations(name):
    model = robot_model(name)
    description = model.description
    followers = set(description.mimics)
    assert set(description.joints) | followers == set(model.model.names[1:])
    assert set(description.drives) == set(description.acceleration_limits) == set(description.joints) | followers
    assert description.groups
    for group in description.groups:
        limits = model.limits(group)
        assert (limits.lower < limits.upper).all()
        assert (limits.velocity > 0).all()
        assert (limits.acceleration > 0).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_named_states_respect_the_limits(name):
    model = robot_model(name)
    for group, states in model.description.named_states.items():
        limits = model.limits(group)
        for state in states.values():
            assert state.names == model.description.group(group)
            assert (state.position >= limits.lower).all()
            assert (state.position <= limits.upper).all()


@pytest.mark.parametrize("name", ROBOTS)
def test_arms_rest_at_home_and_hands_open_whatever_states_both_have_together(name):
    description = robot_model(name).description
    for states in description.named_states.values():
        rest = states.get("home", states.get("open"))
        if rest is not None:
            assert {joint: description.at_rest[joint] for joint in rest.names} == rest.as_mapping()


@pytest.mark.parametrize("name", ROBOTS)
def test_every_mesh_exists_on_this_machine(name):
    meshes = [Path(m.get("filename")) for m in ET.fromstring(build_robot(name).urdf).iter("mesh")]
    assert meshes or name == "parallel_gripper"  # made of boxes
    assert all(mesh.is_absolute() and mesh.is_file() for mesh in meshes)


@pytest.mark.parametrize("name", ROBOTS)
def test_hand_and_finger_links_are_links_of_the_robot(name):
    description = build_robot(name)
    links = {e.get("name") for e in ET.fromstring(description.urdf).findall("link")}
    assert set(description.hand_links) <= links
    assert {link for finger in description.finger_links.values() for link in finger} <= set(description.hand_links)
    assert all(set(mine) <= set(description.hand_links) for mine in description.hands.values())
    assert {frame.link for frame in (description.grasp_frame, *description.grasp_frames.values())} <= links
    assert description.base_link in links
    assert all(a in links and b in links for a, b in description.disabled_pairs)


@pytest.mark.parametrize("name", AT_TABLES)
def test_the_grasp_frame_is_where_the_fingers_close(name):
    """z leaves the palm, x runs along the fingers, closed fingertips lie in front of the palm, mirrored about y."""
    model = robot_model(name)
    frame = model.grasp_pose()
    tips = {
        posture: [
            frame.inverse().apply([_link_position(model, named(model, "hand", posture), links[-1])])[0]
            for links in model.description.finger_links.values()
        ]
        for posture in ("flat", "open", "closed")
    }
    flat, closed = np.array(tips["flat"][:3]), np.array(tips["closed"][:3])
    assert (flat[:, 0] > 0.15).all()
    assert (np.abs(flat[:, 2]) < 0.02).all()
    assert (closed[:, 2] > 0.04).all()
    assert (closed[:, 0] < 0.03).all()
    assert flat[0, 1] == pytest.approx(-flat[2, 1], abs=0.005)
    opened = np.array(tips["open"][:3])
    assert (opened[:, 0] > 0.034 + 0.012 + 0.03).all(), "bent fingers leave room for the thickest thing"


def _link_position(model, posture: JointState, link: str):
    data = model.model.createData()
    pin.framesForwardKinematics(model.model, data, model.configuration(posture))
    return data.oMf[model.model.getFrameId(link)].translation


@pytest.mark.parametrize("name", AT_TABLES)
def test_home_leaves_the_pick_region_visible_from_above_even_with_a_thing_in_the_hand(name):
    model = robot_model(name)
    lowest = np.inf
    for link, corners in [*_shape_corners(model), ("held thing", _held_thing(model))]:
        assert (corners[:, 2] < EYE[2] - 0.05).all(), f"{link} is above the camera"
        scale = EYE[2] / (EYE[2] - corners[:, 2:])
        shadow = EYE[:2] + (corners[:, :2] - EYE[:2]) * scale
        gap = np.maximum(PICK_LOW - shadow.max(axis=0), shadow.min(axis=0) - PICK_HIGH)
        assert gap.max() > 0.02, f"{link} hides part of the pick region"
        if link in model.description.hand_links or link == "held thing":
            lowest = min(lowest, corners[:, 2].min())
    assert lowest >= 0.25


def _shape_corners(model):
    chain = model.chain("arm")
    data = chain.geometry.createData()
    q = named(model, "arm", "home").position
    pin.updateGeometryPlacements(chain.model, chain.data, chain.geometry, data, q)
    for row, shape in enumerate(chain.geometry.geometryObjects):
        shape.geometry.computeLocalAABB()
        box = shape.geometry.aabb_local
        ends = np.stack([box.min_, box.max_])
        corners = np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        link = chain.model.frames[shape.parentFrame].name
        yield link, corners @ data.oMg[row].rotation.T + data.oMg[row].translation


def _held_thing(model):
    """A cylinder of 17 cm in the closed hand, its middle up to 3 cm off the palm's."""
    corners = [[x, y, z] for x in (-0.035, 0.035) for y in (-0.115, 0.115) for z in (0.0, 0.075)]
    return model.grasp_pose().apply(np.array(corners))


@pytest.mark.parametrize("name", AT_TABLES)
def test_home_holds_an_upright_thing_upright(name):
    along_thing = robot_model(name).grasp_pose().rotation()[:, 1]
    assert abs(along_thing[2]) > 0.99


def test_a_description_survives_the_way_to_another_process():
    description = build_robot("panda_allegro")
    copy = pickle.loads(pickle.dumps(description))
    assert copy == description
    with pytest.raises(TypeError):
        copy.groups["arm"] = ()


def test_an_unknown_robot_lists_those_that_exist():
    with pytest.raises(UnknownNameError, match="did you mean 'panda_allegro'.*ur10_allegro"):
        build_robot("panda_alegro")


def test_unknown_groups_and_states_list_those_that_exist():
    description = build_robot("panda_allegro")
    with pytest.raises(UnknownNameError, match="arm, hand"):
        description.group("arms")
    with pytest.raises(UnknownNameError, match="home"):
        description.named_state("arm", "rest")
