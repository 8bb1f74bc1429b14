"""MoveIt's move_group as the planner of arms: the same requests as to the planning process, answered by MoveIt."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    BadReplyError,
    ExpectedError,
    GoalInCollisionError,
    NoIkError,
    NoPlanError,
    PathInvalidError,
    StartInCollisionError,
    TimeOutError,
)
from grip_bt.base.files import Closing
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Sequencer, Steps, run_steps
from grip_bt.base.values import Grasp, JointState, Plan, Pose, Trajectory
from grip_bt.base.values.joints import MOVE_GROUP
from grip_bt.base.values.pose import check_frame
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.planning.grasps import none_feasible, target_of
from grip_bt.commanders.planning.requests import (
    ChooseGrasp,
    ChosenGrasp,
    PlanStraight,
    PlanTo,
    Search,
    Situation,
)

from ..client.types import Message, load_type
from ..convert_values import header, joints_to_message, pose_to_message, pose_to_stamped, trajectory_from_message
from .client import MoveGroup
from .goals import ArmMapping, at_joints, at_pose, on_the_way
from .scene import PlanningSceneSync

STEP = 0.005
"""How far apart points of a straight line are [m]."""
JUMP = 0.3
"""A joint that moves further than this between two of them jumps [rad or m]."""
OUT_OF_REACH = "out of reach, or a joint would jump"
CLEARING = 3.0
"""How long closing waits for move_group to take our objects out of its scene [s]."""


class MoveGroupPlanner(Closing):
    """Implements `planning.service.PlanningService`.

    Requests are answered one after the other, because move_group has one scene. An arm's `kinematics` and `margin`
    don't reach MoveIt, which has settings of its own for them; speed, acceleration, time and attempts do.

    Args:
        robot: what it plans for; its base link is MoveIt's frame of world.
        arms: group of ours -> how it is called in MoveIt, and where its hand sits.
        hands: hand, as the scene knows it -> the mount of the arm that carries it.
        pipeline: MoveIt's planning pipeline, such as `ompl`; its default when empty.
        planner_id: its planner, such as `RRTConnectkConfigDefault`; its default when empty.
    """

    def __init__(
        self,
        move_group: MoveGroup,
        robot: RobotDescription,
        arms: Mapping[str, ArmMapping],
        hands: Mapping[str, ArmMapping],
        pipeline: str = "",
        planner_id: str = "",
    ):
        self._move_group, self.robot, self._arms = move_group, robot, dict(arms)
        self._pipeline, self._planner_id = pipeline, planner_id
        self._scene = PlanningSceneSync(move_group, robot, hands)
        self._requests = Sequencer()

    def submit(self, request: Search) -> Operation[Plan | ChosenGrasp | None]:
        """Ask; see `PlanningService`. Ends with PlannerLostError when move_group isn't there."""
        return self._requests.submit(lambda: run_steps(self._answer(request)))

    def close(self) -> None:
        """Take our objects out of move_group's scene."""
        self._requests.submit(lambda: run_steps(self._scene.clear())).wait(CLEARING)

    # --- what requests are answered with ---

    def mount(self, group: str) -> ArmMapping:
        """Return the mount of a group of ours; raises UnknownNameError where move_group doesn't plan for it."""
        if group not in self._arms:
            raise UnknownNameError("group that move_group plans for", group, self._arms, "grip.yaml: ros/move_group")
        return self._arms[group]

    def _answer(self, request: Search) -> Steps[Plan | ChosenGrasp | None]:
        begin, situation = time.monotonic(), request.situation
        if isinstance(request, ChooseGrasp):
            chosen = yield from choose(self, request)
            return chosen
        yield from self.show(situation)
        if isinstance(request, PlanStraight):
            trajectory = yield from self.straight(situation, situation.start, request.poses)
        else:
            trajectory = yield from self.free(request)
        return Plan(situation.group, trajectory, MOVE_GROUP, time.monotonic() - begin)

    def show(self, situation: Situation) -> Steps[None]:
        yield from self._scene.show(situation.scene)

    def free(self, request: PlanTo) -> Steps[Trajectory]:
        """Plan a free path in the scene that was shown."""
        situation, mount = request.situation, self.mount(request.situation.group)
        asked = load_type("moveit_msgs/msg/MotionPlanRequest")(
            **_common(situation, situation.start, mount),
            pipeline_id=self._pipeline,
            planner_id=self._planner_id,
            num_planning_attempts=situation.settings.attempts,
            allowed_planning_time=situation.settings.planning_time,
            goal_constraints=self._goals(request, mount),
        )
        if request.constraint is not None:
            asked.path_constraints = on_the_way(request.constraint, mount, self.robot.base_link)
        try:
            answer = yield self._move_group.plan(asked, situation.settings.planning_time)
        except (NoPlanError, TimeOutError) as error:
            yield from self._say_what_is_wrong(request, mount, error)
            raise
        return self._trajectory(answer.planned_trajectory, mount)

    def straight(self, situation: Situation, start: JointState, poses: tuple[Pose, ...]) -> Steps[Trajectory]:
        """Plan straight lines of the grasp frame through poses in world, in the scene that was shown.

        Raises:
            NoIkError, PathInvalidError: they can't be followed to their end; `data['fraction']` tells how far.
        """
        mount = self.mount(situation.group)
        asked = load_type("moveit_msgs/srv/GetCartesianPath").Request(
            **_common(situation, start, mount),
            header=header(self.robot.base_link),
            link_name=mount.link,
            waypoints=[pose_to_message(self._in_base(mount.link_pose(pose))) for pose in poses],
            max_step=STEP,
            prismatic_jump_threshold=JUMP,
            revolute_jump_threshold=JUMP,
            avoid_collisions=True,
        )
        answer = yield self._move_group.cartesian(asked)
        if answer.fraction < 1 - 1e-3:
            asked.avoid_collisions = False
            without = yield self._move_group.cartesian(asked)
            blocked = without.fraction > answer.fraction + 1e-3
            kind, why = (PathInvalidError, "something is in the way") if blocked else (NoIkError, OUT_OF_REACH)
            far = f"{why}, only {answer.fraction:.0%} of the way along the line"
            raise kind(far, fraction=float(answer.fraction))
        return self._trajectory(answer.solution, mount)

    def inverse(self, situation: Situation, start: JointState, pose: Pose, collisions: bool) -> Steps[JointState]:
        """Return joint positions at which the grasp frame is at `pose`; ends with NoIkError when there are none.

        Args:
            start: all joints; where the search begins, and where the hand's are.
            pose: in world.
            collisions: whether they must touch nothing in the scene that was shown.
        """
        mount = self.mount(situation.group)
        asked = load_type("moveit_msgs/msg/PositionIKRequest")(
            group_name=mount.group,
            robot_state=_state(start),
            avoid_collisions=collisions,
            ik_link_name=mount.link,
            pose_stamped=pose_to_stamped(self._in_base(mount.link_pose(pose))),
        )
        asked.timeout.sec = 1
        solution = yield self._move_group.inverse(asked)
        positions = dict(zip(solution.joint_state.name, solution.joint_state.position, strict=True))
        missing = [joint for joint in mount.joints if joint not in positions]
        if missing:
            raise BadReplyError(f"{self._move_group.name}: its solution lacks {', '.join(missing)}", joints=missing)
        return JointState(mount.joints, np.array([positions[joint] for joint in mount.joints]))

    # --- requests and replies ---

    def _goals(self, request: PlanTo, mount: ArmMapping) -> list[Message]:
        """Return the goals, any of which will do; joints that a goal doesn't name stay where they are."""
        if request.hints:  # these reach the pose, and what comes after it
            return [at_joints(JointState(mount.joints, hint.ordered(mount.joints))) for hint in request.hints]
        if isinstance(request.goal, JointState):
            start, wanted = request.situation.start.as_mapping(), request.goal.as_mapping()
            for joint in wanted:
                if joint not in mount.joints:
                    raise UnknownNameError("joint", joint, mount.joints, where="goal")
            return [at_joints(JointState.from_mapping({j: wanted.get(j, start[j]) for j in mount.joints}))]
        poses = request.goal if isinstance(request.goal, tuple) else (request.goal,)
        frame = self.robot.base_link
        return [c for pose in poses for c in at_pose(self._in_base(pose), request.free, mount, frame)]

    def _say_what_is_wrong(self, request: PlanTo, mount: ArmMapping, error: ExpectedError) -> Steps[None]:
        """Raise a better word than "no plan" for a pose that can't be reached; MoveIt doesn't tell them apart."""
        if not isinstance(request.goal, Pose) or request.free != "none" or request.hints:
            return
        situation = request.situation
        try:
            yield from self.inverse(situation, situation.start, request.goal, collisions=False)
        except NoIkError:
            raise NoIkError(f"no joint positions reach {request.goal}", pose=request.goal, **error.data) from None
        try:
            yield from self.inverse(situation, situation.start, request.goal, collisions=True)
        except NoIkError:
            reason = f"wherever {request.goal} is reached, the robot touches something"
            raise GoalInCollisionError(reason, **error.data) from None

    def _trajectory(self, found: Message, mount: ArmMapping) -> Trajectory:
        message = found.joint_trajectory
        if set(message.joint_names) != set(mount.joints):
            names = ", ".join(message.joint_names) or "nothing"
            reason = f"it moves {names}, and the arm has {', '.join(mount.joints)}"
            raise BadReplyError(f"{self._move_group.name}: group {mount.group!r} isn't the arm's: {reason}")
        try:
            return trajectory_from_message(message)
        except ValueError as error:
            raise BadReplyError(f"{self._move_group.name}: not a trajectory that can be followed: {error}") from None

    def _in_base(self, pose: Pose) -> Pose:
        check_frame(pose, "world")
        return Pose(pose.position, pose.quaternion, self.robot.base_link)


