"""Make this package the module `smach` of the process, so that legacy code runs on it unchanged. Never by default."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from grip_bt import smach_compat as smach
from grip_bt.errors import GripError

from ._settings import Settings, configure

SUBMODULES = (
    "concurrence",
    "container",
    "exceptions",
    "iterator",
    "log",
    "sequence",
    "state",
    "state_machine",
    "user_data",
    "util",
)


def _modules() -> dict[str, ModuleType]:
    return {"smach": smach, **{f"smach.{name}": getattr(smach, name) for name in SUBMODULES}}


def install(**changes: Any) -> None:
    """Let `import smach` and `import smach.<module>` find this package; harmless when it was done before.

    Args:
        **changes: settings, see `configure`.

    Raises:
        GripError: another `smach` has been imported already; code that has it would go on with it.
    """
    present = sys.modules.get("smach")
    if present is not None and present is not smach:
        raise GripError(
            f"smach is imported already, from {getattr(present, '__file__', 'somewhere')}; "
            "call install() before anything imports it"
        )
    configure(**changes)
    sys.modules.update(_modules())


def uninstall() -> None:
    """Undo `install`, and put the settings back; who has imported the names keeps them."""
    for name, module in _modules().items():
        if sys.modules.get(name) is module:
            del sys.modules[name]
    configure(**vars(Settings()))
