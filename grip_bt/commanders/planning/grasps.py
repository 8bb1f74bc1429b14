"""Which grasp an arm can really do: reach it, approach and lift straight, and touch nothing but the object."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.failures import CanceledError, NoGraspError, NoPlanError, TimeOutError
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.base.values.pose import check_frame

from ..kinematics.collision import CollisionChecker
from ..kinematics.damped_least_squares import Target
from ..kinematics.ik import solver
from ..kinematics.model import Chain, RobotModel
from ..scene_state import SceneSnapshot
from .budget import Budget
from .paths import interpolated
from .requests import ChosenGrasp, Situation
from .search import RESOLUTION, Search
from .straight import BrokenLineError, straight_path

TARGET_WITHIN = 0.03
"""The object nearest to the closing point, at most this far from it [m], is the one that a grasp takes."""
FINGER_DEPTHS = (0.06, 0.09)
"""How far in front of the palm finger tips may pinch an object [m]."""
_RESTARTS = 10
_WARM = 3
_SOLUTIONS = 4
_PATIENCE = 1.0
"""Work for the way to one configuration, as checks that stand for so long [s]."""
_LONGEST = 10.0
"""CPU time after which the search for it ends the whole choice [s]."""


def closing_point(grasp: Grasp) -> Array:
    """Return the middle of what is between palm and fingers, shape (3,) [m]: half its width in front of the palm."""
    return grasp.pose.position + max(grasp.width, 0.03) / 2 * grasp.pose.rotation()[:, 2]


def target_of(grasp: Grasp, scene: SceneSnapshot) -> str | None:
    """Return the name of the object that a grasp takes, or None when the scene has none there.

    It is looked for at the closing point and then, for a pinch with the finger tips, further out from the palm.
    """
    normal = grasp.pose.rotation()[:, 2]
    points = [closing_point(grasp), *(grasp.pose.position + depth * normal for depth in FINGER_DEPTHS)]
    return next((near[0] for point in points if (near := scene.around(point, TARGET_WITHIN))), None)


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
        trial = GraspTrial(search, grasp)
        for q in trial.configurations():
            if canceled():
                raise CanceledError("the choice of a grasp was cancelled")
            if (pre := trial.pre_configuration(q)) is not None and trial.can_go_to(pre, canceled):
                names = trial.chain.joints
                return ChosenGrasp(grasp, JointState(names, pre), JointState(names, q), dict(reasons))
        reasons[trial.reason] += 1
    raise none_feasible(reasons, len(grasps))


def none_feasible(reasons: Counter[str], candidates: int) -> NoGraspError:
    """Return the error that none of so many grasps can be taken; `reasons` counts why."""
    counts = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    said = f"none of {candidates} grasps is feasible" + (f": {counts}" if counts else "")
    return NoGraspError(said, reasons=dict(reasons), candidates=candidates)


class GraspSearch:
    """What the candidates of one request share: collision checkers, and configurations that reached one of them."""

    def __init__(self, model: RobotModel, situation: Situation):
        self.model, self.situation = model, situation
        self.reached: tuple[Array, ...] = ()
        self._made: dict[tuple[int, str | None], CollisionChecker] = {}

    def chain(self, grasp: Grasp) -> Chain:
        """Return the arm with its hand in the grasp's pre-posture."""
        posture = grasp.pre_posture or self.model.description.opened(self.situation.group)
        return self.model.chain(self.situation.group, self.situation.start, posture)

    def without(self, chain: Chain, target: str | None) -> CollisionChecker:
        """Return the checker that doesn't see an object; None stands for no object."""
        key = (id(chain), target)
        if key not in self._made:
            scene = self.situation.scene
            seen = scene if target is None else scene.without([target])
            self._made[key] = CollisionChecker(chain, seen, self.situation.hand)
        return self._made[key]

    def holding(self, chain: Chain, target: str | None, grasp: Pose) -> CollisionChecker:
        """Return the checker in which the hand holds an object, having closed at `grasp`."""
        if target is None:
            return self.without(chain, None)
        held = self.situation.scene.attaching(target, self.situation.hand, grasp)
        return CollisionChecker(chain, held, self.situation.hand)


