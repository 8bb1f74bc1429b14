"""Userdata, read-only wrappers, remapping: the edge cases of upstream, by their number in data/smach_probes.md."""

import copy
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grip_bt.smach_compat import InvalidUserCodeError, Remapper, UserData
from grip_bt.smach_compat.user_data import Const


class Thing:
    def __init__(self):
        self.v = 1

    def m(self):
        return self.v


@pytest.fixture
def ud():
    data = UserData()
    data.o = Thing()
    return data


@pytest.fixture
def view(ud):
    return Remapper(ud, ["o"], [], {})


def test_a_method_of_an_input_cannot_be_called(view):  # probe 1
    assert view.o.v == 1
    assert type(view.o) is Const
    with pytest.raises(TypeError):
        view.o.m()


def test_setting_an_attribute_of_an_input_changes_the_wrapper_only(ud, view):  # probe 2
    wrapped = view.o
    wrapped.v = 5
    assert (wrapped.v, ud.o.v) == (5, 1)


def test_an_attribute_of_an_input_cannot_be_deleted(ud, view, log):  # probe 3
    with pytest.raises(TypeError):
        del view.o.v
    assert ud.o.v == 1
    assert log.at("err")


def test_a_list_is_not_wrapped_so_that_changes_in_place_go_through(ud):  # probe 4
    ud.items = [1]
    Remapper(ud, ["items"], [], {}).items.append(2)
    assert ud.items == [1, 2]


def test_a_wrapped_input_is_no_instance_of_its_class(view):  # probe 5
    assert not isinstance(view.o, Thing)


def test_what_has_no_dict_is_not_wrapped(ud):  # probe 6
    ud.builtin, ud.function = len, lambda: 0
    view = Remapper(ud, ["builtin", "function"], [], {})
    assert type(view.builtin).__name__ == "builtin_function_or_method"
    assert type(view.function).__name__ == "Const"


def test_items_of_a_wrapped_input_are_wrapped(ud):
    class Row(list):
        pass

    ud.row = Row([Thing(), 3])
    row = Remapper(ud, ["row"], [], {}).row
    assert (type(row[0]), row[1]) == (Const, 3)


def test_a_missing_key_raises_an_empty_key_error(log):  # probe 7
    with pytest.raises(KeyError) as caught:
        UserData().x  # noqa: B018 - reading is the point
    assert caught.value.args == ()
    assert len(log.at("err")) == 1


def test_hasattr_of_a_missing_key_raises():  # probe 8
    with pytest.raises(KeyError):
        hasattr(UserData(), "x")


def test_an_item_with_a_leading_underscore_is_an_attribute_error():  # probe 9
    ud = UserData()
    ud["_k"] = 1
    with pytest.raises(AttributeError):
        ud["_k"]
    with pytest.raises(AttributeError):
        UserData()["_k"]


def test_a_name_with_a_leading_underscore_is_no_data():  # probe 10
    ud = UserData()
    ud._k = 1
    assert "_k" not in ud
    assert vars(ud)["_k"] == 1


def test_reading_an_undeclared_key_raises():  # probe 11
    ud = UserData()
    ud.x = 1
    with pytest.raises(InvalidUserCodeError):
        Remapper(ud, [], [], {}).x  # noqa: B018
    with pytest.raises(InvalidUserCodeError):
        Remapper(ud, [], [], {})["x"]


def test_writing_an_undeclared_key_is_logged_and_ignored(log):  # probe 12
    ud = UserData()
    view = Remapper(ud, [], [], {})
    view.x = 1
    view["x"] = 1
    assert "x" not in ud
    assert len(log.at("err")) == 2


def test_an_output_key_is_not_readable_even_after_writing():  # probe 13
    ud = UserData()
    view = Remapper(ud, [], ["x"], {})
    view.x = 1
    assert ("x" in view, "x" in ud) == (False, True)


def test_keys_of_a_remapped_view_are_upstreams_wrong_ones():  # probe 14
    ud = UserData()
    ud.a, ud.x = 1, 2
    view = Remapper(ud, ["a", "x"], [], {"a": "x"})
    assert view.keys() == ["x", "x"]
    assert "a" in view
    assert view.a == view["a"] == 2


def test_extract_renames_back_and_copies_shallowly():  # probe 15
    ud = UserData()
    ud.x, ud.q = 1, [2]
    part = ud.extract(["x", "q"], {"a": "x"})
    assert part._data == {"a": 1, "q": [2]}
    assert part.q is not ud.q


def test_merge_renames_forward():
    ud, other = UserData(), UserData()
    other.a, other.b = 1, 2
    ud.merge(other, ["a", "b"], {"a": "x"})
    assert ud._data == {"x": 1, "b": 2}


