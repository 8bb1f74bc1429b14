"""The file `component.yaml`: what somebody's external software is called, speaks, answers and is started with.

The user writes it beside the software; `grip component add` makes a node package from it. Format: docs/components.md.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, cast

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.base.errors import ExpressionError
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import Identifier, RosName, Settings, read_model
from grip_bt.task.catalog.port_type import PortType
from grip_bt.task.catalog.start import Start
from grip_bt.task.model import Meaning

Kind = Literal["msg", "srv", "action"]
FILE_NAME = "component.yaml"
FEEDBACK = "feedback"
"""The output that holds the last feedback of an action."""

Label = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
_InterfaceName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*/(srv|action|msg)/[A-Z][A-Za-z0-9]*$")]


class Qos(Settings):
    """Quality of service of a topic, where it isn't to be what its publishers offer, or ROS's default."""

    reliability: Literal["reliable", "best_effort"] | None = None
    """Whether messages that were lost are sent again."""
    durability: Literal["volatile", "transient_local"] | None = None
    """`transient_local`: later subscribers get the last messages too."""
    depth: int = Field(default=10, ge=1)
    """Messages kept for slow subscribers."""


class Timeouts(Settings):
    """How long to wait."""

    call: float = Field(default=30.0, gt=0)
    """For the answer of one call, or the result of one goal [s]."""
    ready: float = Field(default=15.0, gt=0)
    """For the server to appear, after its start or before a call [s]."""
    cancel: float = Field(default=3.0, gt=0)
    """For an action to end after it was asked to stop [s]."""


class ComponentFile(Settings):
    """One external component."""

    name: Identifier
    """The name of its folder; its node is `component/NAME`."""
    doc: str = ""
    interface: _InterfaceName
    """Type of the service, action or message, such as `antipodal_interfaces/srv/ProposeGrasps`."""
    server: RosName
    """Name under which it is served, such as `/propose_grasps`; of a message, the topic."""
    use: Literal["receive", "publish"] = "receive"
    """Of a topic: whether the node waits for the next message or publishes one."""
    qos: Qos | None = None
    """Of a topic: its quality of service."""
    outcomes: tuple[Label, ...] = Field(min_length=1)
    """Names of the outcome numbers 0, 1, 2 ...; or their number, for `outcome_0` and so on; or label -> rule, for an
    interface that doesn't keep the contract."""
    rules: FrozenDict[Label, str] = FrozenDict()
    """Filled from `outcomes` where they are given by rule: label -> expression over the outputs; the first that holds
    is the outcome."""
    meaning: FrozenDict[Label, Meaning] = FrozenDict()
    """What an outcome means; `success` where nothing is said."""
    ports: FrozenDict[Identifier, PortType] = FrozenDict()
    """Field -> its type as a value, or more; a field that isn't named here keeps its message type."""
    fixed: FrozenDict[Identifier, object] = FrozenDict()
    """Fields of the request that are always sent with one value, and are no ports."""
    start: Start | None = None
    """How it is started; without it, it is expected to run already."""
    timeouts: Timeouts = Timeouts()
    """How long to wait for it."""
    moves: bool = True
    """Whether its work may move something: then nothing else that may begins before it has ended, or a halted call is
    answered."""

    @property
    def kind(self) -> Kind:
        """What it is: a service (`srv`), an `action` or a topic (`msg`)."""
        return cast(Kind, self.interface.split("/")[1])

    @model_validator(mode="before")
    @classmethod
    def _outcomes_by_rule(cls, data: object) -> object:
        if not isinstance(data, dict):
            return data
        given = data.get("outcomes")
        if given is None and "/msg/" in str(data.get("interface")):
            given = {"published" if data.get("use") == "publish" else "received": "true"}
        if isinstance(given, dict) and set(map(type, given.values())) != {int}:  # those would number them
            rules = {label: "true" if rule is True else rule for label, rule in given.items()}
            return {**data, "outcomes": tuple(given), "rules": rules}
        return data

    @field_validator("outcomes", mode="before", json_schema_input_type=tuple[Label, ...] | int | dict[Label, str])
    @classmethod
    def _number_of_outcomes(cls, value: object) -> object:
        if isinstance(value, int) and not isinstance(value, bool):
            return tuple(f"outcome_{i}" for i in range(value))
        if isinstance(value, dict):
            in_order = ", ".join(map(str, sorted(value, key=value.__getitem__)))
            raise ValueError(f"they are numbered in their order: write [{in_order}], or give each a rule")
        return value

    @field_validator("ports", mode="before", json_schema_input_type=dict[Identifier, PortType | str])
    @classmethod
    def _short_ports(cls, value: object) -> object:
        if isinstance(value, dict):
            return {k: {"type": v} if isinstance(v, str) else v for k, v in value.items()}
        return value

    @field_validator("rules")
    @classmethod
    def _rules_are_expressions(cls, value: FrozenDict[str, str]) -> FrozenDict[str, str]:
        for label, rule in value.items():
            try:
                parse_expression(rule)
            except ExpressionError as error:
                raise ValueError(f"the rule of the outcome {label!r}: {error}") from None
        return value

    @model_validator(mode="after")
    def _outcomes_are_consistent(self) -> ComponentFile:
        if twice := sorted({label for label in self.outcomes if self.outcomes.count(label) > 1}):
            raise ValueError(f"outcomes are named twice: {', '.join(twice)}")
        if unknown := sorted(set(self.meaning) - set(self.outcomes)):
            there_are = ", ".join(self.outcomes)
            raise ValueError(f"meaning of undeclared outcomes: {', '.join(unknown)} (available: {there_are})")
        if self.kind != "msg" and self.use != "receive":
            raise ValueError("use: only a topic, whose interface is a message, can be published")
        if self.kind != "msg" and self.qos is not None:
            raise ValueError("qos: it is a topic's; services and actions are reliable, which is ROS's default")
        if self.kind == "msg" and not self.rules:
            raise ValueError(
                "the interface is a message, which numbers no outcome: give outcomes by rule, such as "
                '`outcomes: {found: "count > 0", none: "true"}`'
            )
        return self

    def meanings(self) -> dict[str, Meaning]:
        """Return every outcome and what it means, by number."""
        return {label: self.meaning.get(label, "success") for label in self.outcomes}

    def port_type(self, field: str, otherwise: str) -> str:
        """Return the declared type of a field's port, or `otherwise`."""
        return self.ports[field].type if field in self.ports else otherwise

    def port_fields(self, fields: Iterable[str]) -> dict[str, str]:
        """Return the ports that one side of the interface has, and where each is in its message.

        Args:
            fields: names of the fields of the request or of the response.

        Returns:
            port -> dotted path; a field that ports take parts of, or that is fixed, is no port itself.
        """
        found: dict[str, str] = {}
        for field in fields:
            inside = {p: t.field for p, t in self.ports.items() if t.field and t.field.split(".")[0] == field}
            if inside:
                found |= inside
            elif field not in self.fixed and not (field in self.ports and self.ports[field].field):
                found[field] = field
        return found


def load_component(path: str | Path) -> ComponentFile:
    """Read a component file, or the one in a component's folder.

    Raises:
        DocumentError: it isn't there, isn't YAML, or says something that the format doesn't allow; with the place.
    """
    file = Path(path)
    return read_model(file / FILE_NAME if file.is_dir() else file, ComponentFile)
