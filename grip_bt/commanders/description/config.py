"""What `robot:` in a project file, and a robot's own YAML file, may hold."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, StringConstraints, model_validator

Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
Vector = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
SOURCES = ("urdf", "xacro", "moveit", "ready", "arm", "robots")


class _Config(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class _Placed(_Config):
    xyz: Vector = (0.0, 0.0, 0.0)
    """Its origin [m]."""
    rpy: Vector = (0.0, 0.0, 0.0)
    """Its orientation, fixed-axis roll pitch yaw [rad]."""


class FrameConfig(_Placed):
    """A frame on a link."""

    link: str
    """The link that it is fixed to."""


class MountConfig(_Placed):
    """How a hand sits on an arm."""

    link: str
    """The arm's link; what hangs on it in the arm's own description is left out."""
    root: str | None = None
    """The hand's link that is fixed to it; its root link when it isn't given."""
    namespace: str = "hand"
    """Prefix of the hand's links and joints, before an underscore."""


class GroupConfig(_Config):
    """A planning group, as in an SRDF."""

    joints: tuple[str, ...] = ()
    """Its joints, in order."""
    links: tuple[str, ...] = ()
    """Its links."""
    chain: tuple[str, str] | None = None
    """Base link and tip link."""
    groups: tuple[str, ...] = ()
    """Groups that it joins."""


class EndEffectorConfig(_Config):
    """Which hand sits on which arm, as in an SRDF."""

    parent_link: str
    """The arm's link that carries the hand."""
    group: str = ""
    """The hand's group."""
    parent_group: str = ""
    """The arm's group."""


class Drive(_Config):
    """How a joint is driven in simulation: torque = stiffness * error - damping * velocity, clamped."""

    stiffness: float = Field(gt=0, allow_inf_nan=False)
    """Torque or force by which a joint is pulled to its target [N m/rad or N/m]."""
    damping: float = Field(ge=0, allow_inf_nan=False)
    """Torque or force against its speed [N m s/rad or N s/m]."""
    limit: float = Field(gt=0, allow_inf_nan=False)
    """The largest torque or force [N m or N]."""
    armature: float = Field(default=0.0, ge=0, allow_inf_nan=False)
    """Inertia of the motor, added to the joint's [kg m^2 or kg]."""


class PlacedConfig(_Placed):
    """One of several robots, and where its base stands in the world."""

    robot: str | RobotConfig
    """A ready-made robot's name, a path, or a description."""


class RobotConfig(_Config):
    """A robot: from files, or put together of others. Relative paths begin in the folder of the file they are in."""

    name: str | None = None
    """What it is called; otherwise as its description says."""
    urdf: str | None = None
    """Path of a URDF file."""
    xacro: str | None = None
    """Path of a xacro file."""
    arguments: dict[str, str | bool | int | float] = {}
    """Of the xacro file, and of the SRDF where it is a xacro file too."""
    srdf: str | None = None
    """Path of an SRDF file: groups, named states, which links may touch."""
    moveit: str | None = None
    """Folder of a MoveIt configuration package."""
    ready: str | None = None
    """Name of a ready-made robot that this one is made of."""
    packages: dict[str, str] = {}
    """Package name -> folder, for `package://` and `$(find ...)`."""
    namespace: Key | None = None
    """Prefix of every name of the robot, before an underscore."""
    arm: str | RobotConfig | None = None
    """A ready-made robot's name, a path, or a description; together with `hand` and `mount`."""
    hand: str | RobotConfig | None = None
    """Likewise."""
    mount: MountConfig | None = None
    """Where the hand sits on the arm."""
    robots: dict[Key, PlacedConfig] = {}
    """Several robots in one world; the key is each one's namespace."""
    groups: dict[str, GroupConfig] = {}
    """Planning groups beside those of the SRDF."""
    states: dict[str, dict[str, dict[str, FiniteFloat] | list[FiniteFloat]]] = {}
    """Group -> name -> position of each joint [rad or m], by name or in the group's order."""
    end_effectors: dict[str, EndEffectorConfig] = {}
    """Which hand sits on which arm, where no SRDF says it."""
    grasp_frames: dict[str, FrameConfig] = {}
    """Arm's group -> the frame that grasps are given in: z leaves the palm, x runs along the fingers."""
    fingers: dict[str, dict[str, tuple[str, ...]]] = {}
    """Hand's group -> finger -> its links from the knuckle to the tip; the thumb last."""
    drives: dict[str, Drive] = {}
    """Group -> how its joints are driven in simulation."""
    accelerations: dict[str, Annotated[float, Field(gt=0, allow_inf_nan=False)]] = {}
    """Group or joint -> acceleration limit [rad/s^2 or m/s^2]."""

    @model_validator(mode="after")
    def _one_source(self) -> RobotConfig:
        given = [name for name in SOURCES if getattr(self, name)]
        if "moveit" in given and len(given) == 2 and {"urdf", "xacro"} & set(given):
            given.remove("moveit")  # its URDF lies elsewhere
        if len(given) != 1:
            found = " and ".join(given) if given else "nothing"
            raise ValueError(f"a robot is made of exactly one of {', '.join(SOURCES)}; this one has {found}")
        if (self.arm is None) != (self.hand is None) or (self.arm is None) != (self.mount is None):
            raise ValueError("a composed robot needs arm, hand and mount")
        return self
