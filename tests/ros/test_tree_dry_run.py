"""Somebody's tree over ROS on stand-ins: nobody offers what it asks for, and its types aren't all installed."""

from pathlib import Path

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session

CODE = """\
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from our_walks.action import Walk
from our_walks.msg import Speed
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rclpy.action import ActionClient
from std_msgs.msg import String
from std_srvs.srv import Trigger

SPEED = float(Path(get_package_share_directory("rounds"), "speed.txt").read_text())


class Go(Behaviour):
    def setup(self, node):
        self.walk, self.ask = ActionClient(node, Walk, "walk"), node.create_client(Trigger, "ask")
        self.speed, self.said = node.create_publisher(Speed, "speed", 1), node.create_publisher(String, "said", 1)
        node.create_subscription(Speed, "speed", self.heard, 1)
        assert self.walk.wait_for_server(1000.0) and self.ask.wait_for_service(1000.0)

    def heard(self, message):
        raise AssertionError("nobody says how fast")

    def update(self):
        self.speed.publish(Speed(value=SPEED))
        self.said.publish(String(data="goes"))
        accepted = self.walk.send_goal_async(Walk.Goal()).result().accepted
        return Status.SUCCESS if accepted else Status.FAILURE


def create_root():
    return Go("go")
"""


@pytest.mark.filterwarnings("ignore:module .sre_.*:DeprecationWarning")  # of a parser that rclpy imports
def test_a_tree_over_ros_runs_where_nobody_offers_anything(domain: int, tmp_path: Path) -> None:
    package = tmp_path / "rounds"  # not the test's folder itself: its neighbours would be one workspace with it
    package.mkdir()
    (package / "package.xml").write_text("<package><name>rounds</name></package>")
    (package / "speed.txt").write_text("0.5")
    (package / "dry_tree.py").write_text(CODE)
    told = []
    options = RunOptions(journal=tmp_path / "runs.sqlite", ticks=1, stand_ins=True)
    with open_session(f"{package}/dry_tree.py:create_root", options, lambda *words: told.append(words)) as session:
        assert session.runner.run().outcome == "success"
    missing = [words for part, words in told if part == "stand-in"]
    assert missing == ["package our_walks", "action walk", "service ask", "topic speed", "topic speed"]
