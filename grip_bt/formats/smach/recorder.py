"""The recording process: imports a legacy module, lets it build its machines, executes none, and says what they are.

Run as `python -m grip_bt.formats.smach.recorder FILE [ARGUMENTS]`; each line of its stdout is what is known so far.
It isn't a sandbox: the module's own code runs. Writing files, starting programs and the network are refused, so that a
module that does more than build machines fails here instead of doing it.
"""

from __future__ import annotations

import inspect
import io
import json
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from pydantic import BaseModel, JsonValue

from grip_bt import smach_compat
from grip_bt.nodes.smach_source import load_legacy, read_source

from .placeholders import Finder, Placeholder
from .reader.found import Unresolved

_CONTAINERS = (smach_compat.StateMachine, smach_compat.Sequence, smach_compat.Concurrence, smach_compat.Iterator)
_BUILDERS = {cls.__name__ for cls in _CONTAINERS}
_REFUSED = (
    *("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.remove", "os.rename", "os.rmdir"),
    *("os.mkdir", "os.truncate", "os.chmod", "os.link", "os.symlink", "shutil.", "socket.connect", "socket.bind"),
    *("socket.sendto", "os.kill"),
)
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
_OURS = str(Path(smach_compat.__file__).parent)


class Recording:
    """Everything that was built: states and containers, held so that identities stay.

    By identity: the place of the code that made it, whether it takes the place of a placeholder, and the class or
    function of the module that gives it when called without placeholders.
    """

    def __init__(self, file: Path, finder: Finder, given: dict[str, dict[str, object]]):
        self.file, self.finder, self.given = file, finder, given
        self.objects: list[object] = []
        self.places: dict[int, tuple[str, int]] = {}
        self.stands: set[int] = set()
        self.entries: dict[int, str] = {}

    def begin(self) -> None:
        """Have every object noted, and nothing executed."""
        made = smach_compat.State.__init__

        def noting(state: Any, *arguments: Any, **named: Any) -> None:
            self.objects.append(state)
            self.places[id(state)] = _place(sys._getframe(1), state)
            made(state, *arguments, **named)

        smach_compat.State.__init__ = noting  # type: ignore[method-assign,assignment]
        for cls in _CONTAINERS:
            cls.execute = _not_executed  # type: ignore[method-assign]
            if "add" in vars(cls):
                setattr(cls, "add", staticmethod(self._adding(vars(cls)["add"].__func__)))  # noqa: B010 - no one class has it

    def _adding(self, add: Callable[..., object]) -> Callable[..., Any]:
        def adding(label: str, state: Any, *arguments: Any, **named: Any) -> Any:
            if isinstance(state, Placeholder):  # nothing is known of it: it ends as its transitions say
                transitions = named.get("transitions", arguments[0] if arguments else None) or {}
                kind, state = type(state).__name__, smach_compat.State(list(transitions))
                state.stands_for = kind
                self.stands.add(id(state))
            return add(label, state, *arguments, **named)

        return adding

    def tell(self) -> None:
        """Write what is known on one line."""
        containers = [o for o in self.objects if isinstance(o, _CONTAINERS)]
        record = Record(containers=self.containers(containers), placeholders=self.finder.packages)
        sys.__stdout__.write(record.model_dump_json() + "\n")  # type: ignore[union-attr]
        sys.__stdout__.flush()  # type: ignore[union-attr]

    def containers(self, containers: Sequence[smach_compat.Container]) -> list[RecordedContainer]:
        """Return what these containers are."""
        numbers = {id(container): number for number, container in enumerate(containers)}
        return [self._container(container, numbers) for container in containers]

    def _container(self, found: Any, numbers: dict[int, int]) -> RecordedContainer:
        try:
            found.check_consistency()
            consistent, reason = True, ""
        except Exception as error:  # noqa: BLE001 - whatever is wrong with it
            consistent, reason = False, str(error)
        transitions = getattr(found, "_transitions", {})
        remappings = getattr(found, "_remappings", {})
        constants = getattr(found, "_constants", {})
        children = [
            RecordedChild(
                label=str(label),
                state=RecordedState(**self._state(state, numbers)),
                transitions={str(k): None if v is None else str(v) for k, v in transitions.get(label, {}).items()},
                remapping={str(k): str(v) for k, v in dict(remappings.get(label) or {}).items()},
                constants={str(k): _literal(v) for k, v in constants.get(label, {}).items()},
            )
            for label, state in found.get_children().items()
        ]
        return RecordedContainer(
            **self._state(found, numbers),
            consistent=consistent,
            reason=reason,
            children=children,
            initial=getattr(found, "_initial_state_label", None),
            userdata={k: _literal(v) for k, v in found.userdata._data.items()},
            settings=_settings(found),
            items=_literal(found._items) if isinstance(found, smach_compat.Iterator) else None,
            entry=self.entries.get(id(found)),
        )

    def _state(self, state: Any, numbers: dict[int, int]) -> dict[str, Any]:
        file, line = self.places.get(id(state), ("", 0))
        kinds = [c.__name__ for c in type(state).__mro__ if c.__module__.startswith(("grip_bt.smach", "smach"))]
        return {
            "cls": getattr(state, "stands_for", type(state).__name__),
            "kind": "" if id(state) in self.stands else next(iter(kinds), ""),
            "file": file,
            "line": line,
            "outcomes": [str(o) for o in state.get_registered_outcomes()],
            "input_keys": [str(k) for k in state.get_registered_input_keys()],
            "output_keys": [str(k) for k in state.get_registered_output_keys()],
            "container": numbers.get(id(state)),
        }


