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
from hypothesis.extra import numpy as arrays_of

from grip_sim import connection
from grip_sim.connection import ClosedError, pack, receive

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)
NUMBERS = st.sampled_from(["<f8", ">f8", "<f4", "<i8", "<u2", "|u1", "|b1", "<c16"]).map(np.dtype)
SHAPES = arrays_of.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5)
ARRAYS = st.dictionaries(st.text(), arrays_of.arrays(NUMBERS, SHAPES), max_size=3)


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


def raw(header, body=b"") -> bytes:
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return struct.pack("!II", len(text), len(body)) + text + body


@given(st.dictionaries(st.text(), JSON, max_size=4), ARRAYS)
@settings(deadline=None)
def test_a_message_arrives_as_it_was_packed(fields, arrays):
    got_fields, got = sent(pack(fields, arrays))
    assert got_fields == fields
    assert got.keys() == arrays.keys()
    for name, array in arrays.items():
        assert got[name].dtype == array.dtype
        assert got[name].shape == array.shape
        assert got[name].tobytes() == array.tobytes()


def test_arrays_without_elements_or_without_axes_keep_their_shape():
    _, got = sent(pack({}, {"none": np.zeros((0, 7)), "one": np.array(3.5), "after": np.arange(3)}))
    assert got["none"].shape == (0, 7)
    assert got["one"].shape == ()
    assert got["one"] == 3.5
    assert got["after"].tolist() == [0, 1, 2]


def test_arrays_that_are_not_contiguous_arrive_whole():
    table = np.arange(12.0).reshape(3, 4)
    _, got = sent(pack({}, {"columns": table[:, ::2], "turned": table.T}))
    assert np.array_equal(got["columns"], table[:, ::2])
    assert np.array_equal(got["turned"], table.T)


def test_messages_follow_one_another():
    with pair() as (one, two):
        one.sendall(pack({"n": 1}, {"a": np.ones(3)}) + pack({"n": 2}))
        assert receive(two)[0] == {"n": 1}
        assert receive(two) == ({"n": 2}, {})


@given(st.data())
@settings(deadline=None)
def test_a_stream_that_ends_within_a_message_is_closed(data):
    whole = pack({"call": "state"}, {"a": np.arange(5.0)})
    with pytest.raises(ClosedError):
        sent(whole[: data.draw(st.integers(0, len(whole) - 1))])


def test_an_oversized_message_is_refused_before_it_is_read():
    with pytest.raises(ClosedError, match="a message of"):
        sent(struct.pack("!II", 10, connection.LARGEST))


def test_an_oversized_message_is_not_sent(monkeypatch):
    monkeypatch.setattr(connection, "LARGEST", 1000)
    with pytest.raises(ValueError, match="at most 1000"):
        pack({}, {"a": np.zeros(1000)})


@pytest.mark.parametrize("array", [np.array([{}]), np.array(["text"]), np.zeros(1, [("a", "f8")])])
def test_what_is_not_plain_numbers_is_not_sent(array):
    with pytest.raises(TypeError, match="only plain numbers"):
        pack({}, {"a": array})


@pytest.mark.parametrize(
    "message",
    [
        raw(b"{"),
        raw(b"\xff\xfe"),
        raw([]),
        raw({"fields": {}}),
        raw({"fields": {}, "arrays": [["a", "O", [1]]]}, b"12345678"),
        raw({"fields": {}, "arrays": [["a", "no such type", [1]]]}, b"12345678"),
        raw({"fields": {}, "arrays": [["a", "<f8", [2]]]}, b"12345678"),
    ],
    ids=["no json", "no text", "no fields", "no arrays", "objects", "unknown type", "too short"],
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
