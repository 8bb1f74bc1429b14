"""Free paths between two configurations by OMPL's planners, with batched collision checks of whole motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from grip_bt.base.arrays import Array, Path
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import CanceledError, ExpectedError, NoPlanError, PathInvalidError, TimeOutError
from grip_bt.base.values import PathConstraint

from ..kinematics.collision import CollisionChecker
from ..settings import PLANNERS, PlanningSettings
from .budget import Budget
from .paths import shortened
from .tree_planners import bitrrt, cbirrt, costs, highest_cost

T = TypeVar("T")
BITRRT = "BiTRRT"
RESOLUTION = 0.02
"""No joint moves more than this [rad] between two checks while planning; the timed result is checked more finely."""
_THREADED = frozenset({"PRM", "PRMstar"})
"""These ask from a thread of their own whether to stop. It can't enter Python, as the search holds the lock; they get
a condition without Python, which the checks of states and motions end."""

_STEP = 0.25
"""RRTConnect's trees grow in steps of this [rad] times the root of the number of joints, unless `range` is given.

OMPL's own range, a fifth of the space's diagonal, leads to longer ways and takes longer where it is hard.
"""

_HARDER = 6.0
"""What one step of BiTRRT or CBiRRT is, in checks of RRTConnect."""

_PARAMETERS = {
    "range": "setRange",
    "goal_bias": "setGoalBias",
    "border_fraction": "setBorderFraction",
    "failed_expansion_score_factor": "setFailedExpansionCellScoreFactor",
    "min_valid_path_fraction": "setMinValidPathFraction",
    "rewire_factor": "setRewireFactor",
    "radius_multiplier": "setRadiusMultiplier",
}
"""Parameter in `ompl_planning.yaml` -> the method that sets it; OMPL's own list of parameters isn't bound."""


class MotionCheck:
    """Tells whether straight motions in joint space are free."""

    def __init__(self, checker: CollisionChecker, resolution: float = RESOLUTION):
        self.checker, self.resolution = checker, resolution

    def __call__(self, one: Array, other: Array) -> bool:
        """Check the motion, its start excepted: its end first, then its middle, quarters, eighths and so on.

        Most motions that aren't free touch something for a good part of the way, so they are found out after a few.
        """
        steps = max(1, int(np.ceil(np.abs(other - one).max() / self.resolution)))
        return self.checker.all_free(one + (other - one) * halving(steps)[:, None])


@cache
def halving(steps: int) -> Array:
    """Return the fractions 1/steps, 2/steps ... 1, those first that cut the gaps between the earlier ones in half."""
    order: list[int] = []
    stride = 1 << (steps - 1).bit_length()
    while stride:
        order += range(steps, 0, -stride)
        stride //= 2
    return np.array(list(dict.fromkeys(order))) / steps


def settable(planner: str) -> frozenset[str]:
    """Return the parameters of a planner that can be set, by their names in MoveIt's `ompl_planning.yaml`."""
    kind = getattr(og, planner, None)
    return frozenset(name for name, setter in _PARAMETERS.items() if hasattr(kind, setter))


def plan_free(
    checker: CollisionChecker,
    start: Array,
    goal: Array,
    planner: str,
    seed: int,
    budget: Budget,
    canceled: Callable[[], bool],
    resolution: float = RESOLUTION,
    parameters: Mapping[str, float] | None = None,
) -> Path:
    """Return a short free path from `start` to `goal`, shape (k, n).

    Args:
        checker: what is avoided; start and goal are free in it.
        planner: name of an OMPL planner.
        seed: of all random choices.
        budget: time to give up after.
        canceled: asked often; True ends it.
        resolution: largest joint step between two checks [rad].
        parameters: of the planner, by their names in `ompl_planning.yaml`; those that it hasn't are left out, see
            `settable`.

    Raises:
        UnknownNameError: there is no such planner.
        CanceledError: it was cancelled.
        TimeOutError: its time was over.
        NoPlanError: the planner gave up.
    """
    if planner not in PLANNERS:
        raise UnknownNameError("planner", planner, PLANNERS)
    motion_free = MotionCheck(checker, resolution)

    def over() -> bool:
        return bool(canceled()) or budget.over(1.0 if planner != BITRRT else _HARDER)  # no bool of numpy's for OMPL

    if planner == BITRRT:
        path = bitrrt(checker, motion_free, start, goal, np.random.default_rng(seed), over)

        def no_worse(one: Array, other: Array) -> bool:  # comes no closer to things than where it leaves the path
            ends = np.stack([one, other])
            return motion_free(one, other) and highest_cost(checker, ends) <= float(costs(checker, ends).max())

        return shortened(_found(path, planner, budget, canceled), no_worse, np.random.default_rng(seed))
    if motion_free(start, goal):
        return np.stack([start, goal])
    path = _solved(checker, motion_free, start, goal, planner, seed, _Ending(over, planner, budget), parameters or {})
    return shortened(_found(path, planner, budget, canceled), motion_free, np.random.default_rng(seed))


def plan_constrained(
    checker: CollisionChecker,
    constraint: PathConstraint,
    start: Array,
    goal: Array,
    seed: int,
    budget: Budget,
    canceled: Callable[[], bool],
    resolution: float = RESOLUTION,
) -> Path:
    """Return a short free path, shape (k, n), that keeps to a constraint, by CBiRRT; arguments as for `plan_free`.

    Raises:
        CanceledError: it was cancelled.
        TimeOutError: its time was over.
    """

    def over() -> bool:
        return canceled() or budget.over(_HARDER)

    rng = np.random.default_rng(seed)
    path = cbirrt(checker, MotionCheck(checker, resolution), constraint, start, goal, rng, over)
    return _found(path, "CBiRRT", budget, canceled)


