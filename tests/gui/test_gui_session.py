"""Runs through the server: started, watched, controlled, and ended whatever they do."""

from __future__ import annotations

import asyncio
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from played import BASE, EVENTS, SOCKET, PlayedLauncher, TestClient, record, until
from starlette.websockets import WebSocketDisconnect

from grip_bt.runtime import JournalError
from grip_bt.runtime.motion_end import Rest
from grip_gui.runs import pages as pages_module
from grip_gui.runs import stream as stream_module
from grip_gui.runs.journal import JournalRuns
from grip_gui.runs.stream import STRIKES
from grip_gui.server import create_app

WISH = {"task": "tasks/tiny.yaml", "robot": "fake", "target": "sm", "seed": 7, "pace": 2.5}


def in_state(state: str) -> Any:
    return lambda f: f["type"] == "session" and f["session"] is not None and f["session"]["state"] == state


def is_events(frame: dict[str, Any]) -> bool:
    return frame["type"] == "events"


def held_by(page: str | None) -> Any:
    return lambda f: f["type"] == "desk" and f["desk"]["holder"] == page


def started(page: TestClient, socket: Any, from_seq: int | None = None) -> str:
    """Start a run, wait until it runs, subscribe to it from a number on; return its id."""
    page.post("/api/session", json=WISH)
    run: str = until(socket, in_state("running"))["session"]["run"]
    if from_seq is not None:
        socket.send_json({"type": "subscribe", "run": run, "from_seq": from_seq})
    return run


def told(page: TestClient, command: str, **more: str) -> dict[str, Any]:
    answer = page.post("/api/session/control", json={"command": command, **more})
    assert answer.status_code == 200, answer.text
    view: dict[str, Any] = answer.json()
    return view


def test_a_run_is_started_with_the_options_of_the_page(
    page: TestClient, launcher: PlayedLauncher, project: Path
) -> None:
    answer = page.post("/api/session", json=WISH)
    assert answer.status_code == 201
    file, options = launcher.started[0]
    assert file == project / "tasks" / "tiny.yaml"
    assert (options.robot, options.seed, options.target, options.pace) == ("fake", 7, "sm", 2.5)


