"""The arm commander: what leaves ask of an arm, over a planner, an executor and a scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from grip_bt.errors import ExecutionAbortedError
from grip_bt.operation import Operation
from grip_bt.ports import Executor
from grip_bt.values import Grasp, JointState, Plan, Pose

from .planning.requests import (
    ChooseGrasp,
    ChosenGrasp,
    PlanningSettings,
    PlanStraight,
    PlanTo,
    Request,
    Situation,
)
from .scene import PlanningScene
from .worker import PlanningService

if TYPE_CHECKING:
    from .model import RobotModel

END_TOLERANCE = 0.05
"""A motion that ends further than this [rad] from its last point did not succeed."""
_REMEMBERED = 8


class ArmCommander:
    """Implements `ports.Arm`.

    Args:
        name: the arm's name in the project.
        model: the robot; used for where the hand is, never for planning.
        planner: makes the plans, without blocking.
        executor: moves the joints of `group`.
        scene: what plans avoid.
        hand: name of the hand at the arm's end, as the scene knows it.
        hand_state: returns the measured state of the hand's joints: they are obstacles too.
        settings: planner, solver, speed and so on.
        group: the robot's group of joints.
    """

    def __init__(
        self,
        name: str,
        model: RobotModel,
        planner: PlanningService,
        executor: Executor,
        scene: PlanningScene,
        hand: str,
        hand_state: Callable[[], JointState],
        settings: PlanningSettings | None = None,
        group: str = "arm",
    ):
        self._name, self._model, self._planner, self._executor = name, model, planner, executor
        self._scene, self._hand, self._hand_state = scene, hand, hand_state
        self._settings = settings or PlanningSettings()
        self._group = group
        self._lock = threading.Lock()
        self._reached_by: list[tuple[Pose, JointState]] = []

    @property
    def name(self) -> str:
        """The arm's name in the project."""
        return self._name

    def state(self) -> JointState:
        """Return the measured state of the arm's joints."""
        return self._executor.state()

    def grasp_pose(self) -> Pose:
        """Return the measured pose of the hand's grasp frame in world."""
        return self._model.grasp_pose(self._executor.state())

    def named_states(self) -> Mapping[str, JointState]:
        """Return the named states of the arm's group."""
        return self._model.description.named_states.get(self._group, {})

    def plan(self, goal: JointState | Pose | str) -> Operation[Plan]:
        """Plan a free path; see `ports.Arm`.

        To a pose of a grasp that `choose_grasp` has returned, it goes by the joint positions that were found then:
        others may reach the pose too, but not the rest of the grasp.

        Raises:
            UnknownNameError: there is no such named state.
        """
        if isinstance(goal, str):
            goal = self._model.description.named_state(self._group, goal)
        hints = () if isinstance(goal, JointState) else self._known_ways_to(goal)
        return self._ask(PlanTo(self._situation(), goal, hints))

    def plan_straight(self, goals: Sequence[Pose]) -> Operation[Plan]:
        """Plan straight lines of the grasp frame; see `ports.Arm`."""
        return self._ask(PlanStraight(self._situation(), tuple(goals)))

    def execute(self, plan: Plan) -> Operation[JointState]:
        """Execute a plan; the result is what was measured at the end.

        Ends with ExecutionAbortedError when that is more than 0.05 rad from the plan's end; `data['errors']` tells
        by how much, joint by joint.
        """
        return self._executor.execute(plan.trajectory).then(lambda measured: _verified(plan, measured))

    def choose_grasp(self, grasps: Sequence[Grasp]) -> Operation[Grasp]:
        """Return the first feasible grasp, by falling quality; see `planning.grasps.choose_grasp`."""
        return self._submit(ChooseGrasp(self._situation(), tuple(grasps))).then(self._remember)

    def stop(self) -> None:
        """Hold where the arm is now and end a motion under way."""
        self._executor.stop()

    def _situation(self) -> Situation:
        arm, hand = self._executor.state(), self._hand_state()
        start = JointState(arm.names + hand.names, np.concatenate([arm.position, hand.position]), time=arm.time)
        return Situation(self._group, start, self._scene.snapshot(), self._hand, self._settings)

    def _submit(self, request: Request) -> Operation[Plan | ChosenGrasp]:
        return self._planner.submit(request)

    def _ask(self, request: Request) -> Operation[Plan]:
        return self._submit(request)  # type: ignore[return-value]

    def _remember(self, chosen: Plan | ChosenGrasp) -> Operation[Grasp]:
        assert isinstance(chosen, ChosenGrasp)
        grasp = chosen.grasp
        with self._lock:
            new = [(grasp.pre_grasp, chosen.at_pre_grasp), (grasp.pose, chosen.at_grasp)]
            self._reached_by = [*new, *self._reached_by][:_REMEMBERED]
        return Operation.finished(grasp)

    def _known_ways_to(self, pose: Pose) -> tuple[JointState, ...]:
        with self._lock:
            return tuple(state for known, state in self._reached_by if known == pose)


def _verified(plan: Plan, measured: JointState) -> Operation[JointState]:
    end = plan.trajectory.end()
    errors = np.abs(measured.ordered(end.names) - end.position)
    if errors.max() <= END_TOLERANCE:
        return Operation.finished(measured)
    worst = int(errors.argmax())
    return Operation.failed(
        ExecutionAbortedError(
            f"the motion ended {errors[worst]:.3f} rad away from its end at joint {end.names[worst]}",
            errors=dict(zip(end.names, map(float, errors), strict=True)),
        )
    )
