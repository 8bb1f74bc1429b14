"""What is taught is there again, to the last digit; a file that is wrong says where."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.base.failures import NameTakenError
from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.taught import TaughtStates


def test_states_and_poses_come_back_to_the_last_digit(tmp_path):
    rng = np.random.default_rng(0)
    taught = TaughtStates(tmp_path / "taught.yaml")
    values = {f"s{k}": JointState(("a", "b"), rng.normal(size=2)) for k in range(5)}
    values |= {f"p{k}": Pose(rng.normal(size=3), rng.normal(size=4), "crate") for k in range(5)}
    for name, value in values.items():
        taught.put("right", name, value, {})
    again = TaughtStates(tmp_path / "taught.yaml").of("right")
    assert list(again) == list(values)
    for name, value in values.items():
        if isinstance(value, Pose):
            assert again[name].matrix() == pytest.approx(value.matrix(), abs=1e-15)
            assert again[name].frame == "crate"
        else:
            assert again[name] == value


def test_teaching_again_replaces_and_without_a_file_lasts_for_the_run():
    taught = TaughtStates()
    taught.put("right", "here", JointState(("a",), [1.0]), {})
    taught.put("right", "here", JointState(("a",), [2.0]), {})
    assert taught.of("right")["here"].position == [2.0]
    assert taught.states("right").keys() == {"here"}
    with pytest.raises(NameTakenError, match="home"):
        taught.put("right", "home", JointState(("a",), [2.0]), {"home": 1})
    with pytest.raises(ValueError, match="word"):
        taught.put("right", "over there", JointState(("a",), [2.0]), {})


def test_a_file_written_by_hand_is_read(tmp_path):
    (tmp_path / "t.yaml").write_text("right:\n  look:\n    pose: {position: [1, 2, 3]}\n  up:\n    state: {a: 1}\n")
    assert TaughtStates(tmp_path / "t.yaml").of("right")["look"] == Pose((1, 2, 3))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("right: 3\n", "t.yaml:1"),
        ("right:\n  look: {stat: {}}\n", "stat"),
        ("right:\n  look: {}\n", "either a `state:` or a `pose:`"),
        ("right:\n  look: {pose: {position: [1, 2, 3], quaternion: [0, 0, 0, 0]}}\n", "quaternion"),
        ("right: [\n", "t.yaml"),
    ],
)
def test_a_wrong_file_says_where(tmp_path, text, says):
    (tmp_path / "t.yaml").write_text(text)
    with pytest.raises(DocumentError, match=says):
        TaughtStates(tmp_path / "t.yaml")
