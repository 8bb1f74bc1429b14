"""A dry run of legacy code: what isn't here is stood in for, and each thing is told once.

A value that nobody knows is 0 as a number, has nothing in it as a sequence, is true, equals nothing and is less than
nothing. A state that can't go on with that ends well, and so does one that waits for what nobody does here.
"""

from __future__ import annotations

import functools
import os
import re
import shutil
import sys
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from importlib import import_module
from importlib.machinery import ModuleSpec
from itertools import chain
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest import mock

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.trees import BehaviourTree

from grip_bt import smach_compat
from grip_bt.smach_compat import Container, State, smach_ros, user_data
from grip_bt.smach_compat.smach_ros._port import Ros

from . import stand_ins
from .smach_source import workspace_of
from .stand_ins import StandIn, StandInFinder, StandInModule, name_of, stand_in, stand_in_class, stands_in, unwrapped

_SUCCESS = frozenset(
    (
        *("succeeded", "succeed", "success", "successful", "successfully", "done", "true", "valid", "finished"),
        *("finish", "arrived", "ok", "okay", "yes", "complete", "completed", "found", "reached", "exhausted"),
    )
)
_FAILURE = re.compile(
    r"abort|cancel|error|exit|fail|false|invalid|lost|miss|never|no$|no_|none|not|over|preempt|quit|reject|stop|time|un|wrong"
)
_NEGATED = re.compile(r"no|not|un.+|fail.*|never")


def says_success(outcome: str) -> bool:
    """Tell whether an outcome is called after success."""
    words = re.findall(r"[a-z]+", outcome.lower())
    return any(word in _SUCCESS for word in words) and not any(_NEGATED.fullmatch(word) for word in words)


def good_outcomes(outcomes: Iterable[str]) -> list[str]:
    """Return those that are called after success; if none is, the first that isn't called after failure."""
    labels = list(outcomes)
    said = [outcome for outcome in labels if says_success(outcome)]
    return said or [outcome for outcome in labels if not _FAILURE.search(outcome.strip().lower())][:1]


class StandInState(State):
    """In the place of a state whose class isn't here: it has the outcomes that its container goes by, and ends well."""

    def __init__(self, label: str, transitions: Mapping[str, object] | None):
        container = next(iter(Container._construction_stack[-1:]), None)
        rules = getattr(container, "_outcome_map", {}).values()
        outcomes = [*(transitions or ()), *(rule[label] for rule in rules if label in rule)]
        super().__init__(outcomes=list(dict.fromkeys(outcomes)) or ["succeeded"])

    def execute(self, ud: object) -> str:
        """End well."""
        return _well(self)


def _well(state: State) -> str:
    outcomes = state.get_registered_outcomes()
    return next(iter((*good_outcomes(outcomes), *outcomes)))


MOST_WAITS, LATER_WAITS, LONGEST_WAIT = 2000, 100, 3.0
"""How often a state may wait, or look whether it should go on, in its first execution and in later ones; and how long
for an Event in the first [s]."""
MOST_ALIKE, LATER_ALIKE = 100, 3
"""How often a state ends with the same outcome, before it takes the one that it has ended with least: in time every way
is taken, and so one that ends. Later is after ten times as many ends of any state."""
_OF_ROS_1 = (f"{smach_compat.__name__}.ros1", f"{smach_compat.__name__}.smach_ros")
_IN_VAIN = "it waits for something that doesn't happen here"
_waits = threading.local()


class WaitingError(Exception):
    """A state waits without end."""


def _look() -> bool:
    """Count that a state waits, or looks whether it should; tell whether one does here."""
    if getattr(_waits, "left", None) is None:
        return False
    _waits.left -= 1
    if _waits.left < 0:
        raise WaitingError(_IN_VAIN)
    return True


def _waiting(wait: Callable[..., bool]) -> Callable[..., bool]:
    """Return `threading.Event.wait`, which a state doesn't wait for long."""

    def waiting(event: threading.Event, timeout: float | None = None) -> bool:
        by_threading = sys._getframe(1).f_code.co_filename == threading.__file__  # a thread that begins
        if by_threading or getattr(_waits, "left", None) is None:
            return wait(event, timeout)
        _look()
        most = LONGEST_WAIT * _waits.left / MOST_WAITS
        given = most if timeout is None else min(float(timeout), most)
        came = wait(event, given)
        if not came and timeout is None:
            raise WaitingError(_IN_VAIN)
        _waits.left -= 0 if came else MOST_WAITS * given / LONGEST_WAIT
        return came

    return waiting


class _ImpatientRos(Ros):
    """What a dry run has for ROS."""

    def sleep(self, seconds: float) -> None:
        _look()
        super().sleep(seconds)

    def is_shutdown(self) -> bool:
        _look()
        return super().is_shutdown()

    def shut_down(self, reason: str = "") -> None:
        """Do so for a state: a program does at its end, which here comes before anything runs."""
        if getattr(_waits, "left", None) is not None:
            super().shut_down(reason)


