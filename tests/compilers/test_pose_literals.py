"""A variable of type Pose may begin with a literal."""

import pytest

from grip_bt.base.types import check_value
from grip_bt.base.values import Pose
from grip_bt.compilers.scopes import Cell, written
from grip_bt.task.catalog import parse_type
from grip_bt.task.model import Variable

LITERAL = {"position": [0.4, 0, 0.3], "quaternion": [0, 1, 0, 0]}


@pytest.mark.parametrize("value", [LITERAL, {"position": [1, 2, 3]}, {**LITERAL, "frame": "table"}])
def test_a_literal_is_a_pose_and_becomes_one(value):
    assert check_value("Pose", value) is None
    assert Cell("goal", Variable(type="Pose", value=value)).value == Pose(**value)


def test_lists_and_maps_of_poses_are_written_likewise():
    for type_, literal in (("list[Pose]", [LITERAL]), ("dict[str, Pose]", {"a": LITERAL})):
        assert check_value(type_, literal) is None
        (made,) = list(
            written(parse_type(type_), literal).values() if "dict" in type_ else written(parse_type(type_), literal)
        )
        assert made == Pose(**LITERAL)
    assert written(parse_type("dict[str, Any]"), {"a": LITERAL}) == {"a": LITERAL}


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ({"position": [1, 2]}, "'position' of it is [1, 2], not 3 numbers"),
        ({"position": [1, 2, float("nan")]}, "not 3 numbers"),
        ({"quaternion": [1, 0, 0, 0]}, "a pose without a `position`"),
        ({**LITERAL, "quaternion": [0, 0, 0, 0]}, "a length of zero"),
        ({**LITERAL, "orientation": [1, 0, 0, 0]}, "'orientation' of it isn't a key of a pose"),
        ({**LITERAL, "frame": 3}, "not the name of a frame"),
        ([0.4, 0, 0.3], "a list, not a Pose"),
    ],
)
def test_what_is_no_pose_says_why(value, says):
    assert says in check_value("Pose", value)
