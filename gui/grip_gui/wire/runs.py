"""What goes over the wire about runs: starting, controlling and watching them, and who may."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from grip_gui.wire.task import TaskView, Wire

RunState = Literal["starting", "running", "paused", "stopping", "ended"]
Robot = Literal["sim", "fake", "ros"]
When = Literal["before", "after"]
Path = Annotated[str, Field(max_length=4096)]
NodePath = Annotated[str, Field(min_length=1, max_length=4096)]
PageId = Annotated[str, Field(max_length=64, pattern=r"^[A-Za-z0-9_-]*$")]
"""How a page is called among the viewers; it makes it up itself. Empty for somebody who watches nothing."""
MOST = 500  # most breakpoints of a task, and most mocks of a run


class RunRecord(Wire):
    """A run of the journal."""

    id: str
    task_name: str
    task_path: str
    target: str
    seed: int | None
    started: float  # seconds since the epoch
    ended: float | None
    status: str
    outcome: str | None


class RunView(Wire):
    """A run with the task as it was when it ran."""

    run: RunRecord
    task: TaskView


class RunEvent(Wire):
    """One line of the journal."""

    seq: int
    t: float  # on the run's clock [s]
    path: str
    event: str
    outcome: str | None = None
    code: str | None = None
    data: dict[str, Any] = {}


class NamedPlace(Wire):
    """A pose, for drawing."""

    name: str
    frame: str
    at: list[float]  # x y z [m], then the quaternion w x y z


class ValueView(Wire):
    """What was written to a variable, for looking at."""

    type: str
    text: str  # one line
    rows: list[list[str]] = []  # name and value of its parts; of lists, the first ones
    picture: str = ""  # a drawing of it as a `data:` address; empty where there is none
    caption: str = ""  # what the drawing shows
    places: list[NamedPlace] = []  # poses in it: its own, or those of grasps


class CloudView(Wire):
    """Points that a variable holds, for drawing them in space."""

    frame: str = ""
    points: str = ""  # float32, little-endian, in base64: x y z of each [m]; empty where the value isn't a cloud
    colors: str = ""  # uint8, in base64: red green blue of each; empty where it has none
    of: int = 0  # how many points there are; only some of many are drawn


class Breakpoint(Wire):
    """Where runs of a task are to hold."""

    node: NodePath
    when: When = "before"
    outcome: Annotated[str, Field(max_length=200)] | None = None
    """Only after this outcome, or `outcome.code`; None for any."""
    condition: Annotated[str, Field(max_length=2000)] = ""
    """An expression over the variables that the node sees; empty for always."""

    @model_validator(mode="after")
    def _outcomes_come_after(self) -> Breakpoint:
        if self.outcome is not None and self.when == "before":
            raise ValueError("a breakpoint on an outcome holds after the node: when is `after`")
        return self


class BreakpointsRequest(Wire):
    """Set the breakpoints of a task; those that aren't named are cleared."""

    task: Annotated[str, Field(max_length=1024)]
    breakpoints: Annotated[list[Breakpoint], Field(max_length=MOST)]
    page: PageId = ""


class Held(Wire):
    """Where the run holds."""

    path: str
    when: When
    why: str  # `breakpoint`, `step` or `run_to`
    outcome: str | None = None
    code: str | None = None
    message: str | None = None  # why a condition couldn't be computed, and the like


class RunOptions(Wire):
    """What a run is started with."""

    robot: Robot = "sim"
    target: Literal["bt", "sm"] = "bt"  # `bt` (behaviour tree) or `sm` (state machine)
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0  # seed of everything random
    pace: Annotated[float, Field(gt=0, le=1000)] | None = 1.0
    """Simulated seconds in a second; None for as fast as it goes."""
    mocks: Annotated[dict[NodePath, Annotated[str, Field(min_length=1, max_length=1000)]], Field(max_length=MOST)] = {}
    """Node -> script that is played in its place, such as `failure.no_ik,success`."""


class StartRun(RunOptions):
    """Start a run of a task."""

    task: Annotated[str, Field(max_length=1024)]
    begin_at: Path = ""
    """Run from here: what comes before this node is passed over as if it had gone well; empty for the beginning."""
    run_to: Path = ""  # hold before this node; empty for nowhere
    page: PageId = ""


