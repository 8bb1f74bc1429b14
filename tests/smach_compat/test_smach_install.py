"""The package in the place of `smach`: names, sub-modules, going in and out, what it may import."""

import subprocess
import sys
from types import ModuleType

import pytest

from grip_bt import smach_compat
from grip_bt.base.errors import GripError
from grip_bt.smach_compat._settings import settings

UPSTREAM = """
    set_loggers loginfo logwarn logerr logdebug
    InvalidTransitionError InvalidStateError InvalidConstructionError InvalidUserCodeError
    State CBState UserData Remapper Container
    is_shutdown set_shutdown_check has_smach_interface cb_interface CBInterface
    StateMachine Sequence Concurrence Iterator
    log exceptions state user_data container util state_machine sequence concurrence iterator
""".split()


@pytest.fixture
def installed():
    smach_compat.install()
    yield
    smach_compat.uninstall()


def test_a_star_import_gives_upstreams_names_and_smach_error(installed):
    names = {}
    exec("from smach import *", names)
    assert set(names) - {"__builtins__"} == {*UPSTREAM, "SmachError"}


def test_sub_modules_are_found_under_upstreams_names(installed):
    import smach.container
    from smach.state import CBState, State
    from smach.user_data import Const, get_const
    from smach.util import has_smach_interface

    assert smach.container.Container is smach_compat.Container
    assert (State, CBState) == (smach_compat.State, smach_compat.CBState)
    assert has_smach_interface is smach_compat.has_smach_interface
    assert type(get_const(State())) is Const


def test_loggers_set_by_the_program_are_those_that_machines_use(installed, log):
    import smach

    heard = []
    smach.loginfo = heard.append
    machine = smach.StateMachine(["ok"])
    with machine:
        smach.StateMachine.add("A", smach.CBState(lambda ud: "ok", outcomes=["ok"]))
    machine.execute()
    assert any("'A'" in text for text in heard)
    assert log.at("info") == []


def test_it_is_gone_after_uninstall():
    smach_compat.install(profile="ros2")
    smach_compat.install(wrap_interrupts=True)
    assert (settings.profile, settings.wrap_interrupts) == ("ros2", True)
    smach_compat.uninstall()
    assert not [name for name in sys.modules if name.split(".")[0] == "smach"]
    assert (settings.profile, settings.wrap_interrupts) == ("noetic", False)


def test_another_smach_is_not_replaced(monkeypatch):
    other = ModuleType("smach")
    monkeypatch.setitem(sys.modules, "smach", other)
    with pytest.raises(GripError, match="imported already"):
        smach_compat.install()
    smach_compat.uninstall()
    assert sys.modules["smach"] is other


@pytest.mark.parametrize(("changes", "error"), [({"profile": "kinetic"}, ValueError), ({"colour": 1}, TypeError)])
def test_unknown_settings_are_refused_with_what_there_is(changes, error):
    with pytest.raises(error, match="available"):
        smach_compat.configure(**changes)


def test_importing_it_installs_nothing_and_loads_neither_ros_nor_py_trees():
    code = (
        "import sys, grip_bt.smach_compat\n"
        "bad = {'smach', 'rospy', 'rclpy', 'py_trees', 'numpy'} & set(sys.modules)\n"
        "sys.exit(f'loaded: {bad}' if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=600)


def test_the_default_loggers_print_with_a_level(capsys):
    for name in ("loginfo", "logwarn", "logdebug", "logerr"):
        getattr(smach_compat.log, name)("text")
    assert capsys.readouterr().out.splitlines() == [
        "[  INFO ] : text",
        "[  WARN ] : text",
        "[ DEBUG ] : text",
        "[ ERROR ] : text",
    ]
