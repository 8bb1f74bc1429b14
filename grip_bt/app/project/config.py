"""What `grip.yaml` holds."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ByteSize, ConfigDict, StringConstraints

from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.settings import MotionSettings
from grip_bt.task.catalog import CodePath
from grip_bt.task.catalog.component_parts import ProcessConfig
from grip_bt.task.catalog.ros_config import RosRobotConfig
from grip_bt.task.catalog.sensors import SensorConfig

FILE_NAME = "grip.yaml"

MESSAGES, ARCHIVE = "messages", "messages.values.sqlite"
"""Folder of named messages; what runs have kept of them, in the folder of the project's state."""

Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]


class _Config(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class _ArmParts(_Config):
    group: str = "arm"
    """Group of joints in the robot's description."""
    hand: str | None = None
    """Name of the hand that it carries."""
    arms: tuple[str, ...] = ()
    """Arms that this one joins: one plan moves them all. `group` holds the joints of all of them."""


class ArmConfig(MotionSettings, _ArmParts):
    """One arm: its joints, and how it is asked to move."""


class HandConfig(_Config):
    """One hand."""

    group: str = "hand"


class ProjectFile(_Config):
    """What `grip.yaml` holds."""

    grip: Literal[1]
    doc: str = ""
    robot: str | RobotConfig | None = None
    """A ready-made robot's name, a file or folder that describes one, or a description; see docs/robots.md."""
    arms: dict[Key, ArmConfig] = {}
    hands: dict[Key, HandConfig] = {}
    sensors: dict[Key, SensorConfig] = {}
    ros: RosRobotConfig | None = None
    """The controllers of the real robot, for `grip run --robot ros`."""
    processes: dict[Key, ProcessConfig] = {}
    """What `grip launch` runs: drivers, a vendor's launch file, anything."""
    message_server: bool = False
    """Whether named messages are those of a running server (`grip messages serve`), not of the run's own process."""
    components: str | None = "components"
    """Folder of external components, each with a `component.yaml`."""
    nodes: str | None = "nodes"
    """Folder of the project's own nodes: decorated Python, or leaves with a `manifest.yaml`."""
    code: tuple[CodePath, ...] = ()
    """What `foreign` nodes of its tasks may import when they run, besides py_trees' own behaviours: `package.module`
    for the behaviours in it, `package.module:name` for one of them, or for a function that makes one."""
    world: str | None = None
    """The world that is simulated."""
    scene: str | None = None
    """A `.scene` file of what belongs to the room besides the world's own."""
    goals: dict[str, str] = {}
    """Task -> what the referee of a simulated world has to find when it has succeeded, such as `placed == objects`."""
    journal_limit: ByteSize = ByteSize(20 * 10**9)
    """How large the journal may become, such as `500 MB`: beyond that the oldest runs that have ended are removed."""
    simulated_time: bool = False
    """Whether the time of a run is that of the topic `/clock`, from a simulator that isn't ours."""
