"""Legacy SMACH states as leaves: the object runs as it is, in a thread of its own, with its userdata bound to ports.

What it reads comes from the bound variables when it reads; what it writes is written when it ends. A halt can't stop a
blocking `execute`: what it still writes and returns is dropped, and until its thread ends the leaf is a *zombie*, which
isn't entered a second time; nor does anything begin that moves.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, ClassVar

from py_trees.common import Status

from grip_bt.nodes.smach_activation import RUNS_LOCK, AmongStates, KeysLeaf
from grip_bt.nodes.stand_ins import are_wanted, stand_in
from grip_bt.smach_compat._settings import settings

from .smach_activation import Activation, Values
from .smach_asking import Iteration, Together

_log = logging.getLogger(__name__)
_INVALID = re.compile(r"[^A-Za-z0-9_ -]")


def task_name(label: str) -> str:
    """Return a SMACH label as a task may spell it: other characters become `_`, and it begins with a letter or `_`."""
    name = _INVALID.sub("_", label)
    return name if name and (name[0].isalpha() or name[0] == "_") else f"_{name}"


def argument(name: str) -> Any:
    """Return what stands for an argument that nobody has given, where stand-ins are wanted."""
    if are_wanted():
        return stand_in(name)
    raise NotImplementedError(
        f"what builds the machine needs `{name}`: put it here in leaves.py in the place of argument({name!r}), import"
        f" again with --arguments, or run on stand-ins"
    )


class SmachLeaf(KeysLeaf):
    """A leaf that runs one SMACH state, or a whole container; generated classes override `make`.

    The manifest's inputs and outputs are the state's keys.

    Attributes:
        state: the legacy object, made once per run and never reset.
        first: key -> a function of the leaf that gives the value of an unwritten variable, for values that a task can't
            hold; it is asked once per run.
    """

    state: Any = None
    first: ClassVar[Mapping[str, Callable[[Any], Any]]] = {}
    _activation: Activation | None = None
    _zombie: Activation | None = None
    _relives = False
    _halted = False

    def make(self) -> Any:
        """Return the legacy state."""
        raise NotImplementedError(f"{type(self).__name__}.make: return the SMACH state")

    def built(self, factory: Callable[..., Any], *arguments: object, **named: object) -> Any:
        """Return the container that `factory` builds, one for all leaves of the run, so that they share its objects."""
        with RUNS_LOCK:
            run = self.asking
            if factory not in run.built:
                run.built[factory] = factory(*arguments, **named)
            return run.built[factory]

    def prepare(self) -> None:
        self.state = self.make()
        wanted = {task_name(label) for label in self.state.get_registered_outcomes()}
        self._agree("outcomes", wanted, self.meaning)
        self._agree("input keys", self.state.get_registered_input_keys(), self.manifest.inputs)
        self._agree("output keys", self.state.get_registered_output_keys(), self.manifest.outputs)

    def _agree(self, what: str, of_state: Iterable[str], of_manifest: Iterable[str]) -> None:
        if missing := sorted(set(of_state) - set(of_manifest)):
            raise TypeError(
                f"the state has the {what} {missing}, which the manifest of {self.manifest.id} lacks; "
                "add them there, or import the file again"
            )

    def at_first(self, key: str) -> tuple[bool, Any]:
        return (True, self.built(self.first[key], self)) if key in self.first else (False, None)

    def initialise(self) -> None:
        """Begin anew; the thread is started by `update`, which may have to wait for a zombie."""
        self._activation = self._since = None

    def update(self) -> Status:
        if self._activation is None:
            if self._zombie is not None and not self._zombie.done():
                return self.running("waiting for the interrupted execute() to return")
            if paths := self.still_to_stop():
                return self.running(f"waits for {', '.join(paths)} to stop")
            self._bury()
            with self.asking.lock:  # a request finds it running, or comes before it begins
                self.asking.begin(self.enclosing, self, self.requests())
                self._ask_here()
                self._activation = Activation(self.state, Values(self), self.path, self.context.wake)
                self._relives = False
            self._activation.start()
        activation = self._activation
        if activation.done():
            return self._take(activation)
        self.asking.arrive(self.requests())
        self._ask_here()
        return self.running()

    def _ask_here(self) -> None:
        if self.asked_here():
            with self.asking.lock:
                outermost = self.asking.container(self.enclosing[0]) if self.enclosing else self
                outermost.request_preempt()

    def request_preempt(self) -> None:
        try:
            self.state.request_preempt()
        except Exception:  # noqa: BLE001 - the task goes on, as SMACH does
            _log.exception("%s: request_preempt() raised", self.path)

    def preempt_requested(self) -> bool:
        return bool(self.state.preempt_requested())

    def recall_preempt(self) -> None:
        self.state.recall_preempt()

    def is_running(self) -> bool:
        activation = self._activation
        return self._relives or (activation is not None and not activation.over.done())

    def replay_begun(self) -> None:
        """Be among what runs, with the flag that it began with."""
        with self.asking.lock:
            self._bury()
            self._relives = True
            self.asking.begin(self.enclosing, self, self.requests())
            self._ask_here()

    def replay_ended(self, outcome: str | None) -> None:
        """Bring the flags to where the activation left them; a state that ended `preempted` has answered."""
        with self.asking.lock:
            if not self._relives:
                self.replay_begun()
            self.asking.arrive(self.requests())
            self._ask_here()
            self._relives = False
            if outcome == "preempted":
                self.recall_preempt()
            elif outcome is None:
                self._ask_to_return()

    def _take(self, activation: Activation) -> Status:
        if isinstance(activation.error, Exception):
            raise activation.error
        if activation.error is not None:
            raise RuntimeError(f"execute() raised {type(activation.error).__name__}") from activation.error
        if not isinstance(activation.result, str):
            raise TypeError(f"execute() returned {activation.result!r} and not one of its outcomes")
        return self.end(task_name(activation.result), **activation.values.written)

    def terminate(self, new_status: Status) -> None:
        """Leave an `execute` that can't be stopped to its thread: flag set, its writes and outcome dropped."""
        activation, self._activation = self._activation, None
        if new_status == Status.INVALID and activation is not None and not activation.done():
            self._zombie = activation
            activation.over.cancel()
            if self.manifest.may_move:
                self.context.left(self.path, activation.over)
            self._ask_to_return()
            self.observer.message(self.path, "interrupted: execute() was asked to return and still runs")

    def _ask_to_return(self) -> None:
        self._halted = True
        self.state.request_preempt()
        for state in with_all_below(self.state):
            if hasattr(state, "request_halt"):  # it ticks a tree of ours, which can be halted
                state.request_halt()

    @property
    def zombie(self) -> bool:
        return self._zombie is not None and not self._zombie.done()

    def _bury(self) -> None:
        if self._halted:
            for state in with_all_below(self.state):
                state.recall_preempt()
                if hasattr(state, "recall_halt"):
                    state.recall_halt()
            self._zombie, self._halted = None, False

    def shutdown(self) -> None:
        """Name what is left running; nobody can end it."""
        if self.zombie:
            _log.warning("%s: execute() was interrupted and still runs in the thread smach:%s", self.path, self.path)


