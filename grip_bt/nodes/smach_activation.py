"""One call of a legacy state's execute, its thread and its userdata, and what the states of one run share."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

from grip_bt.base.errors import DataError
from grip_bt.base.operation import Operation
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.smach_asking import Asking, Enclosing
from grip_bt.smach_compat import Remapper, UserData

_runs: WeakKeyDictionary[Any, Asking] = WeakKeyDictionary()
RUNS_LOCK = threading.RLock()
"""Held while what a run shares is looked up or made."""


class AmongStates(Leaf):
    """A leaf that takes part in how containers of SMACH hand on a preempt request.

    `enclosing`: the containers around it that were SMACH's, outermost first; given by the compiler.
    """

    enclosing: Sequence[Enclosing] = ()
    _asked_here = False

    @property
    def asking(self) -> Asking:
        """What the leaves of this leaf's run share: its flags."""
        with RUNS_LOCK:  # a run has one clock; contexts are wrapped for states of a machine
            return _runs.setdefault(self.context.clock, Asking())

    def requests(self) -> int:
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
        return False, None


class Values:
    """The userdata of one activation: reads go to the ports, writes are kept until the end."""

    def __init__(self, leaf: KeysLeaf):
        self._leaf = leaf
        self.written: dict[str, Any] = {}

    def __getitem__(self, key: str) -> Any:
        if key in self.written:
            return self.written[key]
        found, value = self._leaf.look_up(key)
        if not found:
            raise KeyError(key)
        return value

    def __setitem__(self, key: str, value: object) -> None:
        self.written[key] = value

    def __contains__(self, key: object) -> bool:
        return key in self.written or self._leaf.look_up(str(key))[0]

    def keys(self) -> list[str]:
        return [key for key in self._leaf.manifest.inputs if key in self]

    def update(self, ud: UserData) -> None:
        self.written.update({key: ud[key] for key in ud.keys()})


class Activation:
    """One call of `execute` in its thread; `over` ends when it returns, and nobody can cancel it."""

    def __init__(self, state: Any, values: Values, name: str, wake: Callable[[], None]):
        self.values = values
        self.result: Any = None
        self.error: BaseException | None = None
        self.over: Operation[None] = Operation(on_cancel=lambda: None)
        inputs, outputs = state.get_registered_input_keys(), state.get_registered_output_keys()

        def work() -> None:
            try:
                self.result = state.execute(Remapper(values, inputs, outputs))
            except BaseException as error:  # noqa: BLE001 - raised again in the thread of the task
                self.error = error
            self.over.succeed(None)
            wake()

        self._thread = threading.Thread(target=work, name=f"smach:{name}", daemon=True)

    def start(self) -> None:
        """Begin; whoever asks the state from now on has to know that it is executed."""
        self._thread.start()

    def done(self) -> bool:
        return self.over.done()
