"""States and functions with an interface, by the number of the probe."""

import operator
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st
from smach_states import ok

from grip_bt import smach_compat as smach
from grip_bt.base.errors import GripError
from grip_bt.smach_compat import (
    CBInterface,
    CBState,
    InvalidStateError,
    State,
    UserData,
    cb_interface,
    has_smach_interface,
)
from grip_bt.smach_compat.util import OrderedSet


def test_keys_are_lists():  # probe 16
    with pytest.raises(TypeError):
        State(outcomes=("a",), input_keys=("x",), io_keys=["y"])
    with pytest.raises(TypeError):
        State(input_keys=("x",))


def test_a_string_of_outcomes_becomes_its_characters():  # probe 17
    assert State(outcomes="success").get_registered_outcomes() == ("s", "u", "c", "e")


def test_a_state_has_to_implement_execute():  # probe 18
    with pytest.raises(NotImplementedError):
        State(["a"]).execute(None)


def test_the_decorator_takes_no_io_keys():  # probe 19
    with pytest.raises(TypeError):
        cb_interface(io_keys=["a"])


def test_the_interface_ignores_io_keys():  # probe 20
    interface = CBInterface(len, io_keys=["z"])
    assert interface.get_registered_input_keys() == ()
    assert interface.get_registered_output_keys() == ()


def test_io_keys_are_inputs_and_outputs():
    state = State(["a"], ["i"], ["o"], ["x"])
    assert state.get_registered_input_keys() == ("i", "x")
    assert state.get_registered_output_keys() == ("o", "x")
    state.register_io_keys(["y"])
    state.register_input_keys(["j"])
    state.register_output_keys(["p"])
    assert state.get_registered_input_keys() == ("i", "x", "y", "j")
    assert state.get_registered_output_keys() == ("o", "x", "y", "p")


def test_the_preempt_flag_stays_until_somebody_clears_it():
    state = ok()
    state.request_preempt()
    state.execute(None)
    assert state.preempt_requested()
    state.recall_preempt()
    assert not state.preempt_requested()
    state.request_preempt()
    state.service_preempt()
    assert not state.preempt_requested()


def test_a_function_with_an_interface_gives_its_outcomes_and_keys():
    @cb_interface(outcomes=["done"], input_keys=["x"], output_keys=["y"])
    def double(ud, factor, offset=0):
        ud.y = ud.x * factor + offset
        return "done"

    state = CBState(double, [2], {"offset": 1}, outcomes=["extra"], io_keys=["z"])
    assert has_smach_interface(double)
    assert isinstance(double, CBInterface)
    assert state.get_registered_outcomes() == ("extra", "done")
    assert state.get_registered_input_keys() == ("z", "x")
    assert state.get_registered_output_keys() == ("z", "y")
    ud = UserData()
    ud.x = 3
    assert state.execute(ud) == "done"
    assert ud.y == 7


def test_a_plain_function_has_no_interface():
    assert not has_smach_interface(len)
    assert CBState(lambda ud: "a", outcomes=["a"]).get_registered_outcomes() == ("a",)


def test_making_an_error_logs_it(log):
    with pytest.raises(InvalidStateError, match="no such thing"):
        raise InvalidStateError("no such thing")
    assert log.at("err") == ["InvalidStateError: no such thing"]
    with pytest.raises(TypeError):
        InvalidStateError()
    assert issubclass(smach.exceptions.SmachError, GripError)


def test_errors_can_be_pickled():
    assert str(pickle.loads(pickle.dumps(InvalidStateError("m")))) == "m"


@given(st.lists(st.text(max_size=3)), st.lists(st.text(max_size=3)))
def test_names_are_a_set_in_the_order_of_declaration(first, second):
    names = OrderedSet(first)
    for name in second:
        names.add(name)
    order = list(dict.fromkeys(first + second))
    assert list(names) == order
    assert names == set(order)
    assert list(OrderedSet(first).union(second)) == order
    assert list(pickle.loads(pickle.dumps(names))) == order
    names.difference_update(second)
    assert list(names) == [name for name in order if name not in second]
    names ^= {"added behind its back"}
    assert "added behind its back" in list(names)


@pytest.mark.parametrize(
    "change",
    [
        lambda names: names.add("z"),
        lambda names: names.discard("a"),
        lambda names: names.remove("a"),
        lambda names: names.add(names.pop()),
        lambda names: names.clear(),
        lambda names: names.update(["z"]),
        lambda names: names.difference_update(["a"]),
        lambda names: names.intersection_update(["a"]),
        lambda names: names.symmetric_difference_update(["a", "z"]),
        lambda names: operator.ior(names, {"z"}),
        lambda names: operator.isub(names, {"a"}),
        lambda names: operator.iand(names, {"a"}),
        lambda names: operator.ixor(names, {"a", "z"}),
    ],
)
def test_names_stay_in_order_however_they_change(change):
    names, plain = OrderedSet(["a", "b", "c"]), {"a", "b", "c"}
    change(names)
    change(plain)
    assert names == plain
    assert list(names) == sorted(plain)