def with_all_below(state: object) -> Iterator[Any]:
    """Yield a state, and all that are in it."""
    yield state
    for child in state.get_children().values() if hasattr(state, "get_children") else ():
        yield from with_all_below(child)


class NextItem(AmongStates):
    """Hand out the items of an iteration one by one: `item` with the next, `exhausted` after the last.

    After an item in which a preempt was requested it ends with `preempted`: SMACH leaves an Iterator then, with the
    outcome of its state. The parameter `leaves_by` names one that isn't the Iterator's, which SMACH stumbles over.
    """

    def update(self) -> Status:
        items, position = self.params["items"], self.read("position")
        around = None
        if self.enclosing:
            self.asking.begin(self.enclosing, None, self.requests())
            around = self.asking.container(self.enclosing[-1])
        if position and around is not None and around.preempt_requested() and "preempted" in self.meaning:
            if outcome := self.params["leaves_by"]:
                raise RuntimeError(
                    f"a preempt was requested, with which SMACH leaves an Iterator by the outcome of its state, "
                    f"{outcome!r}, which is none of the Iterator's; say what it means in its final_outcome_map"
                )
            return self.fail("preempted", "a preempt was requested", outcome="preempted")
        if position >= len(items):
            if isinstance(around, Iteration):
                around.exhausted = True
            return self.fail("exhausted", "there are no more items", outcome="exhausted")
        return self.end("item", item=items[position], position=position + 1)

    def replay_ended(self, outcome: str | None) -> None:
        if self.enclosing:
            self.asking.begin(self.enclosing, None, self.requests())
            around = self.asking.container(self.enclosing[-1])
            if outcome == "exhausted" and isinstance(around, Iteration):
                around.exhausted = True


class Obeyed(AmongStates):
    """The last child of what was a Concurrence: `preempted` where a request was obeyed by all others, else `others`.

    It ends when they have ended. The parameter `allowed` is false where `preempted` isn't an outcome of the
    Concurrence; SMACH ends with it all the same, and stumbles over it. ROS 2's SMACH never does.
    """

    def update(self) -> Status:
        asking = self.asking
        if self.status != Status.RUNNING:
            asking.begin(self.enclosing, None, self.requests())
        asking.arrive(self.requests())
        if not self.enclosing or self.enclosing[-1].unfinished() > 1:
            return self.running() if self.enclosing else self.end("others")
        around = asking.container(self.enclosing[-1])
        with asking.lock:
            obeyed = isinstance(around, Together) and around.obeyed()
        if not obeyed or settings.ros2:
            return self.end("others")
        if not self.params["allowed"]:
            raise RuntimeError(
                "a preempt was requested and obeyed, after which SMACH ends a Concurrence with 'preempted', "
                "which is none of its outcomes; add it to them"
            )
        return self.fail("preempted", "a preempt was requested and obeyed", outcome="preempted")

    def replay_ended(self, outcome: str | None) -> None:
        if outcome is None or not self.enclosing:
            return
        asking = self.asking
        with asking.lock:
            asking.begin(self.enclosing, None, self.requests())
            around = asking.container(self.enclosing[-1])
            if isinstance(around, Together):
                around.obeyed()
                if outcome == "preempted":
                    around.recall_preempt()


class CopyKeys(KeysLeaf):
    """Copy inputs to the outputs of the same names, as SMACH does when it enters a container."""

    def update(self) -> Status:
        found = {key: self.look_up(key) for key in self.manifest.inputs}
        return self.end("done", **{key: value for key, (there, value) in found.items() if there})