def test_events_are_streamed_from_the_wanted_number_on(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as socket:
        started(page, socket, 3)
        frame = until(socket, is_events)
        assert [event["seq"] for event in frame["events"]] == list(range(3, len(EVENTS) + 1))
        assert frame["events"][1]["data"]["preview"] == "1"
        assert frame["complete"] is False


def test_a_journal_that_cant_be_read_for_a_moment_silences_no_page(
    page: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures = [JournalError("it is being made"), sqlite3.OperationalError("database is locked")]
    read = JournalRuns.events

    def events(self: JournalRuns, run: str, from_seq: int, limit: int) -> list[Any]:
        if failures:
            raise failures.pop()
        return read(self, run, from_seq, limit)

    monkeypatch.setattr(stream_module, "POLL", 0.01)
    monkeypatch.setattr(JournalRuns, "events", events)
    with page.websocket_connect(SOCKET) as socket:
        started(page, socket, 1)
        until(socket, is_events)
        told(page, "pause")
        until(socket, in_state("paused"))
        assert not failures


def test_a_connection_that_can_tell_nothing_more_is_closed_so_that_the_page_comes_back(
    page: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def events(self: JournalRuns, run: str, from_seq: int, limit: int) -> list[Any]:
        raise ZeroDivisionError

    monkeypatch.setattr(JournalRuns, "events", events)
    with page.websocket_connect(SOCKET) as socket:
        started(page, socket, 1)
        with pytest.raises(WebSocketDisconnect):
            until(socket, lambda frame: False)


def test_pause_resume_and_stop_reach_the_run_and_come_back(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as socket:
        run = started(page, socket)
        told(page, "pause")
        until(socket, in_state("paused"))
        told(page, "resume")
        until(socket, in_state("running"))
        socket.send_json({"type": "subscribe", "run": run, "from_seq": 0})
        until(socket, is_events)
        answer = told(page, "stop")
        assert (answer["state"], answer["status"]) == ("ended", "stopped")
        events: list[dict[str, Any]] = []
        while not (frame := until(socket, is_events))["complete"]:
            events += frame["events"]
        assert [*events, *frame["events"]][-1]["event"] == "run_ended"


def test_the_death_of_a_run_is_noticed_and_told(page: TestClient, launcher: PlayedLauncher) -> None:
    launcher.dies = True
    with page.websocket_connect(SOCKET) as socket:
        page.post("/api/session", json=WISH)
        view = until(socket, in_state("ended"))["session"]
        assert view["status"] == "error"
        assert "exit status 70" in view["message"]
        socket.send_json({"type": "subscribe", "run": view["run"], "from_seq": 0})
        assert until(socket, is_events)["complete"] is True


def test_a_success_that_the_referee_contradicts_says_so(page: TestClient, launcher: PlayedLauncher) -> None:
    launcher.contradicted = "`placed == objects` is false; standing: box_0"
    with page.websocket_connect(SOCKET) as socket:
        page.post("/api/session", json=WISH)
        view = until(socket, in_state("ended"))["session"]
        assert (view["status"], view["outcome"]) == ("success", "done")
        assert view["contradiction"] == launcher.contradicted


def test_after_a_stop_the_page_has_what_was_measured_of_the_robot(page: TestClient, launcher: PlayedLauncher) -> None:
    rest = Rest(("hand",), {"right": "its joints still move, by 0.021 within 0.1 s"})
    launcher.rest = {"rest": str(rest), "unconfirmed": dict(rest.unconfirmed)}
    page.post("/api/session", json=WISH)
    view = told(page, "stop")
    assert (view["status"], view["unconfirmed"]) == ("stopped", ["right"])
    assert view["rest"] == (
        "could not confirm that 'right' stopped: its joints still move, by 0.021 within 0.1 s; 'hand' is at rest"
    )
    launcher.rest = {}
    page.post("/api/session", json=WISH)
    view = told(page, "stop")
    assert (view["rest"], view["unconfirmed"]) == ("", [])  # nothing of the run before


def test_one_run_at_a_time(page: TestClient) -> None:
    assert page.post("/api/session", json=WISH).status_code == 201
    second = page.post("/api/session", json=WISH)
    assert second.status_code == 409
    assert "stop it" in second.json()["detail"]
    told(page, "stop")
    assert page.post("/api/session", json=WISH).status_code == 201


def test_a_command_without_a_run_is_refused(page: TestClient) -> None:
    assert page.post("/api/session/control", json={"command": "pause"}).status_code == 409


def test_all_viewers_see_the_same_and_any_may_stop(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as one, page.websocket_connect(SOCKET) as two:
        page.post("/api/session", json=WISH)
        assert until(one, in_state("running")) == until(two, in_state("running"))
        told(page, "stop")
        assert until(one, in_state("ended")) == until(two, in_state("ended"))


def test_an_old_run_is_replayed_over_the_same_socket(page: TestClient, project: Path) -> None:
    old = record(project / ".grip" / "runs.sqlite", status="success")
    assert [run["id"] for run in page.get("/api/runs").json()] == [old]
    view = page.get(f"/api/runs/{old}").json()
    assert view["task"]["nodes"][0]["name"] == "tiny"
    with page.websocket_connect(SOCKET) as socket:
        socket.send_json({"type": "subscribe", "run": old, "from_seq": 0})
        frame = until(socket, is_events)
        assert len(frame["events"]) == len(EVENTS)
        assert frame["complete"] is True


def test_a_long_run_comes_in_batches_without_gaps(page: TestClient, project: Path) -> None:
    many = [("first", "message", None, {"text": str(i)}) for i in range(2500)]
    long = record(project / ".grip" / "runs.sqlite", many, status="success")
    with page.websocket_connect(SOCKET) as socket:
        socket.send_json({"type": "subscribe", "run": long, "from_seq": 0})
        seen: list[int] = []
        while True:
            frame = until(socket, is_events)
            seen += [event["seq"] for event in frame["events"]]
            if frame["complete"]:
                break
    assert seen == list(range(1, 2501))


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"type":"subscribe"}', '{"type":"x","run":"a"}', "x" * 10_000, "[" * 4000]
)
def test_malformed_socket_messages_are_refused_and_the_socket_lives(page: TestClient, text: str) -> None:
    with page.websocket_connect(SOCKET) as socket:
        socket.send_text(text)
        assert until(socket, lambda f: f["type"] == "refused")["reason"]
        socket.send_bytes(b"\0\1")
        assert "text" in until(socket, lambda f: f["type"] == "refused")["reason"]


def test_a_viewer_that_never_makes_sense_is_sent_away(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as socket:
        for _ in range(STRIKES):
            socket.send_text("nonsense")
        message = socket.receive()
        while message["type"] == "websocket.send":
            message = socket.receive()
        assert message["code"] == 1008


def test_an_unknown_run_is_named(page: TestClient) -> None:
    answer = page.get("/api/runs/nobody")
    assert answer.status_code == 404
    assert "nobody" in answer.json()["detail"]


def test_leaving_the_server_stops_the_run(project: Path, launcher: PlayedLauncher) -> None:
    from grip_gui.wire.runs import RunOptions

    app = create_app(project, launcher, token="t", task="tasks/tiny.yaml", autostart=RunOptions(robot="fake"))
    with TestClient(app):
        assert launcher.last is not None
    assert launcher.last.said == ["stop"]


# --- places to hold, steps, and running from and to a node ---

POINT = {"node": "machine/a", "when": "after", "outcome": "failure.no_plan", "condition": "count > 2"}


def test_breakpoints_are_kept_shown_to_all_and_set_before_the_run_begins(
    page: TestClient, launcher: PlayedLauncher, project: Path
) -> None:
    request = {"task": "tasks/tiny.yaml", "breakpoints": [POINT, {"node": "first"}], "page": "one"}
    with page.websocket_connect(SOCKET) as other:
        assert page.post("/api/breakpoints", json=request).status_code == 200
        shown = until(other, lambda f: f["type"] == "desk" and f["desk"]["breakpoints"])["desk"]["breakpoints"]
    assert [point["node"] for point in shown["tasks/tiny.yaml"]] == ["machine/a", "first"]
    page.post("/api/session", json={**WISH, "page": "one"})
    assert launcher.last is not None
    assert sorted(launcher.last.heard, key=lambda c: c["node"]) == [
        {"command": "break", "node": "first", "when": "before"},
        {"command": "break", "node": "machine/a", "when": "after", "outcome": "failure.no_plan", "if": "count > 2"},
    ]
    again = create_app(project, PlayedLauncher(), token="right")
    with TestClient(again, base_url=BASE, headers={"origin": BASE}) as later:
        later.get("/?token=right")
        assert later.get("/api/desk").json()["breakpoints"] == shown


def test_breakpoints_follow_a_rename_and_its_undo(page: TestClient) -> None:
    tiny = "tasks/tiny.yaml"
    page.post("/api/breakpoints", json={"task": tiny, "breakpoints": [{"node": "machine/a"}], "page": "one"})

    def now() -> list[str]:
        with page.websocket_connect(SOCKET) as socket:
            shown = until(socket, lambda f: f["type"] == "desk")["desk"]["breakpoints"]
        return [point["node"] for point in shown[tiny]]

    def edit(what: str, **request: Any) -> None:
        base = page.get("/api/document", params={"path": tiny}).json()["revision"]
        assert page.post(f"/api/document/{what}", json={"path": tiny, "base": base, **request}).status_code == 200

    edit("edit", command={"do": "rename", "path": "machine", "name": "steps"})
    assert now() == ["steps/a"]
    edit("edit", command={"do": "remove", "path": "steps/a"})
    edit("step", step="undo")
    edit("step", step="undo")
    assert now() == ["machine/a"]


def test_a_breakpoint_that_is_taken_back_is_cleared_in_the_run(page: TestClient, launcher: PlayedLauncher) -> None:
    request = {"task": "tasks/tiny.yaml", "breakpoints": [{"node": "first"}]}
    with page.websocket_connect(SOCKET) as socket:
        page.post("/api/breakpoints", json=request)
        started(page, socket)
        page.post("/api/breakpoints", json={**request, "breakpoints": []})
    assert launcher.last is not None
    assert launcher.last.heard[-1] == {"command": "clear", "id": 1}


@pytest.mark.parametrize(
    "change", [{"when": "before"}, {"node": ""}, {"when": "never"}, {"outcome": "x" * 201}, {"condition": "x" * 2001}]
)
def test_a_breakpoint_that_makes_no_sense_is_refused(page: TestClient, change: dict[str, str]) -> None:
    request = {"task": "tasks/tiny.yaml", "breakpoints": [{**POINT, **change}]}
    assert page.post("/api/breakpoints", json=request).status_code == 422


def test_breakpoints_that_cannot_be_read_are_left_out_and_the_server_starts(project: Path) -> None:
    (project / ".grip").mkdir()
    (project / ".grip" / "breakpoints.json").write_text('{"tasks/tiny.yaml": [{"node": 3}]}')
    with TestClient(create_app(project, PlayedLauncher(), token="t"), base_url=BASE) as client:
        client.get("/?token=t")
        assert client.get("/api/desk").json()["breakpoints"] == {}


@pytest.mark.parametrize("how", ["tick", "in", "over", "out"])
def test_a_step_says_how_and_where_the_run_holds_is_told(page: TestClient, launcher: PlayedLauncher, how: str) -> None:
    with page.websocket_connect(SOCKET) as socket:
        started(page, socket)
        told(page, "step", how=how)
        view = until(socket, in_state("paused"))["session"]
        assert (view["held"]["path"], view["held"]["when"]) == ("first", "before")
        told(page, "resume")
        assert until(socket, in_state("running"))["session"]["held"] is None
    assert launcher.last is not None
    assert {"command": "step", "how": how} in launcher.last.heard


@pytest.mark.parametrize("body", [{"command": "run_to"}, {"command": "pause", "node": "first"}, {"command": "clear"}])
def test_a_command_without_its_place_is_refused(page: TestClient, body: dict[str, str]) -> None:
    page.post("/api/session", json=WISH)
    assert page.post("/api/session/control", json=body).status_code == 422


def test_what_the_run_refuses_is_told_to_people(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as socket:
        started(page, socket)
        told(page, "run_to", node="nowhere")
        assert (
            "nowhere"
            in until(socket, lambda f: f["type"] == "session" and f["session"]["message"])["session"]["message"]
        )


def test_a_run_from_a_node_passes_over_what_comes_before_it(page: TestClient, launcher: PlayedLauncher) -> None:
    answer = page.post("/api/session", json={**WISH, "begin_at": "machine/b", "run_to": "machine/b"})
    assert answer.json()["mocks"] == {"first": "success", "machine/a": "success"}
    assert launcher.last is not None
    assert launcher.last.heard == [{"command": "run_to", "node": "machine/b"}]
    assert launcher.started[0][1].mocks["first"] == "success"


def test_a_run_cannot_begin_where_nothing_leads(page: TestClient, project: Path) -> None:
    text = (project / "tasks" / "tiny.yaml").read_text().replace("on: {success: b}", "on: {success: success}")
    (project / "tasks" / "tiny.yaml").write_text(text)
    answer = page.post("/api/session", json={**WISH, "begin_at": "machine/b"})
    assert answer.status_code == 400
    assert "no way leads there" in answer.json()["detail"]
    unknown = page.post("/api/session", json={**WISH, "begin_at": "machine/x"})
    assert (unknown.status_code, "machine/a" in unknown.json()["detail"]) == (404, True)


def test_a_run_can_be_started_on_every_robot_that_is_offered(page: TestClient) -> None:
    for robot in page.get("/api/project").json()["robots"]:
        assert page.post("/api/session", json={**WISH, "robot": robot}).json()["robot"] == robot
        told(page, "stop")


# --- who holds control ---


def test_one_page_controls_and_another_may_look_stop_and_take_over(page: TestClient) -> None:
    with page.websocket_connect(SOCKET + "?page=one") as one, page.websocket_connect(SOCKET + "?page=two") as two:
        assert page.post("/api/session", json={**WISH, "page": "one"}).status_code == 201
        assert until(two, lambda f: f["type"] == "desk" and f["desk"]["holder"])["desk"]["holder"] == "one"
        refused = page.post("/api/session/control", json={"command": "pause", "page": "two"})
        assert (refused.status_code, refused.json()["kind"]) == (409, "held")
        assert page.post("/api/lease", json={"page": "two"}).status_code == 409
        assert page.post("/api/lease", json={"page": "two", "over": True}).json()["holder"] == "two"
        until(one, held_by("two"))
        assert page.post("/api/session/control", json={"command": "pause", "page": "two"}).status_code == 200
        stopped = page.post("/api/session/control", json={"command": "stop", "page": "one"})
        assert stopped.json()["status"] == "stopped"


def test_control_is_free_again_when_its_page_has_gone_and_not_before(
    page: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pages_module, "GRACE", 0.5)
    with page.websocket_connect(SOCKET + "?page=watcher") as watcher:
        with page.websocket_connect(SOCKET + "?page=one"):
            page.post("/api/lease", json={"page": "one"})
            until(watcher, held_by("one"))
        with page.websocket_connect(SOCKET + "?page=one") as back:  # a reload
            assert until(back, lambda f: f["type"] == "desk")["desk"]["holder"] == "one"
        until(watcher, held_by(None))


def test_control_can_be_given_back(page: TestClient) -> None:
    page.post("/api/lease", json={"page": "one"})
    assert page.post("/api/lease", json={"page": "one", "take": False}).json()["holder"] is None
    assert page.post("/api/lease", json={"page": "not/one"}).status_code == 422


def test_a_connection_that_ends_as_news_come_stops_sending() -> None:
    class Quiet(stream_module.ClientConnection):
        def __init__(self) -> None:
            self._changed, self._run, self._complete = asyncio.Event(), "run", False

    async def cancelled_with_news() -> bool:
        viewer = Quiet()
        waiting = asyncio.create_task(viewer._wait())
        await asyncio.sleep(0)
        viewer._changed.set()
        waiting.cancel()
        await asyncio.wait([waiting])
        return waiting.cancelled()

    assert asyncio.run(cancelled_with_news())
