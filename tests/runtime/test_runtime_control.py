"""Control of a run over two streams."""

from __future__ import annotations

import io
import json
import os
import threading
from pathlib import Path
from typing import Any

import pytest
from runtime_world import TARGETS, Started, leaf

from grip_bt.runtime import Journal, JournalReader, serve_control
from grip_bt.runtime.control import Control


class Served:
    """A run that is served in a thread of its own."""

    def __init__(self, target: Any, root: dict[str, Any], journal: Journal | None = None, data: Any = None):
        self.run = Started(target, root, journal=journal, poll=0.005, data=data)
        command_end, self._commands = os.pipe()
        self._events, event_end = os.pipe()
        self.commands, self.events = os.fdopen(self._commands, "w"), os.fdopen(self._events)
        streams = os.fdopen(command_end), os.fdopen(event_end, "w")

        def serve() -> None:
            with streams[0], streams[1]:
                serve_control(self.run.runner, *streams)

        self._thread = threading.Thread(target=serve, daemon=True)
        self._thread.start()

    def say(self, line: str) -> None:
        self.commands.write(line + "\n")
        self.commands.flush()

    def command(self, name: str) -> None:
        self.say(json.dumps({"command": name}))

    def until(self, event: str, **fields: Any) -> dict[str, Any]:
        for line in self.events:
            told = json.loads(line)
            if told["event"] == event and all(told[k] == v for k, v in fields.items()):
                return told
        raise AssertionError(f"no {event} {fields}")

    def close(self) -> None:
        self.commands.close()
        self._thread.join(120)
        assert not self._thread.is_alive()
        self.events.close()


@pytest.mark.parametrize("target", TARGETS)
def test_a_run_is_paused_resumed_and_stopped_over_its_streams(target: Any, tmp_path: Path) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        served = Served(target, leaf("wait"), journal)
        started = served.until("started")
        assert started["journal"] == str(journal.file)
        for command, state in (("pause", "paused"), ("resume", "running"), ("step", "paused"), ("stop", "stopping")):
            served.command(command)
            served.until("state", state=state)
        ended = served.until("ended")
        assert (ended["status"], ended["outcome"], ended["zombies"]) == ("stopped", None, [])
        served.close()
    with JournalReader(journal.file) as reader:
        states = [e.data["state"] for e in reader.events(started["run"]) if e.event == "state"]
    assert states == ["paused", "running", "paused", "stopping"]


def test_events_are_announced_when_they_can_be_read(tmp_path: Path) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        served = Served(TARGETS[0], leaf("end"), journal)
        run = served.until("started")["run"]
        announced = 0
        while announced < 4:
            announced = served.until("committed")["seq"]
            with JournalReader(journal.file) as reader:
                assert len(reader.events(run)) >= announced
        assert served.until("ended")["status"] == "success"
        served.close()


@pytest.mark.parametrize("target", TARGETS)
def test_at_the_end_of_the_commands_whoever_gave_them_has_gone(target: Any, tmp_path: Path) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        served = Served(target, leaf("wait"), journal)
        run = served.until("started")["run"]
        while not served.run.leaves["/"].active:
            pass
        served.commands.close()
        assert served.until("ended")["status"] == "died"
        served.close()
    assert served.run.leaves["/"].terminated, "it was halted all the same"
    with JournalReader(journal.file) as reader:
        assert reader.run(run).status == "died"
        *before, last = reader.events(run)
    assert (last.event, last.data["status"]) == ("run_ended", "died")
    nodes = ("enter", "exit", "interrupted")
    assert [e.event for e in before if e.event in nodes] == ["enter"], "what was halted isn't in it, but goes on"


def test_after_a_stop_the_end_of_the_commands_is_nothing() -> None:
    served = Served(TARGETS[0], leaf("wait"))
    served.until("started")
    served.command("stop")
    served.commands.close()
    assert served.until("ended")["status"] == "stopped"
    served.close()


def test_a_line_that_is_no_command_is_refused_and_the_run_goes_on() -> None:
    served = Served(TARGETS[0], leaf("wait"))
    for line in ("nonsense", '{"command": "explode"}', "[]", '{"command": ["stop"]}'):
        served.say(line)
        assert "pause, resume, step, run_to" in served.until("refused")["message"]
    served.run.leaves["/"].told.set()
    assert served.until("ended")["status"] == "success"
    served.close()


def test_a_reader_that_has_gone_away_stops_the_run() -> None:
    class Gone(io.StringIO):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    run = Started(TARGETS[0], leaf("wait"), poll=0.005)
    commands, other = os.pipe()
    with os.fdopen(commands) as lines, os.fdopen(other, "w") as open_end:
        result = serve_control(run.runner, lines, Gone())
        open_end.close()
    assert result.status == "died"


def test_what_was_commanded_before_there_is_a_run_is_obeyed_by_it() -> None:
    run = Started(TARGETS[0], leaf("end"), poll=0.005)
    commands, order = os.pipe()
    told = io.StringIO()
    with os.fdopen(commands) as lines, os.fdopen(order, "w") as orders:
        control = Control(lines, told)
        control.start()
        orders.write('{"command": "break", "node": "/"}\n{"command": "pause"}\n')
        orders.flush()
        while len(control._early) < 2:
            pass
        control.attach(run.runner)
        assert [json.loads(line)["event"] for line in told.getvalue().splitlines()] == [
            "started",
            "breakpoint",
            "state",
        ]
        assert run.runner.pacing.state == "paused"
        assert [point.node for point in run.runner.debugger.breakpoints] == ["/"]
        run.runner.stop()


def test_a_stop_before_there_is_a_run_interrupts_its_start_and_is_said_once() -> None:
    told, interrupted = io.StringIO(), []
    control = Control(io.StringIO(), told, lambda: interrupted.append(told.getvalue()))
    control.stop()
    once = told.getvalue()
    control.stop()
    assert told.getvalue() == once
    assert interrupted == [""]
    assert [json.loads(line) for line in told.getvalue().splitlines()] == [{"event": "state", "state": "stopping"}]


@pytest.mark.parametrize("target", TARGETS)
def test_whoever_debugs_a_run_is_told_where_it_holds_and_what_variables_hold(target: Any) -> None:
    parts = {"w": leaf("wait", out={"x": "n"}), "e": leaf("end")}
    data = {"n": {"type": "int", "value": 0}}
    served = Served(target, {"kind": "sequence", "children": parts}, data=data)
    served.say('{"command": "break", "node": "w", "when": "after"}')
    point = served.until("breakpoint")
    assert (point["id"], point["node"], point["when"]) == (1, "w", "after")
    served.run.leaves["w"].told.set()
    held = served.until("held")
    assert (held["path"], held["when"]) == ("w", "after")
    served.command("inspect")
    assert served.until("data")["variables"] == [{"scope": "/", "name": "n", "value": "1"}]
    served.say('{"command": "inspect", "variable": "m"}')
    assert "'m'" in served.until("refused")["message"]
    served.say('{"command": "clear", "id": 1}')
    assert served.until("cleared")["ids"] == [1]
    served.command("breakpoints")
    assert served.until("breakpoints")["breakpoints"] == []
    served.command("resume")
    assert served.until("ended")["status"] == "success"
    served.close()
