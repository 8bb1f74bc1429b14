"""The robot in the physics: loaded from its description, driven by PD drives, relieved of its own weight."""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from grip_bt.base.arrays import Array, Indices
from grip_bt.commanders.description.robot import Mimic, RobotDescription
from grip_bt.commanders.trajectory.stopping import accelerations_of
from grip_sim.physics import HAND, ArticulationBuilder, ignore_each_other, physx, sapien

NEAR_BASE, THUMB = 30, 29
PAIRS = range(28, 11, -1)
"""For pairs of a finger's links that touch by construction; no hand that we know has as many."""
GENTLE = 0.1
"""Part of the drives' torque with which a hand presses at first, when it touches something."""
CALM = 4.0
"""Armature of fingers that slide together over their drive's stiffness times dt^2, at least: lighter ones would swing
about their tie faster than in a step."""
TIE, TIE_TIME = 5.0, 1e-3
"""Stiffness of a linkage over its drive's, and its damping over that [s]. Much stiffer, it swings, and fingers
knock each other off what they meet."""
BELT = 6.0
"""Likewise of fingers that slide together: one drive moves them, and the tie alone moves those that follow."""
REGULATION = 8.0
"""Rate at which that torque grows or sinks while fingers don't press at all, or twice as hard as they are to [1/s]."""
EXACT = 0.01
"""Errors of a regulated force smaller than this part of it aren't regulated."""
LEAST, MOST = 1e-3, 0.999
"""Torques that regulation leaves a drive, as parts of what it can; all of it has one that has touched nothing yet."""


class Measured(NamedTuple):
    """State of some joints: arrays of one length; rad, rad/s, N m."""

    names: tuple[str, ...]
    position: Array
    velocity: Array
    effort: Array


