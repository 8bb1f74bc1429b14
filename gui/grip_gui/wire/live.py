"""What goes over the wire about what runs beside the editor: topics, named messages, tries, measured places."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from grip_gui.wire.runs import Robot, ValueView
from grip_gui.wire.setup import SetupPath
from grip_gui.wire.task import Wire

Word = Annotated[str, Field(max_length=300)]
Typed = Annotated[str, Field(max_length=100_000)]


class TopicView(Wire):
    """A topic that somebody publishes."""

    name: str
    type: str  # its ROS type
    value: str  # what a task would get of it: the type of a sensor's output
    publishers: int


class TopicsView(Wire):
    """The topics of the running graph."""

    topics: list[TopicView] = []
    domain: str = ""  # ROS_DOMAIN_ID
    error: str = ""  # why nothing can be seen; empty when it can


class ReceiveRequest(Wire):
    """Wait for one message of a topic."""

    topic: Word
    type: Word
    within: Annotated[float, Field(gt=0, le=30)] = 5.0


class ReceivedView(Wire):
    """One message, looked at."""

    value: ValueView | None = None
    seconds: float = 0.0  # how long it took to come
    error: str = ""


class StoredMessage(Wire):
    """A named message of a running server."""

    store: str
    name: str
    type: str
    time: float
    provenance: str
    revision: int


class StoreView(Wire):
    """A store of a running server."""

    name: str
    type: str
    queued: int


class LiveMessages(Wire):
    """What a running server has."""

    served: bool = False
    ours: bool = False  # whether it is served by this editor
    stores: list[StoreView] = []
    messages: list[StoredMessage] = []
    domain: str = ""
    error: str = ""  # why there is none


class LiveMessage(Wire):
    """One of them, looked at."""

    value: ValueView | None = None
    text: str = ""  # its data as YAML, to be changed; empty for what is too much for that
    error: str = ""


class MessageRequest(Wire):
    """Do something with a running server, or start one."""

    do: Literal["serve", "end", "delete", "reset", "save"]
    store: Word = ""
    name: Word = ""


class PutRequest(Wire):
    """Add or replace a named message of a running server."""

    store: Annotated[str, Field(min_length=1, max_length=300)]
    name: Annotated[str, Field(min_length=1, max_length=300)]
    type: Word = ""  # ROS type, of a store that isn't one of the standard ones
    text: Typed  # YAML


class Done(Wire):
    """How a request went."""

    error: str = ""
    said: str = ""


class MeasureRequest(Wire):
    """Save the robot's current position now as a named message."""

    robot: Literal["run"] | Robot  # `run`: where the run under way measured it last
    part: Annotated[str, Field(max_length=200, pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]  # an arm, or a hand
    what: Literal["joints", "pose"]
    name: Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_ -]*$", max_length=200)]
    serve: bool = False  # give it to the running server too


class Sample(Wire):
    """A value that was recorded, as an input of a component."""

    source: str  # `run/SEQ` or `messages/STORE/NAME`: what goes back with the request
    title: str
    type: str


class RequestPort(Wire):
    """An input of a component."""

    name: str
    type: str
    doc: str
    samples: list[Sample]


class ComponentForm(Wire):
    """What a component can be tried with."""

    name: str
    inputs: list[RequestPort] = []
    error: str = ""


class Given(Wire):
    """The value of one input: recorded, or typed."""

    port: Word
    sample: Annotated[str, Field(max_length=500)] = ""
    text: Typed = ""  # YAML; used when no sample is named. Empty for nothing.


class TryRequest(Wire):
    """Call a component once."""

    path: SetupPath
    given: Annotated[list[Given], Field(max_length=100)] = []


class TryView(Wire):
    """How a component answered."""

    outcome: str = ""
    fields: dict[str, ValueView] = {}
    milliseconds: float = 0.0
    started: str = ""  # how the component came up
    error: str = ""


Place = Annotated[list[float], Field(min_length=7, max_length=7)]
"""x y z [m], then the quaternion w x y z."""


class ShapeView(Wire):
    """A body of a link."""

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: list[float]  # edge lengths; radius and height; radius [m]
    at: Place  # in the link
    color: list[float] = []  # red, green, blue, opacity of 1; empty where the description says none
    mesh: int = -1  # number of the mesh


class MimicView(Wire):
    """How a joint follows another one: multiplier * its position + offset."""

    joint: str
    multiplier: float
    offset: float


class JointView(Wire):
    """A joint of a robot."""

    name: str
    type: str  # as in a URDF: fixed, revolute, continuous, prismatic ...
    parent: str
    child: str
    at: Place  # in the parent link
    axis: list[float]
    limits: list[float] = []  # lower, upper [rad or m]; empty without them
    mimic: MimicView | None = None


class MeshView(Wire):
    """Triangles, in base64."""

    points: str  # float32, little-endian: x y z of each [m]
    triangles: str  # uint32, little-endian: three points each


class FrameView(Wire):
    """A frame on a link."""

    link: str
    at: Place
    group: str = ""  # of the arm that carries it


class GeometryView(Wire):
    """What the project's robot looks like."""

    name: str = ""
    links: dict[str, list[ShapeView]] = {}
    joints: list[JointView] = []
    meshes: list[MeshView] = []
    rest: dict[str, float] = {}  # joint -> where it is unless told otherwise [rad or m]
    grasp: dict[str, FrameView] = {}  # hand -> the frame in which it holds things
    groups: dict[str, list[str]] = {}  # of joints
    states: dict[str, dict[str, dict[str, float]]] = {}  # group -> name -> joint -> position [rad or m]
    findings: list[str] = []  # what its files say that had to be mended or left out
    error: str = ""


class SceneItem(Wire):
    """An object of the planning scene."""

    kind: Literal["box", "cylinder", "sphere", "mesh", "cells"]
    size: list[float]  # of a mesh, the edge lengths of the box around it; of cells, the edge length of one
    body: str = ""  # which body of the record, of a mesh and of cells
    at: Place  # in the world; in the grasp frame of the hand that holds it
    hand: str
    fixed: bool


Press = tuple[str, str, list[float], list[float]]
"""A link, what it presses on, where in world [m], and the force on that [N]."""


class MotionSample(Wire):
    """What has changed at one time."""

    t: float  # on the run's clock [s]
    q: dict[str, list[float]] = {}  # part -> positions of its joints [rad or m]
    way: dict[str, list[list[float]]] = {}  # arm -> positions that it begins to go through; none: it is over
    plans: dict[str, list[list[list[float]]]] = {}  # arm -> all ways that are planned for it and not begun
    touch: dict[str, dict[str, float]] | None = None  # hand -> link -> contact force [N]
    press: dict[str, list[Press]] | None = None  # hand -> where it presses
    scene: dict[str, SceneItem] | None = None  # all objects; None where none has changed


class MotionView(Wire):
    """How a run's robot has moved, from some place of the record on."""

    parts: dict[str, list[str]] = {}  # part -> its joints; only at the beginning of the record
    bodies: dict[str, MeshView] = {}
    """What meshes and maps of cells look like; each body once in a record. Of cells, their middles."""
    samples: list[MotionSample]
    next: int  # where to go on
