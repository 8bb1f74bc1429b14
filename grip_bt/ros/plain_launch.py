"""A launch file of one program, such as a component's own, for those without ROS's tools."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from pathlib import Path

from grip_bt.base.xml import parse_xml
from grip_bt.ros.interfaces.packages import PackageError

_VARIABLE, _PLACE = re.compile(r"\$\(var +(\w+)\)"), re.compile(r"\$\((\w+)\)")


def program_of(file: Path, given: Mapping[str, str]) -> list[str]:
    """Return the command of an `.xml` launch file that has arguments and one `<executable cmd=...>`.

    Raises:
        PackageError: it has something else, which takes `ros2 launch`, or an argument lacks its value.
        DocumentError: it is no XML.
    """
    elements = list(parse_xml(file.read_bytes(), str(file))) if file.suffix == ".xml" else []
    programs = [element for element in elements if element.tag == "executable"]
    if len(programs) != 1 or not {element.tag for element in elements} <= {"arg", "executable"}:
        how = "source a ROS that has it (source /opt/ros/jazzy/setup.bash), or say what to start by `command:`"
        raise PackageError(f"{file}: launch files are run by `ros2 launch`, which isn't on the path; {how}")
    known = {each.get("name", ""): each.get("default") for each in elements if each.tag == "arg"} | dict(given)
    if lacking := sorted(name for name, value in known.items() if value is None):
        raise PackageError(f"{file}: its argument {lacking[0]!r} has no value; give one under `arguments:`")
    values = {"dirname": str(file.parent), **{f"var_{name}": str(value) for name, value in known.items()}}
    words = shlex.split(_VARIABLE.sub(r"$(var_\1)", programs[0].get("cmd", "")))
    return [_PLACE.sub(lambda at: values.get(at[1], at[0]), word) for word in words]
