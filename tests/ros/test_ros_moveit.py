"""MoveIt's move_group as planner and executor: a stand-in in a process of its own, asked by the requests of ours."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from ros_bench import ended, servers

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    CanceledError,
    ConstraintBrokenError,
    ExecutionAbortedError,
    GoalInCollisionError,
    GoalRejectedError,
    NoGraspError,
    NoIkError,
    NoPlanError,
    OutOfLimitsError,
    PathInvalidError,
    PlannerLostError,
    StartInCollisionError,
    TimeOutError,
)
from grip_bt.base.ports import Executor
from grip_bt.base.values import Grasp, JointState, Pose, Trajectory
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.planning.requests import ChooseGrasp, PlanStraight, PlanTo, Situation
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.settings import PlanningSettings

pytestmark = [pytest.mark.ros, pytest.mark.slow]
ROBOT = "ur5_allegro"


@pytest.fixture(scope="module")
def robot():
    return load_robot(ROBOT, Path.cwd())


@pytest.fixture(scope="module")
def model(robot):
    from grip_bt.commanders.kinematics.model import RobotModel

    return RobotModel(robot)


@pytest.fixture(scope="module")
def start_move_group(own_domain):
    """Return a function that starts the stand-in."""
    from grip_bt.ros.interfaces.build import ensure_package

    prefixes = ensure_package("moveit_msgs")
    with servers(own_domain) as start:
        yield partial(start, "move_group_server.py", ROBOT, overlays=prefixes)


@pytest.fixture(scope="module", autouse=True)
def patient():
    """Have what is asked of move_group wait for its answers as long as a slow machine needs."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("client.ANSWER", "client.LATE", "planner.CLEARING"):
            patch.setattr(f"grip_bt.ros.moveit.{name}", PATIENCE)
        yield


@pytest.fixture(scope="module")
def shared(start_move_group, own_domain):
    """Return a bus, with a stand-in running that all tests share."""
    from patient_bus import PatientBus

    start_move_group()
    with PatientBus("moveit_tests", domain_id=own_domain) as bus:
        yield bus


@pytest.fixture
def scene(model, robot):
    """Return a scene of ours whose hand is where the robot rests."""
    return PlanningScene({"hand": lambda: model.grasp_pose(home(robot))})


@pytest.fixture
def planning(shared, robot):
    """Return a function that makes a planner, closed afterwards."""
    from grip_bt.ros.moveit import ArmMapping, MoveGroup, MoveGroupPlanner

    opened = []

    def make(planner_id: str = "", namespace: str = "", wait: float = PATIENCE, **more) -> MoveGroupPlanner:
        mount = ArmMapping.of(robot, "arm", "hand")
        group = MoveGroup(shared, namespace, wait)
        opened.append(MoveGroupPlanner(group, robot, {"arm": mount}, {"hand": mount}, planner_id=planner_id, **more))
        return opened[-1]

    yield make
    for planner in opened:
        planner.close()


def home(robot) -> JointState:
    return robot.named_state("arm", "home")


def situation(robot, scene, **settings) -> Situation:
    start = {**home(robot).as_mapping(), **robot.named_state("hand", "open").as_mapping()}
    chosen = PlanningSettings(planner="move_group", planning_time=30.0, **settings)
    return Situation("arm", JointState.from_mapping(start), scene.snapshot(), "hand", chosen)


def moved(robot, **by: float) -> JointState:
    positions = home(robot).as_mapping()
    return JointState.from_mapping({n: q + by.get(n, 0.0) for n, q in positions.items()})


def messages(bus):
    """Return what the stand-in's scene holds: objects of the world, attached ones, allowed pairs."""
    from grip_bt.ros.client.types import load_type

    type_ = load_type("moveit_msgs/srv/GetPlanningScene")
    scene = ended(bus.service(type_, "/get_planning_scene").call(type_.Request())).scene
    matrix = scene.allowed_collision_matrix
    allowed = {
        (one, other)
        for one, row in zip(matrix.entry_names, matrix.entry_values, strict=True)
        for other, may in zip(matrix.entry_names, row.enabled, strict=True)
        if may
    }
    attached = {a.object.id: a for a in scene.robot_state.attached_collision_objects}
    return {o.id: o for o in scene.world.collision_objects}, attached, allowed


