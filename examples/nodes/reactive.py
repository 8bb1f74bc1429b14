"""The node of `tasks/reactive.yaml` that draws another pose of the hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import grip_bt as grip
from grip_bt.base.values import Grasp


@grip.leaf("reactive/draw_pose", outputs={"grasp": Grasp}, quick=True)
def draw_pose(grasp: Grasp, number: int, *, radius: float = 0.01, seed: int = 0) -> Grasp:
    """Move a grasp sideways, anywhere within `radius` [m]; the first (`number` 0) stays as it was proposed.

    A seed and a number always draw the same: a run that is repeated goes the same way.
    """
    if number == 0:
        return grasp
    random = np.random.default_rng((seed, number))
    angle, distance = random.uniform(-np.pi, np.pi), radius * np.sqrt(random.random())
    shift = (distance * np.cos(angle), distance * np.sin(angle), 0.0)
    return replace(
        grasp,
        pose=grasp.pose.moved(shift),
        pre_grasp=grasp.pre_grasp.moved(shift),
        post_grasp=grasp.post_grasp.moved(shift),
        provenance=f"{grasp.provenance} moved by {1000 * distance:.0f} mm".strip(),
    )