def _is_own(error: Exception) -> bool:
    """Tell whether an error is the code's own: of a kind that no stand-in makes, or before anything went by one.

    Then a stand-in that has caused it is still one: in what a frame holds or names, or in an object there.
    """
    if (sure := isinstance(error, (NameError, ImportError))) or isinstance(error, WaitingError) or stand_ins.judge.used:
        return sure
    near = list[object]()
    for frame, _ in traceback.walk_tb(error.__traceback__):
        near += [*frame.f_locals.values(), *(frame.f_globals.get(name) for name in frame.f_code.co_names)]
    parts = (each.__dict__.values() for each in near if hasattr(each, "__dict__") and not isinstance(each, ModuleType))
    return not any(map(_may_stand_in, (*near, *chain.from_iterable(parts))))


def _may_stand_in(value: object) -> bool:
    kind = value if isinstance(value, type) else type(value)
    return issubclass(kind, (StandIn, StandInModule)) or kind.__module__.startswith(_OF_ROS_1)


def _going_on(
    state: Any, execute: Callable[..., Any], told: list[str], every: Counter[str], tell: Callable[[str], object]
) -> Any:
    """Return a state's `execute`, which ends well where a stand-in keeps it from going on."""
    ends = Counter[str]()

    def ended(outcome: Any, why: str = "") -> Any:
        most = MOST_ALIKE if every.total() < 10 * MOST_ALIKE else LATER_ALIKE
        if told and ends[str(outcome)] >= most:
            outcomes = state.get_registered_outcomes()
            rarest = min((*good_outcomes(outcomes), *outcomes), key=ends.__getitem__)
            if rarest != outcome:
                why, outcome = f"it has ended {most} times with {outcome}", rarest
        ends[str(outcome)] += 1
        every["ended"] += 1
        if why:
            tell(f"outcome {outcome} of {type(state).__name__}: {why}")
        return outcome

    @functools.wraps(execute)
    def executed(*given: Any) -> Any:
        before, _waits.left = getattr(_waits, "left", None), LATER_WAITS if ends else MOST_WAITS
        try:
            outcome = execute(*given)
            if not stands_in(outcome) or unwrapped(outcome) in state.get_registered_outcomes():
                return ended(unwrapped(outcome))
            why = f"it returned {name_of(outcome)}"
        except Exception as error:
            if not told or _is_own(error):
                raise
            place = traceback.extract_tb(error.__traceback__)[-1]
            why = f"{type(error).__name__}: {error} ({place.filename.rpartition('/')[2]}:{place.lineno})"
        finally:
            _waits.left = before
        return ended(_well(state), why)

    return executed


Made = Mapping[str, Callable[[ModuleType], object]]
"""Module -> what gives it names of its own where it is stood in for."""


class _TellingFinder(StandInFinder):
    parts = True

    def __init__(self, tell: Callable[[str], object]):
        super().__init__()
        self._tell = tell

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Stand in for a module that no other finder has, or that wasn't built; tell of its package once."""
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            # every package has a folder `launch` without `__init__.py`, called like ROS's own
            found = finder.find_spec(fullname, path, target)  # type: ignore[arg-type]
            if found is not None and not (
                found.loader is None and (stand_ins.is_generated(fullname) or fullname == "launch")
            ):
                return found
        known = len(self.packages)
        found = super().find_spec(fullname, path, target)
        for package in self.packages[known:]:
            self._tell(f"package {package}")
        return found


@contextmanager
def dry_run(tell: Callable[[str], object], made: Made | None = None) -> Iterator[None]:
    """Stand in for packages that aren't installed and for what nobody offers over ROS; `tell` is told of each."""
    installed, finder = "smach" in sys.modules, _TellingFinder(lambda what: named(what))
    finder.made |= made or {}

    def added(composite: Composite, child: object) -> object:
        return add_child(composite, _behaviour(child))

    def named(what: str) -> None:
        if what not in told:
            told.append(what)
            tell(what)

    def begun(state: Any, *arguments: Any, **named_ones: Any) -> None:
        begin(state, *map(unwrapped, arguments), **{key: unwrapped(value) for key, value in named_ones.items()})
        if not isinstance(state, Container):
            state.execute = _going_on(state, state.execute, told, every, named)

    def decorated(decorator: Decorator, name: str, child: Any) -> None:
        decorate(decorator, name, _behaviour(child))

    add_child, begin, told, every = Composite.add_child, State.__init__, list[str](), Counter[str]()
    decorate, get_const = Decorator.__init__, user_data.get_const  # one wrapped has an item at every index
    smach_compat.install(rospy=True)
    smach_ros.use(_ImpatientRos(stand_in, named))
    sys.meta_path.insert(0, finder)
    try:
        with (
            mock.patch.object(import_module("rospy"), "__getattr__", _of_rospy, create=True),
            mock.patch.object(Composite, "add_child", added),
            mock.patch.object(Decorator, "__init__", decorated),
            mock.patch.object(State, "__init__", begun),
            mock.patch.object(user_data, "get_const", lambda obj: obj if stands_in(obj) else get_const(obj)),
            mock.patch.object(threading.Event, "wait", _waiting(threading.Event.wait)),
            mock.patch.object(time, "sleep", lambda seconds, sleep=time.sleep: sleep(0 if _look() else seconds)),
            mock.patch.object(stand_ins, "judge", stand_ins.Judge()),
            mock.patch.dict(os.environ, {"ROS_MASTER_URI": "http://localhost:11311", **os.environ}),  # ROS 1 sets it
        ):
            yield
    finally:
        sys.meta_path.remove(finder)
        for name in [name for name, module in sys.modules.items() if isinstance(module, StandInModule)]:
            del sys.modules[name]
        smach_ros.use(None)
        if not installed:
            smach_compat.uninstall()