def _state(joints: JointState) -> Message:
    """Return a robot state in which only the joints are other than in move_group's scene."""
    return load_type("moveit_msgs/msg/RobotState")(joint_state=joints_to_message(joints), is_diff=True)


def _common(situation: Situation, start: JointState, mount: ArmMapping) -> dict[str, object]:
    """Return what every request for a path holds."""
    settings = situation.settings
    return {
        "start_state": _state(start),
        "group_name": mount.group,
        "max_velocity_scaling_factor": settings.speed,
        "max_acceleration_scaling_factor": settings.acceleration or settings.speed,
    }


_UNFIT = (NoIkError, PathInvalidError, NoPlanError, TimeOutError, GoalInCollisionError)


def choose(planner: MoveGroupPlanner, request: ChooseGrasp) -> Steps[ChosenGrasp]:
    """Return the first feasible grasp, by falling quality.

    Raises:
        NoGraspError: none is; `data['reasons']` counts why, `data['candidates']` how many there were.
    """
    reasons: Counter[str] = Counter()
    for grasp in sorted(request.grasps, key=lambda g: -g.quality):
        trial = _Trial(planner, request.situation, grasp)
        try:
            pre, at = yield from trial.run()
        except _UNFIT:
            reasons[trial.stage] += 1
        else:
            return ChosenGrasp(grasp, pre, at, dict(reasons))
    raise none_feasible(reasons, len(request.grasps))


