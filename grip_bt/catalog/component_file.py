"""The file `component.yaml`: what somebody's external software is called, speaks, answers and is started with.

The user writes it beside the software; `grip component add` makes a node package from it. Format: docs/components.md.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, field_validator, model_validator

from grip_bt.graph.frozen import FrozenDict
from grip_bt.graph.model import Meaning
from grip_bt.graph.settings_file import read_model

FILE_NAME = "component.yaml"

Identifier = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
Label = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
InterfaceName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*/srv/[A-Z][A-Za-z0-9]*$")]
ServerName = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]
FieldName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PortType(_Part):
    """A field of the interface as a port of the node."""

    type: str = Field(min_length=1)
    """Name of a value (`PointCloud`, `list[Grasp]`), a builtin, or a ROS type, which leaves the message as it is."""
    doc: str = ""


class Start(_Part):
    """How to start the software. Without this part it is expected to be running already."""

    command: tuple[str, ...] = Field(min_length=1)
    """Program and arguments, run in the component's folder; `{python}` is the Python that runs GRIP."""
    env: FrozenDict[str, str] = FrozenDict()
    """More environment variables."""


class Timeouts(_Part):
    """How long to wait [s]."""

    call: float = Field(default=30.0, gt=0)
    """For the answer of one call."""
    ready: float = Field(default=15.0, gt=0)
    """For the server to appear, after its start or before a call."""


class ComponentFile(_Part):
    """One external component."""

    name: Identifier
    doc: str = ""
    interface: InterfaceName
    """Type of the service or action, such as `antipodal_interfaces/srv/ProposeGrasps`."""
    server: ServerName
    """Name under which it is served, such as `/propose_grasps`."""
    outcomes: tuple[Label, ...] = Field(min_length=1)
    """Names of the outcome numbers 0, 1, 2 ...; or how many there are, which then are named `outcome_0` and so on."""
    meaning: FrozenDict[Label, Meaning] = FrozenDict()
    """What an outcome means; `success` where nothing is said."""
    ports: FrozenDict[FieldName, PortType] = FrozenDict()
    """Types of the fields as values; a field that isn't named here keeps its message type."""
    start: Start | None = None
    timeouts: Timeouts = Timeouts()

    @field_validator("outcomes", mode="before")
    @classmethod
    def _number_of_outcomes(cls, value: Any) -> Any:
        if isinstance(value, int) and not isinstance(value, bool):
            return tuple(f"outcome_{i}" for i in range(value))
        return value

    @field_validator("ports", mode="before")
    @classmethod
    def _short_ports(cls, value: Any) -> Any:
        if isinstance(value, dict):
            return {k: {"type": v} if isinstance(v, str) else v for k, v in value.items()}
        return value

    @model_validator(mode="after")
    def _outcomes_are_consistent(self) -> ComponentFile:
        if twice := sorted({label for label in self.outcomes if self.outcomes.count(label) > 1}):
            raise ValueError(f"outcomes are named twice: {', '.join(twice)}")
        if unknown := sorted(set(self.meaning) - set(self.outcomes)):
            there_are = ", ".join(self.outcomes)
            raise ValueError(f"meaning of undeclared outcomes: {', '.join(unknown)} (there are: {there_are})")
        return self

    def meanings(self) -> dict[str, Meaning]:
        """Return every outcome and what it means, by number."""
        return {label: self.meaning.get(label, "success") for label in self.outcomes}

    def port_type(self, field: str, otherwise: str) -> str:
        """Return the declared type of a field's port, or `otherwise`."""
        return self.ports[field].type if field in self.ports else otherwise


def load_component(path: str | Path) -> ComponentFile:
    """Read a component file, or the one in a component's folder.

    Raises:
        DocumentError: it isn't there, isn't YAML, or says something that the format doesn't allow; with the place.
    """
    file = Path(path)
    return read_model(file / FILE_NAME if file.is_dir() else file, ComponentFile)
