"""Our side of the conversation, against a simulator's part that is played by the test."""

from __future__ import annotations

import select
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from patience import PATIENCE, until

from grip_bt.base.errors import GripError, SimulatorLostError
from grip_bt.base.failures import CanceledError, ExecutionAbortedError
from grip_sim import client as client_module
from grip_sim import connection
from grip_sim.client import SimClient
from grip_sim.connection import ClosedError, pack, receive
from grip_sim.specs import WorldSpec


class Played:
    """Stands for the process: the test reads what was asked and answers."""

    pid = 4711
    spec = None

    def __init__(self, connection, hold=None):
        self.connection = connection.dup()
        self.ended = 0
        threading.Thread(target=self.make_world).start()

    def make_world(self):
        fields = self.asked()
        self.spec = fields["spec"]
        self.answer(fields["id"])

    def answer(self, number, /, **fields):
        self.connection.sendall(pack({"time": 0.0, "id": number, **fields}))

    def asked(self):
        return receive(self.connection)

    def end(self, patience):
        self.ended += 1
        return 7

    def last_words(self):
        return "what it printed"

    def close(self):
        self.connection.close()


@pytest.fixture
def client(monkeypatch):
    monkeypatch.setattr(client_module, "SimProcess", Played)
    made = SimClient(WorldSpec())
    made.played = made._process
    assert WorldSpec.from_json(made.played.spec) == WorldSpec()
    yield made
    made.close()


def ended(operation):
    assert operation.wait(PATIENCE)
    return operation


def test_answers_go_to_whom_they_belong_in_any_order(client):
    one, two = client.request("a"), client.request("b")
    first, second = client.played.asked(), client.played.asked()
    assert (first["call"], second["call"]) == ("a", "b")
    client.played.answer(second["id"], said="two")
    client.played.answer(first["id"], x=np.arange(3), said="one")
    assert ended(two).result().fields["said"] == "two"
    assert ended(one).result().fields["said"] == "one"
    assert one.result().fields["x"].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("error", "kind"), [("aborted", ExecutionAbortedError), ("canceled", CanceledError), ("refused", GripError)]
)
def test_errors_end_an_operation_as_what_they_are(client, error, kind):
    operation = client.move("follow")
    client.played.answer(client.played.asked()["id"], error=error, message="why")
    with pytest.raises(kind, match="why"):
        ended(operation).result()


def test_callbacks_may_ask_again_and_wait_for_the_answer(client):
    said = []
    operation = client.move("follow")
    operation.add_done_callback(lambda: said.append(client.ask("contacts").fields["contacts"]))
    client.played.answer(client.played.asked()["id"])
    question = client.played.asked()
    assert question["call"] == "contacts"
    second = client.request("later")
    client.played.answer(question["id"], contacts={"tip": 1.0})
    client.played.answer(client.played.asked()["id"])
    ended(second)
    assert said == [{"tip": 1.0}]


def play(client):
    """Answer each call by how many came; a world that goes stands again at once. Return the calls."""
    calls = []

    def run():
        try:
            while True:
                fields = client.played.asked()
                calls.append(fields["call"])
                if fields["call"] == "go":
                    client.played.answer(0, stands=True)
                elif fields["id"]:
                    client.played.answer(fields["id"], count=len(calls))
        except ClosedError:
            pass

    threading.Thread(target=run, daemon=True).start()
    return calls


def test_while_the_world_stands_a_question_is_asked_once_and_again_after_whatever_may_have_changed_its_answer(client):
    play(client)
    stood = threading.Semaphore(0)

    def asked(call="state", **fields):
        return client.ask(call, **fields).fields["count"]

    def gone():
        client.go(None)
        assert stood.acquire(timeout=PATIENCE)

    assert asked() != asked()  # it goes by itself
    client.take_turns(lambda operation, holds: operation, stood.release)
    gone()
    sent = client.sent
    assert asked(names=["a"]) == asked(names=["a"]) != asked(names=["b"])
    assert client.sent == sent, "what changes nothing ends no motion"
    changes = (gone, lambda: client.ask("move_object"), lambda: ended(client.move("follow")))
    for change in (*changes, client.go_freely):
        before = asked()
        change()
        assert asked() != before
    assert client.sent == sent + 2
    assert asked() != asked()


