"""The library toppra without matplotlib: a third of a planner's start, for drawing that nobody here asks for."""

import sys
import warnings
from importlib import import_module
from types import ModuleType


class _Later(ModuleType):
    """A module that is loaded when something of it is asked for."""

    def __getattr__(self, name: str) -> object:
        return getattr(import_module(self.__name__), name)


warnings.filterwarnings("ignore", "invalid escape sequence", SyntaxWarning, ".*toppra")  # when it is first compiled
_absent = {"matplotlib": ModuleType("matplotlib"), "matplotlib.pyplot": _Later("matplotlib.pyplot")}
_absent = {} if "matplotlib" in sys.modules else _absent
sys.modules |= _absent
try:
    import toppra.algorithm
    import toppra.constraint
    from toppra.parametrizer import ParametrizeConstAccel
finally:
    for _name in _absent:
        del sys.modules[_name]

__all__ = ["ParametrizeConstAccel", "toppra"]
