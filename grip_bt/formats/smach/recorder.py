"""The recording process: runs the construction of legacy machines, executes none, and tells what was built.

A file is imported in a child of this process, and each of its builders is called in a child of that one. What it asks
of stand-ins is answered in every way, one after the other. The code has to be trusted: what else it does is refused.
"""

from __future__ import annotations

import dis
import gc
import inspect
import marshal
import os
import random
import re
import resource
import sys
import traceback
import unittest
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import lru_cache, partial
from hashlib import sha256
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

from grip_bt import smach_compat
from grip_bt.nodes import stand_ins
from grip_bt.nodes.smach_construction import CONTAINERS, Construction
from grip_bt.nodes.smach_source import LegacyFinder, Workspace, module_name, names_in, read_source, run_as, workspace_of
from grip_bt.nodes.stand_ins import StandIn, StandInFinder, asked_by_a_library, name_of, stand_in, unwrapped
from grip_bt.smach_compat._settings import quiet
from grip_bt.smach_compat.smach_ros._connection import names_used

from . import tracked_code
from .facts import facts_of
from .found import Built, Job, Record, Run, Told
from .sandbox import BUILDER_PATIENCE, PATIENCE, forget, in_child, load
from .surroundings import guard, ros_stand_ins, surround

MOST_ANSWERS, MOST_IMPORTS, FEW_ANSWERS, MOST_FRUITLESS = 100, 6, 6, 16
"""In how many ways the questions of a builder, and those of an import, are answered; few, where all are too many; and
how often in a row, before anything was built, that ends in an error that was seen before."""
MOST_QUESTIONS = 400
_MEMORY = 4 << 30
_ROS = ("rospy", "rosparam", "rclpy", "roslib", "actionlib", "smach_ros", "tf", "tf2_ros", "launch", "launch_ros")
_INTERFACES = ("_msgs", "_srvs", "_interfaces")
_BUILDERS = {cls.__name__ for cls in CONTAINERS}
_OURS = (os.path.dirname(__file__), os.path.dirname(stand_ins.__file__))


_Way = tuple[str | bool | None, int, list[bool]]
"""How the run ends that it parts from, or whether that builds something; how much that asked; the answers."""


class TooManyError(BaseException):
    """The code asks without end."""


class Asking(stand_ins.Judge):
    """Answers as people do (`known`), as it is told to, then as is wanted, and keeps what was asked."""

    def __init__(self, answers: list[bool], job: Job):
        super().__init__()
        self.given, self.answers = answers, list[bool]()
        self.known: dict[str, Any] = {**job.given, **job.given.get("", {})}
        self.asked: list[Told] = []
        self.told: dict[str, Told] = {}
        self.over = False

    def decide(self, what: str, wanted: bool) -> bool:
        """Answer as was told to, or as is wanted."""
        if self.over or what in self.known:
            return bool(self.known.get(what, wanted))
        if len(self.answers) >= MOST_QUESTIONS:
            self.over = True
            raise TooManyError
        answer = self.given[len(self.answers)] if len(self.answers) < len(self.given) else wanted
        self.answers.append(answer)
        self.elsewhere = self.elsewhere or answer != wanted
        self.asked.append(_told(what))
        return answer

    def lacks(self, what: str, also: str = "") -> bool:
        """Answer where legacy code is in a `try` that takes the absence of a name: once for all that a line imports."""
        frame = tracked_code.caller()
        if frame is None or not _prepared(frame, also):
            return False
        imports = dis.opname[frame.f_code.co_code[frame.f_lasti]].startswith("IMPORT")
        place = frame.f_code.co_filename, frame.f_lineno, "" if imports else what
        if place not in self.lasting:
            self.lasting[place] = self.decide(what, True)
        return not self.lasting[place]

    def note(self, what: str, value: object = stand_ins.UNKNOWN) -> None:
        """Keep it."""
        if not self.over:
            told = _told(what, None if value is stand_ins.UNKNOWN else repr(value)[:60])
            self.told[told.model_dump_json()] = told
            if len(self.told) > MOST_QUESTIONS:
                self.over = True
                raise TooManyError


def _told(what: str, value: str | None = None) -> Told:
    frame = tracked_code.caller()
    place = {} if frame is None else {"line": frame.f_lineno, "file": frame.f_code.co_filename}
    return Told(what=what, value=value, **place)


