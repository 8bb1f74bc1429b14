"""The simulator's side of the conversation, run in this process, so that simulated time can be told exactly."""

from __future__ import annotations

import itertools
import socket
import threading
from dataclasses import replace

import numpy as np
import pytest
from sim_bench import SPEC

from grip_bt.commanders.description.load import build_robot
from grip_sim.connection import ClosedError, pack, receive

pytestmark = pytest.mark.sim
ARM = list(build_robot("panda_allegro").group("arm"))


@pytest.fixture
def ends():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        yield ours, theirs


@pytest.fixture
def make_server(ends):
    from grip_sim.server import Server

    return lambda pace=None: Server(ends[1], SPEC, pace)


def answers(server, ends):
    """Let the server obey what was sent until the end of the stream, and return its answers by number."""
    server.serve()
    ends[1].shutdown(socket.SHUT_WR)
    got = {}
    while True:
        try:
            fields = receive(ends[0])
        except ClosedError:
            return got
        got[fields["id"]] = fields


def arm_way(server, by=0.5, duration=2.0):
    start = server.world.robot.positions()[server.world.robot.rows(ARM)]
    times = np.linspace(0, duration, 41)
    return {"times": times, "positions": start + by * (times / duration)[:, None]}


def at_step(server, monkeypatch, when, do):
    """Call `do` after so many steps."""
    steps, step = itertools.count(1), server.world.step

    def stepped():
        step()
        if next(steps) == when:
            do()

    monkeypatch.setattr(server.world, "step", stepped)


@pytest.mark.parametrize("when", [101, 102, 103, 104])
@pytest.mark.parametrize(
    "call", [{"call": "stop", "names": ARM}, {"call": "cancel", "motion": 1}], ids=["stop", "cancel"]
)
def test_a_stop_takes_effect_within_20_ms_of_simulated_time_by_a_ramp(make_server, ends, monkeypatch, when, call):
    server, ours = make_server(), ends[0]
    rows, pace, asked = server.world.robot.rows(ARM), [], []

    def stop():
        asked.append(server.world.time)
        ours.sendall(pack({"id": 2, **call}))

    def look():
        pace.append(server.world.robot.kept()["speeds"][rows])

    for step in range(when, when + 240):
        at_step(server, monkeypatch, step, look)
    at_step(server, monkeypatch, when, stop)
    at_step(server, monkeypatch, when + 240, lambda: ours.shutdown(socket.SHUT_WR))
    ours.sendall(pack({"id": 1, "call": "follow", "names": ARM, **arm_way(server, 2.0)}))
    ours.sendall(pack({"id": 3, "call": "wait", "seconds": 60.0}))
    got = answers(server, ends)
    fields = got[1]
    limits = server.world.robot.accelerations(rows)
    needed = (np.abs(pace[0]) / limits).max()
    assert fields["error"] == "canceled"
    assert "data" not in fields or fields["data"] == {}
    assert np.abs(fields["velocity"]).max() < 0.05, "it is over when the joints are at rest"
    assert needed - 0.01 <= fields["time"] - asked[0] <= needed + 0.020 + 0.15
    moving = np.array(pace)
    assert (np.abs(moving[6]) < np.abs(moving[0])).all(), "braking has begun within 20 ms"
    assert (np.abs(np.diff(moving, axis=0)) * 240 / limits).max() < 1.05, "by a ramp"
    assert np.abs(moving[-1]).max() == 0.0


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        ({"call": "no such call"}, "no such call"),
        ({"call": "state", "names": ["elbow"]}, "elbow"),
        ({"call": "state"}, "names"),
        ({"call": "look", "camera": "nowhere"}, "overhead"),
        (
            {"call": "move_object", "name": "thing", "position": [0, 0, float("nan")], "quaternion": [1, 0, 0, 0]},
            "finite",
        ),
    ],
)
def test_a_wrong_call_is_refused_and_the_next_is_answered(make_server, ends, call, reason):
    server, ours = make_server(), ends[0]
    ours.sendall(pack({"id": 1, **call}) + pack({"id": 2, "call": "fingerprint"}))
    ours.shutdown(socket.SHUT_WR)
    got = answers(server, ends)
    assert got[1]["error"] == "refused"
    assert reason in got[1]["message"]
    assert got[2]["fingerprint"] == server.world.fingerprint()


