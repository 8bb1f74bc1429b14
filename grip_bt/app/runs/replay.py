"""Runs of the journal: found, shown again event by event, also in progress; and what their events add up to."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os.path import commonprefix
from pathlib import Path, PurePosixPath

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import AmbiguousNameError, UnknownNameError
from grip_bt.runtime import Event, JournalReader, RunRecord, RunSnapshot
from grip_bt.runtime.debugger import node_path

POLL = 0.05
"""How often [s] the journal is asked about a run that is under way."""
GLYPHS = {"enter": "▶", "interrupted": "⊘", "message": "…", "write": "=", "error": "‼", "zombie": "☠"}
ENDS: Mapping[str | None, str] = {"success": "✓", "failure": "✗", None: "■"}
"""What an end means; journals of earlier versions don't say what a task's own outcomes mean."""
_WENT_ON = {
    "resume": "continues what was under way",
    "restart": "is started again",
    "result": "has ended as set by --set-outcome",
}
_NO_END = {
    "died": "the run's process has died",
    "lost": "the run has no end, and its process isn't on this machine",
}
_NEAREST = 8


def find_run(reader: JournalReader, name: str) -> str:
    """Return the id that is meant by an id, its beginning, or `last`. Raises UnknownNameError with the nearest ones."""
    ids = [record.id for record in reader.runs()]
    fitting = ids[:1] if name == "last" else [name] if name in ids else [id for id in ids if id.startswith(name)]
    if len(fitting) == 1:
        return fitting[0]
    if name and fitting:
        raise AmbiguousNameError("run", name, fitting, str(reader.file), _NEAREST)
    alike = sorted(ids, key=lambda id: -len(commonprefix([id, name])))
    raise UnknownNameError("run", name, alike[:_NEAREST], str(reader.file))


def journal_of(place: Path | None, journal: Path | None) -> Path:
    """Return the journal that is given, or of the project around `place`. Raises UnknownNameError where none is."""
    file = journal or find_project(place or Path()).folder / ".grip" / "runs.sqlite"
    if not file.is_file():
        raise UnknownNameError("journal", str(file), [], "there are no runs yet; give --journal FILE, or run a task")
    return file


class Until:
    """Where a replay ends: after an event's number, or after an event of a node.

    Args:
        text: `SEQ`, `NODE` (its first end) or `NODE:OUTCOME` (or `NODE:enter`); empty for the end of the run.
    """

    def __init__(self, text: str):
        self.text = text
        self._seq = int(text) if text.isdecimal() else None
        node, _, self._what = text.partition(":") if self._seq is None else ("", "", "")
        self._path = node_path(node) if node else ""

    def reached(self, event: Event) -> bool:
        """Tell whether this is the last event that is wanted."""
        if self._seq is not None:
            return event.seq >= self._seq
        if not self._path or event.path != self._path:
            return False
        said = f"{event.outcome}.{event.code}" if event.code else event.outcome
        if not self._what:
            return event.event in ("exit", "interrupted")
        return self._what == event.event or (event.event == "exit" and self._what in (event.outcome, said))

    def place(self, events: Sequence[Event], run: str) -> int:
        """Return the number of that event. Raises UnknownNameError where the run never came there."""
        found = next((event.seq for event in events if self.reached(event)), None)
        if found is not None:
            return found
        node = self.text.partition(":")[0]
        ends = {f"{node}:{event.outcome}" for event in events if event.path == node and event.outcome is not None}
        there = [f"1 to {len(events)}"] if self._seq is not None else sorted(ends or {event.path for event in events})
        raise UnknownNameError("place in the run", self.text, there, f"run {run}")


def events_of(reader: JournalReader, run: str) -> Iterator[Event]:
    """Yield a run's events in order; of a run whose process lives, also those to come."""
    after = 0
    while True:
        over = reader.run(run).status != "running"
        for event in reader.iterate(run, after):
            after = event.seq
            yield event
        if over:
            return
        time.sleep(POLL)


