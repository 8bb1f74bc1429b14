"""A table with a crate, upright things on it, and side grasps of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.requests import PlanTo, Situation
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.settings import PlanningSettings

CRATE = np.array([0.48, -0.40])
PATIENCE = 60.0
"""Time that a plan may take, also on a slow machine [s]."""

AT_TABLES = ("panda_allegro", "ur5_allegro", "ur10_allegro")
"""Robots that the demo's world is made for."""


@dataclass(frozen=True)
class Thing:
    """An upright cylinder: its place on the table, its radius and its height [m]."""

    place: np.ndarray
    radius: float
    height: float


@cache
def robot_model(name: str = "panda_allegro") -> RobotModel:
    return RobotModel(build_robot(name))


def joined(*states: JointState) -> JointState:
    return JointState(tuple(n for s in states for n in s.names), np.concatenate([s.position for s in states]))


def named(model: RobotModel, group: str, state: str) -> JointState:
    return model.description.named_state(group, state)


def room(model: RobotModel, hand: Callable[[], Pose] | None = None) -> PlanningScene:
    """The table and the crate, and nothing else; the hand is where the arm's home puts it, unless told otherwise."""
    (x, y), wall, height = CRATE, 0.01, 0.06
    walls = {
        "left": ((0.28, wall, height), (x, y - 0.155)),
        "right": ((0.28, wall, height), (x, y + 0.155)),
        "back": ((wall, 0.30, height), (x - 0.135, y)),
        "front": ((wall, 0.30, height), (x + 0.135, y)),
    }
    fixed = {f"crate_{n}": (size, Pose([*xy, height / 2])) for n, (size, xy) in walls.items()}
    fixed["table"] = ((0.7, 1.2, 0.1), Pose([0.65, 0.0, -0.05]))
    home = named(model, "arm", "home")
    return PlanningScene({"right_hand": hand or (lambda: model.grasp_pose(home))}, fixed)


def place_things(scene: PlanningScene, rng: np.random.Generator, count: int = 3) -> list[Thing]:
    """Stand things on the table, at least 0.15 m apart; the scene knows them as `thing_0` and so on."""
    things: list[Thing] = []
    while len(things) < count:
        place = np.array([rng.uniform(0.42, 0.64), rng.uniform(-0.08, 0.32)])
        if all(np.linalg.norm(place - other.place) >= 0.15 for other in things):
            things.append(Thing(place, rng.uniform(0.028, 0.034), rng.uniform(0.14, 0.17)))
    for k, thing in enumerate(things):
        size = (2 * thing.radius, 2 * thing.radius, thing.height)
        scene.set_box(f"thing_{k}", size, Pose([*thing.place, thing.height / 2]))
    return things


def side_grasp(thing: Thing, yaw: float, flip: float, quality: float = 0.0) -> Grasp:
    """A level grasp from the direction `yaw`, palm edge down; the approach comes slightly from above."""
    z, y = np.array([np.cos(yaw), np.sin(yaw), 0.0]), np.array([0.0, 0.0, flip])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([np.cross(y, z), y, z], axis=1)
    height = max(0.08, 0.65 * thing.height)
    matrix[:3, 3] = [*thing.place, height] - (thing.radius + 0.004) * z
    pose = Pose.from_matrix(matrix)
    back = -0.12 * z + [0.0, 0.0, 0.06]
    return Grasp(pose, pose.moved(back), pose.moved([0, 0, 0.15]), width=2 * thing.radius, quality=quality)


def side_grasps(thing: Thing, rng: np.random.Generator) -> list[Grasp]:
    """Side grasps at 24 yaw angles and 2 flips, in random order of quality."""
    turns = np.linspace(-np.pi, np.pi, 24, endpoint=False)
    return [side_grasp(thing, yaw, flip, rng.random()) for yaw in turns for flip in (1.0, -1.0)]


def situation(model: RobotModel, scene, arm: JointState | None = None, hand: str = "open", seed: int = 0) -> Situation:
    start = joined(arm or named(model, "arm", "home"), named(model, "hand", hand))
    return Situation("arm", start, scene, "right_hand", PlanningSettings(seed=seed, planning_time=PATIENCE))


def endless_request(planner="RRTConnect"):
    """Start and goal are free, but the forearm is threaded through a frame that the hand doesn't fit through."""
    model = robot_model()
    scene, home = room(model), named(model, "arm", "home")
    chain = model.chain("arm")
    chain.grasp_pose(home.position)
    elbow, wrist = chain.data.oMi[4], chain.data.oMi[5]
    middle = Pose.from_matrix(wrist.homogeneous)
    middle = Pose(elbow.translation * 0.7 + wrist.translation * 0.3, middle.quaternion)
    opening, edge = 0.09, 0.02
    for k, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        size = (edge, 2 * opening + 2 * edge, edge) if x else (2 * opening + 2 * edge, edge, edge)
        offset = np.array([x, y, 0.0]) * (opening + edge / 2) + [0.0, 0.04, 0.0]
        scene.set_box(f"frame_{k}", size, Pose(middle.apply([offset])[0], middle.quaternion))
    begin = situation(model, scene.snapshot())
    settings = begin.settings.model_copy(update={"planning_time": 600.0, "planner": planner})
    begin = dataclasses.replace(begin, settings=settings)
    checker = CollisionChecker(chain, scene.snapshot(), "right_hand")
    assert checker.free(home.position)
    rng, limits = np.random.default_rng(0), model.limits("arm")
    elsewhere = (q for _ in range(1000) if (q := rng.uniform(limits.lower, limits.upper))[0] > 1.0)
    goal = next(q for q in elsewhere if checker.free(q))
    return PlanTo(begin, JointState(home.names, goal))