def test_an_io_key_gives_the_value_itself(ud):
    view = Remapper(ud, ["o"], ["o"], {})
    assert view.o is ud.o
    assert view.o.m() == 1


def test_update_of_a_view_asks_nobody():
    ud, other = UserData(), UserData()
    other.secret = 1
    Remapper(ud, [], [], {}).update(other)
    assert ud.secret == 1


def test_the_remapping_may_be_a_list_as_smach_ros_passes_it(ud):
    view = Remapper(ud, ["o"], ["p"], [])
    view.p = 3
    assert (view.o.v, ud.p) == (1, 3)


def test_names_of_methods_are_data_by_item_only():
    ud = UserData()
    ud.keys = 1
    assert ud["keys"] == 1
    assert callable(ud.keys)
    assert Remapper(ud, ["keys"], [], {})["keys"] == 1


def test_userdata_can_be_pickled(ud):
    ud.x = 1
    assert pickle.loads(pickle.dumps(ud))._data["x"] == 1


def test_a_key_lock_held_elsewhere_is_respected(in_time):
    ud = UserData()
    ud.x = 1
    with ud._locks["x"], pytest.raises(AssertionError, match="still running"):
        in_time(lambda: ud.x, limit=0.05)


NAMES = st.sampled_from(["a", "b", "c", "d"])


@given(
    st.dictionaries(NAMES, st.integers()),
    st.lists(NAMES),
    st.lists(NAMES),
    st.dictionaries(NAMES, NAMES),
    NAMES,
)
def test_a_view_shows_exactly_the_declared_keys(data, inputs, outputs, remapping, key):
    ud = UserData()
    ud._data.update(data)
    view, there = Remapper(ud, inputs, outputs, remapping), remapping.get(key, key)
    assert (key in view) == (key in inputs and there in data)
    if key not in inputs:
        with pytest.raises(InvalidUserCodeError):
            view[key]
    elif there in data:
        assert view[key] == getattr(view, key) == data[there]
    else:
        with pytest.raises(KeyError):
            view[key]
    view[key] = -1
    assert ud._data == ({**data, there: -1} if key in outputs else data)


def test_a_view_follows_a_remapping_and_a_store_that_change_under_it(ud, in_time):
    ud.x, ud.y = 1, 2
    names = {"a": "x"}
    view = Remapper(ud, ["a", "o"], ["a"], names)
    assert view.a == view["a"] == 1
    names["a"] = "y"
    view.a += 1
    assert (view.a, view["a"], ud.x, ud.y) == (3, 3, 1, 3)
    ud._data = {"y": 5, "_y": 6}
    assert (view.a, view["a"]) == (5, 5)
    names["a"] = "_y"
    for access in (lambda: view.a, lambda: view["a"]):
        with pytest.raises(AttributeError):
            access()
    names.clear()
    with pytest.raises(KeyError):
        view.a  # noqa: B018
    view["a"] = 7
    assert view.a == ud.a == 7
    with ud._locks["a"], pytest.raises(AssertionError, match="still running"):
        in_time(lambda: view.a, limit=0.05)
    with ud._locks["a"], pytest.raises(AssertionError, match="still running"):
        in_time(lambda: view["a"], limit=0.05)


def test_a_part_of_a_view_that_is_set_is_used_at_once(ud):
    ud.x = 1
    for part, value in (("_ud", UserData()), ("_map", {"x": "o"}), ("_input", frozenset()), ("_output", {"x"})):
        view = Remapper(ud, ["x"], [], {})
        setattr(view, part, value)
        view.x = 3
        if part == "_map":
            assert type(view.x) is Const
        elif part == "_output":
            assert (ud.x, view.x) == (3, 3)
        else:
            with pytest.raises((KeyError, InvalidUserCodeError)):
                view.x  # noqa: B018


def test_an_attribute_set_past_a_view_hides_its_key(ud):
    view = Remapper(ud, ["o", "x"], ["o"], {})
    object.__setattr__(view, "o", 3)
    assert (view.o, view["o"]) == (3, ud.o)


def test_views_can_be_copied(ud):
    view = Remapper(ud, ["o", "_hidden"], ["x"], {"x": "y"})
    again = copy.copy(view)
    again.x = 4
    assert ud.y == 4
    other = pickle.loads(pickle.dumps(Remapper(UserData(), ["a"], ["a"], {})))
    other.a = 5
    assert other.a == 5
    with pytest.raises(AttributeError):
        view._hidden  # noqa: B018
    with pytest.raises(AttributeError):
        del view.o
