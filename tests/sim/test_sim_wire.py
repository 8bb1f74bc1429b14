"""The wire: what is packed is received, and what can't be trusted is refused."""

from __future__ import annotations

import json
import socket
import struct
import threading
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_sim import connection
from grip_sim.connection import ClosedError, pack, receive


@contextmanager
def pair():
    one, two = socket.socketpair()
    with one, two:
        yield one, two


def sent(data: bytes):
    """Return what is received when `data` is sent and then the stream ends."""
    with pair() as (one, two):
        writer = threading.Thread(target=lambda: (one.sendall(data), one.shutdown(socket.SHUT_WR)))
        writer.start()
        try:
            return receive(two)
        finally:
            two.close()
            writer.join()


def raw(content) -> bytes:
    text = content if isinstance(content, bytes) else json.dumps(content).encode() + b"\n"
    return struct.pack("!I", len(text)) + text


@pytest.mark.parametrize("dtype", ["<f8", "<f4", "<i8", "|u1", "|b1"])
@pytest.mark.parametrize("shape", [(), (0, 7), (3,), (20, 30, 3)])
def test_a_message_arrives_as_it_was_packed(dtype, shape):
    array = np.ones(shape, dtype)
    got = sent(pack({"call": "state", "names": ["a"], "rate": 0.1, "what": None, "a": array, "turned": array.T}))
    assert (got["call"], got["names"], got["rate"], got["what"]) == ("state", ["a"], 0.1, None)
    assert (got["a"].dtype, got["a"].shape, got["turned"].shape) == (array.dtype, shape, shape[::-1])
    assert got["a"].tobytes() == array.tobytes()
    assert not got["a"].flags.writeable


def test_messages_follow_one_another():
    with pair() as (one, two):
        one.sendall(pack({"n": 1, "a": np.ones(3)}) + pack({"n": 2}))
        assert receive(two)["n"] == 1
        assert receive(two) == {"n": 2}


@given(st.data())
@settings(deadline=None)
def test_a_stream_that_ends_within_a_message_is_closed(data):
    whole = pack({"call": "state", "a": np.arange(50.0)})
    with pytest.raises(ClosedError):
        sent(whole[: data.draw(st.integers(0, len(whole) - 1))])


def test_an_oversized_message_is_refused_before_it_is_read():
    with pytest.raises(ClosedError, match="a message of"):
        sent(struct.pack("!I", connection.LARGEST + 1))


def test_an_oversized_message_is_not_sent(monkeypatch):
    monkeypatch.setattr(connection, "LARGEST", 1000)
    with pytest.raises(ValueError, match="at most 1000"):
        pack({"a": np.zeros(1000)})


@pytest.mark.parametrize("value", [np.array([{}]), object(), threading.Lock()])
def test_what_only_its_own_process_can_hold_is_not_received(value):
    with pytest.raises(ClosedError, match="can't be restored"):
        sent(pack({"a": value}))


@pytest.mark.parametrize(
    "message",
    [
        raw(b"{"),
        raw(b"\xff\xfe"),
        raw([1]),
        raw(b"[" * 200_000),
        raw({"a": {"$unknown": 1}}),
        raw({"a": {"$array": ["O", [1], 0]}}),
        raw({"a": {"$array": ["no such type", [1], 0]}}),
        raw({"a": {"$array": ["<f8", [2], 0]}}),
        raw({"a": {"$value": []}}),
    ],
    ids=["no json", "no text", "no fields", "deep", "unknown", "objects", "unknown type", "too short", "no value"],
)
def test_what_is_no_message_closes_the_connection(message):
    with pytest.raises(ClosedError, match="can't be read"):
        sent(message)


def test_a_closed_socket_is_closed():
    with pair() as (one, two):
        two.close()
        with pytest.raises(ClosedError):
            receive(two)
        one.close()
