"""The robot that a launch file brings up: the files that it and what it includes name, and what it gives them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from operator import attrgetter
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .config import RobotConfig
from .configurations import Alternative, Configurations
from .hints import Hints, hints_in, read_launch
from .packages import Packages, package_around

_INCLUDED = re.compile(r"([\w.-]+\.launch(?:\.xml|\.py|\.yaml)?)\b")
_MOST = 30
"""Launch files that are read, and URDFs of which the one that fits is looked for."""


def is_launch_file(path: Path) -> bool:
    """Tell by its name whether a file is a launch file."""
    return _INCLUDED.fullmatch(path.name) is not None


def robot_of_launch(path: Path) -> RobotConfig:
    """Return the robot that a launch file brings up; the file is read, never run.

    Raises:
        DocumentError: neither it nor what it includes names the file of a robot that is there.
    """
    home, packages = package_around(path) or path.parent, Packages({}, (path,))
    files, texts = [path], list[str]()
    while len(texts) < min(len(files), _MOST):
        texts.append(read_launch(files[len(texts)]))
        included = _named(_INCLUDED.findall(texts[-1]), home, hints_in(texts[-1]), packages)
        files += [file for file in included if file not in files]
    hints = hints_in("\n".join(texts))
    named = _named(hints.files, home, hints, packages)
    srdf = next((file for file in named if ".srdf" in file.name), None)
    urdfs = [file for file in named if ".srdf" not in file.name]
    if not urdfs:
        names = ", ".join(dict.fromkeys(hints.files)) or "no .urdf, .xacro or .srdf"
        raise DocumentError(
            f"no robot's file is found that it brings up (it names {names}); choose the URDF itself", str(path)
        )
    found = Configurations(home, packages, hints)
    chosen = (found.fitted(Alternative(path.name.split(".")[0], srdf, urdf=urdf)) for urdf in urdfs[:_MOST])
    best = max(chosen, key=attrgetter("fit"))
    assert best.urdf is not None
    config = srdf and package_around(srdf)
    said = {
        "moveit": config and config != package_around(best.urdf) and str(config),
        "urdf" if best.urdf.suffix == ".urdf" else "xacro": str(best.urdf),
        "srdf": srdf and str(srdf),
        "arguments": dict(best.arguments),
    }
    return RobotConfig.model_validate({key: value for key, value in said.items() if value})


def _named(names: Iterable[str], home: Path, hints: Hints, packages: Packages) -> list[Path]:
    """Return the files of some names, in a package and those that its launch files look up."""
    folders = dict.fromkeys([home, *filter(None, map(packages.known, hints.packages))])
    return [file for name in dict.fromkeys(names) for folder in folders for file in sorted(folder.rglob(name))]
