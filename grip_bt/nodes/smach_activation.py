"""One call of a legacy state's `execute`: its thread, and the userdata that it sees."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from grip_bt.base.operation import Operation
from grip_bt.smach_compat import Remapper, UserData

from .smach_among import KeysLeaf


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

    def __setitem__(self, key: str, value: Any) -> None:
        self.written[key] = value

    def __contains__(self, key: object) -> bool:
        return key in self.written or self._leaf.look_up(str(key))[0]

    def keys(self) -> list[str]:
        """Return the keys that have been written."""
        return [key for key in self._leaf.manifest.inputs if key in self]

    def update(self, ud: UserData) -> None:
        """Write what another store holds."""
        self.written.update({key: ud[key] for key in ud.keys()})


class Activation:
    """One call of `execute` in its thread.

    Attributes:
        over: ends when `execute` returns; nobody can cancel it.
    """

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
        """Whether the task may go on."""
        return self.returned()

    def returned(self) -> bool:
        """Whether `execute` has returned."""
        return self.over.done()
