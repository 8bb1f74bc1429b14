"""Executing state machines: errors, data, callbacks, shutdown, preemption, by the number of the probe."""

import pytest
from smach_states import Does, Preemptable, Returns, ok, raises

from grip_bt import smach_compat as smach
from grip_bt.smach_compat import (
    InvalidTransitionError,
    InvalidUserCodeError,
    State,
    StateMachine,
    UserData,
    configure,
)
from grip_bt.smach_compat.user_data import Const


def machine(state=None, transitions=None, outcomes=("ok",), **kwargs):
    """Return a machine with one state A."""
    sm = StateMachine(list(outcomes))
    with sm:
        StateMachine.add("A", ok() if state is None else state, transitions, **kwargs)
    return sm


# --- errors ---


@pytest.mark.parametrize(("profile", "running"), [("noetic", False), ("ros2", True)])
def test_an_error_of_a_state_is_an_error_of_user_code(profile, running, log):  # probe 28
    configure(profile=profile)
    sm = machine(raises(ZeroDivisionError()))
    with pytest.raises(InvalidUserCodeError) as caught:
        sm.execute()
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert sm.is_running() is running
    assert sm.get_active_states() == ["A"]


def test_an_inner_machines_own_error_becomes_user_code_outside():  # probe 29
    outer = machine(machine(Returns("weird", outcomes=["ok"])))
    with pytest.raises(InvalidUserCodeError):
        outer.execute()


@pytest.mark.noetic
@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, SystemExit])
def test_interrupts_pass_through(interrupt):  # probe 30
    sm = machine(raises(interrupt()))
    with pytest.raises(interrupt):
        sm.execute()
    assert not sm.is_running()


@pytest.mark.parametrize("returned", ["zz", None, ["ok"]])
def test_an_unregistered_outcome_is_an_invalid_transition(returned):  # probes 31 50
    with pytest.raises(InvalidTransitionError):
        machine(Returns(returned, outcomes=["ok"])).execute()


def test_a_label_equal_to_an_outcome_of_the_machine_is_a_state():  # probe 32
    state = Returns("again", "again", "ok")
    sm = machine(state, {"again": "A", "ok": "ok"}, outcomes=["ok", "A"])
    assert sm.execute() == "ok"
    assert state.runs == 3


def test_an_inconsistent_inner_machine_is_an_invalid_transition_outside():
    with pytest.raises(InvalidTransitionError):
        machine(machine(transitions={"ok": "NOPE"})).execute()


def test_an_outcome_registered_after_add_has_no_transition():  # probe 95
    sm = machine(Returns("late", outcomes=["ok"]), outcomes=["ok", "late"])
    sm["A"].register_outcomes(["late"])
    with pytest.raises(InvalidTransitionError):
        sm.execute()


def test_a_machine_that_executes_itself_ends_in_an_attribute_error():  # probe 49
    depth = []

    def work(ud):
        depth.append(1)
        if len(depth) == 1:
            assert sm.execute() == "ok"

    sm = machine(Does(work))
    with pytest.raises(AttributeError):
        sm.execute()
    assert len(depth) == 2


# --- preemption ---


@pytest.mark.parametrize(("services", "flag", "second"), [(False, True, "preempted"), (True, False, "ok")])
def test_a_preempt_before_execution_lasts_until_it_is_serviced(services, flag, second):  # probes 34 35
    sm = machine(Preemptable(services), outcomes=["ok", "preempted"])
    sm.request_preempt()
    assert sm.execute() == "preempted"
    assert sm.preempt_requested() is flag
    assert sm.execute() == second


def two_states(service):
    """Return a machine A -> B in which A is preempted while it runs, what A saw, and B."""
    seen = []

    def work(ud):
        sm.request_preempt()
        seen.append(sm["A"].preempt_requested())
        if service:
            sm["A"].service_preempt()

    sm, b = StateMachine(["ok", "preempted"]), Preemptable(services=False)
    with sm:
        StateMachine.add("A", Does(work), {"ok": "B"})
        StateMachine.add("B", b)
    return sm, seen, b


def test_an_ignored_preempt_travels_to_the_next_state():  # probe 36
    sm, seen, b = two_states(service=False)
    assert sm.execute() == "preempted"
    assert (seen, b.seen) == ([True], [True])
    flags = [state.preempt_requested() for state in (sm["A"], b, sm)]
    assert flags == [False, True, True]


