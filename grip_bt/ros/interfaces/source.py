"""Where a folder of interface packages defines a type."""

from __future__ import annotations

from pathlib import Path

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.task.catalog.ros_config import FieldSpec

from .definition import read_interface
from .package import KINDS, find_packages


def interface_file(folder: Path, type_name: str) -> Path | None:
    """Return the file that defines a type such as `my_interfaces/srv/Grasp`; None when its package isn't in `folder`.

    Raises:
        DocumentError: a package there is broken, or is the type's and doesn't define it.
    """
    if not folder.is_dir():
        return None
    package_name, kind, name = type_name.split("/")
    for package in find_packages(folder):
        if package.name == package_name:
            for file in package.files:
                if file.as_posix() == f"{kind}/{name}.{kind}":
                    return package.folder / file
            known = [f"{package_name}/{file.parent}/{file.stem}" for file in package.files]
            hint = nearest(name, [file.stem for file in package.files])
            raise DocumentError(f"defines no {type_name}{hint} (it defines: {listing(known)})", str(package.folder))
    return None


def fields_within(folder: Path | None, message: str) -> tuple[FieldSpec, ...] | None:
    """Return the fields of a message that a folder of packages defines, or that is installed; None for any other.

    Args:
        folder: the interface packages; None for installed ones only.
        message: its type, such as `geometry_msgs/msg/Pose`.
    """
    if message.count("/") != 2 or message.split("/")[1] not in KINDS:
        return None
    try:
        return read_interface((folder and interface_file(folder, message)) or message).request
    except DocumentError:
        return None  # a build says what is wrong with it
