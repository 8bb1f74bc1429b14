"""Leaves that make grasps of poses, and that put candidates in another order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.values import Grasp, JointState, Pose

from .arm import ArmLeaf
from .leaf import Leaf, Status


class Make(Leaf):
    """Make a grasp of one pose: approach along the palm's normal, lift straight up."""

    def update(self) -> Status:
        """Make it."""
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
        """Score each, and give them out with the scores as their qualities."""
        grasps: Sequence[Grasp] = self.read("grasps")
        scores = self._scores(grasps)
        order = sorted(range(len(grasps)), key=lambda k: -scores[k])
        return self.end(grasps=[replace(grasps[k], quality=float(scores[k])) for k in order])

    def _scores(self, grasps: Sequence[Grasp]) -> NDArray[np.float64]:
        here, p = self.arm.grasp_pose(), self.params
        quality = np.array([g.quality for g in grasps])
        distance = np.array([np.linalg.norm(g.pose.position - here.position) for g in grasps])
        downward = np.array([-g.pose.rotation()[2, 2] for g in grasps])
        scores: NDArray[np.float64] = p["quality"] * quality - p["distance"] * distance + p["downward"] * downward
        return scores
