"""What `grip serve` offers of a project: its tasks by name, each run in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from grip_bt.app.project.folder import Project
from grip_bt.app.runs.execute import RunOptions, Target
from grip_bt.app.runs.supervisor import Supervisor
from grip_bt.app.wiring.parts import RobotKind
from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.ros.task_server import EventListener, Order, RunningTask
from grip_bt.runtime import JournalReader
from grip_bt.task import load


@dataclass(frozen=True)
class ServedTasks:
    """Implements `grip_bt.ros.task_server.Tasks`; `robot` is that of goals which name none."""

    project: Project
    robot: RobotKind

    def listed(self) -> Mapping[str, tuple[str, str]]:
        """Return the tasks, name -> file and sentence."""
        found = {}
        for file in sorted((self.project.folder / "tasks").glob("*.yaml")):
            try:
                doc = load(file).doc
            except DocumentError as error:
                doc = f"can't be read: {error}"
            found[file.stem] = str(file.relative_to(self.project.folder)), doc
        return found

    def start(self, order: Order, told: EventListener) -> RunningTask:
        """Start a run; UnknownNameError where there is no such task, form or robot."""
        listed = self.listed()
        files = {file for file, _ in listed.values()}
        file = order.task if order.task in files else listed.get(order.task, ("",))[0]
        if not file:
            raise UnknownNameError("task", order.task, listed, str(self.project.folder))
        for what, word, allowed in (("form", order.form, Target), ("robot", order.robot or self.robot, RobotKind)):
            if word not in get_args(allowed):
                raise UnknownNameError(what, word, get_args(allowed))
        options = RunOptions(
            target=order.form,  # type: ignore[arg-type]
            robot=order.robot or self.robot,  # type: ignore[arg-type]
            seed=order.seed,
            data=order.inputs,
            journal=self.project.journal,
        )
        run = Supervisor(str(self.project.folder / file), options, _Nodes(self.project.journal, told).hear)
        run.start()
        return run


class _Nodes:
    """Passes on what a run tells, and, as its journal is written, what its nodes did."""

    def __init__(self, journal: Path, told: EventListener):
        self._journal, self._told = journal, told
        self._run, self._seq = "", 0

    def hear(self, event: Mapping[str, object]) -> None:
        if event["event"] == "started":
            self._run = str(event["run"])
        if event["event"] in ("committed", "ended") and self._run:
            self._read()
        self._told(event)

    def _read(self) -> None:
        try:
            with JournalReader(self._journal) as reader:
                events = reader.events(self._run, self._seq)
        except GripError:
            return  # the run goes on, and its end is told all the same
        for event in events:
            self._seq = event.seq
            if event.event in ("enter", "exit", "interrupted"):
                what = event.outcome or event.event
                self._told({"event": "node", "path": event.path, "what": what, "code": event.code or "", "t": event.t})
