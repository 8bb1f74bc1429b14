"""A robot's first grasp: of a thing on a bench, by one of its arms. `bench/` has the world and the task for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from string import Template

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.kinematics.model import RobotModel, link_of
from grip_bt.commanders.planning.grasps import choose_grasp
from grip_bt.commanders.planning.requests import Situation
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.task import fmt

_FILES = Path(__file__).with_name("bench")
PLACES = tuple(product((0.45, 0.38, 0.55, 0.65), (0.1, -0.1, 0.25, -0.25)))
"""Where the thing may stand, x and y in world [m]."""
BENCH = SceneObject("bench", Box((0.7, 1.2, 0.1)), Pose([0.65, 0.0, -0.05]), fixed=True)
APPROACH, LIFT = 0.1, 0.15
GAP = 0.04
"""How far above the bench finger tips stay that come from above [m]."""
BLOCK, CAN = "model: block", "shape: cylinder, radius: 0.03, height: 0.15, mass: 0.2"
BESIDE_CAN = np.array([0.018, 0.0, 0.034])
"""The can's axis in the grasp frame of a palm that takes it from the side, `PALM_HEIGHT` above the bench [m]."""
PALM_HEIGHT = 0.09


def first_grasp(robot: RobotDescription, name: Callable[[str], str]) -> dict[str, str]:
    """Return the files of a world and a task in which a hand takes something; none where no arm can.

    Args:
        robot: with a state `home` of each arm.
        name: returns what a group is called in the project.
    """
    model, rest = RobotModel(robot), robot.at_rest
    start = JointState(robot.joints, [rest.get(joint, 0.0) for joint in robot.joints])
    scene = SceneSnapshot().with_object(BENCH)
    for end in robot.end_effectors:
        arm, mine = end.parent_group, set(robot.hands.get(end.group, ()))
        fingers = [links for links in robot.finger_links.values() if set(links) & mine]
        if not fingers or "home" not in robot.named_states.get(arm, {}):
            continue
        can = len(fingers) > 2
        middle = BESIDE_CAN if can else _between(model, arm, fingers)
        situation = Situation(arm, start, scene, "", PlanningSettings())
        for x, y in PLACES:
            try:
                found = choose_grasp(model, situation, tuple(_grasps(x, y, middle, can)), lambda: False).grasp
            except ExpectedError:
                continue
            hand = f"hand: {name(end.group)}"
            said = {"thing": "can" if can else "block", "shape": CAN if can else BLOCK, "x": x, "y": y}
            said |= {key: getattr(found.pose, key).round(4).tolist() for key in ("position", "quaternion")}
            # Two fingers press by a force; more of them close to their torque limits.
            # One of several robots can't go out of the others' way.
            said["seen"] = ", max_hidden: 0.05" if len({e.parent_group for e in robot.end_effectors}) > 1 else ""
            said |= {"arm": name(arm), "hand": name(end.group), "close": hand if can else f"{hand}, force: 10"}
            texts = {f: Template((_FILES / f).read_text("utf-8")).substitute(said) for f in ("bench.yaml", "take.yaml")}
            return {"worlds/bench.yaml": texts["bench.yaml"], "tasks/take.yaml": fmt(texts["take.yaml"], "take.yaml")}
    return {}


def _between(model: RobotModel, group: str, fingers: list[tuple[str, ...]]) -> Array:
    """Return what is between the open fingers, at their tips, in the grasp frame [m], shape (3,)."""
    state = model.description.opened(group)
    links = {link for each in fingers for link in each}
    shapes = zip(model.geometry.geometryObjects, model.hulls(state), strict=True)
    points = np.vstack([points for shape, points in shapes if link_of(model.model, shape) in links])
    inside = model.grasp_pose(state, group=group).inverse().apply(points)
    low, high = inside.min(axis=0), inside.max(axis=0)
    return np.array([*(low + high)[:2] / 2, high[2]])


def _grasps(x: float, y: float, middle: Array, can: bool) -> Iterator[Grasp]:
    turns = (0, 90, 180, 270, *((45, 135, 225, 315) if can else ()))
    for number, turn in enumerate(np.radians(turns)):
        c, s = np.cos(turn), np.sin(turn)
        if can:  # the palm's normal is level, the fingers go round it either way
            every = [np.column_stack([[-up * s, up * c, 0.0], [0.0, 0.0, up], [c, s, 0.0]]) for up in (1.0, -1.0)]
        else:
            every = [np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])]
        for axes in every:
            at = np.array([x, y, PALM_HEIGHT if can else GAP]) - axes @ middle
            pose = Pose.from_matrix(pin.SE3(axes, at).homogeneous)
            yield Grasp(pose, pose.moved(-APPROACH * axes[:, 2]), pose.moved((0.0, 0.0, LIFT)), quality=-number)