class SimRobot:
    """An articulation whose joints hold or follow drive targets.

    Args:
        scene: where it is put, with its base link at the origin.
    """

    def __init__(self, scene: sapien.Scene, description: RobotDescription):
        self.description = description
        self.body = _load(scene, description)
        self.links = tuple(self.body.links)
        self.hand_links = frozenset(description.hand_links)
        self._joints = list(self.body.active_joints)
        self._drives = [(joint.set_drive_target, joint.set_drive_velocity_target) for joint in self._joints]
        self._exert, self._weight = self.body.set_qf, self.body.compute_passive_force
        self._where = self.body.get_qpos
        self._rows = {joint.name: row for row, joint in enumerate(self._joints)}
        count, self._dt = len(self._joints), scene.timestep
        self._target, self._speed = [0.0] * count, [0.0] * count
        self._stiffness, self._damping = np.zeros(count), np.zeros(count)
        self._limit, self._force = np.zeros(count), np.zeros(count)
        self._ranges: dict[int, tuple[float, float]] = {}
        self.pressing: dict[str, list[int]] = {}
        """The hands whose force is regulated, each with the rows of its joints."""
        self._followers: dict[int, list[int]] = {}
        for name, mimic in description.mimics.items():
            self._followers.setdefault(self._rows[mimic.joint], []).append(self._rows[name])
        self._tie()
        self._set_drives()
        self._let_neighbours_pass()
        rest = {j: q for j, q in description.at_rest.items() if j in self._rows}
        self.place(description.with_followers(rest))

    def rows(self, names: Sequence[str]) -> Indices:
        """Return the indices of joints, for the other methods."""
        return np.array([self._rows[name] for name in names], dtype=np.intp)

    def place(self, positions: Mapping[str, float]) -> None:
        """Put joints at positions [rad] at once, at rest; for the start of a world only."""
        q = np.array(self.body.get_qpos())
        rows = self.rows(tuple(positions))
        q[rows] = list(positions.values())
        self.body.set_qpos(q.astype(np.float32))
        self.body.set_qvel(np.zeros(len(q), np.float32))
        self._before = self.positions()
        self.drive(rows, q[rows])

    def drive(self, rows: Indices, positions: Array, velocities: Array | None = None) -> None:
        """Set drive targets [rad, rad/s]; without velocities the joints are to stand still."""
        speeds = [0.0] * len(rows) if velocities is None else velocities.tolist()
        self.aim(rows.tolist(), positions.tolist(), speeds)

    def aim(self, rows: Iterable[int], positions: Iterable[float], speeds: Iterable[float]) -> None:
        """Set drive targets, as `drive` does, of what was made ready for many steps; PhysX is told what is new."""
        targets, before, drives = self._target, self._speed, self._drives
        for row, position, speed in zip(rows, positions, speeds, strict=True):
            if row in self._ranges:
                low, high = self._ranges[row]
                kept = min(max(position, low), high)
                position, speed = kept, speed if kept == position else 0.0
            if position != targets[row]:
                targets[row] = position
                drives[row][0](position)
            if speed != before[row]:
                before[row] = speed
                drives[row][1](speed)

    def follow(self) -> None:
        """Note where joints are, and aim those that mimic others by drives of their own at where those *are*.

        What stops the leading joint stops the linkage that it moves, so that the fingers stay parallel on a thing. A
        linkage is no damper: each joint is aimed at with the speed that it has.
        """
        self._before = before = self._where()
        if not self._aimed:
            return
        speeds = self.body.get_qvel()
        for row, mimic in self._aimed:
            leader = self._rows[mimic.joint]
            self.aim([row], [mimic.multiplier * before.item(leader) + mimic.offset], [speeds.item(row)])

    def limit_torque(self, rows: Iterable[int], limit: float | None) -> None:
        """Limit the torque of drives [N m] and of those that mimic them; None restores the description's limits."""
        for leader in rows:
            for row in (leader, *self._followers.get(leader, ())):
                self._limit[row] = value = self._most[row] if limit is None else min(limit, self._most[row])
                stiffness, damping = self._stiffness[row], self._damping[row]
                self._joints[row].set_drive_properties(stiffness, damping, force_limit=value, mode="force")

    def press(self, rows: Indices, force: float | None) -> None:
        """Have the drives' torque regulated so that the hand presses with a force [N]; None ends that."""
        self._force[rows] = force or 0.0
        self._note_pressing()

    def restrict(self, joint: str, between: tuple[float, float] | None) -> None:
        """Have a joint's drive keep it within a range [rad or m], where it is for an empty one; None ends that."""
        row = self._rows[self._belts.get(joint, joint)]
        if between is None:
            self._ranges.pop(row, None)
            return
        here = float(self.positions()[row])
        self._ranges[row] = between if between[0] <= between[1] else (here, here)
        self.aim([row], [self._target[row]], [0.0])

    def _note_pressing(self) -> None:
        self.pressing = {}
        for row in np.flatnonzero(self._force).tolist():
            self.pressing.setdefault(self.hand_of(row), []).append(row)

    def hand_of(self, row: int) -> str:
        """Return the hand that a joint belongs to; the first where its group doesn't tell."""
        hands, groups = self.description.hands, self.description.groups
        return next((hand for hand in hands if self._joints[row].name in groups.get(hand, ())), next(iter(hands), ""))

    def regulate(self, rows: Sequence[int], pressed: float, dt: float) -> bool:
        """Let a hand that presses [N] have torques that grow or sink towards its force for a time [s].

        Until something is touched the fingers close as they are driven. False where it presses as it is to.
        """
        error = min(max(1 - pressed / self._force.item(rows[0]), -1.0), 1.0)
        if abs(error) < EXACT:
            return False
        for row in rows:
            most, limit = self._most[row], float(self._limit[row])
            if limit < most:
                grown = limit * float(np.exp(REGULATION * error * dt))
                self.limit_torque([row], min(max(grown, LEAST * most), MOST * most))
            elif pressed:
                self.limit_torque([row], GENTLE * most)
        return True

    def groups_of(self, rows: Indices) -> list[str]:
        """Return the groups that one of these joints belongs to."""
        names = {self._joints[row].name for row in rows.tolist()}
        return [group for group, joints in self.description.groups.items() if names.intersection(joints)]

    def accelerations(self, rows: Indices) -> Array:
        """Return the acceleration limits of joints [rad/s^2]."""
        return accelerations_of([self._joints[row].name for row in rows.tolist()], self.description.acceleration_limits)

    def targets(self, rows: Indices) -> Array:
        """Return the drive targets [rad]."""
        return np.array(self._target)[rows]

    def positions(self) -> Array:
        """Return all joint positions [rad]."""
        return np.asarray(self.body.get_qpos(), dtype=float)

    def velocities(self) -> Array:
        """Return all joint velocities [rad/s], by where they were a step ago.

        The solver's own of joints that press on something, and stand still, are up to 1 rad/s.
        """
        return (self.positions() - self._before) / self._dt

    def kept(self) -> dict[str, Array]:
        """Return everything that makes the robot move on as it does: states, targets and limits of all joints."""
        driven = {"targets": self._target, "speeds": self._speed, "limits": self._limit, "forces": self._force}
        copies = {name: np.array(each) for name, each in driven.items()}
        return {"positions": self.positions(), "velocities": np.asarray(self.body.get_qvel(), dtype=float), **copies}

    def put_back(self, kept: Mapping[str, Array]) -> None:
        """Bring the robot into a state that was kept. Raises ValueError where it is of a robot with other joints."""
        count = len(self._joints)
        wrong = {name: np.shape(kept[name]) for name in self.kept() if np.shape(kept[name]) != (count,)}
        if wrong:
            raise ValueError(f"the state is of another robot: this one has {count} joints, not {wrong}")
        self.body.set_qpos(np.asarray(kept["positions"], np.float32))
        self.body.set_qvel(np.asarray(kept["velocities"], np.float32))
        self._before = self.positions() - kept["velocities"] * self._dt
        self.drive(np.arange(count), kept["targets"], kept["speeds"])
        for row in range(count):
            self.limit_torque([row], float(kept["limits"][row]))
        self._force[:] = kept["forces"]
        self._note_pressing()

    def measure(self, rows: Indices) -> Measured:
        """Return the state of joints; the efforts are what the drives give, without the weight that is compensated."""
        q, v, speeds = self.positions()[rows], self.velocities()[rows], np.array(self._speed)[rows]
        wanted = self._stiffness[rows] * (self.targets(rows) - q) + self._damping[rows] * (speeds - v)
        effort = np.clip(wanted, -self._limit[rows], self._limit[rows])
        return Measured(tuple(self._joints[r].name for r in rows.tolist()), q, v, effort)

    def compensate(self) -> None:
        """Apply the joint forces that carry the robot's own weight; before each step."""
        self._exert(self._weight(True, True))

    def _set_drives(self) -> None:
        self._most = [self.description.drives[joint.name].limit for joint in self._joints]
        linked = {*self._followers, *(row for each in self._followers.values() for row in each)}
        for row, joint in enumerate(self._joints):
            drive = self.description.drives[joint.name]
            joint.set_friction(0.0)  # the Allegro's URDF says 5-10 N m, ten times what its motors give
            calm = CALM * drive.stiffness * self._dt**2 if row in linked and joint.type == "prismatic" else 0.0
            joint.set_armature(np.array([max(drive.armature, calm)], dtype=np.float32))
            if joint.name not in self._belts:
                self._stiffness[row], self._damping[row] = drive.stiffness, drive.damping
        self.limit_torque(range(len(self._joints)), None)

    def _tie(self) -> None:
        """Tie joints of a linkage by tendons: to the one that leads where that is beside them, else to the one below.

        PhysX's tendons pass no fixed joint; what is behind one is held by its drive alone.
        """
        joints, mimics = {joint.name: joint for joint in self._joints}, self.description.mimics
        self._belts: dict[str, str] = {}
        """Joints without a drive of their own, as they slide as the one that leads does."""
        for name, mimic in mimics.items():
            child, other = joints[name].child_link, joints[mimic.joint]
            if other.parent_link != child.parent:
                other = child.parent.joint
            tied = mimics.get(other.name, Mimic(other.name))
            if tied.joint != mimic.joint:
                continue
            ratio = mimic.multiplier / tied.multiplier
            if joints[name].type == "prismatic" and mimic == Mimic(mimic.joint):
                self._belts[name] = mimic.joint
            stiffness = (BELT if name in self._belts else TIE) * self.description.drives[mimic.joint].stiffness
            self.body.create_fixed_tendon(
                [other.parent_link, other.child_link, child],
                [0.0, -ratio, 1.0],
                [0.0, -1 / ratio, 1.0],
                rest_length=mimic.offset - ratio * tied.offset,
                stiffness=stiffness,
                damping=TIE_TIME * stiffness,
            )
        self._aimed = [(self._rows[name], mimic) for name, mimic in mimics.items() if name not in self._belts]

    def _let_neighbours_pass(self) -> None:
        fingers = list(self.description.finger_links.values())
        distal = {link for finger in fingers for link in finger[2:]}
        thumb = set(fingers[-1][:3]) if fingers else set()
        for link in self.links:
            for shape in link.collision_shapes if link.name in self.hand_links else ():
                shape.set_collision_groups([*HAND, *shape.get_collision_groups()[2:]])
            if link.name not in distal:  # arm, palm, roots of the fingers: the planner keeps them apart
                ignore_each_other(link.collision_shapes, NEAR_BASE)
            if link.name in thumb:
                ignore_each_other(link.collision_shapes, THUMB)
        shapes = {link.name: link.collision_shapes for link in self.links}
        touching = sorted(pair for pair in self.description.disabled_pairs if distal & set(pair))
        for bit, (one, other) in zip(PAIRS, touching, strict=False):
            ignore_each_other([*shapes[one], *shapes[other]], bit)


