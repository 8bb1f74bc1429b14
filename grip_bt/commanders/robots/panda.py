"""The Franka Panda arm without its gripper (Apache-2.0 model; collision shapes are capsules)."""

from __future__ import annotations

from .assembly import Mount
from .description import Drive, RobotDescription
from .parts import ArmPart, assemble

PANDA = ArmPart(
    name="panda",
    urdf="panda_description/urdf/panda.urdf",
    base_link="panda_link0",
    flange="panda_link8",
    joints=tuple(f"panda_joint{k}" for k in range(1, 8)),
    drive=Drive(stiffness=4000.0, damping=400.0, limit=174.0),
    # Half of what the vendor allows: https://frankaemika.github.io/docs/control_parameters.html
    accelerations=(7.5, 3.75, 5.0, 6.25, 7.5, 10.0, 10.0),
    srdf="panda_description/srdf/panda.srdf",
)

# High beside the table, fingers level, so that an upright object in the hand stays upright. From above, neither the arm
# nor what it holds hides the part of the table where objects stand.
HOME = (-0.28, -0.44, -0.76, -2.25, 1.31, 1.73, -0.34)


def panda_allegro() -> RobotDescription:
    """Return the Panda with a right Allegro hand."""
    from .allegro import ALLEGRO

    # 9.5 cm of the palm's box lie behind its frame; the adapter adds 5 cm, or the thumb would hit link 7.
    mount = Mount(PANDA.flange, ALLEGRO.root, xyz=(0.0, 0.0, 0.15))
    return assemble(PANDA, ALLEGRO, mount, {"home": HOME})