class GraspTrial:
    """One candidate under test.

    Attributes:
        chain: the arm with its hand in the grasp's pre-posture.
        reason: how far the candidate got: `no_ik`, `in_collision`, `approach_blocked`, `pre_grasp_in_collision`
            `lift_blocked` or `no_plan`.
    """

    _STAGES = ("no_ik", "in_collision", "approach_blocked", "pre_grasp_in_collision", "lift_blocked", "no_plan")

    def __init__(self, search: GraspSearch, grasp: Grasp):
        for pose in (grasp.pre_grasp, grasp.pose, grasp.post_grasp):
            check_frame(pose, "world")
        self._search, self._grasp = search, grasp
        self._target = target_of(grasp, search.situation.scene)
        self.chain = search.chain(grasp)
        self._approach = search.without(self.chain, self._target)
        self._stage = 0

    @property
    def reason(self) -> str:
        """Why it was refused, judged by the configuration that came furthest."""
        return self._STAGES[self._stage]

    def configurations(self) -> list[Array]:
        """Return up to four free configurations at the grasp, the nearest to the present one first.

        What reached other candidates is tried first: their poses are much alike.
        """
        situation = self._search.situation
        rng = np.random.default_rng(situation.settings.seed)
        start = situation.start.ordered(self.chain.joints)
        home = self._search.model.description.named_state(situation.group, "home").position
        find = solver(situation.settings.kinematics)
        free = []
        seeds = (start, home, *self._search.reached)
        for q in find(self.chain, Target(_se3(self._grasp.pose)), rng, seeds, _RESTARTS):
            self._reached(1)
            self._search.reached = (q, *self._search.reached[: _WARM - 1])
            if self._approach.free(q):
                free.append(q)
            if len(free) == _SOLUTIONS:
                break
        return sorted(free, key=lambda q: float(np.linalg.norm(q - start)))

    def pre_configuration(self, q: Array) -> Array | None:
        """Return the configuration at the pre-grasp from which the straight approach ends at `q`, or None.

        None too when the lift from `q` isn't possible.
        """
        self._reached(2)
        try:
            approach = straight_path(self.chain, q, _se3(self._grasp.pre_grasp))
            if not self._approach.all_free(interpolated(approach, RESOLUTION)):
                return None
            self._reached(3)
            if not self._search.without(self.chain, None).free(approach[-1]):
                return None
            self._reached(4)
            lift = straight_path(self.chain, q, _se3(self._grasp.post_grasp))
        except BrokenLineError:
            return None
        holding = self._search.holding(self.chain, self._target, self._grasp.pose)
        return approach[-1] if holding.all_free(interpolated(lift, RESOLUTION)) else None

    def can_go_to(self, pre: Array, canceled: Callable[[], bool]) -> bool:
        """Tell whether a free path leads from the present configuration to `pre`.

        The search gets little time: a path that is hard to find here is hard to find again when it is needed.
        """
        self._reached(5)
        situation = self._search.situation
        settings, start = situation.settings, situation.start.ordered(self.chain.joints)
        checker = self._search.without(self.chain, None)
        if not checker.free(start):
            return True  # the plan itself will tell that the start is in collision
        whole = Budget(_LONGEST)
        try:
            Search(checker, settings, None, canceled).path(start, pre, whole.part(_PATIENCE))
        except (NoPlanError, TimeOutError):
            if whole.out_of_time:
                raise
            return False
        return True

    def _reached(self, stage: int) -> None:
        self._stage = max(self._stage, stage)


def _se3(pose: Pose) -> pin.SE3:
    return pin.SE3(pose.matrix())
