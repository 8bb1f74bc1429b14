"""Processes for legacy code: each piece of work in a child, which is ended where it takes too long or only waits.

Importing is most of the work. A process that has imported what many files import first is kept warm, and each of them
goes on in a fork of it; that is what it would have seen itself, since none of its own code comes before.
"""

from __future__ import annotations

import ast
import os
import resource
import select
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from grip_bt.base.errors import DocumentError
from grip_bt.nodes.smach_source import LegacyFinder, Workspace, module_name, package_of, read_source, workspace_of

from .found import Job, Record

PATIENCE, BUILDER_PATIENCE = 20, 4
"""How much time of the processor [s] a file, and a builder, may take; of the clock it is ten times as much."""
MOST_WARM, MANY = 6, 3
"""How many warm processes there are at most, and how many files have to begin alike for one."""
_LOOK, _IDLE = 0.25, 12
"""How often it is looked whether a child only waits [s], and how many times are too many: nothing else runs here."""


def in_child(work: Callable[[], BaseModel], otherwise: Callable[[str], BaseModel], patience: int) -> str:
    """Return, as JSON, what is told by a child of this process; `otherwise` says what a failure is."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        os.setpgid(0, 0)
        resource.setrlimit(resource.RLIMIT_CPU, (patience + 1, patience + 1))
        try:
            text = work().model_dump_json(exclude_defaults=True)
        except BaseException as error:  # noqa: BLE001 - legacy code may do anything, sys.exit among it
            text = otherwise(f"{type(error).__name__}: {error}").model_dump_json()
        with os.fdopen(writer, "wb") as pipe:
            pipe.write(text.encode(errors="replace"))
        os._exit(0)
    os.close(writer)
    parts, end, before, idle = [], time.monotonic() + 10 * patience, "", 0
    while True:
        if select.select([reader], [], [], _LOOK)[0]:
            part = os.read(reader, 1 << 20)
            if not part:
                break
            parts.append(part)
            continue
        now = _asleep(child)
        before, idle = now, idle + 1 if now and now == before else 0
        if idle >= _IDLE or time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            why = "it waits for something" if idle >= _IDLE else f"it was stopped after {10 * patience} s"
            parts = [otherwise(why).model_dump_json().encode()]
            break
    os.close(reader)
    os.waitpid(child, 0)
    return (
        b"".join(parts).decode()
        or otherwise(f"its process ended, perhaps after {patience} s of computing").model_dump_json()
    )


def _asleep(process: int) -> str:
    """Return what a process has computed so far, if it sleeps and has no children; empty where it doesn't."""
    try:
        state, *rest = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        children = Path(f"/proc/{process}/task/{process}/children").read_text()
    except OSError:  # no Linux
        return ""
    return " ".join(rest[10:12]) if state == "S" and not children else ""


def seconds_used() -> float:
    """Return the time of the processor [s] that this process and its children took."""
    every = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in every)


class Warmed(BaseModel):
    """What the first imports did: what they were answered, and which modules they looked for, wherever they are.

    Attributes:
        usable: whether files can go on there; `failed`: what becomes of each of them, since this has failed.
    """

    usable: bool = True
    failed: Record | None = None
    answers: list[bool] = []
    tried: dict[str, str] = {}


class _Warm:
    """A warm process, and the pipes to it."""

    def __init__(self, recorder: Callable[[Job], Any], names: list[str], job: Job):
        self._given = job.answers
        (answers, answering), (asked, asking) = os.pipe(), os.pipe()
        self._process = os.fork()
        if self._process == 0:
            os.setpgid(0, 0)
            os.close(answers)
            os.close(asking)
            try:
                _serve(recorder(job), names, asked, answering)
            finally:
                os._exit(0)
        os.close(answering)
        os.close(asked)
        self._answers, self._asking = os.fdopen(answers), os.fdopen(asking, "w")
        ready = select.select([answers], [], [], 10 * PATIENCE)[0]
        line = self._answers.readline() if ready else ""
        self.facts = Warmed.model_validate_json(line) if line else Warmed(usable=False)

    def fits(self, answers: list[bool]) -> bool:
        """Tell whether it has answered as is to be answered."""
        same = all(one == other for one, other in zip(self.facts.answers, answers, strict=False))
        return same and self._given == answers[: len(self._given)]

    def record(self, job: Job) -> str:
        self._asking.write(job.model_dump_json() + "\n")
        self._asking.flush()
        return self._answers.readline()

    def close(self) -> None:
        os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        self._answers.close()
        self._asking.close()


