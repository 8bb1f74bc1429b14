"""`grip replay` shows a run of the journal again, event by event, and what it was like at a place."""

import io
import json
import threading
from types import SimpleNamespace

import pytest

from grip_bt.app.runs.replay import Until, events_of, replay
from grip_bt.cli.__main__ import main
from grip_bt.runtime import Event, Journal, JournalReader

TASK = """\
grip: 1
name: mended
data: {reached: {type: int, value: 0}}
root:
  kind: fallback
  children:
    broken: {node: flow/fail, with: {code: no_plan, message: the way is blocked}}
    second: {node: flow/set, with: {value: 7}, out: {value: reached}}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch, capsys):
    """A project with one run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mended.yaml").write_text(TASK)
    assert main(["run", "mended.yaml", "--in-process"]) == 0
    capsys.readouterr()
    return tmp_path


def test_every_event_is_shown_in_order_with_what_it_says(folder, capsys):
    assert main(["replay", "last"]) == 0
    lines = capsys.readouterr().out.splitlines()
    with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
        events = reader.events(reader.runs()[0].id)
    assert [int(line.split()[0]) for line in lines[: len(events)]] == [event.seq for event in events]
    text = "\n".join(lines)
    assert "✗ broken failure.no_plan (the way is blocked)" in text
    assert "= second reached = 7" in text
    assert lines[-2:] == [
        f"after event {len(events)}, at {events[-1].t:.3f} s: success; running: nothing",
        "  reached = 7",
    ]


def test_a_replay_ends_at_a_node_and_says_what_runs_there(folder, capsys):
    assert main(["replay", "last", "--until", "broken:failure.no_plan"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2].endswith("✗ broken failure.no_plan (the way is blocked)")
    assert lines[-1].endswith("running; running: /")
    assert main(["replay", "last", "--until", "3"]) == 0
    assert "after event 3" in capsys.readouterr().out


def test_a_place_that_the_run_never_reaches_lists_where_it_was(folder, capsys):
    assert main(["replay", "last", "--until", "brokn"]) == 1
    said = capsys.readouterr()
    assert "unknown place in the run 'brokn'; did you mean 'broken'?" in said.err
    assert not said.out  # nothing is shown first


def test_an_unknown_run_lists_the_nearest(folder, capsys):
    assert main(["replay", "1999"]) == 1
    with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
        assert f"unknown run '1999' (available: {reader.runs()[0].id})" in capsys.readouterr().err


def test_without_runs_a_replay_says_what_to_do(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["replay", "last"]) == 1
    assert "there are no runs yet; give --journal FILE, or run a task" in capsys.readouterr().err


def test_json_has_an_event_a_line_as_in_the_journal(folder, capsys):
    assert main(["replay", "last", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["seq"] for line in lines] == list(range(1, len(lines) + 1))
    assert lines[0]["event"] == "run_started"
    assert lines[-1]["data"]["status"] == "success"


def test_a_step_waits_for_enter_and_q_ends(folder, capsys, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("\n\nq\n"))
    assert main(["replay", "last", "--step"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 3


def test_the_speed_divides_the_times_of_the_run(monkeypatch):
    now, waited = [100.0], []

    def sleep(seconds):
        waited.append(seconds)
        now[0] += seconds

    monkeypatch.setattr("grip_bt.app.runs.replay.time", SimpleNamespace(monotonic=lambda: now[0]))
    events = [Event(i + 1, t, t, "a", "enter", None, None, {}) for i, t in enumerate((5.0, 6.0, 9.0))]
    replay(iter(events), lambda *_: None, speed=2.0, sleep=sleep)
    assert waited == pytest.approx([0.5, 1.5]), "the run's own first moment is shown at once"


def test_a_run_under_way_is_followed_to_its_end(tmp_path):
    with Journal(tmp_path / "runs.sqlite") as journal:
        log = journal.begin("task")
        log.append(0.0, "/", "enter")
        journal.flush()
        seen, first = [], threading.Event()

        def show(event, moment):
            seen.append(event.event)
            first.set()

        with JournalReader(journal.file) as reader:
            watcher = threading.Thread(target=replay, args=(events_of(reader, log.id), show))
            watcher.start()
            assert first.wait(120)
            log.append(1.0, "/", "exit", "success")
            log.end("success", "success")
            watcher.join(120)
            assert not watcher.is_alive()
    assert seen == ["enter", "exit"]


@pytest.mark.parametrize(
    ("text", "seq"),
    [("2", 2), ("a", 3), ("/a", 3), ("a:enter", 1), ("a:failure", 3), ("a:failure.x", 3), ("a:success", None)],
)
def test_places_are_numbers_nodes_and_ends_of_nodes(text, seq):
    events = [
        Event(1, 0, 0, "a", "enter", None, None, {}),
        Event(2, 0, 0, "a", "message", None, None, {}),
        Event(3, 0, 0, "a", "exit", "failure", "x", {}),
    ]
    until = Until(text)
    assert next((event.seq for event in events if until.reached(event)), None) == seq


def test_the_page_begins_with_the_run_that_is_replayed(folder):
    testing = pytest.importorskip("fastapi.testclient")
    from grip_gui.server import create_app

    with JournalReader(folder / ".grip" / "runs.sqlite") as reader:
        record = reader.runs()[0]
    app = create_app(folder, token="t", show_run=record.id)
    with testing.TestClient(app, base_url="http://127.0.0.1:8765") as client:
        client.get("/?token=t")
        with client.websocket_connect(
            "ws://127.0.0.1:8765/api/socket", headers={"origin": "http://127.0.0.1:8765"}
        ) as socket:
            session = socket.receive_json()["session"]
            assert (session["run"], session["state"], session["status"]) == (record.id, "ended", "success")


def test_a_run_that_was_gone_on_with_says_so_and_what_ran_runs_on():
    from grip_bt.app.runs.replay import line_of
    from grip_bt.runtime import RunSnapshot

    def event(seq, path, kind, **data):
        return Event(seq, float(seq), 0.0, path, kind, None, None, data)

    events = [
        event(1, "a", "enter"),
        event(2, "a", "kept", part="scene", preview="..."),
        event(3, "a", "error", type="ProcessDied", message="SIGKILL"),
        event(4, "/", "run_ended", status="error"),
        event(5, "/", "run_resumed", restored={"scene": 2}),
        event(6, "a", "went_on", how="restart"),
    ]
    moment = RunSnapshot()
    for each in events[:4]:
        moment.apply(each)
    assert (moment.state, moment.nodes["a"].phase) == ("error", "error")
    for each in events[4:]:
        moment.apply(each)
    assert (moment.state, moment.nodes["a"].phase, moment.nodes["a"].message) == ("running", "running", "")
    said = [line_of(each) for each in events]
    assert said[1].endswith("a saved the scene for resuming")
    assert said[4].endswith("/ continues in another process; restored: scene")
    assert said[5].endswith("a is started again")