def test_a_plan_to_joints_begins_and_ends_where_it_was_asked_to(planning, robot, scene):
    goal = moved(robot, elbow_joint=-0.3)
    plan = ended(planning().submit(PlanTo(situation(robot, scene), JointState.from_mapping({"elbow_joint": 1.13}))))
    assert (plan.group, plan.planner) == ("arm", "move_group")
    assert plan.trajectory.positions[0] == pytest.approx(home(robot).ordered(plan.trajectory.names), abs=1e-3)
    assert plan.trajectory.end().ordered(goal.names) == pytest.approx(goal.position, abs=1e-3)
    assert plan.trajectory.duration > 0


def test_a_plan_to_a_pose_brings_the_grasp_frame_there(planning, robot, scene, model):
    goal = model.grasp_pose(moved(robot, shoulder_pan_joint=0.4, wrist_1_joint=0.3))
    plan = ended(planning().submit(PlanTo(situation(robot, scene), goal)))
    reached = model.grasp_pose(plan.trajectory.end())
    assert reached.position == pytest.approx(goal.position, abs=2e-3)
    assert np.abs((goal.inverse() @ reached).rotation() - np.eye(3)).max() < 0.02


def test_speed_is_a_part_of_the_limits(planning, robot, scene):
    goal = moved(robot, shoulder_pan_joint=0.8)
    fast, slow = (
        ended(planning().submit(PlanTo(situation(robot, scene, speed=speed), goal))).trajectory.duration
        for speed in (0.8, 0.2)
    )
    assert slow > 1.5 * fast


def test_objects_of_the_scene_are_avoided_and_forgotten_when_they_go(planning, robot, scene, model, shared):
    planner, goal = planning(), model.grasp_pose(moved(robot, shoulder_pan_joint=0.4))
    scene.set_box("crate", (0.1, 0.1, 0.1), Pose(goal.position))
    with pytest.raises(GoalInCollisionError, match="touches something") as caught:
        ended(planner.submit(PlanTo(situation(robot, scene), goal)))
    assert caught.value.data["moveit"] == "planning_failed"
    assert set(messages(shared)[0]) == {"crate"}
    scene.remove("crate")
    ended(planner.submit(PlanTo(situation(robot, scene), goal)))
    assert messages(shared)[0] == {}


def test_every_shape_reaches_move_group_as_what_it_is(planning, robot, scene, shared):
    from grip_bt.base.values.solids import CellMap, Cylinder, Mesh, Sphere

    far = Pose(np.array([3.0, 3.0, 0.0]))
    corners = np.array([(x, y, z) for x in (0, 0.1) for y in (0, 0.2) for z in (0, 0.3)])
    scene.set_box("box", (0.1, 0.2, 0.3), far)
    scene.put("can", Cylinder(0.05, 0.2), far)
    scene.put("ball", Sphere(0.04), far)
    scene.put("hull", Mesh(corners), far)
    scene.put("thick", Mesh(corners, margin=0.01), far)
    scene.put("cells", CellMap(np.array([[0, 0, 0], [1, 0, 0]]), 0.1), far)
    ended(planning().submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1))))
    world, _, _ = messages(shared)
    assert list(world["box"].primitives[0].dimensions) == [0.1, 0.2, 0.3]
    assert list(world["can"].primitives[0].dimensions) == [0.2, 0.05]  # height, radius
    assert list(world["ball"].primitives[0].dimensions) == [0.04]
    assert (len(world["hull"].meshes[0].vertices), len(world["hull"].meshes[0].triangles)) == (8, 12)
    assert max(v.z for v in world["thick"].meshes[0].vertices) == pytest.approx(0.31)
    assert (len(world["cells"].meshes[0].vertices), len(world["cells"].meshes[0].triangles)) == (16, 24)
    assert world["box"].header.frame_id == robot.base_link
    assert (world["ball"].pose.position.x, world["ball"].pose.position.y) == (3.0, 3.0)


