"""The parts of a component file and of a project's processes: ports, how software is started, how long to wait."""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import RosName, Settings, exactly_one

UNITS: dict[str, float] = {
    **{"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    **{"rad": 1.0, "deg": math.pi / 180},
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    **{"kg": 1.0, "g": 1e-3, "N": 1.0, "Nm": 1.0, "percent": 0.01},
}
"""Units that a component may use, in those of GRIP (m, rad, s, kg, N, N m, fractions)."""
Unit = Literal["m", "cm", "mm", "in", "rad", "deg", "s", "ms", "us", "ns", "kg", "g", "N", "Nm", "percent"]
_FieldPath = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$")]


class PortType(Settings):
    """A field of the interface as a port of the node, and how it is converted on the way."""

    type: str = Field(min_length=1)
    """Name of a value (`PointCloud`, `list[Grasp]`), a builtin, or a ROS type, which leaves the message as it is."""
    doc: str = ""
    field: _FieldPath | None = None
    """Where it is in the message, such as `target.pose`; the field of the port's own name by default."""
    unit: Unit | None = None
    """Unit that the component uses; a port's own is always m, rad, s, kg, N or a fraction."""
    quaternion: Literal["xyzw", "wxyz"] | None = None
    """Order in which the component writes a rotation into an array of numbers; `xyzw` by default."""
    frame: str | None = None
    """Frame that the component works in: what goes in is transformed into it, what comes out without a frame has it."""

    @property
    def adapts(self) -> bool:
        """Whether the value is changed between port and field."""
        return self.unit is not None or self.quaternion is not None or self.frame is not None


class Start(Settings):
    """How to start the software: a command, an executable of a ROS package, or a launch file.

    Without this part, or with `run: false`, it is expected to be running already.
    """

    command: tuple[str, ...] = ()
    """Program and arguments, run in the component's folder; `{python}` is the Python that runs GRIP."""
    package: str | None = None
    """A ROS package, with `executable` or `launch`."""
    executable: str | None = None
    """Name of a program of the package."""
    args: tuple[str, ...] = ()
    """Arguments of the executable."""
    launch: str | None = None
    """A launch file: in the component's folder, or in the package's `launch/`."""
    arguments: FrozenDict[str, str | bool | int | float] = FrozenDict()
    """Arguments of the launch file, by name."""
    env: FrozenDict[str, str] = FrozenDict()
    """More environment variables."""
    run: bool = True
    """Whether we start it at all; `false` keeps what is written here for later."""

    @field_validator("command", mode="before")
    @classmethod
    def _is_a_list_of_words(cls, value: object) -> object:
        if isinstance(value, str):
            words = ", ".join(f'"{word}"' if "{" in word else word for word in value.split())
            raise ValueError(f"expected a list: write [{words}], not {value!r}")
        if isinstance(value, list) and {"python": None} in value:
            raise ValueError('{python} stands in quotation marks: write "{python}"')
        return value

    @model_validator(mode="after")
    def _one_way(self) -> Start:
        shown = "`command`, `package` with `executable`, `launch`"
        exactly_one(self, ("command", "executable", "launch"), shown)
        for word in self.command:
            if re.fullmatch(r"\{[A-Za-z_]+\}", word) and word != "{python}":
                raise ValueError(f"command: {word} isn't known; `{{python}}` is the Python that runs GRIP")
        if (self.executable is not None or (self.package is not None and self.launch is None)) and not (
            self.package and self.executable
        ):
            raise ValueError("`package` and `executable` go together")
        if self.args and not self.executable:
            raise ValueError("`args` are those of an `executable`; a command has its own, a launch file `arguments`")
        if self.arguments and not self.launch:
            raise ValueError("`arguments` are those of a `launch` file")
        return self


class Timeouts(Settings):
    """How long to wait [s]."""

    call: float = Field(default=30.0, gt=0)
    """For the answer of one call, or the result of one goal."""
    ready: float = Field(default=15.0, gt=0)
    """For the server to appear, after its start or before a call."""
    cancel: float = Field(default=3.0, gt=0)
    """For an action to end after it was asked to stop."""


Restart = Literal["never", "on_failure", "always"]


class Ready(Settings):
    """The sign that a process does its work; exactly one of them."""

    service: RosName | None = None
    """A service or an action that it serves."""
    topic: RosName | None = None
    """A topic that it publishes."""
    log: str | None = None
    """A regular expression that a line of its output matches."""
    within: float = Field(default=20.0, gt=0)
    """How long it may take [s]."""

    @field_validator("log")
    @classmethod
    def _is_an_expression(cls, value: str | None) -> str | None:
        if value is not None:
            try:
                re.compile(value)
            except re.error as error:
                raise ValueError(f"{value!r} isn't a regular expression: {error}") from None
        return value

    @model_validator(mode="after")
    def _one_sign(self) -> Ready:
        exactly_one(self, ("service", "topic", "log"))
        return self

    def __str__(self) -> str:
        if self.log is not None:
            return f"a line like {self.log!r}"
        return f"the service {self.service}" if self.service else f"the topic {self.topic}"


class ProcessConfig(Start):
    """One process of a project."""

    doc: str = ""
    folder: str | None = None
    """Working directory, below the project; the project's folder by default."""
    ready: Ready | None = None
    """Without it, it is ready as soon as it runs."""
    restart: Restart = "never"
    """When it is started again after it has ended by itself."""
    restarts: int = Field(default=3, ge=0)
    """How often, before it is given up."""
    restart_delay: float = Field(default=1.0, ge=0)
    """How long to wait before [s]."""
    required: bool = True
    """Whether all others are ended when it is given up."""
