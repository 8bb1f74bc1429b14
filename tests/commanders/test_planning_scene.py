import numpy as np
import pytest

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.ports import Scene
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Cylinder
from grip_bt.commanders.scene import PlanningScene


class MovingHand:
    def __init__(self):
        self.pose = Pose([0.3, 0.0, 0.4])

    def __call__(self):
        return self.pose


@pytest.fixture
def hand():
    return MovingHand()


@pytest.fixture
def scene(hand):
    scene = PlanningScene({"right": hand}, {"table": ((1, 1, 0.1), Pose([0, 0, -0.05]))})
    scene.set_box("mug", (0.06, 0.06, 0.1), Pose([0.35, 0.0, 0.4]))
    return scene


def test_it_satisfies_the_port(scene):
    assert isinstance(scene, Scene)


def test_a_snapshot_does_not_see_later_changes(scene):
    before = scene.snapshot()
    scene.remove("mug")
    scene.put("can", Cylinder(0.03, 0.1), Pose([0.5, 0, 0.05]))
    assert set(before.objects) == {"table", "mug"}
    assert set(scene.names()) == {"table", "can"}


def test_an_attached_object_moves_with_the_hand_and_stays_where_it_is_let_go(scene, hand):
    scene.attach("mug", "right")
    assert scene.attached("right") == ("mug",)
    quarter = np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    hand.pose = Pose([0.0, 0.5, 0.6], quarter)
    size, pose = scene.box("mug")
    assert size == pytest.approx([0.06, 0.06, 0.1])
    assert pose.position == pytest.approx([0.0, 0.55, 0.6])
    scene.detach("mug")
    hand.pose = Pose([1.0, 1.0, 1.0])
    assert scene.attached("right") == ()
    assert scene.box("mug")[1].position == pytest.approx([0.0, 0.55, 0.6])


def test_attaching_twice_does_not_move_the_object(scene, hand):
    scene.attach("mug", "right")
    hand.pose = Pose([0.0, 0.5, 0.6])
    before = scene.box("mug")[1]
    scene.attach("mug", "right")
    assert scene.box("mug")[1] == before


def test_removing_and_detaching_what_is_not_there_does_nothing(scene):
    before = scene.snapshot()
    scene.remove("spoon")
    scene.detach("spoon")
    scene.detach("mug")
    assert scene.snapshot() == before


def test_the_room_can_be_neither_removed_nor_replaced_nor_taken(scene):
    for change in (
        lambda: scene.remove("table"),
        lambda: scene.set_box("table", (1, 1, 1), Pose()),
        lambda: scene.attach("table", "right"),
    ):
        with pytest.raises(ValueError, match="table"):
            change()
    assert "table" in scene.names()


def test_unknown_objects_and_hands_list_what_exists(scene):
    with pytest.raises(UnknownNameError, match="mug"):
        scene.box("mugg")
    with pytest.raises(UnknownNameError, match="mug"):
        scene.attach("mugg", "right")
    with pytest.raises(UnknownNameError, match="right"):
        scene.attach("mug", "left")
    with pytest.raises(UnknownNameError, match="right"):
        scene.attached("left")


@pytest.mark.parametrize("size", [(0.1, 0.1), (0.1, 0.1, 0.0), (0.1, -0.1, 0.1), (0.1, np.nan, 0.1)])
def test_a_box_without_three_positive_edges_is_refused(scene, size):
    with pytest.raises(ValueError, match="3 positive lengths"):
        scene.set_box("bad", size, Pose())


def test_a_pose_in_another_frame_is_refused(scene):
    with pytest.raises(ValueError, match="camera"):
        scene.set_box("box", (0.1, 0.1, 0.1), Pose(frame="camera"))


def test_objects_around_a_point_come_nearest_first_and_without_the_room(scene):
    scene.set_box("plate", (0.2, 0.2, 0.02), Pose([0.5, 0, 0.4]))
    snapshot = scene.snapshot()
    assert snapshot.around(np.array([0.36, 0.0, 0.4]), 0.1) == ("mug", "plate")
    assert snapshot.around(np.array([0.36, 0.0, 0.4]), 0.01) == ("mug",)
    assert snapshot.around(np.array([0.0, 0.0, -0.01]), 0.01) == ()


def test_allowed_contacts_hold_both_ways_and_can_be_taken_back(scene):
    scene.allow("mug", "hand_palm_link")
    assert scene.snapshot().may_touch("hand_palm_link", "mug")
    scene.allow("hand_palm_link", "mug", False)
    assert not scene.snapshot().may_touch("mug", "hand_palm_link")