class Recording(Construction):
    """A construction in which labels, outcomes and states may be stand-ins."""

    def __init__(self, judge: Asking):
        super().__init__(_OURS, holds_threads=True)
        self.judge = judge

    def __enter__(self) -> Recording:
        begun = smach_compat.State.__init__

        def plain(state: Any, *arguments: Any, **named: Any) -> None:
            given = {name: tracked_code.without_order(each) for name, each in named.items()}
            begun(state, *self._plain(list(map(tracked_code.without_order, arguments))), **self._plain(given))

        self.replace(smach_compat.State, "__init__", plain)
        super().__enter__()
        return self

    def _plain(self, value: Any) -> Any:
        return unwrapped(value, self.judge.note)

    def given(self, label: Any, state: Any, *rest: Any, **named: Any) -> tuple[Any, ...]:
        """Return what is added without stand-ins."""
        rest, named = tuple(self._plain(rest)), self._plain(named)
        if isinstance(state, StandIn):  # nothing is known of it: it ends as its transitions say
            outcomes = named.get("transitions", rest[0] if rest else None) or {}
            kind, state = name_of(state), smach_compat.State(list(outcomes))
            state.stands_for = kind.rstrip("()").split(".")[-1] or kind
        return self._plain(label), state, rest, named

    def machines(self, file: str, result: Any, names: Mapping[str, Any]) -> Iterator[Built]:
        """Yield the outermost machines that are made in a file, are of a class there, executed by it or returned."""
        containers = [m for m in self.made if isinstance(m, CONTAINERS)]
        inside = {id(child) for c in containers for child in c.get_children().values()}
        counted: dict[tuple[str, int], int] = {}
        variables = {id(value): name for name, value in names.items() if isinstance(value, CONTAINERS)}
        for container in containers:
            place = self.places[id(container)]
            number = counted[place] = counted.get(place, -1) + 1
            mine = place[0] == file or type(container).__module__ == names.get("__name__")
            if id(container) in inside or not (mine or container is self.caught or container is result):
                continue
            yield Built(
                key=f"{place[0]}:{place[1]}#{number}",
                state=facts_of(container, Path(file), self),
                returned=container is result,
                variable=variables.get(id(container), ""),
            )


def answered(first: Callable[[list[bool]], Run], most: int) -> list[Run]:
    """Return the runs with all ways of answering what is asked.

    It ends early where that is enough: each machine is another one by the answers, or there are too many ways. The last
    question of the last run is changed first: what it led to was nearest to it; last what comes after one that was
    changed without any effect on how it ends: it ends so again, and nothing else is asked before. Where none of the
    others has built anything, that isn't tried at all.
    """
    todo: list[_Way] = [(None, 0, [])]
    idle, runs = list[_Way](), list[Run]()
    shapes, furthest, fruit, built, dead = defaultdict[str, set[str]](set), dict[str, int](), 0, False, 0
    begun, seen = os.times(), set[tuple[str, int]]()
    while todo or idle:
        fruitless = not built and (not todo or len(runs) - fruit > MOST_FRUITLESS)
        many = len(runs) + len(todo) + len(idle) > most and len(runs) >= FEW_ANSWERS
        late = sum(os.times()[:4]) - sum(begun[:4]) > PATIENCE / 3 or len(runs) >= most or dead > 1
        if fruitless or late or (many and built):
            for run in runs:
                run.unfinished = True
            break
        before, asked_before, given = (todo or idle).pop()
        run = first(given)
        runs.append(run)
        asked, new = len(run.answers), {(told.what, told.line) for told in run.asked}
        end = run.error or run.builder == "import" or bool(run.machines)
        built, dead = built or end is True, dead + (run.unfinished and not asked)  # it was stopped
        if len(new) > furthest.get(run.error, -1):  # a loop asks the same again
            furthest[run.error], fruit = len(new), len(runs)
        for machine in run.machines:
            shapes[machine.key].add(machine.shape)
        if run.stopped or (shapes and all(len(each) > 1 for each in shapes.values())):
            break
        more: list[_Way] = [(end, asked, [*run.answers[:n], not run.answers[n]]) for n in range(len(given), asked)]
        if end is not True and end == before and asked <= asked_before and new <= seen:
            idle = [*more, *idle]
        else:
            todo += more
        seen |= new
    return runs


