"""What goes over the wire about the files that put a project together: robot, sensors, components, named messages."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from grip_gui.wire.runs import PageId
from grip_gui.wire.task import Problem, Wire

LONGEST = 1 << 20  # longest text of a settings file, in characters
SetupPath = Annotated[str, Field(min_length=1, max_length=1024)]
SetupTextField = Annotated[str, Field(max_length=LONGEST)]
Step = Annotated[str, Field(max_length=200)] | int


class SetupEntry(Wire):
    """A file of the project that is no task."""

    path: str
    kind: str
    title: str
    exists: bool
    doc: str


class Template(Wire):
    """Something to begin with."""

    title: str
    key: list[str]  # where it goes; where its last word is taken, a number is added
    value: Any


class SetupView(Wire):
    """A settings file as text, as data, and what is wrong with it."""

    path: str
    kind: str
    title: str
    text: str
    known: str  # tells the file's bytes that the text began with; goes back with the request to save
    data: Any  # None where the text is no YAML
    shape: dict[str, Any]  # JSON Schema of the data
    options: dict[str, list[str]]  # path of keys, with `*` for any, -> what may stand there
    templates: list[Template]
    problems: list[Problem]


class SetupText(Wire):
    """A text of a settings file, to be looked at; nothing is written."""

    path: SetupPath
    text: SetupTextField


class SetupChange(SetupText):
    """One value of the form, to be put into the text; nothing is written."""

    do: Literal["set", "remove", "rename"] = "set"
    key: Annotated[list[Step], Field(min_length=1, max_length=20)]
    value: Any = None  # of `set`: the value; of `rename`: the new name


class SetupSave(SetupText):
    """Write a settings file."""

    known: Annotated[str, Field(max_length=100)] = ""
    over: bool = False  # also over what somebody else has written


class CommandRequest(Wire):
    """Try what is configured."""

    what: Literal["robot", "generate", "test"]
    path: SetupPath  # the component's file, or `grip.yaml`
    page: PageId = ""


class CommandResult(Wire):
    """How a try went."""

    ok: bool
    command: str
    output: str
    seconds: float


class InterfaceRequest(Wire):
    """An interface to be wrapped: pasted, the name of an installed type, or a file in its own repository."""

    text: Annotated[str, Field(max_length=100_000)] = ""  # the .srv, .action or .msg file; empty for an installed type
    type: Annotated[str, Field(max_length=300)] = ""
    """Such as `std_srvs/srv/Trigger`; of a pasted text, what it shall be called."""
    file: Annotated[str, Field(max_length=1024)] = ""  # absolute; in place of text and type
    outcomes: Annotated[str, Field(max_length=2000)] = ""
    """`one,none`: names of 0, 1 ...; `2`; or `found: count > 0; none: true`. Empty to be told a suggestion."""
    failures: Annotated[list[Annotated[str, Field(max_length=200)]], Field(max_length=100)] = []
    name: Annotated[str, Field(max_length=200)] = ""
    server: Annotated[str, Field(max_length=300)] = ""
    create: bool = False  # write the component's folder and generate its node; without it only look


class FieldView(Wire):
    """A field of an interface."""

    side: str
    name: str
    type: str


class InterfaceView(Wire):
    """What an interface has, and what keeps it from being a component."""

    fields: list[FieldView]
    problems: list[str]
    suggestion: str  # outcomes that would be possible
    text: str  # the component file, as it would be written
    path: str  # the component file that was written; empty when none was
    output: str  # what generating said
    type: str = ""
    server: str = ""  # the name under which its repository serves it
    script: str = ""  # what serves it there, from the repository; started with the component


class RecordRequest(Wire):
    """Keep a value of a run as a named message of the project."""

    run: Annotated[str, Field(max_length=200)]
    seq: Annotated[int, Field(ge=1, le=2**53)]
    name: Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_ -]*$", max_length=200)]


EntryKind = Literal["moveit", "package", "folder", "file"]


class FolderView(Wire):
    """A folder of the machine that the server runs on."""

    at: str
    above: str  # empty at the top
    kind: EntryKind
    entries: dict[str, EntryKind]  # name -> what it is, or holds


class BeginRequest(Wire):
    """Begin a project with a robot, or complete one."""

    robot: Annotated[str, Field(max_length=1024)] = ""  # ready-made, or an absolute path; empty for the project's own
    example: Annotated[str, Field(pattern=r"^[a-z_]*$", max_length=100)] = ""  # a task of the example, in place of it
    chosen: Annotated[list[Annotated[str, Field(max_length=300)]], Field(max_length=10)] = []


class BeginView(Wire):
    """What was written; nothing where there is something to choose first."""

    files: list[str] = []
    findings: list[str] = []  # about the robot's files
    question: str = ""
    choices: list[str] = []


class ImportRequest(Wire):
    """Import a task: a file that is sent, or what lies on the server's machine."""

    source: Literal["smach", "btcpp", "pytrees", "grip"]
    name: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_-]*\.[a-z]+)?$", max_length=200)] = ""
    text: SetupTextField = ""
    path: Annotated[str, Field(max_length=1024)] = ""  # absolute; in place of name and text
    execute: bool = False  # run the code, to see what it builds; else it is only read


class ImportView(Wire):
    """What became of it."""

    probe: CommandResult
    tasks: list[str]  # task files that were written