def test_what_a_hand_takes_moves_with_it_and_may_be_touched_until_it_is_let_go(planning, robot, scene, shared, model):
    from grip_bt.ros.convert_values import pose_from_message

    planner, grasp = planning(), model.grasp_pose(home(robot))
    scene.set_box("cube", (0.05, 0.05, 0.05), grasp)
    scene.attach("cube", "hand")
    ended(planner.submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1))))
    world, attached, _ = messages(shared)
    assert (set(world), set(attached)) == (set(), {"cube"})
    held = attached["cube"]
    assert held.link_name == robot.grasp_frame.link == held.object.header.frame_id
    assert set(held.touch_links) == set(robot.hand_links)
    at = pose_from_message(held.object.pose)
    assert at.position == pytest.approx(robot.grasp_frame.pose.position, abs=1e-6)
    scene.detach("cube")
    scene.remove("cube")
    ended(planner.submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1))))
    assert messages(shared)[:2] == ({}, {})


def test_allowing_and_forbidding_a_contact_leaves_what_the_robot_declares(planning, robot, scene, shared):
    planner, goal = planning(), moved(robot, elbow_joint=-0.1)
    declared = messages(shared)[2]
    assert {(a, b) for a, b in robot.disabled_pairs} <= declared
    scene.set_box("table", (0.1, 0.1, 0.1), Pose(np.array([3.0, 3.0, 0.0])))
    scene.allow("table", "*")
    ended(planner.submit(PlanTo(situation(robot, scene), goal)))
    allowed = messages(shared)[2]
    assert {("table", robot.hand_links[0]), (robot.grasp_frame.link, "table")} <= allowed
    assert declared <= allowed
    scene.allow("table", "*", allowed=False)
    ended(planner.submit(PlanTo(situation(robot, scene), goal)))
    assert messages(shared)[2] == declared


def test_closing_takes_out_what_was_sent_and_leaves_what_others_put_there(robot, scene, shared):
    from grip_bt.base.values.solids import Sphere
    from grip_bt.ros.client.types import load_type
    from grip_bt.ros.moveit import ArmMapping, MoveGroup, MoveGroupPlanner
    from grip_bt.ros.moveit.goals import collision_object

    group, mount = MoveGroup(shared, wait=PATIENCE), ArmMapping.of(robot, "arm", "hand")
    theirs = load_type("moveit_msgs/msg/PlanningScene")(is_diff=True)
    theirs.robot_state.is_diff = True
    pose = Pose(np.array([3.0, 3.0, 0.0]))
    theirs.world.collision_objects = [collision_object("theirs", Sphere(0.1), pose, robot.base_link)]
    ended(group.apply(theirs))
    scene.set_box("ours", (0.1, 0.1, 0.1), pose)
    with MoveGroupPlanner(group, robot, {"arm": mount}, {"hand": mount}) as planner:
        ended(planner.submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1))))
        assert set(messages(shared)[0]) == {"ours", "theirs"}
    assert set(messages(shared)[0]) == {"theirs"}
    theirs.world.collision_objects[0].operation = b"\x01"
    ended(group.apply(theirs))


def test_an_object_that_move_group_does_not_take_is_named(planning, robot, scene, shared):
    planner = planning()
    scene.set_box("refused", (0.1, 0.1, 0.1), Pose(np.array([3.0, 3.0, 0.0])))
    with pytest.raises(GoalRejectedError, match="/move_group rejected the planning scene: refused; its log tells why"):
        ended(planner.submit(PlanTo(situation(robot, scene), moved(robot))))
    from grip_bt.ros.client.types import load_type
    from grip_bt.ros.moveit import MoveGroup
    from grip_bt.ros.moveit.goals import removed

    undo = load_type("moveit_msgs/msg/PlanningScene")(is_diff=True)
    undo.robot_state.is_diff = True
    undo.world.collision_objects = [removed("refused")]
    ended(MoveGroup(shared, wait=PATIENCE).apply(undo))


