"""Leaves around one grasp: make candidates, choose one, go there, lift, and get away from there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from grip_bt.base.failures import CanceledError, ExpectedError, NoGraspError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Hand
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.nodes.arm import ArmLeaf
from grip_bt.nodes.leaf import Leaf, Status
from grip_bt.nodes.motion import first_of, go, go_straight, leaving
from grip_bt.nodes.objects import HELD, SEEN, TABLE_GAP, free_name, object_at, objects_near, rename


class MakePose(Leaf):
    """Make a pose of numbers."""

    def prepare(self) -> None:
        """Make it now, so that wrong numbers are found before the run."""
        self._pose = Pose(self.params["position"], self.params["quaternion"], self.params["frame"])

    def update(self) -> Status:
        return self.end(pose=self._pose)


class Offset(Leaf):
    """Move and turn a pose."""

    def prepare(self) -> None:
        """Make the way now, so that wrong numbers are found before the run."""
        self._way = Pose(self.params["position"], self.params["quaternion"])

    def update(self) -> Status:
        pose: Pose = self.read("pose")
        turned = pose @ Pose(quaternion=self._way.quaternion)
        way = pose.rotation() @ self._way.position if self.params["own_axes"] else self._way.position
        return self.end(moved=turned.moved(way))


class MakeGrasp(Leaf):
    """Make a grasp of one pose: approach along the palm's normal, lift straight up."""

    def update(self) -> Status:
        pose: Pose = self.read("pose")
        p, posture = self.params, self.read("posture")
        before: JointState | None = self.read("pre_posture")
        grasp = Grasp(
            pose,
            pose.moved(-p["approach"] * pose.rotation()[:, 2]),
            pose.moved((0.0, 0.0, p["lift"])),
            pre_posture=before,
            posture=posture,
            torque_limit=p["torque_limit"],
            width=p["width"],
            quality=p["quality"],
            provenance=self.path,
        )
        return self.end(grasp=grasp)


class Rank(ArmLeaf):
    """Put grasps in order by a weighted sum of what speaks for them."""

    def update(self) -> Status:
        grasps: Sequence[Grasp] = self.read("grasps")
        here, p = self.arm.grasp_pose(), self.params
        quality = np.array([g.quality for g in grasps])
        distance = np.array([np.linalg.norm(g.pose.position - here.position) for g in grasps])
        downward = np.array([-g.pose.rotation()[2, 2] for g in grasps])
        scores = p["quality"] * quality - p["distance"] * distance + p["downward"] * downward
        order = sorted(range(len(grasps)), key=lambda k: -scores[k])
        return self.end(grasps=[replace(grasps[k], quality=float(scores[k])) for k in order])


_SAME_PLACE = 0.02
"""Two grasps nearer than this [m] and `_SAME_DIRECTION` are one."""
_SAME_DIRECTION = np.radians(20)


def same_grasp(one: Grasp, other: Grasp) -> bool:
    """Tell whether two grasps put the hand within 2 cm and 20 degrees of each other."""
    way = one.pose.inverse() @ other.pose
    near = np.linalg.norm(way.position) <= _SAME_PLACE
    return bool(near and np.linalg.norm(way.rotation_vector()) <= _SAME_DIRECTION)


class Choose(ArmLeaf):
    """Choose the best feasible grasp that wasn't tried."""

    def start(self) -> Operation[Grasp]:
        grasps: Sequence[Grasp] = self.read("grasps")
        tried: Sequence[Grasp] = self.read("tried") or ()
        fresh = [g for g in grasps if not any(same_grasp(g, t) for t in tried)]
        if not fresh:
            raise NoGraspError(
                f"all {len(grasps)} candidates were tried before" if grasps else "there are no candidates",
                candidates=len(grasps),
                tried=len(tried),
            )
        return self.arm.choose_grasp(fresh)


class Remember(Leaf):
    """Add a grasp to those that did not work."""

    def update(self) -> Status:
        """Write the longer list; values are never changed in place."""
        return self.end(tried=[*(self.read("tried") or ()), self.read("grasp")])


class MoveToGrasp(ArmLeaf):
    """Go to a grasp: a free path to the pre-grasp, then straight on until the hand is around the object.

    Nothing may be touched on the way to the pre-grasp. The straight part doesn't see the box of the object that is to
    be taken: a box around a round thing has corners that aren't there.
    """

    def start(self) -> Operation[JointState]:
        grasp: Grasp = self.read("grasp")
        return go(self.arm, grasp.pre_grasp).then(lambda _: self._approach(grasp))

    def _approach(self, grasp: Grasp) -> Operation[JointState]:
        scene = self.context.scene()
        target = object_at(scene, grasp)
        return go_straight(self.arm, [grasp.pose], scene, [target] if target else [])


class ArmHandLeaf(ArmLeaf):
    """A leaf with the parameters `arm` and `hand`."""

    hand: Hand

    def prepare(self) -> None:
        super().prepare()
        self.hand = self.context.hand(self.params["hand"])


class Lift(ArmHandLeaf):
    """Lift straight to the post-grasp; the object at the grasp, if the scene has one, moves along from now on."""

    def start(self) -> Steps[JointState]:
        grasp: Grasp = self.read("grasp")
        scene = self.context.scene()
        target = object_at(scene, grasp)
        if target is not None:
            held = HELD + self.hand.name
            rename(scene, target, held)
            scene.attach(held, self.hand.name)
        return leaving(self.arm, grasp.post_grasp, scene)


class Retreat(ArmHandLeaf):
    """Get the arm to where it can plan again, from wherever a failed attempt left it.

    The hand opens; what was attached is put, in the scene, upright onto the table below, where it most likely is now.
    Then the arm backs off along the palm's normal and goes up, each as far as it can: the whole way, else a half,
    else a quarter. Objects around the hand are ignored, since the hand is among them already. It fails with `stuck`
    only when no step at all could be made.
    """

    def finish(self, result: list[ExpectedError]) -> Status:
        if len(result) < 2:
            return self.end()
        reasons = [f"{e.code}: {e.message}" for e in result]
        return self.fail("stuck", "the arm could neither back off nor go up", reasons=reasons)

    def start(self) -> Steps[list[ExpectedError]]:
        errors: list[ExpectedError] = []
        yield from self._attempt(self.hand.open(), [])
        scene = self.context.scene()
        for name in scene.attached(self.hand.name):
            size, pose = scene.box(name)
            scene.detach(name)
            scene.remove(name)
            below = Pose([*pose.position[:2], float(size[2]) / 2 + TABLE_GAP], pose.quaternion)
            scene.set_box(free_name(scene, SEEN), size.tolist(), below)
        back = -self.arm.grasp_pose().rotation()[:, 2] * self.params["distance"]
        for offset in (back, np.array([0.0, 0.0, self.params["height"]])):
            start = self.arm.grasp_pose()
            goals, ignore = [start.moved(offset * part) for part in (1.0, 0.5, 0.25)], objects_near(scene, start)
            ways = (partial(run_steps, leaving(self.arm, goal, scene, ignore)) for goal in goals)
            yield from self._attempt(first_of(ways), errors)
        return errors

    def _attempt(self, motion: Operation[JointState], errors: list[ExpectedError]) -> Steps[None]:
        try:
            yield motion
        except CanceledError:
            raise
        except ExpectedError as error:
            errors.append(error)