@dataclass(frozen=True)
class Search:
    """Searches for one request: by the planner of its settings, or by CBiRRT where a constraint has to be kept."""

    checker: CollisionChecker
    settings: PlanningSettings
    constraint: PathConstraint | None
    canceled: Callable[[], bool]

    def path(self, start: Array, goal: Array, budget: Budget, attempt: int = 0, resolution: float = RESOLUTION) -> Path:
        """Return a free path; errors are those of `plan_free` and `plan_constrained`."""
        seed, canceled, given = self.settings.seed + attempt, self.canceled, dict(self.settings.parameters)
        if self.constraint is not None:
            return plan_constrained(self.checker, self.constraint, start, goal, seed, budget, canceled, resolution)
        return plan_free(self.checker, start, goal, self.settings.planner, seed, budget, canceled, resolution, given)


def first_success(attempts: Sequence[Callable[[Budget], T]], budget: Budget) -> T:
    """Return what the first attempt that succeeds gives, each having its share of the work.

    Raises:
        NoPlanError, TimeOutError, PathInvalidError: none does; the error is the last one's.
    """
    failure: ExpectedError = NoPlanError("there is no goal to plan to")
    for k, attempt in enumerate(attempts):
        try:
            return attempt(budget.share(len(attempts) - k))
        except (NoPlanError, TimeOutError, PathInvalidError) as error:
            if budget.out_of_time:
                raise
            failure = error
    raise failure


def _found(path: Path | None, planner: str, budget: Budget, canceled: Callable[[], bool]) -> Path:
    if canceled():
        raise CanceledError("planning was cancelled")
    if path is None:
        if budget.over(0.0):
            raise TimeOutError(f"{planner} found no path {budget}", planner=planner)
        raise NoPlanError(f"{planner} found no path", planner=planner)
    return path


def _solved(
    checker: CollisionChecker,
    motion_free: MotionCheck,
    start: Array,
    goal: Array,
    planner: str,
    seed: int,
    ending: _Ending,
    parameters: Mapping[str, float],
) -> Path | None:
    # Re-seeding after the first use is what makes requests independent of one another; OMPL logs an error about it.
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    ou.RNG.setSeed(seed + 1)
    setup = og.SimpleSetup(_space(checker))
    information = setup.getSpaceInformation()
    dimension = len(start)
    setup.setStateValidityChecker(lambda state: not ending.noticed() and checker.free(_values(state, dimension)))
    information.setMotionValidator(_MotionValidator(information, motion_free, dimension, ending))
    space = setup.getStateSpace()
    setup.setStartAndGoalStates(_state(space, start), _state(space, goal))
    search = getattr(og, planner)(information)
    usual = {"range": _STEP * float(np.sqrt(dimension))} if planner == "RRTConnect" else {}
    given = {name: value for name, value in parameters.items() if value or name != "range"}  # 0: the usual one
    for name, value in {**usual, **given}.items():
        if name in settable(planner):
            getattr(search, _PARAMETERS[name])(value)
    setup.setPlanner(search)
    objective = ob.PathLengthOptimizationObjective(information)
    objective.setCostThreshold(ob.Cost(1e9))  # optimising planners: the first path will do, it is shortened anyway
    setup.setOptimizationObjective(objective)
    setup.solve(ending.condition)
    if not setup.haveExactSolutionPath():
        return None
    path = setup.getSolutionPath()
    rows = [_values(path.getState(k), dimension) for k in range(path.getStateCount())]
    rows[0], rows[-1] = start, goal
    return np.stack(rows)


class _Ending:
    """When a search has to end: OMPL's condition, which it asks itself, and which every check that it makes can end."""

    def __init__(self, over: Callable[[], bool], planner: str, budget: Budget):
        threaded, left = planner in _THREADED, max(0.01, budget.wall_left)
        self.condition = ob.timedPlannerTerminationCondition(left) if threaded else ob.PlannerTerminationCondition(over)
        self._over, self._ended = over, False

    def noticed(self) -> bool:
        """Tell whether it has to end, and see to that.

        Then no check is worth its time: some searches make thousands of them before they ask again.
        """
        if not self._ended and self._over():
            self._ended = True
            self.condition.terminate()
        return self._ended


class _MotionValidator(ob.MotionValidator):  # type: ignore[misc]  # OMPL has no types
    """OMPL's question about an edge, answered by one batched check."""

    def __init__(self, information: ob.SpaceInformation, motion_free: MotionCheck, dimension: int, ending: _Ending):
        super().__init__(information)
        self.motion_free, self.dimension, self.ending = motion_free, dimension, ending

    def checkMotion(self, one: ob.State, other: ob.State, *_: object) -> bool:
        if self.ending.noticed():
            return False
        return self.motion_free(_values(one, self.dimension), _values(other, self.dimension))


def _space(checker: CollisionChecker) -> ob.RealVectorStateSpace:
    limits = checker.chain.limits
    space = ob.RealVectorStateSpace(len(limits.lower))
    bounds = ob.RealVectorBounds(len(limits.lower))
    for k, (low, high) in enumerate(zip(limits.lower, limits.upper, strict=True)):
        bounds.setLow(k, float(low))
        bounds.setHigh(k, float(high))
    space.setBounds(bounds)
    return space


def _values(state: ob.State, dimension: int) -> Array:
    return np.array([state[k] for k in range(dimension)])


def _state(space: ob.StateSpace, q: Array) -> ob.State:
    state = space.allocState()
    for k, value in enumerate(q):
        state[k] = float(value)
    return state
