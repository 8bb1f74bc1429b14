"""A process of a project as `grip.yaml` declares it: how it is started, when it is ready, what happens when it ends."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, field_validator, model_validator

from .component_parts import Part, Start

RosName = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]
Restart = Literal["never", "on_failure", "always"]


class Ready(Part):
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
        if sum(sign is not None for sign in (self.service, self.topic, self.log)) != 1:
            raise ValueError("say one of `service`, `topic`, `log`")
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
