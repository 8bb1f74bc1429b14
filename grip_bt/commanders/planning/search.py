"""Free paths between two configurations by OMPL's planners, with batched collision checks of whole motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
BITRRT, CBIRRT = "BiTRRT", "CBiRRT"
RESOLUTION = 0.02
"""No joint moves more than this [rad] between two checks while planning; the timed result is checked more finely."""
_THREADED = frozenset({"PRM", "PRMstar"})
"""These ask from a thread of their own whether to stop. It can't enter Python, as the search holds the lock; they get
a condition without Python, which the checks of states and motions end."""

_STEP = 0.25
"""RRTConnect's trees grow in steps of this [rad] times the root of the number of joints.

OMPL's own range, a fifth of the space's diagonal, leads to longer ways and takes longer where it is hard.
"""

_HARDER = {BITRRT: 6.0, CBIRRT: 6.0}
"""What one step of a planner is, in checks of RRTConnect."""


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


@dataclass(frozen=True)
class Search:
    """Searches for one request: by the planner of its settings, or by CBiRRT where a constraint has to be kept.

    Attributes:
        checker: what is avoided; start and goal are free in it.
        canceled: asked often; True ends it.
    """

    checker: CollisionChecker
    settings: PlanningSettings
    constraint: PathConstraint | None
    canceled: Callable[[], bool]

    def path(self, start: Array, goal: Array, budget: Budget, attempt: int = 0, resolution: float = RESOLUTION) -> Path:
        """Return a short free path from `start` to `goal`, shape (k, n).

        Args:
            budget: time to give up after.
            attempt: changes the seed of all random choices.
            resolution: largest joint step between two checks [rad].

        Raises:
            UnknownNameError: there is no such planner.
            CanceledError: it was cancelled.
            TimeOutError: its time was over.
            NoPlanError: the planner gave up.
        """
        planner = self.settings.planner if self.constraint is None else CBIRRT
        if planner not in (*PLANNERS, CBIRRT):
            raise UnknownNameError("planner", planner, PLANNERS)
        checker, seed, work = self.checker, self.settings.seed + attempt, _HARDER.get(planner, 1.0)
        rng, motion_free = np.random.default_rng(seed), MotionCheck(checker, resolution)

        def over() -> bool:
            return bool(self.canceled()) or budget.over(work)  # no bool of numpy's for OMPL

        def no_worse(one: Array, other: Array) -> bool:  # comes no closer to things than where it leaves the path
            ends = np.stack([one, other])
            return motion_free(one, other) and highest_cost(checker, ends) <= float(costs(checker, ends).max())

        path: Path | None
        if self.constraint is not None:
            path = cbirrt(checker, motion_free, self.constraint, start, goal, rng, over)
        elif planner == BITRRT:
            path = bitrrt(checker, motion_free, start, goal, rng, over)
        elif motion_free(start, goal):
            return np.stack([start, goal])
        else:
            path = self._by_ompl(motion_free, start, goal, seed, over, budget.wall_left)
        if self.canceled():
            raise CanceledError("planning was cancelled")
        if path is None:
            if budget.over(0.0):
                raise TimeOutError(f"{planner} found no path {budget}", planner=planner)
            raise NoPlanError(f"{planner} found no path", planner=planner)
        if self.constraint is not None:
            return path
        return shortened(path, no_worse if planner == BITRRT else motion_free, np.random.default_rng(seed))

    def _by_ompl(
        self, motion_free: MotionCheck, start: Array, goal: Array, seed: int, over: Callable[[], bool], most: float
    ) -> Path | None:
        # Re-seeding after the first use makes requests independent of one another; OMPL logs an error about it.
        ou.setLogLevel(ou.LogLevel.LOG_NONE)
        ou.RNG.setSeed(seed + 1)
        limits, dimension, planner = self.checker.chain.limits, len(start), self.settings.planner
        space, bounds = ob.RealVectorStateSpace(dimension), ob.RealVectorBounds(dimension)
        for k, (low, high) in enumerate(zip(limits.lower.tolist(), limits.upper.tolist(), strict=True)):
            bounds.setLow(k, low)
            bounds.setHigh(k, high)
        space.setBounds(bounds)
        setup = og.SimpleSetup(space)
        information = setup.getSpaceInformation()
        timed = planner in _THREADED
        condition = (
            ob.timedPlannerTerminationCondition(max(0.01, most)) if timed else ob.PlannerTerminationCondition(over)
        )
        motions = _Motions(information, motion_free, over, condition)
        setup.setStateValidityChecker(lambda state: not motions.ended() and self.checker.free(motions.values(state)))
        information.setMotionValidator(motions)
        ends = [space.allocState(), space.allocState()]
        for state, q in zip(ends, (start, goal), strict=True):
            for k, value in enumerate(q.tolist()):
                state[k] = value
        setup.setStartAndGoalStates(*ends)
        search = getattr(og, planner)(information)
        if planner == "RRTConnect":
            search.setRange(_STEP * float(np.sqrt(dimension)))
        setup.setPlanner(search)
        objective = ob.PathLengthOptimizationObjective(information)
        objective.setCostThreshold(ob.Cost(1e9))  # optimising planners: the first path will do, it is shortened anyway
        setup.setOptimizationObjective(objective)
        setup.solve(condition)
        if not setup.haveExactSolutionPath():
            return None
        path = setup.getSolutionPath()
        rows = [motions.values(path.getState(k)) for k in range(path.getStateCount())]
        rows[0], rows[-1] = start, goal
        return np.stack(rows)


class _Motions(ob.MotionValidator):  # type: ignore[misc]  # OMPL has no types
    """OMPL's question about an edge, answered by one batched check; each may end the search.

    Then no check is worth its time: some searches make thousands of them before they ask their condition again.
    """

    def __init__(
        self, information: ob.SpaceInformation, free: MotionCheck, over: Callable[[], bool], condition: object
    ):
        super().__init__(information)
        self.free, self.dimension = free, information.getStateDimension()
        self._over, self._condition, self._ended = over, condition, False

    def ended(self) -> bool:
        """Tell whether the search has to end, and see to that."""
        if not self._ended and self._over():
            self._ended = True
            self._condition.terminate()  # type: ignore[attr-defined]
        return self._ended

    def values(self, state: ob.State) -> Array:
        """Return a state's configuration, shape (n,)."""
        return np.array([state[k] for k in range(self.dimension)])

    def checkMotion(self, one: ob.State, other: ob.State, *_: object) -> bool:
        return not self.ended() and self.free(self.values(one), self.values(other))


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
