"""The arm commander: what leaves ask of an arm, over a planner, an executor and a scene."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExecutionAbortedError, OutOfLimitsError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import FREEDOMS, Executor, Ways
from grip_bt.base.values import Grasp, JointState, PathConstraint, Plan, Pose, Trajectory, WayPoint
from grip_bt.base.values.joints import MOVE_GROUP

from .joined import require_joints
from .planning import requests
from .scene import PlanningScene
from .settings import PlanningSettings
from .steered_motion import SteeredMotion, Twist, velocity_of
from .steering import HOLD, approaching, bounded, jogged
from .taught import TaughtStates
from .trajectory.limits import Limits, refuse_beyond_limits

END_TOLERANCE = 0.05
"""A motion that ends further than this [rad] from its last point did not succeed."""
_REMEMBERED = 8
_PLANNED = 4


class RobotGeometry(Protocol):
    """What an arm asks of the robot's model; see `kinematics.model.RobotModel`."""

    def grasp_pose(self, *states: JointState, group: str = "") -> Pose:
        """Return where the grasp frame of a group is in world."""

    def limits_of(self, names: tuple[str, ...]) -> Limits | None:
        """Return what joints may do; None where nobody knows."""

    def named_states_of(self, group: str) -> Mapping[str, JointState]:
        """Return the states that the robot's description names."""


@dataclass(frozen=True)
class ArmSetup:
    """What is known of an arm before it is started.

    Attributes:
        name: the arm's name in the project.
        group: the robot's group of joints.
        hand: name of the hand at the arm's end, as the scene knows it; empty for none.
        settings: planner, solver, speed and so on.
        states: named states of the arm besides those of its group.
        taught: what was taught before, and where more of it is kept.
    """

    name: str
    group: str = "arm"
    hand: str = ""
    settings: PlanningSettings = field(default_factory=PlanningSettings)
    states: Mapping[str, JointState] = field(default_factory=dict)
    taught: TaughtStates = field(default_factory=TaughtStates)


