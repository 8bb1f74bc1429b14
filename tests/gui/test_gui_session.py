"""Runs through the server: started, watched, controlled, and ended whatever they do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conftest import EVENTS, SOCKET, PlayedLauncher, TestClient, record

from grip_gui import session as session_module
from grip_gui.stream import STRIKES

WISH = {"task": "tasks/tiny.yaml", "robot": "fake", "target": "sm", "seed": 7, "pace": 2.5}


def until(socket: Any, wanted: Any) -> dict[str, Any]:
    """Return the first frame that `wanted` accepts."""
    while True:
        frame: dict[str, Any] = socket.receive_json()
        if wanted(frame):
            return frame


def in_state(state: str) -> Any:
    return lambda f: f["type"] == "session" and f["session"] is not None and f["session"]["state"] == state


def is_events(frame: dict[str, Any]) -> bool:
    return frame["type"] == "events"


def test_a_run_is_started_with_the_options_of_the_page(
    page: TestClient, launcher: PlayedLauncher, project: Path
) -> None:
    answer = page.post("/api/session", json=WISH)
    assert answer.status_code == 201
    file, options = launcher.started[0]
    assert file == project / "tasks" / "tiny.yaml"
    assert options.arguments() == ("--robot", "fake", "--seed", "7", "--as", "sm", "--pace", "2.5")


def test_events_are_streamed_from_the_wanted_number_on(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as socket:
        page.post("/api/session", json=WISH)
        run = until(socket, in_state("running"))["session"]["run"]
        socket.send_json({"type": "subscribe", "run": run, "from_seq": 3})
        frame = until(socket, is_events)
        assert [event["seq"] for event in frame["events"]] == list(range(3, len(EVENTS) + 1))
        assert frame["events"][1]["data"]["preview"] == "1"
        assert frame["complete"] is False


def test_pause_resume_and_stop_reach_the_run_and_come_back(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as socket:
        page.post("/api/session", json=WISH)
        run = until(socket, in_state("running"))["session"]["run"]
        page.post("/api/session/control", json={"command": "pause"})
        until(socket, in_state("paused"))
        page.post("/api/session/control", json={"command": "resume"})
        until(socket, in_state("running"))
        socket.send_json({"type": "subscribe", "run": run, "from_seq": 0})
        until(socket, is_events)
        answer = page.post("/api/session/control", json={"command": "stop"}).json()
        assert (answer["state"], answer["status"]) == ("ended", "stopped")
        last = until(socket, lambda f: is_events(f) and f["complete"])
        assert last["events"][-1]["event"] == "run_ended"


def test_a_run_that_does_not_answer_stop_is_killed_and_the_page_says_so(
    page: TestClient, launcher: PlayedLauncher, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_module, "ACKNOWLEDGE", 0.05)
    launcher.deaf = True
    page.post("/api/session", json=WISH)
    answer = page.post("/api/session/control", json={"command": "stop"}).json()
    assert launcher.last is not None
    assert launcher.last.killed
    assert answer["status"] == "killed"
    assert "did not answer STOP" in answer["message"]


def test_the_death_of_a_run_is_noticed_and_told(page: TestClient, launcher: PlayedLauncher) -> None:
    launcher.dies = True
    with page.websocket_connect(SOCKET) as socket:
        page.post("/api/session", json=WISH)
        view = until(socket, in_state("ended"))["session"]
        assert view["status"] == "died"
        assert "exit status 70" in view["message"]
        assert "something broke" in view["message"]
        socket.send_json({"type": "subscribe", "run": view["run"], "from_seq": 0})
        assert until(socket, is_events)["complete"] is True


def test_one_run_at_a_time(page: TestClient) -> None:
    assert page.post("/api/session", json=WISH).status_code == 201
    second = page.post("/api/session", json=WISH)
    assert second.status_code == 409
    assert "stop it" in second.json()["detail"]
    page.post("/api/session/control", json={"command": "stop"})
    assert page.post("/api/session", json=WISH).status_code == 201


def test_a_command_without_a_run_is_refused(page: TestClient) -> None:
    assert page.post("/api/session/control", json={"command": "pause"}).status_code == 409


def test_all_viewers_see_the_same_and_any_may_stop(page: TestClient) -> None:
    with page.websocket_connect(SOCKET) as one, page.websocket_connect(SOCKET) as two:
        page.post("/api/session", json=WISH)
        assert until(one, in_state("running")) == until(two, in_state("running"))
        page.post("/api/session/control", json={"command": "stop"})
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
    from grip_gui.application import create_app
    from grip_gui.launcher import RunOptions

    app = create_app(project, launcher, token="t", task="tasks/tiny.yaml", autostart=RunOptions("fake"))
    with TestClient(app):
        assert launcher.last is not None
    assert launcher.last.said == ["stop"]
