"""The library toppra without what nobody here asks for: a third of a planner's start is matplotlib, for drawing."""

import sys
import warnings
from importlib import import_module
from types import ModuleType

from grip_bt.base.arrays import Array


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
    from toppra.algorithm.reachabilitybased.reachability_algorithm import ReachabilityAlgorithm
    from toppra.parametrizer import ParametrizeConstAccel
    from toppra.solverwrapper.cy_seidel_solverwrapper import seidelWrapper
finally:
    for _name in _absent:
        del sys.modules[_name]

__all__ = ["ParametrizeConstAccel", "Timing", "toppra"]


class Timing(toppra.algorithm.TOPPRA):  # type: ignore[misc]
    """TOPP-RA with the solver that the library takes for limits of joints, without a look for all others."""

    def __init__(self, limits: list[toppra.constraint.LinearConstraint], path: toppra.SplineInterpolator, grid: Array):
        super(ReachabilityAlgorithm, self).__init__(limits, path, grid)
        self.solver_wrapper = seidelWrapper(limits, path, self.gridpoints, solve_lp1d=True)
