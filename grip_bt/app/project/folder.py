"""A project folder: `grip.yaml` and what lies beside it. Reading it loads no robot, no simulator and no ROS."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import ByteSize, StringConstraints

from grip_bt.base.errors import GripError, NotWritableError, ProjectExistsError
from grip_bt.base.yaml.models import RosName, Settings, read_model
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.settings import MotionSettings
from grip_bt.task.catalog import CodePath
from grip_bt.task.catalog.component_file import Qos
from grip_bt.task.catalog.ros_config import RosRobotConfig, SensorConfig
from grip_bt.task.catalog.start import ProcessConfig

if TYPE_CHECKING:
    from grip_bt.commanders.description.robot import RobotDescription
    from grip_bt.commanders.scene_state import SceneObject

FILE_NAME = "grip.yaml"

MESSAGES, ARCHIVE = "messages", "messages.values.sqlite"
"""Folder of named messages; what runs have kept of them, in the folder of the project's state."""

Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]


class _ArmParts(Settings):
    group: str = "arm"
    """Group of joints in the robot's description."""
    hand: str | None = None
    """Name of the hand that it carries."""
    arms: tuple[str, ...] = ()
    """Arms that this one joins: one plan moves them all. `group` holds the joints of all of them."""


class ArmConfig(MotionSettings, _ArmParts):
    """One arm: its joints, and how it is asked to move."""


class HandConfig(Settings):
    """One hand."""

    group: str = "hand"
    """Group of joints in the robot's description."""


class ProjectFile(Settings):
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
    """Whether named messages are those of a running server (`grip messages serve`) instead of the run's own."""
    components: str | None = "components"
    """Folder of external components, each with a `component.yaml`."""
    nodes: str | None = "nodes"
    """Folder of the project's own nodes: decorated Python, or leaves with a `manifest.yaml`."""
    code: tuple[CodePath, ...] = ()
    """What `foreign` nodes may import besides py_trees' own behaviours: `package.module` for all behaviours in it,
    `package.module:name` for one, or for a function that makes one."""
    world: str | None = None
    """The world that is simulated."""
    scene: str | None = None
    """A `.scene` file of what else is in the room."""
    goals: dict[str, str] = {}
    """Task -> what the referee must find after a success, such as `placed == objects`."""
    journal_limit: ByteSize = ByteSize(20 * 10**9)
    """Largest size of the journal, such as `500 MB`: beyond it the oldest runs that have ended are removed."""
    qos: dict[RosName, Qos] = {}
    """Topic -> its quality of service, wherever it is named: sensors, cameras, controllers, nodes of `ros/`."""
    simulated_time: bool = False
    """Whether a run's time is that of the topic `/clock`, from another simulator."""


@dataclass(frozen=True)
class Project:
    """A project folder and its file."""

    folder: Path
    file: ProjectFile

    @property
    def state_folder(self) -> Path:
        """Where runs, logs and built interfaces are kept; made, if it can be: NotWritableError else."""
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
        if self.file.components is None:
            return {}
        files = sorted((self.folder / self.file.components).glob("*/component.yaml"))
        return {file.parent.name: file.parent for file in files}

    @property
    def robot_source(self) -> str:
        """One word for the robot, for whoever loads it in another process: its name, or the file that describes it."""
        robot = self.file.robot
        if isinstance(robot, RobotConfig):
            return str(self.folder / FILE_NAME)
        path = self.folder / Path(str(robot)).expanduser()
        return str(path) if robot not in ROBOTS and path.exists() else str(robot)

    def description(self) -> RobotDescription:
        """Return the project's robot; see `load_robot`, also for what is raised."""
        from grip_bt.commanders.description.load import load_robot

        return load_robot("None" if self.file.robot is None else self.file.robot, self.folder)

    def room(self) -> tuple[SceneObject, ...]:
        """Return what the project's `.scene` file holds, if it has one; DocumentError where that can't be read."""
        from grip_bt.commanders.scene_file import load_scene

        return () if self.file.scene is None else load_scene(self.folder / self.file.scene)


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
            return Project(candidate, _with_robot_of_world(read_model(file, ProjectFile), candidate))
    return Project(folder, ProjectFile(grip=1))


def _with_robot_of_world(file: ProjectFile, folder: Path) -> ProjectFile:
    """Return a file that names no robot with the robot of its world; a wrong world is told of elsewhere."""
    if file.robot is not None or file.world is None:
        return file
    from grip_sim.worlds import read_world

    try:
        world, path = read_world(file.world, folder)
    except GripError:
        return file
    return file if world.robot is None else file.model_copy(update={"robot": str(path)})


_TEMPLATE = Path(__file__).with_name("template")
_TAKING = {Path("tasks/take.yaml"), Path("worlds/bench.yaml")}
"""What of the template is for its robot in its world alone."""


def in_world(world: str) -> dict[str, str]:
    """Return the `grip.yaml` of a new project of the template's robot in a built-in world."""
    text = (_TEMPLATE / FILE_NAME).read_text("utf-8").replace("world: bench", f"world: {world}")
    return {FILE_NAME: text.replace("camera: overhead", "camera: front") if world == "empty" else text}


_FOLDERS = ("tasks", "components", "nodes", "messages")


def make_project(folder: str | Path, files: Mapping[str, str] | None = None, *, beside: bool = False) -> list[Path]:
    """Make a project in a folder that isn't there yet or is empty (a `.git` in it is no harm).

    Args:
        files: path in it -> text, beside the usual ones or in place of them.
        beside: whether the folder may hold other things, which stay as they are.

    Returns:
        The files written, relative to the folder.

    Raises:
        ProjectExistsError: The folder holds something, or is a file; nothing was written.
    """
    folder = Path(folder)
    if (
        not beside
        and folder.exists()
        and (not folder.is_dir() or any(entry.name != ".git" for entry in folder.iterdir()))
    ):
        raise ProjectExistsError(folder)
    sources = {file.relative_to(_TEMPLATE): file for file in sorted(_TEMPLATE.rglob("*")) if file.is_file()}
    # A file of this name in the package's own folder would hide files from git and from the package's build.
    named = {path.with_name(".gitignore") if path.name == "gitignore" else path: f for path, f in sources.items()}
    left_out = _TAKING if files and FILE_NAME in files else set()
    texts = {path: source.read_text("utf-8") for path, source in named.items() if path not in left_out}
    texts |= {Path(path): text for path, text in (files or {}).items()}
    texts = {path: text for path, text in texts.items() if not (folder / path).exists()}
    for path, text in texts.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    for name in _FOLDERS:
        (folder / name).mkdir(exist_ok=True)
    return list(texts)


_ROS_TEMPLATE = Path(__file__).with_name("ros_template")


def ros_files(folder: Path) -> dict[str, str]:
    """Return path in the project -> text of the files of a package that is called as the folder is.

    Raises:
        GripError: a ROS package can't be called so.
    """
    name = folder.resolve().name.lower().replace("-", "_")
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        rule = "letters, digits and underscores, a letter first"
        raise GripError(f"{folder}: a ROS package has the name of its folder, and {name!r} isn't a name of one: {rule}")
    return {
        "package.xml": (_ROS_TEMPLATE / "package.xml").read_text(encoding="utf-8").replace("NAME", name),
        "setup.py": (_ROS_TEMPLATE / "setup.py.in").read_text(encoding="utf-8"),
        f"resource/{name}": "",
    }
