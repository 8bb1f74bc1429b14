"""How somebody else's process is started, when it is ready, and when it is started again."""

from __future__ import annotations

import re
from typing import Literal

from pydantic import Field, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import RosName, Settings, exactly_one

Restart = Literal["never", "on_failure", "always"]


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
    """Arguments of the launch file, by name; `{python}` in one is the Python that runs GRIP."""
    env: FrozenDict[str, str] = FrozenDict()
    """More environment variables; a search path, such as `PYTHONPATH`, comes before what is there."""
    namespace: RosName | None = None
    """Namespace of its nodes: `--ros-args -r __ns:=NAMESPACE` behind the command or the arguments."""
    run: bool = True
    """Whether GRIP starts it; `false` keeps these keys for later."""
    fresh: bool = False
    """Whether a campaign starts it anew for every trial, because its answers depend on earlier ones."""
    restart: Restart = "never"
    """When it is started again after it has ended by itself."""
    restarts: int = Field(default=3, ge=0)
    """How often, before it is given up."""
    restart_delay: float = Field(default=1.0, ge=0)
    """How long to wait before [s]."""

    def again(self, failed: bool, starts: int) -> bool:
        """Tell whether what ended by itself is started again, after so many starts."""
        return starts <= self.restarts and (self.restart == "always" or (self.restart == "on_failure" and failed))

    @field_validator("command", mode="before")
    @classmethod
    def _quotes_the_python(cls, value: object) -> object:
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
        if self.namespace and self.launch:
            raise ValueError("a `launch` file gets its namespace by one of its own `arguments`")
        return self


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
    required: bool = True
    """Whether all others are ended when it is given up."""
