"""A project folder: `grip.yaml` and what lies beside it. Reading it loads no robot, no simulator and no ROS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, ByteSize, ConfigDict, Field, StringConstraints

from grip_bt.base.errors import DocumentError, NotWritableError
from grip_bt.base.yaml.settings_file import read_model
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.task.catalog import Catalog, CodePath, OwnCode, TaskFolder, find_manifests, find_python_nodes
from grip_bt.task.catalog.controller_config import RosRobotConfig
from grip_bt.task.catalog.process_config import ProcessConfig
from grip_bt.task.catalog.sensor_config import SensorConfig
from grip_bt.task.catalog.sensors import sensor_manifest

if TYPE_CHECKING:
    from grip_bt.commanders.robots import RobotDescription
    from grip_bt.commanders.scene import SceneObject
    from grip_bt.task.catalog.equipment import Equipment

FILE_NAME = "grip.yaml"
MESSAGES, ARCHIVE = "messages", "messages.values.sqlite"
"""Folder of named messages; what runs have kept of them, in the folder of the project's state."""
Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]


class _Config(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class ArmConfig(_Config):
    """How one arm is asked to move."""

    group: str = "arm"
    """Group of joints in the robot's description."""
    hand: str | None = None
    """Name of the hand that it carries."""
    arms: tuple[str, ...] = ()
    """Arms that this one joins: one plan moves them all. `group` holds the joints of all of them."""
    planner: str = "RRTConnect"
    kinematics: str = "damped_least_squares"
    speed: float = Field(default=0.5, gt=0, le=1)
    """Fraction of the joints' speed limits."""
    acceleration: float | None = Field(default=None, gt=0, le=1)
    """Fraction of the joints' acceleration limits; as `speed` when it isn't given."""
    jerk: float | None = Field(default=None, gt=0, le=1)
    """Fraction of the joints' jerk limits (`max_jerk` in `joint_limits.yaml`); any jerk when it isn't given."""
    planning_time: float = Field(default=2.0, gt=0)
    """CPU time for one request, all attempts together [s]; wall time ends it at 20 times as much."""
    attempts: int = Field(default=3, ge=1)
    """How often a plan is searched with other random numbers before it is given up."""
    timing: Literal["direct", "toppra"] = "direct"
    """Who finds the fastest velocities along a path: TOPP-RA solved directly, or the library `toppra`."""


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


@dataclass(frozen=True)
class Project:
    """A project folder and its file."""

    folder: Path
    file: ProjectFile

    @property
    def state_folder(self) -> Path:
        """Where runs, logs and built interfaces are kept; made when it isn't there.

        Raises:
            NotWritableError: it can't be made.
        """
        folder = self.folder / ".grip"
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            advice = "runs and logs are kept there; copy the project to a folder of yours, or give --journal FILE"
            raise NotWritableError(folder, error, advice) from error
        return folder

    @property
    def journal(self) -> Path:
        """The project's journal file."""
        return self.state_folder / "runs.sqlite"

    def component_folders(self) -> dict[str, Path]:
        """Return the folders of the external components by name."""
        return {p.parent.name: p.parent for p in self._files(self.file.components, "*/component.yaml")}

    def catalog(self) -> Catalog:
        """Return the built-in nodes, the project's sensors, components' nodes, own nodes and task files."""
        manifests = [sensor_manifest(name, sensor) for name, sensor in self.file.sensors.items()]
        for folder in (self.file.components, self.file.nodes):
            if folder is not None and (self.folder / folder).is_dir():
                manifests += find_manifests(self.folder / folder)
        if self.file.nodes is not None:
            manifests += find_python_nodes(self.folder / self.file.nodes)
        whole = Catalog.builtin().with_manifests(manifests).with_tasks(TaskFolder(self.folder))
        whole = whole.with_code(OwnCode(self.file.code, self.folder))
        return whole.with_named(self.message_names).with_equipment(self.equipment)

    def equipment(self) -> Equipment:
        """Return what its arms, hands and nodes have, by name, as far as its files tell."""
        from .equipment import equipment_of

        return equipment_of(self)

    def message_names(self) -> Mapping[str, set[str]] | None:
        """Return store -> names of the messages that a run begins with; None where a server or nobody knows."""
        from grip_bt.base.message_store import MessageLibrary, names

        if self.file.message_server:
            return None
        folder = self.folder / MESSAGES
        try:
            stores = MessageLibrary(folder if folder.is_dir() else None).stores()
        except DocumentError:
            return None  # a run says what is wrong with the file
        found = {name: set(store.names()) for name, store in stores.items()}
        for store, kept in names(self.folder / ".grip" / ARCHIVE).items():
            found.setdefault(store, set()).update(kept)
        return found

    @property
    def robot_source(self) -> str:
        """One word for the robot, for whoever loads it in another process: its name, or the file that describes it."""
        robot = self.file.robot
        return str(self.folder / FILE_NAME) if isinstance(robot, RobotConfig) else str(robot)

    def description(self) -> RobotDescription:
        """Return the project's robot.

        Raises:
            InvalidRobotError: its files are wrong.
            UnknownNameError: there is no such robot, or the project names none.
            MissingPartError: the data of a ready-made robot isn't installed.
        """
        from grip_bt.commanders.description.load import load_robot

        return load_robot("None" if self.file.robot is None else self.file.robot, self.folder)

    def room(self) -> tuple[SceneObject, ...]:
        """Return what the project's `.scene` file holds; nothing where there is none.

        Raises:
            DocumentError: the file can't be read.
        """
        from grip_bt.commanders.scene_file import load_scene

        return () if self.file.scene is None else load_scene(self.folder / self.file.scene)

    def _files(self, folder: str | None, pattern: str) -> list[Path]:
        return [] if folder is None else sorted((self.folder / folder).glob(pattern))


def find_project(path: str | Path) -> Project:
    """Return the project that a task file or folder belongs to: the nearest `grip.yaml` upwards.

    Without one, the project is the folder itself with nothing in it, so that a task of built-in nodes can be checked
    and run anywhere.

    Raises:
        DocumentError: `grip.yaml` is wrong.
    """
    start = Path(path).resolve()
    folder = start if start.is_dir() else start.parent
    for candidate in (folder, *folder.parents):
        file = candidate / FILE_NAME
        if file.is_file():
            return Project(candidate, read_model(file, ProjectFile))
    return Project(folder, ProjectFile(grip=1))


def project_catalog(path: str | Path) -> Catalog:
    """Return the nodes that a task file may use."""
    return find_project(path).catalog()
