"""A dry run of legacy code: what isn't here is stood in for, and each thing is told once."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from typing import Any
from unittest import mock

from py_trees.behaviours import Success
from py_trees.composites import Composite

from grip_bt import smach_compat
from grip_bt.smach_compat import Container, State, smach_ros
from grip_bt.smach_compat.smach_ros._port import Ros

from .stand_ins import StandInFinder, StandInModule, name_of, stand_in, stands_in

_BAD = re.compile("abort|fail|preempt|error|invalid|timeout|no_|not_|un", re.IGNORECASE)


class StandInState(State):
    """In the place of a state whose class isn't here: it has the outcomes that its container goes by, and ends well."""

    def __init__(self, label: str, transitions: Mapping[str, object] | None):
        container = next(iter(Container._construction_stack[-1:]), None)
        rules = getattr(container, "_outcome_map", {}).values()
        outcomes = [*(transitions or ()), *(rule[label] for rule in rules if label in rule)]
        super().__init__(outcomes=list(dict.fromkeys(outcomes)) or ["succeeded"])

    def execute(self, ud: object) -> str:
        """End with the first outcome whose name isn't bad."""
        outcomes = self.get_registered_outcomes()
        return next((outcome for outcome in outcomes if not _BAD.search(outcome)), outcomes[0])


class _TellingFinder(StandInFinder):
    def __init__(self, tell: Callable[[str], object]):
        super().__init__()
        self._tell = tell

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Stand in for a module that no finder has, of those that came later either; tell of its package once."""
        for finder in sys.meta_path[sys.meta_path.index(self) + 1 :]:
            if (found := finder.find_spec(fullname, path, target)) is not None:  # type: ignore[arg-type]
                return found
        known = len(self.packages)
        found = super().find_spec(fullname, path, target)
        for package in self.packages[known:]:
            self._tell(f"package {package}")
        return found


@contextmanager
def dry_run(tell: Callable[[str], object]) -> Iterator[None]:
    """Stand in for packages that aren't installed and for what nobody offers over ROS; `tell` is told of each."""
    installed, finder = "smach" in sys.modules, _TellingFinder(tell)

    def added(composite: Composite, child: Any) -> Any:
        return add_child(composite, Success(name_of(child)) if stands_in(child) else child)

    add_child = Composite.add_child
    smach_compat.install(rospy=True)
    smach_ros.use(Ros(stand_in, tell))
    sys.meta_path.append(finder)
    try:
        with mock.patch.object(Composite, "add_child", added):
            yield
    finally:
        sys.meta_path.remove(finder)
        for name in [name for name, module in sys.modules.items() if isinstance(module, StandInModule)]:
            del sys.modules[name]
        smach_ros.use(None)
        if not installed:
            smach_compat.uninstall()
