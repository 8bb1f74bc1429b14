"""The file `component.yaml`: what somebody's external software is called, speaks, answers and is started with.

The user writes it beside the software; `grip component add` makes a node package from it. Format: docs/components.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, cast

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.base.errors import ExpressionError
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import Identifier, RosName, Settings, read_model
from grip_bt.task.model import Meaning

from .component_parts import PortType, Start, Timeouts
from .ros_config import Kind

FILE_NAME = "component.yaml"
FEEDBACK = "feedback"
"""The output that holds the last feedback of an action."""

Label = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
_InterfaceName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*/(srv|action|msg)/[A-Z][A-Za-z0-9]*$")]

__all__ = ["FILE_NAME", "ComponentFile", "PortType", "Start", "Timeouts", "load_component"]


class ComponentFile(Settings):
    """One external component."""

    name: Identifier
    doc: str = ""
    interface: _InterfaceName
    """Type of the service, action or message, such as `antipodal_interfaces/srv/ProposeGrasps`."""
    server: RosName
    """Name under which it is served, such as `/propose_grasps`; of a message, the topic."""
    use: Literal["receive", "publish"] = "receive"
    """Of a topic: whether the node waits for the next message or publishes one."""
    outcomes: tuple[Label, ...] = Field(min_length=1)
    """Names of the outcome numbers 0, 1, 2 ...; or how many there are, which then are named `outcome_0` and so on; or
    label -> rule, for an interface that doesn't keep the contract."""
    rules: FrozenDict[Label, str] = FrozenDict()
    """Filled from `outcomes` where they are given by rule: label -> expression over the outputs; the first that holds
    is the outcome."""
    meaning: FrozenDict[Label, Meaning] = FrozenDict()
    """What an outcome means; `success` where nothing is said."""
    ports: FrozenDict[Identifier, PortType] = FrozenDict()
    """Types of the fields as values; a field that isn't named here keeps its message type."""
    fixed: FrozenDict[Identifier, object] = FrozenDict()
    """Fields of the request that are always sent with one value, and are no ports."""
    start: Start | None = None
    timeouts: Timeouts = Timeouts()
    moves: bool = True
    """Whether its work may move something. Then nothing else that may begins before it has ended; a call that was
    halted, which can't be stopped, before it is answered."""

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
        if isinstance(given, dict) and not _numbered(given):
            rules = {label: "true" if rule is True else rule for label, rule in given.items()}
            return {**data, "outcomes": tuple(given), "rules": rules}
        return data

    @field_validator("outcomes", mode="before")
    @classmethod
    def _number_of_outcomes(cls, value: object) -> object:
        if isinstance(value, int) and not isinstance(value, bool):
            return tuple(f"outcome_{i}" for i in range(value))
        if isinstance(value, str):
            words = ", ".join(re.findall(r"[^,\s]+", value))
            raise ValueError(f"expected a list: write [{words}], not {value!r}")
        if isinstance(value, dict):
            in_order = ", ".join(map(str, sorted(value, key=value.__getitem__)))
            raise ValueError(f"they are numbered in their order: write [{in_order}], or give each a rule")
        return value

    @field_validator("ports", mode="before")
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


def _numbered(outcomes: dict[object, object]) -> bool:
    return bool(outcomes) and all(isinstance(n, int) and not isinstance(n, bool) for n in outcomes.values())


def load_component(path: str | Path) -> ComponentFile:
    """Read a component file, or the one in a component's folder.

    Raises:
        DocumentError: it isn't there, isn't YAML, or says something that the format doesn't allow; with the place.
    """
    file = Path(path)
    return read_model(file / FILE_NAME if file.is_dir() else file, ComponentFile)