_listed = lru_cache(maxsize=None)(names_in)
_codes = dict[tuple[str, int], tuple[CodeType, tracked_code.Tries]]()
_tries = dict[str, tracked_code.Tries]()
_shelf, _fetched, _fresh = Path(os.devnull), set[str](), set[tuple[str, int]]()
"""Where the processes of a `Recorder` keep what they compile, each file once for all; what was taken; what is new."""


def _code(file: Path) -> CodeType:
    key = str(file), file.stat().st_mtime_ns
    tracked_code.files.add(key[0])
    if key not in _codes:
        tree, tries = tracked_code.tracked(read_source(file).tree)
        _codes[key] = compile(tree, key[0], "exec"), tries
        _fresh.add(key)
    code, _tries[key[0]] = _codes[key]
    return code


def _keep() -> None:
    """Put on the shelf what this process has compiled; not at once, since nothing may be written under legacy code."""
    while _fresh:
        kept = marshal.dumps((key := _fresh.pop(), _codes[key]))
        with suppress(OSError):  # others compile it again
            (new := _shelf / f".{os.getpid()}").write_bytes(kept)
            new.replace(_shelf / sha256(repr(key).encode()).hexdigest())


def _fetch() -> None:
    """Take what is new off the shelf, and look up here, once for all children, what importing it asks."""
    for name in {name for name in os.listdir(_shelf) if name[0] != "."} - _fetched:
        key, _codes[key] = marshal.loads((_shelf / name).read_bytes())
        if ("*",) in _codes[key][0].co_consts:
            names_used(_codes[key][0])
        for folder in (Path(key[0]).parent, Path(key[0]).with_suffix("")):
            _listed(folder)
        _fetched.add(name)


