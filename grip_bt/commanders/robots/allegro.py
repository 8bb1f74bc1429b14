"""The right Allegro hand v4 (Wonik Robotics; BSD): four fingers of four joints, the thumb last.

In its palm link, +x leaves the palm, +z runs along the fingers, the fingers flex about y. The URDF's
joint friction of 5-10 N m is not the hand's: simulators set it to zero.
"""

from __future__ import annotations

import numpy as np

from grip_bt.base.values import Pose

from .description import Drive, GraspFrame
from .parts import HandPart

_PALM_TO_GRASP = np.array(
    [
        [0, 0, 1, 0.0111],  # grasp z = palm x: out of the palm
        [0, -1, 0, 0],
        [1, 0, 0, -0.028],  # grasp x = palm z: along the fingers
        [0, 0, 0, 1],
    ]
)


def _finger(first: int) -> tuple[str, ...]:
    return (*(f"link_{k}.0" for k in range(first, first + 4)), f"link_{first + 3}.0_tip")


ALLEGRO = HandPart(
    name="allegro",
    urdf="allegro_hand_description/urdf/allegro_right_hand.urdf",
    root="palm_link",
    joints=tuple(f"joint_{k}.0" for k in range(16)),
    drive=Drive(stiffness=6.0, damping=0.3, limit=0.7, armature=0.001),
    accelerations=(40.0,) * 16,
    postures={
        # The thumb stays opposed (1.396): swinging it while an object is near would sweep the object away. The
        # fingers are half bent, 0.1 m in front of the palm's middle: room enough for an object, and the hand is
        # 5 cm shorter among other objects than with straight fingers.
        "open": (0.0, 0.0, 1.1, 0.5) * 3 + (1.396, 0.0, 0.0, 0.0),
        "flat": (0.0, 0.0, 0.0, 0.0) * 3 + (1.396, 0.0, 0.0, 0.0),
        "closed": (0.0, 1.25, 1.2, 0.9) * 3 + (1.396, 0.25, 0.9, 0.9),
    },
    grasp_frame=GraspFrame("palm_link", Pose.from_matrix(_PALM_TO_GRASP, "palm_link")),
    fingers={
        "index": _finger(0),
        "middle": _finger(4),
        "ring": _finger(8),
        "thumb": _finger(12),
    },
)