def test_a_straight_line_is_followed_or_ends_with_how_far_it_got(planning, robot, scene, model):
    planner, here = planning(), model.grasp_pose(home(robot))
    plan = ended(planner.submit(PlanStraight(situation(robot, scene), (here.moved((0, 0, 0.08)),))))
    places = np.array(
        [model.grasp_pose(JointState(plan.trajectory.names, q)).position for q in plan.trajectory.positions]
    )
    assert places[-1] == pytest.approx(here.position + (0, 0, 0.08), abs=2e-3)
    assert np.abs(places[:, :2] - here.position[:2]).max() < 2e-3
    with pytest.raises(NoIkError, match="out of reach, or a joint would jump, only .*% of the way") as caught:
        ended(planner.submit(PlanStraight(situation(robot, scene), (here.moved((0, 0, 3.0)),))))
    assert 0 <= caught.value.data["fraction"] < 1
    scene.set_box("shelf", (0.6, 0.6, 0.02), Pose(here.position + (0, 0, 0.3)))
    with pytest.raises(PathInvalidError, match="something is in the way"):
        ended(planner.submit(PlanStraight(situation(robot, scene), (here.moved((0, 0, 0.2)),))))


def test_a_pose_out_of_reach_is_no_ik(planning, robot, scene):
    with pytest.raises(NoIkError, match="no joint positions reach"):
        ended(planning().submit(PlanTo(situation(robot, scene), Pose(np.array([5.0, 0.0, 1.0])))))


def test_names_that_are_not_there_are_told_before_anything_is_asked(planning, robot, scene):
    other = replace(situation(robot, scene), group="hand")
    with pytest.raises(UnknownNameError, match="group that move_group plans for 'hand'"):
        ended(planning().submit(PlanTo(other, home(robot))))
    with pytest.raises(UnknownNameError, match="did you mean 'elbow_joint'"):
        ended(planning().submit(PlanTo(situation(robot, scene), JointState.from_mapping({"elbow_join": 0.0}))))


@pytest.mark.parametrize(
    ("code", "error", "words"),
    [
        (-1, NoPlanError, "no path was found"),
        (-6, TimeOutError, "give the arm a longer `planning_time`"),
        (-10, StartInCollisionError, "touches something where the motion begins"),
        (-11, ConstraintBrokenError, "the start violates"),
        (-12, GoalInCollisionError, "at the goal"),
        (-15, GoalRejectedError, r"groups: \{GROUP: ITS_NAME\}"),
        (-26, OutOfLimitsError, "outside its limits"),
        (-29, PlannerLostError, "its planner crashed"),
        (99999, NoPlanError, "without a reason"),
        (-4711, NoPlanError, "code -4711, which this version doesn't know"),
    ],
)
def test_an_error_code_is_a_failure_with_a_name_and_moveits_words(planning, robot, scene, code, error, words):
    with pytest.raises(error, match=words) as caught:
        ended(planning(f"fail:{code}").submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1))))
    assert caught.value.data["moveit_code"] == code
    assert caught.value.data["moveit_says"] == "so it was asked"


def test_every_code_of_moveit_has_a_meaning():
    from grip_bt.ros.client.types import constant_name, load_type
    from grip_bt.ros.interfaces.build import ensure_package
    from grip_bt.ros.moveit.client import FAILURES

    ensure_package("moveit_msgs")
    codes = load_type("moveit_msgs/msg/MoveItErrorCodes")
    names = {n for n in dir(type(codes)) if n.isupper() and isinstance(getattr(codes, n), int)}
    assert {"SUCCESS", "NO_IK_SOLUTION"} < names
    assert FAILURES.keys() == names - {"SUCCESS"}
    assert constant_name(codes(), -31) == "NO_IK_SOLUTION"


def test_a_plan_under_way_is_cancelled_and_the_next_one_is_made(planning, robot, scene):
    hanging = planning("hang")
    under_way = hanging.submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1)))
    queued = hanging.submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1)))
    queued.cancel()
    with pytest.raises(CanceledError, match="before its turn"):
        ended(queued)
    assert not under_way.done()
    under_way.cancel()
    with pytest.raises(CanceledError):
        ended(under_way)
    ended(planning().submit(PlanTo(situation(robot, scene), moved(robot, elbow_joint=-0.1))))