class FileRecorder:
    """Records a file of a workspace, in the process that imports it."""

    def __init__(self, job: Job, workspace: Workspace):
        self.finder, self.record, self.read = StandInFinder(_ROS), Record(), set[str]()
        self.job, self.file, self.workspace, self.before = job, Path(job.file), workspace, frozenset(sys.modules)
        self.name = module_name(self.file)

    def recorded(self) -> Record:
        """Import the file, and call its builders."""
        self._prepare()
        job, name = self.job, self.name
        tracked_code.legacy_modules.add(name)
        stand_ins.judged_by(asking := Asking(job.answers, job))
        sys.argv, sys.modules["__main__"].__file__ = stand_ins.known("sys.argv", [job.file]), job.file
        work = partial(__import__, name) if "." in name else partial(run_as, name, self.file, _code(self.file))
        run, _ = self._run("import", asking, recording := Recording(asking), work)
        module = None if run.error or run.unfinished else sys.modules.get(name)
        run.machines = list(recording.machines(job.file, None, vars(module) if module else {}))
        self.record.runs.append(run)
        gc.freeze()
        for builder, call in self._builders(module) if module else ():
            if job.builders is None or builder in job.builders:
                known = any(each.machines and not each.missing for each in self.record.runs)
                most = FEW_ANSWERS if builder == "__main__" and known else MOST_ANSWERS  # it builds what they do
                self.record.runs += answered(partial(self._built, builder, call), most)
        new = {name: module for name, module in sys.modules.items() if name not in self.before}
        self.record.libraries = [n for n, module in new.items() if "-packages" in str(getattr(module, "__file__", ""))]
        self.record.read = sorted(self.read)
        return self.record

    def _prepare(self) -> None:
        for limit, most in ((resource.RLIMIT_AS, _MEMORY), (resource.RLIMIT_CORE, 0)):
            resource.setrlimit(limit, (most, most))
        null = os.open(os.devnull, os.O_RDWR)
        for stream in range(3):
            os.dup2(null, stream)
        smach_compat.install(ros=False)  # states of smach_ros have stand-ins: recording never talks to ROS
        smach_compat.set_loggers(*[quiet] * 4)
        ros_stand_ins(self.finder, self.workspace)
        sys.path[:] = [path for path in sys.path if path and not _is_of(path, self.workspace)]
        forget({name for folder in self.workspace.folders for name in _listed(folder)})
        sys.meta_path.insert(2, _TrackedFinder(self.workspace, self.finder))
        sys.meta_path.append(self.finder)
        tracked_code.install()
        surround(self.workspace)
        guard(self.workspace, self.read)

    def _wanted(self) -> str:
        """Return a class of machines that the program names, or nothing."""
        own, named = vars(sys.modules["__main__"]), sorted(_names(_code(self.file)))
        spaces = (own, *(vars(each) for each in own.values() if isinstance(each, ModuleType)))
        found = ((name, names[name]) for names in spaces for name in named if name in names)
        return next((name for name, cls in found if isinstance(cls, type) and issubclass(cls, CONTAINERS)), "")

    def _run(self, builder: str, asking: Asking, recording: Recording, work: Callable[[], Any]) -> tuple[Run, Any]:
        stand_ins.judged_by(asking)
        random.seed(os.environ.get("PYTHONHASHSEED"))  # alike for each way of answering
        run, result = Run(builder=builder), None
        try:
            result = recording.run(work)
        except TooManyError:
            run.unfinished = True
        except BaseException as error:  # noqa: BLE001 - see in_child
            run.error = f"{type(error).__name__}: {error}"[:300] + _where(error)
        asking.over = True
        _keep()
        run.answers, run.asked, run.told = asking.answers, asking.asked, list(asking.told.values())
        return run, result

    def _built(self, builder: str, call: Callable[[], Any], given: list[bool]) -> Run:
        def work() -> Run:
            self._missing, self._calls = dict[str, None](), list[str]()
            asking = Asking(given, self.job)
            asking.known |= stand_ins.judge.known  # parameters that the import has uploaded among them
            recording = Recording(asking)
            run, result = self._run(builder, asking, recording, call)
            run.calls, run.missing = self._calls, list(self._missing)
            names = vars(sys.modules[self.name])
            returned = None if recording.caught is not None else result
            if not run.error:  # else it isn't known what it would have added
                run.machines = list(recording.machines(str(self.file), returned, names))
            if run.unfinished and not (run.error or run.machines):
                run.error = "it asks without end what is known only in a run"
            run.wanted = self._wanted() if run.error and builder == "__main__" else ""
            return run

        _fetch()
        failed = partial(Run, builder=builder, unfinished=True)  # what it would have made isn't known
        return Run.model_validate_json(in_child(work, failed, BUILDER_PATIENCE))

    def _builders(self, module: ModuleType) -> Iterator[tuple[str, Callable[[], Any]]]:
        mine = {n: v for n, v in vars(module).items() if getattr(v, "__module__", "") == module.__name__}
        builders = _BUILDERS | {n for n, v in mine.items() if isinstance(v, type) and issubclass(v, CONTAINERS)}
        functions = {n: v for n, v in mine.items() if inspect.isfunction(v)}
        while more := {n for n, f in functions.items() if n not in builders and builders & _names(f.__code__)}:
            builders |= more
        for name, value in mine.items():
            is_container = isinstance(value, type) and issubclass(value, CONTAINERS)
            if is_container or (name in functions and name in builders):
                yield name, partial(self._call, value, name)
            if not isinstance(value, type) or issubclass(value, (StandIn, BaseException)):
                continue
            methods = {n: m for n, m in vars(value).items() if inspect.isfunction(m) and builders & _names(m.__code__)}
            if "__init__" in methods and not is_container:
                yield name, partial(self._call, value, name)
            built = {each.cls for r in self.record.runs for m in r.machines for each in m.state.within()}
            inside = {n for n, v in vars(value).items() if isinstance(v, type) and issubclass(v, CONTAINERS)}
            for nested in sorted(inside - built):
                yield f"{name}.{nested}", partial(self._method, value, name, nested)
            if is_container and any(m.state.added for r in self.record.runs if r.builder == name for m in r.machines):
                continue  # it is filled by its constructor
            for method in methods.keys() - {"__init__"}:
                yield f"{name}.{method}", partial(self._method, value, name, method)
        yield "__main__", partial(run_as, "__main__", self.file, _code(self.file))

    def _method(self, cls: type, name: str, method: str) -> Any:
        if issubclass(cls, unittest.TestCase):
            made = cls(method)
            made.setUp()
        else:
            made = self._call(cls, name)
        return self._call(getattr(made, method), f"{name}.{method}")

    def _call(self, function: Callable[..., object], name: str) -> Any:
        given = {**self.job.given.get("", {}), **self.job.given.get(name, {})}
        signature = inspect.signature(function)
        bound = signature.bind_partial()
        for name, parameter in signature.parameters.items():
            if parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
                continue
            if name in given:
                bound.arguments[name] = given[name]
            elif parameter.default is parameter.empty:
                bound.arguments[name] = _argument(parameter)
                self._missing[name] = None
        said = (f"{n}={given[n]!r}" if n in given else f"{n}=argument({n!r})" for n in bound.arguments)
        self._calls.append(", ".join(said))
        return function(*bound.args, **bound.kwargs)


