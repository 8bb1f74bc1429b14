"""What the recording processes have seen of files, as containers: exact where nothing hangs on chance."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from signal import Signals
from tempfile import TemporaryDirectory
from typing import Any
from zlib import crc32

from grip_bt.base.interpreter import python_command
from grip_bt.nodes.smach_source import Source

from .found import Built, ContainerInfo, Job, Record, Run, Span, Told, Way
from .preview import Place, never_filled, places_of

Given = Mapping[str, Mapping[str, Any]]
"""Class or function, or empty for all -> parameter -> value."""
_MOST_REASONS = 4


class Recorder:
    """Recording processes of two kinds, whose hashes differ; `with` ends them. Threads may share it."""

    def __enter__(self) -> Recorder:
        self._free = (SimpleQueue[Any](), SimpleQueue[Any]())
        self._shelf = TemporaryDirectory(prefix="grip-smach-")
        for free in self._free * 2:  # one goes on while what the other runs only waits; they start when they are wanted
            free.put(None)
        return self

    def __exit__(self, *given: object) -> None:
        for free in self._free * 2:
            if process := free.get():
                _end(process)
        self._shelf.cleanup()

    def _start(self, kind: int) -> subprocess.Popen[str]:
        path = os.pathsep.join(filter(None, sys.path))
        environment = os.environ | {"PYTHONPATH": path, "PYTHONHASHSEED": str(kind + 1), "OPENBLAS_NUM_THREADS": "1"}
        command = python_command("-c", f"from {__package__}.recorder import main; main({self._shelf.name!r})")
        pipe = subprocess.PIPE
        return subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True, env=environment)

    def record(self, file: Path, root: Path | None = None, given: Given | None = None) -> tuple[Record, Record]:
        """Run the construction of a file's machines; return what one process saw, and the other of the same ones."""
        job = Job(file=str(file), root=root and str(root), given={n: dict(each) for n, each in (given or {}).items()})
        turn = crc32(file.name.encode()) % 2  # while one is asked about this file, the other is about the next
        first = self._asked(turn, job)
        job.builders = sorted({seen[0][0].builder for seen in _chosen(first).values() if not _is_open(seen)})
        return first, self._asked(1 - turn, job) if job.builders else Record()

    def _asked(self, kind: int, job: Job) -> Record:
        process = self._free[kind].get()
        try:
            for _ in range(2):  # what has killed it may be over
                if process is None or process.poll() is not None:
                    process = self._start(kind)
                with suppress(BrokenPipeError):  # what has ended it is told below
                    print(job.model_dump_json(), file=process.stdin, flush=True)
                if line := process.stdout.readline():
                    return Record.model_validate_json(line)
                status = _end(process)
        finally:
            self._free[kind].put(process)
        how = f"was killed by {Signals(-status).name}" if status < 0 else f"ended with status {status}"
        advice = "perhaps for want of memory; import the file alone, or without --execute, which only reads it"
        return Record(error=f"the process that runs its construction {how}, {advice}")


def _end(process: subprocess.Popen[str]) -> int:
    with suppress(BrokenPipeError):
        process.stdin.close()  # type: ignore[union-attr]
    process.stdout.close()  # type: ignore[union-attr]
    return process.wait()


def recorded_containers(source: Source, records: tuple[Record, Record]) -> list[ContainerInfo]:
    """Return all containers of a file: those that were built, and those of the text that nothing has built."""
    file = source.path
    chosen, second = _chosen(records[0]), _by_key(records[1])
    found, shapes = [], set[str]()
    for key, seen in sorted(chosen.items(), key=lambda item: _rank(item[1])):
        again = second.get(key, {}).get(seen[0][0].builder)
        state = seen[0][1].state
        shape = seen[0][1].shape + ("" if state.cls != state.kind else key.rpartition("#")[0])
        if shape not in shapes:  # what is built again, in a loop or of a class, is no second machine
            shapes.add(shape)
            found.append(_container(file, seen, again, records[0]))
    kinds = never_filled(source.tree)
    found = [c for c in found if c.added or c.cls == c.kind or c.cls not in kinds]
    parts = {id(c): {_identity(each) for each in c.within()[1:]} for c in found}
    kept = [c for c in found if not any(_identity(c) in parts[id(other)] for other in found if other is not c)]
    every = [c for each in kept for c in each.within()]
    return sorted([*every, *_not_built(source, every, records[0])], key=lambda c: c.span.line)


def _identity(found: ContainerInfo) -> object:
    return found.cls if found.cls != found.kind else (found.span.file, found.span.line)


Seen = list[tuple[Run, Built]]


def _by_key(record: Record) -> dict[str, dict[str, Seen]]:
    """Return what each builder has seen of each machine, and then of others, which it makes only without that one."""
    found: dict[str, dict[str, Seen]] = defaultdict(lambda: defaultdict(list))
    for run in record.runs:
        for machine in run.machines:
            found[machine.key][run.builder].append((run, machine))
    for builder, seen in (each for builders in found.values() for each in builders.items()):
        beside = {machine.key for run, _ in seen for machine in run.machines}
        runs = (run for run in record.runs if run.builder == builder)
        seen += [(run, machine) for run in runs for machine in run.machines if machine.key not in beside]
    return found