def replay(
    events: Iterator[Event],
    show: Callable[[Event, RunSnapshot], None],
    speed: float | None = None,
    until: Until | None = None,
    sleep: Callable[[float], None] = time.sleep,
) -> tuple[RunSnapshot, bool]:
    """Show one event after the other, `speed` seconds of the run in a second, or as fast as it goes.

    Returns the last moment, and whether `until` was reached.
    """
    moment, began = RunSnapshot(), 0.0
    for event in events:
        if speed is not None:
            if moment.seq == 0:
                began = time.monotonic() - event.t / speed
            if (early := event.t / speed - (time.monotonic() - began)) > 0:
                sleep(early)
        moment.apply(event)
        show(event, moment)
        if until is not None and until.reached(event):
            return moment, True
    return moment, until is None


def line_of(event: Event) -> str:
    """Return an event in a line, indented by its node's depth."""
    depth = 0 if event.path == "/" else event.path.count("/") + 1
    name = event.path.rpartition("/")[2] or "/"  # also the root of a subtask
    glyph = ENDS[event.meaning] if event.event == "exit" else GLYPHS.get(event.event, "•")
    return f"{event.seq:>6} {event.t:>10.3f} s  {'  ' * depth}{glyph} {name}{_words(event)}"


def _words(event: Event) -> str:
    data = event.data
    match event.event:
        case "enter":
            return ""
        case "exit":
            said = f"{event.outcome}.{event.code}" if event.code else f"{event.outcome}"
            return f" {said}" + (f" ({data['message']})" if data.get("message") else "")
        case "message":
            return f" {data.get('text', '')}"
        case "write":
            return f" {data.get('variable')} = {data.get('preview')}"
        case "error":
            return f" {data.get('type')}: {data.get('message')}"
        case "state":
            return f" {data.get('state')}"
        case "run_resumed":
            back = ", ".join(data.get("restored", {}))
            return " continues in another process" + (f"; restored: {back}" if back else "")
        case "went_on":
            return f" {_WENT_ON.get(str(data.get('how')), 'continues')}"
        case "kept":
            return f" saved the {data.get('part')} for resuming"
        case "run_ended":
            why = f" ({data['message']})" if data.get("message") else ""
            return f" ended: {data.get('status')}" + (f", {event.outcome}" if event.outcome else "") + why
    more = ", ".join(f"{key} {value}" for key, value in data.items() if isinstance(value, str | int | float))
    return f" {event.event.replace('_', ' ')}" + (f": {more}" if more else "")


def moment_lines(moment: RunSnapshot, record: RunRecord | None = None) -> list[str]:
    """Return what runs, and the variables, at a moment; `record` is given where it is the run's last one."""
    active = moment.active()
    leaves = [path for path in active if not any(other.startswith(f"{path}/") for other in active)]
    leaves = [path for path in leaves if path != "/" or len(active) == 1]
    running = ", ".join(leaves) or "nothing"
    lines = [f"after event {moment.seq}, at {moment.t:.3f} s: {moment.state}; running: {running}"]
    lines += [f"  {name} = {event.data.get('preview')}" for name, event in moment.variables.items()]
    if record is not None and record.status in _NO_END:
        lines.append(f"  {_NO_END[record.status]}; resume it with: grip run --resume {record.id}")
    return lines


def failures(events: Iterable[Event]) -> dict[tuple[str, str], tuple[int, str]]:
    """Return (leaf, reason's code) -> (how often, the last message) of a run, most often first.

    A container fails with the reason of a child, which is counted there.
    """
    entered: set[str] = set()
    counts: Counter[tuple[str, str]] = Counter()
    messages: dict[tuple[str, str], str] = {}
    for event in events:
        if event.event == "enter":
            entered.add(event.path)
        elif event.event == "exit" and event.code is not None:
            counts[event.path, event.code] += 1
            messages[event.path, event.code] = event.data.get("message", "")
    above = {"/"} if entered - {"/"} else set()
    above.update(str(parent) for path in entered for parent in PurePosixPath(path).parents)
    return {key: (count, messages[key]) for key, count in counts.most_common() if key[0] not in above}
