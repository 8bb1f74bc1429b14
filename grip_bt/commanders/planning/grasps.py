"""Which grasp an arm can really do: reach it, approach and lift straight, and touch nothing but the object."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import CanceledError, NoGraspError, NoIkError, NoPlanError, PathInvalidError, TimeOutError
from grip_bt.base.values import Grasp, JointState
from grip_bt.base.values.pose import check_frame

from ..kinematics.collision import CollisionChecker, checker_of
from ..kinematics.damped_least_squares import Target
from ..kinematics.ik import solver
from ..kinematics.model import Chain, RobotModel
from ..scene_state import SceneSnapshot
from .budget import Budget
from .paths import interpolated
from .requests import ChosenGrasp, Situation
from .search import RESOLUTION, Search
from .straight import straight_path, world_pose

TARGET_WITHIN = 0.03
"""The object nearest to the closing point, at most this far from it [m], is the one that a grasp takes."""
_RESTARTS = 10
_WARM = 3
_SOLUTIONS = 4
_PATIENCE = 1.0
"""Work for the way to one configuration, as checks that stand for this time [s]."""
_LONGEST = 10.0
"""CPU time after which the search for it ends the whole choice [s]."""


def target_of(grasp: Grasp, scene: SceneSnapshot) -> str | None:
    """Return the name of the object that a grasp takes, or None when the scene has none there."""
    return next((near[0] for point in grasp.closing_points() if (near := scene.around(point, TARGET_WITHIN))), None)


def choose_grasp(
    model: RobotModel, situation: Situation, grasps: Sequence[Grasp], canceled: Callable[[], bool]
) -> ChosenGrasp:
    """Return the first feasible grasp, by falling quality.

    A grasp is feasible when some joint positions reach the pre-grasp and touch nothing there, a free path leads
    there, the straight approach from there to the grasp touches nothing but the object to be taken, and the
    straight lift to the post-grasp, object in hand, touches nothing.

    Raises:
        NoGraspError: none is; `data['reasons']` counts why, `data['candidates']` how many there were.
        TimeOutError: looking for the way to one of them took too long.
        CanceledError: it was cancelled.
    """
    reasons: Counter[str] = Counter()
    search = GraspSearch(model, situation)
    for grasp in sorted(grasps, key=lambda g: -g.quality):
        found = search.tried(grasp, canceled)
        if not isinstance(found, str):
            return ChosenGrasp(grasp, *found, dict(reasons))
        reasons[found] += 1
    raise none_feasible(reasons, len(grasps))


def none_feasible(reasons: Counter[str], candidates: int) -> NoGraspError:
    """Return the error that none of so many grasps can be taken; `reasons` counts why."""
    counts = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    said = f"none of {candidates} grasps is feasible" + (f": {counts}" if counts else "")
    return NoGraspError(said, reasons=dict(reasons), candidates=candidates)


STAGES = ("no_ik", "in_collision", "approach_blocked", "pre_grasp_in_collision", "lift_blocked", "no_plan")
"""Why a grasp is refused, by how far the configuration that comes furthest comes."""


class GraspSearch:
    """What the candidates of one request share: configurations that reached one of them."""

    def __init__(self, model: RobotModel, situation: Situation):
        self._model, self._situation, self._settings = model, situation, situation.settings
        self._reached: tuple[Array, ...] = ()

    def tried(self, grasp: Grasp, canceled: Callable[[], bool]) -> tuple[JointState, JointState] | str:
        """Return configurations at the pre-grasp and at the grasp, or, where it isn't feasible, one of `STAGES`.

        Raises:
            TimeOutError: looking for the way to it took too long.
            CanceledError: it was cancelled.
        """
        for pose in (grasp.pre_grasp, grasp.pose, grasp.post_grasp):
            check_frame(pose, "world")
        posture = grasp.pre_posture or self._model.description.opened(self._situation.group)
        chain = self._model.chain(self._situation.group, self._situation.start, posture)
        target, furthest = target_of(grasp, self._situation.scene), "no_ik"
        free, reached = self._configurations(chain, grasp, self._without(chain, target))
        if reached:
            furthest = "in_collision"
        for q in free:
            if canceled():
                raise CanceledError("the choice of a grasp was cancelled")
            pre = self._pre_configuration(chain, grasp, target, q)
            stage = pre if isinstance(pre, str) else "no_plan"
            if not isinstance(pre, str) and self.can_go_to(chain, pre, canceled):
                return JointState(chain.joints, pre), JointState(chain.joints, q)
            furthest = max(furthest, stage, key=STAGES.index)
        return furthest

    def _configurations(self, chain: Chain, grasp: Grasp, approach: CollisionChecker) -> tuple[list[Array], bool]:
        """Return up to four free configurations at the grasp, the nearest to the present one first; whether any is.

        What reached other candidates is tried first: their poses are much alike.
        """
        rng, start = np.random.default_rng(self._settings.seed), self._situation.start.ordered(chain.joints)
        robot = self._model.description
        own = robot.named_states.get(self._situation.group, {}).get("home")
        home = np.array([robot.at_rest.get(j, 0.0) for j in chain.joints]) if own is None else own.position
        find, free, any_reached = solver(self._settings.kinematics), list[Array](), False
        for q in find(chain, Target(world_pose(grasp.pose)), rng, (start, home, *self._reached), _RESTARTS):
            any_reached = True
            self._reached = (q, *self._reached[: _WARM - 1])
            if approach.free(q):
                free.append(q)
            if len(free) == _SOLUTIONS:
                break
        return sorted(free, key=lambda q: float(np.linalg.norm(q - start))), any_reached

    def _pre_configuration(self, chain: Chain, grasp: Grasp, target: str | None, q: Array) -> Array | str:
        """Return the configuration at the pre-grasp from which the straight approach ends at `q`, or what is amiss."""
        stage = "approach_blocked"
        try:
            approach = straight_path(chain, q, grasp.pre_grasp)
            if not self._without(chain, target).all_free(interpolated(approach, RESOLUTION)):
                return stage
            if not self._without(chain, None).free(approach[-1]):
                return "pre_grasp_in_collision"
            stage = "lift_blocked"
            lift = straight_path(chain, q, grasp.post_grasp)
        except (NoIkError, PathInvalidError):
            return stage
        holding = self._without(chain, None)
        if target is not None:
            held = self._situation.scene.attaching(target, self._situation.hand, grasp.pose)
            holding = CollisionChecker(chain, held, self._situation.hand)
        return approach[-1] if holding.all_free(interpolated(lift, RESOLUTION)) else stage

    def can_go_to(self, chain: Chain, pre: Array, canceled: Callable[[], bool]) -> bool:
        """Tell whether a free path leads from the present configuration to `pre`.

        The search gets little time: a path that is hard to find here is hard to find again when it is needed.
        """
        start, checker = self._situation.start.ordered(chain.joints), self._without(chain, None)
        if not checker.free(start):
            return True  # the plan itself will tell that the start is in collision
        whole = Budget(_LONGEST)
        try:
            Search(checker, self._settings, None, canceled).path(start, pre, whole.part(_PATIENCE))
        except (NoPlanError, TimeOutError):
            if whole.out_of_time:
                raise
            return False
        return True

    def _without(self, chain: Chain, target: str | None) -> CollisionChecker:
        """Return the checker that doesn't see an object; None stands for no object."""
        scene = self._situation.scene
        return checker_of(chain, scene if target is None else scene.without([target]), self._situation.hand)