class _Trial:
    """One candidate; `stage` says how far it got, in the words of `commanders.planning.grasps`."""

    def __init__(self, planner: MoveGroupPlanner, situation: Situation, grasp: Grasp):
        self._planner, self._grasp = planner, grasp
        posture = grasp.pre_posture or planner.robot.opened(situation.group)
        self._situation = replace(situation, start=_with(situation.start, posture))
        self._target = target_of(grasp, situation.scene)
        self.stage = "no_ik"

    def run(self) -> Steps[tuple[JointState, JointState]]:
        """Return the arm's joints at the pre-grasp and at the grasp; ends with one of `_UNFIT`."""
        planner, whole, grasp = self._planner, self._situation, self._grasp
        free = whole if self._target is None else replace(whole, scene=whole.scene.without([self._target]))
        yield from planner.show(free)
        at = yield from self._at_grasp(free)
        self.stage = "approach_blocked"
        away = yield from planner.straight(free, _with(whole.start, at), (grasp.pre_grasp,))
        pre = away.end()
        self.stage = "lift_blocked"
        if self._target is not None:
            held = replace(whole, scene=whole.scene.attaching(self._target, whole.hand, grasp.pose))
            yield from planner.show(held)
        yield from planner.straight(whole, _with(whole.start, at), (grasp.post_grasp,))
        self.stage = "no_plan"
        yield from planner.show(whole)
        with suppress(StartInCollisionError):  # the plan itself will tell so
            yield from planner.free(PlanTo(whole, pre))
        return pre, at

    def _at_grasp(self, free: Situation) -> Steps[JointState]:
        try:
            return (yield from self._planner.inverse(free, free.start, self._grasp.pose, collisions=True))
        except NoIkError:
            yield from self._planner.inverse(free, free.start, self._grasp.pose, collisions=False)
            self.stage = "in_collision"
            raise


def _with(state: JointState, other: JointState) -> JointState:
    positions = {**state.as_mapping(), **other.as_mapping()}
    return JointState(tuple(positions), np.array(list(positions.values())), time=state.time)
