"""Rigid poses. Quaternions are w, x, y, z everywhere in GRIP; other orders exist only in `grip_bt.ros.convert`."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan2, cos, hypot, isfinite, sin, sqrt
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from grip_bt.base.arrays import Array, ComparesArrays, frozen_array

Number = TypeVar("Number", float, Array)


def rotation_rows(w: Number, x: Number, y: Number, z: Number) -> list[list[Number]]:
    """Return the rows of the rotation matrix of a unit quaternion, or of many at once."""
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


@dataclass(frozen=True, slots=True, eq=False)
class Pose(ComparesArrays):
    """A pose in `frame`: what maps points given in the posed body to `frame`.

    Attributes:
        position: shape (3,) [m].
        quaternion: shape (4,), w x y z, normalised on construction.
        frame: name of the reference frame.
    """

    position: Array = field(default_factory=lambda: np.zeros(3))
    quaternion: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    frame: str = "world"

    if TYPE_CHECKING:  # what the constructor takes is wider than what it keeps

        def __init__(self, position: ArrayLike = ..., quaternion: ArrayLike = ..., frame: str = "world") -> None: ...

    def __post_init__(self) -> None:
        position = frozen_array(self.position, (3,), "position")
        q = frozen_array(self.quaternion, (4,), "quaternion")
        norm = sqrt(q.dot(q))
        if not isfinite(norm) or norm < 1e-9 or not all(map(isfinite, position.tolist())):
            raise ValueError(f"a pose needs finite numbers and a non-zero quaternion, not {position}, {q}")
        q = q / norm
        q.setflags(write=False)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "quaternion", q)

    @classmethod
    def from_matrix(cls, matrix: ArrayLike, frame: str = "world") -> Pose:
        """Make a pose from a homogeneous matrix of shape (4, 4) (Shepperd's method)."""
        m = np.asarray(matrix, dtype=float)
        (r00, r01, r02, _), (r10, r11, r12, _), (r20, r21, r22, _) = m[
            :3
        ].tolist()  # its floats are quicker than numpy's
        k = [1 + r00 + r11 + r22, 1 + r00 - r11 - r22, 1 - r00 + r11 - r22, 1 - r00 - r11 + r22]
        if not all(map(isfinite, k)):
            raise ValueError(f"a pose needs finite numbers, not {m.tolist()}")
        i = max(range(4), key=k.__getitem__)
        s = 2 * sqrt(k[i])
        wx, wy, wz = r21 - r12, r02 - r20, r10 - r01
        xy, xz, yz = r01 + r10, r02 + r20, r12 + r21
        rows = (
            [s * s / 4, wx, wy, wz],
            [wx, s * s / 4, xy, xz],
            [wy, xy, s * s / 4, yz],
            [wz, xz, yz, s * s / 4],
        )
        return cls(m[:3, 3], np.array(rows[i]) / s, frame)

    def rotation(self) -> Array:
        """Return the rotation matrix, shape (3, 3)."""
        return np.array(rotation_rows(*self.quaternion.tolist()))

    def rotation_vector(self) -> Array:
        """Return the axis of the rotation, as long as its angle, at most pi [rad]; shape (3,)."""
        w, axis = self.quaternion[0], self.quaternion[1:]
        sine = float(np.linalg.norm(axis))
        if sine < 1e-12:
            return np.zeros(3)
        angle = 2 * np.arctan2(sine, abs(w))
        return axis * (angle / sine if w >= 0 else -angle / sine)

    def matrix(self) -> Array:
        """Return the homogeneous matrix, shape (4, 4)."""
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = self.rotation(), self.position
        return m

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: `a @ b` is b, given in a's body, expressed in a's frame."""
        return Pose.from_matrix(self.matrix() @ other.matrix(), self.frame)

    def inverse(self, frame: str = "") -> Pose:
        """Return the inverse; `frame` names the frame that the result is given in."""
        r = self.rotation().T
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = r, -r @ self.position
        return Pose.from_matrix(m, frame)

    def apply(self, points: ArrayLike) -> Array:
        """Map points of shape (n, 3) [m] from the posed body to `frame`."""
        return np.asarray(points, dtype=float) @ self.rotation().T + self.position

    def moved(self, offset: ArrayLike) -> Pose:
        """Return the pose shifted by `offset`, shape (3,) [m], given in `frame`."""
        return Pose(self.position + np.asarray(offset, dtype=float), self.quaternion, self.frame)

    def __repr__(self) -> str:
        p, q = ([round(x, 4) + 0.0 for x in a.tolist()] for a in (self.position, self.quaternion))
        return f"Pose({p}, wxyz={q}, frame={self.frame!r})"


def quaternion_of(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return w, x, y, z of turns about the fixed x, then y, then z axis [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((cos(angle / 2), sin(angle / 2)) for angle in (roll, pitch, yaw))
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def quaternion_about(vector: ArrayLike) -> Array:
    """Return w, x, y, z of a turn about an axis by its length [rad], the inverse of `Pose.rotation_vector`."""
    turn = np.asarray(vector, dtype=float)
    angle = float(np.linalg.norm(turn))
    return np.array([cos(angle / 2), *(turn / max(angle, 1e-12) * sin(angle / 2))])


def angles_of(r: Array) -> tuple[float, float, float]:
    """Return a matrix's roll, pitch and yaw [rad], as `quaternion_of` takes them; at pitch +-90 degrees, roll is 0."""
    pitch = atan2(-r[2, 0], hypot(r[0, 0], r[1, 0]))
    if hypot(r[0, 0], r[1, 0]) < 1e-9:
        return 0.0, pitch, atan2(-r[0, 1], r[1, 1])
    return atan2(r[2, 1], r[2, 2]), pitch, atan2(r[1, 0], r[0, 0])


def check_frame(pose: Pose, frame: str) -> None:
    """Raise ValueError unless `pose` is given in `frame`."""
    if pose.frame != frame:
        raise ValueError(f"the pose is given in frame {pose.frame!r}, not {frame!r}")