class RecordedValue(BaseModel):
    """What JSON holds, or the class of what it doesn't: objects of subclasses, too."""

    value: JsonValue = None
    opaque: str | None = None

    def plain(self) -> object:
        """Return the value, or what stands for one that is known only at run time."""
        return self.value if self.opaque is None else Unresolved(self.opaque)


class RecordedState(BaseModel):
    """A state as it was made; `container` is its number among the containers."""

    cls: str
    kind: str
    file: str
    line: int
    outcomes: list[str]
    input_keys: list[str]
    output_keys: list[str]
    container: int | None = None


class RecordedChild(BaseModel):
    """A state as it was added to a container."""

    label: str
    state: RecordedState
    transitions: dict[str, str | None]
    remapping: dict[str, str]
    constants: dict[str, RecordedValue]


class RecordedContainer(RecordedState):
    """A container as it was built; `items` are an Iterator's."""

    consistent: bool
    reason: str
    children: list[RecordedChild]
    initial: str | None
    userdata: dict[str, RecordedValue]
    settings: dict[str, object]
    items: RecordedValue | None = None
    entry: str | None


class Record(BaseModel):
    """What the recording process told; `words` went to stderr: exceptions of the module's code among it."""

    containers: list[RecordedContainer] = []
    placeholders: list[str] = []
    words: str = ""


def _settings(found: object) -> dict[str, object]:
    if isinstance(found, smach_compat.Concurrence):
        return {
            "default_outcome": found._default_outcome,
            "outcome_map": {k: dict(v) for k, v in found._outcome_map.items()},
            "outcome_cb": found._outcome_cb is not None,
            "child_termination_cb": found._child_termination_cb is not None,
        }
    if isinstance(found, smach_compat.Iterator):
        return {
            "it_label": found._items_label,
            "exhausted_outcome": found._exhausted_outcome,
            "loop_outcomes": list(found._loop_outcomes),
            "break_outcomes": list(found._break_outcomes),
            "final_outcome_map": dict(found._final_outcome_map),
        }
    return {}


def _literal(value: object) -> RecordedValue:
    plain = list(value) if isinstance(value, range) else value
    return RecordedValue(value=plain) if _is_plain(plain) else RecordedValue(opaque=type(value).__name__)


def _is_plain(value: object) -> bool:
    if type(value) is list:
        return all(map(_is_plain, value))
    if type(value) is dict:
        return all(type(key) is str and _is_plain(item) for key, item in value.items())
    return value is None or type(value) in (bool, int, str) or (type(value) is float and math.isfinite(value))


def _place(frame: FrameType | None, state: object) -> tuple[str, int]:
    """Return where the code makes the object: outside smach and outside the constructors of its own class."""
    while frame is not None:
        own = frame.f_locals.get("self") is state
        if not own and not frame.f_code.co_filename.startswith((_OURS, os.path.dirname(__file__))):
            return frame.f_code.co_filename, frame.f_lineno
        frame = frame.f_back
    return "", 0


def _not_executed(self: Any, parent_ud: Any = None) -> Any:
    return next(iter(self.get_registered_outcomes()), None)


