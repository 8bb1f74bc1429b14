"""The UR5 and UR10 arms of Universal Robots (BSD models)."""

from __future__ import annotations

from .assembly import Mount
from .description import Drive, RobotDescription
from .parts import ArmPart, assemble

_JOINTS = tuple(f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"))


def _arm(name: str) -> ArmPart:
    return ArmPart(
        name=name,
        urdf=f"ur_description/urdf/{name}_joint_limited_robot.urdf",  # +-pi: no winding up
        base_link="base_link",
        flange="tool0",
        joints=_JOINTS,
        drive=Drive(stiffness=4000.0, damping=400.0, limit=300.0),
        accelerations=(4.0,) * 6,
        srdf="ur_description/srdf/ur5.srdf",  # the UR10's links have the same names and the same shape
    )


def ur5_allegro() -> RobotDescription:
    """Return the UR5 with a right Allegro hand."""
    return _with_allegro("ur5", (-1.40, -1.40, 1.43, -0.03, -0.10, 0.0))


def ur10_allegro() -> RobotDescription:
    """Return the UR10 with a right Allegro hand."""
    return _with_allegro("ur10", (-1.29, -1.20, 1.28, -0.08, -0.56, 0.0))


def _with_allegro(name: str, home: tuple[float, ...]) -> RobotDescription:
    from .allegro import ALLEGRO

    arm = _arm(name)
    return assemble(arm, ALLEGRO, Mount(arm.flange, ALLEGRO.root, (0.0, 0.0, 0.15)), {"home": home})
