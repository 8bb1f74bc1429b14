"""What legacy programs import of ROS 1, over the same connection as `smach_ros`: `rospy`, `roslib`, `actionlib`, `tf`.

Services, topics, actions and frames are those of ROS 2. What ROS 2 has no equal of is kept in the process: parameters.
The package itself is `roslib`.
"""

from __future__ import annotations

import importlib
import sys
from functools import partial
from pathlib import Path
from types import ModuleType

from grip_bt.smach_compat._install import Provided
from grip_bt.smach_compat._settings import settings

from . import _messages

_MODULES = {
    "rospy": ("", ".core", ".exceptions", ".rostime", ".service", ".timer", ".topics", ".client"),
    "actionlib": ("", ".simple_action_client", ".simple_action_server"),
    "tf": ("", ".listener", ".broadcaster", ".transformations"),
}
"""Module -> the names below it under which programs import it too."""


def _module(name: str) -> ModuleType:
    settings.rospy = True  # from the first import of one of them, and not in programs that import none
    return importlib.import_module(f"{__name__}.{name}" if name else __name__)


_PROVIDED = Provided(
    {f"{name}{below}": partial(_module, name) for name, all_below in _MODULES.items() for below in all_below}
    | {name: partial(_module, "") for name in ("roslib", "roslib.packages")}
)


def begin() -> None:
    """Have them found where no others are."""
    _PROVIDED.begin()
    _messages.begin()


def end() -> None:
    """Have them found no more."""
    _PROVIDED.end()
    _messages.end()


packages = sys.modules[__name__]


class InvalidROSPkgException(Exception):
    """A package isn't there."""


def load_manifest(package_name: str) -> None:
    """Do nothing; of ROS 1 it put a package's Python on the path."""


def get_pkg_dir(package: str, required: bool = True) -> str | None:
    """Return the folder of a package, found by its `package.xml` around the folders that Python looks in.

    Raises:
        InvalidROSPkgException: it isn't there, and `required`.
    """
    for entry in dict.fromkeys(sys.path):
        here = Path(entry).resolve()
        for folder in (here, *here.parents[:3]):
            for found in (folder, folder / package, folder / "src" / package, folder / "share" / package):
                if found.name == package and (found / "package.xml").is_file():
                    return str(found)
    if required:
        raise InvalidROSPkgException(f"there is no package {package!r} around sys.path")
    return None
