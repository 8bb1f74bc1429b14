"""The robot that a launch file brings up: the files that it and what it includes name, and what it gives them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from grip_bt.base.errors import DocumentError, MissingPartError

from .config import RobotConfig
from .configurations import Alternative, Configurations, is_configured
from .hints import hints_in, read_launch
from .packages import Packages, package_around

ENDS = (".launch", ".launch.xml", ".launch.py", ".launch.yaml")
_INCLUDED = re.compile(r"([\w.-]+\.launch(?:\.xml|\.py|\.yaml)?)\b")
_MOST = 30


def is_launch_file(path: Path) -> bool:
    """Tell by its name whether a file is a launch file."""
    return path.name.endswith(ENDS)


def robot_of_launch(path: Path) -> RobotConfig:
    """Return the robot that a launch file brings up; the file is read, never run.

    Raises:
        DocumentError: neither it nor what it includes names the file of a robot that is there.
    """
    home = package_around(path) or path.parent
    packages = Packages({}, (path,))
    hints = hints_in("\n".join(_texts(path, home, packages)))
    folders = [home, *(folder for name in hints.packages if (folder := _folder(packages, name)) is not None)]
    named = [
        file
        for name in dict.fromkeys(hints.files)
        for folder in dict.fromkeys(folders)
        for file in sorted(folder.rglob(name))
    ]
    srdf = next((file for file in named if ".srdf" in file.name), None)
    urdfs = [file for file in named if ".srdf" not in file.name]
    if srdf is None:
        srdf = next(
            (file for folder in folders if is_configured(folder) for file in sorted(folder.rglob("*.srdf*"))), None
        )
    if not urdfs:
        said = ", ".join(dict.fromkeys(hints.files)) or "no .urdf, .xacro or .srdf"
        raise DocumentError(
            f"no robot's file is found that it brings up (it names {said}); choose the URDF itself", str(path)
        )
    found = Configurations(home, packages, hints)
    best = max(
        (found.fitted(Alternative(path.name.split(".")[0], srdf, urdf=urdf)) for urdf in urdfs[:3]),
        key=lambda each: each.fit,
    )
    assert best.urdf is not None
    config = None if srdf is None else package_around(srdf)
    return RobotConfig(
        **{"urdf" if best.urdf.suffix == ".urdf" else "xacro": str(best.urdf)},
        **({"srdf": str(srdf)} if srdf is not None else {}),
        **({"moveit": str(config)} if config is not None and config != package_around(best.urdf) else {}),
        **({"arguments": dict(best.arguments)} if best.arguments else {}),
    )


def _texts(path: Path, home: Path, packages: Packages) -> Iterator[str]:
    """Yield the launch file's text, then those of the files that it includes."""
    todo, seen = [path], {path}
    while todo and len(seen) < _MOST:
        text = read_launch(todo.pop(0))
        yield text
        near = [home, *(folder for name in hints_in(text).packages if (folder := _folder(packages, name)) is not None)]
        for name in _INCLUDED.findall(text):
            for file in (file for folder in near for file in sorted(folder.rglob(name)) if file not in seen):
                seen.add(file)
                todo.append(file)


def _folder(packages: Packages, name: str) -> Path | None:
    try:
        return packages.find(name)
    except MissingPartError:
        return None