def _serve(recorder: Any, names: list[str], asked: int, answering: int) -> None:
    with os.fdopen(asked) as requests, os.fdopen(answering, "w") as answers:
        answers.write(recorder.warmed(names).model_dump_json() + "\n")
        answers.flush()
        for line in requests:
            rest = partial(recorder.rest, Job.model_validate_json(line))
            answers.write(in_child(rest, lambda words: Record(error=words), PATIENCE) + "\n")
            answers.flush()


class WarmProcesses:
    """The warm processes of a recording process; `recorder` makes the FileRecorder that each of them works with."""

    def __init__(self, recorder: Callable[[Job], Any]):
        self._recorder = recorder
        self._begun: Counter[tuple[str, ...]] = Counter()
        self._warm: dict[tuple[str, ...], list[_Warm]] = {}

    def record(self, job: Job) -> str | None:
        """Return the record of a file, as JSON; None where nothing is warm for it."""
        file, answers = Path(job.file), job.answers
        workspace = workspace_of(file, Path(job.root) if job.root else None)
        names = first_imports(file, workspace)
        keys = [(str(workspace.root), str(job.given), *names[: number + 1]) for number in range(len(names))]
        if not answers:
            self._begun.update(keys)
        key = next((key for key in reversed(keys) if self._begun[key] >= MANY), None)
        if key is None:
            return None
        warm = next((each for each in self._warm.get(key, ()) if each.fits(answers)), None)
        if warm is None:
            warm = _Warm(self._recorder, list(key[2:]), job)
            self._warm.setdefault(key, []).append(warm)
        self._warm[key] = self._warm.pop(key)  # the last one that was wanted
        if len(self._warm) > MOST_WARM:
            for each in self._warm.pop(next(iter(self._warm))):
                each.close()
        if not warm.facts.usable or not warm.fits(answers) or _finds_others(file, warm.facts.tried):
            return None
        return warm.facts.failed.model_dump_json() if warm.facts.failed else warm.record(job) or None

    def close(self) -> None:
        """End them."""
        for each in (warm for several in self._warm.values() for warm in several):
            each.close()


def _finds_others(file: Path, tried: Mapping[str, str]) -> bool:
    """Tell whether one of the modules that were looked for is another one for this file."""
    finder = LegacyFinder((file.parent, package_of(file)[0]))
    found = ((finder.find_spec(name), origin) for name, origin in tried.items())
    return any(spec is not None and spec.origin != origin for spec, origin in found)


def first_imports(file: Path, workspace: Workspace) -> list[str]:
    """Return the modules of a file's workspace that are imported before any other code of it runs, in their order."""
    finder, found = LegacyFinder(workspace.shared), list[str]()
    for name, parts in _imported_first(file):
        place: Any = None
        if _finds_others(
            file, {name.partition(".")[0]: getattr(finder.find_spec(name.partition(".")[0]), "origin", "")}
        ):
            break
        for here in accumulate(name.split("."), "{}.{}".format):
            spec = finder.find_spec(here, place)
            if spec is None:
                break
            if here not in found:
                found.append(here)
            place = spec.submodule_search_locations or []
        else:
            if any(finder.find_spec(f"{name}.{part}", place) for part in parts):
                break  # where it has no such name, it is imported as a module
    return found


def _imported_first(file: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the modules that a file imports by its first statements, and what it takes from each."""
    name = module_name(file)
    package = name.rpartition(".")[0]
    if package:
        yield package, []
    try:
        body = read_source(file).tree.body
    except DocumentError:
        return
    for node in body:
        match node:
            case ast.Import(names):
                yield from ((each.name, []) for each in names)
            case ast.ImportFrom(module, names, level):
                above = package.split(".")[: len(package.split(".")) - (level or 1) + 1] if level else []
                yield ".".join([*above, *([module] if module else [])]), [each.name for each in names]
            case ast.Expr(ast.Constant()):
                pass
            case _:
                return
