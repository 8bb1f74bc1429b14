"""Stand-ins for packages that aren't installed, so that a legacy module can be imported to see what it builds.

They accept everything and do nothing: no robot, no network. Used in the recording process only.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Iterator
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import CodeType, FunctionType, ModuleType
from typing import Any

from grip_bt.smach_compat import State

from .reader.found import FIXED_OUTCOMES


class _Kind(type):
    """Makes every attribute of a placeholder class a placeholder too."""

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return placeholder_class(name)


class Placeholder(metaclass=_Kind):
    """Accepts every call, attribute and operation."""

    def __init__(self, *arguments: object, **named: object):
        """Take anything."""

    def __call__(self, *arguments: object, **named: object) -> object:
        """Return a placeholder; as a decorator, what is decorated."""
        if len(arguments) == 1 and not named and isinstance(arguments[0], (FunctionType, type)):
            return arguments[0]
        return Placeholder()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Placeholder()

    def __getitem__(self, key: object) -> Any:
        return Placeholder()

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def keys(self) -> list[Any]:
        """Return no keys, so that it can be unpacked."""
        return []

    def _nothing(self, *given: object) -> None:
        pass

    __setitem__ = __exit__ = _nothing

    def __bool__(self) -> bool:
        return True

    def __float__(self) -> float:
        return 0.0

    def __int__(self) -> int:
        return 0

    __len__ = __index__ = __int__

    def __str__(self) -> str:
        return ""

    __fspath__ = __str__

    def _same(self, *others: object) -> object:
        return self

    __enter__ = _same
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _same
    __neg__ = __pow__ = __mod__ = __or__ = __and__ = __floordiv__ = _same

    def _no(self, other: object) -> bool:
        return False

    __contains__ = __lt__ = __le__ = __gt__ = __ge__ = _no


def placeholder_class(name: str) -> type:
    """Return a new placeholder class; it may be called, and derived from."""
    return _Kind(name, (Placeholder,), {"__module__": "stand_in"})


class _Module(ModuleType):
    """A module of which every name is a placeholder."""

    __path__: list[str] = []

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":
            return sorted(_unknown_names(sys._getframe(1)))
        if name.startswith("__"):
            raise AttributeError(name)
        made = placeholder_class(name)
        setattr(self, name, made)
        return made


def _unknown_names(frame: Any) -> set[str]:
    """Return the names that the importing module uses and nobody gives: what a star import has to."""
    while frame is not None and frame.f_code.co_name != "<module>":
        frame = frame.f_back
    if frame is None:
        return set()
    names: set[str] = set()
    stored: set[str] = set()
    todo: list[CodeType] = [frame.f_code]
    while todo:
        code = todo.pop()
        names.update(code.co_names)
        stored.update(code.co_varnames)
        todo.extend(c for c in code.co_consts if isinstance(c, CodeType))
    return {n for n in names - stored if n not in frame.f_globals and not hasattr(builtins, n) and n[0] != "_"}


class Finder(MetaPathFinder, Loader):
    """Comes last: what no other finder has is a placeholder; knows the packages that it stood in for."""

    def __init__(self) -> None:
        self.packages: list[str] = []

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Find every module that isn't part of Python or of an installed package."""
        package = fullname.split(".")[0]
        there = sys.modules.get(package)
        if package in sys.stdlib_module_names or (there is not None and not isinstance(there, _Module)):
            return None
        if package not in self.packages and package not in ("smach_ros", "roslib"):
            self.packages.append(package)
        return ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Make the placeholder."""
        module = _Module(spec.name)
        if spec.name == "rospy":
            absent = lambda name, default=None: Placeholder() if default is None else default  # noqa: E731
            module.get_param = absent  # type: ignore[attr-defined]
            module.is_shutdown = lambda: True  # type: ignore[attr-defined]
        if spec.name == "smach_ros":
            for name in FIXED_OUTCOMES:
                setattr(module, name, _ros_state(name))
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: names are made when somebody asks for them."""


def _ros_state(kind: str) -> type:
    """Return a state with the outcomes and keys of one of smach_ros, that never runs."""

    def __init__(self: State, *arguments: Any, **named: Any) -> None:
        keys = {k: list(named.get(k) or []) for k in ("input_keys", "output_keys", "io_keys")}
        extra = list(named.get("outcomes") or [])
        State.__init__(self, [*FIXED_OUTCOMES[kind], *extra], **keys)
        for side, register in (
            (("goal", "request"), self.register_input_keys),
            (("result", "response"), self.register_output_keys),
        ):
            for word in side:
                register([k for k in (named.get(f"{word}_key"),) if isinstance(k, str)])
                register([k for k in named.get(f"{word}_slots") or [] if isinstance(k, str)])

    return type(kind, (State,), {"__init__": __init__, "__module__": "smach_ros"})