# --- running the module's code ---------------------------------------------------------------------------------------


def _guard() -> None:
    """Refuse what building a machine doesn't need."""
    sys.dont_write_bytecode = True

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        mode, flags = arguments[1:3] if event == "open" else (None, 0)
        writes = any(c in mode for c in "wax+") if isinstance(mode, str) else bool(flags and int(flags) & _WRITING)
        if writes or event.startswith(_REFUSED):
            raise PermissionError(f"{event} isn't allowed while machines are recorded")

    threading.Thread.start = lambda self: None  # type: ignore[method-assign]
    time.sleep = lambda seconds: None
    sys.stdin = io.StringIO()
    sys.addaudithook(hook)


def _builds(code: CodeType, builders: set[str]) -> bool:
    """Whether a function mentions a container, or something that builds one."""
    if builders & {*code.co_names, *code.co_varnames, *code.co_freevars}:
        return True
    return any(isinstance(c, CodeType) and _builds(c, builders) for c in code.co_consts)


def _attempted(name: str, work: Callable[[], Any]) -> Any:
    """Return what is made; what is raised is told and forgotten."""
    try:
        return work()
    except BaseException as error:  # noqa: BLE001 - legacy code may do anything, sys.exit among it
        sys.stderr.write(f"{name}: {type(error).__name__}: {error}\n")
        return None


def _call(function: Callable[..., object], name: str, recording: Recording, *first: object) -> object:
    """Call with what was given, defaults, and placeholders."""
    given = recording.given.get(name, {})
    arguments: dict[str, object] = {}

    def call() -> object:
        for parameter in list(inspect.signature(function).parameters.values())[len(first) :]:
            if parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
                continue
            if parameter.name in given:
                arguments[parameter.name] = given[parameter.name]
            elif parameter.default is parameter.empty:
                arguments[parameter.name] = Placeholder()
        result = function(*first, **arguments)
        if isinstance(result, _CONTAINERS) and not any(isinstance(a, Placeholder) for a in arguments.values()):
            recording.entries[id(result)] = name
        return result

    return _attempted(name, call)


def _explore(module: Any, recording: Recording) -> None:
    """Call what builds machines and hasn't been called."""
    mine = {n: v for n, v in vars(module).items() if getattr(v, "__module__", "") == module.__name__}
    builders = _BUILDERS | {n for n, v in mine.items() if isinstance(v, type) and issubclass(v, _CONTAINERS)}
    functions = {n: v for n, v in mine.items() if inspect.isfunction(v)}
    while more := {n for n, f in functions.items() if n not in builders and _builds(f.__code__, builders)}:
        builders |= more
    for name, value in mine.items():
        if isinstance(value, type) and issubclass(value, _CONTAINERS):
            if not any(type(o) is value for o in recording.objects) or name in recording.given:
                _call(value, name, recording)
        elif name in functions and name in builders:
            _call(value, name, recording)
        elif isinstance(value, type) and not issubclass(value, smach_compat.State):
            methods = {n: m for n, m in vars(value).items() if inspect.isfunction(m) and _builds(m.__code__, builders)}
            made = _call(value, name, recording) if methods else None
            for method in () if made is None else methods:
                if method != "__init__":
                    _call(getattr(made, method), f"{name}.{method}", recording)
        recording.tell()


def main(arguments: list[str]) -> None:
    """Record one file."""
    file = Path(arguments[0]).resolve()
    given = json.loads(arguments[1]) if len(arguments) > 1 else {}
    sys.stdout = sys.stderr  # what the module prints isn't ours
    smach_compat.install(ros=False)  # states of smach_ros have placeholders: recording never talks to ROS
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)
    finder = Finder()
    sys.meta_path.append(finder)
    recording = Recording(file, finder, given)
    recording.begin()
    read_source(file)  # loads the converter, where it is needed, before the guard
    _guard()
    module = _attempted("import", lambda: load_legacy(file, ros=False))
    recording.tell()
    if module is not None:
        names = {"__name__": "__main__", "__file__": str(file)}
        _attempted("__main__", lambda: exec(compile(read_source(file).tree, str(file), "exec"), names))
        recording.tell()
        _explore(module, recording)
    recording.tell()
    sys.stderr.flush()
    os._exit(0)  # what the module left running doesn't keep us


if __name__ == "__main__":
    main(sys.argv[1:])
