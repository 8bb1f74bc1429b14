import threading

import pytest

from grip_bt.base.errors import UnknownNameError, WrongTypeError
from grip_bt.base.message_store import Change, MessageStore
from grip_bt.base.values import Pose


@pytest.fixture
def poses():
    return MessageStore("poses", "Pose")


def test_what_was_put_is_got_back_by_its_name(poses):
    home, shelf = Pose(), Pose([1, 0, 0])
    poses.put("home", home)
    poses.put("shelf", shelf)
    assert poses.get("home") is home
    assert poses.names() == ("home", "shelf")
    assert "shelf" in poses
    assert len(poses) == 2


def test_a_later_value_replaces_an_earlier_one(poses):
    poses.put("home", Pose())
    poses.put("home", Pose([1, 0, 0]))
    assert poses.get("home").position[0] == 1
    assert len(poses) == 1


@pytest.mark.parametrize(("type_name", "bad"), [("Pose", 3), ("int", "3"), ("list[int]", [1, "2"]), ("Pose", None)])
def test_a_value_of_another_type_is_refused_and_nothing_changes(type_name, bad):
    store = MessageStore("things", type_name)
    with pytest.raises(WrongTypeError, match="store 'things': 'x' has to be of type"):
        store.put("x", bad)
    assert store.names() == ()
    assert store.revision == 0


def test_an_unknown_name_is_an_error_that_names_the_nearest(poses):
    poses.put("home", Pose())
    for action in (poses.get, poses.delete):
        with pytest.raises(UnknownNameError, match="did you mean 'home'"):
            action("hom")


def test_an_empty_name_is_refused(poses):
    with pytest.raises(ValueError, match="needs a name"):
        poses.put("", Pose())


def test_watchers_are_told_of_each_change_in_order_until_they_stop(poses):
    changes = []
    stop = poses.watch(changes.append)
    poses.put("home", Pose())
    poses.delete("home")
    stop()
    stop()
    poses.put("home", Pose())
    assert changes == [Change("put", "home", Pose(), 1), Change("deleted", "home", None, 2)]


def test_clearing_tells_of_every_entry(poses):
    poses.put("a", Pose())
    poses.put("b", Pose())
    seen = []
    poses.watch(seen.append)
    poses.clear()
    assert [c.name for c in seen] == ["a", "b"]
    assert len(poses) == 0


def test_a_watcher_may_change_the_store(poses):
    def keep_one(change):
        if change.kind == "put" and len(poses) > 1:
            poses.delete(poses.names()[0])

    poses.watch(keep_one)
    for name in "abc":
        poses.put(name, Pose())
    assert poses.names() == ("c",)


def test_no_change_is_lost_among_threads():
    store, seen = MessageStore("numbers", "int"), []
    store.watch(lambda change: seen.append(change.revision))

    def work(k):
        for i in range(200):
            store.put(f"{k}-{i}", i)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert seen == list(range(1, 801))
    assert len(store) == 800
