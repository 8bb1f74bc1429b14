"""The legacy files around the one that is imported: modules are found by name, read once, and run by nobody."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.nodes.smach_source import Source, read_source

from .names import Scope

SMACH = {
    **{name: f"smach.{name}" for name in ("State", "CBState", "StateMachine", "Sequence", "Concurrence", "Iterator")},
    **{name: f"smach.{name}" for name in ("Container", "UserData", "Remapper", "cb_interface", "CBInterface")},
    **{name: f"smach.{name}" for name in ("set_loggers", "set_shutdown_check", "has_smach_interface")},
}
SMACH_ROS = {
    name: f"smach_ros.{name}"
    for name in (
        *("SimpleActionState", "ServiceState", "MonitorState", "ConditionState", "RosState"),
        *("ActionServerWrapper", "IntrospectionServer", "IntrospectionClient", "set_preempt_handler"),
    )
}


@dataclass
class Project:
    """Files by module name.

    Attributes:
        root: the folder in which modules are looked for, besides the importing file's own.
        scopes: the modules that have been read.
    """

    root: Path
    sources: dict[Path, Source] = field(default_factory=dict)
    scopes: dict[Path, Scope] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._roots = [self.root, self.root / "src", *sorted(self.root.glob("*/src"))]

    def source(self, file: Path) -> Source:
        """Read a file, once.

        Raises:
            DocumentError: it isn't Python.
        """
        if file not in self.sources:
            self.sources[file] = read_source(file)
        return self.sources[file]

    def find(self, module: str, beside: Path, level: int = 0) -> Path | None:
        """Return the file of a module; None when it isn't part of the project."""
        parts = [p for p in module.split(".") if p]
        folders = [beside.parent]
        for _ in range(level - 1):
            folders = [folders[0].parent]
        if level == 0:
            folders += self._roots
        for folder in folders:
            for candidate in (folder.joinpath(*parts).with_suffix(".py"), folder.joinpath(*parts, "__init__.py")):
                if parts and candidate.is_file() and self._readable(candidate):
                    return candidate
        return None

    def _readable(self, file: Path) -> bool:
        try:
            self.source(file)
        except DocumentError:
            return False
        return True
