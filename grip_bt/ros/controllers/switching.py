"""The controller manager of ros2_control: which controllers are active, and switching between them."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import Any

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.operation import Operation

from ..client.bus import Bus
from ..client.types import load_type
from ..interfaces.build import provide

STRICT = 2
ANSWER = 10.0


class SwitchError(ExpectedError):
    """The controller manager didn't switch; `data` tells what was asked."""

    code = "not_switched"


class ControllerManager:
    """Asks a controller manager.

    Args:
        bus: the connection to ROS.
        name: of its node.
        wait: how long to wait for it to appear [s].
    """

    def __init__(self, bus: Bus, name: str = "/controller_manager", wait: float = 5.0):
        provide("controller_manager_msgs")
        self._bus, self._name, self._wait = bus, name, wait

    def states(self) -> Operation[dict[str, str]]:
        """Return the state (`unconfigured`, `inactive`, `active`, `finalized`) of each loaded controller."""
        return self._ask("list_controllers", "ListControllers").then(
            lambda answer: Operation.finished({c.name: c.state for c in answer.controller})
        )

    def switch(self, activate: Collection[str], deactivate: Collection[str] = ()) -> Operation[None]:
        """Activate and deactivate controllers in one step, all or none. Ends with SwitchError when it doesn't work."""

        def check(answer: Any) -> Operation[None]:
            if answer.ok:
                return Operation.finished(None)
            asked = f"activate {', '.join(activate) or 'none'}, deactivate {', '.join(deactivate) or 'none'}"
            said = getattr(answer, "message", "")
            reason = f"{self._name} didn't {asked}{f': {said}' if said else ''}"
            return Operation.failed(SwitchError(reason, activate=list(activate), deactivate=list(deactivate)))

        fields = {
            "activate_controllers": list(activate),
            "deactivate_controllers": list(deactivate),
            "strictness": STRICT,
            "activate_asap": True,
        }
        return self._ask("switch_controller", "SwitchController", **fields).then(check)

    def ensure_active(self, wanted: Collection[str], instead_of: Collection[str] = ()) -> None:
        """Block until the wanted controllers are active, and those of `instead_of` aren't; for start-up.

        Raises:
            UnknownNameError: one isn't loaded.
            SwitchError: it can't be activated.
            ServerLostError, ServerTimeOutError: the manager isn't there, or doesn't answer.
        """
        states = self._wait_for(self.states())
        for name in wanted:
            if name not in states:
                raise UnknownNameError("controller", name, states, self._name)
        start = [name for name in wanted if states[name] != "active"]
        stop = [name for name in instead_of if states.get(name) == "active"]
        if start or stop:
            self._wait_for(self.switch(start, stop))

    def _ask(self, service: str, type_: str, **fields: Any) -> Operation[Any]:
        cls = load_type(f"controller_manager_msgs/srv/{type_}")
        client = self._bus.service(cls, f"{self._name}/{service}")
        return client.call(cls.Request(**fields), ANSWER, self._wait)

    def _wait_for(self, operation: Operation[Any]) -> Any:
        began = time.monotonic()
        if not operation.wait(ANSWER + self._wait + 1.0):
            raise GripError(f"{self._name} didn't answer within {time.monotonic() - began:.0f} s")
        return operation.result()