def _load(scene: sapien.Scene, description: RobotDescription) -> physx.PhysxArticulation:
    builder = _builder(description.urdf)
    body = builder.set_scene(scene).build()
    builder.set_scene(None)  # it stays, and the scene needn't
    body.set_solver_position_iterations(16)  # with SAPIEN's own 10, a gripper loses what is round in a shake
    body.set_solver_velocity_iterations(1)
    return body


@lru_cache(maxsize=4)
def _builder(urdf: str) -> ArticulationBuilder:
    """Return what builds a robot, whose URDF takes longer to read than that."""
    loader = sapien.Scene([]).create_urdf_loader()
    loader.fix_root_link = True
    loader.set_material(0.0, 0.0, 0.0)  # as `FIXED`: an object's own friction counts
    with tempfile.TemporaryDirectory() as folder:  # the loader reads files only
        file = Path(folder) / "robot.urdf"
        file.write_text(bare(urdf))
        ((builder,), _, _) = loader.parse(str(file))
    return builder


def bare(urdf: str) -> str:
    """Return a URDF without `<visual>`, as nothing renders, and `<mimic>`: joints are tied here."""
    robot = ET.fromstring(urdf)
    for part in (*robot.findall("link"), *robot.findall("joint")):
        for element in (*part.findall("visual"), *part.findall("mimic")):
            part.remove(element)
    return ET.tostring(robot, encoding="unicode")
