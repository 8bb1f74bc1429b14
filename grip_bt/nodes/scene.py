"""The leaf that tells the planning scene what a camera sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Scene
from grip_bt.base.values import PointCloud, Pose

from .clusters import clusters_above, upright_box
from .leaf import Leaf, OperationLeaf, Status
from .objects import HELD, SEEN, distances_to_box, region_of

Box = tuple[NDArray[np.float64], Pose]


class NothingSeen(Leaf):
    """Tell whether the last look has found nothing on the table, and if not, what is left and where."""

    def update(self) -> Status:
        """Look into the scene."""
        scene = self.context.scene()
        left = [scene.box(name)[1].position for name in scene.names() if name.startswith(SEEN)]
        if not left:
            return self.end()
        places = ", ".join(f"({x:.2f}, {y:.2f})" for x, y, _ in left)
        things = "1 thing is" if len(left) == 1 else f"{len(left)} things are"
        return self.fail("something_left", f"{things} left, at {places} [m]", count=len(left))


class UpdateFromCloud(OperationLeaf):
    """Replace the scene's `seen_*` by what a cloud shows on the table now.

    What lies within the target, or on its walls, and what moves with a hand is left out: the scene knows these better.
    """

    def start(self) -> Operation[list[Box]]:
        """Find the boxes in a worker."""
        cloud: PointCloud = self.read("cloud")
        if cloud.frame != "world":
            raise SensorError(f"the cloud is given in frame {cloud.frame!r}, not in world")
        if not len(cloud.points):
            raise SensorError("the cloud has no points")
        scene = self.context.scene()
        return self.context.run_in_worker(lambda: self._boxes(scene, cloud.points))

    def finish(self, result: list[Box]) -> Status:
        """Change the scene."""
        scene = self.context.scene()
        for name in [n for n in scene.names() if n.startswith(SEEN)]:
            scene.remove(name)
        for i, (size, pose) in enumerate(result):
            scene.set_box(f"{SEEN}{i}", size.tolist(), pose)
        return self.end(count=len(result))

    def _boxes(self, scene: Scene, points: NDArray[np.float32]) -> list[Box]:
        table, p = self.params["table"], self.params
        keep = np.isfinite(points).all(axis=1)
        target = region_of(scene, p["target"])
        if target is not None:
            keep &= ~target.contains(points, margin=0.025)
        for name in scene.names():
            if name.startswith(HELD):
                keep &= distances_to_box(points, *scene.box(name)) > 0.02
        groups = clusters_above(
            points[keep], table + p["min_height"], table + p["max_height"], p["cell"], p["min_points"]
        )
        return [upright_box(group, table) for group in groups]