class ArmCommander:
    """Implements `ports.Arm`.

    Args:
        setup: which arm, and how it plans.
        model: the robot; used for where the hand is, never for planning.
        planner: makes the plans, without blocking.
        executor: moves the joints of the arm's group.
        scene: what plans avoid.
        others: returns the measured states of the arm's hand and of the robot's other parts: obstacles, too.
        wrench: returns what a sensor at the wrist bears; see `ports.Arm.wrench`.
    """

    def __init__(
        self,
        setup: ArmSetup,
        model: RobotGeometry,
        planner: requests.PlanningService,
        executor: Executor,
        scene: PlanningScene,
        others: Callable[[], Sequence[JointState]] = tuple,
        wrench: Callable[[], Array] | None = None,
    ):
        self._wrench = wrench
        self.name, self._group, self._hand, self._settings = setup.name, setup.group, setup.hand, setup.settings
        self._more_states, self._taught = setup.states, setup.taught
        self._model, self._planner, self._executor = model, planner, executor
        self._scene, self._others = scene, others
        self._stream = SteeredMotion(executor, self._plan_step)
        self._lock = threading.Lock()
        self._reached_by: list[tuple[Pose, JointState]] = []
        self.ways = Ways()

    def state(self) -> JointState:
        return self._executor.state()

    def grasp_pose(self) -> Pose:
        return self._model.grasp_pose(self._executor.state(), group=self._group)

    def wrench(self) -> Array:
        if self._wrench is None:
            raise SensorError(
                f"arm {self.name!r} has no force-torque sensor; over ROS, name its topic:"
                f" `ros: {{controllers: {{{self.name}: {{..., wrench: /TOPIC}}}}}}`"
            )
        return self._wrench()

    def named_states(self) -> Mapping[str, JointState]:
        return {**self._taught.states(self.name), **self._described_states()}

    def plan(
        self,
        goal: JointState | Pose | str,
        *,
        start: JointState | None = None,
        free: str = "none",
        constraint: PathConstraint | None = None,
    ) -> Operation[Plan]:
        """Plan a free path; see `ports.Arm`.

        To a pose of a grasp that `choose_grasp` has returned, it goes by the joint positions that were found then:
        others may reach the pose too, but not the rest of the grasp.

        Raises:
            UnknownNameError: there is no such named state, or no such freedom.
        """
        if free not in FREEDOMS:
            raise UnknownNameError("freedom of a pose", free, FREEDOMS, where=f"arm {self.name!r}")
        goal = self._goal(goal)
        hints = () if isinstance(goal, JointState) else self._known_ways_to(goal)
        return self._ask(requests.PlanTo(self._situation(start), goal, hints, free, constraint))

    def plan_straight(self, goals: Sequence[Pose], *, start: JointState | None = None) -> Operation[Plan]:
        return self._ask(requests.PlanStraight(self._situation(start), tuple(goals)))

    def plan_through(
        self,
        way_points: Sequence[WayPoint],
        *,
        start: JointState | None = None,
        constraint: PathConstraint | None = None,
    ) -> Operation[Plan]:
        named = tuple(replace(point, goal=self._goal(point.goal)) for point in way_points)
        if not named:
            raise ValueError("at least one way point is needed")
        return self._ask(requests.PlanThrough(self._situation(start), named, constraint))

    def plan_from_trajectory(self, trajectory: Trajectory, *, slow_down: bool = False) -> Operation[Plan]:
        require_joints(trajectory.names, self._executor.joint_names, self.name)
        return self._ask(
            requests.CheckTrajectory(replace(self._situation(), settings=self._own_settings()), trajectory, slow_down)
        )

    def check_together(self, plans: Sequence[Plan]) -> Operation[None]:
        situation = replace(self._situation(), settings=self._own_settings())
        return self._planner.submit(requests.CheckTogether(situation, tuple(plans)))  # type: ignore[return-value]

    def jog(
        self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0), seconds: float = 0.5
    ) -> Operation[JointState]:
        goal = jogged(self.grasp_pose(), linear, angular, seconds)
        return self.plan_straight([goal]).then(
            lambda plan: self.execute(replace(plan, trajectory=plan.trajectory.stretched(seconds)))
        )

    def steer(self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0)) -> Operation[JointState]:
        bounded(linear, angular)
        return self._stream.steer(lambda _: (linear, angular))

    def steer_to(self, target: Pose, speed: float = 0.15) -> Operation[JointState]:
        return self._stream.steer(
            lambda there: approaching(self._model.grasp_pose(there, group=self._group), target, speed, HOLD)
        )

    def teach(self, name: str, *, pose: bool = False) -> JointState | Pose:
        state = self._executor.state()
        value = self.grasp_pose() if pose else JointState(state.names, state.position)
        self._taught.put(self.name, name, value, self._described_states())
        return value

    def taught(self) -> Mapping[str, JointState | Pose]:
        return self._taught.of(self.name)

    def execute(self, plan: Plan) -> Operation[JointState]:
        """Execute a plan; the result is what was measured at the end.

        Ends with ExecutionAbortedError when that is more than 0.05 rad from the plan's end; `data['errors']` tells
        by how much, joint by joint. Ends with OutOfLimitsError, and nothing has moved, where a plan breaks limits: it
        may be stored, or made by anybody. Those of move_group are left to its controllers.
        """
        try:
            require_joints(plan.trajectory.names, self._executor.joint_names, self.name)
            limits = None if plan.planner == MOVE_GROUP else self._model.limits_of(plan.trajectory.names)
            if limits is not None:
                refuse_beyond_limits(plan.trajectory, limits)
        except (OutOfLimitsError, UnknownNameError) as error:
            return Operation.failed(error)
        # What was planned before it has been thought better of.
        ends = plan.trajectory.positions[[0, -1]]
        planned = self.ways.planned
        own = [number for number, way in enumerate(planned) if np.array_equal(way.positions[[0, -1]], ends)]
        self.ways = self.ways._replace(planned=planned[own[-1] + 1 :] if own else planned)
        motion = self._executor.execute(plan.trajectory)
        self.ways = self.ways._replace(follows=plan.trajectory, moving=True)
        motion.add_done_callback(lambda: self._ended(plan.trajectory))
        return motion.then(lambda measured: _verified(plan, measured))

    def choose_grasp(self, grasps: Sequence[Grasp]) -> Operation[Grasp]:
        return self._planner.submit(requests.ChooseGrasp(self._situation(), tuple(grasps))).then(self._remember)

    def stop(self) -> None:
        self._executor.stop()

    def _described_states(self) -> Mapping[str, JointState]:
        return {**self._more_states, **self._model.named_states_of(self._group)}

    def _goal(self, goal: JointState | Pose | str) -> JointState | Pose:
        if not isinstance(goal, str):
            return goal
        states = self.named_states()
        if goal not in states:
            raise UnknownNameError("named state", goal, states, where=f"arm {self.name!r}")
        return states[goal]

    def _situation(self, given: JointState | None = None) -> requests.Situation:
        arm = self._executor.state()
        if given is not None:
            arm = replace(arm, position=given.ordered(arm.names))
        parts = (arm, *self._others())
        names = tuple(name for part in parts for name in part.names)
        start = JointState(names, np.concatenate([part.position for part in parts]), time=arm.time)
        return requests.Situation(self._group, start, self._scene.snapshot(), self._hand, self._settings)

    def _own_settings(self) -> PlanningSettings:
        """For what isn't searched: whoever plans, ours checks."""
        return self._settings.model_copy(update={"planner": PlanningSettings().planner})

    def _plan_step(self, start: JointState, twist: Twist, hold: float) -> Operation[Trajectory]:
        situation = self._situation(start)
        names = situation.start.names
        begin = replace(situation.start, velocity=velocity_of(start, names))
        linear, angular = (tuple(map(float, part)) for part in twist)
        request = requests.PlanServoStep(
            replace(situation, start=begin, settings=self._own_settings()), linear, angular, hold
        )
        return self._planner.submit(request).then(lambda plan: Operation.finished(plan.trajectory))  # type: ignore[union-attr]

    def _ask(self, request: requests.Request) -> Operation[Plan]:
        return self._planner.submit(request).then(self._keep)  # type: ignore[arg-type]

    def _keep(self, plan: Plan) -> Operation[Plan]:
        self.ways = self.ways._replace(planned=(*self.ways.planned, plan.trajectory)[-_PLANNED:])
        return Operation.finished(plan)

    def _ended(self, motion: Trajectory) -> None:
        if self.ways.follows is motion:
            self.ways = self.ways._replace(moving=False)

    def _remember(self, chosen: Plan | requests.ChosenGrasp | None) -> Operation[Grasp]:
        assert isinstance(chosen, requests.ChosenGrasp)
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
