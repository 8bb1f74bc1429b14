"""What goes wrong on purpose goes wrong when it is said, as often as it is said, and the same way for a seed."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from test_sim_forces import held

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import Trajectory
from grip_bt.commanders.description.load import load_robot
from grip_sim.faults import Fault, Faults, check_faults
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec

DT = 0.1
ROBOT = "panda"


class Played:
    """A world that writes down what is done to it."""

    def __init__(self, faults, seed=0, holding=("mug",)):
        self.time, self.holding, self.done = 0.0, list(holding), []
        self.faults, self.robot, self.told = Faults(faults, seed, self), self, []
        self.faults.on_event = lambda *event: self.told.append(event)

    def run(self, seconds):
        for _ in range(round(seconds / DT)):
            self.faults.stepped()
            self.time = round(self.time + DT, 6)
        return self.done

    def held_objects(self):
        return self.holding

    def let_slip(self, name, slips):
        self.done.append((self.time, "slip", name, slips))

    def push(self, name, by):
        self.done.append((self.time, "push", name, by))

    def restrict(self, joint, between):
        self.done.append((self.time, "restrict", joint, between))


def test_a_fault_begins_at_its_time_and_ends_after_its_duration():
    world = Played({"elbow": Fault(fault="limit", of="j4", between=(-1, 0), at=1.0, lasts=0.5)})
    assert world.run(5) == [(1.0, "restrict", "j4", (-1, 0)), (1.5, "restrict", "j4", None)]
    assert [event[1:] for event in world.told] == [
        ("limit of j4", False),
        ("limit is over", True),
    ]


def test_a_fault_at_a_node_is_due_each_time_the_node_begins_and_happens_as_often_as_allowed():
    world = Played({"slip": Fault(fault="drop", node="lift", at=0.2, times=2)})
    for _ in range(4):
        world.faults.entered("other")
        world.faults.entered("lift")
        world.run(1)
    assert [done for done in world.done if done[3]] == [(0.2, "slip", "mug", True), (1.2, "slip", "mug", True)]


@given(seed=st.integers(0, 2**32 - 1), chance=st.floats(0, 1), times=st.integers(0, 12))
def test_a_seed_draws_the_same_faults_again_and_more_chance_never_takes_one_away(seed, chance, times):
    def drops(chance):
        world = Played({"slip": Fault(fault="drop", node="lift", chance=chance, at=(0.0, 0.5))}, seed)
        for _ in range(times):
            world.faults.entered("lift")
            world.run(2)
        return [done for done in world.done if done[3]]

    assert drops(chance) == drops(chance)
    assert set(drops(chance)) <= set(drops(1.0))
    assert len(drops(1.0)) == times
    assert drops(0.0) == []


def test_a_drop_of_nothing_is_told():
    world = Played({"slip": Fault(fault="drop", at=1.0)}, holding=())
    assert world.run(3) == []
    assert [words for _, words, _ in world.told] == ["drop of nothing: no hand holds anything"]


@pytest.mark.parametrize(
    ("said", "wrong"),
    [
        ({"fault": "push", "of": "mug"}, "the fault `push` needs `by`"),
        ({"fault": "drop", "by": [1, 0, 0]}, "the fault `drop` takes no `by`"),
        ({"fault": "limit", "of": "j", "between": [1, 0]}, "from 1 to 0 isn't a range"),
        ({"fault": "stuck"}, "the fault `stuck` needs `of`: the joint's name"),
        ({"fault": "drop", "chance": 2}, "less than or equal to 1"),
        ({"fault": "drop", "at": [3, 1]}, "from 3 to 1 isn't a range"),
    ],
)
def test_what_is_no_fault_is_refused_in_words(said, wrong):
    with pytest.raises(ValidationError, match=wrong):
        Fault.model_validate(said)


def test_names_that_are_not_there_are_told_with_what_is():
    faults = {
        "a": Fault(fault="drop", of="mugg"),
        "b": Fault(fault="stuck", of="panda_joint4"),
        "c": Fault(fault="stuck", of="joint4"),
        "d": Fault(fault="blackout", of="above"),
        "e": Fault(fault="light", factor=0.5, of="lamp"),
        "f": Fault(fault="component_death", of="grasps"),
    }
    found = list(check_faults(faults, load_robot(ROBOT), ["mug"], ["overhead"], ["antipodal"]))
    assert [type(error) for error in found] == [UnknownNameError, UnknownNameError, UnknownNameError, GripError] + [
        UnknownNameError
    ]
    assert "mug" in str(found[0])
    assert "faults/a/of" in str(found[0])


@pytest.mark.sim
def test_what_a_hand_holds_falls_through_its_fingers_and_rests_on_the_table_then():
    world, _ = held(0.5, 5.0, ROBOT)
    world.faults = Faults({"slip": Fault(fault="drop", lasts=0.3)}, 0, world)
    before = world.object_pose("thing").position[2]
    for _ in range(int(0.3 / world.spec.dt)):
        world.step()
    assert world.object_pose("thing").position[2] < before - 0.3
    for _ in range(240):
        world.step()
    assert world.object_pose("thing").position[2] > world.spec.floor


@pytest.fixture(scope="module")
def table():
    pytest.importorskip("sapien")
    from grip_sim.world import World

    def make(**faults):
        things = (ObjectSpec("can", "cylinder", 0.03, 0.1, (0.5, 0.1, 0.05)),)
        cameras = (CameraSpec(width=64, height=48), CameraSpec("front", 64, 48))
        return World(WorldSpec(robot=ROBOT, objects=things, cameras=cameras, faults=faults))

    return make


@pytest.mark.sim
def test_a_push_gives_an_object_the_speed_that_is_said(table):
    world = table(nudge=Fault(fault="push", of="can", by=(0.0, 0.2, 0.1)))
    world.step()
    assert world.object_speeds("can")[0] == pytest.approx(np.hypot(0.2, 0.1 - 9.81 / 240), rel=0.02)


@pytest.mark.sim
@pytest.mark.parametrize(
    "fault", [{"fault": "stuck", "of": "panda_joint4"}, {"fault": "limit", "of": "panda_joint4", "between": (-9, -2.2)}]
)
def test_a_joint_that_cannot_move_makes_its_motion_fail_and_moves_again_afterwards(table, fault):
    from grip_sim.motions import Follow

    def motion(world):
        rows = world.robot.rows(["panda_joint4"])
        q = world.robot.positions()[rows]
        path = Trajectory(("panda_joint4",), [0.0, 1.0], [q, q + 0.3])
        follow = Follow(world.robot, rows, path, world.time)
        while (end := follow.advance(world)) is None:
            world.step()
        return end, float(world.robot.positions()[rows][0] - q[0])

    world = table(elbow=Fault(**fault, lasts=2.5))
    start = float(world.robot.positions()[world.robot.rows(["panda_joint4"])][0])
    world.step()
    end, moved = motion(world)
    assert end.error == "aborted"
    assert "panda_joint4" in end.message
    allowed = 0.0 if fault["fault"] == "stuck" else -2.2 - start
    assert moved == pytest.approx(allowed, abs=0.01)
    while world.time < 2.6:
        world.step()
    assert motion(world)[0].error == ""


@pytest.mark.sim
def test_cameras_see_nothing_repeat_themselves_and_darken_only_while_it_lasts(table):
    world = table(
        dark=Fault(fault="blackout", of="front", lasts=0.1),
        stale=Fault(fault="freeze", of="overhead", at=0.05, lasts=0.1),
        dim=Fault(fault="light", factor=0.5, at=0.3),
    )

    def at(time):
        while world.time < time:
            world.step()
        return world.cameras.look("overhead"), world.cameras.look("front")

    above, front = at(0.02)
    assert not front.image.any()
    assert not front.depth.any()
    world.move_object("can", replace(world.object_pose("can"), position=(0.55, 0.2, 0.05)))
    frozen, _ = at(0.06)
    assert np.array_equal(frozen.image, above.image)
    assert frozen.time > above.time
    bright, seen = at(0.2)
    assert seen.depth.any()
    assert not np.array_equal(bright.image, above.image)
    assert at(0.4)[0].image.mean() == pytest.approx(bright.image.mean() / 2, rel=0.02)


@pytest.mark.sim
def test_a_late_camera_shows_what_was_with_the_time_of_then(table):
    world = table(slow=Fault(fault="late", lag=0.1, at=0.1))
    while world.time < 0.25:
        world.step()
    assert 0.1 - 1e-9 <= world.time - world.cameras.look("overhead").time <= 0.1 + 1 / 60 + 1e-9