def _argument(parameter: inspect.Parameter) -> Any:
    """Return what stands for an argument: of the class that its annotation names."""
    made, annotation = stand_in(parameter.name), parameter.annotation
    declared = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", "")
    vars(made)["_stand_in_declared"] = declared.split("[")[0]
    return made


def _names(code: CodeType) -> set[str]:
    inside = (_names(each) for each in code.co_consts if isinstance(each, CodeType))
    return {*code.co_names, *code.co_varnames, *code.co_freevars}.union(*inside)


def _where(error: BaseException) -> str:
    place = ""
    for frame, line in traceback.walk_tb(error.__traceback__):
        if tracked_code.is_tracked(frame):
            place = f" ({os.path.basename(frame.f_code.co_filename)}:{line})"
    return place


def _is_of(path: str, workspace: Workspace) -> bool:
    """Tell whether a folder is one of a workspace's, and none of the libraries that may be installed in it."""
    return "-packages" not in path and f"{path}{os.sep}".startswith(f"{workspace.root}{os.sep}")


class _TrackedFinder(LegacyFinder):
    """Finds what is in the workspace, wherever the path leads there, and compiles it so that it is seen."""

    compiled, listed = staticmethod(_code), staticmethod(_listed)

    def __init__(self, workspace: Workspace, finder: StandInFinder):
        super().__init__(workspace.folders)
        self.workspace, self.finder = workspace, finder

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        top = fullname.partition(".")[0]
        if top in sys.stdlib_module_names or (path is None and (top in sys.modules or asked_by_a_library())):
            return None
        if path and not any(_is_of(each, self.workspace) for each in path):
            return None  # a part of a library
        if top in _ROS or top.endswith(_INTERFACES):  # never the real ones, nor a copy of smach_ros: they want a robot
            return self.finder.find_spec(fullname)
        found = super().find_spec(fullname, path, target)
        if found is None and path is None:
            there = {*self.folders}
            paths = (Path(p) for p in sys.path if isinstance(p, str) and _is_of(p, self.workspace))
            if more := [path for path in paths if path not in there]:
                self.folders += more
                found = super().find_spec(fullname, path, target)
        if found is not None:
            tracked_code.legacy_modules.add(fullname)
        return found


def _prepared(frame: FrameType, more: str = "") -> bool:
    """Whether code is in a `try` that takes the absence of a module or of a name in one."""
    errors = rf"\b(ImportError|ModuleNotFoundError|AttributeError{more})\b"
    tries = _tries.get(frame.f_code.co_filename, ())
    return any(first <= frame.f_lineno < end and re.search(errors, caught) for first, end, caught in tries)


def record(job: Job) -> Record:
    """Record a file, with all ways in which what its import asks can be answered."""
    whole, workspace = Record(), workspace_of(Path(job.file), Path(job.root) if job.root else None)
    for folder in workspace.folders:
        _listed(folder)  # here, once for all files

    def once(given: list[bool]) -> Run:
        job.answers = given
        _fetch()
        text = in_child(lambda: FileRecorder(job, workspace).recorded(), Record, PATIENCE)
        told = Record.model_validate_json(text)
        whole.error = whole.error or told.error
        whole.read = told.read or whole.read
        first = next(iter(told.runs), Run(builder="import", stopped=True))
        for run in told.runs[1:]:  # what the import went by, each machine goes by too
            run.told, run.asked = first.told + run.told, first.asked + run.asked
            run.answers = first.answers + run.answers
        load(told.libraries)
        whole.runs += told.runs
        return first

    answered(once, MOST_IMPORTS)
    return whole


def main(shelf: str) -> None:
    """Answer jobs until stdin ends; `shelf`: a folder for compiled code."""
    global _shelf
    _shelf = Path(shelf)
    gc.disable()  # in a child, whatever it looks at is written to, and so is copied
    for line in sys.stdin:
        sys.stdout.write(record(Job.model_validate_json(line)).model_dump_json(exclude_defaults=True) + "\n")
        sys.stdout.flush()
        gc.collect(0)  # states know the container around them
