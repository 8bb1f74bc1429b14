"""The file `component.yaml`: what somebody's external software is called, speaks, answers and is started with.

The user writes it beside the software; `grip component add` makes a node package from it. Format: docs/components.md.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, cast

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.base.errors import ExpressionError
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import Identifier, RosName, Settings, exactly_one, read_model
from grip_bt.task.model import Meaning

Kind = Literal["msg", "srv", "action"]
FILE_NAME = "component.yaml"
FEEDBACK = "feedback"
"""The output that holds the last feedback of an action."""

Label = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
_InterfaceName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*/(srv|action|msg)/[A-Z][A-Za-z0-9]*$")]

UNITS: dict[str, float] = {
    **{"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    **{"rad": 1.0, "deg": math.pi / 180},
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    **{"kg": 1.0, "g": 1e-3, "N": 1.0, "Nm": 1.0, "percent": 0.01},
}
"""Units that a component may use, in those of GRIP (m, rad, s, kg, N, N m, fractions)."""
Unit = Literal["m", "cm", "mm", "in", "rad", "deg", "s", "ms", "us", "ns", "kg", "g", "N", "Nm", "percent"]
_FieldPath = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$")]


AXES = ("x", "y", "z", "-x", "-y", "-z")
"""Axes of a pose along which a component may approach or close."""
LENGTHS = ("m", "cm", "mm", "in")
_SignedPath = Annotated[str, StringConstraints(pattern=r"^-?[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$")]


class Number(Settings):
    """A number in a component's message; its field's name alone will do."""

    field: _SignedPath
    """Where it is in the message; after a minus, it is negated."""
    unit: Unit | Literal["px"] | None = None
    """Unit that the component uses; `px` of the width of a line in an image."""

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: object) -> object:
        return {"field": value} if isinstance(value, str) else value


class GraspFields(Settings):
    """How a message says a grasp: a pose, a point with two vectors, or a line in an image; or it is a pose itself."""

    pose: _FieldPath | None = None
    """Field with a Pose, PoseStamped or Transform."""
    position: _FieldPath | None = None
    """Field with a point, or 3 numbers; `approach` and `closing` are fields too then."""
    column: Number | None = None
    """Of a line in the image of `camera`, along whose optical axis the approach is: its middle; the first is 0."""
    row: Number | None = None
    """Likewise, counted downwards."""
    angle: Number | None = None
    """From the image's right to the line along which the fingers close, turning towards its lower edge."""
    depth: Number | None = None
    """Of its middle along the optical axis; by default that of the depth image that was sent."""
    approach: _SignedPath = "z"
    """Where the hand goes: an axis of the pose, or a field with a vector; a minus turns it round."""
    closing: _SignedPath = "y"
    """Along which the fingers close, likewise."""
    offset: float = 0.0
    """From what is said to the point between the finger tips, along the approach [m]."""
    width: Number | None = None
    """Of the thing between the fingers."""
    quality: Number | None = None
    """Larger is better."""
    camera: Identifier | None = None
    """The input with a depth image, a frame or a camera's geometry in whose optical frame the grasps are given."""
    standoff: float = Field(default=0.12, gt=0)
    """Length of the straight approach [m]."""
    lift: float = Field(default=0.15, ge=0)
    """Height of the straight lift [m]."""

    @model_validator(mode="after")
    def _one_way(self) -> GraspFields:
        ways = [name for name in ("pose", "position", "column") if getattr(self, name) is not None]
        way, said = ways[0] if ways else "pose", (self.approach, self.closing)
        if len(ways) > 1:
            raise ValueError(f"`{ways[0]}` and `{ways[1]}` are two ways to say a grasp: give one of them")
        directed = {"approach", "closing"} & self.model_fields_set
        if way == "column" and (None in (self.row, self.angle, self.camera) or directed):
            raise ValueError("`column` needs `row`, `angle` and `camera`, and neither `approach` nor `closing`")
        if way == "position" and not {*said}.isdisjoint(AXES):
            raise ValueError("`position` needs `approach` and `closing`, fields with a vector each: it has no axes")
        if way == "pose" and (wrong := [axis for axis in said if axis not in AXES]):
            raise ValueError(f"{wrong[0]!r} isn't an axis of a pose: write one of {', '.join(AXES)}")
        if way == "pose" and said[0][-1] == said[1][-1]:
            raise ValueError("`approach` and `closing` are two axes at right angles, such as z and y")
        widths = (*LENGTHS, "px") if way == "column" else LENGTHS
        units = {"angle": ("rad", "deg"), "width": widths, "depth": LENGTHS}
        for name, number in self.numbers().items():
            if number.unit not in (None, *units.get(name, ())):
                raise ValueError(f"{name}: {number.unit!r} isn't one of its units: {', '.join(units.get(name, ()))}")
        return self

    def numbers(self) -> dict[str, Number]:
        """Return each key whose field holds one number."""
        given = ((name, getattr(self, name)) for name in ("column", "row", "angle", "depth", "width", "quality"))
        return {name: number for name, number in given if number is not None}


class PortType(Settings):
    """A field of the interface as a port of the node, and how it is converted on the way."""

    type: str = Field(min_length=1)
    """Name of a value (`PointCloud`, `list[Grasp]`), a builtin, or a ROS type, which leaves the message as it is."""
    doc: str = ""
    """A sentence about the port."""
    field: _FieldPath | None = None
    """Where it is in the message, such as `target.pose`; the field of the port's own name by default."""
    unit: Unit | None = None
    """Unit that the component uses; a port's own is always m, rad, s, kg, N or a fraction."""
    quaternion: Literal["xyzw", "wxyz"] | None = None
    """Order in which the component writes a rotation into an array of numbers; `xyzw` by default."""
    frame: str | None = None
    """Frame that the component works in: what goes in is transformed into it, what comes out without a frame has it."""
    grasp: GraspFields | None = None
    """How the component's messages say the grasps of an output, which become those of a hand, in world."""

    @property
    def adapts(self) -> bool:
        """Whether the value is changed between port and field."""
        return self.unit is not None or self.quaternion is not None or self.frame is not None

    @model_validator(mode="after")
    def _of_grasps(self) -> PortType:
        if self.grasp is not None and self.type not in ("Grasp", "list[Grasp]"):
            raise ValueError(f"`grasp` says what a `Grasp` or a `list[Grasp]` is made of; this is `{self.type}`")
        return self


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
        if isinstance(given, dict) and not _numbered(given):
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


def _numbered(outcomes: dict[object, object]) -> bool:
    return bool(outcomes) and all(isinstance(n, int) and not isinstance(n, bool) for n in outcomes.values())


def load_component(path: str | Path) -> ComponentFile:
    """Read a component file, or the one in a component's folder.

    Raises:
        DocumentError: it isn't there, isn't YAML, or says something that the format doesn't allow; with the place.
    """
    file = Path(path)
    return read_model(file / FILE_NAME if file.is_dir() else file, ComponentFile)