def test_a_move_group_that_is_not_there_is_named(planning, robot, scene):
    with pytest.raises(PlannerLostError, match=r"/nowhere/move_group: the scene: .*no server within") as caught:
        ended(planning(namespace="/nowhere", wait=0.3).submit(PlanTo(situation(robot, scene), moved(robot))))
    assert caught.value.data["cause"] == "server_lost"


def test_one_that_was_started_anew_gets_the_whole_scene_again(planning, robot, scene, start_move_group, shared):
    first = start_move_group("/again")
    planner, goal = planning(namespace="/again"), moved(robot, elbow_joint=-0.1)
    scene.set_box("crate", (0.1, 0.1, 0.1), Pose(np.array([3.0, 3.0, 0.0])))
    ended(planner.submit(PlanTo(situation(robot, scene), goal)))
    first.kill()
    first.wait()
    start_move_group("/again")
    ended(planner.submit(PlanTo(situation(robot, scene), goal)))
    from grip_bt.ros.client.types import load_type

    type_ = load_type("moveit_msgs/srv/GetPlanningScene")
    shown = ended(shared.service(type_, "/again/get_planning_scene").call(type_.Request())).scene
    assert [o.id for o in shown.world.collision_objects] == ["crate"]


def test_the_first_grasp_that_can_be_done_is_chosen_and_others_are_counted(planning, robot, scene, model):
    here = model.grasp_pose(home(robot))
    scene.set_box("cube", (0.04, 0.04, 0.04), here.moved(0.05 * here.rotation()[:, 2]))

    def grasp(pose, quality):
        return Grasp(pose, pose.moved((0, 0, 0.05)), pose.moved((0, 0, 0.1)), width=0.04, quality=quality)

    out_of_reach = grasp(Pose(np.array([5.0, 0.0, 1.0])), 2.0)
    chosen = ended(planning().submit(ChooseGrasp(situation(robot, scene), (grasp(here, 1.0), out_of_reach))))
    assert chosen.grasp == grasp(here, 1.0)
    assert chosen.reasons == {"no_ik": 1}
    reached = model.grasp_pose(chosen.at_pre_grasp)
    assert reached.position == pytest.approx(here.position + (0, 0, 0.05), abs=3e-3)
    with pytest.raises(NoGraspError, match="none of 1 grasps is feasible: 1 no_ik"):
        ended(planning().submit(ChooseGrasp(situation(robot, scene), (out_of_reach,))))


# --- execution ---


@pytest.fixture
def executor(shared, robot):
    from patient_bus import joints_of

    from grip_bt.ros.moveit import MoveGroupExecutor

    joints = robot.group("arm")
    states = joints_of(shared, joints)
    return MoveGroupExecutor(shared, "/execute_trajectory", joints, states)


def to(executor, goal: JointState, seconds: float = 0.5) -> Trajectory:
    start = executor.state()
    rows = np.linspace(start.position, goal.ordered(start.names), 11)
    return Trajectory(start.names, np.linspace(0, seconds, 11), rows)


def test_move_group_executes_what_was_planned_and_the_end_is_measured(executor, robot):
    assert isinstance(executor, Executor)
    goal = moved(robot, elbow_joint=-0.2)
    measured = ended(executor.execute(to(executor, goal)))
    assert measured.ordered(goal.names) == pytest.approx(goal.position, abs=1e-3)
    ended(executor.execute(to(executor, home(robot))))


def test_a_motion_that_is_stopped_or_given_up_says_so(executor, robot):
    under_way = executor.execute(to(executor, moved(robot, elbow_joint=-0.5), 300.0))
    under_way.cancel()
    with pytest.raises(CanceledError):
        ended(under_way)
    blocked = moved(robot, shoulder_pan_joint=2.8 - home(robot).as_mapping()["shoulder_pan_joint"])
    with pytest.raises(ExecutionAbortedError, match=r"a controller aborted the motion \(blocked\)") as caught:
        ended(executor.execute(to(executor, blocked)))
    assert (caught.value.data["moveit"], caught.value.data["moveit_code"]) == ("control_failed", -4)
    assert math.isfinite(executor.state().position[0])
    ended(executor.execute(to(executor, home(robot))))