def _chosen(record: Record) -> dict[str, Seen]:
    """Return of each machine what the builder did that tells most of it."""
    return {key: min(builders.values(), key=_rank) for key, builders in _by_key(record).items()}


def _rank(seen: Seen) -> tuple[Any, ...]:
    run, machine = seen[0]
    named = machine.returned or machine.variable
    return not machine.state.added, _is_open(seen), len(run.missing), not named, run.builder == "__main__", run.builder


def _is_open(seen: Seen) -> bool:
    return _variants(seen) > 1 or any(run.told or run.unfinished for run, _ in seen)


def _variants(seen: Seen) -> int:
    return len({machine.shape for _, machine in seen})


def _container(file: Path, seen: Seen, again: Seen | None, record: Record) -> ContainerInfo:
    run, machine = seen[0]
    doubts, made = list(_doubts(seen, again, record)), machine.state
    builder = machine.variable if machine.variable and run.builder == "import" else run.builder
    made.way = Way(
        "__main__" if builder == "import" else builder,
        file,
        made.span.line if made.span.file == file else 0,
        tuple(run.calls),
        tuple(run.missing),
        machine.returned or builder == machine.variable,
        builder != machine.variable,
        int(machine.key.rpartition("#")[2]),
    )
    for text, place in doubts:
        made.problem("partial", text, place)
    if run.missing:
        names = ", ".join(f"`{name}`" for name in run.missing)
        made.problem("note", f"{run.builder} needs {names} to run")
    if record.read:
        made.problem("note", f"as {', '.join(record.read[:5])} says; import it again when that changes")
    return made


def _doubts(seen: Seen, again: Seen | None, record: Record) -> Iterator[tuple[str, Span | None]]:
    told = {(t.what, t.file, t.line): t for run, _ in seen for t in run.told}
    for number, each in enumerate(list(told.values())[:_MOST_REASONS], 1):
        taken = f"taken as {each.value}: with another value it may be another machine"
        more = f", and {len(told) - number} more like it" if number == _MOST_REASONS < len(told) else ""
        yield f"goes by `{each.what}`, {'known only in a run' if each.value is None else taken}{more}", _span(each)
    if _variants(seen) > 1:
        for each in _deciding(seen)[:_MOST_REASONS]:
            text = f"is another machine by the answer to `{each.what}`, known only in a run; shown as for one of them"
            yield text, _span(each)
    elif any(run.unfinished for run in record.runs if run.builder in ("import", seen[0][0].builder)):
        asked = list(dict.fromkeys(f"`{told.what}`" for run, _ in seen for told in run.asked))[:_MOST_REASONS]
        yield f"asks more than was tried of what is known only in a run: {', '.join(asked)}", None
    elif not told and (again is None or {m.shape for _, m in again} != {m.shape for _, m in seen}):
        yield "was another machine when it was built again: something in it goes by chance", None


def _deciding(seen: Seen) -> list[Told]:
    """Return the questions that decide which machine is built: each run is compared with the one it parts from last."""
    shapes, found = [machine.shape for _, machine in seen], dict[tuple[str, str, int], Told]()
    for number, (run, _) in enumerate(seen):
        alike = (os.path.commonprefix([run.answers, other.answers]) for other, _ in seen[:number])
        parted = [(len(answers), at) for at, answers in enumerate(alike)]
        at, before = max(parted, default=(len(run.asked), number))
        if shapes[before] != shapes[number] and at < len(run.asked):
            found.setdefault((run.asked[at].what, run.asked[at].file, run.asked[at].line), run.asked[at])
    return list(found.values()) or [told for run, _ in seen for told in run.asked]


def _span(told: Told) -> Span | None:
    return Span(Path(told.file), told.line) if told.file else None


def _not_built(source: Source, found: list[ContainerInfo], record: Record) -> Iterator[ContainerInfo]:
    wanted = next((run.wanted for run in record.runs if run.wanted), "")
    line = source.text.partition(f"{wanted}(")[0].count("\n") + 1
    named = [Place("", line, line, wanted, "__main__")] if wanted and not found else []
    for place in places_of(source.tree) or named:
        lines = range(place.line, place.end_line + 1)
        here = (c for c in found if c.span.file == source.path and c.span.line in lines)
        if any(c.cls == place.cls for c in found) if place.cls else any(here):
            continue
        made = ContainerInfo(kind=place.kind, cls=place.cls or place.kind, span=Span(source.path, place.line), added={})
        made.problem("failed", _why(place, record))
        yield made


def _why(place: Place, record: Record) -> str:
    if record.error:
        return f"wasn't built: {record.error}"
    imports = [r.error for r in record.runs if r.builder == "import"]
    if imports and all(imports):
        return f"wasn't built, since importing the file raises {imports[0]}"
    names = (place.around, place.cls) if place.around or place.cls else ("__main__",)
    failed = [run for run in record.runs if run.error and run.builder.split(".")[0] in names]
    if not failed:
        return "wasn't built by anything that was called"
    run = max(failed, key=lambda run: len(run.answers))  # the one that got on furthest
    return f"wasn't built: {'the program' if run.builder == '__main__' else run.builder}: {run.error}"
