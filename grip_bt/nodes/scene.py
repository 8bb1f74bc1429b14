"""The leaf that tells the planning scene what a camera sees: groups of points, an upright box around each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Scene
from grip_bt.base.values import PointCloud, Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.values.solids import Box as SolidBox
from grip_bt.nodes.leaf import Leaf, OperationLeaf, Status
from grip_bt.nodes.objects import HELD, SEEN, TABLE_GAP, distances_to_box, region_of

Points = NDArray[np.floating]
KNOWN = 0.01
"""What is seen this close to a box of the room is the box [m]."""


def _clusters(points: Points, cell: float, min_points: int) -> list[Points]:
    """Group the points, z up, by what touches what, seen from above; the largest group first.

    They are entered into a grid; occupied cells that touch, also at a corner, are one group. Groups of fewer than
    `min_points` are noise.
    """
    if not len(points):
        return []
    import cv2  # of the extra `vision`, which an empty table does without

    cells = np.floor(points[:, :2] / cell).astype(np.int64)
    cells -= cells.min(axis=0)
    grid = np.zeros(cells.max(axis=0) + 1, np.uint8)
    grid[cells[:, 0], cells[:, 1]] = 1
    count, labels = cv2.connectedComponents(grid, connectivity=8)
    label = labels[cells[:, 0], cells[:, 1]]
    groups = [points[label == k] for k in range(1, count)]
    return sorted((g for g in groups if len(g) >= min_points), key=len, reverse=True)


def _upright_box(points: Points, floor: float) -> tuple[NDArray[np.float64], Pose]:
    """Return the smallest upright box around points that reaches down to `floor` [m]: edge lengths and pose.

    A camera above sees the top of a thing and little of its sides. Its foot is the rectangle of least area around the
    points seen from above (`cv2.minAreaRect`).
    """
    import cv2  # of the extra `vision`

    (x, y), (width, depth), angle = cv2.minAreaRect(points[:, :2].astype(np.float32))
    top, bottom = float(points[:, 2].max()), floor + TABLE_GAP
    size = np.array([max(width, 0.005), max(depth, 0.005), max(top - bottom, 0.005)])
    return size, Pose([x, y, bottom + size[2] / 2], quaternion_of(0, 0, np.radians(angle)))


Box = tuple[NDArray[np.float64], Pose]


class NothingSeen(Leaf):
    """Tell whether the last look has found nothing on the table, and if not, what is left and where."""

    def update(self) -> Status:
        scene = self.context.scene()
        left = [scene.box(name)[1].position for name in scene.names() if name.startswith(SEEN)]
        if not left:
            return self.end()
        places = ", ".join(f"({x:.2f}, {y:.2f})" for x, y, _ in left)
        things = "1 thing is" if len(left) == 1 else f"{len(left)} things are"
        return self.fail("something_left", f"{things} left, at {places} [m]", count=len(left))


class UpdateFromCloud(OperationLeaf):
    """Replace the scene's `seen_*` by what a cloud shows on the table now.

    What lies within the target, or on its walls, what moves with a hand, and boxes of the room are left out: the scene
    knows these better.
    """

    def start(self) -> Operation[list[Box]]:
        cloud: PointCloud = self.read("cloud")
        if cloud.frame != "world":
            raise SensorError(f"the cloud is given in frame {cloud.frame!r}, not in world")
        if not len(cloud.points):
            raise SensorError("the cloud has no points")
        scene = self.context.scene()
        return self.context.run_in_worker(lambda: self._boxes(scene, cloud.points))

    def finish(self, result: list[Box]) -> Status:
        scene = self.context.scene()
        for name in [n for n in scene.names() if n.startswith(SEEN)]:
            scene.remove(name)
        for i, (size, pose) in enumerate(result):
            scene.set_box(f"{SEEN}{i}", size.tolist(), pose)
        return self.end(count=len(result))

    def _boxes(self, scene: Scene, points: NDArray[np.float32]) -> list[Box]:
        table, p = self.params["table"], self.params
        low, high = table + p["min_height"], table + p["max_height"]
        points = points[(points[:, 2] > low) & (points[:, 2] < high) & np.isfinite(points).all(axis=1)]
        keep = np.ones(len(points), dtype=bool)
        target = region_of(scene, p["target"])
        if target is not None:
            keep &= ~target.contains(points, margin=0.025)
        for name in scene.names():
            if name.startswith(HELD):
                keep &= distances_to_box(points, *scene.box(name)) > 0.02
            elif scene.fixed(name) and isinstance((known := scene.solid(name))[0], SolidBox):
                size, pose = known[0].size, known[1]
                if pose.position[2] + size[2] / 2 > low:
                    keep &= distances_to_box(points, np.array(size), pose) > KNOWN
        return [_upright_box(group, table) for group in _clusters(points[keep], p["cell"], p["min_points"])]