def test_a_serviced_preempt_is_over_when_the_machine_goes_on():  # probe 37
    sm, seen, b = two_states(service=True)
    assert sm.execute() == "ok"
    assert b.seen == [False]
    assert not sm.preempt_requested()


def test_an_error_in_request_preempt_of_a_state_is_logged(log):
    class Stubborn(State):
        def request_preempt(self):
            raise RuntimeError("won't")

        def execute(self, ud):
            return "ok"

    sm = machine(Stubborn(["ok"]))
    sm.request_preempt()
    assert sm.execute() == "ok"
    assert any("won't" in text for text in log.at("err"))


def test_a_callback_may_request_a_preempt(in_time):
    b = Preemptable(services=True)
    sm = StateMachine(["ok", "preempted"])
    with sm:
        StateMachine.add("A", ok(), {"ok": "B"})
        StateMachine.add("B", b)
    sm.register_transition_cb(lambda ud, active: sm.request_preempt())
    assert in_time(sm.execute) == "preempted"
    assert b.seen == [True]


# --- data ---


def test_absent_keys_are_warned_of_and_not_copied(log):  # probe 38
    sm = machine()
    sm.register_input_keys(["a"])
    sm.register_output_keys(["b"])
    parent = UserData()
    assert sm.execute(parent) == "ok"
    assert parent._data == {}
    assert len(log.at("warn")) == 2


def test_declared_keys_come_in_and_go_out():
    def work(ud):
        ud.b = ud.a + 1

    sm = machine(Does(work, input_keys=["a"], output_keys=["b"]))
    sm.register_input_keys(["a"])
    sm.register_output_keys(["b"])
    parent = UserData()
    parent.a = 1
    sm.execute(parent)
    assert parent._data == {"a": 1, "b": 2}


def test_a_nested_machine_keeps_the_wrapper_of_an_input():  # probe 39
    class Thing:
        pass

    read = []
    inner = machine(Does(lambda ud: read.append(type(ud.o)), io_keys=["o"]))
    inner.register_input_keys(["o"])
    outer = machine(inner)
    outer.userdata.o = Thing()
    assert outer.execute() == "ok"
    assert read == [Const]


def test_userdata_outlives_an_execution():  # probe 40
    def count(ud):
        ud.n += 1

    sm = machine(Does(count, io_keys=["n"]))
    sm.userdata.n = 0
    sm.execute()
    sm.execute()
    assert sm.userdata.n == 2


def test_the_store_can_be_replaced():
    def count(ud):
        ud.n += 1

    sm = machine(Does(count, io_keys=["n"]))
    for start in (10, 20):
        sm.userdata = UserData()
        sm.userdata.n = start
        sm.execute()
        assert sm.userdata.n == start + 1


def test_reading_an_absent_key_is_an_error_of_user_code():  # probe 43
    with pytest.raises(InvalidUserCodeError) as caught:
        machine(Does(lambda ud: ud.x, input_keys=["x"])).execute()
    assert isinstance(caught.value.__cause__, KeyError)


def test_reading_an_undeclared_key_is_raised_as_it_is():  # probe 44
    with pytest.raises(InvalidUserCodeError) as caught:
        machine(Does(lambda ud: ud.x)).execute()
    assert caught.value.__cause__ is None


def test_keys_declared_later_count_from_the_next_execution_on():
    state = Does(lambda ud: ud.x)
    sm = machine(state)
    sm.userdata.x = "ok"
    with pytest.raises(InvalidUserCodeError):
        sm.execute()
    state._input_keys.add("x")
    assert sm.execute() == "ok"
    state._input_keys.discard("x")
    with pytest.raises(InvalidUserCodeError):
        sm.execute()


def test_keys_that_the_state_declares_while_it_runs_do_not_count_yet():
    def work(ud):
        sm["A"].register_input_keys(["x"])
        return ud.x

    sm = machine(Does(work))
    sm.userdata.x = "ok"
    with pytest.raises(InvalidUserCodeError):
        sm.execute()
    assert sm.execute() == "ok"


def test_private_attributes_of_a_view_are_gone_at_the_next_execution():
    def work(ud):
        with pytest.raises(AttributeError):
            ud._note  # noqa: B018
        ud._note = 1

    sm = machine(Does(work))
    assert [sm.execute(), sm.execute()] == ["ok", "ok"]


