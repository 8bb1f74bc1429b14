"""What makes a project a ROS package that colcon builds; its own `setup.py` says what of it is installed."""

from __future__ import annotations

import re
from pathlib import Path

from grip_bt.base.errors import GripError

_TEMPLATE = Path(__file__).with_name("ros_template")


def ros_files(folder: Path) -> dict[str, str]:
    """Return path in the project -> text of the files of a package that is called as the folder is.

    Raises:
        GripError: a ROS package can't be called so.
    """
    name = folder.resolve().name.lower().replace("-", "_")
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        rule = "letters, digits and underscores, a letter first"
        raise GripError(f"{folder}: a ROS package is called as its folder, and {name!r} isn't a name of one: {rule}")
    return {
        "package.xml": (_TEMPLATE / "package.xml").read_text(encoding="utf-8").replace("NAME", name),
        "setup.py": (_TEMPLATE / "setup.py.in").read_text(encoding="utf-8"),
        f"resource/{name}": "",
    }
