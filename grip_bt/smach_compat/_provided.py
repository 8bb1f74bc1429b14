"""Modules of ours under other packages' names, found where no such package is installed or imported."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType


class Provided(MetaPathFinder, Loader):
    """Asked after all other finders that are there.

    Args:
        makers: name of a module -> what returns it.
    """

    def __init__(self, makers: Mapping[str, Callable[[], ModuleType]]):
        self.makers = dict(makers)
        self._made: dict[str, ModuleType] = {}

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Find a module that is provided, and none below a package that is somebody else's."""
        package = fullname.partition(".")[0]
        theirs = package != fullname and sys.modules.get(package) is not self._made.get(package)
        return ModuleSpec(fullname, self, is_package=True) if fullname in self.makers and not theirs else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        self._made[spec.name] = module = self.makers[spec.name]()
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: it was executed under its own name."""

    def begin(self) -> None:
        if self not in sys.meta_path:
            sys.meta_path.append(self)

    def end(self) -> None:
        if self in sys.meta_path:
            sys.meta_path.remove(self)
        for name, module in self._made.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]
        self._made.clear()