def test_a_callback_that_raises_keeps_no_other_operation_from_ending(client, caplog):
    one, two = client.request("a"), client.request("b")
    one.add_done_callback(lambda: 1 / 0)
    for _ in range(2):
        client.played.answer(client.played.asked()["id"])
    ended(two)
    assert "ZeroDivisionError" in caplog.text


def test_cancelling_asks_the_simulator_and_ends_when_it_says_so(client):
    operation = client.move("follow")
    number = client.played.asked()["id"]
    operation.cancel()
    asked = client.played.asked()
    assert (asked["call"], asked["motion"]) == ("cancel", number)
    assert not operation.done()
    client.played.answer(number, error="canceled", message="stopped")
    with pytest.raises(CanceledError):
        ended(operation).result()


def test_when_the_connection_ends_pending_and_later_operations_fail_with_what_it_printed(client):
    pending = [client.request("a"), client.move("follow")]
    client.played.connection.close()
    for operation in pending:
        with pytest.raises(SimulatorLostError, match=r"process 4711 is gone .*exit status 7.*what it printed"):
            ended(operation).result()
    for later in (lambda: client.ask("state"), lambda: ended(client.move("follow")).result()):
        with pytest.raises(SimulatorLostError):
            later()


def test_what_nobody_understands_ends_the_connection_and_the_process(client):
    operation = client.request("a")
    client.played.asked()
    client.played.connection.sendall(b"\xff" * 64)
    with pytest.raises(SimulatorLostError):
        ended(operation).result()
    assert client.played.ended
    with pytest.raises(ClosedError):
        client.played.asked()


def test_a_simulator_that_owes_an_answer_and_says_nothing_is_lost(client, monkeypatch):
    monkeypatch.setattr(client_module, "SILENCE", 0.05)
    operation = client.request("a")
    client.played.asked()
    client.played.answer(0)  # the reader waits anew, now with the short patience
    with pytest.raises(SimulatorLostError, match="said nothing for"):
        ended(operation).result()


def test_what_is_asked_for_at_the_end_of_a_long_silence_is_not_late(client, monkeypatch):
    asked = []

    def silence(*given):
        if asked:
            return select.select(*given)
        asked.append(client.request("a"))
        return [], [], []

    monkeypatch.setattr(client_module, "select", SimpleNamespace(select=silence))
    client.played.answer(0)  # the reader waits anew
    client.played.answer(client.played.asked()["id"])
    until(lambda: asked)
    ended(asked[0]).result()


def test_after_closing_everything_fails_and_closing_again_is_harmless(client):
    pending = client.move("follow")
    client.close()
    client.close()
    for operation in (pending, client.request("a")):
        with pytest.raises(SimulatorLostError, match="was closed"):
            operation.result()


def test_a_callback_may_close(client):
    closed = threading.Event()
    operation = client.request("a")
    operation.add_done_callback(lambda: (client.close(), closed.set()))
    client.played.answer(client.played.asked()["id"])
    assert closed.wait(PATIENCE)


def test_an_answer_that_arrives_while_it_is_closed_ends_its_operation_all_the_same(client):
    operations = [client.request("a") for _ in range(200)]
    for _ in operations:
        client.played.answer(client.played.asked()["id"])
    client.close()
    assert all(operation.wait(PATIENCE) for operation in operations)


def test_full_pipes_in_both_directions_do_not_lock_each_other(client):
    big = {"x": np.zeros(1 << 20)}
    look = client.request("look")
    asked = client.played.asked()["id"]
    sender = threading.Thread(target=lambda: client.move("follow", **big))
    sender.start()  # fills the pipe to the simulator, which sends before it reads
    client.played.answer(asked, **big)
    assert ended(look).result().fields["x"].size == 1 << 20
    client.played.asked()
    sender.join(10)
    assert not sender.is_alive()


def test_the_clock_stands_while_something_moves_and_goes_on_when_it_can_not_be_sent(client, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(connection, "LARGEST", 1000)
        with pytest.raises(ValueError, match="can be sent"):
            client.move("follow", x=np.zeros(1000))
    assert client.clock._moving == 0
    operation = client.move("follow")
    still = client.clock.now()
    assert client.clock.now() == still
    client.played.connection.close()
    ended(operation)
    assert client.clock._moving == 0
