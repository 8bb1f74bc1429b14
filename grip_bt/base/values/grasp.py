"""Grasps: where the hand goes, how the fingers are, and where the proposal came from."""

from __future__ import annotations

from dataclasses import dataclass, field

from ._frozen import ComparesArrays
from .joints import JointState
from .pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class Grasp(ComparesArrays):
    """One way to take an object. All poses are of the hand's grasp frame (see `RobotModel.grasp_frame`), in one frame.

    Attributes:
        pose: where the hand closes.
        pre_grasp: where the straight approach begins.
        post_grasp: where the straight lift ends.
        pre_posture: hand joints during the approach; None means the hand's `open` posture.
        posture: hand joints to close towards; None means the hand's `closed` posture.
        torque_limit: largest joint torque while closing [N m].
        width: size of the object between the fingers [m]; 0 where unknown.
        quality: larger is better; comparable only within one proposer.
        provenance: who proposed it.
    """

    pose: Pose
    pre_grasp: Pose
    post_grasp: Pose
    pre_posture: JointState | None = None
    posture: JointState | None = None
    torque_limit: float = 0.7
    width: float = 0.0
    quality: float = 0.0
    provenance: str = ""

    def __post_init__(self) -> None:
        frames = {self.pose.frame, self.pre_grasp.frame, self.post_grasp.frame}
        if len(frames) > 1:
            raise ValueError(f"the poses of a grasp are given in one frame, not in {sorted(frames)}")


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a node failed.

    Attributes:
        code: short, stable word for branching and for tables, such as `no_ik`.
        message: a sentence for people.
        data: what may help to mend it.
    """

    code: str
    message: str = ""
    data: dict[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.code}: {self.message}" if self.message else self.code