class StoodIn(Behaviour):
    """In the place of a behaviour whose class isn't here: it succeeds."""

    def update(self) -> Status:
        """Succeed."""
        return Status.SUCCESS


def _behaviour(given: Any) -> Any:
    return StoodIn(given._stand_in_called or name_of(given)) if stands_in(given) else given


def _of_rospy(name: str) -> object:
    """Stand in for what our rospy hasn't."""
    if name.startswith("__"):
        raise AttributeError(name)
    return stand_in(f"rospy.{name}")


class RosTree(BehaviourTree):
    """In the place of the tree of py_trees_ros where that isn't installed."""

    def __init__(self, root: Behaviour, *given: object, **named: object):
        super().__init__(_behaviour(root))
        self.node = stand_in("node")

    def setup(self, *given: object, **named: object) -> None:
        """Set up with a node that stands in."""
        super().setup(node=self.node)


def _ros_trees(module: Any) -> None:
    trees = module if module.__name__.endswith(".trees") else module.trees
    trees.BehaviourTree = RosTree
    for package in ("diagnostic_msgs", "geometry_msgs", "sensor_msgs", "std_msgs"):
        import_module(f"{package}.msg")  # as py_trees_ros does: code takes `std_msgs.msg` for granted


@contextmanager
def dry_run_of_tree(tell: Callable[[str], object], file: Path | None) -> Iterator[None]:
    """Do the same for a tree of py_trees whose code is in a file, and for what rclpy asks of others.

    Services and actions answer whatever is wanted; a subscription or publisher of a type that isn't installed does
    nothing; the share directory of a package is its folder in the file's workspace; without `dot` no tree is drawn.
    """
    packages = workspace_of(file.resolve()).packages if file is not None else {}
    index, share = "ament_index_python.packages", "get_package_share_directory"
    with ExitStack() as patched:

        def replace(module: str, name: str, made: Callable[[Any], Any]) -> None:
            with suppress(ImportError):
                there: Any = import_module(module)
                *owner, last = name.split(".")
                there = getattr(there, owner[0]) if owner else there
                patched.enter_context(mock.patch.object(there, last, made(getattr(there, last))))

        def found(original: Any) -> Any:
            def folder(package: Any, *given: Any, **named: Any) -> Any:
                with suppress(Exception):
                    return str(packages[package]) if package in packages else original(package, *given, **named)
                return stand_in(f"the folder of {package}")

            return folder

        replace(index, share, found)
        for name, what in (("subscription", "topic"), ("publisher", "topic"), ("service", "service"), ("client", "")):
            told = partial(_told, tell, what or "service")
            replace("rclpy.node", f"Node.create_{name}", partial(_of_known_type, told=told, always=not what))
        for name in ("ActionClient", "ActionServer"):
            replace("rclpy.action", name, partial(_action, told=partial(_told, tell, "action")))
        if shutil.which("dot") is None:
            replace("py_trees.display", "render_dot_tree", lambda original: lambda *given, **named: {})
        trees = dict.fromkeys(("py_trees_ros", "py_trees_ros.trees"), _ros_trees)
        with dry_run(tell, {index: lambda module: setattr(module, share, found(None)), **trees}):
            yield


def _of_known_type(original: Callable[..., object], told: Callable[..., str], always: bool) -> Callable[..., object]:
    """Return what makes an end of ROS, but stands in for one whose type isn't known, or `always`."""

    def made(*given: Any, **named: Any) -> Any:
        unknown = any(stands_in(each) or isinstance(each, type(StandIn)) for each in (*given, *named.values()))
        return stand_in(told(*given, **named)) if unknown or always else original(*given, **named)

    return made


def _action(original: type, told: Callable[..., str]) -> Any:
    made: Any = stand_in_class(original.__name__)
    made.__init__ = lambda self, *given, **named: told(*given, **named) and None
    return made


def _told(tell: Callable[[str], object], what: str, *given: object, **named: object) -> str:
    called = next((each for each in (*given, *named.values()) if isinstance(each, str)), "?")
    tell(f"{what} {called}")
    return called