@pytest.mark.noetic
@pytest.mark.parametrize("remapping", [None, {"k": "kk"}])
def test_constants_are_written_before_the_state(remapping):  # probes 82 83
    key = "kk" if remapping else "k"
    read = []
    state = Does(lambda ud: read.append(ud.k), input_keys=["k"])
    sm = machine(state, remapping=remapping, constants={key: 3})
    assert sm.execute() == "ok"
    assert (read, sm.userdata._data) == ([3], {key: 3})
    sm.userdata[key] = 4
    sm.execute()
    assert read == [3, 3]


@pytest.mark.noetic
@pytest.mark.parametrize("remapping", [None, {"k": "kk"}])
def test_the_ros2_branch_has_no_constants(remapping):  # probes 82 83
    configure(profile="ros2")
    with pytest.raises(TypeError):
        machine(remapping=remapping, constants={"k": 3})


# --- callbacks and shutdown ---


def test_errors_of_callbacks_are_logged_and_skip_the_rest(log):  # probe 41
    called = []

    def fail(*args):
        raise RuntimeError("of a callback")

    sm = StateMachine(["ok"])
    with sm:
        StateMachine.add("A", ok(), {"ok": "B"})
        StateMachine.add("B", ok())
    for register in (sm.register_start_cb, sm.register_transition_cb):
        register(fail)
        register(lambda *args: called.append(args))
    assert sm.execute() == "ok"
    assert called == []
    assert sum("of a callback" in text for text in log.at("err")) == 2


def test_callbacks_get_userdata_labels_and_their_arguments():
    calls = []

    def note(ud, *args):
        assert ud is sm.userdata
        calls.append(args)

    sm = StateMachine(["done"])
    with sm:
        StateMachine.add("A", ok(), {"ok": "B"})
        StateMachine.add("B", ok(), {"ok": "done"})
    sm.register_start_cb(note, ["start"])
    sm.register_transition_cb(note, ["transition"])
    sm.register_termination_cb(note, ["end"])
    sm.execute()
    assert calls == [(["A"], "start"), (["B"], "transition"), (["B"], "done", "end")]


def test_a_shutdown_ends_the_machine_without_an_outcome():  # probe 42
    smach.set_shutdown_check(lambda: True)
    sm = machine()
    assert sm.execute() is None
    assert sm["A"].runs == 0


def test_loggers_are_replaced_in_upstreams_order():
    names = ["info", "warn", "debug", "error"]
    heard = []
    smach.set_loggers(*[lambda text, name=name: heard.append(name) for name in names])
    smach.loginfo("")
    smach.logwarn("")
    smach.logdebug("")
    smach.logerr("")
    assert heard == names


# --- what legacy code does to machines ---


def test_a_state_may_be_anything_with_the_right_methods():
    class Duck:
        flag = False

        def get_registered_outcomes(self):
            return ("ok",)

        def get_registered_input_keys(self):
            return ("x",)

        def get_registered_output_keys(self):
            return ("y",)

        def execute(self, ud):
            ud.y = ud.x
            ud.z = 1
            return "ok"

        def request_preempt(self):
            self.flag = True

        def preempt_requested(self):
            return self.flag

    sm = machine(Duck())
    sm.userdata.x = 1
    assert sm.execute() == "ok"
    assert sm.userdata._data == {"x": 1, "y": 1}


def test_execute_of_an_instance_may_be_replaced():
    sm = machine(Returns("ok", outcomes=["ok", "other"]), outcomes=["ok", "other"])
    sm["A"].execute = lambda ud: "other"
    assert sm.execute() == "other"


def test_getters_of_a_subclass_are_asked():
    class Late(State):
        def get_registered_outcomes(self):
            return ("made_up",)

        def execute(self, ud):
            return "made_up"

    assert machine(Late(["ok"]), {"made_up": "ok"}).execute() == "ok"


def test_transitions_may_be_rewired_while_the_machine_runs():
    def rewire(ud):
        sm._transitions["A"]["ok"] = "B"

    sm = StateMachine(["ok", "end"])
    with sm:
        StateMachine.add("A", Does(rewire))
        StateMachine.add("B", Returns("end"))
    assert sm.execute() == "end"


def test_a_state_may_be_put_into_the_internals_by_hand():
    sm = machine(transitions={"ok": "B"}, outcomes=["end"])
    sm._states["B"], sm._transitions["B"], sm._remappings["B"] = Returns("end"), {"end": None}, {}
    sm["A"]._outcomes.add("extra")
    assert sm.execute() == "end"
