"""`smach_msgs` for programs that import it where it isn't installed; its messages are made when one of them is used."""

from __future__ import annotations

import sys
from functools import partial
from types import FrameType, ModuleType
from typing import Any

from grip_bt.smach_compat._provided import Provided

from ._connection import ros

_MESSAGES = {
    "SmachContainerStatus": "Status",
    "SmachContainerStructure": "Structure",
    "SmachContainerInitialStatusCmd": "Command",
}


class _Messages(ModuleType):
    __path__: list[str] = []

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":
            return sorted(_MESSAGES.keys() & _used_by(sys._getframe(1)))
        if name in _MESSAGES:
            return getattr(ros().introspection(), _MESSAGES[name])
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


def _used_by(frame: FrameType | None) -> set[str]:
    """Return the names in the code of the module that imports; so a star import of nothing used builds nothing."""
    while frame is not None and (frame.f_code.co_name != "<module>" or frame.f_globals["__name__"] == __name__):
        frame = frame.f_back
    todo, names = [] if frame is None else [frame.f_code], set[str]()
    while todo:
        code = todo.pop()
        names.update(code.co_names)
        todo += [each for each in code.co_consts if hasattr(each, "co_names")]
    return names


PROVIDED = Provided({name: partial(_Messages, name) for name in ("smach_msgs", "smach_msgs.msg")})
"""Ends before the messages themselves are loaded."""
