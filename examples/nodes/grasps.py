"""The node that fits grasps of two fingers to the hand there is; for `benchmark/tasks/benchmark.yaml`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

import grip_bt as grip
from grip_bt.base.failures import NoGraspError
from grip_bt.base.values import Grasp, Pose
from grip_bt.base.values.joints import Span

GAP = 0.003
"""Of the hand above the table [m]."""


@grip.leaf("grasps/fit", outputs={"grasps": list[Grasp]}, codes=("no_grasp",))
def fit(context: grip.Context, grasps: list[Grasp], *, hand: str = "", table: float = 0.0) -> list[Grasp]:
    """Put the tips of the hand's fingers where grasps say, in both ways that are the same to two fingers.

    A grasp says a point between the tips, along z the approach and along y how the fingers close. One that is wider
    than the hand opens is left out; one that would reach into the table is raised.
    """
    spans = context.hand(hand).spans()
    fitted = [made for grasp in grasps for made in fitted_to(grasp, spans, table)]
    if not fitted:
        widest = 1000 * spans[0].gap
        wanted = ", ".join(f"{1000 * grasp.width:.0f}" for grasp in grasps) or "none"
        raise NoGraspError(f"the hand opens {widest:.0f} mm; widths of the grasps: {wanted} [mm]")
    return fitted


def fitted_to(grasp: Grasp, spans: Sequence[Span], table: float = 0.0) -> Iterator[Grasp]:
    """Yield a grasp, and the one turned by half about its approach, as poses of a hand's grasp frame.

    Args:
        spans: of the hand, from `open` to `closed`.
        table: its height in the grasp's frame [m].
    """
    opened = [span for span in spans if span.gap >= grasp.width]
    if not opened:
        return
    before, held = spans[0], opened[-1]
    tips = grasp.pose.rotation()
    own = np.stack([np.cross(held.axis, held.inward), held.axis, held.inward], axis=1)
    for turn in (1.0, -1.0):
        rotation = tips @ np.diag([turn, turn, 1.0]) @ own.T
        origin = grasp.pose.position - rotation @ held.middle
        lowest = min(float((span.corners @ rotation.T)[:, 2].min()) for span in (before, held))
        raised = max(0.0, table + GAP - lowest - origin[2])
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation, origin + [0.0, 0.0, raised]
        pose = Pose.from_matrix(matrix, grasp.pose.frame)
        back = grasp.pre_grasp.position - grasp.pose.position
        up = grasp.post_grasp.position - grasp.pose.position
        yield replace(
            grasp, pose=pose, pre_grasp=pose.moved(back), post_grasp=pose.moved(up), pre_posture=before.posture
        )
