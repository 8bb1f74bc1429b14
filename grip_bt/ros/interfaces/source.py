"""Where a folder of interface packages defines a type."""

from __future__ import annotations

from pathlib import Path

from .package import find_packages


def interface_file(folder: Path, type_name: str) -> Path | None:
    """Return the file that defines a type such as `my_interfaces/srv/Grasp`; None when no package in `folder` does.

    Raises:
        DocumentError: a package there is broken.
    """
    if not folder.is_dir():
        return None
    package_name, kind, name = type_name.split("/")
    for package in find_packages(folder):
        if package.name == package_name:
            for file in package.files:
                if file.as_posix() == f"{kind}/{name}.{kind}":
                    return package.folder / file
    return None