# --- goals in MoveIt's words ---


@pytest.fixture
def mounted(shared, robot):
    """Return functions of a mount whose link has the grasp frame's axes in another order, and one that lies askew."""
    from grip_bt.ros.moveit import ArmMapping

    def mount(frame: Pose) -> ArmMapping:
        return ArmMapping("arm", robot.group("arm"), "tool", frame, ())

    quarter, askew = math.sqrt(0.5), math.cos(math.radians(15))
    ordered = Pose((0.1, 0, 0), (quarter, 0, quarter, 0), "tool")  # the grasp frame's z is the link's x
    return mount(ordered), mount(Pose((0, 0, 0), (askew, math.sin(math.radians(15)), 0, 0), "tool"))


def tolerances(constraints) -> list[float]:
    (one,) = constraints.orientation_constraints
    return [one.absolute_x_axis_tolerance, one.absolute_y_axis_tolerance, one.absolute_z_axis_tolerance]


def test_a_free_turn_is_a_tolerance_about_the_links_axis_or_several_goals(mounted):
    from grip_bt.ros.convert_values import pose_from_message
    from grip_bt.ros.moveit.goals import ANY, TURN, TURNS, at_pose

    ordered, askew = mounted
    pose = Pose((0.4, 0.1, 0.3), (0.5, 0.5, 0.5, 0.5))
    (exact,) = at_pose(pose, "none", ordered, "base")
    assert tolerances(exact) == [TURN, TURN, TURN]
    (position,) = exact.position_constraints
    offset = position.target_point_offset
    assert (offset.x, offset.y, offset.z) == (0.1, 0, 0)
    assert pose_from_message(position.constraint_region.primitive_poses[0]) == Pose(pose.position, pose.quaternion)
    (about_z,) = at_pose(pose, "z", ordered, "base")
    assert tolerances(about_z) == [ANY, TURN, TURN]  # the link's x
    (anyhow,) = at_pose(pose, "orientation", ordered, "base")
    assert (len(anyhow.position_constraints), anyhow.orientation_constraints) == (1, [])
    turned = at_pose(pose, "z", askew, "base")
    assert len(turned) == TURNS
    assert len({tuple(np.round(_link_turn(c), 6)) for c in turned}) == TURNS
    assert len(at_pose(pose, "x", askew, "base")) == 1  # that axis they share


def _link_turn(constraints) -> list[float]:
    q = constraints.orientation_constraints[0].orientation
    return [abs(q.w), abs(q.x), abs(q.y), abs(q.z)]


def test_what_a_path_keeps_to_is_said_about_the_link(mounted):
    from grip_bt.base.values import PathConstraint
    from grip_bt.ros.moveit.goals import ANY, on_the_way

    ordered, askew = mounted
    upright = PathConstraint(orientation=Pose(), tolerance=(0.1, 0.2, np.inf), axes="own")
    assert tolerances(on_the_way(upright, ordered, "base")) == [ANY, 0.2, 0.1]
    same = PathConstraint(orientation=Pose(), tolerance=(0.1, 0.1, 0.1), axes="own")
    assert tolerances(on_the_way(same, askew, "base")) == [0.1, 0.1, 0.1]
    with pytest.raises(GoalRejectedError, match="only about the axes of the link that carries the hand"):
        on_the_way(upright, askew, "base")
    boxed = on_the_way(PathConstraint(box=Pose((0, 0, 1.0)), size=(0.2, 0.4, 0.6)), ordered, "base")
    (region,) = [p.constraint_region for p in boxed.position_constraints]
    assert list(region.primitives[0].dimensions) == [0.2, 0.4, 0.6]
    assert boxed.orientation_constraints == []
