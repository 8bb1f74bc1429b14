"""`tf.transformations`: rotations about fixed or own axes, as matrices of 4 by 4 and quaternions x, y, z, w.

Axes are named as there: `sxyz` about the fixed axes x, y and z, in this order; `rxyz` about those that turn along.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

_Array = Any


def _axes(axes: str) -> str:
    return axes[1:].lower() if axes[0] == "s" else axes[1:].upper()


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = "sxyz") -> _Array:
    """Return the quaternion of three angles [rad]."""
    return Rotation.from_euler(_axes(axes), [ai, aj, ak]).as_quat()


def euler_from_quaternion(quaternion: _Array, axes: str = "sxyz") -> tuple[float, ...]:
    """Return three angles [rad]."""
    return tuple(float(angle) for angle in Rotation.from_quat(np.asarray(quaternion, float)).as_euler(_axes(axes)))


def quaternion_matrix(quaternion: _Array) -> _Array:
    return _matrix(rotation=Rotation.from_quat(quaternion).as_matrix())


def quaternion_from_matrix(matrix: _Array) -> _Array:
    return Rotation.from_matrix(np.asarray(matrix, float)[:3, :3]).as_quat()


def euler_matrix(ai: float, aj: float, ak: float, axes: str = "sxyz") -> _Array:
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: _Array, axes: str = "sxyz") -> tuple[float, ...]:
    return euler_from_quaternion(quaternion_from_matrix(matrix), axes)


def quaternion_multiply(quaternion1: _Array, quaternion0: _Array) -> _Array:
    """Return the rotation that is first the second one, then the first."""
    (x1, y1, z1, w1), (x0, y0, z0, w0) = quaternion1, quaternion0
    vector = np.cross((x1, y1, z1), (x0, y0, z0)) + w1 * np.array((x0, y0, z0)) + w0 * np.array((x1, y1, z1))
    return np.array((*vector, w1 * w0 - x1 * x0 - y1 * y0 - z1 * z0))


def quaternion_conjugate(quaternion: _Array) -> _Array:
    return np.array(quaternion, float) * (-1, -1, -1, 1)


def quaternion_inverse(quaternion: _Array) -> _Array:
    return quaternion_conjugate(quaternion) / np.dot(quaternion, quaternion)


def quaternion_about_axis(angle: float, axis: _Array) -> _Array:
    """Return the quaternion of an angle [rad] about an axis of any length."""
    axis = np.asarray(axis, float)
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_quat()


def rotation_matrix(angle: float, direction: _Array) -> _Array:
    """Return the matrix of an angle [rad] about an axis through the origin."""
    return quaternion_matrix(quaternion_about_axis(angle, direction))


def translation_matrix(direction: _Array) -> _Array:
    return _matrix(translation=direction)


def translation_from_matrix(matrix: _Array) -> _Array:
    return np.array(matrix, float)[:3, 3]


def concatenate_matrices(*matrices: _Array) -> _Array:
    return np.linalg.multi_dot([np.eye(4), np.eye(4), *matrices])


def inverse_matrix(matrix: _Array) -> _Array:
    return np.linalg.inv(matrix)


def identity_matrix() -> _Array:
    return np.eye(4)


def _matrix(rotation: _Array = None, translation: _Array = (0, 0, 0)) -> _Array:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = np.eye(3) if rotation is None else rotation, translation
    return made
