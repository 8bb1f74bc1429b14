"""A repository for a component that isn't written yet: files of `repository/` under the component's own name."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

from grip_bt.base.errors import GripError, ProjectExistsError

Language = Literal["python", "cpp"]
_TEMPLATES = Path(__file__).with_name("repository")
_NAME, _CAMEL = "component_name", "ComponentName"


def make_repository(folder: Path, name: str, language: Language) -> list[Path]:
    """Write a component that works, to be changed into one's own.

    Args:
        folder: made; it isn't there yet, or is empty.
        name: of the component: lower case, digits and underscores.
        language: of its server.

    Returns:
        the files written, relative to the folder.

    Raises:
        GripError: the name can't be one.
        ProjectExistsError: the folder holds something.
    """
    if not re.fullmatch(r"[a-z](_?[a-z0-9]+)*", name):
        words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
        could_be = re.sub(r"^[0-9_]+|_+$", "", re.sub(r"[^a-z0-9]+", "_", words))
        such = f", such as {could_be}" if could_be else ""
        raise GripError(
            f"{name!r} can't name a component: lower case letters, digits and single _, a letter first{such}"
        )
    if folder.exists() and (not folder.is_dir() or any(entry.name != ".git" for entry in folder.iterdir())):
        raise ProjectExistsError(folder)
    camel = "".join(part.capitalize() for part in name.split("_"))
    written = []
    root = _TEMPLATES / language
    for source in sorted(file for file in root.rglob("*") if file.is_file() and "__pycache__" not in file.parts):
        text = _named(source.relative_to(root).as_posix(), name, camel)
        relative = Path(".gitignore") if text == "gitignore" else Path(text)
        target = folder / relative
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(_named(source.read_text(encoding="utf-8"), name, camel), encoding="utf-8")
        written.append(relative)
    return written


def _named(text: str, name: str, camel: str) -> str:
    return text.replace(_NAME, name).replace(_CAMEL, camel)
