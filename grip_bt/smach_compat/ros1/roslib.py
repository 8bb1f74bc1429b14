"""`roslib`: ROS 2's packages are found by Python, so that there is nothing to load."""

from __future__ import annotations

import sys
from pathlib import Path

packages = sys.modules[__name__]
"""Its sub-module is itself."""


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