class Control(Wire):
    """Ask the run under way for something."""

    command: Literal["pause", "resume", "step", "run_to", "preempt", "fault", "stop"]
    how: Literal["tick", "in", "over", "out"] = "tick"  # of `step`
    node: Path = ""  # of `run_to`
    when: When = "before"  # of `run_to`
    fault: Annotated[str, Field(max_length=1000)] = ""  # of `fault`, `NAME: {fault: KIND}`
    page: PageId = ""

    @model_validator(mode="after")
    def _a_place_where_one_is_needed(self) -> Control:
        if (self.command == "run_to") != bool(self.node):
            raise ValueError("`run_to`, and it alone, needs the node to run to")
        return self

    def fields(self) -> dict[str, Any]:
        """Return it as the control protocol of a run has it."""
        more = {"step": {"how"}, "run_to": {"node", "when"}, "fault": {"fault"}}
        return self.model_dump(include={"command", *more.get(self.command, ())})


class SessionView(RunOptions):
    """The run that this server started last, and how its process is."""

    state: RunState
    task: str
    seed: int = 0
    run: str | None = None  # id in the journal; None until the process has said it
    held: Held | None = None  # where it holds; None while it runs, and when it was just paused
    status: str | None = None  # how it ended: success, failure, error, stopped, killed, or died
    outcome: str | None = None
    message: str = ""
    """What a person should know: the last line of output while starting, what was refused, or why it is gone."""
    contradiction: str = ""  # why the referee contradicts a success; empty where it doesn't
    zombies: list[str] = []  # what hung at the end and was left behind
    rest: str = ""  # what was measured of the robot after a stop or an error, in words
    unconfirmed: list[str] = []  # parts and nodes of which nobody can say that they have stopped; `rest` says why


class ControlRequest(Wire):
    """Take control, or give it back."""

    page: Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9_-]+$")]
    take: bool = True
    over: bool = False  # also from a page that holds it now


class Viewer(Wire):
    """A page that looks on."""

    page: str
    name: str  # what people call it; no two have the same
    colour: int  # number of its colour, from 0
    task: str = ""  # the task file that it shows; empty for the project's files


class SharedState(Wire):
    """What all pages share: who looks on, who holds control, and where runs hold."""

    holder: str | None = None  # id of the page that holds control; None when nobody does
    connections: int = 0  # how many pages look on
    viewers: list[Viewer] = []  # those of them that have said who they are
    breakpoints: dict[str, list[Breakpoint]] = {}  # task file -> breakpoints


class Subscribe(Wire):
    """Page to server: send this run's events from `from_seq` on."""

    type: Literal["subscribe"] = "subscribe"
    run: Annotated[str, Field(min_length=1, max_length=200)]
    from_seq: Annotated[int, Field(ge=0)] = 0


class Introduce(Wire):
    """Page to server: what people call this page, and what it shows."""

    type: Literal["introduce"] = "introduce"
    name: Annotated[str, Field(max_length=40, pattern=r"^[^\x00-\x1f\x7f]*$")] = ""  # empty for the one that it has
    task: Annotated[str, Field(max_length=1024)] = ""


class Selected(Wire):
    """What is selected on a page."""

    task: Annotated[str, Field(max_length=1024)] = ""  # the task file that they are nodes of
    nodes: Annotated[list[Annotated[str, Field(max_length=3000)]], Field(max_length=64)] = []
    """Their paths, the one with the focus first; of very many, some."""


class Selection(Selected):
    """Page to server: the nodes that are selected on it; a page sends it when that changes."""

    type: Literal["selection"] = "selection"


class SessionFrame(Wire):
    """Server to page: how the run under way is; None when none was started."""

    type: Literal["session"] = "session"
    session: SessionView | None


class SharedStateFrame(Wire):
    """Server to page: who holds control, and where runs hold."""

    type: Literal["desk"] = "desk"
    desk: SharedState


class EventsFrame(Wire):
    """Server to page: more of a run, in order and without gaps."""

    type: Literal["events"] = "events"
    run: str
    events: list[RunEvent]
    complete: bool  # whether the run has ended and this was its last part


class RefusedFrame(Wire):
    """Server to page: a message that wasn't understood."""

    type: Literal["refused"] = "refused"
    reason: str


class RevisionsFrame(Wire):
    """Server to page: the revision of each open task file."""

    type: Literal["revisions"] = "revisions"
    revisions: dict[str, int]


class SelectionsFrame(Wire):
    """Server to page: what other pages have selected, of those alone where it has changed."""

    type: Literal["selections"] = "selections"
    selections: dict[str, Selected | None]  # page -> its selection; None where nothing is selected, or the page is gone


ServerFrame = Annotated[
    SessionFrame | SharedStateFrame | EventsFrame | RefusedFrame | RevisionsFrame | SelectionsFrame,
    Field(discriminator="type"),
]
ClientFrame = Annotated[Subscribe | Introduce | Selection, Field(discriminator="type")]


class StudySpan(Wire):
    """How long something had the focus on a page; reading is what is done away from it."""

    window: Literal["configure", "program", "run", "away"]
    seconds: Annotated[float, Field(ge=0, le=86400)]
    page: PageId = ""
