"""Register clouds that are nearly where they belong. GICP of the library small_gicp does it two by two.

Each cloud is registered to those before it together, and then once more to all the others, beginning where it is: what
the kinematics say is the prior. In the end everything is moved as one so that the clouds are, on the whole, where the
kinematics had them: their errors differ from view to view, and what all views say is better than what any of them does.
Where the height of the table is known, what all of them see of it is put there.
"""

from __future__ import annotations

import numpy as np
import small_gicp

ROUNDS = 1  # in which each cloud is registered to all others; before, each is to those before it
FARTHEST = 0.05  # a cloud that would be moved by more has found something else [m]
COARSE = 1.5  # cells of the clouds that are fitted are larger than those of the merged one by this
THICK = 0.02  # what is so near to where the table should be may be the table [m]
FEW = 100  # fewer points are no table
FEWEST = 0.3  # share of a cloud's points that have to have a neighbour in another cloud


def register(clouds, cell, reach, table=np.nan):
    """Return what moves each cloud, shape (k, 4, 4), and the mean distance of neighbouring points [m].

    Args:
        clouds: arrays of shape (n, 3) [m].
        cell: edge of the cells that they are thinned out by [m].
        reach: points farther apart than this don't belong together [m].
        table: height of the level table that they show [m]; NaN where it isn't known.
    """
    cell *= COARSE
    whole = [small_gicp.preprocess_points(cloud, downsampling_resolution=cell)[0] for cloud in clouds]
    moved = [np.eye(4) for _ in clouds]
    for round_ in range(1 + ROUNDS):
        for k in range(1, len(clouds)):
            others = range(len(clouds)) if round_ else range(k)
            beside = [applied(moved[i], points_of(whole[i])) for i in others if i != k]
            moved[k] = fitted(whole[k], np.concatenate(beside), moved[k], cell, reach / (1 + round_))
    back = settled([points_of(each) for each in whole], moved)
    if np.isfinite(table):
        back = (
            levelled(
                np.concatenate([applied(back @ m, points_of(w)) for m, w in zip(moved, whole, strict=True)]), table
            )
            @ back
        )
    moved = [back @ each for each in moved]
    return np.array(moved), residual([applied(m, points_of(each)) for m, each in zip(moved, whole, strict=True)], reach)


def fitted(cloud, others, prior, cell, reach):
    """Return what moves a cloud of small_gicp onto others, shape (n, 3), or its prior where it doesn't fit them."""
    target, tree = small_gicp.preprocess_points(others, downsampling_resolution=cell)
    settings = {"registration_type": "GICP", "max_iterations": 30, "max_correspondence_distance": reach}
    exact = {"translation_epsilon": 1e-5, "rotation_epsilon": 1e-5}
    found = small_gicp.align(target, cloud, tree, prior, **settings, **exact)
    middle = points_of(cloud).mean(axis=0, keepdims=True)
    far = np.linalg.norm(applied(found.T_target_source, middle) - middle)
    return found.T_target_source if far < FARTHEST and found.num_inliers > FEWEST * cloud.size() else prior


def settled(clouds, moved):
    """Return the motion that brings moved clouds, as one, nearest to where they were (Kabsch), shape (4, 4)."""
    were = np.concatenate(clouds)
    are = np.concatenate([applied(m, cloud) for m, cloud in zip(moved, clouds, strict=True)])
    a, b = are.mean(axis=0), were.mean(axis=0)
    u, _, vt = np.linalg.svd((are - a).T @ (were - b))
    turn = vt.T @ np.diag([1, 1, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    back = np.eye(4)
    back[:3, :3], back[:3, 3] = turn, b - turn @ a
    return back


def levelled(points, table):
    """Return the motion that brings the plane of points near a table to its height [m], shape (4, 4)."""
    slope, near = np.array([0.0, 0.0, table]), THICK
    for _ in range(5):  # what stands on the table leaves the fit, the nearer it comes
        on = points[np.abs(points[:, :2] @ slope[:2] + slope[2] - points[:, 2]) < near]
        if len(on) < FEW:
            return np.eye(4)
        slope = np.linalg.lstsq(np.column_stack([on[:, :2], np.ones(len(on))]), on[:, 2], rcond=None)[0]
        near = max(near / 2, THICK / 6)
    normal = np.array([-slope[0], -slope[1], 1.0]) / np.linalg.norm([slope[0], slope[1], 1.0])
    side = np.cross([0.0, 1.0, 0.0], normal) / np.linalg.norm(np.cross([0.0, 1.0, 0.0], normal))
    found = np.eye(4)
    found[:3, :3] = np.array([side, np.cross(normal, side), normal])
    middle = np.append(points[:, :2].mean(axis=0), 1.0)
    found[:3, 3] = [*middle[:2], table] - found[:3, :3] @ [*middle[:2], middle @ slope]
    return found


def residual(clouds, reach):
    """Return the mean distance from points to the nearest of the other clouds, where one is within reach [m]."""
    found = []
    for k, cloud in enumerate(clouds):
        others = [each for i, each in enumerate(clouds) if i != k]
        if others:
            squares = np.array(small_gicp.KdTree(np.concatenate(others)).batch_nearest_neighbor_search(cloud)[1])
            found.append(np.sqrt(squares[squares < reach**2]))
    return float(np.concatenate(found).mean()) if found else 0.0


def points_of(cloud):
    """Return the points of a cloud of small_gicp, shape (n, 3)."""
    return np.asarray(cloud.points())[:, :3]


def applied(matrix, points):
    """Return moved points, shape (n, 3)."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def merged(clouds, cell):
    """Return one cloud, a point for each cell, shape (n, 3)."""
    return points_of(small_gicp.voxelgrid_sampling(np.concatenate(clouds), cell))
