"""Queues, archives, and the stores of a project behind the port that tasks use."""

from __future__ import annotations

import time

import pytest

from grip_bt.base.errors import UnknownNameError, WrongTypeError
from grip_bt.base.failures import EmptyQueueError, NoEntryError
from grip_bt.base.message_store import ArchiveError, LocalMessages, MessageLibrary, MessageStore, load, save
from grip_bt.base.ports import Messages
from grip_bt.base.values import Pose


def encode(value) -> bytes:
    return repr(value).encode()


def decode(content: bytes):
    return eval(content)  # of what this test has written


def test_a_queue_gives_each_value_once_the_oldest_first():
    store = MessageStore("numbers", "int")
    for number in range(4):
        store.push(number)
    assert [store.take().value for _ in range(3)] == [0, 1, 2]
    store.push(9)
    assert [store.take().value, store.take().value] == [3, 9]
    with pytest.raises(EmptyQueueError, match="store 'numbers': its queue is empty"):
        store.take()


def test_names_and_the_queue_do_not_touch_each_other():
    store = MessageStore("numbers", "int")
    store.put("one", 1)
    store.push(2)
    assert (store.names(), store.queued, len(store)) == (("one",), 1, 1)
    store.clear()
    assert (store.names(), store.queued) == ((), 0)


def test_the_queue_takes_only_the_type_of_the_store():
    store = MessageStore("numbers", "int")
    with pytest.raises(WrongTypeError, match="'the queue' has to be of type int"):
        store.push("1")
    assert store.queued == 0


def test_an_entry_knows_when_by_whom_and_at_which_revision_it_was_put():
    store = MessageStore("numbers", "int")
    store.put("a", 1)
    entry = store.put("b", 2, "a camera", at=12.5)
    assert (entry.time, entry.provenance, entry.revision) == (12.5, "a camera", 2)
    assert abs(store.entry("a").time - time.time()) < 60


def test_watchers_hear_of_the_queue_too():
    store, seen = MessageStore("numbers", "int"), []
    store.watch(lambda change: seen.append((change.kind, change.name, change.value)))
    store.push(1)
    store.take()
    assert seen == [("pushed", "", 1), ("taken", "", 1)]


def test_an_archive_gives_everything_back_in_order_with_time_and_provenance(tmp_path):
    library = MessageLibrary()
    mine = library.store("mine", make=True)
    mine.put("b", 0.1 + 0.2, "me", at=1.5)
    mine.put("a", [1, 2])
    mine.push("first")
    mine.push("second")
    file = tmp_path / "kept.sqlite"
    assert save(library.stores(), file, encode) == 4
    again = MessageLibrary()
    assert load(lambda name: again.store(name, make=True), file, decode) == 4
    store = again.store("mine")
    assert store.names() == ("b", "a")
    assert (store.get("b"), store.entry("b").time, store.entry("b").provenance) == (0.1 + 0.2, 1.5, "me")
    assert [store.take().value, store.take().value] == ["first", "second"]
    assert [f.name for f in tmp_path.iterdir()] == ["kept.sqlite"]


def test_what_was_kept_before_stays_when_saving_fails(tmp_path):
    library, file = MessageLibrary(), tmp_path / "kept.sqlite"
    library.store("mine", make=True).put("a", 1)
    save(library.stores(), file, encode)
    library.store("mine").put("b", 2)

    def broken(value):
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        save(library.stores(), file, broken)
    again = MessageLibrary()
    assert load(lambda name: again.store(name, make=True), file, decode) == 1


@pytest.mark.parametrize("content", [None, b"not a database at all, not even nearly"])
def test_a_file_that_is_no_archive_is_refused_by_name(tmp_path, content):
    file = tmp_path / "kept.sqlite"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ArchiveError, match="kept.sqlite"):
        load(MessageLibrary().store, file, decode)


def test_the_port_of_a_library_ends_with_errors_that_a_task_can_expect():
    messages = LocalMessages(MessageLibrary())
    assert isinstance(messages, Messages)
    messages.put("poses", "home", Pose(), "/here").result()
    assert messages.get("poses", "home").result().provenance == "/here"
    with pytest.raises(NoEntryError, match="did you mean 'home'"):
        messages.get("poses", "hone").result()
    with pytest.raises(NoEntryError, match="unknown store 'pose'; did you mean 'poses'"):
        messages.names("pose").result()
    with pytest.raises(EmptyQueueError):
        messages.get("poses", "").result()
    with pytest.raises(NoEntryError, match="outside of a project"):
        messages.save().result()
    with pytest.raises(WrongTypeError):
        messages.put("poses", "x", 3)


def test_a_store_of_ones_own_is_made_by_the_first_value():
    library = MessageLibrary()
    LocalMessages(library).put("wrenches", "touch", {"force": 1.0}).result()
    assert library.store("wrenches").get("touch") == {"force": 1.0}
    with pytest.raises(UnknownNameError):
        library.store("others")
