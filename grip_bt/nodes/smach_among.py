"""Leaves among states of SMACH: what those of one run share, and how keys of userdata are looked up."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

from grip_bt.base.errors import DataError

from .leaf import Leaf
from .smach_asking import Asking, Enclosing


class SharedByRun:
    """What the SMACH leaves of one run share.

    Attributes:
        asking: the flags of preempt requests.
        built: what builds a legacy container -> the container that it has built.
    """

    def __init__(self) -> None:
        self.asking = Asking()
        self.built: dict[Callable[..., Any], Any] = {}


_runs: WeakKeyDictionary[Any, SharedByRun] = WeakKeyDictionary()
RUNS_LOCK = threading.RLock()
"""Held while what a run shares is looked up or made."""


class AmongStates(Leaf):
    """A leaf that takes part in how containers of SMACH hand on a preempt request.

    Attributes:
        enclosing: the containers around it that were SMACH's, outermost first; given by the compiler.
    """

    enclosing: Sequence[Enclosing] = ()
    _asked_here = False

    @property
    def asking(self) -> Asking:
        """The flags of the run."""
        with RUNS_LOCK:
            return self.shared().asking

    def shared(self) -> SharedByRun:
        """Return what the leaves of this leaf's run share; under `RUNS_LOCK`."""
        # A run has one clock; contexts are wrapped for states of a machine.
        return _runs.setdefault(self.context.clock, SharedByRun())

    def requests(self) -> int:
        """Return how many preempt requests the run has had."""
        counted = getattr(self.context, "preempt_requests", None)
        return int(self.context.preempt_requested if counted is None else counted)

    def asked_here(self) -> bool:
        """Tell whether something above has begun to ask just what is below it: a parallel, a state that is a task."""
        asked = any(asker.asked for asker in self.askers) or (not self.requests() and self.context.preempt_requested)
        new, self._asked_here = asked and not self._asked_here, asked
        return new


class KeysLeaf(AmongStates):
    """A leaf whose ports are keys of userdata: a variable that isn't written is a missing key and no error.

    The parameter `unwritten` lists inputs whose variable may not have been written yet: None there is a missing key.
    """

    def look_up(self, key: str) -> tuple[bool, Any]:
        """Return whether the variable of an input has been written, and its value."""
        if key not in self.readers:
            return False, None
        try:
            value = self.read(key)
        except DataError:
            value = None
        else:
            if value is not None or key not in self.params.get("unwritten", ()):
                return True, value
        return self.at_first(key)

    def at_first(self, key: str) -> tuple[bool, Any]:
        """Return whether an unwritten variable has a value all the same, and that value."""
        return False, None