def test_a_motion_that_makes_no_sense_does_not_end_the_one_under_way(make_server, ends, monkeypatch):
    server, ours = make_server(), ends[0]
    wrong = {"times": np.array([0.0, 1.0]), "positions": np.zeros(3)}
    at_step(server, monkeypatch, 8, lambda: ours.sendall(pack({"id": 2, "call": "follow", "names": ARM, **wrong})))
    at_step(server, monkeypatch, 40, lambda: ours.shutdown(socket.SHUT_WR))
    ours.sendall(pack({"id": 1, "call": "follow", "names": ARM, **arm_way(server)}))
    got = answers(server, ends)
    assert got[2]["error"] == "refused"
    assert 1 not in got  # still under way when the client went


def test_physics_stands_still_while_nothing_is_under_way(make_server, ends):
    server, ours = make_server(), ends[0]
    before = server.world.fingerprint()
    for number in range(5):
        ours.sendall(pack({"id": number + 1, "call": "state", "names": ARM}))
    ours.shutdown(socket.SHUT_WR)
    assert all(fields["time"] == 0 for fields in answers(server, ends).values())
    assert server.world.fingerprint() == before


def test_at_a_pace_physics_is_not_faster_however_many_questions_come(make_server, ends, monkeypatch):
    from grip_sim import server as module

    class Wall:
        now = 0.0

        def monotonic(self):
            return self.now

    wall, real, ours = Wall(), module.select.select, ends[0]
    server = make_server(pace=2.0)
    questions = itertools.count(10)

    def asked(readers, writers, errors, timeout):
        """A question is always there after a millisecond, as from somebody who polls."""
        while real([ours], [], [], 0)[0]:
            receive(ours)
        if next(questions) < 600:
            wall.now += 0.001 if timeout else 0.0
            if timeout is None or timeout > 0.001:
                ours.sendall(pack({"id": 5, "call": "stop", "names": []}))
            return real(readers, writers, errors, 0)
        ours.shutdown(socket.SHUT_WR)
        return real(readers, writers, errors, 1)

    monkeypatch.setattr(module, "time", wall)
    monkeypatch.setattr(module.select, "select", asked)  # restored before anybody else waits
    ours.sendall(pack({"id": 1, "call": "wait", "seconds": 1000.0}))
    answers(server, ends)
    assert wall.now > 0.2
    assert 0.85 * 2.0 * wall.now < server.world.time < 2.0 * wall.now + 0.02


def test_a_controller_that_aborts_ends_its_motion_and_the_client_is_told_why(ends):
    from grip_sim.faults import Fault
    from grip_sim.server import Server

    spec = replace(SPEC, faults={"stop": Fault(fault="abort", of="arm", at=0.5)})
    server = Server(ends[1], spec, None)
    way = arm_way(server)
    ends[0].sendall(pack({"id": 1, "call": "follow", "names": ARM, **way}))
    ends[0].sendall(pack({"id": 2, "call": "wait", "seconds": 3.0}))
    got, told = {}, []
    ends[0].settimeout(None)
    thread = threading.Thread(target=server.serve)
    thread.start()
    while 2 not in got:
        fields = receive(ends[0])
        got[fields["id"]] = fields
        told += [fields["fault"]] if "fault" in fields else []
    ends[0].shutdown(socket.SHUT_WR)
    thread.join()
    assert told == [("stop", "abort of arm", False)]
    assert got[1]["error"] == "aborted"
    assert got[1]["message"] == "the controller has aborted (fault 'stop')"
    assert got[1]["time"] == pytest.approx(0.5, abs=0.01)
